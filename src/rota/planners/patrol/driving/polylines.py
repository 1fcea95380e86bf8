"""Closed polylines: their turns, and what of them can be timed."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from rota.model.arrays import Flags, Floats, Ints
from rota.planners.patrol.tolerances import HAIR_M

STRAIGHT_RAD = 1e-12  # a vertex that turns less is on a straight


def turns_rad(vertices_m: Floats) -> Floats:
    """Angle (n,) by which the direction changes at each vertex of a closed polyline; 0 for one vertex."""
    if len(vertices_m) < 2:
        return np.zeros(len(vertices_m))
    after = np.roll(vertices_m, -1, axis=0) - vertices_m
    before = np.roll(after, 1, axis=0)
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.asarray(np.abs(np.arctan2(cross, (before * after).sum(axis=1))))


def without_repeats(vertices_m: Floats) -> Floats:
    """The closed polyline without vertices that repeat the one before; at least one vertex stays."""
    return np.asarray(vertices_m[no_repeats(vertices_m)])


def no_repeats(vertices_m: Floats) -> Flags:
    """Which vertices (n,) of a closed polyline do not repeat the one before; one at least."""
    keep = (np.roll(vertices_m, 1, axis=0) != vertices_m).any(axis=1)
    if not keep[0]:  # the first vertex stays what it is: it may be where a nest's tours meet
        keep[np.flatnonzero(keep)[-1:]] = False
        keep[0] = True
    return np.asarray(keep)


def split_legs(vertices_m: Floats, longest_m: float) -> Floats:
    """The closed polyline with legs longer than ``longest_m`` cut into equal pieces."""
    ends = np.roll(vertices_m, -1, axis=0)
    legs = np.hypot(*(ends - vertices_m).T)
    pieces = np.maximum(1, np.ceil(legs / (longest_m * (1 - 1e-9)))).astype(np.int64)
    which = np.repeat(np.arange(len(vertices_m)), pieces)
    step = (np.arange(len(which)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[which]
    return np.asarray(vertices_m[which] + step[:, None] * (ends - vertices_m)[which])


def timeable(vertices_m: Floats) -> Floats:
    """The closed polyline without repeats and without legs too short to be timed; the first vertex stays."""
    return np.asarray(vertices_m[timeable_kept(vertices_m)])


def timeable_kept(vertices_m: Floats) -> Ints:
    """The numbers of the vertices that stay when a closed polyline is made timeable."""
    apart = np.flatnonzero(no_repeats(vertices_m))
    keep = far_enough(vertices_m[apart])
    while len(keep) > 1 and np.hypot(*(vertices_m[apart[keep[-1]]] - vertices_m[apart[0]])) < HAIR_M:
        keep.pop()
    return np.asarray(apart[keep], dtype=np.int64)


def far_enough(points_m: Floats) -> list[int]:
    """The numbers of the points (n, 2), from the first on, that end legs long enough to be timed."""
    if (np.hypot(*np.diff(points_m, axis=0).T) >= HAIR_M).all():
        return list(range(len(points_m)))
    keep = [0]
    for i in range(1, len(points_m)):
        if np.hypot(*(points_m[i] - points_m[keep[-1]])) >= HAIR_M:
            keep.append(i)
    return keep


def without_straight_vertices(vertices_m: Floats, straight_rad: float = STRAIGHT_RAD) -> Floats:
    """The closed polyline as it can be timed, without vertices that turn by at most ``straight_rad``."""
    return np.asarray(vertices_m[corners_kept(vertices_m, straight_rad)])


def corners_kept(vertices_m: Floats, straight_rad: float = STRAIGHT_RAD) -> Ints:
    """The numbers of the vertices that stay when a closed polyline is thinned."""
    kept = timeable_kept(vertices_m)
    bends = turns_rad(vertices_m[kept]) > straight_rad
    return kept[bends] if bends.sum() >= 2 else kept


def beside_legs(
    line_m: Floats, leg: Ints, vertices_m: Floats, straight_rad: float = STRAIGHT_RAD
) -> tuple[Floats, Floats]:
    """A line (m + 1, 2) cut so that each chord lies beside one leg of a closed polyline (n, 2), and beside what of it.

    leg (m,): of the polyline without its vertices along straights, counted from the first that stays. Returns the line
    (k + 1, 2) and, for each of its chords, from where to where it is beside the polyline, (k, 2) in legs. A part of a
    chord before its leg or beyond it counts as beside the leg's end.
    """
    corners, n = corners_kept(vertices_m, straight_rad), len(vertices_m)
    first = corners[leg % len(corners)]
    begin_m = vertices_m[first]
    along_m = vertices_m[np.append(corners, corners[0])[leg % len(corners) + 1]] - begin_m
    length_m = np.maximum(np.hypot(*along_m.T), 1e-12)
    lengths_m = np.hypot(*(np.roll(vertices_m, -1, axis=0) - vertices_m).T)
    gone_m = np.concatenate([[0.0], np.cumsum(np.tile(lengths_m, 2))])  # to each vertex, round after round

    def legs_at(places_m: Floats) -> Floats:
        on_m = np.clip(((places_m - begin_m) * along_m).sum(axis=1) / length_m, 0.0, length_m)
        return np.asarray(np.interp(gone_m[first] + on_m, gone_m, np.arange(len(gone_m), dtype=np.float64)))

    begin, end = legs_at(line_m[:-1]), legs_at(line_m[1:])
    inside = np.maximum(np.ceil(end - 1e-9) - np.floor(begin + 1e-9) - 1, 0).astype(np.int64)  # vertices on its way
    which = np.repeat(np.arange(len(leg)), inside + 1)
    number = np.arange(len(which)) - np.repeat(np.cumsum(inside + 1) - inside - 1, inside + 1)
    here = np.where(number == 0, begin[which], np.floor(begin[which] + 1e-9) + number)
    there = np.where(number == inside[which], end[which], np.floor(begin[which] + 1e-9) + number + 1)
    share = (here - begin[which]) / np.maximum(end - begin, 1e-12)[which]
    cut_m = line_m[which] + share[:, None] * (line_m[which + 1] - line_m[which])
    turns = n * (np.floor((here + there) / 2) >= n)
    return np.vstack([cut_m, line_m[-1:]]), np.column_stack([here - turns, np.maximum(here, there) - turns])


def way_beside(
    vertices_m: Floats, rows_of: Callable[[Floats], Floats], straight_rad: float = STRAIGHT_RAD
) -> tuple[Floats, Floats]:
    """A round past the corners of a closed polyline (n, 2), and beside what of it that is; see ``beside_legs``.

    rows_of: of the corners (k, 2), k > 1, the rows (m, 5) of the round: seconds, x, y, acceleration, and the leg.
    """
    corners_m = without_straight_vertices(vertices_m, straight_rad)
    if len(corners_m) == 1:
        return corners_m, np.zeros((0, 2))
    rows = rows_of(corners_m)
    return beside_legs(rows[:, 1:3], rows[1:, 4].astype(np.int64), vertices_m, straight_rad)


def keeps_radius(vertices_m: Floats, radius_m: float) -> bool:
    """Whether a closed polyline (n, 2) is driven on arcs of the radius or more: its legs touch such arcs.

    As ``check.turning`` asks: a curve is no farther than radius / 200 off, and what corners take of a leg fits on it.
    """
    corners_m = without_straight_vertices(vertices_m, 1e-7)  # legs whose directions differ by less are one
    turns = turns_rad(corners_m)
    if len(corners_m) < 3 or turns.max() > 2 * math.acos(1 / (1 + 1 / 200)):
        return False
    taken_m = radius_m * np.tan(turns / 2)
    lengths_m = np.hypot(*(np.roll(corners_m, -1, axis=0) - corners_m).T)
    return bool((taken_m + np.roll(taken_m, -1) <= lengths_m).all())
