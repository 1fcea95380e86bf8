"""How often a team size is tried."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from tests.planners.patrol.searching import YARD, hasty_search_on

from rota.planners.patrol.context import Context
from rota.planners.patrol.initial.allocation import Allocation, allocations, period_groupings
from rota.planners.patrol.methods.fewest import team_size_plan
from rota.planners.patrol.methods.fewest.team_size_plan import plan_with_team_size, tries


@pytest.fixture(scope="module")
def quick() -> Context:
    return hasty_search_on(YARD)


@pytest.fixture(scope="module")
def candidates(quick: Context) -> list[Allocation]:
    groupings = period_groupings(quick.problem, 1)
    return allocations(quick.problem, groupings, 3, quick.settings.allocation, least_slack=1.0)


def with_corners(context: Context, reference: int) -> Context:
    """The search for which tours of so many corners are neither short nor long."""
    annealing = replace(context.settings.annealing, reference_corners=reference)
    return replace(context, settings=replace(context.settings, annealing=annealing))


def test_short_tours_are_tried_as_often_as_one_long_try_makes_moves(
    quick: Context, candidates: list[Allocation]
) -> None:
    corners = max(sum(len(tour.vertices_m) for tour in allocation.tours) for allocation in candidates)
    for reference, expected in ((corners // 2, 1), (2 * corners, 2), (3 * corners + 1, 3), (100 * corners, 4)):
        assert tries(with_corners(quick, reference), candidates) == expected


def test_what_is_tried_with_all_moves_is_tried_once(quick: Context, candidates: list[Allocation]) -> None:
    assert tries(quick.with_all_moves(), candidates) == 1


def test_without_allocations_nothing_is_tried(quick: Context) -> None:
    assert tries(quick, []) == 0
    groupings = period_groupings(quick.problem, 1)
    assert plan_with_team_size(quick, groupings, 3, least_slack=math.inf) is None


def test_every_try_has_seeds_of_its_own_and_the_first_plan_that_passes_is_taken(
    quick: Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    seeds: list[int] = []

    def passes_third(_context: Context, _searches: object, *, seed: int) -> str | None:
        seeds.append(seed)
        return "a plan" if len(seeds) == 3 else None

    monkeypatch.setattr(team_size_plan, "first_to_pass", passes_third)
    context = with_corners(quick, 10_000)
    found: object = plan_with_team_size(context, period_groupings(quick.problem, 1), 3, least_slack=1.0)
    assert found == "a plan"
    assert len(set(seeds)) == len(seeds) == 3


def test_who_stops_gets_no_other_try(quick: Context, monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[int] = []

    def fails(_context: Context, _searches: object, *, seed: int) -> None:
        tried.append(seed)

    monkeypatch.setattr(team_size_plan, "first_to_pass", fails)
    context = replace(with_corners(quick, 10_000), should_stop=lambda: len(tried) > 0)
    assert plan_with_team_size(context, period_groupings(quick.problem, 1), 3, least_slack=1.0) is None
    assert len(tried) == 1
