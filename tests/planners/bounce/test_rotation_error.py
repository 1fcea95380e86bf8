"""The Markov chain of an inexact robot against closed forms, brute force and simulation."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad
from shapely import MultiPolygon, box, union_all

from rota.errors import MissionError
from rota.planners.bounce.bounce_map import make_team, single_map
from rota.planners.bounce.cells import BLOCKED, Cells, cells_of
from rota.planners.bounce.rotation_error import (
    ErrorShape,
    MotionChain,
    MotionError,
    anywhere,
    compare_angles,
    cover_time,
    hold_of_cycles,
    motion_chain,
    sample_walks,
    seen_chances,
    spread_chances,
    start_in,
)

Floats = NDArray[np.float64]


def room(*rows: str, headings: int = 8) -> Cells:
    """Cells of 1 m from rows, north first; # is an obstacle."""
    height, width = len(rows), len(rows[0])
    free = [
        box(x, y, x + 1, y + 1) for y, x in itertools.product(range(height), range(width)) if rows[-1 - y][x] == "."
    ]
    ground = union_all(free)
    return cells_of(
        MultiPolygon([ground]) if ground.geom_type == "Polygon" else ground, (0, 0, width, height), cell_m=1.0,
        headings=headings, body_radius_m=0.3,
    )  # fmt: skip


def simulated(chain: MotionChain, start: int, steps: int, walks: int, seed: int) -> Floats:
    """(steps + 1, n) shares of robots that had been in each cell: errors drawn, then rounded up or down at random."""
    rng = np.random.default_rng(seed)
    cells, error, k = chain.cells, chain.error, chain.cells.headings

    def drawn(width: float) -> NDArray[np.int64]:
        exact = rng.uniform(-width, width, walks) if error.shape == "bounded" else rng.normal(0, 1, walks) * width
        return np.floor(exact + rng.uniform(0, 1, walks)).astype(np.int64)

    cell, heading = np.full(walks, start // k), np.full(walks, start % k)
    seen = np.zeros((walks, cells.count), dtype=bool)
    shares = np.empty((steps + 1, cells.count))
    for step in range(steps + 1):
        if step > 0:
            blocked = cells.target[cell, heading] == BLOCKED
            moves = np.where(blocked, 0, np.maximum(1 + drawn(error.step), 0))
            turns = chain.turn + drawn(error.angle_rad * k / math.tau)
            for count in range(int(moves.max())):
                after = cells.target[cell, heading]
                cell = np.where((moves > count) & (after != BLOCKED), after, cell)
            heading = np.where(blocked, (heading + turns) % k, heading)
        seen[np.arange(walks), cell] = True
        shares[step] = seen.mean(axis=0)
    return shares


@pytest.mark.parametrize("bound", [0.05, 0.5, 1.0])
def test_bounded_errors_below_a_step_split_by_a_quarter_of_the_bound(bound: float) -> None:
    """The mean of |x| is half the bound, and half of it goes to either side."""
    offsets, chances = spread_chances(bound, "bounded")
    assert offsets.tolist() == [-1, 0, 1]
    np.testing.assert_allclose(chances, [bound / 4, 1 - bound / 2, bound / 4], atol=1e-12)


@pytest.mark.parametrize("shape", ["bounded", "gaussian"])
@pytest.mark.parametrize("width", [0.01, 0.4, 1.7, 3.2])
def test_chances_are_integrals_of_hats(width: float, shape: ErrorShape) -> None:
    def density(x: float) -> float:
        if shape == "bounded":
            return 1 / (2 * width) if abs(x) <= width else 0.0
        return math.exp(-((x / width) ** 2) / 2) / (width * math.sqrt(math.tau))

    offsets, chances = spread_chances(width, shape)
    assert chances.sum() == pytest.approx(1.0)
    assert offsets @ chances == pytest.approx(0.0, abs=1e-9)
    for offset in (-2, -1, 0, 1, 2):
        points = sorted({-width, 0.0, width} & {x for x in (-width, 0.0, width) if abs(x - offset) < 1})
        integral, _ = quad(
            lambda x, n=offset: max(0.0, 1 - abs(x - n)) * density(x), offset - 1, offset + 1,
            points=[offset, *points, *(p for n in range(1, 9) for p in (-n * width / 2, n * width / 2)
                                       if abs(p - offset) < 1)], limit=200,
        )  # fmt: skip
        found = chances[offsets == offset]
        assert (found[0] if len(found) else 0.0) == pytest.approx(integral, abs=1e-7)


def test_without_errors_the_chain_is_the_bounce_map() -> None:
    cells = room("....", ".#..", "....")
    chain = motion_chain(cells, 3, MotionError())
    successor = single_map(make_team(cells, [3]))
    assert (chain.chances.getnnz(axis=1) == 1).all()
    np.testing.assert_array_equal(chain.chances.indices, successor)
    assert (chain.chances.data == 1).all()


@pytest.mark.parametrize(
    "error",
    [
        MotionError(angle_rad=0.2),
        MotionError(angle_rad=0.3, shape="gaussian"),
        MotionError(step=0.3),
        MotionError(angle_rad=1.5, step=0.7, shape="gaussian"),
    ],
)
def test_chances_of_cells_agree_with_simulation(error: MotionError) -> None:
    chain = motion_chain(room("....", ".#..", "...."), 3, error)
    np.testing.assert_allclose(np.asarray(chain.chances.sum(axis=1)).ravel(), 1.0, atol=1e-12)
    steps, walks = 60, 20_000
    exact = seen_chances(chain, start_in(chain.cells, 2), steps)
    found = simulated(chain, 2, steps, walks, seed=1)
    deviation = np.sqrt(np.maximum(exact * (1 - exact), 1e-4) / walks)
    assert (np.abs(found - exact) / deviation).max() < 5
    assert ((exact > 0.05) & (exact < 0.95)).sum() > 20  # the comparison is one of chances
    own, _ = sample_walks(chain, start_in(chain.cells, 2), walks=walks, steps=steps, seed=2)
    assert (np.abs(own - exact) / deviation).max() < 5


def test_the_time_to_cover_lies_between_its_bounds() -> None:
    """On four cells the chain of states and sets of seen cells is small enough to be solved."""
    cells = room("..", "..", headings=4)
    chain = motion_chain(cells, 1, MotionError(angle_rad=0.9, step=0.2, shape="gaussian"))
    exact = exact_cover_steps(chain, 0)
    bounds = cover_time(chain, start_in(cells, 0))
    assert bounds.lower_steps < exact < bounds.upper_steps
    assert bounds.upper_steps < 2 * exact
    _, covered = sample_walks(chain, start_in(cells, 0), walks=40_000, steps=2000, seed=3)
    assert (covered >= 0).all()
    assert covered.mean() == pytest.approx(exact, abs=4 * covered.std() / 200)


def exact_cover_steps(chain: MotionChain, start: int) -> float:
    """Expected steps until all cells are seen, by solving for all states with all sets of cells."""
    s, k, n = chain.cells.states, chain.cells.headings, chain.cells.count
    dense, whole = chain.chances.toarray(), 2**n - 1
    matrix, ones = np.eye(s * 2**n), np.ones(s * 2**n)
    for seen, state in itertools.product(range(2**n), range(s)):
        row = seen * s + state
        if seen == whole:
            ones[row] = 0
            continue
        for after in np.flatnonzero(dense[state]):
            matrix[row, (seen | 1 << (after // k)) * s + after] -= dense[state, after]
    return float(np.linalg.solve(matrix, ones)[(1 << (start // k)) * s + start])


def test_a_cell_behind_a_wall_is_never_seen() -> None:
    cells = room(".#.", headings=4)
    chain = motion_chain(cells, 1, MotionError(angle_rad=0.5))
    assert seen_chances(chain, start_in(cells, 0), 50)[-1].tolist() == [1.0, 0.0]
    bounds = cover_time(chain, start_in(cells, 0), most_steps=100)
    assert (bounds.lower_steps, bounds.upper_steps) == (pytest.approx(100.0), math.inf)


def test_the_round_along_the_walls_is_left_as_turns_go_wrong() -> None:
    """Four turns a round, each exact with chance 1 - x / 2 for an error of at most x heading steps."""
    cells = room("....", "....", "....", headings=4)
    x = 0.1
    chain = motion_chain(cells, 1, MotionError(angle_rad=x * math.pi / 2))
    (hold,) = hold_of_cycles(chain)
    assert (hold.steps, hold.basin) == (14, cells.states)
    assert hold.leave_chance == pytest.approx(1 - (1 - x / 2) ** 4)
    assert hold.basin_steps == math.inf  # there is no other cycle to go to
    assert hold_of_cycles(motion_chain(cells, 1, MotionError()))[0].leave_chance == 0


def test_steps_within_a_basin_solve_the_dense_equations() -> None:
    cells = room("....", "....", "....", "....")
    chain = motion_chain(cells, 3, MotionError(angle_rad=0.15, shape="gaussian"))
    exact = motion_chain(cells, 3, MotionError())
    holds = hold_of_cycles(chain)
    assert len(holds) > 3
    assert math.isfinite(holds[0].basin_steps)
    dense, after = chain.chances.toarray(), exact.chances.indices
    ends = np.arange(cells.states)
    for _ in range(2000):
        ends = after[ends]
    basins: dict[int, list[int]] = {}
    for state, end in enumerate(ends):
        round_of = [int(end)]
        while after[round_of[-1]] != end:
            round_of.append(int(after[round_of[-1]]))
        basins.setdefault(min(round_of), []).append(state)
    expected = []
    for first, members in basins.items():
        inside = dense[np.ix_(members, members)]
        steps = np.linalg.solve(np.eye(len(members)) - inside, np.ones(len(members)))
        round_of = [first]
        while after[round_of[-1]] != first:
            round_of.append(int(after[round_of[-1]]))
        expected.append((len(members), float(np.mean([steps[members.index(s)] for s in round_of]))))
    found = [(hold.basin, hold.basin_steps) for hold in holds]
    np.testing.assert_allclose(sorted(found), sorted(expected), rtol=1e-9)


def test_the_most_robust_angle_is_best_for_the_worst_cell() -> None:
    cells = room(".....", ".#...", ".....")
    error = MotionError(angle_rad=math.radians(5), shape="gaussian")
    outcomes = compare_angles(cells, error, steps=150, most_steps=300)
    assert sorted(round(math.degrees(o.angle_rad)) for o in outcomes) == [45, 90, 135, 180, 225, 270, 315]
    least = [round(o.least_chance, 9) for o in outcomes]
    assert least == sorted(least, reverse=True)
    assert least[0] > least[-1]
    for outcome in (outcomes[0], outcomes[-1]):
        turn = round(outcome.angle_rad / (math.pi / 4))
        seen, _ = sample_walks(motion_chain(cells, turn, error), anywhere(cells), walks=20_000, steps=150, seed=4)
        assert seen[-1].min() == pytest.approx(outcome.least_chance, abs=0.02)
        ever = np.zeros((cells.states, cells.count), dtype=bool)
        state = np.arange(cells.states)
        for _ in range(151):
            ever[np.arange(cells.states), state // 8] = True
            state = single_map(make_team(cells, [turn]))[state]
        assert outcome.exact_mean == pytest.approx(ever.mean())
        assert outcome.exact_least == pytest.approx(ever.mean(axis=0).min())


def test_the_same_seed_gives_the_same_walks() -> None:
    chain = motion_chain(room("...", "..."), 3, MotionError(angle_rad=0.3))
    first, second = (sample_walks(chain, anywhere(chain.cells), walks=50, steps=40, seed=7) for _ in range(2))
    np.testing.assert_array_equal(first[0], second[0])
    np.testing.assert_array_equal(first[1], second[1])


def test_errors_that_cannot_be_are_refused() -> None:
    with pytest.raises(MissionError, match="angle_rad: -1 is not allowed"):
        MotionError(angle_rad=-1)
    with pytest.raises(MissionError, match=r"step: 1\.5 is not allowed; must lie in 0\.\.1"):
        MotionError(step=1.5)
    with pytest.raises(MissionError, match="bounded or gaussian"):
        MotionError(shape="round")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="must be 1 to 7"):
        motion_chain(room("..."), 8, MotionError())
