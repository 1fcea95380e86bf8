"""Obstacles that move, as robots of a swarm go round them."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from rota.model.field_values import check_fields
from rota.model.fields import field_of
from rota.model.fleet import Place
from rota.model.limits import COORDINATE, LARGEST_M, LENGTH, LONGEST_S, MOMENT
from rota.model.refusals import require


@dataclass(frozen=True, kw_only=True)
class MovingObstacle:
    """A disc that moves along timed points, straight between them; before the first and after the last it stands."""

    radius_m: float = field_of(above=0, most=LARGEST_M, written=LENGTH)
    times_s: tuple[float, ...] = field_of(least=-LONGEST_S, most=LONGEST_S, written=MOMENT)
    positions_m: tuple[Place, ...] = field_of(least=-LARGEST_M, most=LARGEST_M, written=COORDINATE)

    def __post_init__(self) -> None:
        check_fields(self, "moving obstacle: ")
        ok = all(a < b for a, b in itertools.pairwise(self.times_s))
        require(ok, "moving obstacle: times_s", self.times_s, "must rise")
        ok = len(self.positions_m) == len(self.times_s)
        require(ok, "moving obstacle: positions_m", self.positions_m, "one for each time")

    def at(self, time_s: float) -> Place:
        """Where its centre is."""
        x, y = (float(np.interp(time_s, self.times_s, [at[axis] for at in self.positions_m])) for axis in (0, 1))
        return x, y
