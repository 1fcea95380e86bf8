"""From a mission to a plan that the check passes: the mission's planner, a judge, a stop rule and a seed."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from rota.better_plans import BetterPlans, OnBetter, checked_state
from rota.errors import MissionError, NoPlanFound
from rota.planner import Answer, Request, planner_of
from rota.progress import Watch

if TYPE_CHECKING:
    from rota.check.report import Report
    from rota.checkpoint import Checkpoint
    from rota.mission import Mission
    from rota.plan import Plan

Progress = Callable[[float, str], None]
ShouldStop = Callable[[], bool]


@dataclass(frozen=True, kw_only=True)
class PlanSearch:
    """What a search came to: the planner's answer, the check's report on its plan, and whether it was stopped early."""

    answer: Answer
    report: Report
    stopped_early: bool

    @property
    def plan(self) -> Plan:
        """The plan."""
        return self.answer.plan

    @property
    def facts(self) -> tuple[str, ...]:
        """What the planner knows beside the plan, as sentences."""
        return self.answer.facts

    @property
    def checkpoint(self) -> Checkpoint | None:
        """Of a run that ended before robots came to rest; None where there was no run, or they did."""
        return self.answer.checkpoint


def make_plan(
    mission: Mission,
    *,
    seed: int = 0,
    time_limit_s: float | None = None,
    progress: Progress | None = None,
    should_stop: ShouldStop | None = None,
    resume: Checkpoint | None = None,
) -> Plan:
    """Plan ``mission`` and return a plan that the check passes; see ``search_plan``, which tells more."""
    return search_plan(
        mission, seed=seed, time_limit_s=time_limit_s, progress=progress, should_stop=should_stop, resume=resume
    ).plan


def search_plan(
    mission: Mission,
    *,
    seed: int = 0,
    time_limit_s: float | None = None,
    progress: Progress | None = None,
    should_stop: ShouldStop | None = None,
    watch: Watch | None = None,
    resume: Checkpoint | None = None,
    observe: Callable[[Any], None] | None = None,
    on_better: OnBetter | None = None,
    executor: Executor | None = None,
) -> PlanSearch:
    """Plan ``mission`` with the planner that its settings name, and check the outcome.

    seed: the same seed gives the same plan, unless the search is stopped early. time_limit_s: seconds after which the
    planner is asked to stop; it then gives the best plan so far. progress: called with a fraction 0..1 and what is
    being done. should_stop: asked now and then; True stops like the time limit. watch: called with every state that
    the search comes to, from several threads; it changes nothing of what is found. resume: a swarm's run to go on with;
    the outcome is the plan of the same run without a stop, bit for bit. observe: called with what every step of a swarm
    in the plane came to (``History``), those since the stop of one that goes on. on_better: called with each plan, and
    its report, that is better than all before it (``BetterPlans``), from one thread at a time; the plan may not meet
    its demand yet. It changes nothing of what is found. executor: workers for what can be done side by side (patrol's
    annealings and repairs), from ``rota.engines``; None: this process alone. The plan is the same, sooner. What is done
    there tells ``watch`` nothing, and ``on_better`` only what passed.

    Raises NoPlanFound (with the best plan there is) when no plan passes the check; MissionError for a time limit that
    is not greater than 0 or a mission that the planner cannot use; CheckpointError for a run of another one or seed.
    """
    if time_limit_s is not None and not time_limit_s > 0:
        raise MissionError(f"time_limit_s: {time_limit_s!r} is not allowed; must be greater than 0, or None")
    judge = _Judge(mission, watch, on_better)
    stop = _StopRule(time_limit_s, should_stop)
    planner = planner_of(mission)
    judge.get_ready()
    if not mission.planning.makes_runs and (resume is not None or observe is not None):
        what = "makes no runs that can be gone on with" if resume is not None else "has no steps to measure"
        raise MissionError(f"planner: {mission.planning.planner} {what}; swarm does")
    request = Request(
        mission=mission, seed=seed, judge=judge, progress=progress or _no_progress, should_stop=stop, watch=watch,
        checkpoint=resume, observe=observe, executor=executor,
    )  # fmt: skip
    try:
        answer = planner.plan(request)
    except NoPlanFound as failure:
        if stop.stopped:
            raise NoPlanFound(
                f"{failure} (stopped early)", best=failure.best, checkpoint=failure.checkpoint, facts=failure.facts
            ) from failure
        raise
    report = judge(answer.plan)
    if report.verdict != "met":
        reason = f"the best plan found is not shown to meet the demand: {_judged(report)}"
        raise NoPlanFound(
            reason + (" (stopped early)" if stop.stopped else ""),
            best=answer.plan, checkpoint=answer.checkpoint, facts=answer.facts,
        )  # fmt: skip
    return PlanSearch(answer=answer, report=report, stopped_early=stop.stopped)


def _judged(report: Report) -> str:
    """The verdict, and the first thing that is wrong."""
    verdict, wrong = f"the check says {report.verdict!r}", report.violations
    more = f", and {len(wrong) - 1} more" if len(wrong) > 1 else ""
    return f"{verdict} ({wrong[0].text()}{more})" if wrong else verdict


class _Judge:
    """The check as a planner sees it; remembers its last report, since the plan judged last is mostly the one given."""

    def __init__(self, mission: Mission, watch: Watch | None, on_better: OnBetter | None) -> None:
        self._last: tuple[Plan, Report] | None = None
        self._better = None if on_better is None else BetterPlans(mission, on_better)
        self._mission = mission
        self._watch = watch
        self._ready = threading.Thread(target=_made_ready, args=(mission,), daemon=True)

    def __reduce__(self) -> tuple[type[_Judge], tuple[object, ...]]:
        """Sent to another process it judges there, and tells nobody."""
        return _Judge, (self._mission, None, None)

    def get_ready(self) -> None:
        """Begin the check's work on the mission alone, while the planner makes its first plan."""
        self._ready.start()

    def __call__(self, plan: Plan) -> Report:
        from rota.check import check_plan

        last = self._last  # which another thread may change
        if last is None or last[0] is not plan:
            if self._ready.is_alive():
                self._ready.join()
            # on the way planners try longer periods, of which the bound that the plan claims says nothing
            claims = plan.mission is self._mission
            judged = plan if claims else replace(plan, lower_bound_robots=None, lower_bound_reason=None)
            self._last = last = (plan, check_plan(judged))
            # plans for parts of the area tell nothing of how far the whole has come
            if self._watch is not None and plan.mission.area == self._mission.area:
                self._watch(checked_state(*last))
            if self._better is not None:
                self._better.judged(*last)
        return last[1]


def _made_ready(mission: Mission) -> None:
    """Do the check's work on the mission alone."""
    from rota.check import get_ready

    with suppress(Exception):  # what is wrong with the mission, the check tells
        get_ready(mission)


class _StopRule:
    """True once the time is up or the caller says so, and from then on; ``stopped`` tells whether it was asked so."""

    def __init__(self, time_limit_s: float | None, should_stop: ShouldStop | None) -> None:
        self._deadline_s = None if time_limit_s is None else time.monotonic() + time_limit_s
        self._should_stop = should_stop
        self.stopped = False

    def __call__(self) -> bool:
        if not self.stopped:
            late = self._deadline_s is not None and time.monotonic() >= self._deadline_s
            self.stopped = late or (self._should_stop is not None and self._should_stop())
        return self.stopped


def _no_progress(fraction: float, doing: str) -> None:
    pass
