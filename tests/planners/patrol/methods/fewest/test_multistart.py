"""Of several full annealings those with the least shortfall go on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.planners.patrol.searching import YARD, search_on

from rota.planners.patrol.initial.allocation import period_groupings
from rota.planners.patrol.methods.fewest.team_size_plan import anneal_in_full
from rota.planners.patrol.settings import MultistartSettings


def test_those_with_the_least_shortfall_go_on() -> None:
    context = search_on(YARD)
    settings = replace(
        context.settings,
        multistart=MultistartSettings(allocations=2, seeds=3, kept=6),
        annealing=replace(context.settings.annealing, moves=1_000),
    )
    tours = [period_groupings(context.problem, 1)[0].with_robots([2]).tours]
    shortfalls_m = [each.shortfall_m for each in anneal_in_full(replace(context, settings=settings), tours, seed=4)]
    few = replace(settings, multistart=replace(settings.multistart, kept=2))
    kept = anneal_in_full(replace(context, settings=few), tours, seed=4)
    assert sorted(each.shortfall_m for each in kept) == sorted(shortfalls_m)[:2]


@pytest.mark.parametrize(("begun", "seeds", "count"), [(2, 1, 2), (1, 1, 1), (1, 3, 4), (2, 3, 4), (0, 3, 0)])
def test_annealings_differ_by_their_seeds_and_come_in_the_order_in_which_they_began(
    begun: int, seeds: int, count: int
) -> None:
    context = search_on(YARD)
    settings = replace(
        context.settings,
        multistart=MultistartSettings(allocations=2, seeds=seeds, kept=4),
        annealing=replace(context.settings.annealing, moves=1_000),
    )
    context = replace(context, settings=settings)
    grouping = period_groupings(context.problem, 1)[0]
    shared = [grouping.with_robots([robots]).tours for robots in (2, 3)[:begun]]
    searches = anneal_in_full(context, shared, seed=4)
    assert len(searches) == count
    shapes = {np.vstack([tour.vertices_m for tour in each.tours]).tobytes() for each in searches}
    assert len(shapes) == count
    again = anneal_in_full(context, shared, seed=4)
    assert [each.shortfall_m for each in again] == [each.shortfall_m for each in searches]
    if (begun, seeds) == (2, 1):
        assert [each.tours[0].robots for each in searches] == [2, 3]
