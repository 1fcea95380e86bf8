"""A watch with a link: reports become events, events are logged and taken, and what that tells is shown.

A replay is the same without the link: the events come from the log.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable
from contextlib import aclosing, suppress

from rota.links.link import Link
from rota.live.events import Event, Tick
from rota.live.intake import Intake
from rota.live.notices import Notice
from rota.live.watch import Watch
from rota.live.watch_log import LogReader, LogWriter

TICK_S = 0.2

Show = Callable[[list[Notice]], None]


class LinkClock:
    """Seconds since the plan's start: what the link says, else real time, counted from the first report's own time."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._zero_s: float | None = None

    def now_s(self) -> float | None:
        """The time; None before the first report of a link that does not tell it."""
        told = getattr(self._link, "time_s", None)
        if told is not None:
            return float(told)
        return None if self._zero_s is None else time.monotonic() - self._zero_s

    def hear(self, time_s: float) -> None:
        """Take the time of a report where none is known yet."""
        if self._zero_s is None and isinstance(time_s, int | float) and math.isfinite(time_s):
            self._zero_s = time.monotonic() - float(time_s)


class Session:
    """A watch, its log, and whom it shows to; ``show`` is called with the notices of every tick, also with none."""

    def __init__(self, watch: Watch, log: LogWriter | None, show: Show) -> None:
        self._watch, self._log, self._show = watch, log, show
        plan = watch.plan
        names = [way.robot for way in plan]
        self._intake = Intake(names, plan.mission.area.bounds, watch.settings.future_s)
        self._rejected, self._next_s = 0, -math.inf

    async def follow(self, link: Link, *, until_s: float = math.inf, should_stop: Callable[[], bool]) -> None:
        """Watch until the link's reports end, it is ``until_s``, or ``should_stop`` says so.

        LinkErrors of the link go through.
        """
        clock = LinkClock(link)
        reader = asyncio.create_task(self._read(link, clock, until_s))
        try:
            # also where nobody reports
            while not reader.done() and not should_stop() and not self._tick_if_due(link, clock, until_s):
                await asyncio.sleep(TICK_S / 4)
            if reader.done():
                reader.result()
        finally:
            reader.cancel()
            with suppress(asyncio.CancelledError):
                await reader

    async def _read(self, link: Link, clock: LinkClock, until_s: float) -> None:
        async with aclosing(link.reports()) as reports:
            async for report in reports:
                clock.hear(report.time_s)
                heard = self._intake.take(report, clock.now_s() or 0.0)
                if heard is not None:
                    self._take(heard)
                if self._tick_if_due(link, clock, until_s):
                    return

    def _tick_if_due(self, link: Link, clock: LinkClock, until_s: float) -> bool:
        """Tick where it is time to; whether it is ``until_s``."""
        now_s = clock.now_s()
        if now_s is None:
            return False
        if now_s >= self._next_s:
            self._next_s = now_s + TICK_S if self._next_s == -math.inf else max(self._next_s + TICK_S, now_s)
            self._tick(link, now_s)
        return now_s >= until_s

    def _tick(self, link: Link, now_s: float) -> None:
        if link.rejected > self._rejected:
            self._intake.drop("malformed", link.rejected - self._rejected, "by the link")
            self._rejected = link.rejected
        for dropped in self._intake.dropped():
            self._take(dropped)
        self._show(self._take(Tick(now_s)))

    def _take(self, event: Event) -> list[Notice]:
        if self._log is not None:
            self._log.write(event)
        return self._watch.take(event)


def replay(log: LogReader, watch: Watch, show: Show) -> None:
    """Take all events of a log; ``show`` is called as it was when the log was written."""
    for event in log.events():
        notices = watch.take(event)
        if isinstance(event, Tick):
            show(notices)
