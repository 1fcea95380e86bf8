"""Whether a bouncing robot meets another one, which turns it where no wall does."""

from __future__ import annotations

import math

import numpy as np

from rota.check.arrays import Ints
from rota.check.bounce_floor import Floor
from rota.check.tolerances import SAME_TIME, TOUCH_M
from rota.model.plan import Plan, Trajectory


class Around:
    """The robots of a plan at the beginning of a step."""

    def __init__(self, plan: Plan, floor: Floor) -> None:
        self._plan, self._floor = plan, floor
        rules = plan.mission.planning.bouncing
        self._swept = rules is not None and rules.contact == "swept"

    def meets(self, robot: Trajectory, cell: Ints, heading: int, time_s: float) -> bool:
        """Whether the robot's move would bring it in contact with another one in the step that begins at ``time_s``.

        Contact is one target, one middle of the way, or bodies that touch where the mission says "swept". Another robot
        counts with the move that it makes and, where it stays, also with the move that it wanted: a contact stops both.
        """
        fleet = self._plan.mission.fleet
        mine_m = fleet.robot(robot.robot).body_radius_m
        for other in self._plan:
            if other.robot == robot.robot:
                continue
            apart_m = mine_m + fleet.robot(other.robot).body_radius_m if self._swept else 0.0
            for begin, end in self._moves_of(other, time_s):
                if self._touch(cell, cell + self._floor.moves[heading], begin, end, apart_m / self._floor.cell_m):
                    return True
        return False

    def _moves_of(self, other: Trajectory, time_s: float) -> list[tuple[Ints, Ints]]:
        """What the other does in the step from ``time_s`` on, and what it wanted to: from and to which cells."""
        times = other.times_s
        if time_s > times[-1] and other.loop_duration_s > 0:
            time_s = other.loop_start_s + (time_s - other.loop_start_s) % other.loop_duration_s
        leg = int(np.searchsorted(times, time_s + SAME_TIME * (1 + time_s), side="right")) - 1
        if leg >= len(times) - 1:
            cells, _ = self._floor.cells_at(other.positions_m[-1:, :2])
            return [(cells[0], cells[0]), *self._wanted_moves(other, cells[0], len(times) - 1)]
        share = np.clip((time_s - times[leg]) / (times[leg + 1] - times[leg]), 0.0, 1.0)
        share += other.bends[leg] * share * (share - 1)
        way = other.positions_m[leg + 1, :2] - other.positions_m[leg, :2]
        cells, centred = self._floor.cells_at((other.positions_m[leg, :2] + share * way)[None])
        if not centred[0]:
            return []  # it is between two cells, so no step begins for it
        direction = int(np.argmax(self._floor.moves @ way / np.hypot(*self._floor.moves.T)))
        if way.any():
            return [(cells[0], cells[0] + self._floor.moves[direction])]
        return [(cells[0], cells[0]), *self._wanted_moves(other, cells[0], leg)]

    def _wanted_moves(self, other: Trajectory, cell: Ints, leg: int) -> list[tuple[Ints, Ints]]:
        """The move along the heading that a standing robot has, or had when it last moved."""
        moves = self._floor.moves
        if other.headings_rad is not None:
            facing = np.array([math.cos(other.headings_rad[leg]), math.sin(other.headings_rad[leg])])
        else:
            ways = np.diff(other.positions_m[: leg + 1, :2], axis=0)
            moved = np.flatnonzero(ways.any(axis=1))
            if not len(moved):
                return [(cell, cell + move) for move in moves]
            facing = ways[moved[-1]]
        heading = int(np.argmax(moves @ facing / np.hypot(*moves.T)))
        return [(cell, cell + moves[heading])]

    @staticmethod
    def _touch(a: Ints, a_end: Ints, b: Ints, b_end: Ints, apart_cells: float) -> bool:
        """Whether two even moves come in contact; distances in cells."""
        if (a_end == b_end).all() or (a + a_end == b + b_end).all():
            return True
        gap, drift = (b - a).astype(float), ((b_end - b) - (a_end - a)).astype(float)
        drift2 = float(drift @ drift)
        share = min(1.0, max(0.0, -float(gap @ drift) / drift2)) if drift2 > 0 else 0.0
        return float(np.hypot(*(gap + share * drift))) < apart_cells - TOUCH_M
