"""The program of Alam & Bobadilla 2020 for the iRobot Create 2: turn by one angle at every bump, with no plan at all.

The robot's part of the sketch is that of ``create2_sketch``. How long such robots take to cover the ground is no
property of a plan; whoever exports says it.
"""

from __future__ import annotations

import math
import os
from pathlib import Path

from rota.files.create2_course import angle_turned
from rota.files.create2_legs import BACK_OFF_SPEED_M_S, FASTEST_M_S, require_bouncing, turning_speed_m_s
from rota.files.create2_sketch import one_line, sketch_of, write_sketches
from rota.model.mission import Mission
from rota.model.plan import Plan

LONGER = 1.5  # than the longest way in the area: then a robot is outside


def write_create2_programs(plan: Plan, folder: str | os.PathLike[str], *, covers: str) -> tuple[Path, ...]:
    """Write ``ROBOT/ROBOT.ino`` for every robot of a plan into ``folder``, and return the paths.

    covers: what is known of how long they take to cover their ground. Raises PlanError for robots that do not bounce or
    cannot be Create 2 robots, RotaError when the folder cannot be written to.
    """
    return write_sketches(plan, program_texts(plan, covers=covers), folder)


def program_texts(plan: Plan, *, covers: str) -> tuple[str, ...]:
    """The programs' texts, in the plan's order of robots."""
    require_bouncing(plan)
    mission = plan.mission
    return tuple(
        _text(mission, trajectory.robot, angle_deg, turning_speed_m_s(plan, trajectory), covers)
        for trajectory, angle_deg in zip(
            plan.trajectories, mission.bouncing.angles_of(len(plan.trajectories)), strict=True
        )
    )


def _text(mission: Mission, robot: str, angle_deg: float, turn_m_s: float, covers: str) -> str:
    """The program of a robot that drives straight and turns at every bump."""
    speed_m_s = min(mission.fleet.robot(robot).speed_m_s, FASTEST_M_S)
    x0, y0, x1, y1 = mission.area.bounds
    longest_s = LONGER * math.hypot(x1 - x0, y1 - y0) / speed_m_s
    return sketch_of(
        "create2_reactive.ino",
        TITLE=one_line(f"{robot}: {mission.name}"),
        ANGLE=f"{angle_deg:g}",
        COVERS=one_line(covers),
        BACK_OFF_MM_S=str(round(BACK_OFF_SPEED_M_S * 1e3)),
        TURN_MM_S=str(round(turn_m_s * 1e3)),
        SPEED_MM_S=str(round(speed_m_s * 1e3)),
        ANGLE_TENTHS=str(round(math.degrees(angle_turned(math.radians(angle_deg))) * 10)),
        LONGEST_MS=str(round(longest_s * 1e3)),
    )
