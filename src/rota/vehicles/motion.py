"""The seam between routes and vehicles: the way goes in, timed motion comes out.

Each firmware has a module with a ``MotionModel``. What it is made of, numbers of its own or a simulation, stays there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rota.errors import RotaError
from rota.model.plan import Floats, Trajectory
from rota.routes.route import RouteStop
from rota.vehicles.track_kernels import kept_samples

WITHIN_M = 0.05  # a trajectory's straight legs stay so near to the motion, at every moment


@dataclass(frozen=True, kw_only=True)
class Wind:
    """Wind that is the same everywhere and always; ``from_deg``: where it comes from, 0 north, 90 east.

    Raises RotaError for a speed below 0 and for numbers that are not finite.
    """

    speed_m_s: float = 0.0
    from_deg: float = 0.0

    def __post_init__(self) -> None:
        if not 0 <= self.speed_m_s < math.inf:
            raise RotaError(f"wind: {self.speed_m_s:g} m/s is not allowed; must be 0 or more")
        if not math.isfinite(self.from_deg):
            raise RotaError(f"wind: from {self.from_deg:g} degrees is not allowed; a finite number is needed")

    @property
    def toward_m_s(self) -> tuple[float, float]:
        """Where the air moves to, x east and y north in m/s."""
        angle = math.radians(self.from_deg)
        return -self.speed_m_s * math.sin(angle), -self.speed_m_s * math.cos(angle)


@dataclass(frozen=True, kw_only=True)
class Way:
    """What a vehicle is told to drive: the stops of ``once`` and then those of ``every_round``, for ever.

    It begins at the first stop of ``once``, which needs no speed, and ends there where the loop begins. every_round
    ends at that same place; empty: the vehicle stays.
    """

    robot: str
    once: tuple[RouteStop, ...]
    every_round: tuple[RouteStop, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """Where a vehicle is at any time: ``positions_m`` (n, 3) at ``times_s`` (n,), straight between them.

    It repeats from ``loop_start_s`` on, which is one of the times; where that is the last one, it stays there. legs_s:
    seconds of each leg of a round, of the way there for one that stays, waits before the leg included. cut_m: how near
    to each leg's end the vehicle comes.
    """

    robot: str
    times_s: Floats
    positions_m: Floats
    loop_start_s: float
    legs_s: Floats
    cut_m: Floats

    @property
    def round_s(self) -> float:
        """How long a round takes; 0 where the vehicle stays."""
        return float(self.times_s[-1]) - self.loop_start_s

    def at(self, times_s: Floats) -> Floats:
        """Positions (m, 3) at these times (m,), rounds without end included."""
        begun_s = np.asarray(times_s, dtype=np.float64)
        if self.round_s > 0:
            late = begun_s > self.loop_start_s
            again_s = self.loop_start_s + np.mod(begun_s - self.loop_start_s, self.round_s)
            begun_s = np.where(late, again_s, begun_s)
        return np.column_stack([np.interp(begun_s, self.times_s, axis) for axis in self.positions_m.T])

    def trajectory(self, *, flat: bool, within_m: float = WITHIN_M) -> Trajectory:
        """The same as straight legs at constant speeds, which are never farther from it; flat: without heights."""
        first = int(np.searchsorted(self.times_s, self.loop_start_s))
        kept = kept_samples(self.times_s, self.positions_m, first, within_m)
        return Trajectory(
            robot=self.robot,
            times_s=self.times_s[kept],
            positions_m=self.positions_m[kept][:, : 2 if flat else 3],
            loop_start_s=self.loop_start_s,
        )


class MotionModel(Protocol):
    """What one firmware makes of a way."""

    def drive(self, way: Way, wind: Wind) -> Motion:
        """The vehicle's motion. Raises RotaError for what it cannot drive, with the robot and the leg."""
        ...

    def round_s(self, way: Way) -> float:
        """About how long a round takes without wind, without driving it; 0 where the vehicle stays."""
        ...
