"""One planning job in a process of its own: the mission as it was asked, each better plan kept, the last one told."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from rota.errors import NoPlanFound, RotaError
from rota.files.plan_file import plan_from_text, plan_text as text_of_plan
from rota.planning.make_plan import PlanSearch, search_plan
from rota.replanning.replan import replan
from rota.web.refusal import Json, Refusal
from rota.web.store.jobs import job_source
from rota.web.store.plans import NewPlan, finish_plan, forget_old_steps, forget_steps, keep_plan, plan_text
from rota.web.tasks.context import Context, lay_out
from rota.web.tasks.validate import faults_json, judged_document

if TYPE_CHECKING:
    from rota.check.report import Report
    from rota.model.mission import Mission
    from rota.model.plan import Plan

KEPT_STEPS = 2  # plans on the way that stay until another job begins: one may be on its way to a page
PROGRESS_EVERY_S = 0.1

Tell = Callable[[Json], None]


class PlanningJob:
    """A job that runs: it plans, keeps what gets better, and tells the server of both."""

    def __init__(self, context: Context, job: str, tell: Tell, stop: threading.Event) -> None:
        self._context, self._job, self._tell, self._stop = context, job, tell, stop
        self._began_s = time.monotonic()
        self._told_s = -1.0
        self._best: tuple[str, int] | None = None  # a plan on the way, and its robots
        self._source: Json = {}

    def run(self) -> Json:
        """Plan; returns what became of it: {outcome: done | no_plan | stopped | failed, message, plan}."""
        forget_old_steps(self._context.database)
        document, files, self._source = job_source(self._context.database, self._job)
        if self._source["change"] is not None:
            return self._replan(**self._source["change"])
        try:
            mission = self._mission(document, files)
        except RotaError as error:
            faults = error.faults if isinstance(error, Refusal) else []
            lines = [
                f"{fault['field']}: {fault['message']}" if fault["field"] else fault["message"] for fault in faults
            ]
            return self._outcome("failed", "\n".join([str(error), *lines]))
        try:
            search = search_plan(
                mission, seed=self._source["seed"], time_limit_s=self._source["time_limit_s"], progress=self._progress,
                should_stop=self._stop.is_set, on_better=self._better,
            )  # fmt: skip
        except NoPlanFound as failure:
            return self._no_plan(failure)
        except RotaError as error:
            return self._outcome("failed", str(error))
        return self._tell_found(search)

    def _mission(self, document: Json, files: dict[str, bytes]) -> Mission:
        """The mission that the job asks for, with its effort."""
        with lay_out(files) as folder:
            judged = judged_document(document, folder, self._context.vertices)
        if judged.mission is None:
            raise Refusal(422, "the mission has faults", faults_json(judged))
        effort = self._source["effort"]
        return judged.mission if effort is None else judged.mission.with_effort(effort)

    def _replan(self, plan: str, at_s: float, lost: list[str]) -> Json:
        """Replan from a moment of a plan on without these robots."""
        try:
            before = plan_from_text(plan_text(self._context.database, plan), "the plan")
            found = replan(
                before, at_s=at_s, lost=lost, seed=self._source["seed"], time_limit_s=self._source["time_limit_s"],
                should_stop=self._stop.is_set, progress=self._progress,
                on_better=lambda one: self._better(one.plan, one.report),
            )  # fmt: skip
        except NoPlanFound as failure:
            return self._no_plan(failure)
        except RotaError as error:
            return self._outcome("failed", str(error))
        met, stopped = found.meets_demand, self._stop.is_set()
        kept = self._keep(found.plan, found.report, (), is_better=False, partial=not met)
        message = None if met else "the robots that remain do not meet the demand: this is the least late plan found"
        return self._outcome("stopped" if stopped else "done", message, kept, len(found.plan.trajectories), met)

    def _progress(self, fraction: float, doing: str) -> None:
        now_s = time.monotonic()
        if now_s - self._told_s >= PROGRESS_EVERY_S or fraction >= 1:
            self._told_s = now_s
            self._tell({"event": "progress", "fraction": min(max(fraction, 0.0), 1.0), "doing": doing[:300]})

    def _better(self, plan: Plan, report: Report) -> None:
        """Keep a plan that is the best so far, and tell the server."""
        met, robots = report.verdict == "met", len(plan.trajectories)
        key = self._keep(plan, report, (), is_better=True)
        self._best = (key, robots)
        forget_steps(self._context.database, self._job, but=KEPT_STEPS)
        self._tell({"event": "better", "plan": key, "robots": robots, "met": met})

    def _keep(self, plan: Plan, report: Report, facts: tuple[str, ...], **more: bool) -> str:
        new = new_plan(plan, report, facts, plan_s=time.monotonic() - self._began_s, **more)
        source = self._source
        kept = {"mission": source["mission"], "job": self._job, "effort": source["effort"]}
        return keep_plan(self._context.database, NewPlan(**{**vars(new), **kept}), most=self._context.plans)

    def _tell_found(self, search: PlanSearch) -> Json:
        """The plan that the check passed."""
        stopped = self._stop.is_set()
        cut_short = stopped or search.stopped_early
        plan = self._keep(search.plan, search.report, search.facts, is_better=False, partial=cut_short)
        message = "stopped: this is the best plan so far" if stopped else None
        if message is None and search.stopped_early:
            message = "the time limit was reached: this is the best plan so far"
        return self._outcome("stopped" if stopped else "done", message, plan, len(search.plan.trajectories), True)

    def _no_plan(self, failure: NoPlanFound) -> Json:
        """The best plan that does not meet its demand, if there is one."""
        plan, robots = None, None
        best: Plan | None = failure.best  # type: ignore[assignment]
        report: Report | None = failure.report  # type: ignore[assignment]
        if best is not None and report is not None:  # None: not checked to the end
            plan = self._keep(best, report, failure.facts, is_better=False)
            robots = len(best.trajectories)
        elif self._best is not None:
            plan, robots = self._best
            finish_plan(self._context.database, plan)
        return self._outcome("stopped" if self._stop.is_set() else "no_plan", str(failure), plan, robots, False)

    def _outcome(
        self, outcome: str, message: str | None, plan: str | None = None, robots: int | None = None, met: bool = False
    ) -> Json:
        return {
            "event": "ended", "outcome": outcome, "message": message, "plan": plan, "robots": robots, "met": met,
        }  # fmt: skip


def new_plan(plan: Plan, report: Report, facts: tuple[str, ...], **more: object) -> NewPlan:
    """A plan with what lists show of it: the longest loop's worst ratio, the length of all loops, what was found."""
    from rota.check import report_to_json

    planning = plan.mission.planning
    told = report_to_json(report)
    values = {
        "name": plan.mission.name,
        "planner": planning.planner,
        "effort": getattr(planning, "effort", None),
        "robots": len(plan.trajectories),
        "bound": plan.lower_bound_robots,
        "bound_reason": plan.lower_bound_reason,
        "verdict": report.verdict,
        "worst_ratio": told["worst_ratio"] if report.verdict == "met" else told["worst_ratio_at_least"],
        "length_m": float(sum(trajectory.loop_length_m for trajectory in plan)),
        "partial": report.verdict != "met",
        "facts": facts,
        "report": told,
        "text": text_of_plan(plan, meets_demand=report.verdict == "met"),
    }
    return NewPlan(**{**values, **more})
