"""What corners cost in a search, in a form that compiled loops take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class CornerCosts:
    """What corners add to a way, as metres at its pace.

    turn_m: for each radian. arc_m: the turn radius; what tight corners add on arcs is ``at_once.spool_m``. table:
    (a, l) of a robot with mass, by the sharpness of the corner and the length of each leg beside it, see
    ``rounded_kernels.corner_table``; (0, 0) without one. longest_m: the leg of its last column; longer ones cost as
    much. straight: what a metre of a leg adds that ends at no corner.
    """

    turn_m: float
    arc_m: float
    table: Floats
    longest_m: float
    straight: float = 0.0

    @property
    def are_free(self) -> bool:
        """Whether corners cost nothing."""
        return self.turn_m == 0 and not self.table.size


def no_table() -> Floats:
    """The table of a robot whose corners need none."""
    return np.zeros((0, 0))
