"""Mending: the least detour past a further place, whatever is looked at first; how near to it tours are asked to go."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box
from tests.planners.patrol.searching import cheap_search_on

from rota.check import check_plan
from rota.check.report import Report
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.model.plan import Plan
from rota.planners.patrol.ground.extra_points import no_points, prepare_with
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.planner_settings import Effort, PatrolSettings
from rota.planners.patrol.repair.bending.search import Bending
from rota.planners.patrol.repair.detours import least_detour
from rota.planners.patrol.repair.repair import bend, repair_until_feasible, shorter_m, with_tight_margin
from rota.planners.patrol.repair.seeing import lead_to_the_rest
from rota.planners.patrol.tours.tour import Tour, tour_length_m


@pytest.fixture(scope="module")
def problem() -> Problem:
    blocks = [box(x, y, x + 6, y + 6) for x in (4, 16, 28) for y in (4, 16)]
    return set_up_problem(
        Mission(
            name="yard",
            area=MultiPolygon([box(0, 0, 38, 26)]),
            obstacles=tuple(Obstacle(shape=MultiPolygon([block])) for block in blocks),
            period_s=30,
            fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=4)),
            planning=PatrolSettings(effort="quick"),
        )
    )


def test_the_least_detour_is_that_of_all_legs_looked_at(problem: Problem) -> None:
    rng = np.random.default_rng(5)
    places = rng.uniform((0, 0), (38, 26), (400, 2))
    places = places[shapely.intersects_xy(problem.space, *places.T)]
    tour, others = problem.paths.paths_along(places[:120]), places[120:180]
    assert len(tour) > 120
    for place in others:
        ways = problem.paths.distances(tour, place[None])[:, 0]
        legs = np.hypot(*(np.roll(tour, -1, axis=0) - tour).T)
        detours = ways + np.roll(ways, -1) - legs
        leg, detour = least_detour(problem, tour, place)
        assert detour == pytest.approx(detours.min(), abs=1e-9)
        assert detours[leg] == pytest.approx(detours.min(), abs=1e-9)


def test_no_way_is_no_detour(problem: Problem) -> None:
    assert least_detour(problem, np.array([[1.0, 1.0], [2.0, 1.0]]), np.array([7.0, 7.0]))[1] == np.inf


@pytest.fixture(scope="module")
def roomy_and_tight(problem: Problem) -> tuple[Tour, Tour]:
    """A tour that takes half of its budget, and one that takes all of it."""
    ring = np.array([[0.0, 0], [15, 0], [15, 15], [0, 15]])
    roomy = Tour(vertices_m=ring / 2, period_class=0, period_s=30, robots=1, robot=problem.robot, component=0)
    tight = Tour(vertices_m=ring, period_class=0, period_s=30, robots=1, robot=problem.robot, component=0)
    assert (tour_length_m(roomy), tour_length_m(tight), tight.budget_m) == pytest.approx((30, 60, 60), rel=0.01)
    return roomy, tight


def test_among_many_small_obstacles_detours_come_first_where_metres_count_and_legs_are_not_bent_besides(
    problem: Problem, roomy_and_tight: tuple[Tour, Tour], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("legs are bent")

    monkeypatch.setattr("rota.planners.patrol.repair.repair.see_the_rest", refuse)
    context, tours = cheap_search_on(problem), [roomy_and_tight[0]]
    points, samples = prepare_with(problem, no_points())

    def far_of(tours: list[Tour]) -> int:
        return len(Bending(problem, tours, samples, context.settings.bending).far_samples)

    for first in (True, False):
        repair = replace(context.settings.repair, bending_steps=0)
        bending = replace(context.settings.bending, length_weight=1.0 if first else 0.0)
        own = replace(
            context,
            problem=replace(problem, lanes_overlap_m=0.01),
            settings=replace(context.settings, repair=repair, bending=bending),
        )
        if first:
            longer = bend(own, tours, points, samples, seed=0)
            assert far_of(longer) == 0 < len(points) / 2 < far_of(tours)
        else:
            with pytest.raises(AssertionError, match="legs are bent"):
                bend(own, tours, points, samples, seed=0)


def test_tight_tours_are_asked_for_hardly_more_in_later_rounds(
    problem: Problem, roomy_and_tight: tuple[Tour, Tour]
) -> None:
    def asked(tour: Tour, *, bends: bool) -> list[float]:
        return [shorter_m(cheap_search_on(problem), [tour], turn, bends=bends) / problem.reach_m for turn in (1, 20)]

    roomy, tight = roomy_and_tight
    margin = problem.range_margin_m / problem.reach_m
    for tour in (roomy, tight):
        first, last = asked(tour, bends=False)
        assert (first, last) == pytest.approx((margin / 4, 5 * margin))
    assert asked(roomy, bends=True)[1] > asked(tight, bends=True)[1] > asked(tight, bends=True)[0]
    # all rounds together may take a tight tour no more than its range margin
    assert np.diff(asked(tight, bends=True))[0] < margin


def test_with_more_effort_tight_tours_keep_less_of_a_margin(
    problem: Problem, roomy_and_tight: tuple[Tour, Tour]
) -> None:
    roomy, tight = roomy_and_tight
    high = replace(problem, mission=problem.mission.with_effort("high"))
    assert with_tight_margin(cheap_search_on(problem), [tight]) == problem
    assert with_tight_margin(cheap_search_on(high), [roomy]) == high
    kept = with_tight_margin(cheap_search_on(high), [roomy, tight])
    assert 0 < kept.range_margin_m < problem.range_margin_m
    assert shorter_m(cheap_search_on(high), [tight], 1, bends=True) < shorter_m(
        cheap_search_on(problem), [tight], 1, bends=True
    )


@pytest.mark.parametrize(("effort", "rounds"), [("quick", 1), ("high", 3)])
def test_mending_goes_on_a_little_over_budget_and_looks_for_what_is_missed(effort: Effort, rounds: int) -> None:
    # a round of 40 m, for which there is time for 39.98 m
    ring = np.array([[2.0, 2], [12, 2], [12, 12], [2, 12]])
    period_s = 40 * 0.9995
    mission = Mission(
        name="room",
        area=MultiPolygon([box(0, 0, 14, 14)]),
        period_s=period_s,
        fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=8)),
        planning=PatrolSettings(effort=effort),
    )
    given = set_up_problem(mission)
    tour = Tour(vertices_m=ring, period_class=0, period_s=period_s, robots=1, robot=given.robot, component=0)
    asked_s: list[float] = []

    def judge(plan: Plan) -> Report:
        """Never content: it finds one place more missed every time."""
        assert plan.mission.period_s is not None
        asked_s.append(plan.mission.period_s)
        missed = np.column_stack([np.full(len(asked_s), 0.5), 0.5 + np.arange(len(asked_s))])
        return replace(
            check_plan(plan),
            verdict="violated",
            unmet_points_m=missed,
            unmet_demand=np.zeros(len(missed), dtype=np.int64),
            shown_unmet_m=np.zeros((0, 2)),
            shown_unmet_demand=np.zeros(0, dtype=np.int64),
        )

    context = cheap_search_on(given)
    unbent = replace(context.settings, repair=replace(context.settings.repair, bending_steps=0))
    found = repair_until_feasible(
        replace(context, judge=judge, settings=unbent), [tour], no_points(), may_add=False, rounds=3, annealed=True
    )
    assert not found.met
    assert found.plan.mission.period_s == period_s  # what is kept is the plan for what is asked
    assert len(found.extra) == sum(range(1, rounds + 1))
    assert len(asked_s) == rounds
    late_s = 40 * (1 + 1e-6)
    assert [one >= late_s for one in asked_s] == [effort == "high"] * rounds  # judged so that it is not late


def test_what_is_to_stop_is_judged_as_it_is() -> None:
    mission = Mission(
        name="room", area=MultiPolygon([box(0, 0, 14, 14)]), period_s=60.0,
        fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=2)), planning=PatrolSettings(effort="quick"),
    )  # fmt: skip
    given = set_up_problem(mission)
    ring = np.array([[2.0, 2], [12, 2], [12, 12], [2, 12]])
    tour = Tour(vertices_m=ring, period_class=0, period_s=60.0, robots=1, robot=given.robot, component=0)
    stopped = replace(cheap_search_on(given), should_stop=lambda: True)
    left = repair_until_feasible(stopped, [tour], no_points(), may_add=True, rounds=3)
    assert not left.met  # the middle is out of sight
    np.testing.assert_array_equal(left.tours[0].vertices_m, ring)
    assert lead_to_the_rest(stopped, [tour], given.points, given.samples, seed=0) == [tour]
