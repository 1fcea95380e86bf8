"""A swarm that moves step by step: all robots decide from one snapshot, then all move."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.mission import MovingObstacle
from rota.planners.swarm.filter_kernels import filter_velocities
from rota.planners.swarm.kernels import Grid, Kinds, Near, Robots, Rule, move_and_sort
from rota.planners.swarm.velocity_set_kernels import MOST_CORNERS, Outline
from rota.planners.swarm.world import make_grid, moving_at, widest_m

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
CHUNKS_PER_THREAD = 4  # so that a thread with an easy share takes another one
FEWEST_PER_CHUNK = 256


class _Room(NamedTuple):
    """What one thread writes to while it decides."""

    near: Near
    outline: Outline
    spare: Outline


class Swarm:
    """n robots, their places and velocities; ``step`` moves them. The same on any number of threads, bit for bit.

    places_m: (n, 2) starts. kinds, kind: what robots are like, and which of it each robot is, (n,). walls: (m, 4)
    segments, at least one. decide: the controller's kernel; rule: what it reads. safe: whether the last filter is
    applied. moving: discs that do not give way. velocities_m_s: (n, 2) before the first step; None: at rest.

    To go on with a run that was stopped after so many ``steps``: names (n,), the numbers in the fleet of those at
    places_m, in the order in which they stood in ``robots``.
    """

    def __init__(
        self,
        places_m: Floats,
        *,
        kinds: Kinds,
        kind: Ints,
        walls: Floats,
        decide: Callable[..., None],
        rule: Rule,
        safe: bool = True,
        moving: tuple[MovingObstacle, ...] = (),
        velocities_m_s: Floats | None = None,
        names: Ints | None = None,
        steps: int = 0,
        threads: int = 1,
    ) -> None:
        n = len(places_m)
        speeds = np.zeros((n, 2)) if velocities_m_s is None else velocities_m_s
        names = np.arange(n, dtype=np.int64) if names is None else names.copy()
        self.steps = steps
        self.moving = moving
        self.grid: Grid = make_grid(walls, kinds, n, rule.time_step_s)
        self.kinds, self.rule, self.safe = kinds, rule, safe
        self._decide = decide
        x, y, vx, vy = (np.array(values, np.float64) for values in (*places_m.T, *speeds.T))
        self._robots = Robots(x, y, vx, vy, kind[names].astype(np.int64), names)
        self._spare = _room_for(n)
        self._cell = np.empty(n, np.int64)
        self._nearest2 = np.empty(n)
        self._widest_m = widest_m(kinds, rule.time_step_s)
        self._threads = threads
        chunks = min(CHUNKS_PER_THREAD * threads, n // FEWEST_PER_CHUNK) if threads > 1 else 1
        self._cuts = [n * k // max(chunks, 1) for k in range(max(chunks, 1) + 1)]
        self._rooms = [_room(max(rule.neighbours, 1)) for _ in self._cuts[1:]]
        self._pool = ThreadPoolExecutor(threads) if len(self._cuts) > 2 else None
        self._sort(0.0)

    def __len__(self) -> int:
        return len(self._cell)

    @property
    def robots(self) -> Robots:
        """The state in the order of the grid; only to look at, and only until the next step."""
        return self._robots

    @property
    def sensor_square_sum_m2(self) -> float:
        """Sum over all robots of the sensor's radius squared."""
        return float((self.kinds.sensor_m[self._robots.kind] ** 2).sum())

    @property
    def places_m(self) -> Floats:
        """(n, 2) in the order of the fleet."""
        return self._in_order(self._robots.x, self._robots.y)

    @property
    def velocities_m_s(self) -> Floats:
        """(n, 2) of the last step, in the order of the fleet."""
        return self._in_order(self._robots.vx, self._robots.vy)

    def step(self) -> float:
        """Decide and move once; returns the longest way of any robot in metres."""
        moving = moving_at(self.moving, self.steps * self.rule.time_step_s, self.rule.time_step_s)
        # decisions go to the spare state's velocities, which nobody reads meanwhile
        if self._pool is None:
            self._decide_for(0, len(self), self._rooms[0], moving)
        else:
            jobs = [
                self._pool.submit(self._decide_for, begin, end, room, moving)
                for (begin, end), room in zip(pairwise(self._cuts), self._rooms, strict=True)
            ]
            for job in jobs:
                job.result()
        decided = self._robots._replace(vx=self._spare.vx, vy=self._spare.vy)
        self._spare = self._spare._replace(vx=self._robots.vx, vy=self._robots.vy)
        self._robots = decided
        self.steps += 1
        return self._sort(self.rule.time_step_s)

    def _decide_for(self, begin: int, end: int, room: _Room, moving: Any) -> None:
        new = self._spare
        self._decide(
            begin, end, self.steps, self._robots, self.kinds, self.grid, moving, self.rule,
            new.vx, new.vy, self._nearest2, room.near, room.outline, room.spare,
        )  # fmt: skip
        if self.safe:
            filter_velocities(
                begin, end, self._robots, self.kinds, self.grid, moving, self.rule.time_step_s, self._widest_m,
                new.vx, new.vy, self._nearest2, room.outline, room.spare,
            )  # fmt: skip

    def _sort(self, time_step_s: float) -> float:
        farthest2 = move_and_sort(self._robots, self._spare, self.grid, self._cell, time_step_s)
        self._robots, self._spare = self._spare, self._robots
        return float(np.sqrt(farthest2))

    def _in_order(self, x: Floats, y: Floats) -> Floats:
        values = np.empty((len(self), 2))
        values[self._robots.name, 0] = x
        values[self._robots.name, 1] = y
        return values


def _room_for(n: int) -> Robots:
    x, y, vx, vy = np.empty((4, n))
    return Robots(x, y, vx, vy, *np.empty((2, n), np.int64))


def _room(most: int) -> _Room:
    outlines = [Outline(np.empty(MOST_CORNERS), np.empty(MOST_CORNERS)) for _ in range(2)]
    return _Room(Near(np.empty(most, np.int64), np.empty(most)), *outlines)
