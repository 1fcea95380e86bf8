"""Where reports arrive: validated, bounded, and handed on in the order of arrival."""

from __future__ import annotations

import asyncio
import math
import reprlib
from collections import deque
from collections.abc import AsyncGenerator, Collection, Mapping
from dataclasses import replace
from typing import Any, get_args

from rota.links.link import Fault, Mode, Rejections, Report
from rota.model.limits import FAR_FROM_AREA_M, LONGEST_S

MOST_WAITING = 20_000  # reports that nobody has taken yet: 200 robots at 5 Hz for 20 s
ROUNDING_S = 1e-6
AHEAD_S = 2.0  # by which a robot's clock may be ahead
MODES = frozenset(get_args(Mode))
LONGEST_EXAMPLE = 90  # letters

Bounds = tuple[float, float, float, float]


class ReportInbox:
    """Reports of known robots within ``FAR_FROM_AREA_M`` of the area's bounds (x0, y0, x1, y1), in metres.

    Whatever is offered, it holds the latest report of each robot and at most ``most_waiting`` others; when it is full
    the oldest go. It counts what it drops, with an example for each fault.
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
        self._rejections: dict[Fault, Rejections] = {}

    @property
    def rejections(self) -> Mapping[Fault, Rejections]:
        """What was dropped so far."""
        return dict(self._rejections)  # links count from threads of their own, too

    def reject(self, fault: Fault, example: str) -> None:
        """Count a message that could not even be offered."""
        before = self._rejections.get(fault)
        self._rejections[fault] = Rejections(before.messages + 1 if before else 1, example[:LONGEST_EXAMPLE])

    def offer(
        self, *, now_s: float, robot: Any, time_s: Any, position_m: Any, battery: Any = None, mode: Any = None
    ) -> bool:
        """Take what may be a report; False, and counted, if it is none.

        Refused are unknown robots, what is not a finite number, places far from the area, times more than ``AHEAD_S``
        after ``now_s`` or before the robot's last report, a battery outside 0..1 and unknown modes.
        """
        fault = self._fault_of(now_s, robot, time_s, position_m, battery, mode)
        if fault is not None:
            self.reject(fault, f"{_words(robot)}, t = {_words(time_s)}, at {_words(position_m)}")
            return False
        x, y, height = map(float, position_m)
        charge = None if battery is None else float(battery)
        report = Report(robot=robot, time_s=float(time_s), position_m=(x, y, height), battery=charge, mode=mode)
        self._latest[report.robot] = report
        if len(self._waiting) >= self._most_waiting:
            lost = self._waiting.popleft()
            self.reject("too many", f"{lost.robot:.25}, t = {lost.time_s:.3f}")
        self._waiting.append(report)
        self._arrived.set()
        return True

    def _fault_of(
        self, now_s: float, robot: Any, time_s: Any, position_m: Any, battery: Any, mode: Any
    ) -> Fault | None:
        """Why a report is not believed; None where it is."""
        if not isinstance(robot, str) or robot not in self._robots:
            return "unknown robot"
        if not isinstance(position_m, tuple | list) or len(position_m) != 3 or not (mode is None or _is_mode(mode)):
            return "malformed"
        numbers = (time_s, *position_m, *(() if battery is None else (battery,)))
        if not all(isinstance(value, int | float) and not isinstance(value, bool) for value in numbers):
            return "malformed"
        if any(value != value or value in (math.inf, -math.inf) for value in numbers):
            return "not a number"
        if time_s > now_s + AHEAD_S:
            return "from the future"
        ranges = ((-LONGEST_S, math.inf), *self._ranges, (0, 1))
        # whole numbers too long for float64 compare exactly, too
        if not all(low <= value <= high for value, (low, high) in zip(numbers, ranges, strict=False)):
            return "out of range"
        last = self._latest.get(robot)
        return "out of order" if last is not None and time_s < last.time_s else None

    def begin_later(self, by_s: float) -> None:
        """Count the time of all reports from so many seconds later; none gets later by rounding than one to come.

        What waits is dropped: it tells where robots were before, and nothing of how they drive the plan.
        """
        by_s += ROUNDING_S
        for robot, report in self._latest.items():
            self._latest[robot] = replace(report, time_s=report.time_s - by_s)
        self._waiting.clear()

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


def _words(value: object) -> str:
    """A value in few letters, whatever it is."""
    try:
        return value[:25] if isinstance(value, str) else reprlib.repr(value)[:40]
    except ValueError:
        return "a very long number"


def _is_mode(value: Any) -> bool:
    return isinstance(value, str) and value in MODES
