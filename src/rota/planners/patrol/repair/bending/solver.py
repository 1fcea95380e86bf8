"""A linear program that takes in limits while it is solved, each solution beginning from the one before."""

from __future__ import annotations

import highspy
import numpy as np
from scipy.sparse import csr_array, eye_array, hstack

from rota.model.arrays import Floats

# dual simplex: whatever limits are added, it can go on from the solution before them; no presolve,
# which would take longer than it saves here; one thread, since several programs are solved side by side
OPTIONS: dict[str, bool | int | str] = {
    "output_flag": False,
    "presolve": "off",
    "solver": "simplex",
    "simplex_strategy": 1,
    "parallel": "off",
}


class GrowingProgram:
    """The least ``price`` times x, where x (n,) is from 0 to ``upper`` and ``rows`` times x is at most ``most``."""

    def __init__(self, price: Floats, upper: Floats, rows: csr_array, most: Floats) -> None:
        self._solver = highspy.Highs()  # type: ignore[no-untyped-call]
        for name, value in OPTIONS.items():
            self._solver.setOptionValue(name, value)
        self._columns = 0
        self._add_columns(price, upper)
        self._add_rows(rows, most)

    def add_soft_rows(self, rows: csr_array, most: Floats, *, price: float) -> None:
        """Take in limits on the first variables, rows (r, n) times them at most ``most`` (r,), or beyond for a price.

        price: of every unit beyond; by how much it is becomes a variable of each row's own.
        """
        r, n = rows.shape
        if r == 0:
            return
        others = csr_array((r, self._columns - n))
        self._add_columns(np.full(r, price), np.full(r, np.inf))
        self._add_rows(csr_array(hstack([rows, others, -eye_array(r)])), most)

    def solve(self) -> tuple[Floats, float] | None:
        """The variables (n,), those of soft rows last, and what they cost; None: there is no answer."""
        self._solver.run()
        if self._solver.getModelStatus() != highspy.HighsModelStatus.kOptimal:
            return None
        values = np.array(self._solver.getSolution().col_value)
        return values, float(self._solver.getInfo().objective_function_value)

    def _add_columns(self, price: Floats, upper: Floats) -> None:
        count = len(price)
        none = np.zeros(0, dtype=np.int32)
        self._solver.addCols(count, price, np.zeros(count), upper, 0, none, none, np.zeros(0))
        self._columns += count

    def _add_rows(self, rows: csr_array, most: Floats) -> None:
        count = rows.shape[0]
        period_groupings, columns = rows.indptr[:-1].astype(np.int32), rows.indices.astype(np.int32)
        self._solver.addRows(count, np.full(count, -np.inf), most, rows.nnz, period_groupings, columns, rows.data)
