"""The annealing's kernels compiled before there is anything to anneal, so that two processes can share the work."""

from __future__ import annotations

from typing import Any

import numpy as np

from rota.geometry.kernels import EdgeGrid
from rota.planners.patrol.annealing import kernels, move_kernels, state_kernels
from rota.planners.patrol.annealing.state import Tours
from rota.planners.patrol.ground.sample_kernels import Samples

typeof = kernels.anneal.typeof_pyval
INT, FLOAT = typeof(0), typeof(0.0)
# arrays of two dimensions
WIDE = {
    "walls", "frames", "frame_ints", "petals", "seen", "times_seen", "scratch", "new_legs", "edges", "corners",
    "window",
}  # fmt: skip
WHOLE = {
    "period", "wall_start", "wall_item", "next_walled", "frame_ints", "bin_start", "bins",
    "after", "before", "tour", "slot", "in_use", "place", "free_vertices", "bucket", "bucket_after", "bucket_before",
    "grid_n", "anchor", "n", "square", "costly", "period_class", "hub", "petals", "meets", "more", "seen_n",
    "free_slots", "unseen_item", "unseen_place", "unseen_in", "ints", "tried_new", "tried_old", "start", "items",
    "clear",
}  # fmt: skip
SHORT = {"column_start", "seen", "bucket_of_sample"}  # 32 bits
BITS = {"times_seen", "rng"}  # 64 bits without a sign
SINGLE = {"depth2"}  # of three dimensions, and 32 bits a number


def moves() -> None:
    """Compile the whole annealing, but for what is in the cache already."""
    space, samples, tours = types_of_states()
    state_kernels.over_budget_costs.compile_entry(typeof(np.zeros(0, np.int64)), tours)
    kernels.see_more.compile_entry(INT, FLOAT, space, samples, tours)
    kernels.anneal.compile_entry(
        INT, INT, typeof(kernels.Schedule(0, 0.0, 0.0, 0.0)), FLOAT, FLOAT, space, samples, tours
    )


def longest_moves() -> None:
    """Compile the two longest moves alone; ``moves`` in another process finds them in the cache."""
    space, samples, tours = types_of_states()
    move_kernels.try_two_opt.compile((INT, INT, FLOAT, space, samples, tours))
    move_kernels.try_or_opt.compile((INT, INT, INT, FLOAT, FLOAT, space, samples, tours))


def types_of_states() -> tuple[Any, Any, Any]:
    """The types of a standing space, of samples and of tours."""
    grid = EdgeGrid(0.0, 0.0, 1.0, 1, 1, *(_array(name) for name in EdgeGrid._fields[5:]))
    return (
        typeof(grid),
        typeof(Samples(*(_array(name) for name in Samples._fields))),
        typeof(Tours(*(_array(name) for name in Tours._fields))),
    )


def _array(name: str) -> Any:
    if name in SINGLE:
        return np.zeros((0, 0, 0), dtype=np.float32)
    kind = np.int32 if name in SHORT else np.int64 if name in WHOLE else np.uint64 if name in BITS else np.float64
    return np.zeros((0, 0) if name in WIDE else 0, dtype=kind)
