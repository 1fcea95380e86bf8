"""More effort begins with what the lesser efforts find, on a coarser lattice, and never takes more robots."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
from shapely import MultiPolygon, box
from tests.planners.patrol.searching import YARD, search_on

from rota.check import check_plan
from rota.errors import NoPlanFound
from rota.model.mission import Mission, Zone
from rota.model.plan import Plan
from rota.planners.patrol import context as context_module, planner as planner_module
from rota.planners.patrol.bounds.best_bound import prove_bound
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.context import Context
from rota.planners.patrol.efforts import EFFORTS
from rota.planners.patrol.ground import problem as problem_module
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.initial.allocation import period_groupings, slack_factor
from rota.planners.patrol.methods.fewest import search as search_module
from rota.planners.patrol.methods.fewest.search import (
    fewest_robots,
    reduce_team,
    search_upwards,
    with_less_effort,
    without_spare_robots,
)
from rota.planners.patrol.methods.fewest.team_sizes import most_slack
from rota.planners.patrol.planner import plan_tours
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.repair import Repaired
from rota.planners.patrol.verdict import Judge, Verdict
from rota.planning.planner import Request


def test_less_effort_keeps_the_bound_and_lays_a_coarser_lattice() -> None:
    normal = replace(search_on(YARD.with_effort("normal")), bound=ProvedBound(robots=7, reason="so"), enough_robots=9)
    quick = with_less_effort(normal, "quick")
    assert quick.problem.spacing_m == pytest.approx(1.5 * normal.problem.spacing_m)
    assert quick.settings == EFFORTS["quick"] != normal.settings
    assert (quick.bound, quick.enough_robots) == (normal.bound, 9)


@pytest.fixture(scope="module")
def first() -> Repaired:
    """The quick search's plan."""
    return fewest_robots(search_on(YARD))


def test_more_effort_is_spent_only_while_fewer_robots_may_do(first: Repaired) -> None:
    told: list[float] = []
    normal = search_on(YARD.with_effort("normal"))
    found = fewest_robots(replace(normal, progress=lambda share, _what: told.append(share)))
    # two robots are the bound, and the least effort, the first half of the search, finds them
    assert (found.robots, found.plan.lower_bound_robots) == (2, 2)
    assert found.plan.mission == normal.problem.mission
    assert [tour.vertices_m.tolist() for tour in found.tours] == [tour.vertices_m.tolist() for tour in first.tours]
    assert 0 < max(told) < 0.5


def test_robots_are_given_up_only_where_enough_slack_is_left(first: Repaired) -> None:
    told: list[str] = []
    context = search_on(YARD)
    groupings = period_groupings(context.problem, 1)
    more = replace(first, tours=[replace(first.tours[0], robots=first.robots + 2), *first.tours[1:]])
    assert without_spare_robots(context, groupings, more, 1).robots == first.robots

    def tell(_share: float, what: str) -> None:
        told.append(what)

    asks_more = replace(context.settings.allocation, least_slack=50.0)
    picky = replace(context, progress=tell, settings=replace(context.settings, allocation=asks_more))
    assert without_spare_robots(picky, groupings, more, 1) is more
    assert not told


def test_a_slack_factor_is_never_more_than_what_is_known_without_tours() -> None:
    """One period: the budgets of all robots over ideal lanes; two: that hangs on who drives where."""
    problem = search_on(YARD).problem
    grouping = period_groupings(problem, 1)[0]
    for robots in (1, 2, 5):
        assert most_slack(problem, robots) == pytest.approx(slack_factor(grouping.with_robots([robots])), rel=2e-6)
        # by hand: 2 m/s for 60 s, and lanes of 4 m over 600 m2 less a block of 16
        assert most_slack(problem, robots) == pytest.approx(robots * 120 / (584 / 4))
    zone = Zone(name="zone", shape=MultiPolygon([box(20, 10, 28, 18)]), period_s=30)
    assert most_slack(search_on(replace(YARD, zones=(zone,))).problem, 2) == math.inf
    hardly_moves = replace(YARD, period_s=6)  # 12 m, less than once round a disc
    assert most_slack(search_on(hardly_moves).problem, 30) == math.inf


def test_no_tours_are_laid_where_a_robot_fewer_is_surely_too_few(
    first: Repaired, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise AssertionError("tours are laid")

    monkeypatch.setattr("rota.planners.patrol.methods.fewest.search.period_groupings", refuse)
    context = replace(search_on(YARD), enough_robots=1)
    # 0.82 with one robot less
    assert reduce_team(context, first) is first
    asks_less = replace(context.settings.allocation, least_slack=0.8)
    for other in (
        replace(context, settings=replace(context.settings, allocation=asks_less)),
        replace(context, enough_robots=-1),  # a likely team size may be far less
    ):
        with pytest.raises(AssertionError, match="tours are laid"):
            reduce_team(other, first)


def never_content(plan: Plan) -> Verdict:
    return replace(check_plan(plan), verdict="violated")


def hasty(context: Context) -> Context:
    """The search with hardly any moves, and a judge whom nothing suits."""
    settings = replace(
        EFFORTS["quick"],
        screening=replace(EFFORTS["quick"].screening, moves=10),
        annealing=replace(EFFORTS["quick"].annealing, moves=10),
    )
    return replace(context, settings=settings, judge=never_content)


def test_the_best_of_less_effort_is_kept_when_more_finds_no_better(first: Repaired) -> None:
    assert reduce_team(replace(hasty(search_on(YARD)), enough_robots=1), first) is first


@pytest.mark.parametrize(
    ("likely", "known", "passes", "tried", "robots"),
    [
        (2, 5, 4, [2, 3, 4], 4),  # the last one downwards: upwards two sizes are tried
        (2, 5, 5, [2, 3, 4], 5),
        (16, 30, 17, [16, 17], 17),
        (16, 30, 18, [16, 17, 29, 28, 27, 26, 25, 24, 23, 22, 21, 20, 19, 18], 18),
        (16, 30, 28, [16, 17, 29, 28, 27], 28),
    ],
)
def test_no_team_size_between_one_that_fails_and_the_plan_is_left_out(
    monkeypatch: pytest.MonkeyPatch,
    first: Repaired,
    likely: int,
    known: int,
    passes: int,
    tried: list[int],
    robots: int,
) -> None:
    sizes: list[int] = []

    def of(count: int) -> Repaired:
        return replace(first, tours=[replace(first.tours[0], robots=count)])

    def plan_with(_context: Context, _groupings: object, count: int, **_: float) -> Repaired | None:
        sizes.append(count)
        return of(count) if count >= passes else None

    monkeypatch.setattr(search_module, "plan_with_team_size", plan_with)
    monkeypatch.setattr(search_module, "sure_team_size", lambda _groupings: 1)
    found = search_upwards(search_on(YARD), [], likely, of(known))
    assert (sizes, found.robots) == (tried, robots)


def test_fewer_robots_on_ragged_ground_are_looked_for_where_the_settings_say_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(problem_module, "MOST_DENSE", 0)
    told: list[str] = []
    ragged = replace(search_on(YARD), progress=lambda _share, what: told.append(what))
    assert ragged.problem.is_ragged
    found = reduce_team(ragged, None)
    assert check_plan(found.plan).verdict == "met"
    assert not any("trying" in what for what in told)
    searches = replace(EFFORTS["quick"], team_size=replace(EFFORTS["quick"].team_size, searches_ragged=True))
    reduce_team(replace(ragged, settings=searches, should_stop=lambda: any("trying" in what for what in told)), None)
    assert any("trying" in what for what in told)


def test_over_ragged_ground_the_bound_is_proved_once_there_are_first_tours(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(problem_module, "MOST_DENSE", 0)
    problem = problem_module.set_up_problem(YARD)
    told: list[str] = []
    proofs: list[str] = []

    def prove(of: Problem, **values: Any) -> ProvedBound:
        proofs.extend(told[-1:])
        return prove_bound(of, **values)

    monkeypatch.setattr(context_module, "prove_bound", prove)
    asked = Request(
        mission=YARD, seed=0, judge=check_plan, progress=lambda _share, what: told.append(what),
        should_stop=lambda: False,
    )  # fmt: skip
    plans = plan_tours(YARD, asked=asked, judge=check_plan)
    assert proofs == ["finishing with the robots that surely suffice"]
    best = prove_bound(problem)
    assert [(plan.lower_bound_robots, plan.lower_bound_reason) for plan in plans] == [(best.robots, best.reason)]
    assert best.robots > 1


def set_up_for(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Scanned ground even where it is small; told from now on the effort of each mission that is set up."""
    monkeypatch.setattr(problem_module, "MOST_DENSE", 0)
    monkeypatch.setattr(planner_module, "MANY_CORNERS", 0)
    efforts: list[str] = []

    def set_up(mission: Mission, **asked: Any) -> Problem:
        efforts.append(PatrolSettings.of(mission).effort)
        return problem_module.set_up_problem(mission, **asked)

    monkeypatch.setattr(planner_module, "set_up_problem", set_up)
    return efforts


def planned(mission: Mission, judge: Judge) -> Plan:
    """The plan for a mission without starts."""
    asked = Request(
        mission=mission, seed=0, judge=check_plan, progress=lambda _share, _what: None, should_stop=lambda: False
    )
    [plan] = plan_tours(mission, asked=asked, judge=judge)
    return plan


def test_more_effort_over_scanned_ground_gives_what_quick_finds_and_sets_up_nothing_finer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    efforts = set_up_for(monkeypatch)
    normal = YARD.with_effort("normal")
    plan = planned(normal, check_plan)
    assert efforts == ["quick"]
    assert plan.mission is normal
    quick = planned(YARD, check_plan)
    assert [t.positions_m.tolist() for t in plan] == [t.positions_m.tolist() for t in quick]
    assert plan.lower_bound_robots == quick.lower_bound_robots


@pytest.mark.slow  # a scanned floor by two efforts
def test_more_effort_over_scanned_ground_goes_on_where_quick_finds_no_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    efforts = set_up_for(monkeypatch)
    plan = planned(
        YARD.with_effort("normal"), lambda plan: (check_plan if "normal" in efforts else never_content)(plan)
    )
    assert efforts == ["quick", "normal"]
    assert check_plan(plan).verdict == "met"


def test_scanned_ground_for_many_robots_is_set_up_as_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    efforts = set_up_for(monkeypatch)
    busy = replace(YARD.with_effort("normal"), period_s=5.0)
    asked = Request(
        mission=busy, seed=0, judge=check_plan, progress=lambda _share, _what: None, should_stop=lambda: True
    )
    with pytest.raises(NoPlanFound):
        plan_tours(busy, asked=asked, judge=never_content)
    assert efforts[:2] == ["quick", "normal"]


def test_a_stop_on_ragged_ground_ends_the_search_after_the_first_tours(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(problem_module, "MOST_DENSE", 0)
    told: list[str] = []
    context = hasty(replace(search_on(YARD), progress=lambda _share, what: told.append(what)))
    stopped = replace(context, should_stop=lambda: any("surely suffice" in what for what in told))
    found = reduce_team(stopped, None)
    assert not found.met
    assert not any("trying" in what for what in told)
