"""Large ground in districts: each swept in lanes by a few robots that share one route, so that work grows with area.

One route over everything would be the shortest, but each of its robots would drive all of it: what a plan holds and
what there is to check would grow with the square of the area. Robots of one district are few, whatever the area.
Districts are the columns of rows of lanes (``rows``), which suit open ground; or boxes of ground in about the same
amounts, where rows take more robots than these could.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely import LineString, MultiPolygon

from rota.geometry.shortest_path import ShortestPaths
from rota.model.arrays import Floats, Ints
from rota.model.mission import DiscSensor
from rota.model.polygons import polygons_of
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.initial.standing import tour_of_one
from rota.planners.patrol.methods.large.cells import weighed_boxes
from rota.planners.patrol.methods.large.rows import Column, best_rows, columns_of, lane_cells, row_measures
from rota.planners.patrol.methods.sweeping.lanes import Swath, common_part, lane_ends, polygons, turn_shape, turning
from rota.planners.patrol.methods.sweeping.methods import BALANCING, burden, load, meets_itself, not_more, sequential
from rota.planners.patrol.methods.sweeping.routes import SweepGround, best_route, promising_angles, robots_for, sensing
from rota.planners.patrol.methods.sweeping.search import LEAST_LANES
from rota.planners.patrol.tolerances import ON_LINE_M, ROUNDING, SAME_PLACE_M
from rota.planners.patrol.tours.tour import Tour, tour_length_m

MOST_SHARING = 12  # robots of one district or joined tour: what there is to check grows with their square
AROUND = 4.0  # reaches beyond a district's bounds in which its robots may go


def in_districts(problem: Problem, ground: SweepGround, reserve: float, most: int | None) -> list[Tour] | None:
    """Routes over districts of the ground, with as few robots as their lengths allow; None when more than ``most``.

    reserve: share of every budget that is kept for the repair. Rows of lanes, or boxes where they may do with fewer.
    """
    if ground.shape.is_empty:
        return sequential(problem, ground, reserve, most)
    budget_m = problem.pace_m_s * problem.periods_s[ground.period_class] * (1 - reserve)
    least = ground.shape.area / (problem.swath_m * budget_m)
    rows = promising_rows(problem, ground, budget_m)
    enough = 1.1 * least  # boxes seldom come below
    if most is not None and most < rows.robots <= enough:
        return None
    # boxes take fewer robots where rows take a quarter more than perfect lanes
    tours = in_rows(problem, ground, rows, reserve, most) if rows.robots <= 1.25 * least else None
    if tours is not None and burden(tours)[0] <= enough:
        return tours
    boxes = in_boxes(problem, ground, reserve, most if tours is None else burden(tours)[0] - 1)
    return boxes or tours or in_rows(problem, ground, rows, reserve, most)


def lesser(one: int | None, other: int) -> int:
    """The lesser of two limits, the first of which may be none."""
    return other if one is None else min(one, other)


@dataclass(frozen=True, kw_only=True)
class Rows:
    """Rows laid over the ground at one angle: for robots that drive ``budget_m`` in a period, so many of them."""

    budget_m: float
    angle_rad: float
    robots: int
    columns: list[Column]


def promising_rows(problem: Problem, ground: SweepGround, budget_m: float) -> Rows:
    """The rows with the fewest robots, of the directions of lanes tried."""
    laid = []
    for angle_rad in promising_angles(problem, ground.shape):
        measures = row_measures(problem, sensing(problem, angle_rad), budget_m * (1 - ROUNDING))
        cells = lane_cells(ground.shape, angle_rad, measures.width_m)
        rows = [(cell, row) for cell in cells for row in best_rows(cell, measures)]
        laid.append((sum(row.robots for _, row in rows), angle_rad, measures, rows))
    robots, angle_rad, measures, rows = min(laid, key=lambda entry: entry[0])
    columns = [column for cell, row in rows for column in columns_of(cell, row, measures)]
    return Rows(budget_m=budget_m, angle_rad=angle_rad, robots=robots, columns=columns)


def in_rows(problem: Problem, ground: SweepGround, rows: Rows, reserve: float, most: int | None) -> list[Tour] | None:
    """Loops over the columns of rows of lanes; None when more robots than ``most``.

    Where real loops are longer than their columns promised, rows are laid anew for that length.
    """
    best: list[Tour] | None = None
    for _ in range(3):  # rows are laid anew for the lengths that loops came to
        if most is not None and rows.robots > most:
            break
        tours = tours_over_columns(problem, ground, rows, reserve)
        if tours is None:
            break
        robots = burden(tours)[0]
        if best is None or robots < burden(best)[0]:
            best = not_more(tours, most)
        if robots <= rows.robots:
            break
        longer = sum(tour_length_m(tour) for tour in tours) / rows.robots / rows.budget_m
        rows = promising_rows(problem, ground, rows.budget_m / max(1.0, longer) * (1 - 2e-3))
    return best


def tours_over_columns(problem: Problem, ground: SweepGround, rows: Rows, reserve: float) -> list[Tour] | None:
    """A tour over each column, by way of the stops nearest to it, with as many robots as it needs.

    A loop over the lanes where these are open; else the shortest route that is found. A column near which no robot can
    be has none. None where robots with bodies would share a route that is no such loop: they would meet.
    """
    areas = [
        MultiPolygon(polygons(turn_shape(shapely.union_all(column.lanes), rows.angle_rad))) for column in rows.columns
    ]
    nearest = nearest_areas(ground.stops_m, areas)
    swath, room = sensing(problem, rows.angle_rad), shapely.buffer(problem.space, ON_LINE_M)
    shapely.prepare(room)
    tours = []
    for k, column in enumerate(rows.columns):
        stops_m = ground.stops_m[nearest == k]
        ring_m = ring_over(column, swath) @ turning(rows.angle_rad)
        tour = None if len(stops_m) else loop_within(problem, ground, room, ring_m)
        is_ring = tour is not None
        tour = tour or route_over(problem, replace(ground, shape=areas[k], stops_m=stops_m))
        if tour is None:
            continue
        robots = robots_for(tour, reserve)
        if robots > 1 and problem.robot.body_radius_m > 0 and not is_ring:
            return None
        tours.append(replace(tour, robots=robots))
    return tours


def loop_within(problem: Problem, ground: SweepGround, room: MultiPolygon, ring_m: Floats) -> Tour | None:
    """The tour along a closed polyline (k, 2); None where it leaves the ground's part of the space."""
    if not room.covers(shapely.LinearRing(ring_m) if len(ring_m) > 2 else shapely.LineString(ring_m)):
        return None
    if (problem.paths.part_of(ring_m[:1]) != ground.component).any():
        return None
    return tour_of_one(problem, ring_m, ground.period_class, ground.component)


def in_boxes(problem: Problem, ground: SweepGround, reserve: float, most: int | None) -> list[Tour] | None:
    """Routes over boxes of the ground in about the same amounts; see ``in_districts``.

    Each box has as many robots as its route needs. Where that takes many more than all lengths together do, boxes are
    weighed anew. Robots with bodies share no route.
    """
    one_m = problem.pace_m_s * problem.periods_s[ground.period_class] * (1 - reserve)
    robots = max(1, math.ceil(LEAST_LANES * ground.shape.area / (problem.swath_m * one_m)))
    if one_m < 20.0 * problem.reach_m:  # with so little to drive a robot hardly moves, or is all turns
        return None
    for _ in range(8):  # numbers of robots
        if most is not None and robots > most:
            return None
        tours = over_districts(problem, ground, robots, reserve)
        if all(load(tour) <= 1 - reserve for tour in tours):
            return tours
        needed = sum(tour_length_m(tour) for tour in tours) / one_m
        whole = [replace(tour, robots=robots_for(tour, reserve)) for tour in tours]
        robots = max(robots + 1, math.ceil(needed))
        shared = all(tour.robots <= MOST_SHARING for tour in whole) and not meets_itself(whole)
        # so few more are not worth evening out districts
        if shared and burden(whole)[0] <= lesser(most, max(robots, math.floor(1.05 * needed))):
            return whole
    return None


def over_districts(problem: Problem, ground: SweepGround, robots: int, reserve: float) -> list[Tour]:
    """So many robots on routes over districts as large as their shares, weighed anew until all fit or none can help."""
    shares = robots_shared(robots, groups_for(problem, ground, robots))
    weights = shares.astype(np.float64)
    angle_rad = promising_angles(problem, ground.shape)[0]
    best: list[Tour] = []
    for _ in range(BALANCING):
        tours = routes_over(problem, ground, divide(ground.shape, angle_rad, weights), shares)
        loads = np.array([load(tour) for tour in tours])
        if not best or loads.max(initial=0.0) < max(load(tour) for tour in best):
            best = tours
        if len(tours) < len(shares) or loads.max() <= 1 - reserve or loads @ shares > robots * (1 - reserve):
            break
        weights = weights * np.clip(loads @ shares / robots / np.maximum(loads, 1e-9), 0.5, 2.0)
    return best


def divide(shape: MultiPolygon, angle_rad: float, weights: Floats) -> list[MultiPolygon]:
    """The shape in as many districts as weights (n,), of areas in proportion to them, cut along the angle and across.

    Districts in which there is nothing are left out.
    """
    upright = turn_shape(shape, -angle_rad)
    cut = [common_part(upright, shapely.box(*box)) for box in weighed_boxes(upright, weights)]
    return [MultiPolygon(polygons(turn_shape(part, angle_rad))) for part in cut if part.area > 0]


def groups_for(problem: Problem, ground: SweepGround, robots: int) -> int:
    """How many districts there are for so many robots: as few as keep each one's robots and corners few."""
    sharing = math.ceil(robots / (1 if problem.robot.body_radius_m > 0 else MOST_SHARING))
    # ways round corners, and orders of lanes, take their square
    winding = math.ceil(int(shapely.count_coordinates(ground.shape)) / 600)
    return max(sharing, min(winding, robots))


def robots_shared(robots: int, groups: int) -> Ints:
    """So many robots in groups as even as can be: (k,) robots of each."""
    return np.array([robots // groups + (k < robots % groups) for k in range(groups)], dtype=np.int64)


def routes_over(problem: Problem, ground: SweepGround, areas: list[MultiPolygon], shares: Ints) -> list[Tour]:
    """One route over each area with its share of the robots, by way of the stops nearest to it.

    An area near which no robot can be has none.
    """
    nearest = nearest_areas(ground.stops_m, areas)
    routes = []
    for k, area in enumerate(areas):
        own = replace(ground, shape=area, stops_m=ground.stops_m[nearest == k])
        tour = route_over(problem, own)
        if tour is not None:
            routes.append(replace(tour, robots=int(shares[k])))
    return routes


def nearest_areas(places_m: Floats, areas: list[MultiPolygon]) -> Ints:
    """For each of the places (n, 2) the number of the area nearest to it."""
    if not len(places_m):
        return np.zeros(0, dtype=np.int64)
    away_m = shapely.distance(shapely.points(places_m)[:, None], np.array(areas)[None])
    return np.asarray(np.argmin(away_m, axis=1))


def route_over(problem: Problem, ground: SweepGround) -> Tour | None:
    """The shortest closed route over one district that lanes give; its ways are looked for near the district."""
    near = space_near(problem, ground)
    if near is None:
        return best_route(problem, ground, ground.shape, promising_angles(problem, ground.shape))
    paths = ShortestPaths(near)
    local = replace(problem, space=near, paths=paths)
    tour = best_route(local, replace(ground, component=0), ground.shape, promising_angles(local, ground.shape))
    return None if tour is None else replace(tour, component=ground.component)


def space_near(problem: Problem, ground: SweepGround) -> MultiPolygon | None:
    """Where robots can be in and round the district, if it is all in one; None when ways may lead farther round."""
    margin_m = AROUND * problem.robot.sensor.reach_m
    x0, y0, x1, y1 = shapely.total_bounds(np.array([ground.shape, *shapely.points(ground.stops_m)]))
    box = shapely.box(x0 - margin_m, y0 - margin_m, x1 + margin_m, y1 + margin_m)
    part = problem.paths.parts[ground.component]
    asked = shapely.union_all([ground.shape, *shapely.points(ground.stops_m)])
    pieces = [piece for piece in polygons_of(shapely.intersection(part, box)).geoms if shapely.intersects(piece, asked)]
    return MultiPolygon(pieces) if len(pieces) == 1 else None


def ring_over(column: Column, swath: Swath) -> Floats:
    """A closed polyline (k, 2), in the frame of the lanes, from which all of the column is seen in the open.

    Lanes lead straight past holes in their ground. With an even number of lanes the way back is along the left ends; an
    inner lane then begins where that way sees no further. With an odd one it is straight across.
    """
    ends = np.array([lane_ends(part, y, swath) for part, y in zip(column.lanes, column.heights_m, strict=True)])
    lanes = len(ends)
    back = np.column_stack([ends[:, 0], column.heights_m])[::-1] if lanes % 2 == 0 else np.zeros((0, 2))
    if lanes > 2 and len(back) and isinstance(swath.sensor, DiscSensor):
        seen = LineString(back).buffer(swath.half_m)
        for j in range(1, lanes - 1):
            rest = shapely.difference(column.lanes[j], seen)
            ends[j] = lane_ends(rest, column.heights_m[j], swath) if not rest.is_empty else (ends[j, 1], ends[j, 1])
    there = np.stack([ends, np.repeat(column.heights_m[:, None], 2, axis=1)], axis=2)  # lane, end, axis
    there[1::2] = there[1::2, ::-1]
    ring = np.vstack([there.reshape(-1, 2), back[1:-1]])
    closed = LineString(np.vstack([ring, ring[:1]])).simplify(SAME_PLACE_M)
    return np.asarray(shapely.get_coordinates(closed)[:-1])
