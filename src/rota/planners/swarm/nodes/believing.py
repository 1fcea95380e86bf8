"""What one robot believes of itself and of the others, in the arrays that the swarm's compiled decisions take."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from rota.planners.swarm.deciding import deciding_room
from rota.planners.swarm.delayed_news_kernels import MOST_SPEED_GAIN, no_faster
from rota.planners.swarm.filter_kernels import filter_velocities
from rota.planners.swarm.free_ground_kernels import load_with_all, pass_on_distances
from rota.planners.swarm.kernels import cell_of
from rota.planners.swarm.nodes.hearing import Known
from rota.planners.swarm.state import Decisions, Grid, Kinds, Moving, Robots, Rule, Snapshot


class Belief:
    """Room for one robot's decision: itself and whatever it knows of, all in the cell of the grid that it stands in.

    own: what it is like, kinds of one row. Robots are as many as the fleet has at most, and their starts.
    """

    def __init__(
        self, own: Kinds, number: int, fleet: int, grid: Grid, rule: Rule, decide: Callable[..., None]
    ) -> None:
        most = 2 * fleet
        self._own, self._number, self._rule, self._decide = own, number, rule, decide
        x, y, vx, vy, self._reach_m = np.zeros((5, most))
        self._robots = Robots(x, y, vx, vy, np.arange(most), np.zeros(most, np.int64), 1)
        self._kinds = Kinds(*np.zeros((len(Kinds._fields), most)))
        self._grid = grid._replace(start=np.zeros_like(grid.start))
        self._out = Decisions(np.zeros(1), np.zeros(1), np.zeros(1))
        self._room = deciding_room(rule)
        self._members: frozenset[int] = frozenset()
        self._last_change = 0

    def decision(
        self, place: tuple[float, float], last: tuple[float, float], known: Sequence[Known], moving: Moving, step: int
    ) -> tuple[float, float]:
        """The velocity that the swarm's controller and its last filter give a robot at a place.

        last: the velocity that it went with. known: neighbours first, then mere bodies.
        """
        robots, widest_m = self._fill(place, last, known)
        members = frozenset(other.robot for other in known if other.is_member)
        if members != self._members or moving.vx.any() or moving.vy.any():
            self._members, self._last_change = members, step
        rule = self._rule._replace(last_change=self._last_change)
        snapshot = Snapshot(step, robots, self._kinds, self._grid, moving, rule)
        graph = self._grid.place_graph
        if len(graph.x):
            load_with_all(robots._replace(x=robots.x[: len(known) + 1]), self._kinds, graph)
            pass_on_distances(step, graph)
        cell = self._stand_in_cell(place, len(known) + 1)
        self._decide(0, 1, snapshot, self._out, self._room)
        filter_velocities(0, 1, snapshot, widest_m, self._reach_m, self._out, self._room)
        self._stand_in_cell(place, 0, cell)
        speed = float(np.hypot(*last)) + MOST_SPEED_GAIN * float(self._own.speed_m_s[0])
        vx, vy = no_faster(float(self._out.vx[0]), float(self._out.vy[0]), speed)
        return float(vx), float(vy)

    def _fill(
        self, place: tuple[float, float], last: tuple[float, float], known: Sequence[Known]
    ) -> tuple[Robots, float]:
        """The arrays with the robot itself in the first row, and how far off the filter must look."""
        robots, kinds, own = self._robots, self._kinds, self._own
        time_step_s = self._rule.time_step_s
        robots.x[0], robots.y[0], robots.vx[0], robots.vy[0] = *place, *last
        robots.name[0] = self._number
        for values, value in zip(kinds, own, strict=True):
            values[0] = value[0]
        members, widest_m = 1, float(own.body_m[0] + own.speed_m_s[0] * time_step_s)
        for k, other in enumerate(known, 1):
            robots.x[k], robots.y[k], robots.vx[k], robots.vy[k] = other.x, other.y, other.vx, other.vy
            robots.name[k] = other.robot
            kinds.body_m[k], kinds.sensor_m[k], kinds.speed_m_s[k] = other.body_m, other.sensor_m, other.speed_m_s
            kinds.wall_range_m[k] = own.wall_range_m[0]
            self._reach_m[k] = other.reach_m
            members += other.is_member
            widest_m = max(widest_m, other.body_m + other.speed_m_s * time_step_s + other.reach_m)
        return robots._replace(member_kinds=members), widest_m

    def _stand_in_cell(self, place: tuple[float, float], count: int, cell: int | None = None) -> int:
        """Let the first ``count`` robots be all that stands in the place's cell and beside it; returns the cell."""
        c = int(cell_of(*place, self._grid)) if cell is None else cell
        start, stride = self._grid.start, self._grid.columns + 2
        start[c - stride - 1], start[c - stride + 2] = 0, 0
        start[c - 1], start[c + 2] = 0, count
        start[c + stride - 1], start[c + stride + 2] = count, count
        return c
