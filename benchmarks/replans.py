"""The loss of each robot of each example, one at a time, and random losses beside sampling of time."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.charging import docks
from benchmarks.random_missions import random_mission
from benchmarks.row import Options, Row
from benchmarks.time_sampling import Sampled, lattice
from rota import NoPlanFound, Plan, Replanned, make_plan, read_mission, replan

EXAMPLES = ("warehouse", "building", "parcel", "sun2019-fig13", "coast", "harbour")
SPARED = EXAMPLES[:4]  # those of which loops for other robots are found within a minute
CHARGING = ("port-relief", "warehouse-relief")  # those whose robots charge
COPTERS = {"fleet.vehicle": "arducopter-targets", "fleet.speed_m_s": 8}  # with mass, by targets
DOCKS = (1, 2, 3, 14, 17, 18, 24, 25)  # seeds of random docks between which robots fly, so that each loss upsets all
LOSSES, OF_EACH = 100, 4  # random losses, and those of one random mission
STEP_S, POINTS = 0.1, 150
FIRST_S, RECOVERY = 2.0, 2.0  # what is asked: of the first answer, and of recovery in longest periods
LIMIT_S = 60.0  # of the processor, until an answer is there, or one that meets the demand where those left suffice
TOLERANCE_S = 0.25


class Answer(NamedTuple):
    """A plan that takes over; how long the first one took, by the clock and of the processor, and this one."""

    found: Replanned
    first_s: float
    first_cpu_s: float
    cpu_s: float


def replans(options: Options) -> Iterator[Row]:
    """The first answers for the examples, and for some with a robot to spare how soon they recover."""
    plans = {name: plan_of(name) for name in EXAMPLES}
    lost = [answer(plan, *loss) for plan in plans.values() for loss in losses(plan)]
    yield first_answers(f"first answer to the loss of each robot of {len(EXAMPLES)} examples", lost)
    spare = {name: plan_of(name, len(plans[name]) + 1) for name in SPARED}
    met = [answer(plan, *loss, until_met=True) for plan in spare.values() for loss in losses(plan)]
    yield first_answers(f"the same of {len(SPARED)} with a robot to spare", met)
    recovered = [recovery(one.found) for one in met if one.found.meets_demand]
    told = (
        f"{sum(one <= RECOVERY for one in recovered)} of {len(met)}, latest {max(recovered):.2f} of the longest period"
    )
    at_once = sum(one.cpu_s == one.first_cpu_s for one in met if one.found.meets_demand)
    told += (
        f"; {at_once} by the first answer, the last found after {max(one.cpu_s for one in met):.0f} s of the processor"
    )
    name = "there, where those left suffice: all periods hold again"
    yield Row(
        name, f"within {RECOVERY:g} of the longest period", told, sum(one <= RECOVERY for one in recovered) == len(met)
    )
    yield charging_row("robots that charge", [with_one_more(name) for name in CHARGING])
    yield charging_row("copters with mass that charge", [with_one_more("port-relief", **COPTERS)])
    yield unlike_row()
    yield docks_row()


def unlike_row() -> Row:
    """The first answers where robots of several kinds, or on circuits, are left without one to spare."""
    plans = [plan_of("farm"), make_plan(read_mission(Path("examples") / "port-relief.yaml").mission, seed=0)]
    lost = [answer(plan, *loss) for plan in plans for loss in losses(plan)]
    return first_answers("the same of the farm's kinds, and of the port's circuits by default", lost)


def docks_row() -> Row:
    """The worst gap over period at once, and after the search, of drones with a dock each that lose one of as few."""
    at_once, at_last, cpu_s = list[float](), list[float](), list[float]()
    for seed in DOCKS:
        plan, answers = make_plan(docks(seed), seed=0), list[Replanned]()
        at_s, began_s = plan.trajectories[0].loop_start_s + 500, time.process_time()
        replan(plan, at_s=at_s, lost=["robot-1"], on_better=answers.append)
        cpu_s.append(time.process_time() - began_s)
        ratios = [max(one.worst_gap_at_least_s / one.period_s for one in each.report.demands) for each in answers]
        at_once.append(ratios[0])
        at_last.append(ratios[-1])
    told = f"{min(at_once):.2f} to {max(at_once):.2f} at once, {min(at_last):.2f} to {max(at_last):.2f} at last"
    told += f", after {np.median(cpu_s):.0f} s of the processor (median)"
    return Row(f"{len(DOCKS)} teams of drones with a dock each, one lost: worst gap / period", "", told, None)


def with_one_more(name: str, **changed: object) -> Plan:
    """The plan of an example, changed by field paths, for one robot more than it takes."""
    return plan_of(name, len(plan_of(name, **changed)) + 1, **changed)


def charging_row(who: str, plans: list[Plan]) -> Row:
    """The first answers where robots charge and there is one to spare, and how soon all periods hold again."""
    lost = [answer(plan, *loss) for plan in plans for loss in losses(plan)]
    cpu_s, recovered = [one.first_cpu_s for one in lost], [recovery(one.found) for one in lost]
    told = f"longest {max(cpu_s):.2f} s, median {np.median(cpu_s):.2f} s of the processor"
    told += f"; {sum(one <= RECOVERY for one in recovered)} recover so soon, latest {max(recovered):.2f}"
    reached = max(cpu_s) < FIRST_S and max(recovered) <= RECOVERY
    asked = f"< {FIRST_S:g} s of the processor, periods hold within {RECOVERY:g} of the longest one"
    return Row(f"loss of each of {len(lost)} {who}, one to spare", asked, told, reached)


def plan_of(name: str, robots: int | None = None, **changed: object) -> Plan:
    """The quick plan of an example, changed by field paths, for as few robots as it takes or for so many."""
    mission = read_mission(Path("examples") / f"{name}.yaml", overrides=changed).mission.with_effort("quick")
    if robots is not None:
        named = tuple(mission.fleet.equal_robot(f"robot-{k + 1}") for k in range(robots))
        mission = replace(mission, fleet=replace(mission.fleet, robots=named, start=None))
    return make_plan(mission, seed=0)


def losses(plan: Plan) -> Iterator[tuple[str, float]]:
    """Each robot and when it is lost; what an answer loads is loaded before."""
    answer(plan, plan.trajectories[0].robot, 10.0)
    for k, line in enumerate(plan):
        yield line.robot, 137.0 + 100 * k


def first_answers(name: str, answers: list[Answer]) -> Row:
    """How long the first answers took."""
    cpu_s, wall_s = ([getattr(one, field) for one in answers] for field in ("first_cpu_s", "first_s"))
    told = f"longest {max(cpu_s):.2f} s, median {np.median(cpu_s):.2f} s of the processor"
    told += f" ({max(wall_s):.2f} and {np.median(wall_s):.2f} s by the clock)"
    asked = f"< {FIRST_S:g} s of the processor each, warm"
    return Row(f"{name}, {len(answers)} losses", asked, told, max(cpu_s) < FIRST_S)


def random_losses(options: Options) -> Iterator[Row]:
    """Losses of random missions at random times, every other one with a new robot: judged as sampling says.

    And how soon all periods hold again, where as many robots are left as the plan had.
    """
    right, wrong, recovered, ended, replaced = 0, list[str](), list[float](), 0, 0
    for seed in range(LOSSES // OF_EACH):
        try:
            plan = make_plan(random_mission(seed), seed=0)
        except NoPlanFound as failure:
            plan = failure.best  # type: ignore[assignment]
        random = np.random.default_rng(seed)
        for k in range(OF_EACH):
            line = plan.trajectories[random.integers(len(plan))]
            at_s, x_y = float(random.uniform(0, 300)), line.at(float(random.uniform(0, 300)))
            new = {"new": (float(x_y[0]), float(x_y[1]))} if k % 2 or len(plan) == 1 else {}
            replaced += bool(new)
            try:
                found = answer(plan, line.robot, at_s, new, until_met=bool(new)).found
            except NoPlanFound:
                ended, right = ended + 1, right + 1
                continue
            fault = judged_wrongly(found)
            right += fault is None
            wrong += [] if fault is None else [f"seed {seed}, {line.robot} at {at_s:.1f} s: {fault}"]
            if new and found.meets_demand:
                recovered.append(recovery(found))
    name = f"{LOSSES} random losses, half of them with a new robot, beside sampling every {STEP_S:g} s"
    told = "; ".join([f"{right} ({ended} without an answer)", *wrong])
    yield Row(name, f"{LOSSES} judged right, each answered", told, right == LOSSES and not ended)
    soon = sum(one <= RECOVERY for one in recovered)
    told = f"{soon} of {replaced}, latest {max(recovered, default=0.0):.2f} of the longest period"
    name = "those with a new robot in place of the lost one: all periods hold again"
    yield Row(name, f"within {RECOVERY:g} of the longest period", told, soon == replaced)


def answer(
    plan: Plan, robot: str, at_s: float, new: dict[str, tuple[float, float]] | None = None, *, until_met: bool = False
) -> Answer:
    """The first plan that takes over when a robot is lost; or the first that meets the demand, while time lasts."""
    began_s, used_s = time.monotonic(), time.process_time()
    told = list[tuple[Replanned, float, float]]()

    def note(found: Replanned) -> None:
        told.append((found, time.monotonic() - began_s, time.process_time() - used_s))

    def enough() -> bool:
        done = bool(told) and (not until_met or told[-1][0].meets_demand)
        return done or time.process_time() - used_s > LIMIT_S

    replan(plan, at_s=at_s, lost=[robot], joined=new, should_stop=enough, on_better=note)
    return Answer(told[-1][0], told[0][1], told[0][2], told[-1][2])


def recovery(found: Replanned) -> float:
    """After how many of the longest period all periods hold again."""
    assert found.report.lateness is not None
    periods_s = [demand.period_s for demand in found.report.demands]
    again_s = found.report.lateness.holds_again_s
    return np.inf if again_s is None else again_s / max(periods_s)


def judged_wrongly(found: Replanned) -> str | None:
    """What of the report sampling of time says otherwise; None: nothing."""
    plan, lateness = found.plan, found.report.lateness
    assert lateness is not None
    fastest_m_s = max(robot.speed_m_s for robot in plan.mission.fleet.robots or ())
    step_m = fastest_m_s * STEP_S / 2
    points = lattice(plan.mission, np.sqrt(plan.mission.area.area / POINTS))
    until_s = max(float(line.times_s[-1]) for line in plan) + max(demand.period_s for demand in found.report.demands)
    sampled = Sampled(plan, points, STEP_S, until_s, more_m=step_m)
    bodies_m = max(2 * robot.body_radius_m for robot in plan.mission.fleet.robots or ())
    if sampled.nearest_m < bodies_m - 2 * step_m:
        return f"bodies {sampled.nearest_m:.2f} m apart"
    worst_s = max((demand.worst_s for demand in lateness.demands), default=0.0)
    if sampled.worst_s > worst_s + TOLERANCE_S:
        return f"a point is {sampled.worst_s:.2f} s late, told {worst_s:.2f}"
    for demand in lateness.demands:
        if demand.place_m is None or not np.isfinite(demand.worst_at_least_s):
            continue
        if next(one for one in found.report.demands if one.name == demand.name).demand == "visit":
            continue
        place = np.array([demand.place_m])
        period_s = next(one.period_s for one in found.report.demands if one.name == demand.name)
        less, more = (
            Sampled(plan, place, STEP_S / 2, until_s, more_m=by, periods_s=np.array([period_s])).worst_s
            for by in (step_m, -step_m)
        )
        # loops without a common period may come to their longest gap long after what is sampled
        beyond_s = np.inf if not found.meets_demand else more + TOLERANCE_S
        if not less - TOLERANCE_S <= demand.worst_at_least_s <= beyond_s:
            return f"{demand.name}: told {demand.worst_at_least_s:.2f} s late, sampled {less:.2f} to {more:.2f}"
    if lateness.holds_again_s is not None and sampled.last_s > lateness.holds_again_s + TOLERANCE_S:
        return f"late until {sampled.last_s:.2f} s, told {lateness.holds_again_s:.2f}"
    return None
