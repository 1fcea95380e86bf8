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
from rota.planners.patrol.tour_kernels import MOST_REMOVED, Tours, set_up

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LONGEST_LEG = 6.0  # legs of at most this many reaches, so that what one sees fits its slot
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
        reach_m = np.array([t.robot.sensor.reach_m for t in tours])
        self._longest_m = LONGEST_LEG * float(reach_m.min())
        self._step_m = float(reach_m.max())
        self._state = self._allocate(price, over_price, seed, range_margin_m, reserve)

    def _allocate(self, price: Floats, over_price: Floats, seed: int, range_margin_m: float, reserve: float) -> Tours:
        tours = self._tours
        shapes = [split_legs(t.vertices_m, self._longest_m) for t in tours]
        n = np.array([len(shape) for shape in shapes], dtype=np.int64)
        room = int(2 * n.max() + 64)
        x, y = np.zeros((len(tours), room)), np.zeros((len(tours), room))
        for k, shape in enumerate(shapes):
            x[k, : n[k]], y[k, : n[k]] = shape.T
        discs = [t.robot.sensor if isinstance(t.robot.sensor, DiscSensor) else None for t in tours]
        reach = [d.radius_m if d else t.robot.sensor.reach_m / np.sqrt(2) for d, t in zip(discs, tours, strict=True)]
        count = len(self._samples.x)
        slots = int(2 * n.sum() + 64 * len(tours) + 64)
        state = Tours(
            x=x,
            y=y,
            slot=np.zeros((len(tours), room), dtype=np.int64),
            n=n,
            length=np.zeros(len(tours)),
            reach_m=np.array(reach) - range_margin_m,
            square=np.array([0 if d else 1 for d in discs], dtype=np.int64),
            serves=np.array([t.serves for t in tours], dtype=np.int64),
            turn_m=np.array([t.turn_m_per_rad for t in tours]),
            price=np.asarray(price, dtype=np.float64),
            budget_m=np.array([t.budget_m for t in tours]) * (1 - reserve),
            over_price=np.asarray(over_price, dtype=np.float64),
            seen=np.zeros((slots, self._slot_room()), dtype=np.int32),
            seen_n=np.zeros(slots, dtype=np.int64),
            free_slots=np.zeros(slots, dtype=np.int64),
            times_seen=np.zeros(count, dtype=np.int64),
            unseen_item=np.zeros(count, dtype=np.int64),
            unseen_place=np.zeros(count, dtype=np.int64),
            ints=np.zeros(3, dtype=np.int64),
            unseen=np.zeros(1),
            removed_x=np.zeros((2, MOST_REMOVED)),
            removed_y=np.zeros((2, MOST_REMOVED)),
            removed_slot=np.zeros((2, MOST_REMOVED + 1), dtype=np.int64),
            rng=np.array([seed * 0x9E3779B97F4A7C15 % 2**64 | 1], dtype=np.uint64),
        )
        if not set_up(self._samples, state):
            # a crowd of samples somewhere: give every slot room for all there could be
            state = state._replace(seen=np.zeros((slots, count), dtype=np.int32))
            set_up(self._samples, state)
        return state

    def _slot_room(self) -> int:
        """Samples that the longest leg may see: those of the fullest bins under its lane, with some to spare."""
        per_bin = np.diff(self._samples.bin_start)
        cell_m, far_m = self._samples.origin[2], self._samples.origin[3]
        lane_m2 = 2 * far_m * self._longest_m + 4 * far_m**2
        fullest = np.sort(per_bin)[::-1][: int(np.ceil(2 * lane_m2 / cell_m**2)) + 4]
        return max(16, min(len(self._samples.x), int(fullest.sum())))

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
        for first in range(0, moves, CHUNK):
            if should_stop():
                return False
            chunk = min(CHUNK, moves - first)
            annealing_kernels.anneal(
                first, chunk, moves, hot_m, cold_m, self._step_m, self._longest_m,
                self._space, self._samples, self._state,
            )  # fmt: skip
            done(chunk)
        return True

    def mend(self, tries: int) -> None:
        """Bend legs towards what is unseen and leave all else alone, so that nothing seen elsewhere is lost."""
        annealing_kernels.mend(tries, self._longest_m, self._space, self._samples, self._state)

    @property
    def unseen(self) -> int:
        """Number of samples that no tour sees."""
        return int(self._state.ints[1])

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
        return max(0.0, *(tour_length_m(tour) / tour.budget_m - 1 for tour in self.tours))

    @property
    def tours(self) -> list[Tour]:
        """The tours as they stand."""
        state = self._state
        return [
            replace(tour, vertices_m=np.column_stack([state.x[k, : state.n[k]], state.y[k, : state.n[k]]]))
            for k, tour in enumerate(self._tours)
        ]
