"""What `rota plan` does once its mission is read: search, write, and say what came of it."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rich.console import Console

from rota.command.checkpoint import keep_checkpoint
from rota.command.exit_codes import DONE, NO_PLAN
from rota.command.partial_plan import PartialPlan
from rota.command.terminal import STANDARD_STREAM, Bar, progress_bar, say
from rota.command.without_mass import without_mass
from rota.errors import NoPlanFound, RotaError

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from rota.check import Report
    from rota.model.mission import Mission
    from rota.model.plan import Plan
    from rota.planning.checkpoint import Checkpoint
    from rota.planning.make_plan import PlanSearch
    from rota.planning.planner import Answer


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
    from rota.command.interrupt import stop_on_interrupt
    from rota.planning.make_plan import search_plan

    histories: list[Any] = []  # the measures of every step
    partial, bar = PartialPlan(target), Bar(None)

    def better(plan: Plan, report: Report) -> None:
        partial.keep_better(plan, report)
        bar.show_better(plan, report)

    with stop_on_interrupt(lambda by: bar.announce_stop(by)) as stop:
        found: PlanSearch | NoPlanFound
        try:
            with progress_bar() as bar:
                found = search_plan(
                    mission, seed=seed, time_limit_s=time_limit_s, progress=bar.show, should_stop=stop,
                    resume=resume[1], observe=None if metrics is None else histories.append, on_better=better,
                    on_candidate=partial.keep_candidate, executor=executor,
                )  # fmt: skip
        except NoPlanFound as failure:
            found = failure
        except BaseException:
            partial.tell()
            raise
        ended = stop.exit_code  # what comes from here on is too late to stop anything
        if isinstance(found, NoPlanFound):
            code = _without_plan(found, target, ended, best, resume[0], partial)
            _write_metrics(histories, metrics)
            return code
        _write_outcome(found.answer, found.report, target, resume[0], partial, meets_demand=True)
        _write_metrics(histories, metrics)
    if ended:
        say("interrupted: this is the best plan so far")
    elif found.stopped_early:
        say("stopped early by the time limit: this is the best plan so far")
    return ended or DONE


def _without_plan(
    failure: NoPlanFound, target: str, ended: int, best: bool, resumed: str | None, partial: PartialPlan
) -> int:
    """What there is after a search that found no plan: with ``--best`` its best one, else that beside the target."""
    from rota.planning.planner import Answer

    checkpoint: Checkpoint | None = failure.checkpoint  # type: ignore[assignment]
    plan: Plan | None = failure.best  # type: ignore[assignment]
    report: Report | None = failure.report  # type: ignore[assignment]
    if best and plan is not None:
        answer = Answer(plan=plan, facts=failure.facts, checkpoint=checkpoint)
        _write_outcome(answer, report, target, resumed, partial, meets_demand=False)
        if ended:
            say("interrupted: this is the best plan so far")
        say(f"no plan: {failure}")
        misses = "it was not checked to the end" if report is None else "it does NOT meet its demand"
        say(f"this is the best plan found; {misses} and its file is marked so")
        return ended or NO_PLAN
    if plan is not None:
        partial.keep(plan, meets_demand=False)
    if checkpoint is not None:
        keep_checkpoint(checkpoint, target, resumed)
    if ended:
        say("interrupted before a plan passed the check; no plan is written")
    say(f"no plan: {failure}")
    partial.tell()
    if plan is not None:
        say("--best writes the best plan found, which does not meet its demand")
    return ended or NO_PLAN


def _write_outcome(
    answer: Answer,
    report: Report | None,
    target: str,
    resumed: str | None,
    partial: PartialPlan,
    *,
    meets_demand: bool,
) -> None:
    """Write the plan, tell what it comes to, and keep a run that can be gone on with."""
    try:
        write_or_print(answer.plan, target, meets_demand=meets_demand)
    except RotaError:
        partial.tell()
        raise
    partial.remove()
    _show_outcome(answer, report, target)
    if answer.checkpoint is not None:
        keep_checkpoint(answer.checkpoint, target, resumed)


def write_or_print(answer: Plan, target: str, *, meets_demand: bool) -> None:
    """Write a plan file, or print it where the target is ``-``."""
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


def _show_outcome(answer: Answer, report: Report | None, target: str) -> None:
    """Print what the planner says of its plan and what the check says."""
    from rota.check import met_text, report_table
    from rota.planning.planner import planner_of

    console = Console(stderr=target == STANDARD_STREAM, highlight=False)
    planner = planner_of(answer.plan.mission)
    for paragraph in answer.facts if report is None else planner.sentences(answer, report):
        if paragraph is not None:
            console.print(paragraph, markup=False, soft_wrap=True)
    if report is None:
        console.print("Check: not checked to the end.")
    elif report.verdict == "met":
        console.print(f"Check: {met_text(report)}")
        for sentence in _reserves(answer.plan, report):
            console.print(sentence, markup=False, soft_wrap=True)
        told = without_mass(answer.plan) if report.demands else None
        if told is not None:
            console.print(f"The plan is {told}.", markup=False, soft_wrap=True)
    else:
        console.print(f"Check: {report.verdict}. The plan does not meet its demand.\n")
        console.print(report_table(report), markup=False, soft_wrap=True)
    if target != STANDARD_STREAM:
        console.print(f"Plan: {target}", markup=False, soft_wrap=True)


def _reserves(plan: Plan, report: Report) -> list[str]:
    """What a plan that is met has to spare, and what one robot more or less brings."""
    from rota.check import margins_of
    from rota.planning.one_robot_more import one_robot_sentence

    report = replace(report, margins=margins_of(plan, report))
    if not report.margins:
        return []
    reserves = [margin.text() for margin in report.margins]
    one_robot = one_robot_sentence(plan, report)
    return [*(f"L{reserve[1:]}." for reserve in reserves), *([one_robot] if one_robot else [])]
