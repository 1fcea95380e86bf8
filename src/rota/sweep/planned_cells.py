"""What a worker does for a sweep: plan missions, check the plans as their files read back, and measure both."""

from __future__ import annotations

import itertools
import os
import platform
import sys
import time
import traceback
from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rota.engines.workers import cores
from rota.errors import NoPlanFound, RotaError

if TYPE_CHECKING:
    from rota.model.mission import Mission
    from rota.model.plan import Plan

Row = dict[str, Any]


class Task(NamedTuple):
    """A cell as a worker is given it."""

    mission: Mission
    seed: int
    time_limit_s: float | None


class Planned(NamedTuple):
    """What became of a cell: its columns, and the text of its plan file if there is a plan."""

    row: Row
    plan_text: str | None


_planned_before = itertools.count()  # cells, by this process


def planned_cells(tasks: Sequence[Task], rota_version: str) -> list[Planned]:
    """Plan each of the missions. Whatever goes wrong is an outcome: a failure of one does not touch the others."""
    return [planned_cell(task, rota_version) for task in tasks]


def planned_cell(task: Task, rota_version: str) -> Planned:
    """Plan one mission, and check its plan as it reads back. rota_version: of who asks, and no other must plan."""
    row: Row = {
        "started_at": datetime.now(UTC).isoformat(timespec="milliseconds"), "rota_version": version("rota"),
        "python_version": platform.python_version(), "machine": platform.node(), "system": platform.platform(),
        "cores": cores(), "process": os.getpid(), "planned_before": next(_planned_before),
    }  # fmt: skip
    text = None
    reset_peak_memory()
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    try:
        if row["rota_version"] != rota_version:
            raise RuntimeError(f"{row['machine']} has rota {row['rota_version']}, the sweep's is {rota_version}")
        plan, outcome = search(task)
        row |= outcome
        row |= {"wall_s": time.perf_counter() - wall_s, "cpu_s": time.process_time() - cpu_s}
        if plan is not None:
            text, judged = check(plan, met=row["outcome"] == "met")
            row |= judged
    except Exception as error:  # whatever it is, it is a finding, and the others go on
        row |= {"outcome": "crashed", "reason": error_in_words(error)}
        text = None
    row.setdefault("wall_s", time.perf_counter() - wall_s)
    row.setdefault("cpu_s", time.process_time() - cpu_s)
    row["peak_memory_mb"] = peak_memory_mb()
    return Planned(row, text)


def search(task: Task) -> tuple[Plan | None, Row]:
    """The plan of a search, or the best one of a search that failed, with the outcome and its reason."""
    from rota.model.plan import Plan
    from rota.planning.make_plan import search_plan

    runs: list[Any] = []
    observe = runs.append if task.mission.planning.makes_runs else None
    try:
        found = search_plan(task.mission, seed=task.seed, time_limit_s=task.time_limit_s, observe=observe)
    except NoPlanFound as failure:
        # without a report its check was stopped, and another would take as long
        best = failure.best if isinstance(failure.best, Plan) and failure.report is not None else None
        stopped = str(failure).endswith("(stopped early)")
        return best, {"outcome": "no plan", "reason": str(failure), "stopped_early": stopped}
    except RotaError as error:
        return None, {"outcome": "refused", "reason": str(error)}
    reason = f"the best plan within {task.time_limit_s:g} s" if found.stopped_early else None
    row: Row = {"outcome": "met", "reason": reason, "stopped_early": found.stopped_early}
    if runs:
        row |= {"coverage": float(runs[-1].coverage[-1]), "steps": runs[-1].first_step + runs[-1].steps}
    return found.plan, row


def check(plan: Plan, *, met: bool) -> tuple[str, Row]:
    """The text of a plan's file, and what there is to say of the plan that it reads back to.

    met: the search says so; a check that does not is a fault of ours, and the outcome says so.
    """
    from rota.check import check_plan, report_to_json
    from rota.files.plan_file import plan_from_text, plan_text
    from rota.routes.distinct_loops import distinct_loops

    text = plan_text(plan, meets_demand=met)
    began_s = time.perf_counter()
    report = check_plan(plan_from_text(text.encode(), "plan"))
    told_of = report_to_json(report)
    loops_m = [trajectory.loop_length_m for trajectory in distinct_loops(plan)]
    row: Row = {
        "verdict": report.verdict, "check_s": time.perf_counter() - began_s,
        "robots": len(plan.trajectories), "lower_bound_robots": plan.lower_bound_robots,
        "lower_bound_reason": plan.lower_bound_reason,
        "worst_gap_ratio": told_of["worst_ratio"], "worst_gap_ratio_at_least": told_of["worst_ratio_at_least"],
        "asked_area_m2": sum(demand.area_m2 for demand in report.demands),
        "unseen_area_m2": sum(demand.unseen_area_m2 for demand in report.demands),
        "first_coverage_s": told_of["first_coverage_s"], "violations": len(report.violations),
        "length_m": float(sum(loops_m)) if loops_m else None, "longest_loop_m": max(loops_m, default=None),
        "longest_loop_s": float(max((trajectory.loop_duration_s for trajectory in plan), default=0.0)),
    }  # fmt: skip
    if met and report.verdict != "met":
        row |= {"outcome": "crashed", "reason": f"the check says {report.verdict!r} of the plan as its file reads back"}
    return text, row


def error_in_words(error: Exception) -> str:
    """An exception that nobody expected, and where it was raised."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__} in {place.name}, {Path(place.filename).name}:{place.lineno}: {error}"


def reset_peak_memory() -> None:
    """Begin a new count of the most memory that the process takes, where the system has one."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def peak_memory_mb() -> float | None:
    """The most memory (10^6 bytes) of this process since the count began; without Linux, ever; None: not known."""
    with suppress(OSError, StopIteration):
        lines = Path("/proc/self/status").read_text().splitlines()
        return int(next(line for line in lines if line.startswith("VmHWM:")).split()[1]) * 1024 / 1e6
    with suppress(ImportError):
        import resource

        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024) / 1e6
    return None
