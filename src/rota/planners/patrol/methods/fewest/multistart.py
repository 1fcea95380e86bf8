"""Full annealings of the most promising allocations, several of each; those with the least shortfall go on."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

from rota.planners.patrol.annealing.schedule import anneal_shape
from rota.planners.patrol.annealing.search import Annealed
from rota.planners.patrol.context import Context
from rota.planners.patrol.tours.tour import Tour


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
