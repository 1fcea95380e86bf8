"""The bounce map of a team (simple cell-to-cell mapping), and its cycles and basins in time linear in its states."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rota.errors import MissionError
from rota.planners.bounce.arrays import Floats, Ints, Longs
from rota.planners.bounce.cells import BLOCKED, Cells
from rota.planners.bounce.kernels import Team
from rota.planners.bounce.map_kernels import (
    MOST_STATES,
    NOWHERE as NOWHERE,
    decompose,
    pair_successors,
    strip_labels,
    successors,
)
from rota.planning.stopping import require_going_on

Words = NDArray[np.uint32]

MEMORY_SHARE = 0.8  # of the machine's memory, for a joint map
STATES_TOGETHER = 1 << 22  # of a joint map: between two of so many it is asked whether to stop


@dataclass(frozen=True, kw_only=True, eq=False)
class Decomposition:
    """Where every state of a map ends. cycle: (n,) int32, the number of its cycle; -1: robots in one place.

    Of c cycles, (c,) int64: ``first``, a state of each; ``length``; ``basin``, the number of states that come to it,
    its own included.
    """

    cycle: Ints
    first: Longs
    length: Longs
    basin: Longs


def make_team(cells: Cells, bounces: Sequence[int], *, apart_m: Floats | float = 0.0) -> Team:
    """Robots on cells. bounces: heading steps by which each robot turns at a bump.

    apart_m: (m, m), or one number for all, the distance in metres of two centres at which bodies touch. 0: contact is
    as published, on the grid alone. Raises ValueError for turns by a full round or by none.
    """
    n, k, m = cells.count, cells.headings, len(bounces)
    if not all(0 < bounce < k for bounce in bounces):
        raise ValueError(f"bounces {list(bounces)}: each must be 1 to {k - 1} heading steps")
    cell, heading = np.divmod(np.arange(n * k), k)
    target = cells.target.ravel()
    ends = np.where(target == BLOCKED, cell, target)
    apart = np.broadcast_to(np.asarray(apart_m, float), (m, m)) / cells.cell_m
    turned = [cell * k + (heading + bounce) % k for bounce in bounces]
    return Team(
        x=cells.column[cell],
        y=cells.row[cell],
        to_x=cells.column[ends],
        to_y=cells.row[ends],
        moved=np.where(target == BLOCKED, -1, target * k + heading).astype(np.int32),
        bumped=np.array(turned, np.int32).reshape(m, n * k),
        apart2=np.ascontiguousarray(apart**2),
    )


def single_map(team: Team, robot: int = 0) -> Ints:
    """(s,) int32 successors of one robot's states, where only walls stop it."""
    return np.where(team.moved < 0, team.bumped[robot], team.moved).astype(np.int32)


def joint_states(states: int, robots: int) -> int:
    """The number of packed states of a team, with the states in which two robots are in one place."""
    return int(states**robots)


def require_memory(states: int, robots: int, *, copies: int = 1) -> None:
    """Raise MissionError when the joint map of these robots does not fit in memory, before any of it is made.

    copies: how many times the map's four bytes for a state are needed.
    """
    count = joint_states(states, robots)
    bytes_needed = 4 * copies * count
    available = MEMORY_SHARE * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if count > MOST_STATES or bytes_needed > available:
        power = "" if robots == 1 else f" ** {robots}"
        raise MissionError(
            f"the joint map of {robots} robots has {states}{power} = {count:.3g} states and needs"
            f" {bytes_needed / 1e9:.3g} GB; at most {min(MOST_STATES, available / 4 / copies):.3g} states are possible:"
            " fewer robots or larger cells are needed, or method: improved, which needs no joint map"
        )


def joint_map(team: Team, *, contact_free: bool = False, should_stop: Callable[[], bool] = lambda: False) -> Words:
    """Successors of all packed states of the team, (n,) uint32; NOWHERE for states with robots in one place.

    contact_free: a contact leads NOWHERE. Raises MissionError for maps that do not fit in memory, NoPlanFound once
    ``should_stop``.
    """
    m, s = len(team.bumped), len(team.x)
    require_memory(s, m)
    successor = np.empty(joint_states(s, m), np.uint32)
    if m == 2:
        pair_successors(team, successor, contact_free)
    else:
        states, after, stays = np.zeros(m, np.int32), np.empty(m, np.int32), np.empty(m, np.int8)
        for some in in_turn(len(successor), should_stop):
            successors(team, states, after, stays, successor[some], contact_free)
    return successor


def in_turn(count: int, should_stop: Callable[[], bool]) -> Iterator[slice]:
    """So many states in groups that are soon gone through; NoPlanFound once ``should_stop``."""
    for first in range(0, count, STATES_TOGETHER):
        require_going_on(should_stop, "the joint map was gone through")
        yield slice(first, min(first + STATES_TOGETHER, count))


def cycles_and_basins(successor: Any) -> Decomposition:
    """Cycles and basins of a map, (n,) of uint32 or int32, which is overwritten when it is uint32.

    Linear in n: every state is walked over once and labelled once. Memory: the map itself, and the longest walk.
    """
    labels = np.asarray(successor, dtype=np.uint32)
    path, cycles, progress = np.empty(1 << 16, np.uint32), np.empty((1 << 10, 3), np.int64), np.zeros(3, np.int64)
    while (missing := decompose(labels, path, progress, cycles)) != 0:
        if missing == 1:
            path = np.concatenate([path, np.empty_like(path)])
        else:
            cycles = np.concatenate([cycles, np.empty_like(cycles)])
    strip_labels(labels)
    first, length, basin = cycles[: progress[2]].T.copy()
    return Decomposition(cycle=labels.view(np.int32), first=first, length=length, basin=basin)
