"""A watch with a link: reports become events, events are logged and taken, and what that tells is shown.

A replay is the same without the link: the events come from the log.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from contextlib import aclosing, suppress

from rota.links.link import Fault, Link
from rota.live.events import Event, Tick
from rota.live.intake import DIGITS, Intake
from rota.live.notices import Notice
from rota.live.watch import Watch
from rota.live.watch_log import LogReader, LogWriter

TICK_S = 0.2

Show = Callable[[list[Notice]], None]


class Session:
    """A watch, its log, and whom it shows to; ``show`` is called with the notices of every tick, also with none."""

    def __init__(self, watch: Watch, log: LogWriter | None, show: Show) -> None:
        self._watch, self._log, self._show = watch, log, show
        plan = watch.plan
        names = [way.robot for way in plan]
        self._intake = Intake(names, plan.mission.area.bounds, watch.settings.future_s)
        self._rejected: dict[Fault, int] = {}
        self._next_s = -math.inf

    async def follow(self, link: Link, *, until_s: float = math.inf, should_stop: Callable[[], bool]) -> None:
        """Watch until the link's reports end, it is ``until_s``, or ``should_stop`` says so.

        LinkErrors of the link go through.
        """
        reader = asyncio.create_task(self._read(link, until_s))
        try:
            # also where nobody reports
            while not reader.done() and not should_stop() and not self._tick_if_due(link, until_s):
                await asyncio.sleep(TICK_S / 4)
            if reader.done():
                reader.result()
        finally:
            reader.cancel()
            with suppress(asyncio.CancelledError):
                await reader

    async def _read(self, link: Link, until_s: float) -> None:
        async with aclosing(link.reports()) as reports:
            async for report in reports:
                heard = self._intake.take(report, link.time_s)
                if heard is not None:
                    self._take(heard)
                if self._tick_if_due(link, until_s):
                    return

    def _tick_if_due(self, link: Link, until_s: float) -> bool:
        """Tick where it is time to; whether it is ``until_s``."""
        now_s = link.time_s
        if now_s >= self._next_s:
            self._next_s = now_s + TICK_S if self._next_s == -math.inf else max(self._next_s + TICK_S, now_s)
            self._tick(link, now_s)
        return now_s >= until_s

    def _tick(self, link: Link, now_s: float) -> None:
        for fault, (messages, example) in link.rejections.items():
            if (fresh := messages - self._rejected.get(fault, 0)) > 0:
                self._intake.drop(fault, fresh, example)
                self._rejected[fault] = messages
        for dropped in self._intake.take_dropped():
            self._take(dropped)
        self._show(self._take(Tick(round(now_s, DIGITS))))

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
