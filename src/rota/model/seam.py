"""What a plan that takes over from another one goes on from: where robots drove before, and with what they saw."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from rota.errors import PlanError
from rota.model.arrays import Floats
from rota.model.fields import field_of
from rota.model.fleet import Sensor
from rota.model.limits import LONGEST_S
from rota.model.mission import Obstacle
from rota.model.trajectory import PLACES, SHARE, Charge, Place, bends_of, freeze, require_battery

BEFORE: dict[str, Any] = {"least": -LONGEST_S, "most": 0}


@dataclass(frozen=True, kw_only=True, eq=False)
class Driven:
    """What one robot drove before a plan took over, at which the plan's clock is 0.

    times_s: (n,) seconds, rising; the last is 0, or when it was lost in a change before. positions_m: (n, 2).
    sensor: what it saw with. accelerations_m_s2, charges: as a ``Trajectory`` has them. battery: 0 to 1, how full its
    battery was at the first time. climbed_s: of one that is on a charger at the last time, and leaves soon. Raises
    PlanError for other shapes, numbers that are not finite, times that do not rise.
    """

    robot: str = field_of(key="name", count=((1, None),))
    sensor: Sensor = field_of(meaning="what it saw with")
    times_s: Floats = field_of(meaning="up to 0", form=tuple[float, ...], **BEFORE)
    positions_m: Floats = field_of(form=tuple[Place, ...], count=((1, None),), **PLACES)
    accelerations_m_s2: Floats | None = field_of(
        None,
        "along each leg; absent: all legs were driven at constant speeds",
        form=tuple[float, ...] | None,
        count=((0, None),),
        newer=True,
        spared=True,
    )
    charges: tuple[Charge, ...] = field_of((), "stays at chargers", count=((0, None),), newer=True, spared=True)
    battery: float = field_of(1.0, "how full it was at the first time; absent: full", **SHARE)
    climbed_s: float = field_of(
        0.0, "for how long it had been climbing off its charger at the last time", least=0, most=LONGEST_S,
        newer=True, spared=True,
    )  # fmt: skip

    def __post_init__(self) -> None:
        for name in ("times_s", "positions_m", "accelerations_m_s2"):
            if (given := getattr(self, name)) is not None:
                object.__setattr__(self, name, freeze(given))
        times, places, changes = self.times_s, self.positions_m, self.accelerations_m_s2
        who = f"seam: robot {self.robot}"
        if times.ndim != 1 or not len(times) or places.shape != (len(times), 2):
            raise PlanError(f"{who}: times_s {times.shape}, positions_m {places.shape}; (n,) and (n, 2) are needed")
        if changes is not None and changes.shape != (len(times) - 1,):
            raise PlanError(f"{who}: accelerations_m_s2 has shape {changes.shape}, not ({len(times) - 1},)")
        for given in (times, places) if changes is None else (times, places, changes):
            if not np.isfinite(given).all():
                raise PlanError(f"{who}: times, positions and accelerations must be finite")
        if times[-1] > 0:
            raise PlanError(f"{who}: times_s ends at {times[-1]}; the last must be 0, when the plan takes over")
        if any(before >= after for before, after in pairwise(times.tolist())):
            raise PlanError(f"{who}: times_s must rise")
        object.__setattr__(self, "charges", tuple(self.charges))
        require_battery(who, times, self.charges, self.battery)

    @property
    def bends(self) -> Floats:
        """(n - 1,) how the way along each leg bends in time; see ``Trajectory.bends``."""
        return bends_of(self.times_s, self.positions_m, self.accelerations_m_s2)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Driven):
            return NotImplemented
        told = [(one.robot, one.sensor, one.charges, one.battery, one.climbed_s) for one in (self, other)]
        same = told[0] == told[1] and np.array_equal(self.bends, other.bends)
        return (
            same and np.array_equal(self.times_s, other.times_s) and np.array_equal(self.positions_m, other.positions_m)
        )


@dataclass(frozen=True, kw_only=True)
class Seam:
    """Where a plan takes over from another one: at ``at_s`` of that plan's clock, which is 0 of this plan's.

    ``driven``: by each robot of the plan before, until then; they are those that this plan has and ``lost`` ones.
    ``obstacles``: those that blocked sight until then, where they are not those of the mission; None: they are.
    Raises PlanError for a robot that is told twice.
    """

    at_s: float = field_of(meaning="the moment in the clock of the plan before", least=0, most=LONGEST_S)
    lost: tuple[str, ...] = field_of((), "robots that are there no more", count=((0, None), (1, None)))
    driven: tuple[Driven, ...] = field_of(meaning="what robots drove before", count=((0, None),))
    obstacles: tuple[Obstacle, ...] | None = field_of(
        None, "what blocked sight before, where that is not the mission's; absent: it is", count=((0, None),),
        newer=True, spared=True,
    )  # fmt: skip

    def __post_init__(self) -> None:
        for name, count in Counter(driven.robot for driven in self.driven).items():
            if count > 1:
                raise PlanError(f"seam: robot {name} has driven twice")
        for driven in self.driven:
            if (ends_s := driven.times_s[-1]) < 0 and driven.robot not in self.lost:
                raise PlanError(f"seam: robot {driven.robot}: times_s ends at {ends_s}; it is not lost: 0 is needed")

    @property
    def since_s(self) -> float:
        """The first moment that is told of, 0 or before."""
        return min((float(driven.times_s[0]) for driven in self.driven), default=0.0)
