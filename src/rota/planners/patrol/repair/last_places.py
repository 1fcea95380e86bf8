"""The last places that see something: where no candidate place does, a place that is looked for, or a way across."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from shapely import MultiPolygon
from shapely.geometry.base import BaseGeometry

from rota.geometry.line_of_sight import points_inside, segments_free
from rota.model.arrays import Flags, Floats
from rota.planners.patrol.ground.nearest_kernels import nearest_on_segments
from rota.planners.patrol.ground.nearest_places import nearest_places, segments_of
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.samples import SamplePoints, lay_out
from rota.planners.patrol.ground.sight import sensor_arguments
from rota.planners.patrol.ground.surroundings import places_in_sight
from rota.planners.patrol.ground.viewpoints import place_that_sees, what_places_see
from rota.planners.patrol.tolerances import CUT_M, INSIDE_M, SAME_PLACE_M
from rota.planners.patrol.tours.tour import Tour

ACROSS = 0.02  # of the reach: how far to either side of a line of sight a tour goes across it
HALVINGS = 6  # of that way, where something stands in it


def ways_to_hidden(problem: Problem, tours: Sequence[Tour], hidden: SamplePoints) -> list[tuple[Floats, int]]:
    """Short ways (k, 2) that together see the hidden points, which no candidate place sees, with their periods.

    On ragged ground those come first that are seen from the least ground, and what is seen on a way to one of them
    gets no way of its own: views of places along a wall lie within each other.
    """
    if not problem.is_ragged:
        places_m = [last_place(problem, hidden, i) for i in range(len(hidden))]
        return [(place[None], int(hidden.period[i])) for i, place in enumerate(places_m) if place is not None]
    hidden, samples, _ = lay_out(hidden, problem.walls, problem.robot)
    seen_m2 = [places_in_view(problem, xy_m).area for xy_m in hidden.xy_m]
    vertices_m = np.vstack([tour.vertices_m for tour in tours])
    ways: list[tuple[Floats, int]] = []
    soonest = np.full(len(hidden), np.iinfo(np.int64).max)  # the shortest period of a way that sees a point
    for i in np.argsort(seen_m2, kind="stable"):
        period = int(hidden.period[i])
        place_m = last_place(problem, hidden, int(i)) if soonest[i] > period else None
        if place_m is None:
            continue
        place_m = off_vertices(problem, vertices_m, hidden.xy_m[i], place_m)
        way_m = way_across(problem, hidden.xy_m[i], place_m)
        ways.append((way_m, period))
        vertices_m = np.vstack([vertices_m, way_m])
        _, seen = what_places_see(way_m, problem.robot, problem.range_margin_m, samples)
        soonest[seen] = np.minimum(soonest[seen], period)
    return ways


def near_to(vertices_m: Floats, place_m: Floats) -> Floats:
    """The vertices (k, 2) of some (n, 2) that count as one place with this one."""
    return np.asarray(vertices_m[np.hypot(*(vertices_m - place_m).T) < CUT_M])


def off_vertices(problem: Problem, vertices_m: Floats, point_m: Floats, place_m: Floats) -> Floats:
    """A place that sees the point like this one, but does not count as one with vertices (n, 2) that do not see it.

    A timetable keeps but one of them. A view may be 1e-7 m wide and centimetres long: another place in it does as well.
    Where there is none it is the place itself, which then replaces the vertex.
    """
    near_m = near_to(vertices_m, place_m)
    if not len(near_m):
        return place_m
    apart_m = border_place(problem, point_m, off=shapely.multipoints(near_m).buffer(2 * CUT_M))
    return place_m if apart_m is None else apart_m


def way_across(problem: Problem, point_m: Floats, place_m: Floats) -> Floats:
    """A short straight way (k, 2) across a line of sight, near the place that sees the point; k is 1 to 3.

    Between the walls of a scanned floor much is seen through slits only: the nearer to a wall a point lies, the nearer
    to that wall's line is all that sees it. No place sees all points beside the wall, but who crosses the line does,
    one after the other. Where robots can stand begins at that line, too often: so the way is the first, from the place
    onwards, that has room on both sides, and where none has, it ends at the very border. Elsewhere than on ragged
    ground it is the place alone.
    """
    away_m = float(np.hypot(*(place_m - point_m)))
    if not problem.is_ragged or away_m == 0:
        return place_m[None]
    along = (place_m - point_m) / away_m
    across = ACROSS * problem.reach_m * np.array([-along[1], along[0]])
    furthest_m = max(0.0, (1 - 2 * ACROSS) * problem.reach_m - away_m)
    # 16 places along the line of sight, up to the reach
    middles = place_m + np.linspace(0.0, furthest_m, 16)[:, None] * along
    shares = 0.5 ** np.arange(HALVINGS + 1)
    ends = middles[:, None, None] + np.array([-1.0, 1.0])[:, None, None] * (shares[:, None] * across)
    free = reached_straight(problem, np.broadcast_to(middles[:, None, None], ends.shape), ends)
    room = np.where(free, shares, 0.0).max(axis=2)  # (depths, sides) of the way to either side
    room[~reached_straight(problem, np.broadcast_to(place_m, middles.shape), middles)] = -1.0
    k = int(np.argmax(room.min(axis=1) + room.max(axis=1) / 2**HALVINGS))
    if room[k].max() == 0:  # in a corridor as narrow as the body a timetable could not tell the ends of the way apart
        return place_m[None]
    left, right = (border_along(problem, middles[k], side * across, room[k, i]) for i, side in enumerate((-1.0, 1.0)))
    return np.array([place for place in (left, middles[k], right) if place is not None])


def reached_straight(problem: Problem, begins_m: Floats, ends_m: Floats) -> Flags:
    """Whether robots get straight from places in the space to others, (..., 2) each: (...) flags."""
    grid = problem.paths.grid
    begins, ends = begins_m.reshape(-1, 2), ends_m.reshape(-1, 2)
    return np.asarray(points_inside(ends, grid) & segments_free(begins, ends, grid)).reshape(ends_m.shape[:-1])


def border_along(problem: Problem, begin_m: Floats, way_m: Floats, share: float) -> Floats | None:
    """How far robots get from a place along a straight way, a share of which is known to be free; None: nowhere.

    A hair before the border: what touches it counts as inside, and might be just outside.
    """
    low, high = share, min(1.0, 2 * share) if share > 0 else 0.5**HALVINGS
    for _ in range(32 if share < 1 else 0):  # halvings, to less than a hair
        middle = (low + high) / 2
        if reached_straight(problem, begin_m[None], (begin_m + middle * way_m)[None])[0]:
            low = middle
        else:
            high = middle
    low -= INSIDE_M / float(np.hypot(*way_m)) if share < 1 else 0.0
    return begin_m + low * way_m if low > 0 else None


def last_place(problem: Problem, points: SamplePoints, i: int) -> Floats | None:
    """A place for a sample that no candidate sees: with room all round if there is any, or at the border."""
    space, walls, robot = problem.space, problem.walls, problem.robot
    place = None
    if points.shrink_m[i] >= 0:
        place = place_that_sees(points.xy_m[i], points.visit_m[i], space, walls, robot, problem.range_margin_m)
    return border_place(problem, points.xy_m[i]) if place is None and points.visit_m[i] == 0 else place


def nearby_place(problem: Problem, point_m: Floats, visit_m: float, turn: int) -> Floats | None:
    """A place from where the point is seen well: in the middle of its view, of a view cut shorter every turn."""
    margin_m = problem.reach_m * (1 - 0.6**turn) + problem.range_margin_m
    place = place_that_sees(point_m, visit_m, problem.space, problem.walls, problem.robot, margin_m)
    return border_place(problem, point_m) if place is None and visit_m == 0 else place


def border_place(problem: Problem, point_m: Floats, off: BaseGeometry | None = None) -> Floats | None:
    """The place that sees the point from least far, on the border of where robots can stand; None out of reach.

    off: on ragged ground, places that will not do.

    On ragged ground it is a hair inside of what the point sees: from the very edge of a view rounding decides. Of a
    view narrower than any hair it is where the space ends: what is nearer to a wall than the point is seen from there.
    """
    if not problem.is_ragged:
        nearest_m, ranges_m = nearest_places(point_m, problem.space, problem.walls, problem.robot)
        return nearest_m[0] if ranges_m[0] <= problem.reach_m else None
    _, square = sensor_arguments(problem.robot, 0.0)
    places = places_in_view(problem, point_m)
    places = places if off is None else shapely.difference(places, off)
    for hair_m in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 0.0):  # off the edge of a view, as far as it is wide enough
        inside = segments_of(places.buffer(-hair_m)) if hair_m > 0 else ends_of(places, problem.space)
        if len(inside):
            place_m, range_m = nearest_on_segments(point_m[None], inside, square)
            if range_m[0] <= problem.reach_m:
                return np.asarray(place_m[0])
    return None


def places_in_view(problem: Problem, point_m: Floats) -> BaseGeometry:
    """Where a robot may stand in sight of the point, as far off as the corner of a square sensor."""
    return places_in_sight(point_m, problem.space, problem.walls, problem.robot.sensor.reach_m)


def ends_of(places: BaseGeometry, space: MultiPolygon) -> Floats:
    """The sides (k, 4) of the places where the space ends too; all their sides where there are none."""
    sides = segments_of(places)
    on_border = shapely.dwithin(space.boundary, shapely.points(sides.reshape(-1, 2, 2)), SAME_PLACE_M).all(axis=1)
    return sides[on_border] if on_border.any() else sides
