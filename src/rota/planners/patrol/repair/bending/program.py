"""One step of all tours at once: the linear program whose answer moves every vertex a little."""

from __future__ import annotations

from typing import NamedTuple

import highspy
import numpy as np
from scipy.sparse import block_array, coo_array, csr_array, eye_array, hstack, kron

from rota.model.arrays import Flags, Floats, Ints
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.loop_settings import BendingSettings
from rota.planners.patrol.repair.bending.layout import Layout
from rota.planners.patrol.repair.bending.share_kernels import share_out
from rota.planners.patrol.repair.bending.sighting_kernels import Sightings
from rota.planners.patrol.tolerances import HAIR_M

# dual simplex: whatever limits are added, it can go on from the solution before them; no presolve,
# which would take longer than it saves here; one thread, since several programs are solved side by side
OPTIONS: dict[str, bool | int | str] = {
    "output_flag": False,
    "presolve": "off",
    "solver": "simplex",
    "simplex_strategy": 1,
    "parallel": "off",
}
BUDGET_PENALTY = 2.0  # of a metre over a budget


class Rows(NamedTuple):
    """Limits on moves: ``along`` (r, 2n) times the moves of all vertices is at most ``most_m`` (r,)."""

    along: csr_array
    most_m: Floats


class Step(NamedTuple):
    """Moves (n, 2) of all vertices, and what everything costs after them as far as the program can tell."""

    moves_m: Floats
    cost: float


def best_step(
    layout: Layout, places_m: Floats, settings: BendingSettings, ranges: Rows, clearances: Rows, *,
    fixed: Flags, trust_m: float, reserve: float,
) -> Step | None:  # fmt: skip
    """The moves, along either axis at most twice ``trust_m``, after which least is lacking; None: there is no answer.

    ranges: what samples may lose, for a price. clearances: how near vertices may come to the border, at no price.
    fixed (n,): vertices that stay. reserve: share of the budgets that is left alone.
    """
    n, b = len(places_m), len(layout.budget_m)
    moved = moves_of(layout, fixed)
    by_tour, bent_by = length_rows(layout, places_m)
    lengths_m = layout.lengths_m(places_m)
    budgets = csr_array(csr_array(layout.counts) @ by_tour)
    bends = csr_array(csr_array(layout.counts) @ bent_by)
    left_m = layout.budget_m * (1 - reserve) - layout.counts @ lengths_m
    most_m = np.repeat(np.where(fixed, 0.0, trust_m), 2)
    used, nearer, closer = budgets @ moved, csr_array(ranges.along @ moved), clearances.along @ moved
    # a variable is the difference of two numbers that are not negative, so that its size has a price
    longer_m, shorter_m = (used + bends, bends - used) if bends.nnz else (used, -used)
    hard = [[longer_m, shorter_m, -eye_array(b)], *([[closer, -closer, None]] if closer.shape[0] else [])]
    longer = settings.length_weight * (by_tour @ moved).sum(axis=0)
    moving = settings.move_weight + settings.length_weight * bent_by.sum(axis=0)
    program = GrowingProgram(
        np.concatenate([moving + longer, moving - longer, np.full(b, BUDGET_PENALTY)]),
        np.concatenate([most_m, most_m, np.full(b, np.inf)]),
        csr_array(block_array(hard)),
        np.concatenate([left_m, clearances.most_m]),
    )
    near_m = 0.25 * trust_m
    taken = new = ranges.most_m < near_m  # with less to spare they are limits from the start
    while True:
        program.add_soft_rows(
            csr_array(hstack([nearer[new], -nearer[new]])), ranges.most_m[new], price=settings.range_weight
        )
        solution = program.solve()
        if solution is None:
            return None
        values, cost = solution
        variables = values[: 2 * n] - values[2 * n : 4 * n]
        beyond_m = nearer @ variables - ranges.most_m
        if not (beyond_m[~taken] > HAIR_M).any():
            return Step((moved @ variables).reshape(n, 2), cost + settings.length_weight * float(lengths_m.sum()))
        new = ~taken & (beyond_m > -near_m)
        taken = taken | new


def moves_of(layout: Layout, fixed: Flags) -> csr_array:
    """The moves (2n,) of all vertices by the program's variables (2n,).

    A vertex that cuts a leg goes along with the ends of the leg, and its variable is by how much it leaves the straight
    way between them: so that a leg stays straight, and as short as it was, unless there is a reason to bend it.
    """
    n = len(layout.share)
    with_ends = (layout.share > 0) & ~fixed
    middle, share = np.flatnonzero(with_ends), layout.share[with_ends]
    rows = np.concatenate([np.arange(n), middle, middle])
    columns = np.concatenate([np.arange(n), layout.before[middle], layout.after[middle]])
    one_axis = coo_array((np.concatenate([np.ones(n), 1 - share, share]), (rows, columns)), shape=(n, n))
    return csr_array(kron(one_axis, eye_array(2)))


def length_rows(layout: Layout, places_m: Floats) -> tuple[csr_array, csr_array]:
    """By how much each tour (k, 2n) grows for each metre that a vertex moves along an axis, and whichever way it moves.

    Robots that know the slopes of their times have these; others metres of way, which bends do not lengthen at first.
    """
    n = len(places_m)
    shape = len(layout.tours), 2 * n
    if layout.slopes is not None:
        of_legs = [slopes(places_m[layout.start[layout.tour == k]]) for k, slopes in enumerate(layout.slopes)]
        growth, bends = (np.vstack(parts).ravel() for parts in zip(*of_legs, strict=True))
        # a petal and its hub share a vertex, and either grows as that moves
        where = np.repeat(layout.tour, 2), np.column_stack([2 * layout.start, 2 * layout.start + 1]).ravel()
        return coo_array((growth, where), shape=shape).tocsr(), coo_array((bends, where), shape=shape).tocsr()
    along = places_m[layout.end] - places_m[layout.start]
    along /= np.maximum(np.hypot(*along.T), 1e-12)[:, None]
    rows = np.concatenate([layout.tour] * 4)
    columns = np.concatenate([2 * layout.end, 2 * layout.end + 1, 2 * layout.start, 2 * layout.start + 1])
    values = np.concatenate([along[:, 0], along[:, 1], -along[:, 0], -along[:, 1]])
    return coo_array((values, (rows, columns)), shape=shape).tocsr(), csr_array(shape)


def range_rows(
    layout: Layout, places_m: Floats, sightings: Sightings, samples: Samples, *, square: bool, near_m: float
) -> Rows:
    """How much farther away each sample may get that a step could lose or gain: one with less than ``near_m`` to spare.

    Each is left to the leg that sees it best, from where that sees it. Where others are told beside that one, those of
    discs that see it as well but for ``near_m`` share it, see ``share_out``.
    """
    near = np.flatnonzero((sightings.leg[:, 0] >= 0) & (sightings.range_deficit_m[:, 0] > -near_m))
    legs, at, deficit_m = sightings.leg[near], sightings.at[near], sightings.range_deficit_m[near]
    a, b, is_visit = layout.start[legs], layout.end[legs], samples.visit_m[near] > 0
    here_m = (1 - at)[..., None] * places_m[a] + at[..., None] * places_m[b]
    away_m = here_m - np.column_stack([samples.x[near], samples.y[near]])[:, None]
    if square:
        return square_rows(a[:, 0], b[:, 0], at[:, 0], away_m[:, 0], -deficit_m[:, 0], is_visit, len(places_m), near_m)
    towards = away_m / np.maximum(np.hypot(away_m[..., 0], away_m[..., 1]), 1e-12)[..., None]
    if at.shape[1] == 1:
        along = rows_along(towards[:, 0], a[:, 0], b[:, 0], at[:, 0], len(places_m))
        return Rows(along, -deficit_m[:, 0] - HAIR_M)
    weights, rivals = np.zeros(at.shape), deficit_m < deficit_m[:, :1] + near_m
    share_out(np.where(rivals, deficit_m, np.inf), towards, is_visit, weights)
    row, which = np.nonzero(weights)
    share = weights[row, which]
    moved = rows_along(
        share[:, None] * towards[row, which], a[row, which], b[row, which], at[row, which], len(places_m)
    )
    of_sample = csr_array((np.ones(len(row)), (row, np.arange(len(row)))), shape=(len(near), len(row)))
    spare_m = -np.bincount(row, share * deficit_m[row, which], minlength=len(near)).astype(np.float64)
    return Rows(csr_array(of_sample @ moved), spare_m - HAIR_M)


def square_rows(
    a: Ints, b: Ints, t: Floats, away_m: Floats, spare_m: Floats, is_visit: Flags, n: int, near_m: float
) -> Rows:
    """The rows of samples (r,) for squares: both coordinates are limited, each on its own; visits are in a circle."""
    wide = np.tile(~is_visit, 2)
    sides_m = np.abs(away_m)
    round_m = np.concatenate([spare_m, np.full(len(a), np.inf)])
    spare_m = np.concatenate([spare_m + sides_m.max(axis=1) - sides_m[:, axis] for axis in (0, 1)])
    spare_m = np.where(wide, spare_m, round_m)
    along_m = np.vstack([away_m * [1, 0], away_m * [0, 1]])
    away_m = np.where(wide[:, None], along_m, np.tile(away_m, (2, 1)))
    keep = spare_m < near_m
    towards = away_m[keep] / np.maximum(np.hypot(*away_m[keep].T), 1e-12)[:, None]
    along = rows_along(towards, np.tile(a, 2)[keep], np.tile(b, 2)[keep], np.tile(t, 2)[keep], n)
    return Rows(along, spare_m[keep] - HAIR_M)


def rows_along(towards: Floats, a: Ints, b: Ints, t: Floats, n: int) -> csr_array:
    """By how much the places t of the way from vertex a to b (r,) move along unit vectors (r, 2), for n vertices."""
    row = np.tile(np.arange(len(t)), 4)
    columns = np.concatenate([2 * a, 2 * a + 1, 2 * b, 2 * b + 1])
    values = np.concatenate([(1 - t) * towards[:, 0], (1 - t) * towards[:, 1], t * towards[:, 0], t * towards[:, 1]])
    return coo_array((values, (row, columns)), shape=(len(t), 2 * n)).tocsr()


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
