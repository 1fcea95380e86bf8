"""The method of Sun et al. 2019 as a whole, on its cases: with our routes, with repaired ones, and as printed.

CPU seconds of planning, the search's own checks included, with everything compiled.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

from benchmarks.missions import EXAMPLES
from benchmarks.row import Options, Row
from benchmarks.sun_cases import CASES, FIGURE_16, Case, write_case
from rota.check import check_plan
from rota.check.report import Report
from rota.errors import NoPlanFound
from rota.files.mission_file import read_mission
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planners.patrol.planner_settings import Effort
from rota.planning.make_plan import make_plan
from rota_studies.sun2019.printed_settings import AS_PRINTED, AS_PRINTED_FIGURE_16
from rota_studies.sun2019_method.mission_settings import Sun2019

OURS, REPAIRED = Sun2019(), Sun2019(routes="repaired")
PRINTED = {CASES[-1]: ("Tables 2, 3 and 4", AS_PRINTED), FIGURE_16: ("Tables 7, 3 and 4", AS_PRINTED_FIGURE_16)}


class Tried(NamedTuple):
    """The best plan for a case, the check's report on it, and the CPU seconds it took."""

    plan: Plan
    report: Report
    cpu_s: float

    @property
    def met(self) -> bool:
        """Whether the plan passed."""
        return self.report.verdict == "met"

    @property
    def robots(self) -> int:
        """Of the plan."""
        return len(self.plan.trajectories)

    @property
    def told(self) -> str:
        """Robots, what the check says, and the time."""
        demands = self.report.demands
        unseen = sum(demand.unseen_area_m2 for demand in demands) / sum(demand.area_m2 for demand in demands)
        worst = max(demand.worst_gap_s / demand.period_s for demand in demands)
        what = f"met; worst gap / period {worst:.3f}" if self.met else f"{self.report.verdict}, {unseen:.1%} never seen"
        return f"{self.robots} robots (bound {self.plan.lower_bound_robots}), {what}; CPU {self.cpu_s:.0f} s"


def sun_method(options: Options) -> Iterator[Row]:
    """Each case with our routes; all of them with repaired routes; the paper's own two as printed."""
    cases = {case: read_mission(write_case(case, options.folder)).mission for case in CASES}
    cases[FIGURE_16] = read_mission(EXAMPLES / "sun2019-fig16.yaml").mission
    tried(cases[CASES[-1]], OURS, "quick")  # compiles
    found = {case: tried(mission, OURS, options.effort) for case, mission in cases.items()}
    for case, run in found.items():
        periods = ", ".join(f"{period_s:g}" for period_s in case.periods_s)
        reached = run.met and run.robots <= case.paper_robots
        name = f"Sun 2019, method sun2019, {case.name} ({periods} s), {options.effort}"
        yield Row(name, f"met, at most {case.paper_robots} robots, the paper's", run.told, reached)
    yield total_row(found, "shortened", options.effort)
    repaired = {case: tried(mission, REPAIRED, options.effort) for case, mission in cases.items()}
    yield total_row(repaired, "repaired, not shortened", options.effort)
    for case, (tables, settings) in PRINTED.items():
        run = tried(cases[case], settings, "quick")
        name = f"Sun 2019, method sun2019, {case.name}, as printed: {tables}, nothing repaired"
        yield Row(name, f"the paper: {case.paper_robots} robots", run.told, None)


def tried(mission: Mission, stages: Sun2019, effort: Effort) -> Tried:
    """Plan the mission by the method with these stages."""
    planning = replace(mission.planning, effort=effort, method="sun2019", method_settings=stages)
    began_s = time.process_time()
    try:
        plan = make_plan(replace(mission, planning=planning))
    except NoPlanFound as failure:
        if not isinstance(failure.best, Plan):
            raise
        plan = failure.best
    cpu_s = time.process_time() - began_s
    return Tried(plan, check_plan(plan), cpu_s)


def total_row(found: dict[Case, Tried], routes: str, effort: str) -> Row:
    """All cases together."""
    met = [run for run in found.values() if run.met]
    each = ", ".join(str(run.robots) if run.met else "-" for run in found.values())
    measured = f"{sum(run.robots for run in met)} robots ({each}) in {len(met)} of {len(found)} cases met; "
    measured += f"CPU {sum(run.cpu_s for run in found.values()):.0f} s"
    paper = sum(case.paper_robots for case in found)
    late = sum(case.paper_late for case in found)
    reached = len(met) == len(found) and sum(run.robots for run in met) <= paper
    asked = f"all met, at most {paper} robots (the paper, {late} of them late)"
    return Row(f"Sun 2019, method sun2019, all cases, routes {routes}, {effort}", asked, measured, reached)
