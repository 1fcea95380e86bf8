"""Robots sorted by the cells of a grid, as swarms in the plane and in space have them, and where they begin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rota.errors import CheckpointError
from rota.model.arrays import Floats, Ints
from rota.model.mission import MovingObstacle
from rota.planners.swarm.deciding import deciding_room
from rota.planners.swarm.free_ground_kernels import settle_distances
from rota.planners.swarm.kernels import move_and_sort
from rota.planners.swarm.settle_kernels import note_wishes
from rota.planners.swarm.state import FleetKinds, Grid, PlaceGraph, Robots, Rule, Snapshot
from rota.planners.swarm.world import moving_at


@dataclass(frozen=True, eq=False)
class Beginning:
    """Where n robots begin: at their starts, or in the middle of a run that goes on; d is 2, in space 3.

    places_m: (n, d). velocities_m_s: (n, d) before the first step; None: at rest. The rest tells of the run so far.
    names: (n,) the numbers in the fleet of those at places_m, in the order in which ``robots`` had them;
    None: 0 to n - 1. steps: how many the run has made. past, news_m: ``Swarm.past`` and ``Swarm.news_m`` then; None:
    nothing has been told.
    """

    places_m: Floats
    velocities_m_s: Floats | None = None
    names: Ints | None = None
    steps: int = 0
    past: Floats | None = None
    news_m: Floats | None = None

    @property
    def known_velocities_m_s(self) -> Floats:
        """(n, d) velocities, 0 where none are given."""
        return np.zeros(self.places_m.shape) if self.velocities_m_s is None else self.velocities_m_s

    @property
    def known_names(self) -> Ints:
        """(n,) numbers in the fleet, a copy."""
        return np.arange(len(self.places_m), dtype=np.int64) if self.names is None else self.names.copy()


class SortedRobots:
    """n robots in the order of a grid's cells, their places and velocities in the plane.

    fleet: all rows of kinds, and each robot's; those of kinds from ``member_kinds`` on are bodies only. Raises
    CheckpointError for news of other places.
    """

    moving: tuple[MovingObstacle, ...] = ()

    def __init__(self, beginning: Beginning, fleet: FleetKinds, member_kinds: int, grid: Grid, rule: Rule) -> None:
        n, names, (self.kinds, kind) = len(beginning.places_m), beginning.known_names, fleet
        self.steps, self.grid, self.rule = beginning.steps, grid, rule
        if (news_m := beginning.news_m) is not None:
            if len(news_m) != (places := len(grid.place_graph.x)):
                raise CheckpointError(f"news_m: numbers of {len(news_m)} places; {places} are needed")
            grid.place_graph.away_m[self.steps % 2] = news_m
        starts = (*beginning.places_m.T[:2], *beginning.known_velocities_m_s.T[:2])
        x, y, vx, vy = (np.array(values, np.float64) for values in starts)
        self._robots = Robots(x, y, vx, vy, kind[names], names, member_kinds)
        self._spare = room_for(n, member_kinds)
        self._cell, self._nearest2, self._unsorted_m = np.empty(n, np.int64), np.empty(n), 0.0

    def __len__(self) -> int:
        return len(self._cell)

    @property
    def robots(self) -> Robots:
        """The state in the plane in the order of the grid; only to look at, and only until the next step."""
        return self._robots

    @property
    def news_m(self) -> Floats:
        """(k,): how far it is to free ground from each place of the map, as told; of "settle" only, else k = 0."""
        return np.array(self.grid.place_graph.away_m[self.steps % 2])

    @property
    def news_rest(self) -> bool:
        """Whether news of all free ground have arrived; see ``have_arrived``."""
        return have_arrived(self.steps, self.grid.place_graph)

    def wishes_m(self) -> Floats:
        """(n,) in the order of the fleet: how far robots that settle would go in the plane if nothing held them.

        That is once all news have arrived; see ``note_wishes``.
        """
        moving = moving_at(self.moving, self.steps * self.rule.time_step_s, self.rule.time_step_s)
        graph, wishes, in_order = self.grid.place_graph, np.empty(len(self)), np.empty(len(self))
        graph = graph._replace(away_m=np.tile(settled_news(self.steps, graph), (2, 1)))
        grid = self.grid._replace(place_graph=graph)
        note_wishes(
            Snapshot(self.steps, self._robots, self.kinds, grid, moving, self.rule), wishes, deciding_room(self.rule)
        )
        in_order[self._robots.name] = wishes
        return in_order

    def _sort(self, time_step_s: float) -> float:
        """Move the robots in the plane for that time and sort them by cell; returns the longest way in metres."""
        farthest2 = move_and_sort(self._robots, self._spare, self.grid, self._cell, time_step_s)
        self._robots, self._spare = self._spare, self._robots
        self._unsorted_m = 0.0
        return float(np.sqrt(farthest2))

    def _in_order(self, x: Floats, y: Floats) -> Floats:
        """(n, 2) values in the order of the fleet, from two (n,) in the order of the grid."""
        values = np.empty((len(self), 2))
        values[self._robots.name, 0] = x
        values[self._robots.name, 1] = y
        return values


def have_arrived(step: int, graph: PlaceGraph) -> bool:
    """Whether at a step all places from which a way leads to free ground tell how long it is.

    What others tell is old: of ground that has been taken since. It goes round for long and is not waited for.
    """
    settled = settled_news(step, graph)
    return bool(((settled >= graph.far_m) | (settled == graph.away_m[step % 2])).all())


def settled_news(step: int, graph: PlaceGraph) -> Floats:
    """(k,): what places will tell of free ground if nobody moves any more."""
    settled = np.empty(len(graph.x))
    settle_distances(step, graph, settled)
    return settled


def room_for(n: int, member_kinds: int) -> Robots:
    """A state of n robots that is yet to be written."""
    x, y, vx, vy = np.empty((4, n))
    return Robots(x, y, vx, vy, np.empty(n, np.int64), np.empty(n, np.int64), member_kinds)
