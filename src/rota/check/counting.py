"""Which robots count for which demands: those whose sensor has a name that the zone names, or all."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from rota.check.demands import DemandedGround
from rota.check.report import Violation, violation
from rota.model.mission import Sensor
from rota.model.plan import Plan, Seam

Names = tuple[str, ...]

SAME_COST = 1e-9  # sums of costs differ by less where they are the same


def counts(sensor: Sensor, names: Names) -> bool:
    """Whether what a sensor sees counts for a demand that names these sensors; where it names none, all count."""
    return not names or sensor.name in names


def counting_robots(plan: Plan, names: Names) -> Plan:
    """The plan with those of its robots alone that count for a demand that names these sensors."""
    if not names:
        return plan
    fleet = plan.mission.fleet
    own = tuple(each for each in plan if counts(fleet.robot(each.robot).sensor, names))
    return replace(plan, trajectories=own, seam=None)


def counting_before(seam: Seam, names: Names) -> Seam:
    """What those drove before a change alone that count for a demand that names these sensors."""
    return replace(seam, driven=tuple(one for one in seam.driven if counts(one.sensor, names))) if names else seam


def groups_of(demands: Sequence[DemandedGround]) -> list[tuple[Names, list[int]]]:
    """The demands' numbers in groups that name the same sensors, each with these names."""
    names = list(dict.fromkeys(demand.sensors for demand in demands))
    return [(own, [k for k, demand in enumerate(demands) if demand.sensors == own]) for own in names]


def kind_violations(plan: Plan) -> list[Violation]:
    """Kinds of which a plan has more robots than there are."""
    fleet = plan.mission.fleet
    if not fleet.kinds:
        return []
    used = Counter(fleet.kind_of(trajectory.robot).name for trajectory in plan)
    return [
        violation("more robots than there are", kind.name, None, 0.0, used[kind.name], kind.most, "robots")
        for kind in fleet.kinds
        if kind.most is not None and used[kind.name] > kind.most
    ]


def claim_violations(plan: Plan) -> list[Violation]:
    """What a plan that meets its demand claims that none can do, and does: with so few robots, or at such a cost."""
    fleet, robots, bound = plan.mission.fleet, len(plan.trajectories), plan.lower_bound_robots
    false = []
    if bound is not None and bound > robots:
        false.append(violation("claims that fewer robots cannot do", "lower bound", None, 0.0, bound, robots, "robots"))
    cost = sum(fleet.kind_of(trajectory.robot).cost for trajectory in plan) if fleet.kinds else math.inf
    if plan.lower_bound_cost is not None and plan.lower_bound_cost > cost * (1 + SAME_COST):
        bound_cost = plan.lower_bound_cost
        false.append(violation("claims that a cheaper fleet cannot do", "lower bound", None, 0.0, bound_cost, cost, ""))
    return false
