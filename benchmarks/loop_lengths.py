"""Sums of the loops' lengths beside ground over swath, turning and spikes, before and after loops are made shorter."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from benchmarks.missions import EXAMPLES
from benchmarks.row import Options, Row
from benchmarks.sun_cases import CASES, write_case
from rota import read_mission
from rota.check import check_plan
from rota.model.anywhere import without_starts
from rota.model.mission import Mission
from rota.planners.patrol.context import begin_search
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.margins import with_reserve
from rota.planners.patrol.methods.method import load_method
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.repair import Repaired
from rota.planners.patrol.shortening.search import loops_m, turning_rad, with_better_loops
from rota.planners.patrol.shortening.spikes import spikes
from rota.planners.patrol.tours.tour import Tour
from rota.planning.planner import Request

ASKED_RATIO = 1.12
FURTHER = ("sun2019-fig16", "harbour", "parcel", "building")


class Loops(NamedTuple):
    """Loops of one plan: metres in all, these over ground / swath, degrees of turning in each metre, and spikes."""

    robots: int
    length_m: float
    ratio: float
    turning_deg_m: float
    spikes: int

    def text(self) -> str:
        """The figures of the loops."""
        return f"{self.length_m:.0f} m, ratio {self.ratio:.3f}, {self.turning_deg_m:.1f} deg/m, {self.spikes} spikes"


def loop_lengths(options: Options) -> Iterator[Row]:
    """Sun's seven cases and the examples, each by both preferences; one search serves all of its row."""
    sun = [write_case(case, options.folder) for case in CASES]
    for path in (*sun, *(EXAMPLES / f"{name}.yaml" for name in FURTHER)):
        mission = read_mission(path).mission.with_effort(options.effort)
        yield loops_row(mission, ASKED_RATIO if path in sun else None)


def loops_row(mission: Mission, asked_ratio: float | None) -> Row:
    """The loops as they were found, the shortest and those that turn least, each judged by the check."""
    searched = without_starts(with_reserve(mission))
    asked_of_it = Request(
        mission=mission, seed=0, judge=check_plan, progress=lambda _share, _what: None, should_stop=lambda: False
    )
    context = begin_search(set_up_problem(searched), asked_of_it)
    found = load_method("tours")(context)
    parts, better = [f"found {loops_of(context.problem, found).text()}"], []
    for prefer in ("shortest", "fewest_turns"):
        planning = replace(PatrolSettings.of(searched), prefer=prefer)
        own = replace(context, problem=replace(context.problem, mission=replace(searched, planning=planning)))
        began_s = time.process_time()
        best = with_better_loops(own, found)
        cpu_s = time.process_time() - began_s
        better.append(best)
        parts.append(f"{prefer} {loops_of(context.problem, best).text()}, CPU {cpu_s:.1f} s")
    sound = all(best.met and best.robots <= found.robots for best in better)
    shortest = loops_of(context.problem, better[0])
    asked = "met, no robot more, no spikes" + (f", ratio <= {asked_ratio}" if asked_ratio is not None else "")
    reached = sound and not shortest.spikes and (asked_ratio is None or shortest.ratio <= asked_ratio)
    name = f"loops of {mission.name}, {PatrolSettings.of(mission).effort}"
    return Row(name, asked, f"{found.robots} robots: " + "; ".join(parts), reached)


def loops_of(problem: Problem, plan: Repaired) -> Loops:
    """The figures of a plan's loops."""
    tours: Sequence[Tour] = plan.tours
    length_m, ground_m2 = loops_m(tours), sum(region.shape.area for region in problem.regions)
    turning_deg_m = math.degrees(turning_rad(tours)) / length_m
    return Loops(
        plan.robots, length_m, length_m * problem.swath_m / ground_m2, turning_deg_m, len(spikes(problem, tours))
    )
