"""From lanes to a closed route: the order and the directions in which they are driven, and the ways between them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely import LineString, MultiPolygon, Point, Polygon
from shapely.geometry.base import BaseGeometry

from rota.model.arrays import Floats
from rota.model.mission import DiscSensor
from rota.planners.patrol.efforts import EFFORTS
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.initial.first_tours import MOST_ORDERED, distances
from rota.planners.patrol.initial.standing import tour_of_one
from rota.planners.patrol.methods.sweeping.boustrophedon import cells
from rota.planners.patrol.methods.sweeping.lanes import (
    Swath,
    ground_turned,
    lanes_in,
    polygons,
    turn_shape,
)
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.tolerances import ON_LINE_M, TO_SPARE
from rota.planners.patrol.tours.tour import Tour, tour_length_m
from rota.planners.patrol.tours.visiting_order import order_of_pairs

MISSED_WEIGHT = (
    3.0  # times the length of lane that its ground takes: what it costs to reach a pocket that a route misses
)
MUCH_LONGER = 1.5  # times the shortest guess


@dataclass(frozen=True, kw_only=True)
class SweepGround:
    """What one route, or several side by side, must see: ground of some period classes before one part of the space.

    period_class: the shortest of the classes; stops_m (n, 2): places to be visited besides.
    """

    shape: MultiPolygon
    stops_m: Floats
    period_class: int
    component: int


def sweep_grounds(problem: Problem, groups: tuple[tuple[int, ...], ...]) -> list[SweepGround]:
    """The ground of each group of period classes, by part of the standing space; what no part borders is left out.

    Ground in front of two parts belongs to the larger one.
    """
    taken: BaseGeometry = MultiPolygon()
    claims = []
    for part in problem.paths.parts:
        body_m = problem.robot.body_radius_m
        claim = part.buffer(1.05 * body_m, join_style="mitre") if body_m > 0 else part
        claims.append(shapely.difference(claim, taken, grid_size=ON_LINE_M))
        taken = shapely.union(taken, claim, grid_size=ON_LINE_M)
    swept = []
    for group in groups:
        shapes = [
            region.shape
            for region, c in zip(problem.regions, problem.region_class, strict=True)
            if c in group and region.demand == "every_point"
        ]
        shape = smooth(shapely.union_all(shapes, grid_size=ON_LINE_M), 0.02 * problem.reach_m)
        visits = problem.points.xy_m[(problem.points.visit_m > 0) & np.isin(problem.points.period, group)]
        parts = problem.paths.part_of(visits)
        for part, claim in enumerate(claims):
            own = MultiPolygon(polygons(shapely.intersection(shape, claim, grid_size=ON_LINE_M)))
            if problem.lanes_overlap_m > 0:
                own = without_small_holes(own, problem.reach_m)
            stops = visits[parts == part]
            if not own.is_empty or len(stops):
                swept.append(SweepGround(shape=own, stops_m=stops, period_class=group[0], component=part))
    return swept


def smooth(shape: BaseGeometry, tolerance_m: float) -> BaseGeometry:
    """The shape without joints, slivers and the steps of a scanned map: lanes need no such detail, mending sees it."""
    simple = shapely.simplify(shape, tolerance_m)
    return simple if simple.is_valid and not simple.is_empty else shape


def without_small_holes(shape: BaseGeometry, most_m: float) -> BaseGeometry:
    """The shape with its holes filled whose boxes are no longer or wider than that.

    Sixty trunks would cut it in a hundred cells, each with lanes of its own; lanes that meet one go round it.
    """
    filled = []
    for part in shapely.get_parts(shape):
        holes = np.array([Polygon(ring) for ring in part.interiors], dtype=object)
        left, low, right, high = shapely.bounds(holes).reshape(-1, 4).T
        kept = holes[np.maximum(right - left, high - low) > most_m]
        filled.append(Polygon(part.exterior, [hole.exterior for hole in kept]))
    return MultiPolygon(filled)


def sensing(problem: Problem, angle_rad: float) -> Swath:
    """The swath of the mission's robot along lanes of this angle, a little narrower than it is."""
    margin_m = problem.range_margin_m + TO_SPARE * problem.reach_m + problem.lanes_overlap_m
    return Swath(sensor=problem.robot.sensor, angle_rad=angle_rad, margin_m=margin_m)


def angles(problem: Problem, shape: BaseGeometry) -> list[float]:
    """Directions in [0, pi) worth a try for lanes over a shape: along and across its longest edges, and both axes.

    For convex ground some direction along an edge needs fewest turns (Huang, ICRA 2001). A square sensor has the
    widest swath along its diagonals, which are tried too.
    """
    rings = shapely.get_parts(shapely.boundary(shape))
    steps = np.vstack([np.diff(shapely.get_coordinates(ring), axis=0) for ring in rings])
    turn, length_m = np.arctan2(steps[:, 1], steps[:, 0]) % math.pi, np.hypot(*steps.T)
    alike = np.rint(np.degrees(turn) * 4).astype(np.int64) % 720
    total_m = {int(which): float(length_m[alike == which].sum()) for which in np.unique(alike)}
    tried = [0.0] if isinstance(problem.robot.sensor, DiscSensor) else [0.0, math.pi / 4]
    for which in sorted(total_m, key=lambda which: (-total_m[which], which))[:6]:  # the longest edges
        tried.append(float(turn[alike == which][np.argmax(length_m[alike == which])]))
    both = [(angle + across) % math.pi for angle in tried for across in (0.0, math.pi / 2)]
    return list({round(angle, 6): angle for angle in both}.values())


def guess_m(shape: MultiPolygon, swath: Swath) -> float:
    """A guess at the length of a route over a shape in lanes: these at their mean length, sideways, and back."""
    across = np.array([-math.sin(swath.angle_rad), math.cos(swath.angle_rad)])
    high_m, width_m = float(np.ptp(shapely.get_coordinates(shape) @ across)), 2 * swath.half_m
    mean_m = float(shape.area) / high_m
    return mean_m * math.ceil(high_m / width_m - 1e-9) + 2 * max(high_m - width_m, 0.0)


def shortest_guess_m(problem: Problem, shape: MultiPolygon) -> float:
    """The guess for the direction that suits the shape best; 0 for an empty one."""
    if shape.is_empty:
        return 0.0
    return min(guess_m(shape, sensing(problem, angle)) for angle in angles(problem, shape))


def promising_angles(problem: Problem, shape: MultiPolygon, most: int | None = None) -> list[float]:
    """The directions that promise the shortest routes, at most so many, or (None) as many as the effort allows.

    Directions that promise routes ``MUCH_LONGER`` than the best one are left out: across a long corridor lanes are all
    turns, and there are thousands of them.
    """
    if shape.is_empty:
        return []
    guesses_m = {angle: guess_m(shape, sensing(problem, angle)) for angle in angles(problem, shape)}
    most_m = MUCH_LONGER * min(guesses_m.values())
    tried = [angle for angle in sorted(guesses_m, key=guesses_m.__getitem__) if guesses_m[angle] <= most_m]
    return tried[: most or EFFORTS[PatrolSettings.of(problem.mission).effort].sweeping.angles]


def lane_cost_m(lanes: Sequence[Floats], swath: Swath) -> float:
    """A guess at the length of a route along lanes: their own, and a swath's width from each to the next."""
    return sum(float(np.hypot(*np.diff(lane, axis=0).T).sum()) for lane in lanes) + 2 * swath.half_m * len(lanes)


def layouts(problem: Problem, shape: MultiPolygon, tried: list[float], *, own: bool) -> Iterator[Sequence[Floats]]:
    """Ways to lay lanes over a shape, those first that promise the shortest routes.

    For each angle: strips over all of it; strips cell by cell; strips over all but one side, along which a lane leads
    back. own: also cells of which each has the direction that suits it best.
    """
    guessed: list[tuple[float, int, Sequence[Floats]]] = []

    def add(lanes: Sequence[Floats], swath: Swath) -> None:
        if lanes:
            guessed.append((lane_cost_m(lanes, swath), len(guessed), lanes))

    for angle in tried:
        swath, across = sensing(problem, angle), sensing(problem, angle + math.pi / 2)
        add(lanes_in(shape, problem.space, swath), swath)
        blocks = cells_at(shape, angle)
        if len(blocks) > 1:
            add([lane for block in blocks for lane in lanes_in(block, problem.space, swath)], swath)
            if own:
                add([lane for block in blocks for lane in best_lanes(problem, block, tried)], swath)
        for side, rest in without_a_side(shape, angle, 2 * across.half_m):
            add(lanes_in(side, problem.space, across) + lanes_in(rest, problem.space, swath), swath)
    for _, _, lanes in sorted(guessed, key=lambda entry: entry[:2]):
        yield lanes


def cells_at(shape: MultiPolygon, angle_rad: float) -> list[BaseGeometry]:
    """The boustrophedon cells of a shape for lanes at this angle."""
    upright = ground_turned(shape, -angle_rad)
    return [turn_shape(cell, angle_rad) for part in polygons(upright) for cell in cells(part)]


def best_lanes(problem: Problem, cell: BaseGeometry, tried: list[float]) -> Sequence[Floats]:
    """The lanes over one cell at the angle that promises the shortest route; none where no robot can be."""
    laid = [(lanes_in(cell, problem.space, swath), swath) for swath in (sensing(problem, angle) for angle in tried)]
    laid = [(lanes, swath) for lanes, swath in laid if lanes]
    return min(laid, key=lambda pair: lane_cost_m(*pair))[0] if laid else ()


def without_a_side(
    shape: MultiPolygon, angle_rad: float, width_m: float
) -> Iterator[tuple[MultiPolygon, MultiPolygon]]:
    """The shape cut in a strip across the lanes at either end, for a lane that leads back, and the rest."""
    upright = ground_turned(shape, -angle_rad)
    left, low, right, high = upright.bounds
    if right - left < 2 * width_m or high - low < 2 * width_m:
        return
    for a, b in ((left - 1, left + width_m), (right - width_m, right + 1)):
        strip = shapely.box(a, low - 1, b, high + 1)
        side = polygons(shapely.intersection(upright, strip, grid_size=ON_LINE_M))
        rest = polygons(shapely.difference(upright, strip, grid_size=ON_LINE_M))
        if side and rest:
            yield turn_shape(MultiPolygon(side), angle_rad), turn_shape(MultiPolygon(rest), angle_rad)


def best_route(
    problem: Problem, ground: SweepGround, shape: MultiPolygon, tried: list[float], *, own: bool = False
) -> Tour | None:
    """The shortest closed route over a shape that lanes at the angles tried give; None when no robot can be near it.

    Ground that a route does not see is charged for, since the repair will have to lead it there.
    """
    best: tuple[float, Tour] | None = None
    ways = [[]] if shape.is_empty else layouts(problem, shape, tried, own=own)
    for k, lanes in enumerate(ways):
        if k == 3:  # the shortest on a guess are joined to routes and compared
            break
        tour = closed_route(problem, [*lanes, *(stop[None] for stop in ground.stops_m)], ground)
        if tour is None:
            continue
        length_m = tour_length_m(tour)
        if best is not None and length_m >= best[0]:
            continue  # what it misses takes longer to find than the route
        cost_m = length_m + MISSED_WEIGHT * missed_m2(problem, tour, shape) / problem.swath_m
        if best is None or cost_m < best[0]:
            best = (cost_m, tour)
    return best[1] if best is not None else None


def missed_m2(problem: Problem, tour: Tour, shape: MultiPolygon) -> float:
    """Area of the shape that is not in range of the route; what obstacles hide is not looked at."""
    ring = np.vstack([tour.vertices_m, tour.vertices_m[:1]])
    if isinstance(problem.robot.sensor, DiscSensor):
        line = LineString(ring) if len(ring) > 2 else Point(ring[0])
        return float(shapely.difference(shape, line.buffer(problem.reach_m, quad_segs=16)).area)
    half_m = problem.reach_m
    corners = half_m * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    ends = np.stack([ring[:-1], ring[1:]], axis=1)
    swept = shapely.convex_hull(
        shapely.multipoints([shapely.points((leg[:, None] + corners).reshape(-1, 2)) for leg in ends])
    )
    return float(shapely.difference(shape, shapely.union_all(swept)).area)


def closed_route(problem: Problem, lanes: list[Floats], ground: SweepGround) -> Tour | None:
    """A short closed tour along all lanes (k, 2), each driven in either direction, joined by shortest paths.

    Lanes outside the ground's part of the space are left out. None when there are none.
    """
    ends = np.array([[lane[0], lane[-1]] for lane in lanes]).reshape(-1, 2)
    inside = (problem.paths.part_of(ends) == ground.component).reshape(-1, 2).all(axis=1)
    lanes = [lane for lane, good in zip(lanes, inside, strict=True) if good]
    if not lanes:
        return None
    stops_m = np.vstack([lanes[k][::-1] if back else lanes[k] for k, back in driving_order(problem, lanes)])
    stops_m = stops_m[problem.paths.part_of(stops_m) == ground.component]
    vertices = problem.paths.paths_along(np.vstack([stops_m, stops_m[:1]]))
    ring_m = vertices[:-1] if len(vertices) > 1 else vertices
    return tour_of_one(problem, ring_m, ground.period_class, ground.component)


def driving_order(problem: Problem, lanes: list[Floats]) -> list[tuple[int, bool]]:
    """Lanes in the order of a short closed tour, each with whether it is driven backwards.

    Very many lanes are driven to and fro in the order given.
    """
    if 2 * len(lanes) > MOST_ORDERED or len(lanes) == 1:
        return [(k, k % 2 == 1) for k in range(len(lanes))]
    apart = distances(problem, np.array([[lane[0], lane[-1]] for lane in lanes]).reshape(-1, 2)).copy()
    return order_of_pairs(apart)


def robots_for(tour: Tour, reserve: float) -> int:
    """Robots that keep the tour's period when a share of their budget is kept for the repair."""
    return max(1, math.ceil(tour_length_m(tour) / (replace(tour, robots=1).budget_m * (1 - reserve))))
