"""Simulated annealing over all tours at once: units and checks before the compiled loops."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rota.geometry.kernels import EdgeGrid
from rota.model.arrays import Floats, Ints
from rota.model.mission import DiscSensor, inner_reach_m
from rota.planners.patrol.annealing import kernels as annealing_kernels
from rota.planners.patrol.annealing.count_kernels import words_for
from rota.planners.patrol.annealing.state import Count, Tours
from rota.planners.patrol.annealing.state_kernels import MOST_TRIED, over_budget_costs, set_up, tour_length
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.driving.polylines import split_legs, without_repeats
from rota.planners.patrol.driving.speed_kernels import Row
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.samples import MOST_CELLS
from rota.planners.patrol.tours.tour import (
    Tour,
    hubs_and_petals,
    over_budget_share,
    rounds_more,
    tour_length_m,
    whole_budget_m,
)


@dataclass(frozen=True, kw_only=True)
class Annealed:
    """What an annealing came to: its tours, and what ``Annealing`` says of them in properties of these names."""

    tours: list[Tour]
    unseen_share: float
    over_budget_share: float
    shortfall_m: float
    moves_made: int


LONGEST_LEG = 6.0  # legs of at most this many reaches, so that what one sees stays near its ends
BENDS = 2_000  # tries to see more between two looks at the stop flag


class Annealing:
    """The state of one search: the samples, the standing space, and the tours as the kernels hold them."""

    def __init__(
        self,
        tours: Sequence[Tour],
        samples: Samples,
        space: EdgeGrid,
        *,
        length_weight: Floats,
        budget_penalty: Floats,
        seed: int,
        range_margin_m: float,
        reserve: float = 0.0,
    ) -> None:
        """length_weight, budget_penalty: (k,) cost of a metre of each tour, and of one beyond its reduced budget."""
        self._tours = [replace(t, vertices_m=without_repeats(t.vertices_m), pace=None) for t in tours]
        self._samples = samples
        self._space = space
        self._length_weight, self._budget_penalty = length_weight, budget_penalty
        self._range_margin_m, self._reserve = range_margin_m, reserve
        self._budget_m = np.array([t.budget_m for t in tours]) * (1 - reserve)
        reach_m = np.array([t.robot.sensor.reach_m for t in tours])
        self._longest_m = LONGEST_LEG * float(reach_m.min())
        self._step_m = float(reach_m.max())
        self.moves_made = 0
        self._room, self._spare = 64, 64
        self._state = self._lay_out(np.array([seed * 0x9E3779B97F4A7C15 % 2**64 | 1], dtype=np.uint64))

    def _lay_out(self, rng: NDArray[np.uint64]) -> Tours:
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
        """Tours without stops, with room for so many and the tables that their moves read."""
        tours, count = self._tours, len(self._samples.x)
        room = vertices + vertices // 2 + self._spare
        slots = room + MOST_TRIED
        reach_m = np.array([inner_reach_m(t.robot.sensor) for t in tours])
        grid, grid_n = bucket_grid(self._space, float(reach_m.min()))
        hub, petals = hubs_and_petals(tours)
        whole_m = np.array([whole_budget_m(tours, h, petals[h]) for h in range(len(tours))])

        costs = [driving_of(t.robot).corner_costs for t in tours]
        more = [rounds_more(tours, range(*petals[h])) for h in range(len(tours))]
        heaviest_m = self._samples.weight.max(initial=0.0)

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
            period_class=np.array([t.period_class for t in tours], dtype=np.int64),
            turn_m=np.array([cost.turn_m for cost in costs]), arc_m=np.array([cost.arc_m for cost in costs]),
            corners=costs[0].table, corner_leg_m=np.array([costs[0].longest_m, costs[0].straight]),
            blind_m=np.array([driving_of(t.robot).blind_m for t in tours]),
            limits=costs[0].limits, trims=np.zeros(8), window=np.zeros((len(Row), room)),
            sine=np.zeros(room), speed2=np.zeros(room), leg_cost=np.zeros(room), corner_cost=np.zeros(room),
            costly=np.array([0 if cost.are_free else 1 for cost in costs], dtype=np.int64),
            length_weight=np.asarray(self._length_weight, dtype=np.float64),
            budget_m=self._budget_m.copy(),
            budget_penalty=np.asarray(self._budget_penalty, dtype=np.float64),
            hub=hub, petals=petals, meets=numbers(len(tours)), more=np.array(more, dtype=np.int64),
            whole_m=whole_m * (1 - self._reserve),
            seen=np.zeros((slots, self._room), dtype=np.int32), seen_n=numbers(slots), free_slots=numbers(slots),
            times_seen=np.zeros(words_for(count, slots), dtype=np.uint64),
            unseen_item=numbers(count), unseen_place=numbers(count),
            bucket_of_sample=buckets_of(self._samples, grid, grid_n), unseen_in=numbers(int(grid_n.prod())),
            most=np.array([heaviest_m, max(reach_m.max(), self._samples.visit_m.max(initial=0.0)), 0.0]),
            ints=numbers(len(Count)), unseen=np.zeros(1),
            new_legs=np.zeros((8, 5)), tried_new=numbers(MOST_TRIED), tried_old=numbers(MOST_TRIED),
            rng=rng, new_x=np.zeros(8), new_y=np.zeros(8), scratch=np.zeros((2, 8)),
        )  # fmt: skip

    def _grow(self) -> None:
        """Make room for more vertices, or for legs that see more, whichever a move lacked."""
        if self._state.ints[Count.SLOTS_LEFT] > MOST_TRIED // 2:
            self._room *= 2
        self._spare *= 2
        self._tours = self.tours
        self._state = self._lay_out(self._state.rng)

    def run(
        self,
        moves: int,
        *,
        hot_m: float,
        cold_m: float,
        should_stop: Callable[[], bool],
        done: Callable[[int], None] = lambda moves: None,
        vertex_price: float = 0.0,
    ) -> bool:
        """Anneal; True when all moves were made, False when ``should_stop`` ended it early.

        vertex_price: what a vertex more costs, as a multiple of the heat.
        """
        first, schedule = 0, annealing_kernels.Schedule(moves, hot_m, cold_m, vertex_price)
        while first < moves:
            if should_stop():
                return False
            self._look_at_corners()
            made = annealing_kernels.anneal(
                # moves between two looks at the stop flag
                first, min(20_000, moves - first), schedule, self._step_m, self._longest_m,
                self._space, self._samples, self._state,
            )  # fmt: skip
            first += made
            self.moves_made += made
            if self._state.ints[Count.FULL]:
                self._grow()
            done(made)
        return True

    def _look_at_corners(self) -> None:
        """Of robots with mass: count anew what is seen where corners are cut, and take lengths from their exact rounds.

        A move looks at its own corners only, and sums of costs are near to exact lengths: budgets make up for the rest.
        """
        if not driving_of(self._tours[0].robot).has_mass:
            return
        if self._state.limits.size:
            self._tours = self.tours
            self._state = self._lay_out(self._state.rng)
        state = self._state
        exact_m = np.array([tour_length_m(tour) for tour in self.tours])
        summed_m = np.array([tour_length(k, state) for k in range(len(exact_m))])
        state.budget_m[:] = self._budget_m - (exact_m - summed_m)

    def see_more(self, tries: int, should_stop: Callable[[], bool] = lambda: False) -> None:
        """Bend legs towards what is unseen and leave all else alone, so that nothing seen elsewhere is lost."""
        while tries > 0 and not should_stop():
            some = min(tries, BENDS)
            made = annealing_kernels.see_more(some, self._longest_m, self._space, self._samples, self._state)
            tries -= made
            if self._state.ints[Count.FULL]:
                self._grow()
            elif made < some:  # all is seen
                return

    @property
    def unseen(self) -> int:
        """Number of samples that no tour sees."""
        return int(self._state.ints[Count.UNSEEN])

    @property
    def unseen_samples(self) -> Ints:
        """Indices of the samples that no tour sees, ascending."""
        return np.sort(self._state.unseen_item[: self.unseen])

    @property
    def unseen_share(self) -> float:
        """Weight of the samples that no tour sees, as a share of all."""
        return self.unseen_m / float(self._samples.weight.sum())

    @property
    def unseen_m(self) -> float:
        """Weight of the samples that no tour sees: the metres that it is worth to see them."""
        return float(self._samples.weight[self.unseen_samples].sum())

    @property
    def over_budget_share(self) -> float:
        """The greatest excess of a tour over its budget, as a share of the budget."""
        return over_budget_share(self.tours)

    @property
    def shortfall_m(self) -> float:
        """How far from done: what is unseen, as the metres it is worth, and metres over budget at their price."""
        state = self._state
        return float(state.unseen[0] + over_budget_costs(np.unique(state.hub), state))

    @property
    def annealed(self) -> Annealed:
        """What it came to so far, without its state."""
        tours = self.tours
        return Annealed(
            tours=tours, unseen_share=self.unseen_share, over_budget_share=over_budget_share(tours),
            shortfall_m=self.shortfall_m, moves_made=self.moves_made,
        )  # fmt: skip

    @property
    def tours(self) -> list[Tour]:
        """The tours as they stand."""
        state = self._state
        return [replace(tour, vertices_m=ring_of(state, k)) for k, tour in enumerate(self._tours)]


def bucket_grid(space: EdgeGrid, reach_m: float) -> tuple[Floats, Ints]:
    """Corner and cell (3,), columns and rows (2,), of buckets as wide as the reach over the standing space."""
    wide_m, high_m = space.nx * space.cell_m, space.ny * space.cell_m
    cell_m = max(reach_m, np.sqrt(wide_m * high_m / MOST_CELLS))
    counts = [int(np.ceil(wide_m / cell_m)) + 1, int(np.ceil(high_m / cell_m)) + 1]
    return np.array([space.x0, space.y0, cell_m]), np.array(counts, dtype=np.int64)


def buckets_of(samples: Samples, grid: Floats, grid_n: Ints) -> NDArray[np.int32]:
    """The bucket (n,) of each sample; places outside the grid belong to its nearest one."""
    column = np.clip((samples.x - grid[0]) / grid[2], 0, grid_n[0] - 1).astype(np.int32)
    row = np.clip((samples.y - grid[1]) / grid[2], 0, grid_n[1] - 1).astype(np.int32)
    buckets: NDArray[np.int32] = row * np.int32(grid_n[0]) + column
    return buckets


def ring_of(state: Tours, k: int) -> Floats:
    """Places (n, 2) of the vertices of tour k, from its anchor on."""
    order = np.empty(int(state.n[k]), dtype=np.int64)
    v = int(state.anchor[k])
    for i in range(len(order)):
        order[i] = v
        v = int(state.after[v])
    return np.column_stack([state.x[order], state.y[order]])


def budget_penalties(tours: list[Tour], price: float) -> Floats:
    """Price (k,) of a metre over the budget of each tour; the more the less a robot can travel at all."""
    one_m = np.array([replace(tour, robots=1).budget_m for tour in tours])
    reach_m = np.array([tour.robot.sensor.reach_m for tour in tours])
    return np.asarray(price * np.maximum(1.0, reach_m / one_m))
