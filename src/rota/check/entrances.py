"""Whether robots are only where their bodies can be driven to from the fleet's entrances."""

from __future__ import annotations

import shapely

from rota.check.report import Violation, violation
from rota.check.standing import near_entrance_m, standing_area_of
from rota.plan import Plan
from rota.violation_kinds import ViolationKind


def entrance_violations(plan: Plan) -> list[Violation]:
    """Robots that begin where no way leads from an entrance, and how far off that is.

    Where a robot begins tells all: its legs are judged by themselves, and without a jump it stays in its part of the
    ground.
    """
    mission, violations = plan.mission, []
    if mission.fleet.entrances is None:
        return []
    for trajectory in plan:
        robot = mission.fleet.robot(trajectory.robot)
        x, y = (float(value) for value in trajectory.positions_m[0, :2])
        inside = standing_area_of(mission, robot).shape
        away_m = float("inf") if inside.is_empty else float(shapely.distance(inside, shapely.Point(x, y)))
        limit_m = near_entrance_m(robot.body_radius_m)
        if away_m > limit_m:
            kind: ViolationKind = "no way there from the entrances"
            violations.append(violation(kind, robot.name, (x, y), 0.0, away_m, limit_m, "m"))
    return violations
