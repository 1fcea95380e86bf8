"""Robots driven along: what they report is watched, and each is told about once a second what it is to make up."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable

from rota.errors import LinkError
from rota.links.link import Link, Order
from rota.live.keeping import LATE_S, Keeping
from rota.live.notices import Notice
from rota.live.session import Session
from rota.live.watch import Watch
from rota.live.watch_log import LogWriter

KEPT_EVERY_S = 1.0


class Driving:
    """A link's robots on their routes, kept in phase where the link can do that.

    tell: called with each notice. log: where all that arrives is written, None: nowhere.
    """

    def __init__(
        self, link: Link, watch: Watch, keeping: Keeping, log: LogWriter | None, tell: Callable[[Notice], None]
    ) -> None:
        self._link, self._watch, self._keeping, self._tell = link, watch, keeping, tell
        self._session = Session(watch, log, self._look)
        self._next_s = -math.inf
        self._sent: dict[str, asyncio.Task[None]] = {}
        self._deaf: set[str] = set()
        self._waiting: set[str] = set()

    async def drive(self, *, until_s: float = math.inf, should_stop: Callable[[], bool]) -> None:
        """Until the link's reports end, the plan is ``until_s`` old, or ``should_stop`` says so."""
        try:
            await self._session.follow(self._link, until_s=until_s, should_stop=should_stop)
        finally:
            sent = list(self._sent.values())
            for task in sent:
                task.cancel()
            await asyncio.gather(*sent, return_exceptions=True)

    def latest(self) -> tuple[str, float] | None:
        """The robot on its route that is latest, and by how much; None where nobody is on one."""
        on_route = [robot for robot in self._watch.state().robots if robot.standing == "ok"]
        last = max(on_route, key=self._keeping.late_s, default=None)
        return None if last is None else (last.name, self._keeping.late_s(last))

    def _look(self, notices: list[Notice]) -> None:
        """Pass notices on, and at times tell all robots what to make up or lose."""
        for notice in notices:
            if not self._is_of_waiting(notice):
                self._tell(notice)
        now_s = self._watch.now_s
        if now_s < self._next_s:
            return
        self._next_s = now_s + KEPT_EVERY_S
        robots, link = self._watch.state().robots, self._link
        room_s = {robot.name: link.room_s(robot.name) for robot in robots}
        expected_s = {robot.name: link.expected_s(robot.name, now_s - robot.lag_s) for robot in robots}
        orders, told = self._keeping.look(now_s, robots, room_s, expected_s, link.lead_s)
        for name, lag_s in self._keeping.conduct.lags_s.items():
            self._watch.believe(name, lag_s)
        for notice in told:
            self._tell(notice)
        if self._link.keeps_phase:
            for order in orders:
                self._send(order)

    def _is_of_waiting(self, notice: Notice) -> bool:
        """Whether a notice tells that a robot stands, or goes on, that only waits for the clock of all."""
        if notice.kind == "held up":
            robot = next(robot for robot in self._watch.state().robots if robot.name == notice.about)
            if self._keeping.late_s(robot) < LATE_S:
                self._waiting.add(notice.about)
                return True
        waited = notice.kind == "goes on" and notice.about in self._waiting
        self._waiting -= {notice.about} if notice.kind in ("held up", "goes on") else set()
        return waited

    def _send(self, order: Order) -> None:
        """Hand an order on, unless the robot still has to do with its last one."""
        before = self._sent.get(order.robot)
        if before is None or before.done():
            self._sent[order.robot] = asyncio.get_running_loop().create_task(self._keep(order))

    async def _keep(self, order: Order) -> None:
        """Give a robot its order; one that does not take it is told of once."""
        try:
            await self._link.keep(order)
        except LinkError as error:
            if order.robot not in self._deaf:
                self._deaf.add(order.robot)
                text = f"{error}; it is not kept in phase meanwhile"
                self._tell(Notice(time_s=self._watch.now_s, kind="too slow", about=order.robot, text=text))
            return
        self._deaf.discard(order.robot)
