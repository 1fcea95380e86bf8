"""Built-up ground in pieces: each with a tour past places that see it, annealed for length; neighbours' tours joined.

Lanes suit open ground. Among buildings a tour past places that see everything, made shorter by annealing, is a sixth
shorter than lanes and found sooner. Pieces are all of one size, so that work grows with the area. Robots come whole: a
tour for itself alone leaves half a robot idle, so that tours of neighbours are joined into rounds of several robots.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from rota.errors import NoPlanFound
from rota.geometry.shortest_path import ShortestPaths
from rota.model.arrays import Ints
from rota.planners.patrol.annealing.search import Annealed, Annealing, budget_penalties
from rota.planners.patrol.context import Context
from rota.planners.patrol.driving.polylines import without_repeats
from rota.planners.patrol.ground.extra_points import no_points, prepare_with
from rota.planners.patrol.initial.allocation import period_groupings
from rota.planners.patrol.initial.standing import robots_stand
from rota.planners.patrol.methods.large.cells import boxes_for, missions_of, where_robots_come
from rota.planners.patrol.methods.large.districts import by_districts
from rota.planners.patrol.methods.large.lanes import AROUND, MOST_SHARING
from rota.planners.patrol.methods.sweeping.search import judge_by_lanes
from rota.planners.patrol.repair.repair import Repaired, plan_of, repair_until_feasible, with_robots
from rota.planners.patrol.tours.tour import Tour, tour_length_m
from rota.planners.patrol.tours.visiting_order import short_order


def is_built_up(context: Context) -> bool:
    """Whether so much stands on the ground, that lanes over it are mostly ways round something.

    Robots with bodies would meet where they share such a tour; those that hardly move drive none.
    """
    problem = context.problem
    if problem.robot.body_radius_m > 0 or any(robots_stand(problem, period_s) for period_s in problem.periods_s):
        return False
    corner_m2 = context.settings.districts.built_up_corner * problem.reach_m**2
    return problem.asked_m2 < corner_m2 * len(problem.paths.corners_m)


def in_pieces(context: Context) -> Repaired:
    """The best plan of tours over pieces, joined where that spares robots (met unless all repair failed).

    Everything is repaired before tours are joined: what each of them sees, the joined one sees as well. Raises
    NoPlanFound when the search is to end before every piece has its tour.
    """
    problem, settings = context.problem, context.settings
    count = boxes_for(problem.asked_m2, settings.districts.piece_area * problem.reach_m**2)
    missions = missions_of(problem.mission, count, AROUND * problem.robot.sensor.reach_m, where_robots_come(problem))
    pieces = by_districts(context, short_tours, missions)
    if context.should_stop():
        raise NoPlanFound("the search was stopped before there were tours over all of the ground")
    context.progress(0.9, "mending what the tours of all districts miss")
    found = [tour for own in pieces for tour in own]
    tours = [tour for alike in by_kind(found) for tour in without_scraps(problem.paths, alike)]
    tours = [with_robots(replace(tour, robots=1)) for tour in tours]
    exact = replace(context, problem=judge_by_lanes(problem))  # the points of the whole are farther apart
    apart = repair_until_feasible(exact, tours, no_points(), may_add=True, rounds=settings.repair.patient_rounds)
    if not apart.met or context.should_stop():
        return apart
    together = joined_tours(problem.paths, apart.tours)
    plan = plan_of(problem, together, seed=context.seed, bound=context.bound)
    fewer = replace(apart, tours=together, plan=plan, verdict=context.judge(plan))
    return fewer if fewer.met and fewer.robots < apart.robots else apart


def short_tours(context: Context) -> Annealed:
    """Tours over one piece by itself, annealed until they are short: every metre costs a metre.

    Seeing weighs twenty times as much as usual, and budgets nothing: tours are joined and get their robots later.
    """
    problem, settings = context.problem, context.settings.districts
    tours = period_groupings(problem, 1)[0].tours
    _, samples = prepare_with(problem, no_points())
    search = Annealing(
        tours,
        samples._replace(weight=20 * samples.weight),
        problem.paths.grid,
        length_weight=np.ones(len(tours)),
        budget_penalty=budget_penalties(tours, 0.0),
        seed=context.seed,
        range_margin_m=problem.range_margin_m,
    )
    search.run(
        int(settings.piece_moves * problem.asked_m2 / problem.swath_m / problem.reach_m),
        hot_m=problem.reach_m / 4,
        cold_m=1e-3 * problem.reach_m,
        should_stop=context.should_stop,
    )
    return search.annealed


@dataclass(frozen=True, kw_only=True)
class Link:
    """A way from a tour to another, from vertex ``leave`` to vertex ``arrive``; it is driven there and back."""

    leave: int
    arrive: int
    length_m: float


def by_kind(tours: Sequence[Tour]) -> list[list[Tour]]:
    """The tours of each period in each part of the space, which alone can be joined."""
    kinds = sorted({(tour.component, tour.period_class) for tour in tours})
    return [[tour for tour in tours if (tour.component, tour.period_class) == kind] for kind in kinds]


def joined_tours(paths: ShortestPaths, tours: Sequence[Tour]) -> list[Tour]:
    """The tours with those that follow each other joined wherever robots are spared, in the best way to do so."""
    together: list[Tour] = []
    for alike in by_kind(tours):
        own = [alike[k] for k in neighbours_in_turn(alike)]
        together += [
            with_robots(replace(merge(paths, own[first:last]), robots=1)) for first, last in best_runs(paths, own)
        ]
    return together


def neighbours_in_turn(tours: Sequence[Tour]) -> Ints:
    """An order (n,) of the tours in which each is followed by one nearby: a short round past their middles."""
    middles_m = np.array([tour.vertices_m.mean(axis=0) for tour in tours])
    return short_order(np.hypot(*(middles_m[:, None] - middles_m[None]).transpose(2, 0, 1)))


def best_runs(paths: ShortestPaths, tours: Sequence[Tour]) -> list[tuple[int, int]]:
    """The runs (first, last + 1) of tours to be joined that take the fewest robots, and of these the least way.

    Dynamic programming over how many tours are done.
    """
    n, one_m = len(tours), replace(tours[0], robots=1).budget_m
    own_m = [tour_length_m(tour) for tour in tours]
    ways_m = [0.0, *(2 * link_between(paths, a, b).length_m for a, b in pairwise(tours))]
    best: list[tuple[int, float]] = [(0, 0.0)]
    begun = [0]
    for last in range(1, n + 1):
        choices = []
        for first in range(last - 1, -1, -1):
            length_m = sum(own_m[first:last]) + sum(ways_m[first + 1 : last])
            robots = max(1, math.ceil(length_m / one_m))
            if robots > MOST_SHARING and first < last - 1:
                break
            choices.append((best[first][0] + robots, best[first][1] + length_m, first))
        robots, length_m, first = min(choices)
        best.append((robots, length_m))
        begun.append(first)
    runs: list[tuple[int, int]] = []
    last = n
    while last > 0:
        runs.append((begun[last], last))
        last = begun[last]
    return runs[::-1]


def link_between(paths: ShortestPaths, one: Tour, other: Tour) -> Link:
    """A short way between two tours: of those between the vertices of each that are nearest to the other's."""
    leave, arrive = vertices_near(one, other), vertices_near(other, one)
    ways_m = paths.distances(one.vertices_m[leave], other.vertices_m[arrive])
    k, m = np.unravel_index(int(np.argmin(ways_m)), ways_m.shape)
    return Link(leave=int(leave[k]), arrive=int(arrive[m]), length_m=float(ways_m[k, m]))


def vertices_near(one: Tour, other: Tour) -> Ints:
    """The vertices (k,) of a tour that are nearest to another's in a straight line, and some not quite so near.

    A wall may stand before those that are nearest.
    """
    away_m, _ = cKDTree(other.vertices_m).query(one.vertices_m)
    order = np.argsort(away_m, kind="stable")
    return np.unique(np.concatenate([order[:16], order[:128:8]]))


def merge(paths: ShortestPaths, tours: Sequence[Tour]) -> Tour:
    """One tour that goes round all of them in turn, there and back along the links between each and the next."""
    whole = tours[-1]
    for tour in tours[-2::-1]:
        whole = with_other(paths, tour, whole, link_between(paths, tour, whole))
    return whole


def with_other(paths: ShortestPaths, one: Tour, other: Tour, link: Link) -> Tour:
    """The tour that goes round the other one too, by way of the link."""
    there = np.roll(other.vertices_m, -link.arrive, axis=0)
    way_m = paths.path(one.vertices_m[link.leave], there[0])
    vertices_m = np.vstack(
        [one.vertices_m[: link.leave], way_m, there[1:], way_m[::-1], one.vertices_m[link.leave + 1 :]]
    )
    return replace(one, vertices_m=without_repeats(vertices_m))


def without_scraps(paths: ShortestPaths, tours: Sequence[Tour]) -> list[Tour]:
    """The tours, the shortest of them joined one by one to the nearest other of their kind while they are scraps.

    The border of a piece cuts off corners of courtyards, which are no ground for a robot of their own.
    """
    left = list(tours)
    while len(left) > 1:
        k = int(np.argmin([tour_length_m(tour) for tour in left]))
        scrap = left[k]
        # shorter tours are joined to others before all else
        if tour_length_m(scrap) > 0.3 * replace(scrap, robots=1).budget_m:
            break
        away_m = [
            np.inf if m == k else float(cKDTree(other.vertices_m).query(scrap.vertices_m)[0].min())
            for m, other in enumerate(left)
        ]
        nearest = np.argsort(away_m, kind="stable")[: min(3, len(left) - 1)]  # tours that a scrap may be joined to
        links = [(link_between(paths, left[m], scrap), m) for m in nearest]
        link, m = min(links, key=lambda pair: pair[0].length_m)
        left[m] = with_other(paths, left[m], scrap, link)
        del left[k]
    return left
