"""The loss of each robot of each example, one at a time, and random losses beside sampling of time."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.random_missions import random_mission
from benchmarks.row import Options, Row
from benchmarks.time_sampling import Sampled, lattice
from rota import NoPlanFound, Plan, Replanned, make_plan, read_mission, replan

EXAMPLES = ("harbour", "parcel", "coast", "building", "warehouse", "sun2019-fig13")
LOSSES, OF_EACH = 100, 4  # random losses, and those of one random mission
STEP_S, POINTS = 0.1, 150
FIRST_S, RECOVERY = 2.0, 2.0  # what is asked: of the first answer, and of recovery in longest periods
TOLERANCE_S = 0.25


def replans(options: Options) -> Iterator[Row]:
    """The first answers for the examples, how soon they recover, and the random losses."""
    took_s, cpu_s, met = list[float](), list[float](), 0
    for name in EXAMPLES:
        mission = read_mission(Path("examples") / f"{name}.yaml").mission.with_effort("quick")
        plan = make_plan(mission, seed=0)
        first_answer(plan, plan.trajectories[0].robot, 10.0)  # so that no time holds loading
        for k, line in enumerate(plan):
            begin, used_s = time.monotonic(), time.process_time()
            found = first_answer(plan, line.robot, 137.0 + 100 * k)
            took_s.append(time.monotonic() - begin)
            cpu_s.append(time.process_time() - used_s)
            met += found.meets_demand
    asked, longest = f"< {FIRST_S:g} s each, warm", f"longest {max(took_s):.2f} s, median {np.median(took_s):.2f} s"
    longest += f" ({max(cpu_s):.2f} and {np.median(cpu_s):.2f} s of the processor)"
    name = f"first answer to the loss of each robot of {len(EXAMPLES)} examples, {len(took_s)} losses"
    yield Row(name, asked, f"{longest}; {met} of them meet the demand", max(took_s) < FIRST_S)
    yield from random_losses()


def random_losses() -> Iterator[Row]:
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
            try:
                found = first_answer(plan, line.robot, at_s, new)
            except NoPlanFound:
                ended, right = ended + 1, right + 1
                continue
            fault = judged_wrongly(found)
            right += fault is None
            wrong += [] if fault is None else [f"seed {seed}, {line.robot} at {at_s:.1f} s: {fault}"]
            replaced += bool(new)
            if new and found.meets_demand:
                recovered.append(recovery(found))
    name = f"{LOSSES} random losses, half of them with a new robot, beside sampling every {STEP_S:g} s"
    told = "; ".join([f"{right} ({ended} have no way to go on)", *wrong])
    yield Row(name, f"{LOSSES} judged right", told, right == LOSSES)
    late = sum(one > RECOVERY for one in recovered)
    told = (
        f"{len(recovered) - late} of {len(recovered)}, latest {max(recovered, default=0.0):.2f} of the longest period"
    )
    told += f"; {replaced - len(recovered)} of {replaced} first answers do not meet the demand"
    name = "those with a new robot whose first answer meets the demand: all periods hold again"
    yield Row(name, f"within {RECOVERY:g} of the longest period", told, late == 0)


def first_answer(plan: Plan, robot: str, at_s: float, new: dict[str, tuple[float, float]] | None = None) -> Replanned:
    """The first plan that takes over when a robot is lost."""
    return replan(plan, at_s=at_s, lost=[robot], joined=new, should_stop=lambda: True)


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
