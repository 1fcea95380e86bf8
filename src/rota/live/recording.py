"""A watch's log -> what each robot drove, for the check to judge."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from rota.check.recorded import RecordedTrack
from rota.live.ages import is_jump
from rota.live.events import Event, Heard, Tick
from rota.live.reliefs import AT_CHARGER_M
from rota.live.settings import WatchSettings
from rota.model.arrays import Flags, Floats
from rota.model.plan import Plan


@dataclass(frozen=True, kw_only=True)
class Recording:
    """What was driven, and the time that can be judged: not before the plan's latest loop start."""

    tracks: tuple[RecordedTrack, ...]
    window_s: tuple[float, float]
    reports: int


def recording_of(plan: Plan, events: Iterable[Event], settings: WatchSettings) -> Recording:
    """The tracks of a log's events, by the rule of the watch.

    Two reports of a robot that follow each other are joined by a straight leg at constant speed, if they are at most
    ``silent_s`` apart and the robot can have gone that way; else each counts for its moment alone. A robot that stands
    on a charger of its plan sees nothing; who only comes past it does.
    """
    robots = [plan.mission.fleet.robot(way.robot) for way in plan]
    rows: list[list[tuple[float, ...]]] = [[] for _ in robots]
    last: list[Heard | None] = [None] * len(robots)
    ticks: list[float] = []
    reports = 0
    for event in events:
        if isinstance(event, Tick):
            ticks = [ticks[0], event.now_s] if ticks else [event.now_s]
        if not isinstance(event, Heard):
            continue
        reports += 1
        robot, before = robots[event.robot], last[event.robot]
        if before is not None and event.time_s <= before.time_s:
            continue
        last[event.robot] = event
        if event.time_s < robot.joins_s or (robot.leaves_s is not None and event.time_s > robot.leaves_s):
            continue
        start = event if before is None or event.time_s - before.time_s > settings.silent_s else before
        here, there = (event.x_m, event.y_m, event.height_m), (start.x_m, start.y_m, start.height_m)
        if is_jump(robot, there, here, event.time_s - start.time_s):
            start, there = event, here
        rows[event.robot].append((*there[:2], *here[:2], start.time_s, event.time_s, min(there[2], here[2])))
    tracks = []
    for robot, driven, way in zip(robots, rows, plan, strict=True):
        table = np.array(driven, np.float64).reshape(-1, 7)
        used = {charge.charger for charge in way.charges}
        for charger in plan.mission.chargers:
            if charger.name in used:
                table = table[~_stands_at(charger.at, robot.speed_m_s, table)]
        tracks.append(
            RecordedTrack(robot=robot.name, legs_m=table[:, :4], times_s=table[:, 4:6], heights_m=table[:, 6])
        )
    from_s = max((way.loop_start_s for way in plan), default=0.0)
    window_s = (max(from_s, ticks[0]), ticks[-1]) if ticks else (from_s, from_s)
    return Recording(tracks=tuple(tracks), window_s=window_s, reports=reports)


def _stands_at(place_m: tuple[float, float], speed_m_s: float, table: Floats) -> Flags:
    """Which legs (n,) of a table (n, 7) of legs a robot spends at a charger: it is there for longer than to come past.

    Who comes past it at half its speed is within ``AT_CHARGER_M`` on either side for so long.
    """
    ends_m = table[:, :4].reshape(-1, 2, 2) - place_m
    near = np.all(np.hypot(ends_m[..., 0], ends_m[..., 1]) <= AT_CHARGER_M, axis=1)
    changes = np.flatnonzero(np.diff(near, prepend=False, append=False))
    for first, after in changes.reshape(-1, 2):
        near[first:after] = table[after - 1, 5] - table[first, 4] > 2 * 2 * AT_CHARGER_M / speed_m_s
    return np.asarray(near)
