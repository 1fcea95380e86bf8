"""One robot whose turns and steps are inexact: the bounce map as a Markov chain (generalised cell mapping).

Alam and Bobadilla 2020, Section 6, name a bounded uncertainty of rotation and translation, and a probabilistic variant
of their method, as future work; the theory is C. S. Hsu, "Cell-to-cell mapping", chapter 10. A state stands for all
places and headings in its cell, spread evenly: an error that is a share x of a heading step or of a move leads to the
neighbouring state with chance x, and nowhere else with the rest. So means are kept, and errors far below the grid's
resolution count.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, identity
from scipy.sparse.csgraph import breadth_first_order
from scipy.sparse.linalg import spsolve
from scipy.special import ndtr

from rota.errors import MissionError
from rota.planners.bounce.bounce_map import cycles_and_basins, make_team, single_map
from rota.planners.bounce.cells import BLOCKED, Cells
from rota.planners.bounce.rotation_error_kernels import walk_until_covered

Floats = NDArray[np.float64]
Longs = NDArray[np.int64]
ErrorShape = Literal["bounded", "gaussian"]

_NEGLIGIBLE = 1e-12
_COVERED = 1e-9


@dataclass(frozen=True, kw_only=True)
class MotionError:
    """How inexact a robot is. ``angle_rad`` of each turn, ``step`` as a share of each move; 0: exact.

    ``shape`` "bounded": errors are uniform between minus and plus that much; "gaussian": these are standard deviations.
    Errors of different turns and moves are independent.
    """

    angle_rad: float = 0.0
    step: float = 0.0
    shape: ErrorShape = "bounded"

    def __post_init__(self) -> None:
        if self.shape not in ("bounded", "gaussian"):
            raise MissionError(f"shape: {self.shape!r} is not allowed; bounded or gaussian")
        for name, value, top in (("angle_rad", self.angle_rad, math.pi), ("step", self.step, 1.0)):
            if not (math.isfinite(value) and 0 <= value <= top):
                raise MissionError(f"{name}: {value!r} is not allowed; must lie in 0..{top:.6g}")


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionChain:
    """Where one robot may be a step later: ``chances`` (s, s), rows add up to 1; states as those of ``cells``.

    ``turn``: heading steps at a bump.
    """

    cells: Cells
    turn: int
    error: MotionError
    chances: csr_matrix


@dataclass(frozen=True, kw_only=True)
class CoverTime:
    """Bounds of the expected number of steps until all cells were entered.

    ``lower_steps``: at any time, that some cell is unseen is at least as likely as for the cell least likely seen.
    ``upper_steps``: and at most as likely as all cells' chances added up; infinite where it has not faded in the end.
    """

    lower_steps: float
    upper_steps: float


@dataclass(frozen=True, kw_only=True)
class CycleHold:
    """How well a limit cycle of the exact robot holds an inexact one.

    ``steps`` in a round, ``basin`` in states; ``leave_chance``: that the robot strays from the cycle within a round;
    ``basin_steps``: expected steps, from the cycle, until it is in the basin of another one (infinite: never for sure).
    """

    steps: int
    basin: int
    leave_chance: float
    basin_steps: float


@dataclass(frozen=True, kw_only=True)
class AngleOutcome:
    """What a bouncing angle comes to after some steps: the mean and the least of the cells' chances of being seen.

    ``exact_mean``, ``exact_least``: of the robot without errors. ``cover``: bounds of the expected time to see all.
    """

    angle_rad: float
    mean_chance: float
    least_chance: float
    exact_mean: float
    exact_least: float
    cover: CoverTime


def spread_chances(half_width: float, shape: ErrorShape) -> tuple[Longs, Floats]:
    """Whole offsets (k,) and their chances (k,) for an error, in units of a grid, split between its two neighbours.

    half_width: the bound, or the standard deviation, of the error x. The chance of offset n is the mean of the hat
    max(0, 1 - |x - n|), which is the second difference of the mean of max(0, u - x).
    """
    if half_width == 0:
        return np.zeros(1, dtype=np.int64), np.ones(1)
    reach = math.ceil(half_width * (1 if shape == "bounded" else 8)) + 1
    offsets = np.arange(-reach, reach + 1)
    u = np.arange(-reach - 1, reach + 2, dtype=np.float64)
    if shape == "bounded":
        mean = np.where(u >= half_width, u, (np.maximum(u + half_width, 0.0)) ** 2 / (4 * half_width))
    else:
        scaled = u / half_width
        mean = u * ndtr(scaled) + half_width * np.exp(-(scaled**2) / 2) / math.sqrt(2 * math.pi)
    chances = np.maximum(mean[2:] - 2 * mean[1:-1] + mean[:-2], 0.0)
    kept = chances > _NEGLIGIBLE
    return offsets[kept], chances[kept] / chances[kept].sum()


def motion_chain(cells: Cells, turn: int, error: MotionError) -> MotionChain:
    """The chain of a robot that turns by ``turn`` heading steps at a bump, give or take ``error``.

    A step that is too short leaves the robot where it is, one that is too long takes it a move farther, up to what
    blocks it. Raises ValueError for a turn that is no turn.
    """
    n, k = cells.count, cells.headings
    if not 0 < turn < k:
        raise ValueError(f"turn: {turn} is not allowed; must be 1 to {k - 1} heading steps")
    cell, heading = np.divmod(np.arange(n * k), k)
    target = cells.target.astype(np.int64).ravel()
    free, blocked = np.flatnonzero(target != BLOCKED), np.flatnonzero(target == BLOCKED)
    rows, columns, values = [], [], []
    for offset, chance in zip(*spread_chances(error.angle_rad * k / (2 * math.pi), error.shape), strict=True):
        rows.append(blocked)
        columns.append(cell[blocked] * k + (heading[blocked] + turn + offset) % k)
        values.append(np.full(len(blocked), chance))
    offsets, chances = spread_chances(error.step, error.shape)
    moves = np.maximum(offsets + 1, 0)
    at = free.copy()
    for count in range(int(moves.max()) + 1):
        rows.append(free)
        columns.append(at.copy())
        values.append(np.full(len(free), chances[moves == count].sum()))
        following = target[at]
        at = np.where(following == BLOCKED, at, following * k + heading[free])
    matrix = csr_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(n * k, n * k)
    )  # fmt: skip
    matrix.sum_duplicates()
    matrix.eliminate_zeros()
    return MotionChain(cells=cells, turn=turn, error=error, chances=matrix)


def anywhere(cells: Cells) -> Floats:
    """(s,) a start in any cell with any heading, all equally likely."""
    return np.full(cells.states, 1 / cells.states)


def start_in(cells: Cells, state: int) -> Floats:
    """(s,) a start that is known."""
    start = np.zeros(cells.states)
    start[state] = 1.0
    return start


def seen_chances(chain: MotionChain, start: Floats, steps: int) -> Floats:
    """(steps + 1, n) the chance that each cell was entered after so many steps or fewer; start: (s,) distribution.

    For every cell the chain is followed in which this cell absorbs, all of them together: steps times the chain's
    entries times the number of cells.
    """
    n, k = chain.cells.count, chain.cells.headings
    unseen = np.repeat(np.asarray(start, dtype=np.float64)[:, None], n, axis=1)
    own = np.arange(n * k), np.repeat(np.arange(n), k)
    forward = chain.chances.T.tocsr()
    seen = np.empty((steps + 1, n))
    for step in range(steps + 1):
        if step > 0:
            unseen = forward @ unseen
        unseen[own] = 0.0
        seen[step] = 1 - unseen.sum(axis=0)
    return np.clip(seen, 0.0, 1.0)


def cover_time(chain: MotionChain, start: Floats, most_steps: int = 20_000) -> CoverTime:
    """Bounds of the expected steps until all cells were entered, from the chances of ``seen_chances``.

    That all are seen is no likelier than that one is, and the chance that any is unseen is at most the sum of all.
    """
    lower, upper, block = 0.0, 0.0, 256
    n, k = chain.cells.count, chain.cells.headings
    unseen = np.repeat(np.asarray(start, dtype=np.float64)[:, None], n, axis=1)
    own = np.arange(n * k), np.repeat(np.arange(n), k)
    forward = chain.chances.T.tocsr()
    unseen[own] = 0.0
    for step in range(most_steps):
        left = unseen.sum(axis=0)
        lower, upper = lower + float(left.max()), upper + min(float(left.sum()), 1.0)
        if step % block == 0 and left.sum() < _COVERED:
            return CoverTime(lower_steps=lower, upper_steps=upper)
        unseen = forward @ unseen
        unseen[own] = 0.0
    return CoverTime(lower_steps=lower, upper_steps=math.inf)


def sample_walks(chain: MotionChain, start: Floats, *, walks: int, steps: int, seed: int) -> tuple[Floats, Longs]:
    """Monte Carlo: (steps + 1, n) shares of walks that had entered each cell, and (walks,) steps to cover; -1: not."""
    rng = np.random.default_rng(seed)
    starts = rng.choice(chain.cells.states, walks, p=start)
    seeds = rng.integers(0, 2**64, walks, dtype=np.uint64)
    rows = chain.chances
    cumulated = np.cumsum(rows.data)
    cumulated -= np.repeat(np.concatenate([[0.0], cumulated])[rows.indptr[:-1]], np.diff(rows.indptr))
    seen = np.zeros((steps + 1, chain.cells.count), dtype=np.int64)
    covered = np.empty(walks, dtype=np.int64)
    walk_until_covered(
        rows.indptr.astype(np.int64), rows.indices.astype(np.int64), cumulated, chain.cells.headings,
        starts.astype(np.int64), seeds, steps, seen, covered,
    )  # fmt: skip
    return seen / walks, covered


def hold_of_cycles(chain: MotionChain) -> tuple[CycleHold, ...]:
    """How well each limit cycle of the exact robot holds, the one with the largest basin first."""
    successor = single_map(make_team(chain.cells, [chain.turn])).astype(np.int64)
    found = cycles_and_basins(successor.astype(np.int32))
    follows = np.asarray(chain.chances[np.arange(len(successor)), successor]).ravel()
    holds = []
    for number in np.argsort(-found.basin, kind="stable"):
        states = [int(found.first[number])]
        while len(states) < found.length[number]:
            states.append(int(successor[states[-1]]))
        members = np.flatnonzero(found.cycle == number)
        expected = _steps_inside(chain.chances, members)
        holds.append(
            CycleHold(
                steps=int(found.length[number]),
                basin=int(found.basin[number]),
                leave_chance=float(1 - follows[states].prod()),
                basin_steps=float(expected[np.searchsorted(members, states)].mean()),
            )
        )
    return tuple(holds)


def _steps_inside(chances: csr_matrix, members: Longs) -> Floats:
    """(m,) expected steps until the chain leaves the set, from each member; inf where it may stay for ever."""
    inside = chances[members][:, members].tocsr()
    leaves = np.asarray(inside.sum(axis=1)).ravel() < 1 - _NEGLIGIBLE
    escaping = _leads_to(inside, leaves)
    endless = _leads_to(inside, ~escaping)
    expected = np.full(len(members), math.inf)
    some = np.flatnonzero(~endless)
    if len(some):
        part = identity(len(some), format="csc") - inside[some][:, some].tocsc()
        expected[some] = spsolve(part, np.ones(len(some)))
    return expected


def _leads_to(inside: csr_matrix, goal: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(m,) whether a way leads from each state to the goal; the goal itself included."""
    m = len(goal)
    into = np.flatnonzero(goal)
    back = inside.T.tocoo()
    rows = np.concatenate([back.row, np.full(len(into), m)])
    columns = np.concatenate([back.col, into])
    graph = csr_matrix((np.ones(len(rows)), (rows, columns)), shape=(m + 1, m + 1))
    reached = np.zeros(m + 1, dtype=bool)
    reached[breadth_first_order(graph, m, return_predecessors=False)] = True
    return reached[:m]


def compare_angles(
    cells: Cells, error: MotionError, steps: int, *, start: Floats | None = None, most_steps: int = 20_000
) -> tuple[AngleOutcome, ...]:
    """All bouncing angles, the most robust first: that with the best chance, after ``steps``, for the worst cell.

    Where these tie, the better mean decides. start: (s,), by default anywhere.
    """
    begin = anywhere(cells) if start is None else start
    outcomes = []
    for turn in range(1, cells.headings):
        chain = motion_chain(cells, turn, error)
        seen = seen_chances(chain, begin, steps)[-1]
        exact = seen_chances(motion_chain(cells, turn, MotionError()), begin, steps)[-1]
        outcomes.append(
            AngleOutcome(
                angle_rad=turn * 2 * math.pi / cells.headings,
                mean_chance=float(seen.mean()),
                least_chance=float(seen.min()),
                exact_mean=float(exact.mean()),
                exact_least=float(exact.min()),
                cover=cover_time(chain, begin, most_steps),
            )
        )
    return tuple(sorted(outcomes, key=lambda o: (-round(o.least_chance, 9), -o.mean_chance, o.angle_rad)))
