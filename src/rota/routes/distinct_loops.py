"""The loops of a plan, with those counted once that several robots share."""

from __future__ import annotations

import shapely

from rota.model.plan import Plan, Trajectory

SAME_LOOP_M = 1e-6


def distinct_loops(plan: Plan) -> list[Trajectory]:
    """One trajectory for each loop of the plan; robots that follow each other on one loop count once."""
    distinct: list[tuple[Trajectory, shapely.LineString]] = []
    for trajectory in plan:
        points_m = trajectory.positions_m[trajectory.loop_index :, :2]
        if len(points_m) < 2:
            continue
        line = shapely.LineString(points_m)
        same_s = 1e-6 * trajectory.loop_duration_s
        for other, along in distinct:
            alike = abs(other.loop_duration_s - trajectory.loop_duration_s) <= same_s
            if alike and shapely.hausdorff_distance(line, along) < SAME_LOOP_M:
                break
        else:
            distinct.append((trajectory, line))
    return [trajectory for trajectory, _ in distinct]
