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
from rota.planners.swarm.kernels import Near
from rota.planners.swarm.velocity_set_kernels import MOST_CORNERS, Outline

MOST_NEIGHBOURS = 32  # room of a thread
THREADS = 128  # of a block


def kernel_of(decide: Callable[..., None]) -> Any:
    """A kernel in which thread i decides for robot i as ``decide`` does."""

    @cuda.jit
    def decide_all(
        step: int, robots: Any, kinds: Any, grid: Any, moving: Any, rule: Any, new_vx: Any, new_vy: Any, nearest2: Any
    ) -> None:
        i = cuda.grid(1)
        if i < new_vx.shape[0]:
            near = Near(cuda.local.array(MOST_NEIGHBOURS, np.int64), cuda.local.array(MOST_NEIGHBOURS, np.float64))
            outline = Outline(cuda.local.array(MOST_CORNERS, np.float64), cuda.local.array(MOST_CORNERS, np.float64))
            spare = Outline(cuda.local.array(MOST_CORNERS, np.float64), cuda.local.array(MOST_CORNERS, np.float64))
            decide(
                i, i + 1, step, robots, kinds, grid, moving, rule, new_vx, new_vy, nearest2, near, outline, spare
            )  # fmt: skip

    return decide_all


@cuda.jit
def filter_all(
    robots: Any, kinds: Any, grid: Any, moving: Any, time_step_s: float, widest_m: float, exact: Any,
    new_vx: Any, new_vy: Any, nearest2: Any,
) -> None:  # fmt: skip
    """Thread i puts robot i's velocity through the last filter."""
    i = cuda.grid(1)
    if i < new_vx.shape[0]:
        outline = Outline(cuda.local.array(MOST_CORNERS, np.float64), cuda.local.array(MOST_CORNERS, np.float64))
        spare = Outline(cuda.local.array(MOST_CORNERS, np.float64), cuda.local.array(MOST_CORNERS, np.float64))
        filter_velocities(
            i, i + 1, robots, kinds, grid, moving, time_step_s, widest_m, exact, new_vx, new_vy, nearest2, outline,
            spare,
        )  # fmt: skip
