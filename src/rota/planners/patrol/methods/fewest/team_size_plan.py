"""A plan for one team size: allocations screened, the best annealed in full, then repaired in a race."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from rota.planners.patrol.annealing.schedule import anneal_all, anneal_shape, share_of_moves
from rota.planners.patrol.annealing.search import Annealed
from rota.planners.patrol.context import Context
from rota.planners.patrol.initial.allocation import Allocation, PeriodGrouping, allocations
from rota.planners.patrol.methods.fewest.racing import first_to_pass
from rota.planners.patrol.repair.repair import Repaired
from rota.planners.patrol.tours.tour import Tour

Candidate = TypeVar("Candidate")


def plan_with_team_size(
    context: Context, groupings: list[PeriodGrouping], robots: int, *, least_slack: float
) -> Repaired | None:
    """A plan with so many robots that the judge passes, or None.

    Few robots on short tours are tried several times: each try is short, and its outcome much a matter of chance.
    """
    settings = context.settings.allocation
    candidates = allocations(context.problem, groupings, robots, settings, least_slack=least_slack)
    turns = tries(context, candidates)
    for turn in range(turns):
        seed = context.seed + 1000 * robots + 7_000_000 * turn  # far from those of other tries and team sizes
        context.progress(turn / turns, f"trying {robots} robots")
        chosen = screen(context, candidates, seed=seed)
        context.progress((turn + 0.1) / turns, f"trying {robots} robots: annealing their tours")
        searches = anneal_in_full(context, chosen, seed=seed)
        context.progress((turn + 0.4) / turns, f"trying {robots} robots: repairing their tours")
        found = first_to_pass(context, searches, seed=seed)
        if found is not None or context.should_stop():
            return found
    return None


def tries(context: Context, candidates: list[Allocation]) -> int:
    """How often these allocations are tried: so often that all tries together make no more moves than a long one."""
    share = max((share_of_moves(context, allocation.tours) for allocation in candidates), default=math.inf)
    return min(context.settings.multistart.tries, max(1, int(1 / share))) if candidates else 0


def anneal_in_full(context: Context, begun: list[list[Tour]], *, seed: int) -> list[Annealed]:
    """The annealings with the least shortfall, in the order in which they were begun.

    begun: tours to begin with, the most promising first. Round after round begins with each of the first of them and
    with other seeds.
    """
    settings = context.settings.multistart
    few = min(len(begun), settings.allocations)
    if few == 0:
        return []
    turns = range(few if settings.seeds == 1 else settings.allocations * settings.seeds)

    def search(turn: int) -> Annealed:
        return context.run(anneal_shape, begun[turn % few], seed=seed + 100 * turn)

    with ThreadPoolExecutor(max_workers=context.threads) as pool:
        searches = list(pool.map(search, turns))
    best = sorted(turns, key=lambda turn: searches[turn].shortfall_m)[: settings.kept]
    return [searches[turn] for turn in sorted(best)]


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
