"""When each place was last seen, from what robots said of where they were."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rota.geometry.free_space import border_segments, sight_walls
from rota.geometry.line_of_sight import edge_grid
from rota.live import age_kernels
from rota.live.places import Places, sort_in_bins
from rota.model.fleet import DiscSensor, Robot, inner_reach_m
from rota.model.mission import Mission

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Place = tuple[float, float, float]

FASTER, FREE_REACHES = 1.5, 0.25  # a robot may have gone so many times as far as it can, and a part of its reach


def is_jump(robot: Robot, before: Place, after: Place, time_s: float) -> bool:
    """Whether a robot cannot have gone a way in a time: half as fast again, and noise, are let pass."""
    way_m = float(np.hypot(after[0] - before[0], after[1] - before[1]))
    return way_m > FASTER * robot.speed_m_s * time_s + FREE_REACHES * inner_reach_m(robot.sensor)


class Ages:
    """The moment at which each place was last seen, exact up to ``known_s``, the moment up to which all has been told.

    last_seen_s: (n,) as ``places`` has them. worst_s, worst_place: (demands,) the longest gap that has ended, and
    where; 0 and -1 before there is one. ``drive`` takes what a robot drove, ``settle`` looks what was seen on the way.
    """

    def __init__(self, mission: Mission, places: Places) -> None:
        self.places = places
        self.known_s = 0.0
        count = len(places.points_m)
        self.last_seen_s = np.zeros(count)
        self.worst_s, self.worst_place = _none_yet(len(places.demands))
        self._first_s, self._last_s = np.full(count, np.inf), np.full(count, -np.inf)
        robots = mission.fleet.unlike_robots
        self._points_m = np.ascontiguousarray(places.points_m[: places.points])
        self._grid, self._near = sort_in_bins(self._points_m, max(inner_reach_m(robot.sensor) for robot in robots))
        self._walls = edge_grid(sight_walls(mission))
        visits = [demand for demand in places.demands if demand.demand == "visit"]
        self._zones = [edge_grid(border_segments(demand.region)) for demand in visits]
        self._rows: list[list[float]] = []

    def begin(self, time_s: float) -> None:
        """Count ages from this moment on: what was seen before is not known."""
        self.last_seen_s[:] = time_s
        self.known_s = time_s

    def drive(self, robot: Robot, before: Place, from_s: float, after: Place, to_s: float) -> None:
        """A robot drove straight from one place (x, y, height) to another; the same place and time: it was there."""
        sensor = robot.sensor
        reach_m = inner_reach_m(sensor)
        if isinstance(sensor, DiscSensor):
            reach_m = sensor.radius_at_m(min(before[2], after[2]))
        square = float(not isinstance(sensor, DiscSensor))
        self._rows.append([*before[:2], *after[:2], from_s, to_s, reach_m, square])

    def settle(self, known_s: float) -> tuple[Floats, Ints]:
        """See what was in sight until ``known_s``; ways that go on beyond it are cut there, and the rest waits.

        Returns the longest gap of each demand that ended, (demands,) seconds, and its place, (demands,): 0 and -1
        where none ended. Gaps within the time that is settled at once are not told apart.
        """
        rows = np.array(self._rows).reshape(-1, 8)
        over = rows[:, 5] > known_s
        past, later = rows[~over], rows[over]
        across = later[:, 4] < known_s
        if across.any():
            cut = later[across]
            share = ((known_s - cut[:, 4]) / (cut[:, 5] - cut[:, 4]))[:, None]
            middle = cut[:, :2] + share * (cut[:, 2:4] - cut[:, :2])
            known = np.full((len(cut), 1), known_s)
            past = np.vstack([past, np.hstack([cut[:, :2], middle, cut[:, 4:5], known, cut[:, 6:]])])
            later[across] = np.hstack([middle, cut[:, 2:4], known, cut[:, 5:]])
        self._rows = later.tolist()
        self.known_s = known_s
        gaps_s, where = _none_yet(len(self.places.demands))
        if len(past):
            self._see(past)
            age_kernels.close_gaps(self._first_s, self._last_s, self.last_seen_s, self.places.demand, gaps_s, where)
        longer = gaps_s > self.worst_s
        self.worst_s[longer], self.worst_place[longer] = gaps_s[longer], where[longer]
        return gaps_s, where

    def _see(self, rows: Floats) -> None:
        legs, times = np.ascontiguousarray(rows[:, :4]), np.ascontiguousarray(rows[:, 4:6])
        points, first, last = self.places.points, self._first_s, self._last_s
        driven = age_kernels.Driven(legs, times, np.ascontiguousarray(rows[:, 6]), rows[:, 7] > 0)
        age_kernels.see_along(
            driven, self._points_m, self._grid, self._near, self._walls, first[:points], last[:points]
        )
        for k, zone in enumerate(self._zones, start=points):
            first[k], last[k] = age_kernels.visits_along(legs, times, zone, first[k], last[k])

    def oldest(self) -> Ints:
        """For each demand (demands,) the place that was seen longest ago; -1 where it has none."""
        found: Ints = age_kernels.oldest(self.last_seen_s, self.places.demand, len(self.places.demands))
        return found


def _none_yet(demands: int) -> tuple[Floats, Ints]:
    return np.zeros(demands), np.full(demands, -1, np.int64)
