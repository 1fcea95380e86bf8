"""The loops of a plan, with those counted once that several robots share."""

from __future__ import annotations

import shapely

from rota.model.plan import Plan, Trajectory

SAME_LOOP_M = 1e-6


def distinct_loops(plan: Plan) -> list[Trajectory]:
    """One trajectory for each loop of the plan; robots that follow each other on one loop count once."""
    return [loop[0] for loop in shared_loops(plan)]


def shared_loops(plan: Plan) -> list[list[Trajectory]]:
    """The trajectories of each loop of the plan: of one that several robots follow, all of them."""
    shared: list[tuple[list[Trajectory], shapely.LineString]] = []
    for trajectory in plan:
        points_m = trajectory.positions_m[trajectory.loop_index :, :2]
        if len(points_m) < 2:
            continue
        line = shapely.LineString(points_m)
        same_s = 1e-6 * trajectory.loop_duration_s
        for loop, along in shared:
            alike = abs(loop[0].loop_duration_s - trajectory.loop_duration_s) <= same_s
            if alike and _follows(line, along) and _follows(along, line):
                loop.append(trajectory)
                break
        else:
            shared.append(([trajectory], line))
    return [loop for loop, _ in shared]


def _follows(line: shapely.LineString, along: shapely.LineString) -> bool:
    """Whether all corners of the line lie on the other one."""
    shapely.prepare(along)
    return bool(shapely.dwithin(along, shapely.points(line.coords), SAME_LOOP_M).all())
