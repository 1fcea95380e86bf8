"""Keeping bodies apart: loops of periods in simple ratios, with phases that never meet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rota.planners.patrol.annealing.search import Tour
from rota.planners.patrol.timetable import trajectories_of

Floats = NDArray[np.float64]


def timed_rounds(tours: Sequence[Tour], body_radius_m: float) -> list[tuple[Floats, Floats]]:
    """Times and places of one round of every robot, tour by tour."""
    return trajectories_of(tours, [None] * len(tours), [0.0] * len(tours))
