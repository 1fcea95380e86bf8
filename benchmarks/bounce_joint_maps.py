"""Joint maps of two bouncing robots, their cycles and basins, against scipy."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from benchmarks.bounce_maps import LESS_EIGHT, cells_on
from benchmarks.row import Options, Row
from rota.planners.bounce.bounce_map import (
    NOWHERE,
    cycles_and_basins,
    joint_map,
    make_team,
)

REPEATS = 9
LEAST_RATIO = 5.0


def bounce_map(_: Options) -> Iterator[Row]:
    """Processor times, in one run with scipy."""
    yield two_robots()


def two_robots() -> Row:
    """Successor map, cycles and basins of two robots that are told apart; scipy is given the successors."""
    team = make_team(cells_on(LESS_EIGHT), [3, 3])
    successor = joint_map(team)
    cycles_and_basins(successor.copy())  # compiles
    ours, theirs = [], []
    for _ in range(REPEATS):
        ours.append(cpu_s(lambda: cycles_and_basins(joint_map(team))))
        theirs.append(cpu_s(lambda: by_scipy(successor)))
    mine, their = statistics.median(ours), statistics.median(theirs)
    measured = f"{their / mine:.1f} x ({mine * 1e3:.1f} ms, scipy {their * 1e3:.0f} ms without the successor map)"
    name = f"bounce, 2 robots, {len(successor):,} joint states: successor map, cycles and basins, against scipy"
    return Row(name, f"> {LEAST_RATIO:.0f} x", measured, their / mine > LEAST_RATIO)


def by_scipy(successor: NDArray[np.uint32]) -> tuple[int, int]:
    """Basins are the weak components of the map's graph, cycles its strong ones of more than one state, or a loop."""
    real = np.flatnonzero(successor != NOWHERE)
    shape = (len(successor), len(successor))
    graph = csr_matrix((np.ones(len(real), np.int8), (real, successor[real].astype(np.int32))), shape=shape)
    basins, _ = connected_components(graph, connection="weak")
    strong, _ = connected_components(graph, connection="strong")
    return int(basins), int(strong)


def cpu_s(work: Callable[[], object]) -> float:
    """Processor seconds of a call."""
    began_s = time.process_time()
    work()
    return time.process_time() - began_s
