"""The cases of Sun et al. 2019 on the reconstructed map: robots beside the paper's and the proved bound."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from ruamel.yaml import YAML

from benchmarks.missions import EXAMPLES
from benchmarks.planning import Planned, plan_and_check, told, worst_ratio
from benchmarks.row import Options, Row
from benchmarks.shell import PATIENCE_S
from benchmarks.warm_cache import measured_warm

ROBOTS_IN_ALL, ONE_CASE_S = 35, 60
HIGH_PATIENCE_S = 3600.0


class Case(NamedTuple):
    """One case: periods of zone 1, zone 2 and the rest, and the paper's robots, some of which miss their period."""

    name: str
    periods_s: tuple[float, float, float]
    paper_robots: int
    paper_late: int = 0
    at_most: int | None = None

    @property
    def asked_robots(self) -> int:
        """As few as the figures table asks for; where it asks nothing, as the paper has."""
        return self.paper_robots if self.at_most is None else self.at_most


CASES = (
    Case("Table 6, case 1", (12, 10, 40), 5),
    Case("Table 6, case 2", (12, 20, 30), 5),
    Case("Table 6, case 3", (12, 7, 40), 7),
    Case("Table 6, case 4", (12, 10, 20), 8),
    Case("Table 6, case 5", (8, 10, 20), 9),
    Case("Table 6, case 6", (12, 10, 10), 11, paper_late=4),
    Case("Section 5.1", (8, 20, 40), 5, at_most=4),
)
FIGURE_16 = Case("Section 5.3, Figure 16", (10, 12, 45), 7, at_most=5)


def write_case(case: Case, folder: Path) -> Path:
    """Write the case's mission: examples/sun2019-fig13.yaml with other periods."""
    mission = YAML(typ="safe").load((EXAMPLES / "sun2019-fig13.yaml").read_text())
    zone_1, zone_2, rest = case.periods_s
    mission["period_s"] = rest
    for zone, period_s in zip(mission["zones"], (zone_1, zone_2), strict=True):
        zone["period_s"] = period_s
    mission["name"] = "sun2019-" + "-".join(f"{period_s:g}" for period_s in case.periods_s)
    path = folder / f"{mission['name']}.json"
    path.write_text(json.dumps(mission))
    return path


def sun_cases(options: Options) -> Iterator[Row]:
    """Each case as a row, then the seven of Table 6 and Section 5.1 together, then the one of Figure 16."""
    found: list[Planned] = []
    for case in CASES:
        found.append(planned_case(write_case(case, options.folder), options))
        yield case_row(case, found[-1], options.effort)
    yield total_row(found, options.effort)
    yield case_row(FIGURE_16, planned_case(EXAMPLES / "sun2019-fig16.yaml", options), options.effort)


def planned_case(mission: Path, options: Options) -> Planned:
    """A case planned and checked once, with a warm cache."""
    patience_s = HIGH_PATIENCE_S if options.effort == "high" else PATIENCE_S
    (planned,) = measured_warm(
        lambda: plan_and_check(mission, options.folder, effort=options.effort, patience_s=patience_s),
        lambda run: run.wall_s,
        repeats=1,
    )
    return planned


def case_row(case: Case, planned: Planned, effort: str) -> Row:
    """What came of one case."""
    periods = ", ".join(f"{period_s:g}" for period_s in case.periods_s)
    paper = f"the paper: {case.paper_robots}" + (f", {case.paper_late} of them late" if case.paper_late else "")
    in_time = effort == "high" or planned.wall_s < ONE_CASE_S  # at high no time is asked for
    reached = planned.met and planned.report["robots"] <= case.asked_robots and in_time
    measured = told([planned])
    if planned.report is not None:
        measured += f"; worst gap / period {worst_ratio(planned.report):.3f}; CPU {planned.cpu_s:.0f} s"
    asked = f"met, at most {case.asked_robots} robots ({paper})" + ("" if effort == "high" else f", < {ONE_CASE_S} s")
    return Row(f"Sun 2019, {case.name} ({periods} s), {effort}", asked, measured, reached)


def total_row(found: list[Planned], effort: str) -> Row:
    """All cases together; robots only of those that are met."""
    met = [planned.report for planned in found if planned.met]
    robots = sum(report["robots"] for report in met)
    bound = sum(report["lower_bound_robots"] for report in met)
    paper, late = sum(case.paper_robots for case in CASES), sum(case.paper_late for case in CASES)
    seconds, cpu_s = sum(planned.wall_s for planned in found), sum(planned.cpu_s for planned in found)
    measured = f"{robots} robots (bound {bound}) in {len(met)} of {len(found)} cases met; "
    measured += f"{seconds:.0f} s in all, CPU {cpu_s:.0f} s"
    reached = len(met) == len(CASES) and robots <= ROBOTS_IN_ALL
    asked = f"at most {ROBOTS_IN_ALL} robots, all met (the paper: {paper}, {late} of them late)"
    return Row(f"Sun 2019, the seven cases together, {effort}", asked, measured, reached)
