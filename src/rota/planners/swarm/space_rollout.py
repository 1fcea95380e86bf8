"""A swarm that moves in three dimensions, in bands of altitudes; all decide from one snapshot, then all move."""

from __future__ import annotations

import numpy as np

from rota.cells.importance_cells import ImportanceCells
from rota.model.arrays import Floats
from rota.planners.swarm.chunks import Chunks
from rota.planners.swarm.deciding import deciding_room
from rota.planners.swarm.free_ground_kernels import load_with_all, pass_on_distances
from rota.planners.swarm.settle_kernels import decide_settle
from rota.planners.swarm.sorted_robots import Beginning, SortedRobots
from rota.planners.swarm.space_kernels import (
    Bands,
    Heights,
    SpaceDecisions,
    SpaceRoom,
    SpaceSnapshot,
    climb,
    decide_in_space,
    filter_in_space,
)
from rota.planners.swarm.space_set_kernels import MOST_PLANES
from rota.planners.swarm.state import Decisions, FleetKinds, Rule, Snapshot
from rota.planners.swarm.world import make_grid, moving_at

FEWEST_PER_CHUNK = 16  # robots whose decisions take about as long as it takes to wake a thread


class SpaceSwarm(SortedRobots):
    """n robots in space, bodies and velocities balls; ``step`` moves them. The same on any number of threads.

    beginning: places (n, 3) in the bands, whose heights may be equal; robots in space tell each other nothing of
    themselves, so that past is of no use. walls: (m, 4) segments, at least one, closed rings for ``settles``. rule:
    samples, circle and alpha are of no use. bands: for each robot. full_m: (n,) for each robot the height in its band
    from which on its footprint grows no more; -inf for one that never grows. settles: robots decide in the plane by
    "settle", with the footprints that they have at full_m, and climb there; else by the reciprocal controller. safe:
    whether the last filter is applied. importance: of the ground; None: all is worth as much.
    """

    def __init__(
        self,
        beginning: Beginning,
        fleet: FleetKinds,
        walls: Floats,
        rule: Rule,
        *,
        bands: Bands,
        full_m: Floats,
        importance: ImportanceCells | None = None,
        settles: bool = False,
        safe: bool = True,
        threads: int = 1,
    ) -> None:
        n, names, (kinds, kind) = len(beginning.places_m), beginning.known_names, fleet
        grid = make_grid(walls, kinds, n, rule.time_step_s, importance=importance, mapped=settles)
        super().__init__(beginning, FleetKinds(kinds, kind.astype(np.int64)), len(kinds.body_m), grid, rule)
        self._bands, self._safe, self._settles = bands, safe, settles
        self._full_m = np.asarray(full_m, np.float64)
        self._heights, self._new_vz = Heights(np.empty(n), np.empty(n)), np.empty(n)
        self._heights.z[names] = beginning.places_m[:, 2]
        self._heights.vz[names] = beginning.known_velocities_m_s[:, 2]
        self._chunks = Chunks(n, threads, FEWEST_PER_CHUNK)
        rooms = [deciding_room(rule) for _ in range(len(self._chunks))]
        self._rooms = [(SpaceRoom(r.near, np.empty((MOST_PLANES, 4)), r.outline, r.spare), r) for r in rooms]
        self._sort(0.0)

    @property
    def past(self) -> Floats:
        """(0, 4, n): what messages may still tell, which is nothing, since everybody knows all."""
        return np.empty((0, 4, len(self)))

    @property
    def places_m(self) -> Floats:
        """(n, 3) in the order of the fleet."""
        return np.column_stack([self._in_order(self._robots.x, self._robots.y), self._heights.z])

    @property
    def velocities_m_s(self) -> Floats:
        """(n, 3) of the last step, in the order of the fleet."""
        return np.column_stack([self._in_order(self._robots.vx, self._robots.vy), self._heights.vz])

    def step(self) -> float:
        """Decide and move once; returns the longest way of any robot in metres."""
        new, time_step_s = self._spare, self.rule.time_step_s
        self._decide(SpaceDecisions(new.vx, new.vy, self._new_vz))
        decided = self._robots._replace(vx=new.vx, vy=new.vy)
        self._spare = new._replace(vx=self._robots.vx, vy=self._robots.vy)
        self._robots = decided
        self.steps += 1
        heights = self._heights
        heights.vz[:] = self._new_vz
        # rounding must not carry anybody out of its band
        np.clip(heights.z + heights.vz * time_step_s, self._bands.low_m, self._bands.high_m, out=heights.z)
        farthest2 = decided.vx**2 + decided.vy**2 + heights.vz[decided.name] ** 2
        self._sort(time_step_s)
        return float(np.sqrt(farthest2.max())) * time_step_s

    def _decide(self, decisions: SpaceDecisions) -> None:
        """The velocities of all robots, from one snapshot."""
        robots, kinds, grid, rule = self._robots, self.kinds, self.grid, self.rule
        snapshot = SpaceSnapshot(robots, self._heights, kinds, self._full_m, grid, self._bands, rule)
        plane = Snapshot(self.steps, robots, kinds, grid, moving_at((), 0.0, rule.time_step_s), rule)
        in_plane = Decisions(decisions.vx, decisions.vy, self._nearest2)
        if self._settles:
            load_with_all(robots, kinds, grid.place_graph)
            pass_on_distances(self.steps, grid.place_graph)

        def decide_part(begin: int, end: int, part: int) -> None:
            room, plane_room = self._rooms[part]
            if self._settles:
                decide_settle(begin, end, plane, in_plane, plane_room)
                climb(begin, end, snapshot, self._nearest2, decisions)
            else:
                decide_in_space(begin, end, snapshot, decisions, room)
            if self._safe:
                filter_in_space(begin, end, snapshot, decisions)

        self._chunks.run(decide_part)
