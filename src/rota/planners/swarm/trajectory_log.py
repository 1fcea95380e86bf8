"""Trajectories of a swarm as they come about: places of every step, thinned block by block."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.model.plan import Trajectory
from rota.planners.swarm.thinning_kernels import thin

LONGEST_BLOCK, SHORTEST_BLOCK = 256, 8  # steps thinned at a time
MOST_PLACES = 16_000_000  # in a block, so that many robots take little memory


class Kept(NamedTuple):
    """Places that thinning has kept: the step of each and the robot, (k,), and the place, (k, 2) or (k, 3)."""

    steps: Ints
    robots: Ints
    places_m: Floats


class TrajectoryLog:
    """recent_m: (r, n, 2 or 3) places since the last block, from step ``begin`` on; kept: of the blocks before.

    Thinning errs by no more than allowed_m at any time.
    """

    def __init__(self, recent_m: Floats, allowed_m: float, *, begin: int = 0, kept: tuple[Kept, ...] = ()) -> None:
        n, axes = recent_m.shape[1:]
        steps = min(max(MOST_PLACES // n, SHORTEST_BLOCK), LONGEST_BLOCK)
        self._block = np.empty((steps + 1, n, axes))
        self._block[: len(recent_m)] = recent_m
        self._filled, self._begin = len(recent_m), begin
        self._allowed_m = allowed_m
        self._kept = list(kept)

    @property
    def recent_m(self) -> Floats:
        """Places (r, n, 2 or 3) that are not thinned yet; the first of them are the last that are."""
        return self._block[: self._filled]

    @property
    def kept(self) -> Kept:
        """All that thinning has kept so far."""
        none = Kept(np.empty(0, np.int64), np.empty(0, np.int64), np.empty((0, self._block.shape[2])))
        return Kept(*(np.concatenate(parts) for parts in zip(none, *self._kept, strict=True)))

    def add(self, places_m: Floats) -> None:
        """Places (n, 2) or (n, 3) after one step more."""
        self._block[self._filled] = places_m
        self._filled += 1
        if self._filled == len(self._block):
            self.keep_last()

    def keep_last(self) -> None:
        """Keep the last places as they are; no thinning goes across them."""
        if self._filled == 1:
            return
        self._kept.append(self._thin())
        self._begin += self._filled - 1
        self._block[0] = self._block[self._filled - 1]
        self._filled = 1

    def _thin(self) -> Kept:
        """What thinning keeps of the places of this block."""
        places = self.recent_m
        marks: Any = np.zeros(places.shape[:2], np.int8)
        thin(places, self._allowed_m, marks)
        if self._begin > 0:
            marks[0] = 0  # it is the last one of the block before
        step, robot = np.nonzero(marks)
        return Kept(step + self._begin, robot, places[step, robot])

    def trajectories(self, names: list[str], time_step_s: float) -> tuple[Trajectory, ...]:
        """One for each robot; at the end it holds."""
        last = [self._thin()] if self._filled > 1 or self._begin == 0 else []
        step, robot, places = (np.concatenate(parts) for parts in zip(*self._kept, *last, strict=True))
        order = np.lexsort((step, robot))
        ends = np.cumsum(np.bincount(robot, minlength=len(names)))[:-1]
        parts = zip(np.split(step[order], ends), np.split(places[order], ends), strict=True)
        return tuple(
            Trajectory(
                robot=name, times_s=steps * time_step_s, positions_m=at, loop_start_s=float(steps[-1] * time_step_s)
            )
            for name, (steps, at) in zip(names, parts, strict=True)
        )
