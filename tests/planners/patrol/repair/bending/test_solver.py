"""Programs that grow, against scipy's with everything from the start, and one that can be solved by hand."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.sparse import csr_array

from rota.planners.patrol.repair.bending.program import GrowingProgram


def test_by_hand() -> None:
    # the most of x + 2 y with x + y at most 3, both at most 2; then y at most 1 or 0.5 for every unit beyond
    program = GrowingProgram(np.array([-1.0, -2.0]), np.array([2.0, 2.0]), csr_array([[1.0, 1.0]]), np.array([3.0]))
    values, cost = solved(program)
    assert values.tolist() == [1.0, 2.0]
    assert cost == -5.0
    program.add_soft_rows(csr_array([[0.0, 1.0]]), np.array([1.0]), price=0.5)
    values, cost = solved(program)  # a unit of y is worth 1 more than the x that it displaces, and costs 0.5
    assert values.tolist() == [1.0, 2.0, 1.0]
    assert cost == -4.5
    program.add_soft_rows(csr_array([[0.0, 1.0]]), np.array([1.0]), price=2.0)
    values, cost = solved(program)
    assert values.tolist() == [2.0, 1.0, 0.0, 0.0]
    assert cost == -4.0


def test_no_rows_change_nothing() -> None:
    program = GrowingProgram(np.array([-1.0]), np.array([2.0]), csr_array([[1.0]]), np.array([1.5]))
    program.add_soft_rows(csr_array((0, 1)), np.zeros(0), price=1.0)
    assert solved(program)[0].tolist() == [1.5]


def test_no_answer() -> None:
    program = GrowingProgram(np.array([1.0]), np.array([1.0]), csr_array([[-1.0]]), np.array([-2.0]))
    assert program.solve() is None  # x at least 2, and at most 1


@pytest.mark.parametrize("seed", range(8))
def test_as_cheap_as_with_all_rows_from_the_start(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, hard, soft = 12, 5, 60
    price, upper = rng.normal(size=n), rng.uniform(0.5, 2, n)
    rows, most = rng.normal(size=(hard, n)), rng.uniform(0.5, 2, hard)
    limits, limit = rng.normal(size=(soft, n)), rng.uniform(-0.5, 1, soft)
    program = GrowingProgram(price, upper, csr_array(rows), most)
    for few in np.array_split(np.arange(soft), 4):
        program.add_soft_rows(csr_array(limits[few]), limit[few], price=0.7)
        values, cost = solved(program)
    x = values[:n]
    assert (rows @ x <= most + 1e-9).all()
    assert cost == pytest.approx(price @ x + 0.7 * np.maximum(0, limits @ x - limit).sum())
    whole = linprog(
        np.concatenate([price, np.full(soft, 0.7)]),
        A_ub=np.block([[rows, np.zeros((hard, soft))], [limits, -np.eye(soft)]]),
        b_ub=np.concatenate([most, limit]),
        bounds=[*((0, most_x) for most_x in upper), *[(0, None)] * soft],
    )
    assert cost == pytest.approx(whole.fun)


def solved(program: GrowingProgram) -> tuple[np.ndarray, float]:
    found = program.solve()
    assert found is not None
    return found
