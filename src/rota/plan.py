"""What is answered: one timed trajectory per robot, for ever."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.errors import PlanError
from rota.mission import Mission

Floats = NDArray[np.float64]


def _frozen(values: object) -> Floats:
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


@dataclass(frozen=True, kw_only=True, eq=False)
class Trajectory:
    """Timed points of one robot: straight legs at constant speed, then the loop for ever.

    times_s: (n,) seconds, from 0, strictly increasing; n >= 1. positions_m: (n, 2) or (n, 3) metres. headings_rad: (n,)
    or None (the direction of motion). ``loop_start_s`` is one of the times: equal to the last, the robot stays where
    it is; otherwise the position then equals the last position exactly and the robot repeats from there.
    """

    robot: str
    times_s: Floats
    positions_m: Floats
    headings_rad: Floats | None = None
    loop_start_s: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "times_s", _frozen(self.times_s))
        object.__setattr__(self, "positions_m", _frozen(self.positions_m))
        if self.headings_rad is not None:
            object.__setattr__(self, "headings_rad", _frozen(self.headings_rad))
        object.__setattr__(self, "loop_start_s", float(self.loop_start_s))
        times, positions = self.times_s, self.positions_m
        if times.ndim != 1 or not len(times):
            raise PlanError(f"robot {self.robot}: times_s has shape {times.shape}; at least one time is needed")
        if positions.ndim != 2 or positions.shape[0] != len(times) or positions.shape[1] not in (2, 3):
            raise PlanError(
                f"robot {self.robot}: positions_m has shape {positions.shape}; ({len(times)}, 2) or ({len(times)}, 3)"
                " is needed, one position per time"
            )
        if self.headings_rad is not None and self.headings_rad.shape != times.shape:
            raise PlanError(f"robot {self.robot}: headings_rad has shape {self.headings_rad.shape}, not {times.shape}")
        if not (np.isfinite(times).all() and np.isfinite(positions).all()):
            raise PlanError(f"robot {self.robot}: times and positions must be finite")
        if times[0] != 0:
            raise PlanError(f"robot {self.robot}: times_s starts at {times[0]}; it must start at 0")
        late = np.flatnonzero(np.diff(times) <= 0)
        if len(late):
            k = int(late[0])
            raise PlanError(f"robot {self.robot}: times_s[{k + 1}] = {times[k + 1]} does not come after {times[k]}")
        start = np.flatnonzero(times == self.loop_start_s)
        if not len(start):
            raise PlanError(f"robot {self.robot}: loop_start_s = {self.loop_start_s} is none of the times")
        if (positions[start[0]] != positions[-1]).any():
            raise PlanError(
                f"robot {self.robot}: the loop does not close: at loop_start_s the position is"
                f" {positions[start[0]].tolist()}, at the end {positions[-1].tolist()}"
            )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Trajectory):
            return NotImplemented
        mine, theirs = self.headings_rad, other.headings_rad
        same_headings = mine is theirs if mine is None or theirs is None else np.array_equal(mine, theirs)
        return (
            self.robot == other.robot
            and self.loop_start_s == other.loop_start_s
            and np.array_equal(self.times_s, other.times_s)
            and np.array_equal(self.positions_m, other.positions_m)
            and same_headings
        )

    @property
    def loop_index(self) -> int:
        """Index of ``loop_start_s`` in ``times_s``."""
        return int(np.searchsorted(self.times_s, self.loop_start_s))

    @property
    def loop_duration_s(self) -> float:
        """Length of the repeated part in seconds; 0 when the robot stays at its last position."""
        return float(self.times_s[-1]) - self.loop_start_s

    @property
    def loop_length_m(self) -> float:
        """Length of the repeated part in metres; 0 when the robot stays at its last position."""
        steps = np.diff(self.positions_m[self.loop_index :], axis=0)
        return float(np.sqrt((steps**2).sum(axis=1)).sum())


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A mission and its answer. ``lower_bound_robots``: no plan with fewer robots exists, proved; None: not known.

    ``lower_bound_reason``: why, in words that go on after "... robots at least:"; None: not told.
    """

    mission: Mission
    trajectories: tuple[Trajectory, ...]
    seed: int = 0
    lower_bound_robots: int | None = None
    lower_bound_reason: str | None = None

    def __post_init__(self) -> None:
        counted = Counter(trajectory.robot for trajectory in self.trajectories)
        for name, count in counted.items():
            if count > 1:
                raise PlanError(f"robot {name} has more than one trajectory")
            self.mission.fleet.robot(name)

    def __iter__(self) -> Iterator[Trajectory]:
        return iter(self.trajectories)
