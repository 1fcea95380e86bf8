"""What `rota fly --start` does while robots drive: keeps them in phase, and tells of them."""

from __future__ import annotations

import asyncio
import time
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

from rota.command.terminal import say
from rota.compiled.compiled_cache import mention_compiling

if TYPE_CHECKING:
    from rota.links.link import Link
    from rota.live.driving import Driving
    from rota.live.keeping import Keeping
    from rota.live.notices import Notice
    from rota.live.watch import Watch
    from rota.model.plan import Plan

ROOM = 0.03  # by which robots that are driven along can be faster than the clock of all
ON_MISSIONS = 0.98  # of the plan's pace, at which ArduCopter's simulator was kept in phase on missions
NEWS_EVERY_S = 10.0
RELEASED = "robots get nothing more from here on, and wait at the last stop that they have, or where they are"
GO_ON = "robots go on with their routes; --pause stops them, --home calls them back"


class Along(AbstractContextManager["Along"]):
    """The plan's watch and the clock of its robots, made before the start: both take some seconds.

    As a context it holds the log, in which nothing is written before the start; RotaError where there is one already.
    """

    def __init__(self, plan: Plan, link: Link, log: str | None) -> None:
        from rota.live.watch import Watch
        from rota.live.watch_log import LogWriter

        self._link = link
        self._watch: Watch = Watch(plan)
        self._keeping: Keeping = _keeping(plan, link) if link.keeps_phase else _without_slack(plan)
        self._log = None if log is None else LogWriter(log, plan, self._watch.settings)

    def __exit__(self, *failed: Any) -> None:
        if self._log is not None:
            self._log.__exit__(*failed)

    def tell_before(self) -> list[str]:
        """How slowly all may drive before something lapses, and who has to be slower than planned."""
        if not self._link.keeps_phase:
            return []
        told = []
        if (found := self._keeping.least_pace()) is not None:
            pace, name = found
            told.append(f"robots are kept in phase; driven at less than {pace:.3f} of the plan's pace, {name} lapses")
            if self._link.flies and not self._link.drives_along and pace > ON_MISSIONS:
                told.append(
                    f"copters on missions of their own go at about {ON_MISSIONS:g} of it: plan with a period_margin"
                    f" greater by {pace - ON_MISSIONS:.3f}, or for vehicle: arducopter-targets"
                )
        if self._keeping.rate < 1:
            slowest = min(self._link.robots, key=self._link.most_pace)
            lapses = self._keeping.lapses_at(self._keeping.rate)
            then = f"; {', '.join(lapses)}" if lapses else ""
            can = f"{slowest} can be driven at {self._link.most_pace(slowest):.3f} of its pace"
            room = ", to leave it room" if self._link.drives_along else ""
            told.append(f"{can}; all go at {self._keeping.rate:.3f} of theirs{room}{then}")
        return told

    async def drive(self, seconds: float | None) -> None:
        """Until Ctrl-C, for so many seconds, or until the link's reports end."""
        from rota.live.driving import Driving

        if self._link.drives_along:
            say("robots drive while this goes on; Ctrl-C ends it")
        elif self._link.keeps_phase:
            say("robots are kept in phase while this goes on; after Ctrl-C they go on by themselves")
        end_s = None if seconds is None else time.monotonic() + seconds
        driving = Driving(self._link, self._watch, self._keeping, self._log, _tell)
        teller = asyncio.create_task(self._news(driving))
        try:
            await driving.drive(should_stop=lambda: end_s is not None and time.monotonic() >= end_s)
        finally:
            teller.cancel()
            if not self._link.in_process:
                say(RELEASED if self._link.drives_along else GO_ON)

    async def _news(self, driving: Driving) -> None:
        """Say now and then how many robots are heard, which is the latest and how fast all go."""
        link = self._link
        while True:
            await asyncio.sleep(NEWS_EVERY_S)
            known = [report for robot in link.robots if (report := link.latest(robot)) is not None]
            charges = [report.battery for report in known if report.battery is not None]
            words = [f"{len(known)} of {len(link.robots)} robots heard"]
            if (last := driving.latest()) is not None:
                words.append(f"the latest is {last[0]}, {last[1]:+.1f} s")
            if self._keeping.rate < 1:
                words.append(f"all at {self._keeping.rate:.2f} of the plan's pace")
            if charges:
                words.append(f"lowest battery {min(charges):.0%}")
            words.append(f"{sum(rejected.messages for rejected in link.rejections.values())} messages dropped")
            say(", ".join(words))


def _tell(notice: Notice) -> None:
    from rota.live.notices import notice_line

    if notice.kind != "dropped":  # those are counted in the news
        say(notice_line(notice).strip())


def _most_rate(link: Link) -> float:
    """The pace of the clock of all; it leaves robots that are driven along room to make something up."""
    room = ROOM if link.drives_along else 0.0
    return min((link.most_pace(robot) for robot in link.robots), default=1.0) / (1 + room)


def _keeping(plan: Plan, link: Link) -> Keeping:
    """With what the check says of each demand."""
    from rota.check import check_plan
    from rota.live.keeping import Keeping, Slack

    mention_compiling("check")
    demands = check_plan(plan).demands
    return Keeping(
        plan,
        {each.name: Slack(gap_s=each.worst_gap_s, period_s=each.period_s) for each in demands},
        _most_rate(link),
    )


def _without_slack(plan: Plan) -> Keeping:
    from rota.live.keeping import Keeping

    return Keeping(plan, {})
