"""What `rota plan` does once its mission is read: search, write, and say what came of it."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

from rich.console import Console

from rota.command.checkpoint import keep_checkpoint
from rota.command.exit_codes import DONE, NO_PLAN
from rota.command.terminal import STANDARD_STREAM, progress_bar, say
from rota.errors import NoPlanFound

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from rota.check import Report
    from rota.checkpoint import Checkpoint
    from rota.command.interrupt import StopFlag
    from rota.mission import Mission
    from rota.plan import Plan
    from rota.planner import Answer


def plan_and_write(
    mission: Mission,
    target: str,
    seed: int,
    time_limit_s: float | None,
    best: bool,
    resume: tuple[str | None, Checkpoint | None],
    metrics: str | None = None,
    executor: Executor | None = None,
) -> int:
    """Plan, check, write and tell the outcome; returns the exit code. resume: a run file's path and what it holds.

    metrics: where the measures of every step of a swarm are written to, as CSV. executor: as ``search_plan`` takes it.
    """
    from rota.check import check_plan
    from rota.command.interrupt import stop_on_interrupt
    from rota.make_plan import search_plan
    from rota.planner import Answer

    reason = None
    histories: list[Any] = []  # the measures of every step
    with progress_bar() as bar, stop_on_interrupt(bar.announce_stop) as stop:
        try:
            search = search_plan(
                mission, seed=seed, time_limit_s=time_limit_s, progress=bar.show, should_stop=stop, resume=resume[1],
                observe=None if metrics is None else histories.append, on_better=bar.show_better, executor=executor,
            )  # fmt: skip
            answer, report, early = search.answer, search.report, search.stopped_early
        except NoPlanFound as failure:
            reason, early = failure, False
            checkpoint: Checkpoint | None = failure.checkpoint  # type: ignore[assignment]
            if not best or failure.best is None:
                _write_metrics(histories, metrics)
                if checkpoint is not None:
                    keep_checkpoint(checkpoint, target, resume[0])
                return _say_no_plan(failure, stop, "no plan" if checkpoint is not None else "nothing")
            answer = Answer(plan=failure.best, facts=failure.facts, checkpoint=checkpoint)  # type: ignore[arg-type]
            report = check_plan(answer.plan)
    _write_plan(answer.plan, target, meets_demand=reason is None)
    _write_metrics(histories, metrics)
    _show_outcome(answer, report, target)
    if answer.checkpoint is not None:
        keep_checkpoint(answer.checkpoint, target, resume[0])
    if stop.raised:
        say("interrupted: this is the best plan so far")
    elif early:
        say("stopped early by the time limit: this is the best plan so far")
    if reason is not None:
        say(f"no plan: {reason}")
        say("this is the best plan found; it does NOT meet its demand and its file is marked so")
    return stop.exit_code or (DONE if reason is None else NO_PLAN)


def _say_no_plan(failure: NoPlanFound, stop: StopFlag, what: str) -> int:
    if stop.raised:
        say(f"interrupted before a plan passed the check; {what} is written")
    say(f"no plan: {failure}")
    if failure.best is not None:
        say("--best writes the best plan found, which does not meet its demand")
    return stop.exit_code or NO_PLAN


def _write_plan(answer: Plan, target: str, *, meets_demand: bool) -> None:
    from rota.files.plan_file import plan_text, write_plan

    if target == STANDARD_STREAM:
        sys.stdout.write(plan_text(answer, meets_demand=meets_demand))
        sys.stdout.flush()
    else:
        write_plan(answer, target, meets_demand=meets_demand)


def _write_metrics(histories: list[Any], path: str | None) -> None:
    from rota.files.atomic_write import write_atomically

    for history in histories:
        write_atomically(str(path), history.csv())


def _show_outcome(answer: Answer, report: Report, target: str) -> None:
    from rota.check import met_text, report_table
    from rota.planner import planner_of

    console = Console(stderr=target == STANDARD_STREAM, highlight=False)
    for paragraph in planner_of(answer.plan.mission).sentences(answer, report):
        if paragraph is not None:
            console.print(paragraph, markup=False, soft_wrap=True)
    if report.verdict == "met":
        console.print(f"Check: {met_text(report)}")
    else:
        console.print(f"Check: {report.verdict}. The plan does not meet its demand.\n")
        console.print(report_table(report), markup=False, soft_wrap=True)
    if target != STANDARD_STREAM:
        console.print(f"Plan: {target}", markup=False, soft_wrap=True)
