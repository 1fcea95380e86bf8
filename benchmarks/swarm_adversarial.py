"""Dense swarms in tight boxes with random velocities, which no controller would have come to: do bodies ever touch?"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.row import Options, Row
from rota.planners.swarm.asked import ALL_NEIGHBOURS, DECIDE
from rota.planners.swarm.kernels import Hearing, Rule
from rota.planners.swarm.rollout import Swarm
from rota.planners.swarm.world import kinds_of

Floats = NDArray[np.float64]

STATES, ROBOTS, STEPS = 10_000, 8, 20
GAPS_M = (0.0, 1e-9, 1e-3, 0.1)  # between a body and the one it was put beside
ROOMS_M = (0.0, 1e-6, 0.3, 2.0)  # between the bodies and the walls
TRIES = 60
SPEED_M_S, TIME_STEP_S = 2.0, 0.25
LATE_AND_LOSSY = Hearing(delay_steps=1, lost=0.1)
ROUNDING_M = 1e-9


class States(NamedTuple):
    """Small swarms: places (states, robots, 2), bodies (states, robots), boxes (states, 4) x0, y0, x1, y1, metres."""

    places_m: Floats
    bodies_m: Floats
    boxes_m: Floats


def swarm_adversarial(options: Options) -> Iterator[Row]:
    """Every controller with the last filter; all know all, and messages a step old of which a tenth is lost."""
    states = dense_states(STATES, ROBOTS, np.random.default_rng(0))
    for controller in DECIDE:
        for hearing, told in ((None, ""), (LATE_AND_LOSSY, ", a step late and 10 % lost")):
            bodies_m, walls_m, way_m = least_gaps(states, controller, STEPS, hearing)
            name = f"swarm, {STATES:,} dense states of {ROBOTS}, {controller}{told}: between bodies, and walls"
            measured = f"{bodies_m:.2g} and {walls_m:.2g} m after {STEPS} steps; {way_m:.2g} m gone on average"
            yield Row(name, f"never below -{ROUNDING_M:.0e} m", measured, min(bodies_m, walls_m) >= -ROUNDING_M)


def dense_states(states: int, robots: int, rng: np.random.Generator) -> States:
    """Bodies of different sizes, each touching or nearly touching an earlier one, in a box that fits tightly."""
    bodies = rng.uniform(0.2, 1.0, (states, robots))
    places = np.zeros((states, robots, 2))
    for k in range(1, robots):
        waiting = np.arange(states)
        for _ in range(TRIES):
            beside = rng.integers(0, k, len(waiting))
            angle = rng.uniform(0, 2 * np.pi, len(waiting))
            away = bodies[waiting, beside] + bodies[waiting, k] + rng.choice(GAPS_M, len(waiting))
            place = places[waiting, beside] + away[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
            gaps = np.hypot(*np.moveaxis(place[:, None] - places[waiting, :k], 2, 0)) - bodies[waiting, :k]
            fits = (gaps - bodies[waiting, k][:, None]).min(axis=1) >= 0
            places[waiting[fits], k] = place[fits]
            waiting = waiting[~fits]
        # who found no place stands to the right of all
        right = (places[waiting, :k, 0] + bodies[waiting, :k]).max(axis=1)
        places[waiting, k, 0] = right + bodies[waiting, k]
    slack = rng.choice(ROOMS_M, (states, 4))
    low = (places - bodies[..., None]).min(axis=1) - slack[:, :2]
    high = (places + bodies[..., None]).max(axis=1) + slack[:, 2:]
    return States(places, bodies, np.hstack([low, high]))


def swarm_of(states: States, controller: str, hearing: Hearing | None, seed: int, threads: int = 1) -> Swarm:
    """All states in one swarm, side by side and each between walls of its own, with random velocities."""
    count, robots = states.bodies_m.shape
    offsets = offsets_m(states)[:, None]
    kinds, kind = kinds_of(
        count * robots,
        body_m=states.bodies_m.ravel(),
        sensor_m=5.0,
        speed_m_s=SPEED_M_S,
        neighbour_range_m=10.0,
        wall_range_m=5.0,
    )
    corners = states.boxes_m[:, [[0, 1], [2, 1], [2, 3], [0, 3], [0, 1]]] + offsets
    walls = np.concatenate([corners[:, :-1], corners[:, 1:]], axis=2).reshape(-1, 4)
    neighbours = 4 if controller == "reciprocal" else ALL_NEIGHBOURS
    return Swarm(
        (states.places_m + offsets).reshape(-1, 2),
        kinds=kinds,
        kind=kind,
        walls=np.ascontiguousarray(walls),
        decide=DECIDE[controller],
        rule=Rule(neighbours, False, 1.0, 1.0, 0, seed, TIME_STEP_S),
        velocities_m_s=np.random.default_rng(seed).uniform(-SPEED_M_S, SPEED_M_S, (count * robots, 2)),
        hearing=hearing,
        threads=threads,
    )


def offsets_m(states: States) -> Floats:
    """Where each state's own origin lies, (states, 2): in rows, out of each other's sensor range."""
    spacing = 12.0 + float((states.boxes_m[:, 2:] - states.boxes_m[:, :2]).max())
    k = np.arange(len(states.bodies_m))
    row = int(np.ceil(np.sqrt(len(k))))
    return spacing * np.stack([k % row, k // row], axis=1)


def least_gaps(states: States, controller: str, steps: int, hearing: Hearing | None) -> tuple[float, float, float]:
    """Least distance between bodies, and between bodies and walls, after any step; and the mean way of a robot."""
    swarm = swarm_of(states, controller, hearing, seed=1)
    before, bodies = swarm.places_m, states.bodies_m
    between, beside, way = np.inf, np.inf, 0.0
    pairs = np.array(list(itertools.combinations(range(bodies.shape[1]), 2))).T
    for _ in range(steps):
        swarm.step()
        at = swarm.places_m.reshape(*bodies.shape, 2) - offsets_m(states)[:, None]
        gap = (
            np.hypot(*np.moveaxis(at[:, pairs[0]] - at[:, pairs[1]], 2, 0)) - bodies[:, pairs[0]] - bodies[:, pairs[1]]
        )
        between = min(between, float(gap.min()))
        low, high = at - states.boxes_m[:, None, :2], states.boxes_m[:, None, 2:] - at
        beside = min(beside, float((np.minimum(low, high).min(axis=2) - bodies).min()))
        way += float(np.hypot(*(swarm.places_m - before).T).mean())
        before = swarm.places_m
    return between, beside, way
