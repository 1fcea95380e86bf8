"""Ways of their own to what bending does not bring into sight: past places that see it, by the least detour."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from rota.model.arrays import Floats, Ints
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.samples import SamplePoints, lay_out
from rota.planners.patrol.ground.viewpoints import choose_viewpoints, what_places_see
from rota.planners.patrol.repair.last_places import near_to, ways_to_hidden
from rota.planners.patrol.tolerances import CUT_M, ON_LINE_M
from rota.planners.patrol.tours.tour import Tour, room_m

LONG_LEG = 4.0  # reaches: a leg so long is left and come back to where a detour is nearest


def visit_places(
    problem: Problem, tours: list[Tour], points: SamplePoints, samples: Samples, unseen: Ints, *, further: bool
) -> list[Tour] | None:
    """Tours led along shortest paths past places that see the unseen samples; None where there are none.

    further: also past places other than the candidates, of which each sees the one sample that it was looked for.
    """
    wanted = np.zeros(len(points), dtype=bool)
    wanted[unseen] = True
    places_m = near_places(problem, points.xy_m[unseen])
    start, items = what_places_see(places_m, problem.robot, problem.range_margin_m, samples)
    chosen, hidden = choose_viewpoints(start, items, wanted, points.area_m2)
    stops = [
        (places_m[i][None], min(points.period[s] for s in items[start[i] : start[i + 1]] if wanted[s])) for i in chosen
    ]
    ways = ways_to_hidden(problem, tours, points[np.flatnonzero(hidden)]) if further and hidden.any() else []
    if not stops and not ways:
        return None
    for k, (way_m, period) in enumerate([*stops, *ways]):
        # what is hidden on ragged ground is not seen from a vertex that is a hair beside its place
        sees_as_much = k < len(stops) or not problem.is_ragged
        middle_m = way_m[len(way_m) // 2]
        if not (sees_as_much and any(len(near_to(tour.vertices_m, middle_m)) for tour in tours)):
            tours = led_past(problem, tours, way_m, int(period))
    return tours


def places_hidden(problem: Problem, points: SamplePoints) -> Floats:
    """Those (k, 2) of the points that no candidate place sees."""
    points, samples, _ = lay_out(points, problem.walls, problem.robot)
    near_m = near_places(problem, points.xy_m)
    _, seen = what_places_see(near_m, problem.robot, problem.range_margin_m, samples)
    return points.xy_m[np.setdiff1d(np.arange(len(points)), seen)]


def near_places(problem: Problem, xy_m: Floats) -> Floats:
    """The candidate places within reach of any of the points (n, 2)."""
    tree = cKDTree(problem.viewpoints.xy_m)
    near = tree.query_ball_point(xy_m, problem.robot.sensor.reach_m)
    return problem.viewpoints.xy_m[sorted({int(i) for row in near for i in row})].reshape(-1, 2)


def led_past(problem: Problem, tours: list[Tour], way_m: Floats, period: int) -> list[Tour]:
    """The tours, the one that has the least detour led along a short straight way (k, 2), or past a place (1, 2).

    A new tour when none may or can go there. A robot of its own is posted there also where the detour would take more
    than one robot travels in a period.
    """
    place_m = way_m[len(way_m) // 2]
    component = int(problem.paths.part_of(place_m[None])[0])
    able = [k for k, tour in enumerate(tours) if tour.period_class <= period and tour.component == component]
    straight_m = {k: float(straight_detours(tours[k].vertices_m, place_m).min()) for k in able}
    best: tuple[float, int, int] | None = None
    for k in sorted(able, key=straight_m.__getitem__):
        if best is not None and straight_m[k] > best[0] + ON_LINE_M:
            break  # no detour is shorter than straight
        tour = tours[k]
        i, detour_m = least_detour(problem, tour.vertices_m, place_m)
        room = room_m(tours, k)
        if min(detour_m, detour_m - room) > replace(tour, robots=1).budget_m:
            continue
        cost = detour_m + 3 * max(0.0, detour_m - room)
        if math.isfinite(cost) and (best is None or (cost, k) < best[:2]):
            best = (cost, k, i)
    if best is None:
        alone = Tour(
            vertices_m=way_m, period_class=period, period_s=problem.periods_s[period], robots=1,
            robot=problem.robot, component=component,
        )  # fmt: skip
        return [*tours, alone]
    _, k, i = best
    return [*tours[:k], with_detour(problem, tours[k], i, way_m), *tours[k + 1 :]]


def with_detour(problem: Problem, tour: Tour, i: int, way_m: Floats) -> Tour:
    """The tour led along a way (k, 2), in the direction that is shorter, between its i-th place and the next."""
    vertices = tour.vertices_m
    before, after = vertices[i], vertices[(i + 1) % len(vertices)]
    ways = (way_m, way_m[::-1])
    way_m = min(ways, key=lambda way: float(np.hypot(*(way[0] - before)) + np.hypot(*(way[-1] - after))))
    overlap = problem.lanes_overlap_m > 0  # lanes among many small obstacles: those are left near each of them alone
    kept = left_near(before, after, way_m, problem.reach_m) if overlap else np.zeros((0, 2))
    detour = problem.paths.paths_along(np.vstack([before, kept[:1], way_m, kept[1:], after]))[1:-1]
    # a timetable keeps but one of places so near each other; slivers of views lie beside each other on ragged ground
    away_m = np.hypot(*(vertices - way_m[len(way_m) // 2]).T)
    replaced = (len(way_m) == 1) & (away_m > 0) & (away_m < CUT_M) & problem.is_ragged & (tour.nest < 0)
    longer = np.vstack([vertices[: i + 1][~replaced[: i + 1]], detour, vertices[i + 1 :][~replaced[i + 1 :]]])
    return replace(tour, vertices_m=longer)


def left_near(before_m: Floats, after_m: Floats, way_m: Floats, reach_m: float) -> Floats:
    """Where a way leaves a long leg, and where it comes back: (2, 2), or (0, 2) where all of the leg is left.

    Right beside the way, so that all of the leg is still driven: ground that a leg led aside takes out of sight bends
    the lane beside it in the next round of repair, and that one the next.
    """
    leg_m = float(np.hypot(*(after_m - before_m)))
    if leg_m < LONG_LEG * reach_m:
        return np.zeros((0, 2))
    along = (after_m - before_m) / leg_m
    feet_m = (way_m - before_m) @ along
    leaves_m, returns_m = np.clip(feet_m[[0, -1]], 0.0, leg_m)
    return np.vstack([before_m + leaves_m * along, before_m + returns_m * along])


def least_detour(problem: Problem, vertices_m: Floats, place_m: Floats) -> tuple[int, float]:
    """The leg of a closed tour (n, 2) with the shortest detour past the place, the first of several; and its metres.

    inf where no way leads there. Legs are looked at by their straight detours, for no way is shorter than straight.
    """
    ends_m = np.roll(vertices_m, -1, axis=0)
    legs_m = np.hypot(*(ends_m - vertices_m).T)
    straight_m = straight_detours(vertices_m, place_m)
    order = np.argsort(straight_m, kind="stable")
    best = (math.inf, 0)
    first, count = 0, 2  # ways round obstacles are measured for two legs at first, then for twice as many each time
    while first < len(order):
        some = order[first : first + count]
        first, count = first + count, 2 * count
        if straight_m[some[0]] > best[0] + ON_LINE_M:
            break
        ways_m = problem.paths.distances(np.vstack([vertices_m[some], ends_m[some]]), place_m[None])[:, 0]
        detours_m = ways_m[: len(some)] + ways_m[len(some) :] - legs_m[some]
        best = min(best, *zip(detours_m.tolist(), some.tolist(), strict=True))
    return best[1], best[0]


def straight_detours(vertices_m: Floats, place_m: Floats) -> Floats:
    """Metres (n,) that each leg of a closed tour (n, 2) would be longer past the place, if nothing were in the way."""
    legs_m = np.hypot(*(np.roll(vertices_m, -1, axis=0) - vertices_m).T)
    away_m = np.hypot(*(vertices_m - place_m).T)
    straight_m: Floats = away_m + np.roll(away_m, -1) - legs_m
    return straight_m
