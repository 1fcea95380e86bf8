"""Where reports arrive: validated, bounded, and handed on in the order of arrival."""

from __future__ import annotations

import asyncio
import math
from collections import deque
from collections.abc import AsyncGenerator, Collection
from typing import Any, get_args

from rota.limits import FAR_FROM_AREA_M, LONGEST_S
from rota.links.link import Mode, Report

MOST_WAITING = 20_000  # reports that nobody has taken yet: 200 robots at 5 Hz for 20 s
AHEAD_S = 2.0  # by which a robot's clock may be ahead
MODES = frozenset(get_args(Mode))

Bounds = tuple[float, float, float, float]


class ReportInbox:
    """Reports of known robots within ``FAR_FROM_AREA_M`` of the area's bounds (x0, y0, x1, y1), in metres.

    Whatever is offered, it holds the latest report of each robot and at most ``most_waiting`` others; when it is full
    the oldest go.
    """

    def __init__(self, robots: Collection[str], bounds_m: Bounds, most_waiting: int = MOST_WAITING) -> None:
        self._robots = frozenset(robots)
        x0, y0, x1, y1 = bounds_m
        far = FAR_FROM_AREA_M
        self._ranges = ((x0 - far, x1 + far), (y0 - far, y1 + far), (-far, far))
        self._waiting: deque[Report] = deque()
        self._most_waiting = most_waiting
        self._latest: dict[str, Report] = {}
        self._arrived = asyncio.Event()
        self._closed = False
        self.rejected = 0

    def reject(self) -> None:
        """Count a message that could not even be offered."""
        self.rejected += 1

    def offer(
        self, *, now_s: float, robot: Any, time_s: Any, position_m: Any, battery: Any = None, mode: Any = None
    ) -> bool:
        """Take what may be a report; False, and counted, if it is none.

        Refused are unknown robots, what is not a finite number, places far from the area, times more than ``AHEAD_S``
        after ``now_s`` or before the robot's last report, a battery outside 0..1 and unknown modes.
        """
        report = self._validated(now_s, robot, time_s, position_m, battery, mode)
        if report is None:
            self.rejected += 1
            return False
        self._latest[report.robot] = report
        if len(self._waiting) >= self._most_waiting:
            self._waiting.popleft()
            self.rejected += 1
        self._waiting.append(report)
        self._arrived.set()
        return True

    def _validated(
        self, now_s: float, robot: Any, time_s: Any, position_m: Any, battery: Any, mode: Any
    ) -> Report | None:
        if not isinstance(robot, str) or robot not in self._robots or not (mode is None or _is_mode(mode)):
            return None
        if not _is_number(time_s, -LONGEST_S, now_s + AHEAD_S) or not (battery is None or _is_number(battery, 0, 1)):
            return None
        if not isinstance(position_m, tuple | list) or len(position_m) != 3:
            return None
        if not all(_is_number(value, low, high) for value, (low, high) in zip(position_m, self._ranges, strict=True)):
            return None
        last = self._latest.get(robot)
        if last is not None and time_s < last.time_s:
            return None
        x, y, height = (float(value) for value in position_m)
        charge = None if battery is None else float(battery)
        return Report(robot=robot, time_s=float(time_s), position_m=(x, y, height), battery=charge, mode=mode)

    def latest(self, robot: str) -> Report | None:
        """The robot's last report, None before the first."""
        return self._latest.get(robot)

    def take_all(self) -> list[Report]:
        """What is waiting, in the order of arrival; nothing waits afterwards."""
        taken = list(self._waiting)
        self._waiting.clear()
        self._arrived.clear()
        return taken

    async def reports(self) -> AsyncGenerator[Report, None]:
        """All reports as they arrive, until ``close``."""
        ended = False
        while not ended:
            await self._arrived.wait()
            ended = self._closed
            for report in self.take_all():
                yield report

    def close(self) -> None:
        """Let ``reports`` end once all that waits has been taken."""
        self._closed = True
        self._arrived.set()


def _is_mode(value: Any) -> bool:
    return isinstance(value, str) and value in MODES


def _is_number(value: Any, low: float, high: float) -> bool:
    # a comparison with NaN is never true; whole numbers too long for float64 compare exactly, too
    return isinstance(value, int | float) and not isinstance(value, bool) and math.inf > high >= value >= low
