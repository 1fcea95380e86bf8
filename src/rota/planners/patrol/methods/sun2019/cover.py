"""Set cover in place of the CCPSO2: as few of given places as see all cells, greedily or by integer programming."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csr_matrix

from rota.model.arrays import Flags, Ints
from rota.planners.patrol.ground.viewpoints import choose_viewpoints


def greedy_cover(start: Ints, items: Ints, cells: int) -> Ints:
    """Places (k,), each chosen for the most cells that no place before it sees; of equal places the first.

    start (c + 1,), items: the cells that each place sees, of ``cells`` cells. Cells that no place sees stay unseen.
    """
    chosen, _ = choose_viewpoints(start, items, np.ones(cells, dtype=bool), np.ones(cells))
    return chosen


def exact_cover(start: Ints, items: Ints, cells: int, *, node_limit: int = 1) -> tuple[Ints, int]:
    """As few places (k,) as see all cells that any place sees, and a lower bound for any choice of these places.

    start (c + 1,), items: the cells that each place sees, of ``cells`` cells. Integer programming (HiGHS) decides on
    what dominance leaves. node_limit nodes of its tree end it, never the clock; where it has nothing better by then,
    the greedy cover stays. The bound holds for these places, not for sensors anywhere in the plane. Without cells: no
    places, 0.
    """
    greedy = greedy_cover(start, items, cells)
    sees = csr_matrix((np.ones(len(items)), items, start), shape=(len(start) - 1, cells))
    places, wanted = leave_out_dominated(sees)
    if not len(wanted):
        return greedy[:0], 0
    rows = sees[places][:, wanted].T.tocsr()
    count = len(places)
    solution = milp(
        np.ones(count), constraints=LinearConstraint(rows, 1, np.inf), integrality=np.ones(count), bounds=Bounds(0, 1),
        options={"node_limit": node_limit},
    )  # fmt: skip
    proved = solution.mip_dual_bound
    bound = max(1, math.ceil(proved - 1e-6)) if proved is not None and math.isfinite(proved) else 1
    if solution.x is None or round(solution.fun) >= len(greedy):
        return greedy, min(bound, len(greedy))
    chosen = places[np.flatnonzero(solution.x > 0.5)]
    return chosen, min(bound, len(chosen))


def leave_out_dominated(sees: csr_matrix) -> tuple[Ints, Ints]:
    """Places (rows) and cells (columns) that decide: a least cover of these is a least cover of all.

    A place is left out when another one sees all that it sees. A cell is left out when another cell is seen only from
    places that see it, too. Of equal ones the first stays. A cell that nothing sees asks for nothing.
    """
    places = np.arange(sees.shape[0])
    cells = np.flatnonzero(sees.getnnz(axis=0) > 0)
    for _ in range(10):  # after two or three there is hardly anything left to drop
        before = len(places) + len(cells)
        places = places[~_within_another(sees[places][:, cells])]
        cells = cells[~_holds_another(sees[places][:, cells].T.tocsr())]
        if len(places) + len(cells) == before:
            break
    return places, cells


def _within_another(rows: csr_matrix) -> Flags:
    """Rows whose set lies in another row's: (r,) flags; of equal rows all but the first, and all empty rows."""
    inner, outer, size = _subsets(rows)
    drop: Flags = size == 0
    drop[inner[(size[inner] < size[outer]) | (inner > outer)]] = True
    return drop


def _holds_another(rows: csr_matrix) -> Flags:
    """Rows whose set holds another row's: (r,) flags; of equal rows all but the first."""
    inner, outer, size = _subsets(rows)
    drop = np.zeros(len(size), dtype=bool)
    drop[outer[(size[inner] < size[outer]) | (inner < outer)]] = True
    return drop


def _subsets(rows: csr_matrix) -> tuple[Ints, Ints, Ints]:
    """Pairs (p,) of different rows, the first one's set within the second one's, and the size of every row, (r,)."""
    size = np.asarray(rows.getnnz(axis=1), dtype=np.int64)
    shared = (rows @ rows.T).tocoo()
    pairs = (shared.row != shared.col) & (np.rint(shared.data) == size[shared.row])
    return shared.row[pairs].astype(np.int64), shared.col[pairs].astype(np.int64), size
