"""Loops within loops: robots of an urgent zone that make excursions into slower ground between their rounds."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.initial.first_tours import Ground, straight_neighbourhoods, tour_past
from rota.planners.patrol.tours.tour import Tour

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

WINDING = 1.15  # real tours over ideal ones
SCATTERED = 1.1875  # times the share of their metres on their ground that excursions have from vertices of their own
SCATTERED_WORTH = 0.7  # of what excursions from one vertex spend, that scattered ones must; they are shorter ways
MOST_PETALS = 12


class Handing(NamedTuple):
    """How much slow ground is handed to excursions at first: by what they are taken to be able to spend on it.

    winding: real hubs over ideal ones. travel: share of what a hub leaves free that an excursion spends on its ground
    rather than on the way there, when it begins where the others do.
    """

    winding: float
    travel: float


USUAL = Handing(WINDING, 0.8)
# annealing hardly moves ground from one robot to another: which of these comes out best is luck, and is tried
HANDINGS = (
    USUAL,
    Handing(1.15, 0.67),
    Handing(1.05, 0.55),
    Handing(1.05, 0.67),
    Handing(1.25, 0.8),
    Handing(1.05, 0.8),
    Handing(0.95, 0.55),
)


def can_nest(problem: Problem) -> bool:
    """Whether nests are tried: their timetable knows neither turning time at the hub nor bodies."""
    robot = problem.robot
    return robot.body_radius_m == 0 and robot.turn_rate_rad_s is None and not len(problem.border_places_m)


def petals_of(tour: Tour, slow_s: float) -> int:
    """The excursions that fit into the slow period, one after each round of the hub; 0 when there is but one."""
    petals = min(MOST_PETALS, math.floor(slow_s / tour.period_s + 1e-9))
    return petals if petals > 1 else 0


def scattered_petals(tour: Tour, ideal_m: float, slow_s: float, winding: float = WINDING) -> tuple[int, float]:
    """As many excursions from different vertices of the hub as spend most metres in the slow period, and these metres.

    They take one more round of the hub. 0: fewer than two have room.
    """
    if tour.robots > 1:
        return 0, 0.0
    hub_m, per_s = winding * ideal_m, tour.budget_m / tour.period_s
    best = 0, 0.0
    for petals in range(2, petals_of(tour, slow_s) + 1):
        metres = min(petals * (tour.budget_m - hub_m), slow_s * per_s - (petals + 1) * hub_m)
        if metres > best[1]:
            best = petals, metres
    return best


def spare_m(tour: Tour, ideal_m: float, slow_s: float, handing: Handing = USUAL) -> float:
    """Metres per slow period that the robots of a tour can spend on slow ground, by excursions or by a longer tour."""
    return handing.travel * max(1, petals_of(tour, slow_s)) * max(0.0, tour.budget_m - handing.winding * ideal_m)


class Excursions(NamedTuple):
    """How many a hub has, the metres per slow period that they spend on slow ground, whether each begins elsewhere."""

    petals: int
    spare_m: float
    scattered: bool


def excursions(tour: Tour, ideal_m: float, slow_s: float, *, scattered: bool, handing: Handing = USUAL) -> Excursions:
    """What a tour can do between rounds; ``scattered``: from different vertices, where that spends not much less."""
    together = Excursions(petals_of(tour, slow_s), spare_m(tour, ideal_m, slow_s, handing), False)
    if not scattered:
        return together
    petals, metres = scattered_petals(tour, ideal_m, slow_s, handing.winding)
    apart = Excursions(petals, SCATTERED * handing.travel * metres, True)
    return apart if petals and apart.spare_m > SCATTERED_WORTH * together.spare_m else together


def nested(
    problem: Problem,
    grounds: list[Ground],
    tours: list[Tour],
    ideal_m: list[float],
    least_squeeze: float,
    *,
    scattered: bool = False,
    handing: Handing = USUAL,
) -> tuple[float, list[Tour]] | None:
    """The tours with part of the slowest tour's ground handed to excursions of the others; None when it is no use.

    tours, ideal_m: one per ground, with their robots, and the metres of ideal lanes over it. Beside them how many times
    longer than ideal the slow ground's tour and its excursions may be together. scattered: with excursions from
    different vertices of their hub where that spends not much less; None if it does nowhere.
    """
    load = [ideal / replace(tour, robots=1).budget_m for tour, ideal in zip(tours, ideal_m, strict=True)]
    slow = slowest(tours, load)
    if load[slow] == 0 or grounds[slow].stands is not None:
        return None
    component, slow_s = tours[slow].component, tours[slow].period_s
    most = [
        excursions(tour, m, slow_s, scattered=scattered, handing=handing)
        for tour, m in zip(tours, ideal_m, strict=True)
    ]
    may = [tour.component == component and tour.period_class < tours[slow].period_class for tour in tours]
    spare = [each.spare_m if allowed else 0.0 for each, allowed in zip(most, may, strict=True)]
    room = (tours[slow].budget_m + sum(spare)) / ideal_m[slow]
    spare = [s if s > 2 * problem.swath_m and each.petals else 0.0 for s, each in zip(spare, most, strict=True)]
    if not any(spare) or room < least_squeeze:
        return None
    if scattered and not any(each.scattered for s, each in zip(spare, most, strict=True) if s):
        return None
    left = grounds[slow].places
    share = len(left) / ideal_m[slow]
    found: list[Tour] = []
    for k in sorted(set(range(len(tours))) - {slow}, key=lambda k: (-spare[k], k)):
        # its own part of the slow ground: the nearest places, as many as it can sweep
        count = min(len(left) - 1, int(share * spare[k]))
        if count == 0:
            found.append(tours[k])
            continue
        apart = most[k].scattered or not scattered
        from_m = tours[k].vertices_m if apart else best_vertex(problem, tours[k], left, count)
        taken, left = np.split(nearest_first(problem, from_m, left), [count])
        found += nest_of(problem, tours[k], tours[slow], taken, len(found), most[k])
    if all(tour.nest < 0 for tour in found):
        return None
    rest = tour_past(problem, problem.viewpoints.xy_m[left], tours[slow].period_class, component)
    return room, [*found, replace(rest, robots=tours[slow].robots)]


def slowest(tours: list[Tour], load: list[float]) -> int:
    """The tour of the longest period that has ground to sweep, of those the one with the greatest load."""
    return max(range(len(tours)), key=lambda k: (load[k] > 0, tours[k].period_s, load[k]))


def nearest_first(problem: Problem, from_m: Floats, places: Ints) -> Ints:
    """The places, by their straight distance from the nearest of some (n, 2)."""
    apart = problem.viewpoints.xy_m[places][:, None] - from_m[None]
    return places[np.argsort(np.hypot(*apart.transpose(2, 0, 1)).min(axis=1), kind="stable")]


def nest_of(problem: Problem, hub: Tour, slow: Tour, places: Ints, number: int, each: Excursions) -> list[Tour]:
    """The hub and a petal for each of its rounds, all from the hub's vertex that is nearest to the places.

    Scattered ones each begin at the vertex that is nearest to their own places.
    """
    here_m = problem.viewpoints.xy_m[places]
    start = nearest_vertex(hub, here_m)
    anchor_m = hub.vertices_m[start : start + 1]
    petals = []
    for label in straight_neighbourhoods(here_m, each.petals):
        if each.scattered:
            own = nearest_vertex(hub, here_m[label])
            anchor_m = hub.vertices_m[own : own + 1]
        tour = tour_past(problem, np.vstack([anchor_m, here_m[label]]), slow.period_class, slow.component)
        first = int(np.argmin(np.hypot(*(tour.vertices_m - anchor_m).T)))
        vertices_m = np.vstack([anchor_m, np.roll(tour.vertices_m, -first, axis=0)[1:]])
        petals.append(replace(tour, vertices_m=vertices_m, robots=0, nest=number))
    petals += [replace(petals[0], vertices_m=anchor_m)] * (each.petals - len(petals))
    return [replace(hub, vertices_m=np.roll(hub.vertices_m, -start, axis=0), nest=number), *petals]


def nearest_vertex(tour: Tour, places_m: Floats) -> int:
    """The vertex of the tour that is nearest to the middle of the places (n, 2)."""
    return int(np.argmin(np.hypot(*(tour.vertices_m - places_m.mean(axis=0)).T)))


def best_vertex(problem: Problem, hub: Tour, places: Ints, count: int) -> Floats:
    """The vertex (1, 2) of the hub that has so many of the places nearest to it, taken together."""
    apart_m = np.hypot(*(problem.viewpoints.xy_m[places][:, None] - hub.vertices_m[None]).transpose(2, 0, 1))
    best = int(np.argmin(np.sort(apart_m, axis=0)[:count].sum(axis=0)))
    return hub.vertices_m[best : best + 1]
