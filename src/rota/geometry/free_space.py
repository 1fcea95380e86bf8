"""Area minus obstacles: where a body may stand, what is demanded there, and the walls that cut sight."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import MultiPolygon, Point, Polygon
from shapely.geometry.base import BaseGeometry

from rota.errors import MissionError
from rota.geometry.tiles import Box, clip, grown_box
from rota.model.arrays import Floats
from rota.model.mission import AREA, TOUCH_M, Demand, Mission, Obstacle, Zone
from rota.model.polygons import polygons_of
from rota.model.start_faults import ENTRANCE_NEAR

# Overlays of polygons that share borders leave slivers of rounding error; nothing a robot could stand in is this small.
_SLIVER_M2 = 1e-9
# Corners of a whole turn round a grown corner: 16 keeps a right angle at four corners and 2 % of the radius too far.
_ARC_CORNERS = 16
# The same where the fleet has entrances: a gap wider than the body by a thousandth of its radius is a way in.
_ENTERED_ARC_CORNERS = 72


def free_ground(mission: Mission) -> MultiPolygon:
    """The area without what blocks motion; it may be empty or in parts."""
    blocking = [obstacle.shape for obstacle in mission.obstacles if obstacle.blocks_motion]
    return polygons_of(mission.area.difference(shapely.union_all(blocking)))


@dataclass(frozen=True, kw_only=True)
class DemandedRegion:
    """Ground that must be seen (or, with demand "visit", entered) in every window of ``period_s`` seconds.

    sensors: names of those that count; none: all do.
    """

    name: str
    period_s: float
    demand: Demand
    shape: MultiPolygon
    sensors: tuple[str, ...] = ()


def standing_space(mission: Mission, body_radius_m: float, *, arc_corners: int = _ARC_CORNERS) -> MultiPolygon:
    """Where the centre of a disc body may be: the area minus what blocks motion, eroded by the body.

    body_radius_m: metres, 0 or more; 0 gives exactly area minus obstacles. arc_corners: corners of a polygon all the
    way round a grown corner, at least 8. Straight borders move by exactly body_radius_m; round a corner the border is
    circumscribed about the true arc, so that no point of the space is closer than body_radius_m to an obstacle or to
    the outside, and at most 1 / cos(pi / arc_corners) times the radius away from the corner.

    The answer may be empty or in parts. A gap as wide as the body, or narrower, is closed. Where the fleet has
    entrances, only the parts behind them are left; see ``entered``. Arcs are then so fine that they close no way in,
    whatever ``arc_corners`` says. Raises ValueError when the radius is negative or not finite, or arc_corners below 8.
    """
    if mission.fleet.entrances is not None:
        arc_corners = max(arc_corners, _ENTERED_ARC_CORNERS)
    space = standing_anywhere(mission, body_radius_m, arc_corners=arc_corners)
    return parts_entered(space, mission, body_radius_m, arc_corners=arc_corners)


def standing_anywhere(mission: Mission, body_radius_m: float, *, arc_corners: int = _ARC_CORNERS) -> MultiPolygon:
    """The same as ``standing_space``, with the parts that no entrance leads to."""
    if not (math.isfinite(body_radius_m) and body_radius_m >= 0):
        raise ValueError(f"body_radius_m: {body_radius_m!r} is not allowed; must be a finite number, 0 or more")
    if arc_corners < 8:
        raise ValueError(f"arc_corners: {arc_corners!r} is not allowed; must be 8 or more")
    blocking = tuple(obstacle.shape for obstacle in mission.obstacles if obstacle.blocks_motion)
    return _free_of(mission.area, blocking, body_radius_m, arc_corners)


@functools.lru_cache(maxsize=8)
def _free_of(
    area: MultiPolygon, blocking: tuple[MultiPolygon, ...], body_radius_m: float, arc_corners: int
) -> MultiPolygon:
    """The area without what blocks, eroded by the body; each setting up of one ground asks for the same again."""
    free = _polygons(area.difference(shapely.union_all(blocking)) if blocking else area)
    return _erode(free, body_radius_m, arc_corners)


def parts_entered(space: MultiPolygon, mission: Mission, body_radius_m: float, *, arc_corners: int) -> MultiPolygon:
    """The parts of a standing space that bodies come to from the fleet's entrances; all where it has none.

    An entrance leads to the part that holds it. Coarse arcs may keep the entrance itself out of the space, and so do
    walls that a body there touches; then it leads to the nearest parts, unless these are farther away than that
    explains.
    """
    if mission.fleet.entrances is None or space.is_empty:
        return space
    parts = shapely.get_parts(space)
    most_m = body_radius_m * (1 / math.cos(math.pi / arc_corners) - 1 + ENTRANCE_NEAR) + 2 * TOUCH_M
    doors = shapely.points(np.array(mission.fleet.entrances))
    nearest = shapely.STRtree(parts).query_nearest(doors, max_distance=most_m)[1]
    return MultiPolygon(list(parts[np.unique(nearest)]))


def standing_space_in(mission: Mission, body_radius_m: float, box: Box, *, arc_corners: int) -> MultiPolygon:
    """The part of ``standing_anywhere`` in a box, x0, y0, x1, y1 in metres, without the rest being worked out.

    May be empty or in parts.
    """
    wide = shapely.box(*grown_box(box, 2 * body_radius_m))
    blocking = [shapely.intersection(obstacle.shape, wide) for obstacle in mission.obstacles if obstacle.blocks_motion]
    free = _polygons(shapely.intersection(mission.area, wide).difference(shapely.union_all(blocking)))
    return clip(_erode(free, body_radius_m, arc_corners), box)


def _erode(free: MultiPolygon, body_radius_m: float, arc_corners: int) -> MultiPolygon:
    if body_radius_m == 0 or free.is_empty:
        return free
    return _polygons(free.difference(_band_inside(free, body_radius_m, arc_corners)))


def demanded_regions(mission: Mission) -> tuple[DemandedRegion, ...]:
    """What must be seen how often: a region per zone in the mission's order, then the rest of the area, named "area".

    Regions that must be seen point by point are disjoint: where zones overlap the smallest period rules, between equal
    ones the earlier zone. They are cut to the area and end at what blocks sight and at obstacles that ask nothing. A
    zone without a period asks nothing and takes its ground out of the rest. A zone to visit keeps all of itself that
    lies in the area, whatever overlaps it, and takes its ground out of the rest as well. Regions left empty are absent.
    """
    hiding = tuple(obstacle.shape for obstacle in mission.obstacles if obstacle.hides_demand)
    return _regions_of_demand(mission.area, hiding, mission.zones, mission.period_s)


@functools.lru_cache(maxsize=4)
def _regions_of_demand(
    area: MultiPolygon, hiding: tuple[MultiPolygon, ...], zones: tuple[Zone, ...], outside_s: float | None
) -> tuple[DemandedRegion, ...]:
    """The regions of ``demanded_regions``; the setting up of one search asks for them several times."""
    hidden = _polygons(shapely.union_all(hiding))
    shapes: dict[str, MultiPolygon] = {}
    taken: list[BaseGeometry] = [hidden]
    watched = [zone for zone in zones if zone.demand == "every_point" and zone.period_s is not None]
    for zone in sorted(watched, key=lambda zone: zone.period_s or 0.0):
        shapes[zone.name] = _polygons(zone.shape.intersection(area).difference(shapely.union_all(taken)))
        taken.append(zone.shape)
    for zone in zones:
        if zone.demand == "visit":
            shapes[zone.name] = _polygons(zone.shape.intersection(area))
    regions = [
        DemandedRegion(
            name=zone.name, period_s=zone.period_s, demand=zone.demand, shape=shapes[zone.name], sensors=zone.sensors
        )
        for zone in zones
        if zone.period_s is not None
    ]
    if outside_s is not None:
        outside_zones = shapely.union_all([hidden, *(zone.shape for zone in zones)]) if zones else hidden
        rest = _polygons(area.difference(outside_zones))
        regions.append(DemandedRegion(name=AREA, period_s=outside_s, demand="every_point", shape=rest))
    return tuple(region for region in regions if not region.shape.is_empty)


def sight_walls(mission: Mission) -> Floats:
    """The borders of all that blocks sight, (k, 4) metres x0, y0, x1, y1, with the obstacle on the left of each.

    Obstacles that overlap or share a border are one. (0, 4) when nothing blocks sight.
    """
    return border_segments(_sight_blockers(mission))


def border_segments(shape: MultiPolygon) -> Floats:
    """The border of a shape, (k, 4) metres x0, y0, x1, y1, with the shape on the left of each; (0, 4) when empty."""
    segments = [np.hstack([ring[:-1], ring[1:]]) for ring in _oriented_rings(shape)]
    return np.ascontiguousarray(np.vstack(segments)) if segments else np.zeros((0, 4))


def border_corners(shape: MultiPolygon, *, bend_m: float = 1e-12) -> tuple[Floats, Floats, Floats]:
    """The reflex corners of a shape (convex corners of obstacles) and the border corners before and after each.

    Three (n, 2) arrays in metres. A corner that stands out by no more than bend_m from the line between its
    neighbours counts as straight.
    """
    before, corner, after = [np.zeros((0, 2))], [np.zeros((0, 2))], [np.zeros((0, 2))]
    for ring in _oriented_rings(shape):
        corners = ring[:-1]
        back, ahead = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
        come, go, chord = corners - back, ahead - corners, ahead - back
        turn = come[:, 0] * go[:, 1] - come[:, 1] * go[:, 0]
        reflex = -turn > bend_m * np.hypot(chord[:, 0], chord[:, 1])
        before.append(back[reflex])
        corner.append(corners[reflex])
        after.append(ahead[reflex])
    return np.vstack(corner), np.vstack(before), np.vstack(after)


def nooks(shape: MultiPolygon, inset_m: float, *, per_side: int = 1, least_turn_rad: float = 0.1) -> Floats:
    """Points (n, 2) beside the border of a shape, in metres: some along each side, and one in each inner corner.

    They lie ``inset_m`` off the sides. per_side: each of so many equal parts of a side has one at its middle. Corners
    that turn by less than ``least_turn_rad`` count as straight.
    """
    shares = (np.arange(per_side) + 0.5)[:, None, None] / per_side
    found = [np.zeros((0, 2))]
    for ring in _oriented_rings(shape):
        side = np.diff(ring, axis=0)
        normal = np.column_stack([-side[:, 1], side[:, 0]]) / np.hypot(side[:, 0], side[:, 1])[:, None]
        before = np.roll(normal, 1, axis=0)
        cosine = (before * normal).sum(axis=1)
        turn = np.arctan2(before[:, 0] * normal[:, 1] - before[:, 1] * normal[:, 0], cosine)
        inner = (turn > least_turn_rad) & (turn < math.pi - least_turn_rad)
        off_both = (before + normal)[inner] / (1 + cosine[inner])[:, None]
        along = ring[:-1] + shares * side + inset_m * normal
        found += [along.reshape(-1, 2), ring[:-1][inner] + inset_m * off_both]
    return np.vstack(found)


def standing_parts(space: MultiPolygon) -> tuple[Polygon, ...]:
    """The parts of a space between which nobody can travel, largest first; parts that only touch are two."""
    return tuple(sorted(space.geoms, key=lambda part: -part.area))


def nearest_free_point(space: MultiPolygon, point_m: tuple[float, float]) -> tuple[float, float]:
    """The point of the closed space nearest to a point (metres); the point itself when it lies in it.

    Raises MissionError when the space is empty.
    """
    if space.is_empty:
        raise MissionError(f"point {tuple(point_m)}: no free point is near it, because there is no free space at all")
    point = Point(point_m)
    if space.covers(point):
        return (float(point.x), float(point.y))
    nearest = shapely.get_point(shapely.shortest_line(point, space), 1)
    return (float(nearest.x), float(nearest.y))


def _sight_blockers(mission: Mission) -> MultiPolygon:
    return _blocking_sight(mission.obstacles)


@functools.lru_cache(maxsize=4)
def _blocking_sight(obstacles: tuple[Obstacle, ...]) -> MultiPolygon:
    """What blocks sight as one shape; setting up one search asks for it three times."""
    return _polygons(shapely.union_all([obstacle.shape for obstacle in obstacles if obstacle.blocks_sight]))


def _polygons(shape: BaseGeometry) -> MultiPolygon:
    return polygons_of(shape, _SLIVER_M2)


def _oriented_rings(shape: MultiPolygon) -> list[Floats]:
    """Closed rings (k + 1, 2) with the shape on the left, without repeated points."""
    rings = []
    for part in shape.geoms:
        for number, ring in enumerate([part.exterior, *part.interiors]):
            points = shapely.get_coordinates(ring)
            points = points[np.r_[True, (points[1:] != points[:-1]).any(axis=1)]]
            rings.append(points if ring.is_ccw == (number == 0) else points[::-1])
    return rings


def _band_inside(free: MultiPolygon, width_m: float, arc_corners: int) -> BaseGeometry:
    """A union that holds every point of free closer than width_m to its border.

    Whichever border point is nearest to a point of the space lies inside an edge, or is a reflex corner: a rectangle
    on each edge and a sector at each reflex corner are therefore enough.
    """
    pieces: list[Polygon] = []
    for ring in _oriented_rings(free):
        step = np.diff(ring, axis=0)
        normal = np.column_stack([-step[:, 1], step[:, 0]]) / np.hypot(step[:, 0], step[:, 1])[:, None]
        shifted = width_m * normal
        corners = np.stack([ring[:-1], ring[1:], ring[1:] + shifted, ring[:-1] + shifted], axis=1)
        pieces.extend(shapely.polygons(corners))
        for k in range(len(step)):
            sector = _sector(ring[k], normal[k - 1], normal[k], width_m, arc_corners)
            if sector is not None:
                pieces.append(sector)
    return shapely.union_all(pieces)


def _sector(corner: Floats, before: Floats, after: Floats, radius_m: float, arc_corners: int) -> Polygon | None:
    """The sector between the normals of two edges, circumscribed about its arc; None where the border turns left."""
    turn = math.atan2(before[0] * after[1] - before[1] * after[0], before @ after)
    if turn >= 0:
        return None
    count = math.ceil(-turn * arc_corners / (2 * math.pi))
    angles = math.atan2(before[1], before[0]) + turn * (np.arange(count) + 0.5) / count
    arc = corner + radius_m / math.cos(turn / count / 2) * np.column_stack([np.cos(angles), np.sin(angles)])
    return Polygon(np.vstack([corner, corner + radius_m * before, arc, corner + radius_m * after]))
