"""Where bouncing robots begin: at the cells of the mission's starts, or at random ones, and the headings they face."""

from __future__ import annotations

import math

import numpy as np

from rota.errors import MissionError
from rota.model.mission import TOUCH_M, Mission, Robot
from rota.planners.bounce.arrays import Floats, Ints
from rota.planners.bounce.cells import Cells
from rota.planners.bounce.planner_settings import BounceSettings

TRIES = 10_000


def robots_of(mission: Mission, count: int | None = None) -> tuple[Robot, ...]:
    """The mission's robots, or ``count`` equal robots of a fleet of as few as possible."""
    if mission.fleet.robots is not None:
        return mission.fleet.robots
    return tuple(mission.fleet.equal_robot(f"robot-{k + 1}") for k in range(count or 1))


def start_cells(cells: Cells, robots: tuple[Robot, ...]) -> list[int | None]:
    """The cell of each robot's start, None where the robot has no start.

    Raises MissionError for a start that is not the centre of a free cell, and for two robots in one cell.
    """
    occupied: list[int | None] = []
    for robot in robots:
        if robot.start is None:
            occupied.append(None)
            continue
        cell = cells.at(robot.start)
        if cell is None or math.dist(cells.centres_m[cell], robot.start) > TOUCH_M:
            x, y = robot.start
            near_x, near_y = cells.centres_m[np.hypot(*(cells.centres_m - robot.start).T).argmin()]
            raise MissionError(
                f"robot {robot.name}: start: [{x:.9g}, {y:.9g}] is not allowed; bouncing robots start at the centre of"
                f" a free cell, the nearest is [{near_x:.9g}, {near_y:.9g}]"
            )
        if cell in occupied:
            other = robots[occupied.index(cell)].name
            raise MissionError(f"robot {robot.name}: start: is in one cell with robot {other}; each needs its own")
        occupied.append(cell)
    return occupied


def start_headings(mission: Mission, robots: int) -> list[int] | None:
    """The heading of each robot at its start, in heading steps; None: the mission does not say."""
    settings = BounceSettings.of(mission)
    if settings.start_headings_deg is None:
        return None
    angles = settings.start_headings_deg
    step_deg = 360 / settings.headings
    angles_of_robots = angles * robots if len(angles) == 1 else angles
    return [round(angle / step_deg) % settings.headings for angle in angles_of_robots]


def random_starts(mission: Mission, cells: Cells, robots: tuple[Robot, ...], apart_m: Floats, seed: int) -> Ints:
    """(m,) states in which the robots begin: in the cells and headings that the mission gives, at random otherwise.

    apart_m: (m, m), the least distance of two centres. Raises MissionError when so many robots find no room.
    """
    rng = np.random.default_rng(seed)
    start_of, facing = start_cells(cells, robots), start_headings(mission, len(robots))
    if len(robots) > cells.count:
        free_cells = "there is only 1 free cell" if cells.count == 1 else f"there are only {cells.count} free cells"
        message = f"{len(robots)} robots are not allowed; {free_cells}"
        raise MissionError(f"fleet.robots: {message}")
    taken = [cell for cell in start_of if cell is not None]
    free = np.setdiff1d(np.arange(cells.count), taken)
    for _ in range(TRIES if len(taken) < len(robots) else 1):
        drawn = iter(rng.choice(free, len(robots) - len(taken), replace=False).tolist())
        chosen = [int(next(drawn)) if cell is None else cell for cell in start_of]
        if _apart(cells, chosen, apart_m) or len(taken) == len(robots):
            break
    else:
        raise MissionError(f"fleet.robots: no room was found for {len(robots)} bodies in {TRIES} tries; give fewer")
    headings = facing if facing is not None else rng.integers(0, cells.headings, len(robots)).tolist()
    return np.array([cell * cells.headings + h for cell, h in zip(chosen, headings, strict=True)], np.int32)


def _apart(cells: Cells, chosen: list[int], apart_m: Floats) -> bool:
    """Whether the centres of the chosen cells (m,) are as far apart as apart_m (m, m) asks."""
    centres = cells.centres_m[chosen]
    gaps = np.hypot(*(centres[:, None] - centres).transpose(2, 0, 1))
    return bool(((gaps >= apart_m - TOUCH_M) | np.eye(len(chosen), dtype=bool)).all())
