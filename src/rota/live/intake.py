"""Reports -> events: what does not hold is dropped and counted, however much of it comes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import get_args

from rota.links.link import Fault, Mode, Report
from rota.live.events import Dropped, Heard
from rota.model.limits import FAR_FROM_AREA_M, LONGEST_S

LONGEST_EXAMPLE = 70  # characters
DIGITS = 3  # milliseconds, millimetres and thousandths of a battery: what comes of sensors is no finer
MODES = frozenset(get_args(Mode))


class Intake:
    """Takes the reports of a plan's robots, places within ``FAR_FROM_AREA_M`` of the area's bounds (x0, y0, x1, y1).

    Dropped are reports of robots that the plan does not have, with numbers that are not finite or out of range, of a
    moment more than ``future_s`` ahead, and those that are no later than the robot's last. Numbers are rounded before
    anybody uses them, so that a log of what was used is short. It keeps a number for each
    fault and one example, whatever comes.
    """

    def __init__(self, robots: Sequence[str], bounds_m: tuple[float, float, float, float], future_s: float) -> None:
        self._number = {name: k for k, name in enumerate(robots)}
        self._bounds_m, self._future_s = bounds_m, future_s
        self._last_s = [-math.inf] * len(robots)
        self._dropped: dict[Fault, tuple[int, str]] = {}

    def take(self, report: Report, now_s: float) -> Heard | None:
        """The report as an event; None where it was dropped."""
        number = self._number.get(report.robot) if isinstance(report.robot, str) else None
        fault = "unknown robot" if number is None else self._fault_of(report, now_s, self._last_s[number])
        if fault is not None or number is None:
            self.drop(fault or "unknown robot", 1, f"{report.robot!s:.40}, t = {report.time_s!s:.15}")
            return None
        self._last_s[number] = time_s = round(float(report.time_s), DIGITS)
        x, y, height = (round(float(value), DIGITS) for value in report.position_m)
        battery = None if report.battery is None else round(float(report.battery), DIGITS)
        return Heard(round(now_s, DIGITS), number, time_s, x, y, height, battery, report.mode)

    def drop(self, fault: Fault, count: int, example: str) -> None:
        """Count messages that are no reports."""
        before, first = self._dropped.get(fault, (0, example))
        self._dropped[fault] = (before + count, first)

    def take_dropped(self) -> list[Dropped]:
        """What was dropped since the last call."""
        found = [Dropped(fault, count, _plain(example)) for fault, (count, example) in self._dropped.items()]
        self._dropped.clear()
        return found

    def _fault_of(self, report: Report, now_s: float, last_s: float) -> Fault | None:
        """Why a report is not believed; None where it is."""
        try:
            numbers = [float(value) for value in (report.time_s, *report.position_m)]
            battery = 0.0 if report.battery is None else float(report.battery)
        except (TypeError, ValueError, OverflowError):
            return "malformed"
        if len(numbers) != 4 or not (report.mode is None or report.mode in MODES):
            return "malformed"
        if not all(map(math.isfinite, (*numbers, battery))):
            return "not a number"
        time_s, x, y, height = numbers
        x0, y0, x1, y1 = self._bounds_m
        far = FAR_FROM_AREA_M
        if not (x0 - far <= x <= x1 + far and y0 - far <= y <= y1 + far and abs(height) <= far and 0 <= battery <= 1):
            return "out of range"
        if time_s > now_s + self._future_s or abs(time_s) > LONGEST_S:
            return "from the future"
        return "out of order" if round(time_s, DIGITS) <= last_s else None


def _plain(example: str) -> str:
    """Text that may go to a terminal and a log: printable, and not long."""
    return "".join(sign if sign.isprintable() else "?" for sign in example[:LONGEST_EXAMPLE])
