"""Screening: all allocations of a team size are annealed a little, and the most promising go on."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar

from rota.planners.patrol.annealing.schedule import anneal_all
from rota.planners.patrol.context import Context
from rota.planners.patrol.initial.allocation import Allocation
from rota.planners.patrol.tours.tour import Tour

Candidate = TypeVar("Candidate")


def screen(context: Context, candidates: list[Allocation], *, seed: int) -> list[list[Tour]]:
    """The tours of the allocations after a little annealing, the least shortfall first.

    Allocations that leave too much unseen are dropped. Nested loops take longer to find their shape, which their own
    limits allow for. A single allocation is not annealed.
    """
    if len(candidates) < 2:
        return [allocation.tours for allocation in candidates]
    settings = context.settings.screening
    half = (settings.allocations + 1) // 2
    nested = [allocation for allocation in candidates if allocation.nested]
    nested = choose_nested(context, nested[: max(half, settings.nested_allocations)], half, seed=seed)
    candidates = [*[allocation for allocation in candidates if not allocation.nested][:half], *nested]
    is_thorough = context.settings.multistart.is_thorough
    searches = anneal_all(
        context, [allocation.tours for allocation in candidates],
        moves=settings.moves, seed=seed, coarse=is_thorough,
    )  # fmt: skip
    ranked: list[tuple[float, list[Tour]]] = []
    for allocation, search in zip(candidates, searches, strict=True):
        limit = settings.nested_unseen_limit if allocation.nested else settings.unseen_limit
        if search.unseen_share <= limit:
            ranked.append((search.shortfall_m, search.tours))
    ranked.sort(key=lambda pair: pair[0])
    least_m = min((shortfall_m for shortfall_m, _ in ranked), default=0.0)
    most_m = settings.multistart_limit * least_m if is_thorough else math.inf
    return [tours for shortfall_m, tours in ranked if shortfall_m <= most_m]


def choose_nested(context: Context, nested: list[Allocation], most: int, *, seed: int) -> list[Allocation]:
    """At most this many of the nested loops, those that do best in annealings shorter than that of the screening."""

    def shortfalls_m(candidates: list[Allocation], halvings: int) -> list[float]:
        moves = context.settings.screening.moves >> halvings
        tours = [allocation.tours for allocation in candidates]
        return [search.shortfall_m for search in anneal_all(context, tours, moves=moves, seed=seed, coarse=True)]

    return successive_halving(nested, most, shortfalls_m)


def successive_halving(
    candidates: list[Candidate], most: int, shortfalls: Callable[[list[Candidate], int], list[float]]
) -> list[Candidate]:
    """At most this many of the candidates: of each round the better half goes on to the next.

    shortfalls: of the candidates of a round, which makes an effort halved so many times: once in the last round, twice
    in the one before, and so on.
    """
    rounds = max(0, math.ceil(math.log2(len(candidates) / most))) if candidates else 0
    for halvings in range(rounds, 0, -1):
        lacks = shortfalls(candidates, halvings)
        order = sorted(range(len(candidates)), key=lacks.__getitem__)
        candidates = [candidates[k] for k in order[: max(most, (len(candidates) + 1) // 2)]]
    return candidates
