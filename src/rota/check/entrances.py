"""Whether robots are only where their bodies can be driven to from the fleet's entrances."""

from __future__ import annotations

import numpy as np
import shapely

from rota.check.report import Violation, violation
from rota.check.standing import near_entrance_m, near_way_in_m, standing_area_of
from rota.model.plan import Plan
from rota.model.violation_kinds import ViolationKind


def entrance_violations(plan: Plan) -> list[Violation]:
    """Robots that come to places where no way leads from an entrance: the first of each, when, and how far off it is.

    Where a robot turns tells all: between two such places its leg is judged by itself, and each is to be in ground that
    ways lead to. A gap just as wide as the body is no way, though a leg may pass it. Where a robot begins it must be as
    near to such ground as an entrance.
    """
    mission, violations = plan.mission, []
    if mission.fleet.entrances is None:
        return []
    for trajectory in plan:
        robot = mission.fleet.robot(trajectory.robot)
        inside = standing_area_of(mission, robot).shape
        shapely.prepare(inside)  # whose sides are then looked up in a tree
        places_m = trajectory.positions_m[:, :2]
        limits_m = np.full(len(places_m), near_way_in_m(robot.body_radius_m))
        limits_m[0] = near_entrance_m(robot.body_radius_m)
        far = ~shapely.dwithin(inside, shapely.points(places_m), limits_m)  # all, where bodies can come to nothing
        for i in np.flatnonzero(far)[:1]:
            x, y = (float(value) for value in places_m[i])
            at_s = float(trajectory.times_s[i])
            away_m = float("inf") if inside.is_empty else float(shapely.distance(inside, shapely.Point(x, y)))
            kind: ViolationKind = "no way there from the entrances"
            violations.append(violation(kind, robot.name, (x, y), at_s, away_m, float(limits_m[i]), "m"))
    return violations
