"""The step that the program finds from the limits that matter, against one with all limits at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import linprog
from scipy.sparse import csr_array

from rota.model.mission import DiscSensor, Fleet
from rota.planners.patrol.loop_settings import BendingSettings
from rota.planners.patrol.repair.bending.layout import lay_out_tours
from rota.planners.patrol.repair.bending.program import (
    BUDGET_PENALTY,
    Rows,
    best_step,
    length_rows,
    rows_along,
)
from rota.planners.patrol.tours.tour import Tour

Floats = NDArray[np.float64]
TRUST_M = 0.3
BENDING = BendingSettings()


@pytest.mark.parametrize("seed", range(6))
def test_as_good_as_with_every_limit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    corners, samples = 12, 400
    angles = np.sort(rng.random(corners)) * 2 * np.pi
    ring_m = 20 * np.column_stack([np.cos(angles), np.sin(angles)]) + rng.normal(0, 1, (corners, 2))
    robot = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=3.0)).equal_robot("one")
    ring = Tour(vertices_m=ring_m, period_class=0, period_s=float(rng.uniform(105, 130)), robots=1, robot=robot)
    layout, places_m = lay_out_tours([ring], 1e3)
    leg = rng.integers(0, corners, samples)
    bearing = 2 * np.pi * rng.random(samples)
    towards = np.column_stack([np.cos(bearing), np.sin(bearing)])
    along = rows_along(towards, layout.start[leg], layout.end[leg], rng.random(samples), corners)
    ranges = Rows(along, rng.uniform(-0.1, 2.5 * TRUST_M, samples))
    border = Rows(rows_along(towards[:3], leg[:3], leg[:3], np.zeros(3), corners), rng.uniform(0, 0.2, 3))
    fixed = np.arange(corners) == 4

    step = best_step(
        layout,
        places_m,
        BENDING,
        ranges,
        border,
        fixed=fixed,
        trust_m=TRUST_M,
        reserve=0.01,
    )

    assert step is not None
    (budgets, bends), lengths_m = length_rows(layout, places_m), layout.lengths_m(places_m)
    assert not bends.nnz
    left_m = layout.budget_m * 0.99 - lengths_m
    moves_m = step.moves_m.ravel()
    assert (np.abs(moves_m) <= np.where(np.repeat(fixed, 2), 0.0, TRUST_M) + 1e-9).all()
    assert (border.along @ moves_m <= border.most_m + 1e-6).all()
    assert step.cost == pytest.approx(cost(moves_m, budgets, left_m, ranges), abs=1e-5)
    least = least_cost(budgets, left_m, ranges, border, fixed=fixed)
    assert step.cost == pytest.approx(least, abs=1e-5)


def cost(moves_m: Floats, budgets: csr_array, left_m: Floats, ranges: Rows) -> float:
    over_m = np.maximum(0.0, budgets @ moves_m - left_m).sum()
    range_deficit_m = np.maximum(0.0, ranges.along @ moves_m - ranges.most_m).sum()
    return float(
        BUDGET_PENALTY * over_m + BENDING.range_weight * range_deficit_m + BENDING.move_weight * np.abs(moves_m).sum()
    )


def least_cost(budgets: csr_array, left_m: Floats, ranges: Rows, border: Rows, *, fixed: NDArray[np.bool_]) -> float:
    """The least that any moves cost: moves are free variables, with their sizes beside them, and all limits dense."""
    n, r, b = len(fixed) * 2, len(ranges.most_m), len(left_m)
    size, near = np.eye(n), border.along.toarray()
    limits = np.block([
        [budgets.toarray(), np.zeros((b, n)), -np.eye(b), np.zeros((b, r))],
        [ranges.along.toarray(), np.zeros((r, n + b)), -np.eye(r)],
        [near, np.zeros((len(near), n + b + r))],
        [size, -size, np.zeros((n, b + r))],
        [-size, -size, np.zeros((n, b + r))],
    ])  # fmt: skip
    most_m = np.repeat(np.where(fixed, 0.0, TRUST_M), 2)
    prices = [np.zeros(n), np.full(n, BENDING.move_weight)]
    found = linprog(
        np.concatenate([*prices, np.full(b, BUDGET_PENALTY), np.full(r, BENDING.range_weight)]),
        A_ub=limits,
        b_ub=np.concatenate([left_m, ranges.most_m, border.most_m, np.zeros(2 * n)]),
        bounds=[*zip(-most_m, most_m, strict=True), *[(0, None)] * (n + b + r)],
        method="highs-ipm",
    )
    return float(found.fun)


def test_a_nest_grows_as_the_vertices_move_that_its_loops_share() -> None:
    robot = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=3.0)).equal_robot("one")
    hub = Tour(
        vertices_m=np.array([[30.0, 30.0], [20.0, 31.0], [19.0, 20.0], [32.0, 20.0]]),
        period_class=0, period_s=400.0, robots=1, robot=replace(robot, turn_rate_rad_s=0.5), nest=2,
    )  # fmt: skip
    petals_m = (
        np.array([[30.0, 30.0], [50.0, 32.0], [48.0, 40.0]]),
        np.array([[30.0, 30.0], [28.0, 55.0], [24.0, 50.0]]),
    )
    nest = [hub, *(replace(hub, vertices_m=petal_m, robots=0) for petal_m in petals_m)]
    layout, places_m = lay_out_tours(nest, 1e3)
    growth, bends = length_rows(layout, places_m)
    assert not bends.toarray().any()
    before_m, step_m = layout.lengths_m(places_m), 1e-6
    for which in np.ndindex(places_m.shape):
        moved_m = places_m.copy()
        moved_m[which] += step_m
        grown = (layout.lengths_m(moved_m) - before_m) / step_m
        assert growth.toarray()[:, 2 * which[0] + which[1]] == pytest.approx(grown, abs=1e-4)
