# mypy: disable-error-code="attr-defined,no-untyped-call,untyped-decorator,misc"
"""The decisions of a step on an NVIDIA GPU, a robot for each thread: compiled from the functions that a processor runs.

Loading this loads numba's CUDA part; only ``cuda_step`` does.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import cuda

from rota.planners.swarm.filter_kernels import filter_velocities
from rota.planners.swarm.state import Near, Outline, Room
from rota.planners.swarm.velocity_set_kernels import MOST_CORNERS

MOST_NEIGHBOURS = 32  # room of a thread
THREADS = 128  # of a block


def kernel_of(decide: Callable[..., None]) -> Any:
    """A kernel in which thread i decides for robot i as ``decide`` does."""

    @cuda.jit
    def decide_all(snapshot: Any, decisions: Any) -> None:
        i = cuda.grid(1)
        if i < decisions.vx.shape[0]:
            near = Near(cuda.local.array(MOST_NEIGHBOURS, np.int64), cuda.local.array(MOST_NEIGHBOURS, np.float64))
            outline = Outline(cuda.local.array(MOST_CORNERS, np.float64), cuda.local.array(MOST_CORNERS, np.float64))
            spare = Outline(cuda.local.array(MOST_CORNERS, np.float64), cuda.local.array(MOST_CORNERS, np.float64))
            decide(i, i + 1, snapshot, decisions, Room(near, outline, spare))

    return decide_all


@cuda.jit
def filter_all(snapshot: Any, widest_m: float, exact: Any, decisions: Any) -> None:
    """Thread i puts robot i's velocity through the last filter."""
    i = cuda.grid(1)
    if i < decisions.vx.shape[0]:
        near = Near(cuda.local.array(1, np.int64), cuda.local.array(1, np.float64))
        outline = Outline(cuda.local.array(MOST_CORNERS, np.float64), cuda.local.array(MOST_CORNERS, np.float64))
        spare = Outline(cuda.local.array(MOST_CORNERS, np.float64), cuda.local.array(MOST_CORNERS, np.float64))
        filter_velocities(i, i + 1, snapshot, widest_m, exact, decisions, Room(near, outline, spare))
