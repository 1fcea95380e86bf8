"""What takes long is told before it begins: large files, large ground, many robots, slow turning."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import shapely

if TYPE_CHECKING:
    from rota.mission import Mission

# measured with the benchmarks plan-10-km2 (100,000 squares of the reach: 34 s, 0.76 GB) and files of 50,000 corners
READING_S_PER_MB = 7.0
PLANNING_S_PER_SQUARE, MEMORY_PER_SQUARE, MEMORY_AT_LEAST = 3.4e-4, 4.3e3, 3.3e8
MANY_SQUARES, MANY_ROBOTS, MANY_CORNERS = 100_000, 200, 2_000
LONG_READING_S = 15.0


def reading_ahead(path: Path) -> str | None:
    """What to say before a mission file is read; None where that takes seconds only, or there is no such file."""
    size = os.path.getsize(path) if path.is_file() else 0
    seconds = READING_S_PER_MB * size / 1e6
    return f"reading {path}, {size / 1e6:.1f} MB: about {_time(seconds)}" if seconds > LONG_READING_S else None


def planning_ahead(mission: Mission) -> Iterator[str]:
    """What makes planning a mission of the planner patrol long, each with a rough estimate; nothing of others."""
    if mission.planning.planner != "patrol":
        return
    from rota.mission import inner_reach_m

    robot = (mission.fleet.robots or (mission.fleet.equal_robot("any"),))[0]
    reach_m = inner_reach_m(robot.sensor)
    periods_s = [period for period in (mission.period_s, *(zone.period_s for zone in mission.zones)) if period]
    if mission.period_s is not None:
        squares = mission.area.area / reach_m**2
        if squares >= MANY_SQUARES:
            memory = (MEMORY_AT_LEAST + MEMORY_PER_SQUARE * squares) / 1e9
            yield (
                f"{squares:,.0f} squares of the sensor's reach to watch: at effort quick about"
                f" {_time(PLANNING_S_PER_SQUARE * squares)} and {memory:.0f} GB, more at the others"
            )
        robots = mission.area.area / (2 * reach_m * robot.speed_m_s * mission.period_s)
        if robots >= MANY_ROBOTS:
            yield f"about {robots:,.0f} robots are needed to sweep the area in {mission.period_s:g} s: maybe hours"
    corners = int(shapely.get_num_coordinates([mission.area, *(one.shape for one in mission.obstacles)]).sum())
    if corners >= MANY_CORNERS:
        yield f"{corners:,} corners of walls: minutes to find the ways round them"
    if robot.turn_rate_rad_s is not None and periods_s:
        round_s = 2 * math.pi / robot.turn_rate_rad_s
        if round_s > max(periods_s):
            yield (
                f"turning round once takes {round_s:.4g} s, longer than any period: no robot that moves keeps a loop"
                " of its own, and a search for many that share one takes minutes"
            )


def _time(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} minutes" if seconds < 5400 else f"{seconds / 3600:.1f} hours"
