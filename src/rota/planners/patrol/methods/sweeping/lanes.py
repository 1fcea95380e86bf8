"""Lanes over a shape at one angle: strips no wider than the swath, cut where obstacles or borders cut them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
import shapely
from shapely import LineString, MultiPolygon, Point, Polygon
from shapely.geometry.base import BaseGeometry

from rota.errors import PlanError
from rota.geometry.free_space import nearest_free_point
from rota.geometry.shortest_path import ShortestPaths
from rota.model.arrays import Floats
from rota.model.mission import DiscSensor, Sensor
from rota.model.polygons import polygons_of
from rota.planners.patrol.tolerances import BESIDE_M, HAIR_M, ON_LINE_M, SAME_PLACE_M, SLIVER_M2

FEW_CORNERS = 100  # of a shape: with more it is halved before it is cut into slabs, each of which costs all corners


@dataclass(frozen=True, kw_only=True)
class Swath:
    """What a robot sees while it moves along a lane. The lane's frame has x along the lane, y across it.

    sensor: the footprint, taken ``margin_m`` shorter on all sides. angle_rad: of the lane, against x of the plane.
    """

    sensor: Sensor
    angle_rad: float
    margin_m: float = 0.0

    @property
    def half_m(self) -> float:
        """Half the width of the swath: the radius; of a square half its width as seen along the lane."""
        if isinstance(self.sensor, DiscSensor):
            return self.sensor.radius_m - self.margin_m
        half_m = self.sensor.side_m / 2 - self.margin_m
        return half_m * (abs(math.cos(self.angle_rad)) + abs(math.sin(self.angle_rad)))

    def chords_m(self, offset_m: Floats) -> tuple[Floats, Floats]:
        """How far (n,) behind and ahead of the robot it sees at offsets (n,) from the lane; offsets beyond are cut."""
        offset_m = np.clip(offset_m, -self.half_m, self.half_m)
        if isinstance(self.sensor, DiscSensor):
            chord = np.sqrt(np.maximum(self.half_m**2 - offset_m**2, 0.0))
            return -chord, chord
        half_m = self.sensor.side_m / 2 - self.margin_m
        behind, ahead = np.full(len(offset_m), -np.inf), np.full(len(offset_m), np.inf)
        cos, sin = math.cos(self.angle_rad), math.sin(self.angle_rad)
        # |x cos - y sin| and |x sin + y cos| are at most half the side
        for along, across in ((cos, -sin), (sin, cos)):
            if abs(along) > 1e-12:
                ends = np.array([-half_m - across * offset_m, half_m - across * offset_m]) / along
                behind, ahead = np.maximum(behind, ends.min(axis=0)), np.minimum(ahead, ends.max(axis=0))
        middle = (behind + ahead) / 2  # at the very rim rounding may swap them
        return np.minimum(behind, middle), np.maximum(ahead, middle)


def turn_shape(shape: BaseGeometry, angle_rad: float) -> BaseGeometry:
    """The shape turned about the origin."""
    turn = turning(angle_rad)
    return shapely.transform(shape, lambda xy: xy @ turn)


def ground_turned(shape: BaseGeometry, angle_rad: float) -> BaseGeometry:
    """Ground turned about the origin, its corners moved onto a grid so fine that it stays valid whatever the angle."""
    return off_grid(shapely.set_precision(turn_shape(shape, angle_rad), ON_LINE_M))


def off_grid(shape: BaseGeometry) -> BaseGeometry:
    """The same shape without the grid it was made on, which would be handed on to all that is cut from it."""
    return shapely.set_precision(shape, 0.0)


def common_part(one: BaseGeometry, other: BaseGeometry) -> BaseGeometry:
    """What two shapes have in common, exactly where exact arithmetic on their corners succeeds."""
    try:
        return shapely.intersection(one, other)
    except shapely.GEOSException:
        # borders that nearly coincide, or cross themselves by rounding: corners within what counts as touching
        valid = shapely.make_valid(np.array([one, other]), method="structure", keep_collapsed=False)
        return off_grid(shapely.intersection(*valid, grid_size=SAME_PLACE_M))


def turning(angle_rad: float) -> Floats:
    """The matrix (2, 2) that turns rows of points from the right: ``xy @ turning(angle)``."""
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[cos, sin], [-sin, cos]])


def polygons(shape: BaseGeometry) -> list[Polygon]:
    """The polygons of a shape that have an area to speak of."""
    return list(polygons_of(off_grid(shape), SLIVER_M2).geoms)


def slab(shape: BaseGeometry, low_m: float, high_m: float) -> list[Polygon]:
    """The parts of a shape between two heights, from left to right."""
    if shape.is_empty:
        return []
    left, _, right, _ = shape.bounds
    cut = shapely.intersection(shape, shapely.box(left - 1, low_m, right + 1, high_m), grid_size=ON_LINE_M)
    parts = polygons(cut)
    return sorted(parts, key=lambda part: part.bounds)


def slabs(shape: BaseGeometry, heights_m: list[float]) -> list[list[Polygon]]:
    """The ``slab`` between each of the heights, which rise, and the next: one fewer than heights."""
    if len(heights_m) == 2 or shapely.get_num_coordinates(shape) <= FEW_CORNERS:
        return [slab(shape, low, high) for low, high in pairwise(heights_m)]
    middle = len(heights_m) // 2
    below = MultiPolygon(slab(shape, heights_m[0], heights_m[middle]))
    above = MultiPolygon(slab(shape, heights_m[middle], heights_m[-1]))
    return slabs(below, heights_m[: middle + 1]) + slabs(above, heights_m[middle:])


def bands(space: BaseGeometry, heights_m: list[float]) -> list[BaseGeometry]:
    """For each of the heights and the next a part of the space that holds all of it between them, with few corners."""
    if len(heights_m) == 2 or shapely.get_num_coordinates(space) <= FEW_CORNERS:
        return [space] * (len(heights_m) - 1)
    middle = len(heights_m) // 2
    left, _, right, _ = space.bounds
    found: list[BaseGeometry] = []
    for part in (heights_m[: middle + 1], heights_m[middle:]):
        box = shapely.box(left - 1, part[0] - BESIDE_M, right + 1, part[-1] + BESIDE_M)
        found += bands(common_part(space, box), part)
    return found


def strips(shape: BaseGeometry, width_m: float) -> tuple[list[float], list[float]]:
    """Heights that part a shape into equal strips no wider than ``width_m``, and those of the strips' middles."""
    _, low, _, high = shape.bounds
    count = max(1, math.ceil((high - low) / width_m - 1e-9))
    step = (high - low) / count
    return [low + k * step for k in range(count + 1)], [low + (k + 0.5) * step for k in range(count)]


def shared_m(one: Polygon, other: Polygon) -> float:
    """Length of the border that two parts of neighbouring slabs share."""
    return float(shapely.intersection(one, other, grid_size=ON_LINE_M).length)


@lru_cache(maxsize=1024)  # more than half of what decompositions ask was asked before, for other cuts or robots
def lanes_in(shape: BaseGeometry, space: MultiPolygon, swath: Swath) -> tuple[Floats, ...]:
    """Lanes, polylines (k, 2) in metres, k = 1 or more, from which all of the shape is seen, bar what is hidden.

    shape: the ground; space: where robots can be; both in the plane. A lane stops where its end is just seen, runs
    along obstacles that reach into its strip, and is left out where no robot can be in its strip. Lanes come in the
    order of their strips.
    """
    ground, room = ground_turned(shape, -swath.angle_rad), turn_shape(space, -swath.angle_rad)
    if ground.is_empty:
        return ()
    left, low, right, high = ground.bounds
    reach_m = 2 * swath.sensor.reach_m
    near = common_part(room, shapely.box(left - reach_m, low - reach_m, right + reach_m, high + reach_m))
    back = turning(swath.angle_rad)
    heights_m, middles_m = strips(ground, 2 * swath.half_m)
    lanes: list[Floats] = []
    for parts, middle_m, band in zip(slabs(ground, heights_m), middles_m, bands(near, heights_m), strict=True):
        shapely.prepare(band)
        for part in parts:
            lanes += [lane @ back for lane in lanes_of_strip(part, middle_m, band, swath)]
    for lane in lanes:
        lane.flags.writeable = False  # others are given the same
    return tuple(lanes)


def lanes_of_strip(part: Polygon, middle_m: float, space: BaseGeometry, swath: Swath) -> list[Floats]:
    """The lanes (k, 2) that see one part of a strip, in the lane's frame; several when no way in it joins them."""
    first_m, last_m = lane_ends(part, middle_m, swath)
    pieces = straight_pieces(space, middle_m, first_m, last_m)
    if len(pieces) == 1 and pieces[0][0, 0] <= first_m + HAIR_M and pieces[0][-1, 0] >= last_m - HAIR_M:
        return pieces
    # edges of rounding length would turn what is no corner into one, and block the way past it
    parts = polygons(common_part(part, space))
    room = MultiPolygon([shapely.remove_repeated_points(one, SAME_PLACE_M) for one in parts])
    if not pieces:
        if room.is_empty:
            return []
        middle_m = within(middle_m, room.bounds[1], room.bounds[3])
        first_m, last_m = lane_ends(part, middle_m, swath)
        pieces = straight_pieces(space, middle_m, first_m, last_m)
    if not pieces:
        return [np.array([nearest_free_point(room, ((first_m + last_m) / 2, middle_m))])]
    if not room.is_empty:
        # where the middle of the strip is blocked before its end, go on as near to that end as can be
        if pieces[0][0, 0] > first_m + HAIR_M:
            pieces.insert(0, np.array([nearest_free_point(room, (first_m, middle_m))]))
        if pieces[-1][-1, 0] < last_m - HAIR_M:
            pieces.append(np.array([nearest_free_point(room, (last_m, middle_m))]))
    return join_within(room, pieces)


def within(value: float, low: float, high: float) -> float:
    """The value, moved into the stretch between low and high and a little off its ends."""
    nudge = min(ON_LINE_M, (high - low) / 2)
    return min(max(value, low + nudge), high - nudge)


def lane_ends(part: BaseGeometry, height_m: float, swath: Swath) -> tuple[float, float]:
    """Where a straight lane at this height must begin and end to see all of the part; the same where one place does.

    Exact: along an edge of the part the place from which its point is just seen is a concave (convex) function, since
    the footprint is convex, so that the corners decide.
    """
    xy = shapely.get_coordinates(part)
    behind, ahead = swath.chords_m(xy[:, 1] - height_m)
    first, last = float((xy[:, 0] - behind).min()), float((xy[:, 0] - ahead).max())
    return (first, last) if first < last else ((first + last) / 2, (first + last) / 2)


def straight_pieces(space: BaseGeometry, height_m: float, first_m: float, last_m: float) -> list[Floats]:
    """The stretches (2, 2), or one place (1, 2), of a straight lane that lie in the space, from left to right."""
    if first_m == last_m:
        return [np.array([[first_m, height_m]])] if space.covers(Point(first_m, height_m)) else []
    cut = common_part(LineString([(first_m, height_m), (last_m, height_m)]), space)
    cut = shapely.line_merge(cut) if cut.geom_type == "MultiLineString" else cut
    pieces = [shapely.get_coordinates(line) for line in shapely.get_parts(cut) if line.length > 1e-9]
    return sorted((line if line[0, 0] <= line[-1, 0] else line[::-1] for line in pieces), key=lambda line: line[0, 0])


def join_within(room: MultiPolygon, pieces: list[Floats]) -> list[Floats]:
    """The pieces of a lane joined by the shortest ways inside their strip; apart where there is no such way."""
    if len(pieces) < 2:
        return pieces
    paths = ShortestPaths(room)
    joined = [pieces[0]]
    for piece in pieces[1:]:
        try:
            between = paths.path(joined[-1][-1], piece[0])
        except PlanError:
            joined.append(piece)
        else:
            joined[-1] = np.vstack([joined[-1], between[1:-1], piece])
    return joined
