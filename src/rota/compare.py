"""One mission planned by several methods: robots, loops, worst gap and time side by side."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rota.errors import MissionError, NoPlanFound, RotaError
from rota.model.columns import columns
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.model.planner_registry import DEFAULT
from rota.planning.make_plan import search_plan
from rota.planning.planner import planner_named, planner_of
from rota.planning.stopping import StopRule
from rota.routes.distinct_loops import distinct_loops

if TYPE_CHECKING:
    from rota.check.report import Report

HEAD = ("method", "robots", "lower bound", "loops m", "worst gap / period", "time s", "outcome")


@dataclass(frozen=True, kw_only=True)
class MethodOutcome:
    """What one method came to. ``plan``: its plan, or the best one that failed, or None; ``report``: the check of it.

    planning_s: seconds of search and of the judging within it. reason: why there is no plan that meets the demand.
    """

    method: str
    plan: Plan | None
    report: Report | None
    planning_s: float
    reason: str | None = None
    stopped_early: bool = False

    @property
    def met(self) -> bool:
        """Whether the method found a plan that the check passes."""
        return self.reason is None

    @property
    def robots(self) -> int | None:
        """Robots of the plan."""
        return None if self.plan is None else len(self.plan.trajectories)

    @property
    def lower_bound_robots(self) -> int | None:
        """Robots below which no plan exists, proved; None when no plan came with it."""
        return None if self.plan is None else self.plan.lower_bound_robots

    @property
    def loops_m(self) -> float | None:
        """Length of all loops in metres; one that several robots share counts once."""
        return None if self.plan is None else sum(loop.loop_length_m for loop in distinct_loops(self.plan))

    @property
    def worst_ratio(self) -> float | None:
        """The worst gap over its period, of all demands; inf where something is not shown to be seen."""
        if self.report is None:
            return None
        return max((demand.worst_gap_s / demand.period_s for demand in self.report.demands), default=0.0)

    @property
    def outcome(self) -> str:
        """Met, or why not."""
        early = " (stopped early)" if self.stopped_early else ""
        return f"met{early}" if self.reason is None else f"no plan: {self.reason}"


def compare_methods(
    mission: Mission,
    methods: Sequence[str] | None = None,
    *,
    seed: int = 0,
    progress: Callable[[float, str], None] | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> tuple[MethodOutcome, ...]:
    """Plan ``mission`` with each of its planner's methods, or of those given, in their order; check the outcomes.

    seed: the same for all. progress: called with a fraction 0..1 and what is being done. should_stop: asked now and
    then; True makes the methods that are left give what they have at once, all in the time that one of them has. A
    method that finds no plan is an outcome with a reason. Raises MissionError for no methods, a method given twice, or
    one that is not known.
    """
    tell = progress or (lambda fraction, doing: None)
    methods = named_methods(mission, None) if methods is None else methods
    if not methods:
        raise MissionError(f"methods: none is given; {', '.join(planner_of(mission).methods)} are known")
    for method in methods:
        if list(methods).count(method) > 1:
            raise MissionError(f"methods: {method!r} is given twice")
    asked = [mission.with_method(method) for method in methods]
    stop = StopRule(should_stop=should_stop)  # once for all: what a stop leaves is not given to each of them
    tell(0.0, "loading")
    load_compiled_loops(mission.planning.planner)
    outcomes = []
    for k, by_method in enumerate(asked):

        def tell_of_method(fraction: float, doing: str, k: int = k) -> None:
            tell((k + fraction) / len(asked), f"{methods[k]}: {doing}")

        outcomes.append(outcome_of(by_method, seed=seed, progress=tell_of_method, should_stop=stop))
    return tuple(outcomes)


def named_methods(mission: Mission, listed: str | None) -> tuple[str, ...]:
    """The methods of a list of names with commas, all of the mission's planner for None.

    Raises MissionError for a planner that has no methods to compare and for an unknown name.
    """
    known = planner_of(mission).methods
    if not known:
        raise MissionError(f"methods: the {mission.planning.planner} planner has none that could be compared")
    if listed is None:
        return known
    names = tuple(name.strip() for name in listed.split(","))
    for name in names:
        if name not in known:
            raise MissionError(f"methods: {name!r} is not known; {', '.join(known)} are")
    return names


def outcome_of(
    mission: Mission,
    *,
    seed: int,
    progress: Callable[[float, str], None],
    should_stop: Callable[[], bool] | None,
) -> MethodOutcome:
    """Plan the mission by the method of its settings; a search that fails is an outcome too."""
    method = mission.planning.method or ""
    started_s = time.perf_counter()
    try:
        search = search_plan(mission, seed=seed, progress=progress, should_stop=should_stop)
    except MissionError:
        raise
    except RotaError as failure:
        planning_s = time.perf_counter() - started_s
        best = failure.best if isinstance(failure, NoPlanFound) and isinstance(failure.best, Plan) else None
        report: Report | None = failure.report if isinstance(failure, NoPlanFound) else None  # type: ignore[assignment]
        if report is None:  # the check was stopped
            best = None
        return MethodOutcome(method=method, plan=best, report=report, planning_s=planning_s, reason=str(failure))
    planning_s = time.perf_counter() - started_s
    return MethodOutcome(
        method=method,
        plan=search.plan,
        report=search.report,
        planning_s=planning_s,
        stopped_early=search.stopped_early,
    )


def load_compiled_loops(planner: str = DEFAULT) -> None:
    """Plan the planner's small mission, so that no method's time holds what the first one spends on loading loops."""
    small = planner_named(planner).small_mission()
    if small is None:
        return
    with suppress(NoPlanFound):
        search_plan(small)


def comparison_table(outcomes: Sequence[MethodOutcome]) -> str:
    """The outcomes as plain text, a row each."""
    return columns([HEAD, *(_row(outcome) for outcome in outcomes)], (0, len(HEAD) - 1))


def _row(outcome: MethodOutcome) -> tuple[str, ...]:
    """A method as a row of the table, in the order of ``HEAD``."""

    def value_in_words(value: float | None, form: str) -> str:
        return "-" if value is None else "never" if value == math.inf else format(value, form)

    return (
        outcome.method,
        value_in_words(outcome.robots, "d"),
        value_in_words(outcome.lower_bound_robots, "d"),
        value_in_words(outcome.loops_m, ".1f"),
        value_in_words(outcome.worst_ratio, ".3f"),
        value_in_words(outcome.planning_s, ".1f"),
        outcome.outcome,
    )


def comparison_to_json(mission: Mission, outcomes: Sequence[MethodOutcome], seed: int) -> dict[str, Any]:
    """The outcomes as plain values for JSON; a gap without end is null, as it is where there is no plan."""
    return {
        "rota_comparison": 1,
        "mission": mission.name,
        "effort": mission.planning.effort,
        "seed": seed,
        "methods": [
            {
                "method": outcome.method,
                "met": outcome.met,
                "robots": outcome.robots,
                "lower_bound_robots": outcome.lower_bound_robots,
                "loops_m": outcome.loops_m,
                "worst_ratio": None if outcome.worst_ratio == math.inf else outcome.worst_ratio,
                "planning_s": outcome.planning_s,
                "stopped_early": outcome.stopped_early,
                "reason": outcome.reason,
            }
            for outcome in outcomes
        ],
    }


def draw_outcomes(mission: Mission, outcomes: Sequence[MethodOutcome], path: str | Path) -> None:
    """Draw the plans side by side to a PNG, SVG or PDF file; see ``rota.draw.draw_comparison``."""
    from rota.draw import Panel, draw_comparison

    panels = [Panel(title=o.method, caption=caption(o), plan=o.plan, met=o.met) for o in outcomes]
    draw_comparison(mission, panels, path)


def caption(outcome: MethodOutcome) -> str:
    """What a plan comes to, in a few words."""
    if outcome.plan is None or outcome.loops_m is None or outcome.worst_ratio is None:
        return outcome.outcome
    robots = f"{outcome.robots} robot{'' if outcome.robots == 1 else 's'}"
    ratio = "some of it is never seen" if math.isinf(outcome.worst_ratio) else f"worst gap {outcome.worst_ratio:.2f}"
    return f"{robots} · loops {outcome.loops_m:,.0f} m · {ratio}{'' if outcome.met else ' · not met'}"
