"""Full annealings of the most promising allocations, several of each; those with the least shortfall go on."""

from __future__ import annotations

import itertools
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

from rota.planners.patrol.annealing.schedule import anneal_shape
from rota.planners.patrol.annealing.search import Annealed
from rota.planners.patrol.context import Context
from rota.planners.patrol.tours.tour import Tour


def anneal_in_full(context: Context, begun: list[list[Tour]], *, seed: int) -> list[Annealed]:
    """The annealings with the least shortfall, in the order in which they were begun.

    begun: tours to begin with, the most promising first. Round after round begins with each of the first of them and
    with other seeds; the rounds take the weights of seeing in turn, since now this one, now that one gives the better
    shape. No weight is preferred: of each as many annealings go on.
    """
    settings = context.settings.multistart
    few = min(len(begun), settings.allocations)
    if few == 0:
        return []
    turns = range(few if settings.seeds == 1 else settings.allocations * settings.seeds)
    weights = settings.coverage_weights
    kind = [turn // few % len(weights) for turn in turns]

    def search(turn: int) -> Annealed:
        weight = weights[kind[turn]] * context.coverage_weight
        own = replace(context, coverage_weight=weight)
        return own.run(anneal_shape, begun[turn % few], seed=seed + 100 * turn)

    with ThreadPoolExecutor(max_workers=context.threads) as pool:
        searches = list(pool.map(search, turns))
    best = least_of_each([each.shortfall_m for each in searches], kind, settings.kept)
    return [searches[turn] for turn in sorted(best)]


def least_of_each(shortfalls_m: list[float], kind: list[int], most: int) -> list[int]:
    """The places of at most ``most`` of the least shortfalls (n,), of each kind (n,) as many as of the others.

    In turn the least of each kind, then the next of each, and so on; kinds that have no more are passed over.
    """
    nearest = sorted(range(len(kind)), key=shortfalls_m.__getitem__)
    by_kind = [[place for place in nearest if kind[place] == k] for k in sorted(set(kind))]
    best = [place for tie in itertools.zip_longest(*by_kind) for place in tie if place is not None]
    return best[:most]
