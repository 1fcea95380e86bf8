"""Loops within loops: robots of an urgent zone that make excursions into slower ground between their rounds."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rota.planners.patrol.annealing.tour import Tour
from rota.planners.patrol.problem import Problem
from rota.planners.patrol.start.first_tours import Ground, straight_neighbourhoods, tour_past

Ints = NDArray[np.int64]

WINDING = 1.15  # real tours over ideal ones
TRAVEL = 0.8  # share of what a hub leaves free that an excursion spends on its ground rather than on the way there
MOST_PETALS = 12


def can_nest(problem: Problem) -> bool:
    """Whether nests are tried: their timetable knows neither turning time at the hub nor bodies."""
    robot = problem.robot
    return robot.body_radius_m == 0 and robot.turn_rate_rad_s is None and not len(problem.rim_places_m)


def petals_of(tour: Tour, slow_s: float) -> int:
    """The excursions that fit into the slow period, one after each round of the hub; 0 when there is but one."""
    petals = min(MOST_PETALS, math.floor(slow_s / tour.period_s + 1e-9))
    return petals if petals > 1 else 0


def spare_m(tour: Tour, ideal_m: float, slow_s: float) -> float:
    """Metres per slow period that the robots of a tour can spend on slow ground, by excursions or by a longer tour."""
    return TRAVEL * max(1, petals_of(tour, slow_s)) * max(0.0, tour.budget_m - WINDING * ideal_m)


def nested(
    problem: Problem, grounds: list[Ground], tours: list[Tour], ideal_m: list[float], least_squeeze: float
) -> tuple[float, list[Tour]] | None:
    """The tours with part of the slowest tour's ground handed to excursions of the others; None when it is no use.

    tours, ideal_m: one per ground, with their robots, and the metres of ideal lanes over it. Beside them how many times
    longer than ideal the slow ground's tour and its excursions may be together.
    """
    load = [ideal / replace(tour, robots=1).budget_m for tour, ideal in zip(tours, ideal_m, strict=True)]
    slow = slowest(tours, load)
    if load[slow] == 0 or grounds[slow].stands is not None:
        return None
    part, slow_s = tours[slow].part, tours[slow].period_s
    spare = [
        spare_m(tour, ideal, slow_s) if tour.part == part and tour.serves < tours[slow].serves else 0.0
        for tour, ideal in zip(tours, ideal_m, strict=True)
    ]
    room = (tours[slow].budget_m + sum(spare)) / ideal_m[slow]
    spare = [
        s if s > 2 * problem.swath_m and petals_of(tour, slow_s) else 0.0 for s, tour in zip(spare, tours, strict=True)
    ]
    if not any(spare) or room < least_squeeze:
        return None
    left = grounds[slow].places
    share = len(left) / ideal_m[slow]
    found: list[Tour] = []
    for k in sorted(range(len(tours)), key=lambda k: -spare[k]):
        if not spare[k]:
            found += [tours[k]] if k != slow else []
            continue
        # its own part of the slow ground: the nearest places, as many as it can sweep
        near = nearest_first(problem, tours[k], left)
        count = min(len(near) - 1, int(share * spare[k]))
        if count == 0:
            found.append(tours[k])
            continue
        taken, left = np.split(near, [count])
        found += nest_of(problem, tours[k], tours[slow], taken, len(found))
    if all(tour.nest < 0 for tour in found):
        return None
    rest = tour_past(problem, problem.places_m[left], tours[slow].serves, part)
    return room, [*found, replace(rest, robots=tours[slow].robots)]


def slowest(tours: list[Tour], load: list[float]) -> int:
    """The tour of the longest period that has ground to sweep, of those the one with the greatest load."""
    return max(range(len(tours)), key=lambda k: (load[k] > 0, tours[k].period_s, load[k]))


def nearest_first(problem: Problem, tour: Tour, places: Ints) -> Ints:
    """The places, by their straight distance from the nearest vertex of the tour."""
    apart = problem.places_m[places][:, None] - tour.vertices_m[None]
    return places[np.argsort(np.hypot(*apart.transpose(2, 0, 1)).min(axis=1), kind="stable")]


def nest_of(problem: Problem, hub: Tour, slow: Tour, places: Ints, number: int) -> list[Tour]:
    """The hub and a petal for each of its rounds, all from the hub's vertex that is nearest to the places."""
    rounds = petals_of(hub, slow.period_s)
    here_m = problem.places_m[places]
    start = int(np.argmin(np.hypot(*(hub.vertices_m - here_m.mean(axis=0)).T)))
    anchor_m = hub.vertices_m[start : start + 1]
    petals = []
    for label in straight_neighbourhoods(here_m, rounds):
        tour = tour_past(problem, np.vstack([anchor_m, here_m[label]]), slow.serves, slow.part)
        first = int(np.argmin(np.hypot(*(tour.vertices_m - anchor_m).T)))
        vertices_m = np.vstack([anchor_m, np.roll(tour.vertices_m, -first, axis=0)[1:]])
        petals.append(replace(tour, vertices_m=vertices_m, robots=0, nest=number))
    petals += [replace(petals[0], vertices_m=anchor_m)] * (rounds - len(petals))
    return [replace(hub, vertices_m=np.roll(hub.vertices_m, -start, axis=0), nest=number), *petals]
