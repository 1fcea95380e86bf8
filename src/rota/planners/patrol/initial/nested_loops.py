"""Loops within loops: robots of an urgent zone that make excursions into slower ground between their rounds."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.initial.first_tours import PlaceGroup, straight_neighbourhoods, tour_past
from rota.planners.patrol.settings import ExcursionEstimate
from rota.planners.patrol.tours.tour import Tour


def can_nest(problem: Problem) -> bool:
    """Whether nests are tried: their timetable knows neither turning time at the hub nor bodies."""
    robot = problem.robot
    return robot.body_radius_m == 0 and robot.turns_at_once and not problem.at_limit


def petals_of(tour: Tour, slow_s: float) -> int:
    """The excursions that fit into the slow period, one after each round of the hub; 0 when there is but one."""
    petals = min(12, math.floor(slow_s / tour.period_s + 1e-9))
    return petals if petals > 1 else 0


def separate_petals(tour: Tour, ideal_m: float, slow_s: float, hub_detour: float) -> tuple[int, float]:
    """As many excursions from different vertices of the hub as spend most metres in the slow period, and these metres.

    They take one more round of the hub. 0: fewer than two have room.
    """
    if tour.robots > 1:
        return 0, 0.0
    hub_m, per_s = hub_detour * ideal_m, tour.budget_m / tour.period_s
    best = 0, 0.0
    for petals in range(2, petals_of(tour, slow_s) + 1):
        metres = min(petals * (tour.budget_m - hub_m), slow_s * per_s - (petals + 1) * hub_m)
        if metres > best[1]:
            best = petals, metres
    return best


def spare_m(tour: Tour, ideal_m: float, slow_s: float, estimate: ExcursionEstimate) -> float:
    """Metres per slow period that the robots of a tour can spend on slow ground, by excursions or by a longer tour."""
    left_m = max(0.0, tour.budget_m - estimate.hub_detour * ideal_m)
    return estimate.travel_share * max(1, petals_of(tour, slow_s)) * left_m


class Excursions(NamedTuple):
    """The excursions of one hub.

    petals: their number. spare_m: metres per slow period that they spend on slow ground.
    separate: whether they begin at different vertices of the hub.
    """

    petals: int
    spare_m: float
    separate: bool


def excursions(tour: Tour, ideal_m: float, slow_s: float, estimate: ExcursionEstimate, *, separate: bool) -> Excursions:
    """What a tour can do between rounds; ``separate``: from different vertices, where that spends not much less."""
    together = Excursions(petals_of(tour, slow_s), spare_m(tour, ideal_m, slow_s, estimate), False)
    if not separate:
        return together
    petals, metres = separate_petals(tour, ideal_m, slow_s, estimate.hub_detour)
    apart = Excursions(petals, 1.1875 * estimate.travel_share * metres, True)  # less of their metres are ways there
    return apart if petals and apart.spare_m > 0.7 * together.spare_m else together


def nest_tours(
    problem: Problem,
    groups: list[PlaceGroup],
    tours: list[Tour],
    ideal_m: list[float],
    *,
    least_slack: float,
    separate: bool,
    estimate: ExcursionEstimate,
) -> tuple[float, list[Tour]] | None:
    """The tours with some of the slowest tour's ground handed to excursions of the others; None when it is no use.

    tours, ideal_m: for each group a tour with its robots, and the metres of ideal lanes over its ground.
    separate: with excursions from different vertices of their hub where these spend not much less; None if nowhere.
    Returns the tours after the slack factor of the slow ground's tour and its excursions together.
    """
    load = [ideal / replace(tour, robots=1).budget_m for tour, ideal in zip(tours, ideal_m, strict=True)]
    slow = slowest(tours, load)
    if load[slow] == 0 or groups[slow].stands is not None:
        return None
    component, slow_s = tours[slow].component, tours[slow].period_s
    most = [excursions(tour, m, slow_s, estimate, separate=separate) for tour, m in zip(tours, ideal_m, strict=True)]
    may = [tour.component == component and tour.period_class < tours[slow].period_class for tour in tours]
    spare = [each.spare_m if allowed else 0.0 for each, allowed in zip(most, may, strict=True)]
    slack = (tours[slow].budget_m + sum(spare)) / ideal_m[slow]
    spare = [s if s > 2 * problem.swath_m and each.petals else 0.0 for s, each in zip(spare, most, strict=True)]
    if not any(spare) or slack < least_slack:
        return None
    if separate and not any(each.separate for s, each in zip(spare, most, strict=True) if s):
        return None
    left = groups[slow].places
    share = len(left) / ideal_m[slow]
    handed: list[Tour] = []
    for k in sorted(set(range(len(tours))) - {slow}, key=lambda k: (-spare[k], k)):
        # its own part of the slow ground: the nearest places, as many as it can sweep
        count = min(len(left) - 1, int(share * spare[k]))
        if count == 0:
            handed.append(tours[k])
            continue
        apart = most[k].separate or not separate
        from_m = tours[k].vertices_m if apart else best_vertex(problem, tours[k], left, count)
        taken, left = np.split(nearest_first(problem, from_m, left), [count])
        handed += nest_of(problem, tours[k], tours[slow], taken, len(handed), most[k])
    if all(tour.nest < 0 for tour in handed):
        return None
    rest = tour_past(problem, problem.viewpoints.xy_m[left], tours[slow].period_class, component)
    return slack, [*handed, replace(rest, robots=tours[slow].robots)]


def slowest(tours: list[Tour], load: list[float]) -> int:
    """The tour of the longest period that has ground to sweep, of those the one with the greatest load."""
    return max(range(len(tours)), key=lambda k: (load[k] > 0, tours[k].period_s, load[k]))


def nearest_first(problem: Problem, from_m: Floats, places: Ints) -> Ints:
    """The places, by their straight distance from the nearest of some (n, 2)."""
    apart = problem.viewpoints.xy_m[places][:, None] - from_m[None]
    return places[np.argsort(np.hypot(*apart.transpose(2, 0, 1)).min(axis=1), kind="stable")]


def nest_of(problem: Problem, hub: Tour, slow: Tour, places: Ints, number: int, each: Excursions) -> list[Tour]:
    """The hub and a petal for each of its rounds, all from the hub's vertex that is nearest to the places.

    Separate ones each begin at the vertex that is nearest to their own places.
    """
    stops_m = problem.viewpoints.xy_m[places]
    start = nearest_vertex(hub, stops_m)
    anchor_m = hub.vertices_m[start : start + 1]
    petals = []
    for label in straight_neighbourhoods(stops_m, each.petals):
        if each.separate:
            own = nearest_vertex(hub, stops_m[label])
            anchor_m = hub.vertices_m[own : own + 1]
        tour = tour_past(problem, np.vstack([anchor_m, stops_m[label]]), slow.period_class, slow.component)
        first = int(np.argmin(np.hypot(*(tour.vertices_m - anchor_m).T)))
        vertices_m = np.vstack([anchor_m, np.roll(tour.vertices_m, -first, axis=0)[1:]])
        petals.append(replace(tour, vertices_m=vertices_m, robots=0, nest=number))
    petals += [replace(petals[0], vertices_m=anchor_m)] * (each.petals - len(petals))
    return [replace(hub, vertices_m=np.roll(hub.vertices_m, -start, axis=0), nest=number), *petals]


def nearest_vertex(tour: Tour, places_m: Floats) -> int:
    """The vertex of the tour that is nearest to the middle of the places (n, 2)."""
    return int(np.argmin(np.hypot(*(tour.vertices_m - places_m.mean(axis=0)).T)))


def best_vertex(problem: Problem, hub: Tour, places: Ints, count: int) -> Floats:
    """The vertex (1, 2) of the hub from which the nearest ``count`` of the places are nearest, taken together."""
    apart_m = np.hypot(*(problem.viewpoints.xy_m[places][:, None] - hub.vertices_m[None]).transpose(2, 0, 1))
    best = int(np.argmin(np.sort(apart_m, axis=0)[:count].sum(axis=0)))
    return hub.vertices_m[best : best + 1]
