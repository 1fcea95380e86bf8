"""`rota watch --replan`: when a robot is lost, a plan for those that remain is offered as a file beside the log."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from rota.command.terminal import say
from rota.errors import RotaError

if TYPE_CHECKING:
    from rota.live.notices import Notice
    from rota.model.plan import Plan
    from rota.replanning.replan import Replanned

AHEAD_S = 10.0  # from the loss to when the plan takes over: those that remain must be told first
LIMIT_S = 20.0  # of the search for better plans


class Replans:
    """Plans without the robots that are lost, one after the other in a thread of their own; a robot may come back.

    stem: before the moment in the names of their files.
    """

    def __init__(self, plan: Plan, stem: str) -> None:
        self._plan, self._stem = plan, stem
        self._lost: dict[str, float] = {}
        self._at_s, self._has_new = 0.0, False
        self._wanted, self._ended = threading.Event(), False
        self._thread = threading.Thread(target=self._work, name="rota replans", daemon=True)
        self._thread.start()

    def note(self, notices: Sequence[Notice]) -> None:
        """What a session tells at a tick."""
        lost = [notice for notice in notices if notice.kind == "lost"]
        for notice in notices:
            if notice.kind == "back":
                self._lost.pop(notice.about, None)
        for notice in lost:
            self._lost[notice.about] = notice.time_s
            self._at_s = notice.time_s + AHEAD_S
        if lost:
            self._has_new = True
            self._wanted.set()

    def end(self) -> None:
        """Begin no more; one that is being searched is told to the end."""
        self._ended = True
        self._wanted.set()
        self._thread.join()

    def _work(self) -> None:
        """Replan whenever a robot was lost."""
        while True:
            self._wanted.wait()
            self._wanted.clear()
            has_new, self._has_new = self._has_new, False
            lost, at_s = tuple(self._lost), self._at_s
            if lost and has_new:  # at the end nothing is offered again
                with suppress(RotaError):
                    self._offer(lost, at_s)
            if self._ended and not self._wanted.is_set():
                return

    def _offer(self, lost: tuple[str, ...], at_s: float) -> None:
        """Replan without these robots, and tell each plan that is better than the last."""
        from rota.files.plan_file import write_plan
        from rota.replanning.replan import replan

        path = f"{self._stem}-at-{at_s:.0f}.rota.json"

        def tell(found: Replanned) -> None:
            write_plan(found.plan, path, meets_demand=found.meets_demand)
            late = found.report.lateness
            told = "" if late is None else f": {late.lines()[0].partition(': ')[2]}"
            say(f"without {', '.join(lost)} from t = {at_s:.1f} s on: {path}, {found.report.verdict}{told}")

        try:
            replan(
                self._plan, at_s=at_s, lost=lost, time_limit_s=LIMIT_S, on_better=tell,
                should_stop=lambda: self._ended or self._wanted.is_set(),
            )  # fmt: skip
        except RotaError as error:
            say(f"without {', '.join(lost)} from t = {at_s:.1f} s on: no plan: {error}")
