"""Screening keeps the most promising allocations: in every round the better half, then those near the best."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tests.planners.patrol.searching import YARD, search_on

from rota.planners.patrol.context import Context
from rota.planners.patrol.initial.allocation import Allocation, allocations, period_groupings
from rota.planners.patrol.methods.fewest.team_size_plan import screen, successive_halving


@pytest.mark.parametrize(
    ("count", "most", "rounds"),
    [
        (8, 8, []),
        (9, 8, [(9, 1)]),
        (13, 2, [(13, 3), (7, 2), (4, 1)]),  # the better half goes on, to an effort twice as large
        (0, 8, []),
    ],
)
def test_of_many_candidates_the_better_half_goes_on(count: int, most: int, rounds: list[tuple[int, int]]) -> None:
    made: list[tuple[int, int]] = []

    def shortfalls(candidates: list[int], halvings: int) -> list[float]:
        made.append((len(candidates), halvings))
        return [7 * k % 13 for k in candidates]

    kept = successive_halving(list(range(count)), most, shortfalls)
    assert made == rounds
    best = sorted(range(count), key=lambda k: 7 * k % 13)[:most]
    assert kept == (best if rounds else list(range(count)))


@pytest.fixture(scope="module")
def quick() -> Context:
    return with_limits(search_on(YARD), moves=20_000)  # of which small tours make a tenth


@pytest.fixture(scope="module")
def candidates(quick: Context) -> list[Allocation]:
    """Two ways to share the yard among three robots: one tour, and three."""
    groupings = period_groupings(quick.problem, 4)
    found = allocations(quick.problem, groupings, 3, quick.settings.allocation, least_slack=0.5)
    assert sorted(len(allocation.tours) for allocation in found) == [1, 3]
    return found


def with_limits(context: Context, **limits: float) -> Context:
    screening = replace(context.settings.screening, **limits)  # type: ignore[arg-type]
    return replace(context, settings=replace(context.settings, screening=screening))


def test_what_leaves_too_much_unseen_is_dropped(quick: Context, candidates: list[Allocation]) -> None:
    assert screen(with_limits(quick, unseen_limit=-1.0), candidates, seed=3) == []
    assert len(screen(with_limits(quick, unseen_limit=1.0), candidates, seed=3)) == 2


def test_nested_loops_have_a_limit_of_their_own(quick: Context, candidates: list[Allocation]) -> None:
    shared = next(allocation for allocation in candidates if len(allocation.tours) == 1)
    both = [replace(shared, nested=True), *[each for each in candidates if each is not shared]]
    alone = screen(with_limits(quick, unseen_limit=-1.0, nested_unseen_limit=1.0), both, seed=3)
    assert [len(tours) for tours in alone] == [1]


def test_with_several_seeds_only_those_near_the_best_go_on(quick: Context, candidates: list[Allocation]) -> None:
    for seeds, limit, count in ((1, 1.0, 2), (2, 1.0, 1), (2, 1e6, 2)):
        context = with_limits(quick, unseen_limit=1.0, multistart_limit=limit)
        multistart = replace(context.settings.multistart, seeds=seeds)
        context = replace(context, settings=replace(context.settings, multistart=multistart))
        assert len(screen(context, candidates, seed=3)) == count
