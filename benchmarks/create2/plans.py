"""Plans of bouncing robots made step by step on a typed map, by nothing but Eq. 6 of Alam and Bobadilla 2020."""

from __future__ import annotations

import math
from dataclasses import dataclass

from shapely import MultiPolygon, box, union_all

from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot, Zone
from rota.model.plan import Plan, Trajectory
from rota.planners.bounce.planner_settings import BounceSettings

STEPS = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))
BODY_RADIUS_M = 0.17
State = tuple[tuple[int, int, int], ...]


@dataclass(frozen=True, kw_only=True)
class TypedMap:
    """Rows from north to south: ``.`` free, ``#`` obstacle; cells of ``cell_m``, the south-west corner at (0, 0)."""

    rows: tuple[str, ...]
    cell_m: float

    def is_free(self, column: int, row: int) -> bool:
        """Whether a robot can be in this cell; rows count from the south."""
        inside = 0 <= row < len(self.rows) and 0 <= column < len(self.rows[0])
        return inside and self.rows[-1 - row][column] == "."

    def centre_m(self, column: int, row: int) -> tuple[float, float]:
        """Where the cell's centre is."""
        return (column + 0.5) * self.cell_m, (row + 0.5) * self.cell_m


def bounced_plan(ground: TypedMap, starts: State, *, turn: int, speed_m_s: float, headings: int = 8) -> Plan:
    """Robots at ``starts`` (column, row, heading in 45 degrees) that turn by ``turn`` times 45 degrees, for ever."""
    states, loop_from = _until_it_repeats(ground, starts, turn)
    longest_m = ground.cell_m * (math.sqrt(2) if headings == 8 else 1)
    step_s = longest_m / speed_m_s
    robots = tuple(
        Robot(name=f"robot-{k + 1}", speed_m_s=speed_m_s, sensor=DiscSensor(radius_m=0.5), body_radius_m=BODY_RADIUS_M)
        for k in range(len(starts))
    )
    trajectories = tuple(
        Trajectory(
            robot=robot.name,
            times_s=[step_s * n for n in range(len(states))],
            positions_m=[ground.centre_m(*state[k][:2]) for state in states],
            headings_rad=[state[k][2] * math.pi / 4 for state in states],
            loop_start_s=step_s * loop_from,
        )
        for k, robot in enumerate(robots)
    )
    return Plan(mission=_mission(ground, robots, turn, speed_m_s, headings), trajectories=trajectories)


def _until_it_repeats(ground: TypedMap, starts: State, turn: int) -> tuple[list[State], int]:
    states, known = [starts], {starts: 0}
    while True:
        state = _next(ground, states[-1], turn)
        states.append(state)
        if state in known:
            return states, known[state]
        known[state] = len(states) - 1


def _next(ground: TypedMap, state: State, turn: int) -> State:
    """One step: who is blocked, by a wall or by another robot, stays and turns; the others move."""
    targets = {}
    for k, (column, row, heading) in enumerate(state):
        dx, dy = STEPS[heading]
        cells = ((column + dx, row + dy), (column + dx, row), (column, row + dy))
        targets[k] = cells[0] if all(ground.is_free(*cell) for cell in cells) else (column, row)
    while True:
        places = [(*state[k][:2], *targets[k]) for k in targets]
        blocked = {
            k
            for k, (x, y, u, v) in enumerate(places)
            for n, (p, q, r, s) in enumerate(places)
            if n != k and (u, v) != (x, y) and ((u, v) == (r, s) or (x + u, y + v) == (p + r, q + s))
        }
        if not blocked:
            break
        for k in blocked:
            targets[k] = state[k][:2]
    return tuple(
        (*targets[k], heading if targets[k] != (column, row) else (heading + turn) % 8)
        for k, (column, row, heading) in enumerate(state)
    )


def _mission(ground: TypedMap, robots: tuple[Robot, ...], turn: int, speed_m_s: float, headings: int) -> Mission:
    cell, rows = ground.cell_m, len(ground.rows)
    blocks = [
        box(column * cell, row * cell, (column + 1) * cell, (row + 1) * cell)
        for row in range(rows)
        for column in range(len(ground.rows[0]))
        if not ground.is_free(column, row)
    ]
    area = MultiPolygon([box(0, 0, len(ground.rows[0]) * cell, rows * cell)])
    fleet = Fleet(speed_m_s=speed_m_s, sensor=DiscSensor(radius_m=0.5), body_radius_m=BODY_RADIUS_M, robots=robots)
    return Mission(
        name="bouncing on a desk",
        area=area,
        obstacles=(Obstacle(shape=union_all(blocks)),) if blocks else (),
        zones=(Zone(name="all", shape=area, period_s=1e6, demand="visit"),),
        fleet=fleet,
        planning=BounceSettings(cell_m=cell, headings=headings, bouncing_angles_deg=(45.0 * turn,)),
    )
