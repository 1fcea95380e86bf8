"""``rota plan`` and ``rota check`` of one mission: what they took and what came out."""

from __future__ import annotations

import functools
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.shell import PATIENCE_S, Run, rota
from benchmarks.warm_cache import measured_warm


@dataclass(frozen=True, kw_only=True)
class Planned:
    """One planning and checking. ``report``: what ``rota check --json`` printed; None when either command failed."""

    plan: Run
    check: Run | None
    report: dict[str, Any] | None

    @property
    def wall_s(self) -> float:
        """Seconds for both commands."""
        return self.plan.wall_s + (self.check.wall_s if self.check else 0.0)

    @property
    def peak_bytes(self) -> int:
        """The larger of both commands' memory."""
        return max(self.plan.peak_bytes, self.check.peak_bytes if self.check else 0)

    @property
    def cpu_s(self) -> float:
        """Processor time of both commands: what tells when other work slows the machine down."""
        return self.plan.cpu_s + (self.check.cpu_s if self.check else 0.0)

    @property
    def met(self) -> bool:
        """Whether there is a plan and the check passed it."""
        return self.report is not None and self.report["verdict"] == "met"


def plan_and_check(
    mission: Path,
    folder: Path,
    environment: Mapping[str, str] | None = None,
    *,
    effort: str | None = "quick",
    patience_s: float = PATIENCE_S,
) -> Planned:
    """Plan ``mission`` and check the plan, which is left in ``folder``; neither for longer than ``patience_s``.

    ``effort`` None: for a planner that has none.
    """
    plan_file = plan_file_of(mission, folder)
    asked = () if effort is None else ("--effort", effort)
    plan = rota("plan", mission, *asked, "-o", plan_file, environment=environment, patience_s=patience_s)
    if plan.code != 0:
        return Planned(plan=plan, check=None, report=None)
    check = rota("check", plan_file, "--json", environment=environment, patience_s=patience_s)
    return Planned(plan=plan, check=check, report=json.loads(check.out) if check.out.startswith("{") else None)


def plan_file_of(mission: Path, folder: Path) -> Path:
    """Where ``plan_and_check`` leaves the plan."""
    return folder / f"{mission.stem}.rota.json"


@functools.cache
def planned_warm(mission: Path, folder: Path, effort: str | None = "quick") -> tuple[Planned, ...]:
    """The same with a warm cache, repeated while short; measured once, although two figures may ask for it."""
    return tuple(measured_warm(lambda: plan_and_check(mission, folder, effort=effort), lambda planned: planned.wall_s))


def met_with(runs: Sequence[Planned]) -> int | None:
    """The robots of a plan that the check passes; None when any run failed."""
    reports = [planned.report for planned in runs]
    if any(report is None or report["verdict"] != "met" for report in reports):
        return None
    return reports[0]["robots"]


def told(runs: Sequence[Planned]) -> str:
    """The measured cell of the table: seconds, memory, robots, bound and verdict, or what went wrong."""
    for planned in runs:
        if planned.check is None or planned.report is None:
            return (planned.check or planned.plan).failure()
    median, report = median_run(runs), runs[0].report
    took = f"{median.wall_s:.1f} s (plan {median.plan.wall_s:.1f}, check {median.check.wall_s:.1f})"
    robots = f"{report['robots']} robots (bound {report['lower_bound_robots']})"
    return f"{took}, {peak(runs)}; {robots}, {report['verdict']}"


def worst_ratio(report: Mapping[str, Any]) -> float:
    """The worst gap over its period, of all demands of a report; inf where something is not shown to be seen."""
    gaps = [(demand["worst_gap_s"], demand["period_s"]) for demand in report["demands"]]
    return max((math.inf if gap_s is None else gap_s / period_s for gap_s, period_s in gaps), default=0.0)


def median_run(runs: Sequence[Planned]) -> Planned:
    """The run that took the median wall time (their number is odd)."""
    return sorted(runs, key=lambda planned: planned.wall_s)[len(runs) // 2]


def peak(runs: Sequence[Planned | Run]) -> str:
    """The most memory of any of the runs, for people."""
    return f"{max(measured.peak_bytes for measured in runs) / 1e6:.0f} MB"
