"""What one robot more or one less brings to a plan, without a search."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rota.check.margin_report import names_text
from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory
from rota.routes.distinct_loops import shared_loops

if TYPE_CHECKING:
    from rota.check import Report

MOST_LOOPS = 6  # that are tried
WORTH_SAYING = 0.005  # of a period, by which its reserve rises


def one_robot_sentence(plan: Plan, report: Report) -> str | None:
    """What is known of one robot more and one less than a plan that is met has; None of other plans, and of swarms.

    One more: it goes along on a loop, all robots of which are spread evenly over it; the best of the loops of those
    that see the place with the least of its period to spare.
    """
    tightest = next((margin for margin in report.margins if margin.kind == "period"), None)
    loops = [loop for loop in shared_loops(plan) if loop[0].loop_duration_s > 0]
    if tightest is None or not loops or plan.mission.planning.bouncing is not None:
        return None
    if any(way.charges for way in plan):
        return _less_text(plan)  # who charges when would be planned anew
    near = [loop for loop in loops if any(way.robot in tightest.robots for way in loop)] or loops
    return f"{_more_text(plan, near[:MOST_LOOPS])} {_less_text(plan)}"


def with_one_more(plan: Plan, loop: list[Trajectory]) -> Plan:
    """The plan with one robot more on a loop, which all follow evenly spread; how they come there is left open."""
    first = loop[0]
    extra = _name_of_one_more(plan, first.robot)
    names = [*(way.robot for way in loop), extra]
    spread = [_start_later(first, name, k / len(names)) for k, name in enumerate(names)]
    others = [way for way in plan if way.robot not in names]
    mission = _with_robot(plan.mission, first.robot, extra)
    return replace(plan.without_bound(), mission=mission, trajectories=(*others, *spread), seam=None)


def _name_of_one_more(plan: Plan, like: str) -> str:
    """What another robot like this one is called: after its kind, with the next number, in a fleet of kinds."""
    fleet = plan.mission.fleet
    if not fleet.kinds:
        return f"{like} and one more"
    kind = fleet.kind_of(like).name
    return next(name for k in itertools.count(1) if (name := f"{kind}-{k}") not in {way.robot for way in plan})


def _start_later(way: Trajectory, robot: str, share: float) -> Trajectory:
    """Another robot on a trajectory's loop, which begins it later by a share of a round."""
    begin, late_s = way.loop_index, share * way.loop_duration_s
    times_s, places_m = way.times_s[begin:] - way.times_s[begin] + late_s, way.positions_m[begin:]
    speeding = None if way.accelerations_m_s2 is None else way.accelerations_m_s2[begin:]
    if late_s > 0:
        times_s, places_m = np.concatenate([[0.0], times_s]), np.vstack([places_m[:1], places_m])
        speeding = None if speeding is None else np.concatenate([[0.0], speeding])
    return Trajectory(
        robot=robot, loop_start_s=late_s, times_s=times_s, positions_m=places_m, accelerations_m_s2=speeding
    )


def _with_robot(mission: Mission, like: str, name: str) -> Mission:
    """The mission with one robot more, like another one, where its robots are named."""
    fleet = mission.fleet
    if fleet.robots is None:
        return mission
    added = replace(fleet.robot(like), name=name, start=None)
    return replace(mission, fleet=replace(fleet, robots=(*fleet.robots, added)))


def _more_text(plan: Plan, loops: list[list[Trajectory]]) -> str:
    """What one robot more on the best of these loops leaves of the tightest period."""
    from rota.check.margins import worst_ratio_of

    now, *spare = (1 - worst_ratio_of(each) for each in (plan, *(with_one_more(plan, loop) for loop in loops)))
    best = int(np.argmax(spare))
    if spare[best] <= now + WORTH_SAYING:
        return "One robot more on a loop there would leave no more to spare."
    names = names_text([way.robot for way in loops[best]])
    left, before = (f"{100 * share:.1f} %" for share in (spare[best], now))
    return f"One robot more on the loop of {names} would leave {left} of each period instead of {before}, bodies aside."


def _less_text(plan: Plan) -> str:
    bound, robots = plan.lower_bound_robots, len(plan.trajectories)
    if bound is not None and robots <= bound:
        return "One robot less cannot do it, proved."
    if plan.mission.fleet.robots is None:
        return "With one robot less no plan was found, and none is ruled out."
    return "Whether one robot less could do it was not searched."
