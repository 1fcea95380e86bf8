"""From a mission to a plan that the check passes: the mission's planner, a judge, a stop rule and a seed."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rota.errors import MissionError, NoPlanFound
from rota.model.refusals import require
from rota.planning.better_plans import BetterPlans, OnBetter, checked_state
from rota.planning.planner import Answer, Planner, Request, planner_of
from rota.planning.progress import Watch
from rota.planning.stopping import OwnThread, StopRule

if TYPE_CHECKING:
    from rota.check.report import Report
    from rota.model.mission import Mission
    from rota.model.plan import Plan
    from rota.planning.checkpoint import Checkpoint

Progress = Callable[[float, str], None]
ShouldStop = Callable[[], bool]
EARLY = " (stopped early)"  # the end of what NoPlanFound says of a search that was stopped


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
    on_candidate: Callable[[Plan], None] | None = None,
    executor: Executor | None = None,
) -> PlanSearch:
    """Plan ``mission`` with the planner that its settings name, and check the outcome.

    The search and the check run in a thread of their own, from which all callbacks come, while this one waits.

    seed: the same seed gives the same plan, unless the search is stopped early. time_limit_s: seconds after which the
    planner is asked to stop; it then gives the best plan so far. progress: called with a fraction 0..1 and what is
    being done. should_stop: asked now and then; True stops like the time limit. A search that has not come to its end
    after ``stopping.GRACE_S`` of processor time more is left, and its best plan so far is the outcome. watch: called
    with every state that the search comes to, from several threads; it changes nothing of what is found. resume: a
    swarm's run to go on with; the outcome is the plan of the same run without a stop, bit for bit. observe: called with
    what every step of a swarm in the plane came to (``History``), those since the stop of one that goes on. on_better:
    called with each plan, and its report, that is better than all before it (``BetterPlans``), from one thread at a
    time; the plan may not meet its demand yet. It changes nothing of what is found. on_candidate: called with each plan
    of the mission before its check begins, which may take long. executor: workers for what can be done side by side
    (patrol's annealings and repairs), from ``rota.engines``; None: this process alone. The plan is the same, sooner.
    What is done there tells ``watch`` nothing, and ``on_better`` only what passed.

    Raises NoPlanFound (with the best plan there is, and its report) when no plan passes the check; MissionError for a
    seed below 0, a time limit that is not greater than 0 or a mission that the planner cannot use; CheckpointError for
    a run of another one or seed.
    """
    if time_limit_s is not None and not time_limit_s > 0:
        raise MissionError(f"time_limit_s: {time_limit_s!r} is not allowed; must be greater than 0, or None")
    require(seed >= 0, "seed", seed, "must be at least 0")
    planner = planner_of(mission)
    _mention_compiling(planner, mission)
    _require_runs(mission, resumes=resume is not None, observed=observe is not None)
    shared = should_stop if isinstance(should_stop, StopRule) and time_limit_s is None else None
    stop = shared or StopRule(time_limit_s, should_stop)
    own = OwnThread(lambda: _search(planner, request, judge))
    watch, observe, on_better, on_candidate = (
        None if each is None else _while_awaited(own, each) for each in (watch, observe, on_better, on_candidate)
    )
    may_stop = time_limit_s is not None or should_stop is not None
    better = BetterPlans(mission, on_better, own.require_awaited) if may_stop or on_better is not None else None
    judge = _Judge(mission, watch, better, on_candidate, own.require_awaited)
    request = Request(
        mission=mission, seed=seed, judge=judge, progress=_while_awaited(own, progress or _no_progress),
        should_stop=stop, watch=watch, checkpoint=resume, observe=observe, executor=executor,
    )  # fmt: skip
    try:
        found = own.result(stop.is_spent)
    except KeyboardInterrupt:
        stop.stop()  # so that what is left ends soon
        raise
    return found if found is not None else judge.leave()


def _mention_compiling(planner: Planner, mission: Mission) -> None:
    from rota.check import compiled_packages
    from rota.compiled.compiled_cache import mention_compiling

    mention_compiling(*planner.compiled_packages(mission), *compiled_packages(mission))


def _require_runs(mission: Mission, *, resumes: bool, observed: bool) -> None:
    """MissionError for what only a planner that makes runs can be asked."""
    if not mission.planning.makes_runs and (resumes or observed):
        what = "makes no runs that can be gone on with" if resumes else "has no steps to measure"
        raise MissionError(f"planner: {mission.planning.planner} {what}; swarm does")


def _while_awaited(own: OwnThread[PlanSearch], callback: Callable[..., None]) -> Callable[..., None]:
    """The callback, which is not called any more once nobody waits for the search."""

    def tell(*what: object) -> None:
        own.require_awaited()
        callback(*what)

    return tell


def _search(planner: Planner, request: Request, judge: _Judge) -> PlanSearch:
    """The planner's answer, and the check's report on it, which every NoPlanFound has as well."""
    from rota.planning.near_origin import plan_near_origin

    stop = request.should_stop
    assert isinstance(stop, StopRule)
    judge.get_ready()
    try:
        answer = plan_near_origin(planner, request)
    except NoPlanFound as failure:
        passed = judge.passed if stop.stopped else None
        if passed is not None:
            return passed
        if failure.best is not None and failure.report is None:
            failure.report = judge(failure.best)  # type: ignore[arg-type]
        if stop.stopped:
            raise NoPlanFound(
                f"{failure}{EARLY}", best=failure.best, checkpoint=failure.checkpoint, facts=failure.facts,
                report=failure.report,
            ) from failure  # fmt: skip
        raise
    report = judge(answer.plan)
    if report.verdict != "met":
        if stop.stopped and judge.passed is not None:
            return judge.passed
        reason = f"the best plan found is not shown to meet the demand: {_verdict_in_words(report)}"
        raise NoPlanFound(
            reason + (EARLY if stop.stopped else ""),
            best=answer.plan, checkpoint=answer.checkpoint, facts=answer.facts, report=report,
        )  # fmt: skip
    return PlanSearch(answer=answer, report=report, stopped_early=stop.stopped)


def _verdict_in_words(report: Report) -> str:
    """The verdict, and the first thing that is wrong."""
    verdict, wrong = f"the check says {report.verdict!r}", report.violations
    more = f", and {len(wrong) - 1} more" if len(wrong) > 1 else ""
    return f"{verdict} ({wrong[0].text()}{more})" if wrong else verdict


class _Judge:
    """The check as a planner sees it; remembers its last report, since the plan judged last is mostly the one given."""

    def __init__(
        self,
        mission: Mission,
        watch: Watch | None,
        better: BetterPlans | None,
        on_candidate: Callable[[Plan], None] | None,
        on_the_way: Callable[[], None] | None,
    ) -> None:
        self._last: tuple[Plan, Report] | None = None
        self._unchecked: Plan | None = None  # whose check has begun
        self._mission, self._watch, self._better = mission, watch, better
        self._on_candidate, self._on_the_way = on_candidate, on_the_way
        self._ready = threading.Thread(target=_made_ready, args=(mission,), daemon=True)

    def __reduce__(self) -> tuple[type[_Judge], tuple[object, ...]]:
        """Sent to another process it judges there, and tells nobody."""
        return _Judge, (self._mission, None, None, None, None)

    def get_ready(self) -> None:
        """Begin the check's work on the mission alone, while the planner makes its first plan."""
        from rota.check import load

        load()
        self._ready.start()

    def __call__(self, plan: Plan) -> Report:
        from rota.check import check_plan

        last = self._last  # which another thread may change
        if last is None or last[0] is not plan:
            if self._ready.is_alive():
                self._ready.join()
            # on the way planners try longer periods, of which the bound that the plan claims says nothing
            claims = plan.mission is self._mission
            judged = plan if claims else plan.without_bound()
            if claims:
                self._unchecked = plan
                if self._on_candidate is not None:
                    self._on_candidate(plan)
            self._last = last = (plan, check_plan(judged, on_the_way=self._on_the_way))
            self._unchecked = None
            # plans for parts of the area tell nothing of how far the whole has come
            if self._watch is not None and plan.mission.area == self._mission.area:
                self._watch(checked_state(*last))
            if self._better is not None:
                self._better.note(*last)
        return last[1]

    @property
    def passed(self) -> PlanSearch | None:
        """The best plan that passed, of a search that may be stopped, as the outcome of one that was; or None."""
        best = None if self._better is None else self._better.best
        if best is None or best[1].verdict != "met":
            return None
        return PlanSearch(answer=Answer(plan=best[0]), report=best[1], stopped_early=True)

    def leave(self) -> PlanSearch:
        """The outcome of a search that was left: its best plan so far, or NoPlanFound with the best there is."""
        if self.passed is not None:
            return self.passed
        plan, report = (self._better and self._better.best) or (self._unchecked, None)
        reason = "the search did not come to an end in time after it was to stop"
        if report is not None:
            reason += f"; the best plan so far is not shown to meet the demand: {_verdict_in_words(report)}"
        elif plan is not None:
            reason += "; its best plan so far was not checked to the end"
        raise NoPlanFound(reason + EARLY, best=plan, report=report)


def _made_ready(mission: Mission) -> None:
    """Do the check's work on the mission alone."""
    from rota.check import get_ready

    with suppress(Exception):  # what is wrong with the mission, the check tells
        get_ready(mission)


def _no_progress(fraction: float, doing: str) -> None:
    pass
