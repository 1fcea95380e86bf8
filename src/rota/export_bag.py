"""What exports hand the bags of ROS: how long they play, and the grids, whose gaps are those of `rota draw`."""

from __future__ import annotations

import math
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rota.files.ros.bags import Storage
    from rota.files.ros.grids import GroundGrid
    from rota.model.plan import Plan

GRID_CELLS, LEAST_CELLS = 40_000, 2_500
CELLS_BY_POINTS = 500_000_000  # a gap at a place takes the longer the more timed points there are
MOST_ROUNDS = 8  # of the longest loop, that a bag plays until all loops begin together again
MOST_POINTS = 200_000


def rosbag1(plan: Plan, path: str, start: datetime) -> tuple[Path, ...]:
    """A bag of ROS 1."""
    from rota.files.ros.bags import write_rosbag1
    from rota.files.ros.library import require_rosbags

    require_rosbags("a rosbag1")
    return write_rosbag1(plan, path, start, full_period_s(plan), ground_grids(plan))


def rosbag2(plan: Plan, folder: str, start: datetime, storage: Storage = "mcap") -> tuple[Path, ...]:
    """A bag of ROS 2 in MCAP, or in SQLite."""
    from rota.files.ros.bags import write_rosbag2
    from rota.files.ros.library import require_rosbags

    require_rosbags("a rosbag2")
    return write_rosbag2(plan, folder, start, full_period_s(plan), ground_grids(plan), storage)


def full_period_s(plan: Plan) -> float:
    """How long a plan takes, in seconds, until every robot has made its approach and then all loops come round.

    That is one common period of all loops. Where they have none, or one that is longer than 8 rounds of the longest
    loop or has more than 200,000 timed points, it is until every robot has made one round.
    """
    from rota.check.routes import routes_of

    one_round_s = max((float(trajectory.times_s[-1]) for trajectory in plan), default=0.0)
    routes = routes_of(plan)
    moving = routes.durations_s > 0
    if not moving.any() or len(set(routes.classes[moving].tolist())) > 1:
        return one_round_s
    common_s = math.lcm(*routes.parts[moving].tolist()) * float(routes.units_s[routes.classes[moving][0]])
    rounds = [round(common_s / duration_s) if duration_s else 0 for duration_s in routes.durations_s.tolist()]
    points = sum(count * len(trajectory.times_s) for count, trajectory in zip(rounds, plan, strict=True))
    if min(count for count in rounds if count) > MOST_ROUNDS or points > MOST_POINTS:
        return one_round_s
    return max(one_round_s, routes.from_s + common_s)


def ground_grids(plan: Plan) -> dict[str, GroundGrid]:
    """By topic: where robots may drive, and each place's worst gap in percent of its period."""
    from rota.draw.gap_map import gap_map
    from rota.files.ros.grids import GroundGrid, free_space, percent_of_period, usual_cells

    points = sum(len(trajectory.times_s) for trajectory in plan)
    gaps = gap_map(plan, max(min(CELLS_BY_POINTS // max(points, 1), GRID_CELLS), LEAST_CELLS))
    cells = gaps.cell_map
    return {
        "/map": free_space(plan.mission, *usual_cells(plan.mission)),
        "/worst_gaps": GroundGrid(
            x_m=cells.x_m, y_m=cells.y_m, cell_m=cells.cell_m, values=percent_of_period(gaps.ratio)
        ),
    }
