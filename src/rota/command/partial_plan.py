"""The best plan so far on disk while a search goes on: what is left when the machine stops or nothing passes."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

from rota.command.checkpoint import stem_of
from rota.command.terminal import STANDARD_STREAM, say
from rota.errors import RotaError

if TYPE_CHECKING:
    from rota.check.report import Report
    from rota.model.plan import Plan

PARTIAL_SUFFIX = ".partial.rota.json"
SHARE = 0.1  # of a search's time at most goes into writing, but for the first plan


class PartialPlan:
    """A plan file beside the one to be written, which it makes room for.

    It holds the plan whose check has begun, marked as not meeting its demand, until one passes; from then on the best
    that passed. ``path`` None: the plan goes to stdout, and nothing is kept.
    """

    def __init__(self, target: str) -> None:
        self.path = None if target == STANDARD_STREAM else stem_of(target) + PARTIAL_SUFFIX
        self.is_there = False
        self._holds_met = False
        self._next_s = 0.0

    def keep_candidate(self, plan: Plan) -> None:
        """Keep a plan whose check is to begin, unless there is one that passed."""
        if not self._holds_met and time.monotonic() >= self._next_s:
            self.keep(plan, meets_demand=False)

    def keep_better(self, plan: Plan, report: Report) -> None:
        """Keep a plan that passed, the best so far."""
        if report.verdict == "met" and (not self._holds_met or time.monotonic() >= self._next_s):
            self.keep(plan, meets_demand=True)

    def keep(self, plan: Plan, *, meets_demand: bool) -> None:
        """Write the plan; a search goes on where that cannot be done."""
        from rota.files.plan_file import write_plan

        if self.path is None:
            return
        began_s = time.monotonic()
        try:
            write_plan(plan, self.path, meets_demand=meets_demand)
        except RotaError as error:
            say(f"warning: {error}; the best plan so far is not kept on the way")
            self.path = None
            return
        self.is_there, self._holds_met = True, meets_demand
        self._next_s = time.monotonic() + (time.monotonic() - began_s) / SHARE

    def remove(self) -> None:
        """The plan is written: what was kept on its way, by an earlier run too, is of no use any more."""
        if self.path is not None:
            Path(self.path).unlink(missing_ok=True)
        self.is_there = False

    def tell(self) -> None:
        """Say where the best plan is, if there is one."""
        if self.is_there:
            met = "" if self._holds_met else ", marked as not meeting its demand"
            say(f"the best plan so far is in {self.path}{met}")
