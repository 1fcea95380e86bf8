"""Simulated annealing over all tours at once: units and checks before the compiled loops."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rota.geometry.kernels import EdgeGrid
from rota.mission import DiscSensor, Robot
from rota.planners.patrol.annealing import kernels as annealing_kernels
from rota.planners.patrol.kernels import Samples
from rota.planners.patrol.tour_kernels import FULL, MOST_TRIED, NUMBERS, SLOTS_LEFT, UNSEEN, Tours, set_up

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LONGEST_LEG = 6.0  # legs of at most this many reaches, so that what one sees stays near its ends
MOST_BUCKETS = 4_000_000
CHUNK = 20_000  # moves between two looks at the stop flag


@dataclass(frozen=True, kw_only=True)
class Tour:
    """A closed polyline served by one or more equally spaced robots.

    vertices_m: (n, 2), n >= 1; the last leg leads back to the first vertex. serves: the shortest period class whose
    points it may count as seen; ``period_s`` is that class's period; part: the part of the standing space it lies in.
    """

    vertices_m: Floats
    serves: int
    period_s: float
    robots: int
    robot: Robot
    part: int = 0

    @property
    def budget_m(self) -> float:
        """Length that its robots can travel within the period (turning counts as the metres of the same time)."""
        return self.robots * self.period_s * self.robot.speed_m_s * (1 - 1e-6)

    @property
    def turn_m_per_rad(self) -> float:
        """Metres that could be travelled while turning by one radian."""
        return 0.0 if self.robot.turn_rate_rad_s is None else self.robot.speed_m_s / self.robot.turn_rate_rad_s


def tour_length_m(tour: Tour) -> float:
    """Length of the tour, with turning counted as the metres that take the same time; 0 for a tour of one vertex."""
    legs = np.diff(np.vstack([tour.vertices_m, tour.vertices_m[:1]]), axis=0)
    total = float(np.hypot(legs[:, 0], legs[:, 1]).sum())
    return total + tour.turn_m_per_rad * float(turns_rad(tour.vertices_m).sum())


def over_budget_share(tours: Sequence[Tour]) -> float:
    """The greatest excess of a tour over its budget, as a share of the budget; 0 when all keep within."""
    return max(0.0, *(tour_length_m(tour) / tour.budget_m - 1 for tour in tours))


def turns_rad(vertices_m: Floats) -> Floats:
    """Angle (n,) by which the direction changes at each vertex of a closed polyline; 0 for one vertex."""
    if len(vertices_m) < 2:
        return np.zeros(len(vertices_m))
    after = np.roll(vertices_m, -1, axis=0) - vertices_m
    before = np.roll(after, 1, axis=0)
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.asarray(np.abs(np.arctan2(cross, (before * after).sum(axis=1))))


def without_repeats(vertices_m: Floats) -> Floats:
    """The closed polyline without vertices that repeat the one before; at least one vertex stays."""
    keep = (np.roll(vertices_m, 1, axis=0) != vertices_m).any(axis=1)
    return np.asarray(vertices_m[keep] if keep.any() else vertices_m[:1])


def split_legs(vertices_m: Floats, longest_m: float) -> Floats:
    """The closed polyline with legs longer than ``longest_m`` cut into equal pieces."""
    ends = np.roll(vertices_m, -1, axis=0)
    legs = np.hypot(*(ends - vertices_m).T)
    pieces = np.maximum(1, np.ceil(legs / (longest_m * (1 - 1e-9)))).astype(np.int64)
    which = np.repeat(np.arange(len(vertices_m)), pieces)
    step = (np.arange(len(which)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[which]
    return np.asarray(vertices_m[which] + step[:, None] * (ends - vertices_m)[which])


class Annealing:
    """The state of one search: the samples, the standing space, and the tours as the kernels hold them."""

    def __init__(
        self,
        tours: Sequence[Tour],
        samples: Samples,
        space: EdgeGrid,
        *,
        price: Floats,
        over_price: Floats,
        seed: int,
        range_margin_m: float,
        reserve: float = 0.0,
    ) -> None:
        """price, over_price: (k,) cost per metre of each tour, and above its budget less the reserve (a share)."""
        self._tours = [replace(t, vertices_m=without_repeats(t.vertices_m)) for t in tours]
        self._samples = samples
        self._space = space
        self._price, self._over_price = price, over_price
        self._range_margin_m, self._reserve = range_margin_m, reserve
        reach_m = np.array([t.robot.sensor.reach_m for t in tours])
        self._longest_m = LONGEST_LEG * float(reach_m.min())
        self._step_m = float(reach_m.max())
        self._room, self._spare = 64, 64
        self._state = self._laid_out(np.array([seed * 0x9E3779B97F4A7C15 % 2**64 | 1], dtype=np.uint64))

    def _laid_out(self, rng: NDArray[np.uint64]) -> Tours:
        """The tours laid out for the kernels, with as much room for what their legs see as it takes."""
        shapes = [split_legs(t.vertices_m, self._longest_m) for t in self._tours]
        places_m = np.vstack(shapes)
        tour = np.repeat(np.arange(len(shapes)), [len(shape) for shape in shapes])
        while True:
            state = self._allocate(len(places_m), rng)
            x, y = np.ascontiguousarray(places_m[:, 0]), np.ascontiguousarray(places_m[:, 1])
            if set_up(x, y, tour, self._samples, state):
                return state
            self._room *= 2

    def _allocate(self, vertices: int, rng: NDArray[np.uint64]) -> Tours:
        tours, count = self._tours, len(self._samples.x)
        room = vertices + vertices // 2 + self._spare
        slots = room + MOST_TRIED
        reach_m = np.array([in_range_m(t.robot) for t in tours])
        grid, grid_n = bucket_grid(self._space, float(reach_m.min()))
        ids = np.arange(len(tours), dtype=np.int64)

        def numbers(n: int) -> Ints:
            return np.zeros(n, dtype=np.int64)

        return Tours(
            x=np.zeros(room), y=np.zeros(room), after=numbers(room), before=numbers(room), tour=numbers(room),
            slot=numbers(room), in_use=numbers(room), place=numbers(room), free_vertices=numbers(room),
            bucket=numbers(int(grid_n.prod())), bucket_after=numbers(room), bucket_before=numbers(room),
            grid=grid, grid_n=grid_n,
            anchor=numbers(len(tours)), n=numbers(len(tours)), length=np.zeros(len(tours)),
            reach_m=reach_m - self._range_margin_m,
            square=np.array([0 if isinstance(t.robot.sensor, DiscSensor) else 1 for t in tours], dtype=np.int64),
            serves=np.array([t.serves for t in tours], dtype=np.int64),
            turn_m=np.array([t.turn_m_per_rad for t in tours]),
            price=np.asarray(self._price, dtype=np.float64),
            budget_m=np.array([t.budget_m for t in tours]) * (1 - self._reserve),
            over_price=np.asarray(self._over_price, dtype=np.float64),
            hub=ids, petals=np.zeros((len(tours), 2), dtype=np.int64), visits=np.ones(len(tours), dtype=np.int64),
            whole_m=np.full(len(tours), np.inf),
            seen=np.zeros((slots, self._room), dtype=np.int32), seen_n=numbers(slots), free_slots=numbers(slots),
            times_seen=np.zeros(count, dtype=np.int32), unseen_item=numbers(count), unseen_place=numbers(count),
            ints=numbers(NUMBERS), unseen=np.zeros(1),
            tried_new=numbers(MOST_TRIED), tried_old=numbers(MOST_TRIED), rng=rng, scratch=np.zeros((4, 8)),
        )  # fmt: skip

    def _grow(self) -> None:
        """Make room for more vertices, or for legs that see more, whichever a move lacked."""
        if self._state.ints[SLOTS_LEFT] > MOST_TRIED // 2:
            self._room *= 2
        self._spare *= 2
        self._tours = self.tours
        self._state = self._laid_out(self._state.rng)

    def run(
        self,
        moves: int,
        *,
        hot_m: float,
        cold_m: float,
        should_stop: Callable[[], bool],
        done: Callable[[int], None] = lambda moves: None,
    ) -> bool:
        """Anneal; True when all moves were made, False when ``should_stop`` ended it early."""
        first = 0
        while first < moves:
            if should_stop():
                return False
            made = annealing_kernels.anneal(
                first, min(CHUNK, moves - first), moves, hot_m, cold_m, self._step_m, self._longest_m,
                self._space, self._samples, self._state,
            )  # fmt: skip
            first += made
            if self._state.ints[FULL]:
                self._grow()
            done(made)
        return True

    def mend(self, tries: int) -> None:
        """Bend legs towards what is unseen and leave all else alone, so that nothing seen elsewhere is lost."""
        while tries > 0:
            made = annealing_kernels.mend(tries, self._longest_m, self._space, self._samples, self._state)
            if not self._state.ints[FULL]:
                return
            tries -= made
            self._grow()

    @property
    def unseen(self) -> int:
        """Number of samples that no tour sees."""
        return int(self._state.ints[UNSEEN])

    @property
    def unseen_samples(self) -> Ints:
        """Indices of the samples that no tour sees, ascending."""
        return np.sort(self._state.unseen_item[: self.unseen])

    @property
    def unseen_share(self) -> float:
        """Weight of the samples that no tour sees, as a share of all."""
        return float(self._samples.weight[self.unseen_samples].sum() / self._samples.weight.sum())

    @property
    def over_budget_share(self) -> float:
        """The greatest excess of a tour over its budget, as a share of the budget."""
        return over_budget_share(self.tours)

    @property
    def shortfall_m(self) -> float:
        """How far from done: what is unseen, as the metres it is worth, and metres over budget at their price."""
        state = self._state
        over_m = np.maximum(0.0, state.length - state.budget_m)
        return float(state.unseen[0] + (over_m * state.over_price).sum())

    @property
    def tours(self) -> list[Tour]:
        """The tours as they stand."""
        state = self._state
        return [replace(tour, vertices_m=ring_of(state, k)) for k, tour in enumerate(self._tours)]


def in_range_m(robot: Robot) -> float:
    """Radius of a disc sensor, or half the side of a square one."""
    sensor = robot.sensor
    return sensor.radius_m if isinstance(sensor, DiscSensor) else sensor.side_m / 2


def bucket_grid(space: EdgeGrid, reach_m: float) -> tuple[Floats, Ints]:
    """Corner and cell (3,), columns and rows (2,), of buckets as wide as the reach over the standing space."""
    wide_m, high_m = space.nx * space.cell_m, space.ny * space.cell_m
    cell_m = max(reach_m, np.sqrt(wide_m * high_m / MOST_BUCKETS))
    counts = [int(np.ceil(wide_m / cell_m)) + 1, int(np.ceil(high_m / cell_m)) + 1]
    return np.array([space.x0, space.y0, cell_m]), np.array(counts, dtype=np.int64)


def ring_of(state: Tours, k: int) -> Floats:
    """Places (n, 2) of the vertices of tour k, from its anchor on."""
    order = np.empty(int(state.n[k]), dtype=np.int64)
    v = int(state.anchor[k])
    for i in range(len(order)):
        order[i] = v
        v = int(state.after[v])
    return np.column_stack([state.x[order], state.y[order]])
