"""Of several full annealings those with the least shortfall go on, as many of each weight of seeing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.planners.patrol.searching import YARD, search_on

from rota.planners.patrol.initial.allocation import period_groupings
from rota.planners.patrol.methods.fewest.multistart import anneal_in_full, least_of_each
from rota.planners.patrol.settings import MultistartSettings


@pytest.mark.parametrize(
    ("shortfalls_m", "kind", "most", "expected"),
    [
        ([5.0, 9.0], [0, 0], 2, [0, 1]),
        ([9.0, 5.0, 1.0], [0, 0, 0], 2, [2, 1]),
        # of each kind as many, even where all of one are nearer than any of the other
        ([1.0, 2.0, 3.0, 7.0, 9.0, 8.0], [0, 0, 0, 1, 1, 1], 4, [0, 3, 1, 5]),
        ([1.0, 2.0, 3.0, 7.0], [0, 0, 0, 1], 4, [0, 3, 1, 2]),
        ([], [], 3, []),
    ],
)
def test_of_each_kind_the_least_shortfalls_go_on(
    shortfalls_m: list[float], kind: list[int], most: int, expected: list[int]
) -> None:
    assert least_of_each(shortfalls_m, kind, most) == expected


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
