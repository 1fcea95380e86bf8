"""Decisions of all robots on an NVIDIA GPU: what a step reads is copied there, the velocities are copied back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from rota.errors import MissionError
from rota.planners.swarm.state import Decisions, Kinds, Moving, Robots, Rule, Snapshot

NEEDED = "an NVIDIA GPU with its driver and the package numba-cuda are needed, or device: cpu"


class CudaStep:
    """Makes the decisions of one swarm; raises MissionError where there is no GPU, or nothing to compile for it with.

    Robots are moved and sorted by the processor, so that the order of the state does not depend on the device.
    """

    def __init__(self, decide: Callable[..., None], kinds: Kinds, rule: Rule) -> None:
        kernels = _require_kernels()
        most = kernels.MOST_NEIGHBOURS
        if rule.neighbours > most:
            raise MissionError(f"swarm.neighbours: {rule.neighbours} is not allowed on the device cuda; at most {most}")
        self._cuda, self._threads = kernels.cuda, kernels.THREADS
        self._decide_all, self._filter_all = kernels.kernel_of(decide), kernels.filter_all
        self._kinds, self._rule = Kinds(*map(self._cuda.to_device, kinds)), rule
        self._walls: tuple[Any, ...] | None = None

    def decide(self, snapshot: Snapshot, widest_m: float | None, decisions: Decisions) -> None:
        """New velocities of all robots into the decisions, as on the processor; widest_m None: unfiltered."""
        cuda, n, robots, grid = self._cuda, len(decisions.vx), snapshot.robots, snapshot.grid
        if self._walls is None:
            self._walls = tuple(map(cuda.to_device, (grid.wall_start, grid.wall_item, grid.walls)))
        x, y, vx, vy, kind, name = map(cuda.to_device, robots[:-1])
        robots_on_device = Robots(x, y, vx, vy, kind, name, robots.member_kinds)
        wall_start, wall_item, walls = self._walls
        arrays = {k: cuda.to_device(v) for k, v in grid.place_graph._asdict().items() if isinstance(v, np.ndarray)}
        near = grid._replace(
            start=cuda.to_device(grid.start), wall_start=wall_start, wall_item=wall_item, walls=walls,
            place_graph=grid.place_graph._replace(**arrays),
            importance=grid.importance._replace(
                **{name: cuda.to_device(getattr(grid.importance, name)) for name in ("values", "sums", "moments")}
            ),
        )  # fmt: skip
        discs = Moving(*map(cuda.to_device, snapshot.moving))
        new = Decisions(*(cuda.device_array(n, np.float64) for _ in range(3)))
        shape = (-(-n // self._threads), self._threads)
        copied = Snapshot(snapshot.step, robots_on_device, self._kinds, near, discs, self._rule)
        self._decide_all[shape](copied, new)
        if widest_m is not None:
            exact = cuda.to_device(np.empty(0))
            self._filter_all[shape](copied, widest_m, exact, new)
        new.vx.copy_to_host(decisions.vx)  # type: ignore[attr-defined]
        new.vy.copy_to_host(decisions.vy)  # type: ignore[attr-defined]


def _require_kernels() -> Any:
    """The module of the kernels for the GPU; raises MissionError where there is no GPU."""
    try:
        from rota.planners.swarm import cuda_kernels
    except ImportError as error:
        raise MissionError(f"swarm.device: cuda is not possible here: {error}; {NEEDED}") from None
    kernels: Any = cuda_kernels
    if not kernels.cuda.is_available():
        raise MissionError(f"swarm.device: cuda is not possible here: no NVIDIA GPU is found; {NEEDED}")
    return kernels
