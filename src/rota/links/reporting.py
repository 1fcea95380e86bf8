"""What links have in common: an inbox of reports, and to real robots also a clock and the meeting of all."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncGenerator, Awaitable, Callable, Collection, Mapping, Sequence

from rota.errors import LinkError
from rota.links.inbox import Bounds, ReportInbox
from rota.links.link import Fault, Order, Rejections, Report
from rota.links.plan_clock import PlanClock
from rota.routes.route import Place3


class ReportingLink:
    """The part of a Link that tells what its robots have reported, and what of that was dropped.

    Its robots stay on the ground unless a link says otherwise.
    """

    flies = False
    relieves = False
    lead_s = 0.0

    def __init__(self, robots: Collection[str], bounds_m: Bounds) -> None:
        self._names = tuple(robots)
        self._inbox = ReportInbox(self._names, bounds_m)

    @property
    def robots(self) -> tuple[str, ...]:
        """The names of the robots, in the plan's order."""
        return self._names

    @property
    def rejections(self) -> Mapping[Fault, Rejections]:
        """The messages that were dropped so far, by fault."""
        return self._inbox.rejections

    @property
    def trouble(self) -> str:
        """Nothing keeps it from its robots."""
        return ""

    def begin(self) -> None:
        """The plan's time runs only while robots can drive."""

    def most_pace(self, robot: str) -> float:
        """Nothing is known of that."""
        return math.inf

    def room_s(self, robot: str) -> float:
        """Nothing is known of that."""
        return 0.0

    def expected_s(self, robot: str, plan_s: float) -> float:
        """Nothing is known of that."""
        return 0.0

    async def by_itself(self, robot: str) -> tuple[str, ...]:
        """Nothing is known of that."""
        return ()

    def is_in_air(self, robot: str) -> bool:
        """It stays on the ground."""
        return False

    def home_m(self, robot: str) -> Place3 | None:
        """Nothing is known of it."""
        return None

    async def climb(self, robot: str, height_m: float) -> None:
        """It stays on the ground."""

    async def go(self, robot: str, places_m: Sequence[Place3]) -> None:
        """It drives its route alone."""

    async def land(self, robot: str) -> None:
        """It stands already."""

    def latest(self, robot: str) -> Report | None:
        """The robot's last report, None before the first."""
        return self._inbox.latest(robot)


class RealTimeLink(ReportingLink):
    """The part of a Link that every one to real robots has.

    start_time: when the plan started, in ISO 8601, named ``where`` in errors; empty: when ``begin`` was called, and
    before that when the link was opened.
    """

    in_process = False
    keeps_phase = False
    heard_by_one = False

    async def keep(self, order: Order) -> None:
        """Links to robots that cannot be kept in phase do nothing."""

    def __init__(self, robots: Collection[str], bounds_m: Bounds, start_time: str, where: str) -> None:
        super().__init__(robots, bounds_m)
        self._clock: PlanClock = PlanClock(start_time, where)

    @property
    def time_s(self) -> float:
        """Seconds since the plan's start."""
        return self._clock.now_s()

    @property
    def begun_s(self) -> float:
        """The plan's start, in seconds since 1970."""
        return self._clock.unix_s(0.0)

    def begin(self) -> None:
        """Let the plan's time start now, unless it is given when it started; reports count from then on."""
        self._inbox.begin_later(self._clock.begin())

    def reports(self) -> AsyncGenerator[Report, None]:
        """All reports as they arrive."""
        return self._inbox.reports()

    async def _meet_all(self, meet: Callable[[str], Awaitable[None]]) -> None:
        """Meet all robots at the same time; LinkError with a line for each that is not as needed."""
        outcomes = await asyncio.gather(*map(meet, self._names), return_exceptions=True)
        faults = [outcome for outcome in outcomes if isinstance(outcome, BaseException)]
        for fault in faults:
            if not isinstance(fault, LinkError):
                raise fault
        if faults:
            raise LinkError("\n".join(map(str, faults)))
