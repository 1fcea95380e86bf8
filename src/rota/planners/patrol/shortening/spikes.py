"""Spikes of tours: detours out and back that see next to nothing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely

from rota.geometry.kernels import free_segments
from rota.planners.patrol.annealing.search import Annealing
from rota.planners.patrol.ground.extra_points import UNSEEN_WEIGHT, no_points, prepare_with
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.samples import SamplePoints, known_walls, lay_out
from rota.planners.patrol.tours.tour import Tour, hubs_and_petals


class Spike(NamedTuple):
    """A detour of a tour (k): its ``corners`` from vertex ``first`` on, and the metres that are saved without them."""

    tour: int
    first: int
    corners: int
    saved_m: float


def spikes(problem: Problem, tours: Sequence[Tour]) -> list[Spike]:
    """The spikes of the tours, none with a corner of another; what one alone sees is measured on the samples near it.

    A spike has one to three corners. The way past them is at least twice as long as straight on, by a quarter of the
    reach or more, and they see less than a tenth of what a lane would see that is as long as the detour.
    """
    points, samples = prepare_with(problem, no_points())
    found: list[Spike] = []
    for spike in sorted(detours(problem, tours), key=lambda detour: -detour.saved_m):
        if any(_meet(spike, other, len(tours[spike.tour].vertices_m)) for other in found):
            continue
        near = samples_near(problem, tours[spike.tour], spike, points, samples)
        if near is None:
            lost_m2 = 0.0
        else:
            lost_m2 = unseen_m2(problem, without(tours, [spike]), near) - unseen_m2(problem, tours, near)
        if (
            lost_m2 < 0.1 * spike.saved_m * problem.swath_m
        ):  # next to nothing: a lane as long would see ten times as much
            found.append(spike)
    return found


def samples_near(problem: Problem, tour: Tour, spike: Spike, points: SamplePoints, samples: Samples) -> Samples | None:
    """The samples that the spike, or the way past it, may see; None: none. What else is seen stays as it is."""
    way_m = np.take(tour.vertices_m, np.arange(spike.first - 1, spike.first + spike.corners + 1), axis=0, mode="wrap")
    far_m = max(problem.robot.sensor.reach_m, float(samples.visit_m.max(initial=0.0)))
    inside = ((points.xy_m >= way_m.min(axis=0) - far_m) & (points.xy_m <= way_m.max(axis=0) + far_m)).all(axis=1)
    near = np.flatnonzero(inside)
    near = near[shapely.distance(shapely.linearrings(way_m), shapely.points(points.xy_m[near])) <= far_m]
    if not len(near):
        return None
    known, weight = known_walls(samples, near), samples.weight[near]
    return lay_out(points[near], problem.walls, problem.robot, weight=weight, known=known)[1]


def detours(problem: Problem, tours: Sequence[Tour]) -> Iterator[Spike]:
    """All stretches of a few corners that go out and back, whatever they see."""
    hub, petals = hubs_and_petals(tours)
    for k, tour in enumerate(tours):
        n = len(tour.vertices_m)
        if hub[k] != k or petals[k, 0] != petals[k, 1]:
            continue  # tours that meet others keep their corners
        for corners in range(1, min(3, n - 3) + 1):  # a spike has three corners at most
            before = np.roll(tour.vertices_m, 1, axis=0)
            after = np.roll(tour.vertices_m, -corners, axis=0)
            legs_m = np.hypot(*(tour.vertices_m - before).T)
            way_m = sum((np.roll(legs_m, -i) for i in range(1, corners + 1)), legs_m)
            saved_m = way_m - np.hypot(*(after - before).T)
            out = (saved_m >= 0.25 * problem.reach_m) & (saved_m >= 0.5 * way_m)  # half of its way is out and back
            out[out] = free_segments(before[out], after[out], problem.paths.grid)
            yield from (Spike(k, int(i), corners, float(saved_m[i])) for i in np.flatnonzero(out))


def without(tours: Sequence[Tour], some: Sequence[Spike]) -> list[Tour]:
    """The tours straight on past some of their spikes."""
    shorter = []
    for k, tour in enumerate(tours):
        n = len(tour.vertices_m)
        gone = sorted({(spike.first + i) % n for spike in some if spike.tour == k for i in range(spike.corners)})
        shorter.append(replace(tour, vertices_m=np.delete(tour.vertices_m, gone, axis=0)) if gone else tour)
    return shorter


def unseen_m2(problem: Problem, tours: Sequence[Tour], samples: Samples) -> float:
    """Ground of the samples that no tour sees."""
    none = np.zeros(len(tours))
    search = Annealing(
        tours, samples, problem.paths.grid, length_weight=none, budget_penalty=none, seed=0,
        range_margin_m=problem.range_margin_m,
    )  # fmt: skip
    return search.unseen_m * problem.swath_m / UNSEEN_WEIGHT


def _meet(one: Spike, other: Spike, n: int) -> bool:
    """Whether two stretches of a tour of n vertices share a corner, or an end with a corner."""
    if one.tour != other.tour:
        return False
    apart = (one.first - other.first) % n
    return apart <= other.corners or n - apart <= one.corners
