"""The methods: one ground to the tours that sweep it, by as few robots as its period and the lanes' lengths allow.

Sun et al. 2019, Figure 3, draws them for one open area with one period; here each takes the ground of one group of
period classes in one component of the standing space, so that zones can have routes of their own (``search`` chooses
the groups). A share ``reserve`` of every robot's budget is kept for the repair. A method that needs more robots than
``most`` gives None.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import shapely
from shapely import MultiPolygon

from rota.model.arrays import Floats
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.methods.sweeping.lanes import ground_turned, slab, turn_shape, turning
from rota.planners.patrol.methods.sweeping.routes import (
    SweepGround,
    angles,
    best_route,
    promising_angles,
    robots_for,
    sensing,
    shortest_guess_m,
)
from rota.planners.patrol.tours.tour import Tour, tour_length_m

Sweeping = Callable[[Problem, SweepGround, float, int | None], list[Tour] | None]  # see the methods of this module

BALANCING = 6  # rounds in which strips, sub-areas and districts are made more alike


def sequential(problem: Problem, ground: SweepGround, reserve: float, most: int | None) -> list[Tour] | None:
    """One route over everything, with robots evenly spaced on it (Figure 3b), as many as its length needs."""
    return share_out(best_route(problem, ground, ground.shape, promising_angles(problem, ground.shape)), reserve, most)


def sequential_once(most_angles: int) -> Sweeping:
    """The method ``sequential`` for one problem, with so many directions of lanes; no ground gets lanes twice."""
    routes: dict[tuple[bytes, bytes, int, int], Tour | None] = {}

    def sweeping(problem: Problem, ground: SweepGround, reserve: float, most: int | None) -> list[Tour] | None:
        key = (ground.shape.wkb, ground.stops_m.tobytes(), ground.period_class, ground.component)
        if key not in routes:
            tried = promising_angles(problem, ground.shape, most_angles)
            routes[key] = best_route(problem, ground, ground.shape, tried)
        return share_out(routes[key], reserve, most)

    return sweeping


def share_out(tour: Tour | None, reserve: float, most: int | None) -> list[Tour] | None:
    """The route with as many robots as its length needs; none where there is no route."""
    return [] if tour is None else not_more([replace(tour, robots=robots_for(tour, reserve))], most)


def not_more(tours: list[Tour], most: int | None) -> list[Tour] | None:
    """The tours, or None when they have more robots than that."""
    return tours if most is None or burden(tours)[0] <= most else None


def parallel(problem: Problem, ground: SweepGround, reserve: float, most: int | None) -> list[Tour] | None:
    """Strips side by side, each swept by a robot of its own, all lanes in one direction (Figure 3a).

    The strips are as few as fit the robots' budgets, and then made as even as can be. A lane too long for one robot is
    cut into pieces of a robot each.
    """
    if ground.shape.is_empty:
        return sequential(problem, ground, reserve, most)
    best: list[Tour] | None = None
    for angle in promising_angles(problem, ground.shape):
        tours = strips_at(problem, ground, angle, reserve, most)
        if tours is not None and (best is None or rank(tours) < rank(best)):
            best = tours
            most = max(burden(best)[0], 1)
    return best


def rank(tours: list[Tour]) -> tuple[bool, int, float]:
    """What makes one division of the ground better than another, the smaller the better."""
    return meets_itself(tours), *burden(tours)


def meets_itself(tours: list[Tour]) -> bool:
    """Whether robots with bodies share a lane to and fro, and so come face to face."""
    return any(tour.robots > 1 and tour.robot.body_radius_m > 0 for tour in tours)


def burden(tours: list[Tour]) -> tuple[int, float]:
    """Robots, then the fullest budget of any: what makes one division of the ground better than another."""
    return sum(tour.robots for tour in tours), max((load(tour) for tour in tours), default=0.0)


def load(tour: Tour) -> float:
    """Length over budget."""
    return tour_length_m(tour) / tour.budget_m


def strips_at(
    problem: Problem, ground: SweepGround, angle_rad: float, reserve: float, most: int | None
) -> list[Tour] | None:
    """The fewest strips along lanes of this angle, and then as even as rounds of bisection make them."""
    upright = ground_turned(ground.shape, -angle_rad)
    _, low, _, high = upright.bounds
    lanes = max(1, math.ceil((high - low) / (2 * sensing(problem, angle_rad).half_m) - 1e-9))
    edges = low + (high - low) * np.arange(lanes + 1) / lanes
    stops = np.searchsorted(edges, (ground.stops_m @ turning(-angle_rad))[:, 1]).clip(1, lanes) - 1

    def strip(first: int, last: int) -> SweepGround:
        shape = MultiPolygon([turn_shape(part, angle_rad) for part in slab(upright, edges[first], edges[last])])
        return replace(ground, shape=shape, stops_m=ground.stops_m[(stops >= first) & (stops < last)])

    @cache
    def over(first: int, last: int) -> Tour | None:
        ground_of_strip = strip(first, last)
        return best_route(problem, ground_of_strip, ground_of_strip.shape, [angle_rad])

    def divide(share: float, most: int | None) -> list[Tour] | None:
        """From below, every strip as wide as one robot with this share of its budget can sweep."""
        strips: list[Tour] = []
        first = 0
        while first < lanes:
            if not_more(strips, most) is None:
                return None
            last = widest(lambda k, first=first: fits(over(first, k), share), first + 1, lanes)  # type: ignore[misc]
            tour = over(first, last)
            if tour is not None and fits(tour, share):
                strips.append(tour)
            elif tour is not None:
                strips += pieces_of_lane(problem, strip(first, last), tour, angle_rad, share)
            first = last
        return not_more(strips, most)

    best = divide(1 - reserve, most)
    if best is None:
        return None
    # no share below the mean load of the robots can do with as many
    loose, tight = 1 - reserve, sum(load(tour) * tour.robots for tour in best) / max(1, burden(best)[0])
    for _ in range(BALANCING if len(best) > 1 else 0):
        middle = (loose + tight) / 2
        even = divide(middle, burden(best)[0])
        if even is not None and burden(even) <= burden(best):
            best, loose = even, middle
        else:
            tight = middle
    return best


def pieces_of_lane(problem: Problem, strip: SweepGround, whole: Tour, angle_rad: float, share: float) -> list[Tour]:
    """A strip too long for one robot cut across: even pieces, as few as fit; or shared, where that takes fewer robots.

    Pieces keep robots with bodies from meeting face to face on one lane, which is worth a robot more.
    """
    shared = replace(whole, robots=robots_for(whole, 1 - share))
    upright = ground_turned(strip.shape, math.pi / 2 - angle_rad)
    _, low, _, high = upright.bounds
    spare = 1 if whole.robot.body_radius_m > 0 else 0
    for count in range(2, shared.robots + spare + 1):
        edges = low + (high - low) * np.arange(count + 1) / count
        areas = [MultiPolygon([turn_shape(part, angle_rad - math.pi / 2) for part in slab(upright, a, b)])
                 for a, b in pairwise(edges)]  # fmt: skip
        tours = tours_over(problem, strip, [area for area in areas if not area.is_empty], [angle_rad])
        if all(fits(tour, share) for tour in tours):
            return tours
    return [shared]


def fits(tour: Tour | None, share: float) -> bool:
    """Whether one robot can go round within this share of its budget."""
    return tour is None or load(tour) <= share


def widest(good: Callable[[int], bool], first: int, last: int) -> int:
    """The greatest number from first to last that is good, if what is below a good one is good too; first at least."""
    while first < last:
        middle = (first + last + 1) // 2
        if good(middle):
            first = middle
        else:
            last = middle - 1
    return first


def decomposition(problem: Problem, ground: SweepGround, reserve: float, most: int | None) -> list[Tour] | None:
    """Sub-areas of a robot each, swept cell by cell, each in the direction that suits it best (Figure 3c).

    Halved again and again by straight cuts, in proportion to the robots on either side, along the directions that give
    the shortest lanes, and then made more alike; strips instead, where only these are as few. The robots: as few as
    make all loops fit. Source: the decomposition of Maza and Ollero (DARS 2007), which the figure shows, with the cells
    of Choset (2000).
    """
    if ground.shape.is_empty:
        return sequential(problem, ground, reserve, most)
    strips = parallel(problem, ground, reserve, most)
    limit = burden(strips)[0] if strips is not None else most
    assert limit is not None
    budget_m = problem.pace_m_s * problem.periods_s[ground.period_class] * (1 - reserve)
    fewest = max(1, math.ceil(ground.shape.area / (problem.swath_m * budget_m) - 1e-9))
    for robots in range(max(fewest, limit - 6), limit + 1):  # up to six fewer than strips need
        tours = balanced_areas(problem, ground, robots)
        if all(fits(tour, 1 - reserve) for tour in tours):
            return tours
    return strips


def balanced_areas(problem: Problem, ground: SweepGround, robots: int) -> list[Tour]:
    """Tours over so many sub-areas, weighed anew by the lengths of their tours until these stop becoming more alike."""
    weights = np.ones(robots)
    best: list[Tour] = []
    for _ in range(BALANCING):
        areas = divided_area(problem, ground.shape, weights)
        tours = tours_over(problem, ground, areas, None)
        if best and burden(tours) >= burden(best):
            break
        best = tours
        loads = np.array([load(tour) for tour in tours])
        if robots == 1 or len(tours) < robots or loads.min() <= 0 or loads.mean() > 1:
            break
        weights = weights * loads.mean() / loads
    return best


def tours_over(
    problem: Problem, ground: SweepGround, areas: list[MultiPolygon], tried: list[float] | None
) -> list[Tour]:
    """One tour over each sub-area, by way of the stops nearest to it.

    tried: the directions of its lanes; None: those that suit it best, its cells each by themselves.
    """
    apart = shapely.distance(shapely.points(ground.stops_m)[:, None], np.array(areas)[None])
    nearest = np.argmin(apart, axis=1) if len(apart) else np.zeros(0, dtype=np.int64)
    tours = []
    for k, area in enumerate(areas):
        own = replace(ground, stops_m=ground.stops_m[nearest == k])
        tour = best_route(problem, own, area, tried or promising_angles(problem, area), own=tried is None)
        if tour is not None:
            tours.append(tour)
    return tours


def divided_area(problem: Problem, shape: MultiPolygon, weights: Floats) -> list[MultiPolygon]:
    """The shape in as many sub-areas as weights (n,), of areas in proportion to them, by straight cuts."""
    if len(weights) == 1:
        return [shape]
    half = len(weights) // 2
    share = float(weights[:half].sum() / weights.sum())
    tried = angles(problem, shape)
    cuts = [cut_in_two(shape, angle, share) for angle in tried]
    costs = [
        max(shortest_guess_m(problem, one) / share, shortest_guess_m(problem, two) / (1 - share)) for one, two in cuts
    ]
    one, two = cuts[int(np.argmin(costs))]
    return [*divided_area(problem, one, weights[:half]), *divided_area(problem, two, weights[half:])]


def cut_in_two(shape: MultiPolygon, angle_rad: float, share: float) -> tuple[MultiPolygon, MultiPolygon]:
    """The shape cut along a line of this angle, with this share of its area below the line."""
    upright = ground_turned(shape, -angle_rad)
    _, low, _, high = upright.bounds
    bottom, top = low, high
    for _ in range(25):
        middle = (bottom + top) / 2
        below = sum(part.area for part in slab(upright, low - 1, middle))
        bottom, top = (middle, top) if below < share * upright.area else (bottom, middle)
    both = [MultiPolygon(slab(upright, low - 1, middle)), MultiPolygon(slab(upright, middle, high + 1))]
    return turn_shape(both[0], angle_rad), turn_shape(both[1], angle_rad)
