"""A swarm that moves in three dimensions, in a band of altitudes; all decide from one snapshot, then all move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rota.planners.swarm.kernels import move_and_sort
from rota.planners.swarm.rollout import Beginning, deciding_room, in_fleet_order, room_for
from rota.planners.swarm.space_kernels import (
    Band,
    Heights,
    SpaceDecisions,
    SpaceRoom,
    SpaceSnapshot,
    decide_in_space,
    filter_in_space,
)
from rota.planners.swarm.space_set_kernels import MOST_PLANES
from rota.planners.swarm.state import FleetKinds, Grid, Robots, Rule
from rota.planners.swarm.world import make_grid

Floats = NDArray[np.float64]


class SpaceSwarm:
    """n robots in space, bodies and velocities balls; ``step`` moves them by the reciprocal controller, on one thread.

    beginning: places (n, 3) in the band, whose heights may be equal; robots in space tell each other nothing, so that
    past and news_m are of no use. walls: (m, 4) segments, at least one. rule: samples, circle and alpha are of no use.
    full_m: (n,) for each robot the height from which on its footprint grows no more; -inf for one that never grows.
    safe: whether the last filter is applied.
    """

    def __init__(
        self,
        beginning: Beginning,
        fleet: FleetKinds,
        walls: Floats,
        rule: Rule,
        *,
        band: Band,
        full_m: Floats,
        safe: bool = True,
    ) -> None:
        n, names = len(beginning.places_m), beginning.known_names
        kinds, kind = fleet
        self.steps, self.rule, self.kinds = beginning.steps, rule, kinds
        self.grid: Grid = make_grid(walls, kinds, n, rule.time_step_s)
        self._band, self._safe, self._full_m = Band(*map(float, band)), safe, np.asarray(full_m, np.float64)
        starts = (*beginning.places_m.T, *beginning.known_velocities_m_s.T)
        x, y, z, vx, vy, vz = (np.array(values, np.float64) for values in starts)
        self._robots = Robots(x, y, vx, vy, kind.astype(np.int64)[names], names, len(kinds.body_m))
        self._spare = room_for(n, len(kinds.body_m))
        self._heights, self._new_vz = Heights(np.empty(n), np.empty(n)), np.empty(n)
        self._heights.z[names], self._heights.vz[names] = z, vz
        self._cell = np.empty(n, np.int64)
        near, outline, spare = deciding_room(rule)
        self._room = SpaceRoom(near, np.empty((MOST_PLANES, 4)), outline, spare)
        self._sort(0.0)

    def __len__(self) -> int:
        return len(self._cell)

    @property
    def robots(self) -> Robots:
        """The state in the plane in the order of the grid; only to look at, and only until the next step."""
        return self._robots

    @property
    def past(self) -> Floats:
        """(0, 4, n): what messages may still tell, which is nothing, since everybody knows all."""
        return np.empty((0, 4, len(self)))

    @property
    def news_m(self) -> Floats:
        """None: robots in space keep no numbers of places."""
        return np.empty(0)

    @property
    def places_m(self) -> Floats:
        """(n, 3) in the order of the fleet."""
        return self._in_order(self._robots.x, self._robots.y, self._heights.z)

    @property
    def velocities_m_s(self) -> Floats:
        """(n, 3) of the last step, in the order of the fleet."""
        return self._in_order(self._robots.vx, self._robots.vy, self._heights.vz)

    def step(self) -> float:
        """Decide and move once; returns the longest way of any robot in metres."""
        new, time_step_s = self._spare, self.rule.time_step_s
        snapshot = SpaceSnapshot(
            self._robots, self._heights, self.kinds, self._full_m, self.grid, self._band, self.rule
        )
        decisions = SpaceDecisions(new.vx, new.vy, self._new_vz)
        decide_in_space(snapshot, decisions, self._room)
        if self._safe:
            filter_in_space(snapshot, decisions)
        decided = self._robots._replace(vx=new.vx, vy=new.vy)
        self._spare = new._replace(vx=self._robots.vx, vy=self._robots.vy)
        self._robots = decided
        self.steps += 1
        heights = self._heights
        heights.vz[:] = self._new_vz
        # rounding must not carry anybody out of the band
        np.clip(heights.z + heights.vz * time_step_s, self._band.low_m, self._band.high_m, out=heights.z)
        farthest2 = decided.vx**2 + decided.vy**2 + heights.vz[decided.name] ** 2
        self._sort(time_step_s)
        return float(np.sqrt(farthest2.max())) * time_step_s

    def _sort(self, time_step_s: float) -> None:
        """Move the robots in the plane for that time and sort them by cell."""
        move_and_sort(self._robots, self._spare, self.grid, self._cell, time_step_s)
        self._robots, self._spare = self._spare, self._robots

    def _in_order(self, x: Floats, y: Floats, of_fleet: Floats) -> Floats:
        """(n, 3) values in the order of the fleet; x, y (n,) in that of the grid, of_fleet: in that of the fleet."""
        return np.column_stack([in_fleet_order(self._robots, x, y), of_fleet])
