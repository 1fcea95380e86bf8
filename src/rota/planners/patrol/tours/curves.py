"""Tours as robots with a turn radius drive them: curves past the vertices, as closed polylines of short legs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import replace

import numpy as np
import shapely

from rota.geometry.kernels import EdgeGrid, free_segments, points_in_space
from rota.model.arrays import Floats, Ints
from rota.planners.patrol.driving.polylines import keeps_radius, timeable
from rota.planners.patrol.tolerances import HAIR_M, TO_SPARE
from rota.planners.patrol.tours.curve_kernels import (
    BLOCKED_M,
    STEP_RAD,
    Leg,
    chosen_headings,
    curve_corners,
    look_for_walls,
    shortest_words,
)
from rota.planners.patrol.tours.tour import Tour


def _never() -> bool:
    return False


def curve_tours(tours: Sequence[Tour], grid: EdgeGrid, should_stop: Callable[[], bool] = _never) -> list[Tour]:
    """The tours as their robots drive them in the space of the grid; the same tours where robots turn on the spot.

    So are tours that keep the radius as they are. Curves may leave the space where the search is to stop.
    """
    return [
        tour
        if tour.robot.turn_radius_m == 0 or keeps_radius(tour.vertices_m, tour.robot.turn_radius_m)
        else replace(tour, vertices_m=closed_curve(tour.vertices_m, tour.robot.turn_radius_m, grid, should_stop))
        for tour in tours
    ]


def closed_curve(
    vertices_m: Floats, radius_m: float, grid: EdgeGrid, should_stop: Callable[[], bool] = _never
) -> Floats:
    """A closed curve past the vertices (n, 2) with no arc tighter than the radius, as corners (m, 2) of straight legs.

    The shortest of those that pass each vertex in one of 26 headings and stay in the space. Where none does, vertices
    are moved by up to the radius or left out, as far as that helps. One vertex is gone round, or stood at where there
    is no room to go round it.
    """
    curve = _Curve(timeable(vertices_m), radius_m * (1 + TO_SPARE), grid, closed=True)
    for _ in range(2 * len(vertices_m)):
        eased = curve.ease() if len(curve.points_m) > 1 and not should_stop() else None
        if eased is None:
            break
        curve = eased
    if len(curve.points_m) == 1:
        return _circle(curve.points_m[0], radius_m * (1 + TO_SPARE), grid)
    return curve.corners_m()[1:-1]


def approach_curve(
    line_m: Floats, radius_m: float, grid: EdgeGrid, onward_m: Floats | None, heading_rad: float | None = None
) -> Floats:
    """A curve (m, 2) past the points (n, 2) of an open line, which begins in any heading, with no tighter arc.

    onward_m: (2,), to where it goes on from the last point; it ends in that direction. None: in any. heading_rad: it
    begins in.
    """
    line_m = line_m[np.r_[True, (np.diff(line_m, axis=0) != 0).any(axis=1)]]
    if len(line_m) == 1:
        return line_m
    curve = _Curve(line_m, radius_m * (1 + TO_SPARE), grid, closed=False)
    if onward_m is not None:
        curve.end_towards(onward_m)
    if heading_rad is not None:
        curve.begin_towards(heading_rad)
        return curve.corners_m()
    for _ in range(4):  # an approach may begin with any heading
        curve.begin_straight()
    return curve.corners_m()


class _Curve:
    """The shortest curve past points (n, 2), closed or open, by one of the headings (n, 26) of each point."""

    def __init__(self, points_m: Floats, radius_m: float, grid: EdgeGrid, *, closed: bool) -> None:
        self.points_m = points_m
        self._radius_m, self._grid, self._closed = radius_m, grid, closed
        if len(points_m) == 1:
            return
        self._headings = _headings(points_m, _directions(points_m, closed), grid)
        legs, h = len(points_m) - (not closed), self._headings.shape[1]
        self._lengths, self._words = np.zeros((legs, h, h)), np.zeros((legs, h, h), dtype=np.int64)
        self._looked = np.zeros(legs, dtype=np.bool_)
        for k in range(legs):
            self._measure(k)

    def end_towards(self, onward_m: Floats) -> None:
        """Let an open curve end in the direction of a place (2,)."""
        ahead = onward_m - self.points_m[-1]
        self._headings[-1] = np.arctan2(ahead[1], ahead[0])
        self._measure(len(self._lengths) - 1)

    def begin_towards(self, heading_rad: float) -> None:
        """Let an open curve begin in a heading."""
        self._headings[0] = heading_rad
        self._measure(0)

    def begin_straight(self) -> None:
        """Turn the chosen heading at the first point to where the first arc ends, unless that makes the way longer.

        The tangent to the next arc is approached quadratically; what is left of the first arc is soon no turn at all.
        """
        chosen = self._solve()[2]
        corners = self.corners_m()[1:3]
        if len(corners) < 2:
            return
        before_m, h = self._length_m(), int(chosen[0])
        kept, self._headings = self._headings, self._headings.copy()
        self._headings[0, h] = math.atan2(*(corners[1] - corners[0])[::-1])
        self._measure(0)
        if self._length_m() > before_m + HAIR_M:
            self._headings = kept
            self._measure(0)

    def corners_m(self) -> Floats:
        """The corners (m, 2) of its legs, both ends among them."""
        points, headings, chosen = self._solve()
        driven = headings[np.arange(len(chosen)), chosen]
        words = self._words[np.arange(len(chosen) - 1), chosen[:-1], chosen[1:]]
        return np.asarray(curve_corners(points, driven, words, self._radius_m))

    def ease(self) -> _Curve | None:
        """A closed curve with one point moved or left out, whose legs meet fewer walls; None where none is better."""
        blocked = self._legs_into_walls()
        if not len(blocked):
            return None
        n, k = len(self.points_m), int(blocked[0])
        angles = np.arange(8) * (math.pi / 4)
        around = np.column_stack([np.cos(angles), np.sin(angles)]) * self._radius_m
        options: list[_Curve] = []
        for v in (k, (k + 1) % n):
            others = np.delete(self.points_m, v, axis=0)
            options.append(_Curve(timeable(others), self._radius_m, self._grid, closed=True))
            moved_m = self.points_m[v] + np.vstack([around / 2, around])
            for place_m in moved_m[points_in_space(moved_m, self._grid)]:
                options.append(self._with_point(v, place_m))
        fewest = min(options, key=lambda option: option._length_m())
        return fewest if fewest._length_m() < self._length_m() - BLOCKED_M / 2 else None

    def _with_point(self, v: int, place_m: Floats) -> _Curve:
        """The closed curve with one point elsewhere; all legs but two are as they were."""
        other = copy(self)
        n = len(self.points_m)
        other.points_m = self.points_m.copy()
        other.points_m[v] = place_m
        other._headings = self._headings.copy()
        near = _mean_directions(*other.points_m[[(v - 1) % n, v, (v + 1) % n], None])
        other._headings[v] = _headings(place_m[None], near, self._grid)[0]
        other._lengths, other._words, other._looked = self._lengths.copy(), self._words.copy(), self._looked.copy()
        for k in {(v - 1) % n, v}:
            other._measure(k)
        return other

    def _measure(self, k: int) -> None:
        """The lengths of leg k by all headings, whatever is in the way."""
        n = len(self.points_m)
        after = (k + 1) % n
        leg = Leg(self.points_m[k], self.points_m[after], self._headings[k], self._headings[after])
        shortest_words(leg, self._radius_m, self._grid, False, self._lengths[k], self._words[k])
        self._looked[k] = False

    def _solve(self) -> tuple[Floats, Floats, Ints]:
        """Its points (k, 2) from end to end, their headings (k, 26), and which of these are best (k,)."""
        ring = np.arange(len(self.points_m) + self._closed) % len(self.points_m)
        points, headings = self.points_m[ring], self._headings[ring]
        while True:
            chosen = chosen_headings(self._lengths, self._closed)
            if not look_for_walls(
                points, headings, chosen, self._radius_m, self._grid, self._lengths, self._words, self._looked
            ):
                return points, headings, chosen

    def _driven_m(self) -> Floats:
        """The lengths of its legs; of those that meet walls BLOCKED_M more."""
        if len(self.points_m) == 1:
            return np.zeros(1)
        chosen = self._solve()[2]
        return np.asarray(self._lengths[np.arange(len(chosen) - 1), chosen[:-1], chosen[1:]])

    def _length_m(self) -> float:
        return float(self._driven_m().sum())

    def _legs_into_walls(self) -> Ints:
        """The legs that meet walls, whatever the headings."""
        return np.flatnonzero(self._driven_m() >= BLOCKED_M)


def _directions(points_m: Floats, closed: bool) -> Floats:
    """Directions (n, 2) in which points (n, 2) are passed: half way between those of the legs, of the leg at an end."""
    if closed:
        return _mean_directions(np.roll(points_m, 1, axis=0), points_m, np.roll(points_m, -1, axis=0))
    steps = np.diff(points_m, axis=0)
    return np.vstack([steps[:1], _mean_directions(points_m[:-2], points_m[1:-1], points_m[2:]), steps[-1:]])


def _mean_directions(before_m: Floats, at_m: Floats, after_m: Floats) -> Floats:
    """Directions (n, 2) half way between both legs' at points (n, 2); across the legs where one leads straight back."""
    into, out = at_m - before_m, after_m - at_m
    out = out / np.hypot(*out.T)[:, None]
    mean = out + into / np.hypot(*into.T)[:, None]
    turns_back = np.hypot(*mean.T) < 1e-9
    mean[turns_back] = np.column_stack([-out[turns_back, 1], out[turns_back, 0]])
    return np.asarray(mean)


def _headings(points_m: Floats, directions: Floats, grid: EdgeGrid) -> Floats:
    """Headings (n, 26) at points (n, 2): evenly round from one of the directions (n, 2), and along the nearest wall.

    Right beside a wall no other heading leaves room for an arc.
    """
    first = np.arctan2(directions[:, 1], directions[:, 0])
    evenly = first[:, None] + np.arange(24) * (2 * math.pi / 24)
    if not len(grid.edges):
        return np.asarray(evenly)
    walls = shapely.linestrings(grid.edges.reshape(-1, 2, 2))
    nearest = grid.edges[shapely.STRtree(walls).nearest(shapely.points(points_m))]
    along = np.arctan2(nearest[:, 3] - nearest[:, 1], nearest[:, 2] - nearest[:, 0])
    return np.column_stack([evenly, along, along + math.pi])


def _circle(centre_m: Floats, radius_m: float, grid: EdgeGrid) -> Floats:
    """A circle's corners (32, 2) round a place; the place alone where the circle leaves the space."""
    angles = np.arange(0, 2 * math.pi - STEP_RAD / 2, STEP_RAD)
    corners = centre_m + radius_m / math.cos(STEP_RAD / 2) * np.column_stack([np.cos(angles), np.sin(angles)])
    stays = not free_segments(corners, np.roll(corners, -1, axis=0), grid).all()
    return centre_m[None] if stays else corners
