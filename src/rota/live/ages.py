"""When each place was last seen, from what robots said of where they were."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rota.check.arrays import Binned, Grid
from rota.check.counting import Names, counts, groups_of
from rota.geometry.free_space import border_segments, sight_walls
from rota.geometry.kernels import EdgeGrid
from rota.geometry.line_of_sight import edge_grid
from rota.live import age_kernels
from rota.live.places import Places, sort_in_bins
from rota.model.arrays import Flags, Floats, Ints
from rota.model.fleet import DiscSensor, Robot, inner_reach_m
from rota.model.mission import Mission

Place = tuple[float, float, float]

FASTER, FREE_REACHES = 1.5, 0.25  # a robot may have gone so many times as far as it can, and a part of its reach


def is_jump(robot: Robot, before: Place, after: Place, time_s: float) -> bool:
    """Whether a robot cannot have gone a way in a time: half as fast again, and noise, are let pass."""
    way_m = float(np.hypot(after[0] - before[0], after[1] - before[1]))
    return way_m > FASTER * robot.speed_m_s * time_s + FREE_REACHES * inner_reach_m(robot.sensor)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Group:
    """Places for which the same sensors count: (n,) numbers of points, where they are, and the zones to visit."""

    counts: Flags
    points: Ints
    points_m: Floats
    bins: tuple[Grid, Binned]
    zones: list[tuple[int, EdgeGrid]]


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
        self._walls = edge_grid(sight_walls(mission))
        self._sensors = tuple(dict.fromkeys(robot.sensor for robot in mission.fleet.unlike_robots))
        reach_m = max(map(inner_reach_m, self._sensors))
        self._groups = [self._group(names, own, reach_m) for names, own in groups_of(places.demands)]
        self._rows: list[list[float]] = []

    def _group(self, names: Names, own: list[int], reach_m: float) -> _Group:
        """The places of some demands, for which robots with the same sensors count."""
        asked = np.isin(self.places.demand, own)
        points, visits = (np.flatnonzero(part) for part in (asked[: self.places.points], asked[self.places.points :]))
        points_m = np.ascontiguousarray(self.places.points_m[points])
        regions = [self.places.demands[self.places.demand[self.places.points + visit]].region for visit in visits]
        return _Group(
            counts=np.array([counts(sensor, names) for sensor in self._sensors], np.bool_),
            points=points,
            points_m=points_m,
            bins=sort_in_bins(points_m, reach_m),
            zones=[
                (self.places.points + int(visit), edge_grid(border_segments(region)))
                for visit, region in zip(visits, regions, strict=True)
            ],
        )

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
        self._rows.append([*before[:2], *after[:2], from_s, to_s, reach_m, square, self._sensors.index(sensor)])

    def settle(self, known_s: float) -> tuple[Floats, Ints]:
        """See what was in sight until ``known_s``; ways that go on beyond it are cut there, and the rest waits.

        Returns the longest gap of each demand that ended, (demands,) seconds, and its place, (demands,): 0 and -1
        where none ended. Gaps within the time that is settled at once are not told apart.
        """
        rows = np.array(self._rows).reshape(-1, 9)
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
        """Note what was seen along ways (m, 9), each group of places by those that count for it."""
        first_s, last_s = self._first_s, self._last_s
        for group in self._groups:
            own = rows[group.counts[rows[:, 8].astype(np.int64)]]
            legs, times = np.ascontiguousarray(own[:, :4]), np.ascontiguousarray(own[:, 4:6])
            driven = age_kernels.Driven(legs, times, np.ascontiguousarray(own[:, 6]), own[:, 7] > 0)
            first, last = first_s[group.points], last_s[group.points]
            age_kernels.see_along(driven, group.points_m, *group.bins, self._walls, first, last)
            first_s[group.points], last_s[group.points] = first, last
            for k, zone in group.zones:
                first_s[k], last_s[k] = age_kernels.visits_along(legs, times, zone, first_s[k], last_s[k])

    def oldest(self) -> Ints:
        """For each demand (demands,) the place that was seen longest ago; -1 where it has none."""
        found: Ints = age_kernels.oldest(self.last_seen_s, self.places.demand, len(self.places.demands))
        return found


def _none_yet(demands: int) -> tuple[Floats, Ints]:
    return np.zeros(demands), np.full(demands, -1, np.int64)
