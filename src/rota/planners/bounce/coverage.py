"""Algorithm 1 of Alam & Bobadilla 2020: a joint trajectory of bouncing robots that covers the ground."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from rota.planners.bounce.arrays import Flags, Ints
from rota.planners.bounce.cells import BLOCKED, Cells
from rota.planners.bounce.coverage_kernels import Log, Search, cover_as_printed, cover_by_rate
from rota.planners.bounce.kernels import Team
from rota.planners.bounce.planner_settings import BounceMethod


@dataclass(frozen=True, kw_only=True, eq=False)
class Coverage:
    """A joint trajectory that covers: states (steps + 1, m) from the start on.

    contacts: (steps,) pairs of robots in contact in each step. jumps: (steps,), the robot that turned by the clock in
    a step, -1: none. covered: (n,) cells that were entered, the starts included. reachable: (n,), cells to which some
    robot has a way, whichever way it turns.
    """

    states: Ints
    contacts: Ints
    jumps: Ints
    covered: Flags
    reachable: Flags

    @property
    def steps(self) -> int:
        """How many steps it takes."""
        return len(self.states) - 1

    @property
    def share(self) -> float:
        """The share of the free cells that is covered."""
        return float(self.covered.mean())

    @property
    def complete(self) -> bool:
        """Whether all free cells are covered."""
        return bool(self.covered.all())

    @property
    def walled_off(self) -> Flags:
        """(n,) cells that no robot can come to from where it starts."""
        return ~self.reachable

    @property
    def missed(self) -> Flags:
        """(n,) which cells were not entered although a way leads there."""
        return self.reachable & ~self.covered


def cover(
    cells: Cells, team: Team, start: Sequence[int], *, method: BounceMethod = "improved", most_steps: int = 100_000
) -> Coverage:
    """A joint trajectory from the robots' states ``start`` that covers all cells that can be reached, if one is found.

    method "as_printed" is Algorithm 1: it ends without full coverage when it has been in every joint state that it can
    jump to. "improved": robots turn by the clock whenever that enters more new cells for a step, by as many heading
    steps as it takes, one a step, and on the way to the nearest new cell. Both are deterministic and end after
    ``most_steps``. Raises ValueError for two robots in one cell.
    """
    m, k = len(start), cells.headings
    at = np.asarray(start, np.int32) // k
    if len(set(at.tolist())) < m:
        raise ValueError(f"states {list(start)}: two robots stand in one cell")
    reachable = reachable_cells(cells, at)
    path = np.empty((most_steps + 1, m), np.int32)
    path[0] = start
    log = Log(
        path=path,
        contact=np.zeros(most_steps + 1, np.int32),
        jump=np.zeros(most_steps + 1, np.int32),
        table=np.zeros(1 << (2 * most_steps + 2).bit_length(), np.int64),
        covered=np.zeros(cells.count, np.uint8),
        added=np.empty(cells.count, np.int32),
    )
    wanted, stays, after = int(reachable.sum()), np.empty(m, np.int8), np.empty(m, np.int32)
    if method == "as_printed":
        count, _ = cover_as_printed(team, log, k, wanted, after, stays)
    else:
        horizon = 4 * int(cells.column.max() + cells.row.max() + 2)
        begin, states = np.empty(m, np.int32), np.empty(m, np.int32)
        distance, action, before, queue = (np.empty(cells.states, np.int32) for _ in range(4))
        stamps, marks = np.zeros(cells.count, np.int64), np.zeros(cells.states, np.int64)
        search = Search(begin, states, after, stays, stamps, marks, distance, action, before, queue)
        count, _ = cover_by_rate(team, log, k, wanted, horizon, search)
    return Coverage(
        states=path[:count].copy(),
        contacts=log.contact[1:count].copy(),
        jumps=log.jump[1:count] - 1,
        covered=log.covered.astype(np.bool_),
        reachable=reachable,
    )


def reachable_cells(cells: Cells, starts: Ints) -> Flags:
    """(n,) which cells moves lead to from one of the starting cells (m,); moves lead there and back."""
    origin, heading = np.nonzero(cells.target != BLOCKED)
    ends = cells.target[origin, heading]
    links = coo_matrix((np.ones(len(origin), np.int8), (origin, ends)), shape=(cells.count, cells.count))
    _, part = connected_components(links, directed=False)
    return np.isin(part, part[starts])
