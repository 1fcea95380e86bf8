"""Closed tours, and nests of them that one robot drives in turn."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.model.mission import Robot
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.driving.polylines import without_repeats


@dataclass(frozen=True, kw_only=True)
class Pace:
    """How a robot keeps step with others that come to the same places.

    first: the vertices at which its rounds begin. rounds_m: metres that it could travel in the time of each round,
    which ends where the next one begins; it waits where a round is shorter. lead_m: by how much, in such metres, it is
    past the beginning of the first.
    """

    first: tuple[int, ...]
    rounds_m: tuple[float, ...]
    lead_m: float


@dataclass(frozen=True, kw_only=True)
class Tour:
    """A closed polyline served by one or more equally spaced robots.

    vertices_m: (n, 2), n >= 1; the last leg leads back to the first vertex.
    period_class: the shortest period class whose points it may count as seen; ``period_s`` is that class's period.
    component: the connected component of the standing space in which it lies.
    nest: tours of one number (not -1), which follow each other, belong together: in each period the first, the hub, is
    gone round once, and after each round one of the others, its petals, in turn. Petals begin at vertices of the hub
    and have no robots of their own. Several robots of a hub begin its rounds in turn; then all petals begin at its
    first vertex. A robot alone whose petals begin at different vertices goes on along the hub from one to the next,
    which takes it once more round the hub until all have had their turn.
    pace: only of a tour as it is driven, by one robot, in step with others.
    revisits: it comes to some places several times in a round, each time before they are late: no search moves it.
    """

    vertices_m: Floats
    period_class: int
    period_s: float
    robots: int
    robot: Robot
    component: int = 0
    nest: int = -1
    pace: Pace | None = None
    revisits: bool = False

    @property
    def budget_m(self) -> float:
        """Length that its robots can travel within the period (what costs time counts as the metres of that time)."""
        return self.robots * self.period_s * driving_of(self.robot).pace_m_s * (1 - 1e-6)


def tour_length_m(tour: Tour) -> float:
    """Length of the tour, with all that costs time counted as the metres of the same time; 0 for one vertex."""
    return driving_of(tour.robot).round_m(tour.vertices_m)


def nests(tours: Sequence[Tour]) -> Iterator[list[int]]:
    """The indices of the tours of each robot or group of robots: a tour alone, or a hub and its petals."""
    k = 0
    while k < len(tours):
        end = k + 1
        while tours[k].nest >= 0 and end < len(tours) and tours[end].nest == tours[k].nest:
            end += 1
        yield list(range(k, end))
        k = end


def hubs_and_petals(tours: Sequence[Tour]) -> tuple[Ints, Ints]:
    """For each tour (k,) its hub, itself for a tour alone; and (k, 2) its first petal and one past its last one."""
    hub, petals = np.arange(len(tours), dtype=np.int64), np.zeros((len(tours), 2), dtype=np.int64)
    for nest in nests(tours):
        hub[nest] = nest[0]
        if len(nest) > 1:
            petals[nest[0]] = nest[1], nest[-1] + 1
    return hub, petals


def meeting(hub_m: Floats, petal_m: Floats) -> int:
    """The vertex of a hub (n, 2) at which a petal (m, 2) begins."""
    return int(np.flatnonzero((hub_m == petal_m[0]).all(axis=1))[0])


def rounds_more(tours: Sequence[Tour], petals: Sequence[int]) -> int:
    """Rounds of a hub beyond one for each of its petals: one where these begin at different vertices."""
    return int(len({tuple(tours[k].vertices_m[0].tolist()) for k in petals}) > 1)


def whole_budget_m(tours: Sequence[Tour], hub: int, petals: Ints) -> float:
    """Metres in which all rounds of a nest may be driven: the shortest period of a petal; inf without petals."""
    per_s = tours[hub].budget_m / tours[hub].period_s
    return min((per_s * tours[k].period_s for k in range(petals[0], petals[1])), default=math.inf)


def excesses(tours: Sequence[Tour]) -> list[tuple[float, float]]:
    """Metres over budget (less than 0: what is left) and that budget, of each tour alone and each round of a nest."""
    over = []
    for hub, *petals in nests(tours):
        if not petals:
            over.append((tour_length_m(tours[hub]) - tours[hub].budget_m, tours[hub].budget_m))
            continue
        hub_m = tour_length_m(tours[hub])
        rounds_m = [hub_m + tour_length_m(tours[k]) for k in petals]
        whole_m = whole_budget_m(tours, hub, np.array([petals[0], petals[-1] + 1]))
        over += [(round_m - tours[hub].budget_m, tours[hub].budget_m) for round_m in rounds_m]
        over.append((sum(rounds_m) + rounds_more(tours, petals) * hub_m - whole_m, whole_m))
    return over


def over_budget_share(tours: Sequence[Tour], reserve: float = 0.0) -> float:
    """The greatest excess over a budget less a reserve (a share of it), as a share of the budget; 0: all are kept."""
    return max(0.0, *(excess / budget + reserve for excess, budget in excesses(tours)))


def room_m(tours: Sequence[Tour], k: int) -> float:
    """Metres by which tour k may grow within the budgets; less than 0 when it is over one."""
    for nest in nests(tours):
        if k in nest:
            members = [tours[i] for i in nest]
            left = [-excess for excess, _ in excesses(members)]
            if len(nest) > 1 and k > nest[0]:
                left = [left[k - nest[0] - 1], left[-1]]
            return min(left)
    raise IndexError(k)


def unfold_nests(tours: Sequence[Tour]) -> list[Tour]:
    """The tours as robots drive them: of each nest one long tour a robot, hub and petals in turn, at the slow period.

    Rounds of a robot alone whose petal is empty are left out: what they see is seen again sooner.
    """
    driven_tours = []
    for hub, *all_petals in nests(tours):
        petals = [k for k in all_petals if len(tours[k].vertices_m) > 1]
        if not petals:
            driven_tours.append(replace(tours[hub], nest=-1))
            continue
        if tours[hub].robots > 1:
            driven_tours += in_step(tours, hub, all_petals)
            continue
        vertices_m = np.vstack(list(in_turn(tours[hub].vertices_m, [tours[k].vertices_m for k in petals])))
        slow_s = min(tours[k].period_s for k in petals)
        driven_tours.append(replace(tours[hub], vertices_m=without_repeats(vertices_m), period_s=slow_s, nest=-1))
    return driven_tours


def in_turn(hub_m: Floats, petals_m: Sequence[Floats]) -> Iterator[Floats]:
    """The parts of the tour of a robot alone: on along the hub to where a petal begins, once round, then the petal.

    Between two visits to a place of the hub there is at most one petal and just one round of the hub, wherever the
    petals begin, because they take their turns in the order of the hub.
    """
    at = [meeting(hub_m, petal_m) for petal_m in petals_m]
    order = sorted(range(len(at)), key=lambda k: at[k])
    for before, k in zip(order[-1:] + order[:-1], order, strict=True):
        yield np.roll(hub_m, -at[before], axis=0)[: (at[k] - at[before]) % len(hub_m)]
        yield np.roll(hub_m, -at[k], axis=0)
        yield petals_m[k]


def in_step(tours: Sequence[Tour], hub: int, petals: Sequence[int]) -> Iterator[Tour]:
    """The tour of each robot of one hub: they begin rounds of equal time in turn, and each round has the next petal.

    With as many petals as is no multiple of the robots, every robot comes to make them all.
    """
    robots, ring = tours[hub].robots, tours[hub].vertices_m
    round_m = tour_length_m(tours[hub]) + max(tour_length_m(tours[k]) for k in petals)
    each = len(petals) // math.gcd(len(petals), robots)
    for i in range(robots):
        own = [petals[(i + k * robots) % len(petals)] for k in range(each)]
        rounds = [np.vstack([ring, tours[k].vertices_m]) for k in own]
        first = np.cumsum([0, *(len(way) for way in rounds[:-1])])
        yield replace(
            tours[hub],
            vertices_m=np.vstack(rounds),
            robots=1,
            period_s=min(tours[k].period_s for k in petals),
            nest=-1,
            pace=Pace(first=tuple(map(int, first)), rounds_m=(round_m,) * each, lead_m=-i * round_m / robots),
        )
