"""Pieces of way that robots with wide turns drive as they are: lanes that leave room to turn, and rings at the border.

A piece is a polyline (k, 2) of legs that touch arcs of the turn radius or more, driven from either end.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import shapely
from shapely import LineString, MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from rota.model.arrays import Flags, Floats
from rota.planners.patrol.methods.sweeping.lanes import (
    Swath,
    ground_turned,
    lane_ends,
    polygons,
    slab,
    straight_pieces,
    strips,
    turn_shape,
    turning,
)
from rota.planners.patrol.tours.curve_kernels import STEP_RAD

OUTSIDE = 1 / math.cos(STEP_RAD / 2)  # radii from the middle of an arc to the corners of the legs that touch it
SHORTEST = 0.1  # radii: shorter pieces are left out


def lanes_with_room(ground: BaseGeometry, space: BaseGeometry, swath: Swath, radius_m: float) -> Iterator[Floats]:
    """Lanes (2, 2) over the ground at the swath's angle, that end where a robot can still turn to one side.

    There a whole circle of the radius that touches the lane lies in the space, on its left or on its right. Lanes on
    which that is nowhere so are left out.
    """
    if ground.is_empty:
        return
    upright, room = ground_turned(ground, -swath.angle_rad), turn_shape(space, -swath.angle_rad)
    middles = shapely.buffer(room, -radius_m * OUTSIDE, join_style="mitre")
    heights_m, lanes_m = strips(upright, 2 * swath.half_m)
    back = turning(swath.angle_rad)
    for k, height_m in enumerate(lanes_m):
        parts = slab(upright, heights_m[k], heights_m[k + 1])
        if not parts:
            continue
        first_m, last_m = lane_ends(MultiPolygon(parts), height_m, swath)
        beside = [
            straight_pieces(middles, height_m + side * radius_m, first_m - radius_m, last_m + radius_m)
            for side in (-1, 1)
        ]
        turns = [(piece[0, 0], piece[-1, 0]) for pieces in beside for piece in pieces]
        for piece in straight_pieces(room, height_m, first_m - radius_m, last_m + radius_m):
            here = [
                (max(a, piece[0, 0]), min(b, piece[-1, 0])) for a, b in turns if b > piece[0, 0] and a < piece[-1, 0]
            ]
            if not here:
                continue
            begins, ends = max(first_m, min(a for a, _ in here)), min(last_m, max(b for _, b in here))
            if ends - begins > SHORTEST * radius_m:
                yield np.array([[begins, height_m], [ends, height_m]]) @ back


def rings(space: BaseGeometry, depth_m: float, radius_m: float) -> Iterator[Floats]:
    """What can be driven of the lines so far inside the outer borders of the space, their corners cut by arcs.

    Rings are cut in the middle of their straights, and end before corners that turn outwards.
    """
    middles = shapely.buffer(space, -(depth_m + radius_m * OUTSIDE), join_style="mitre")
    for part in polygons(middles):
        yield from pieces_round(part, radius_m)


def pieces_round(middles: Polygon, radius_m: float) -> Iterator[Floats]:
    """The pieces of a way that keeps the radius from a polygon, on its outside and anticlockwise.

    It begins in the middle of a leg that is cut, and comes to that again.
    """
    ring = shapely.get_coordinates(shapely.remove_repeated_points(shapely.orient_polygons(middles).exterior, 1e-6))[:-1]
    legs = np.roll(ring, -1, axis=0) - ring
    lengths_m = np.hypot(*legs.T)
    along = legs / lengths_m[:, None]
    before = np.roll(along, 1, axis=0)
    turns = np.arctan2(before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0], (before * along).sum(axis=1))
    across = np.column_stack([along[:, 1], -along[:, 0]])
    cuts = cut_legs(lengths_m, turns, radius_m)
    n, first = len(ring), int(np.argmax(cuts))
    way: list[Floats] = []
    for i in range(first, first + n + 1):
        k, after = i % n, (i + 1) % n
        begin_m, end_m = ring[k] + radius_m * across[k], ring[after] + radius_m * across[k]
        # a corner that turns outwards is passed by an arc that other pieces make
        begin_m = begin_m + short_m(turns[k], radius_m, lengths_m[k]) * along[k]
        end_m = end_m - short_m(turns[after], radius_m, lengths_m[k]) * along[k]
        if turns[k] < 0 or i == first:
            way = [begin_m]
        if cuts[k]:
            middle_m = (begin_m + end_m) / 2
            if i > first:
                yield from long_enough([*way, middle_m], radius_m)
            way = [middle_m]
        if i == first + n:
            return
        if turns[after] < 0:
            yield from long_enough([*way, end_m], radius_m)
            way = []
        else:
            way += [end_m, *arc_corners(ring[after], across[k], turns[after], radius_m)]
            way += [ring[after] + radius_m * across[after]]


def cut_legs(lengths_m: Floats, turns: Floats, radius_m: float) -> Flags:
    """Which legs (n,) of a ring are cut in their middle: those as long as the radius, or the longest."""
    straight = np.where(np.minimum(turns, np.roll(turns, -1)) < 0, 0.0, lengths_m)
    return np.asarray((straight >= radius_m) | (np.arange(len(straight)) == np.argmax(straight)))


def short_m(turn: float, radius_m: float, most_m: float) -> float:
    """Metres that a leg ends before a corner that turns outwards; none before others."""
    return min(2 * radius_m * math.tan(min(-turn, 2.0) / 2), most_m / 2) if turn < 0 else 0.0


def arc_corners(middle_m: Floats, from_across: Floats, turn: float, radius_m: float) -> list[Floats]:
    """The corners (2,) of the legs that touch an arc to the left round a place, from that side of it on."""
    steps = math.ceil(turn / STEP_RAD - 1e-9)
    if steps == 0:
        return []
    angles = math.atan2(from_across[1], from_across[0]) + turn * (np.arange(steps) + 0.5) / steps
    out_m = radius_m / math.cos(turn / steps / 2)
    return [middle_m + out_m * np.array([math.cos(angle), math.sin(angle)]) for angle in angles]


def long_enough(way: list[Floats], radius_m: float) -> Iterator[Floats]:
    """The way as a polyline without vertices that repeat, if it is long enough for a piece."""
    line = np.array(way)
    line = line[np.r_[True, np.hypot(*np.diff(line, axis=0).T) > 1e-6]]
    if len(line) > 1 and LineString(line).length > SHORTEST * radius_m:
        yield line


def parts_near(piece: Floats, ground: BaseGeometry, half_m: float, radius_m: float) -> Iterator[Floats]:
    """What of a piece sees the ground, from the first place to the last; it ends on straights or where arcs touch."""
    line = LineString(piece)
    near = shapely.intersection(line, ground.buffer(half_m))
    if near.is_empty:
        return
    at = [line.project(shapely.Point(xy)) for xy in shapely.get_coordinates(near)]
    gone_m = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(piece, axis=0).T))])
    first, last = touching(min(at), gone_m, radius_m, -1), touching(max(at), gone_m, radius_m, 1)
    inner = piece[(gone_m > first + 1e-6) & (gone_m < last - 1e-6)]
    ends = [np.asarray(line.interpolate(where).coords[0]) for where in (first, last)]
    yield from long_enough([ends[0], *inner, ends[1]], radius_m)


def touching(at_m: float, gone_m: Floats, radius_m: float, way: int) -> float:
    """Where a piece may end, so far along it or a little further that way; gone_m (k,): to its vertices."""
    leg = int(np.clip(np.searchsorted(gone_m, at_m, side="right") - 1, 0, len(gone_m) - 2))
    while 0 <= leg < len(gone_m) - 1:
        begin, end = gone_m[leg], gone_m[leg + 1]
        if end - begin > 2 * radius_m * math.tan(STEP_RAD / 2) * 1.001:
            return float(np.clip(at_m, begin, end))
        middle = (begin + end) / 2
        if (middle - at_m) * way >= 0:
            return float(middle)
        leg += way
    return float(gone_m[0] if way < 0 else gone_m[-1])
