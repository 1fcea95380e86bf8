"""Swarms in a box, and the room that the compiled loops write to."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from rota.planners.swarm.deciding import Controller
from rota.planners.swarm.reciprocal_kernels import decide_reciprocal
from rota.planners.swarm.rollout import Surroundings, Swarm
from rota.planners.swarm.sorted_robots import Beginning
from rota.planners.swarm.state import Rule
from rota.planners.swarm.world import kinds_of

PAPER = Rule(
    neighbours=4, circle=False, horizon_s=1.0, alpha=1.0, samples=0, seed=0, time_step_s=0.25
)  # Table 2, and the readings


def box_walls(width_m: float, height_m: float) -> np.ndarray:
    corners = np.array([[0, 0], [width_m, 0], [width_m, height_m], [0, height_m], [0, 0]], float)
    return np.hstack([corners[:-1], corners[1:]])


def in_box(places_m: Any, size_m: tuple[float, float] = (250, 250), rule: Rule = PAPER, **changed: Any) -> Swarm:
    """Robots as in Table 2 of Chen et al. 2018 unless changed, in a box with a corner at the origin."""
    places = np.array(places_m, float).reshape(-1, 2)
    like = {"body_m": 0.5, "sensor_m": 25, "speed_m_s": 2, "neighbour_range_m": 51, "wall_range_m": 25}
    like |= {key: changed.pop(key) for key in tuple(changed) if key in like}
    changed = {"decide": decide_reciprocal, "walls": box_walls(*size_m), "rule": rule, **changed}
    beginning = Beginning(places, **taken(changed, Beginning))
    surroundings = Surroundings(**taken(changed, Surroundings))
    controller = Controller(**taken(changed, Controller))
    return Swarm(beginning, kinds_of(len(places), **like), surroundings, controller, **changed)


def taken(values: dict[str, Any], kind: Any) -> dict[str, Any]:
    """Those of the values that fields of a dataclass are named after, taken out of them."""
    return {field.name: values.pop(field.name) for field in fields(kind) if field.name in values}


def scattered(count: int, low: float, high: float, apart_m: float, seed: int) -> np.ndarray:
    """Random places in a square, none nearer to another than so far."""
    rng = np.random.default_rng(seed)
    places: list[np.ndarray] = []
    while len(places) < count:
        place = rng.uniform(low, high, 2)
        if all(np.hypot(*(place - other)) > apart_m for other in places):
            places.append(place)
    return np.array(places)
