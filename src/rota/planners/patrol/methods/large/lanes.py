"""Large ground in districts: each swept in lanes by a few robots that share one route, so that work grows with area.

One route over everything would be the shortest, but each of its robots would drive all of it: what a plan holds and
what there is to check would grow with the square of the area. Robots of one district are few, whatever the area.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon

from rota.geometry.shortest_path import ShortestPaths
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.methods.large.cells import weighed_boxes
from rota.planners.patrol.methods.sweeping.lanes import common_part, polygons, turned
from rota.planners.patrol.methods.sweeping.methods import load, sequential
from rota.planners.patrol.methods.sweeping.routes import SweepGround, best_route, promising_angles
from rota.planners.patrol.methods.sweeping.search import LEAST_LANES
from rota.planners.patrol.tours.tour import Tour, tour_length_m
from rota.polygons import polygons_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_SHARING = 12  # robots of one district; with bodies, which would meet on lanes side by side, one
MOST_CORNERS = 600  # of the ground in one district: ways round them, and orders of lanes, take their square
SHORTEST = 20.0  # reaches that a robot can drive in a period: with less, it hardly moves or is all turns
MOST_TRIES = 8  # numbers of robots
BALANCING = 6  # rounds in which districts are weighed anew by the lengths of their routes
AROUND = 4.0  # reaches beyond a district's bounds in which its route may find its way


def in_districts(problem: Problem, ground: SweepGround, reserve: float, most: int | None) -> list[Tour] | None:
    """Routes over districts of the ground, with as few robots as their lengths allow; None when more than ``most``.

    reserve: share of every budget that is kept for the repair. None also where a period is too short for lanes, or
    districts of so many robots do not fit their budgets after some numbers tried.
    """
    if ground.shape.is_empty:
        return sequential(problem, ground, reserve, most)
    one_m = problem.robot.speed_m_s * problem.periods_s[ground.period_class] * (1 - reserve)
    robots = max(1, math.ceil(LEAST_LANES * ground.shape.area / (problem.swath_m * one_m)))
    if one_m < SHORTEST * problem.reach_m:
        return None
    for _ in range(MOST_TRIES):
        if most is not None and robots > most:
            return None
        tours = over_districts(problem, ground, robots, reserve)
        if all(load(tour) <= 1 - reserve for tour in tours):
            return tours
        needed = math.ceil(sum(tour_length_m(tour) for tour in tours) / one_m)
        robots = max(robots + 1, needed)
    return None


def over_districts(problem: Problem, ground: SweepGround, robots: int, reserve: float) -> list[Tour]:
    """So many robots on routes over districts as large as their shares, weighed anew until all fit or none can help."""
    shares = robots_shared(robots, groups_for(problem, ground, robots))
    weights = shares.astype(np.float64)
    angle_rad = promising_angles(problem, ground.shape)[0]
    best: list[Tour] = []
    for _ in range(BALANCING):
        tours = routes_over(problem, ground, divided(ground.shape, angle_rad, weights), shares)
        loads = np.array([load(tour) for tour in tours])
        if not best or loads.max(initial=0.0) < max(load(tour) for tour in best):
            best = tours
        if len(tours) < len(shares) or loads.max() <= 1 - reserve or loads @ shares > robots * (1 - reserve):
            break
        weights = weights * np.clip(loads @ shares / robots / np.maximum(loads, 1e-9), 0.5, 2.0)
    return best


def divided(shape: MultiPolygon, angle_rad: float, weights: Floats) -> list[MultiPolygon]:
    """The shape in as many districts as weights (n,), of areas in proportion to them, cut along the angle and across.

    Districts in which there is nothing are left out.
    """
    upright = turned(shape, -angle_rad)
    cut = [common_part(upright, shapely.box(*box)) for box in weighed_boxes(upright, weights)]
    return [MultiPolygon(polygons(turned(part, angle_rad))) for part in cut if part.area > 0]


def groups_for(problem: Problem, ground: SweepGround, robots: int) -> int:
    """How many districts there are for so many robots: as few as keep each one's robots and corners few."""
    sharing = math.ceil(robots / (1 if problem.robot.body_radius_m > 0 else MOST_SHARING))
    winding = math.ceil(int(shapely.count_coordinates(ground.shape)) / MOST_CORNERS)
    return max(sharing, min(winding, robots))


def robots_shared(robots: int, groups: int) -> Ints:
    """So many robots in groups as even as can be: (k,) robots of each."""
    return np.array([robots // groups + (k < robots % groups) for k in range(groups)], dtype=np.int64)


def routes_over(problem: Problem, ground: SweepGround, areas: list[MultiPolygon], shares: Ints) -> list[Tour]:
    """One route over each area with its share of the robots, by way of the stops nearest to it.

    An area near which no robot can be has none.
    """
    away_m = shapely.distance(shapely.points(ground.stops_m)[:, None], np.array(areas)[None])
    nearest = np.argmin(away_m, axis=1) if len(away_m) else np.zeros(0, dtype=np.int64)
    routes = []
    for k, area in enumerate(areas):
        own = replace(ground, shape=area, stops_m=ground.stops_m[nearest == k])
        tour = route_over(problem, own)
        if tour is not None:
            routes.append(replace(tour, robots=int(shares[k])))
    return routes


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
