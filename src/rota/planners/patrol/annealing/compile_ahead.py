"""The annealing's kernels compiled before there is anything to anneal, so that two processes can share the work."""

from __future__ import annotations

from typing import Any, get_args, get_type_hints

import numpy as np

from rota.geometry.kernels import EdgeGrid
from rota.planners.patrol.annealing import kernels, move_kernels, state_kernels
from rota.planners.patrol.annealing.state import Tours
from rota.planners.patrol.ground.sample_kernels import Samples

typeof = kernels.anneal.typeof_pyval
Int, Float = typeof(0), typeof(0.0)
TWO_DIMENSIONS = {
    "walls",
    "frames",
    "frame_ints",
    "petals",
    "seen",
    "times_seen",
    "scratch",
    "new_legs",
    "corners",
    "window",
}


def moves() -> None:
    """Compile the whole annealing, but for what is in the cache already."""
    space, samples, tours = types_of_states()
    state_kernels.over_budget_costs.compile_entry(typeof(np.zeros(0, np.int64)), tours)
    kernels.see_more.compile_entry(Int, Float, space, samples, tours)
    kernels.anneal.compile_entry(
        Int, Int, typeof(kernels.Schedule(0, 0.0, 0.0, 0.0)), Float, Float, space, samples, tours
    )


def longest_moves() -> None:
    """Compile the two longest moves alone; ``moves`` in another process finds them in the cache."""
    space, samples, tours = types_of_states()
    move_kernels.try_two_opt.compile((Int, Int, Float, space, samples, tours))
    move_kernels.try_or_opt.compile((Int, Int, Int, Float, Float, space, samples, tours))


def types_of_states() -> tuple[Any, Any, Any]:
    """The types of a standing space, of samples and of tours."""
    ints = np.zeros(0, dtype=np.int64)
    grid = EdgeGrid(0.0, 0.0, 1.0, 1, 1, start=ints, items=ints, edges=np.zeros((0, 0)), clear=ints)
    return typeof(grid), typeof(Samples(**_empty_arrays(Samples))), typeof(Tours(**_empty_arrays(Tours)))


def _empty_arrays(row: type) -> dict[str, Any]:
    """An array of the declared kind of number for each field."""
    arrays = {}
    for name, declared in get_type_hints(row).items():
        kind = get_args(get_args(declared)[1])[0]
        dimensions = 3 if name == "depth2" else 2 if name in TWO_DIMENSIONS else 1
        arrays[name] = np.zeros((0,) * dimensions, dtype=kind)
    return arrays
