"""Dense states in motion: whether a single step of a controller makes bodies touch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rota.geometry.free_space import free_ground
from rota.planners.swarm.planner import make_swarm
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.sorted_robots import Beginning
from rota_studies.chen2018 import maps, paper
from rota_studies.chen2018.runs import Controller, Runs, what

Floats = NDArray[np.float64]

TRIED = 1000
ROBOTS = 25
APART_M = (1.0, 1.5)  # from middle to middle on the lattice that is shaken; bodies touch at 1 m


def counted_contacts(runs: Runs, controller: Controller) -> tuple[int, float]:
    """What ``dense_contacts`` counts for a controller, from its record."""

    def make() -> tuple[int, float]:
        runs.now(f"dense states: {controller.name}")
        return dense_contacts(controller.settings, seed=runs.seed)

    run = {"what": "dense states", **what(maps.small("centre"), controller), "tried": TRIED, "seed": runs.seed}
    return runs.records.get(tuple[int, float], run, make)


def dense_contacts(settings: SwarmSettings, *, seed: int, tried: int = TRIED) -> tuple[int, float]:
    """In how many of ``tried`` states bodies touch within one step, and the least distance between middles in metres.

    A state has 25 robots of Table 2 on a lattice, shaken by as much as keeps them apart, with random velocities.
    """
    mission = replace(maps.small("centre"), planning=settings)
    ground = free_ground(mission)
    rng = np.random.default_rng(seed)
    contacts, least_m = 0, np.inf
    for _ in range(tried):
        places, velocities = dense_state(rng)
        swarm = make_swarm(mission, ground, Beginning(places, velocities), seed=seed)
        swarm.step()
        distance_m = closest_approach_m(places, swarm.places_m)
        contacts += distance_m < 2 * paper.BODY_M - 1e-9
        least_m = min(least_m, distance_m)
    return contacts, float(least_m)


def dense_state(rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Places and velocities (25, 2) of robots; no two are nearer than 1 m."""
    apart_m = rng.uniform(*APART_M)
    lattice = np.stack(np.meshgrid(np.arange(5.0), np.arange(5.0)), -1).reshape(-1, 2) * apart_m + 120
    angle, length = rng.uniform(0, 2 * np.pi, ROBOTS), rng.uniform(0, (apart_m - 1) / 2, ROBOTS)
    places = lattice + length[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    angle, speed = rng.uniform(0, 2 * np.pi, ROBOTS), paper.SPEED_M_S * np.sqrt(rng.uniform(0, 1, ROBOTS))
    return places, speed[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


def closest_approach_m(before_m: Floats, after_m: Floats) -> float:
    """The least distance of any two of n robots that go straight from (n, 2) to (n, 2) metres in the same time."""
    i, j = np.triu_indices(len(before_m), 1)
    gap, change = before_m[i] - before_m[j], (after_m - before_m)[i] - (after_m - before_m)[j]
    part = np.clip(-(gap * change).sum(1) / np.maximum((change**2).sum(1), 1e-300), 0, 1)
    return float(np.hypot(*(gap + part[:, None] * change).T).min())
