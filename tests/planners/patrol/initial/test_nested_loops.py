"""Loops within loops: their budgets and timetable in closed form, and a search that keeps them together."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TypedDict

import numpy as np
import pytest
from shapely import MultiPolygon, box
from tests.planners.patrol.annealing.test_annealing import assert_books_are_true

from rota.check import check_plan
from rota.model.mission import DiscSensor, Fleet, Mission, Zone
from rota.planners.patrol.annealing.search import Annealing
from rota.planners.patrol.efforts import EFFORTS, ESTIMATES
from rota.planners.patrol.ground.extra_points import no_points, prepare_with
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.initial.allocation import nested_allocations, nesting_bases, period_groupings
from rota.planners.patrol.initial.nested_loops import (
    excursions,
    nest_tours,
    petals_of,
    separate_petals,
    spare_m,
)
from rota.planners.patrol.repair.repair import plan_of
from rota.planners.patrol.settings import ExcursionEstimate
from rota.planners.patrol.tours.timetable import paced_timetable
from rota.planners.patrol.tours.tour import (
    Tour,
    excesses,
    hubs_and_petals,
    meeting,
    nests,
    over_budget_share,
    room_m,
    rounds_more,
    tour_length_m,
    unfold_nests,
)

USUAL = ESTIMATES[0]


class Loops(TypedDict):
    """How nested loops are asked for."""

    least_slack: float
    separate: bool
    estimate: ExcursionEstimate


def loops_of(least_slack: float, *, separate: bool = False) -> Loops:
    return {"least_slack": least_slack, "separate": separate, "estimate": USUAL}


@pytest.fixture(scope="module")
def problem() -> Problem:
    fleet = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=3.5))
    zone = Zone(name="gate", shape=MultiPolygon([box(2, 2, 10, 10)]), period_s=20)
    area = MultiPolygon([box(0, 0, 30, 12)])
    return set_up_problem(Mission(name="yard", area=area, zones=(zone,), period_s=60, fleet=fleet))


def ring(problem: Problem, corners_m: list[list[float]], **fields: object) -> Tour:
    values: dict[str, object] = {
        "period_class": 0,
        "period_s": 20.0,
        "robots": 1,
        "robot": problem.robot,
        "component": 0,
    }
    return Tour(vertices_m=np.array(corners_m, dtype=np.float64), **(values | fields))  # type: ignore[arg-type]


def nest(problem: Problem) -> list[Tour]:
    """A hub of 24 m, petals of 12, 16 and 0 m from its corner, and another tour."""
    slow = {"period_class": 1, "period_s": 60.0, "robots": 0, "nest": 4}
    return [
        ring(problem, [[9, 3], [3, 3], [3, 9], [9, 9]], nest=4),
        ring(problem, [[9, 3], [15, 3]], **slow),
        ring(problem, [[9, 3], [17, 3]], **slow),
        ring(problem, [[9, 3]], **slow),
        ring(problem, [[20, 3], [27, 3], [27, 9], [20, 9]], period_class=1, period_s=60.0),
    ]


def test_a_nest_is_one_robots(problem: Problem) -> None:
    tours = nest(problem)
    assert list(nests(tours)) == [[0, 1, 2, 3], [4]]
    hub, petals = hubs_and_petals(tours)
    assert hub.tolist() == [0, 0, 0, 0, 4]
    assert petals.tolist() == [[1, 4], [0, 0], [0, 0], [0, 0], [0, 0]]
    # 40 m a round, 120 m for all three of them
    assert [excess for excess, _ in excesses(tours)] == pytest.approx(
        [36 - 40, 40 - 40, 24 - 40, 100 - 120, 26 - 120], abs=1e-3
    )
    assert over_budget_share(tours) == pytest.approx(0, abs=1e-5)
    assert room_m(tours, 3) == pytest.approx(16, abs=1e-3)
    assert room_m(tours, 0) == pytest.approx(0, abs=1e-3)
    assert room_m(tours, 4) == pytest.approx(94, abs=1e-3)


def test_the_robot_goes_round_the_hub_between_its_excursions(problem: Problem) -> None:
    loop, other = unfold_nests(nest(problem))
    hub = [[9, 3], [3, 3], [3, 9], [9, 9]]
    assert loop.vertices_m.tolist() == [*hub, [9, 3], [15, 3], *hub, [9, 3], [17, 3]]
    assert tour_length_m(loop) == pytest.approx(2 * 24 + 12 + 16)  # the round with an empty petal is left out
    assert (loop.robots, loop.period_s, loop.nest) == (1, 60.0, -1)
    assert other.vertices_m.tolist() == nest(problem)[4].vertices_m.tolist()
    # what the hub alone sees of the gate is seen once in every round, the longest of which is 40 m at 2 m/s
    plan = plan_of(problem, nest(problem), seed=0)
    assert len(plan.trajectories) == 2
    assert plan.trajectories[0].loop_duration_s == pytest.approx(38, rel=1e-5)
    gate = next(d for d in check_plan(plan).demands if d.name == "gate")
    assert gate.outcome == "met"
    assert 15 < gate.worst_gap_at_least_s < 20


def test_a_hub_without_excursions_is_a_loop_of_its_own(problem: Problem) -> None:
    hub, *petals, _ = nest(problem)
    empty = [replace(petal, vertices_m=petal.vertices_m[:1]) for petal in petals]
    [loop] = unfold_nests([hub, *empty])
    assert loop.vertices_m.tolist() == hub.vertices_m.tolist()
    assert (loop.period_s, loop.nest) == (hub.period_s, -1)


def test_the_search_keeps_a_nest_together_and_within_its_rounds(problem: Problem) -> None:
    _, samples = prepare_with(problem, no_points())
    tours = nest(problem)[:4]
    search = Annealing(
        tours, samples, problem.paths.grid, length_weight=np.full(4, 0.3), budget_penalty=np.full(4, 6.0), seed=2,
        range_margin_m=problem.range_margin_m,
    )  # fmt: skip
    before = search.unseen_share
    assert search.run(60_000, hot_m=1.5, cold_m=0.02, should_stop=lambda: False)
    found = search.tours
    anchors = {tuple(tour.vertices_m[0].tolist()) for tour in found}
    assert len(anchors) == 1
    assert anchors != {(9.0, 3.0)}  # it moved, and all of them with it
    assert search.unseen_share < 0.7 * before
    assert over_budget_share(found) < 0.01


def test_petals_from_different_vertices_take_one_round_more(problem: Problem) -> None:
    slow = {"period_class": 1, "period_s": 60.0, "robots": 0, "nest": 4}
    tours = [
        ring(problem, [[9, 3], [3, 3], [3, 9], [9, 9]], nest=4),
        ring(problem, [[3, 9], [3, 11]], **slow),
        ring(problem, [[9, 3], [15, 3]], **slow),
    ]
    assert rounds_more(tours, [1, 2]) == 1
    assert rounds_more(nest(problem), [1, 2, 3]) == 0
    # 24 m of hub in every round, petals of 4 and 12 m, and 24 m more to come to both of them
    assert [excess for excess, _ in excesses(tours)] == pytest.approx([28 - 40, 36 - 40, 88 - 120], abs=1e-3)
    [loop] = unfold_nests(tours)
    from_first, from_third = [[9, 3], [3, 3], [3, 9], [9, 9]], [[3, 9], [9, 9], [9, 3], [3, 3]]
    first, third = [[9, 3], [15, 3]], [[3, 9], [3, 11]]
    on_to_first, on_to_third = [[3, 9], [9, 9]], [[9, 3], [3, 3]]
    expected = [*on_to_first, *from_first, *first, *on_to_third, *from_third, *third]
    assert loop.vertices_m.tolist() == expected
    assert tour_length_m(loop) == pytest.approx(88)
    # what only the hub sees of the gate waits for its longest round, 36 m at 2 m/s, and no longer
    gate = next(d for d in check_plan(plan_of(problem, tours, seed=0)).demands if d.name == "gate")
    assert gate.outcome == "met"
    assert gate.worst_gap_s <= 18.01


@pytest.mark.parametrize("seed", range(8))
def test_no_place_of_the_hub_waits_for_more_than_a_round_and_a_petal(problem: Problem, seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 9))
    hub = ring(problem, rng.uniform(0, 10, (n, 2)).tolist(), nest=0)
    petals = [
        ring(problem, [hub.vertices_m[rng.integers(n)].tolist(), *rng.uniform(0, 10, (2, 2)).tolist()], nest=0)
        for _ in range(int(rng.integers(1, 6)))
    ]
    [loop] = unfold_nests([hub, *petals])
    hub_m, petals_m = tour_length_m(hub), [tour_length_m(petal) for petal in petals]
    more = rounds_more([hub, *petals], range(1, 1 + len(petals)))
    assert more == (len({meeting(hub.vertices_m, petal.vertices_m) for petal in petals}) > 1)
    whole_m = (len(petals) + more) * hub_m + sum(petals_m)
    assert tour_length_m(loop) == pytest.approx(whole_m)
    # when the robot passes each vertex of the hub, wherever in its loop
    legs_m = np.hypot(*(np.roll(loop.vertices_m, -1, axis=0) - loop.vertices_m).T)
    at_m = np.concatenate([[0.0], np.cumsum(legs_m)[:-1]])
    for vertex in hub.vertices_m:
        passed_m = at_m[(loop.vertices_m == vertex).all(axis=1)]
        assert np.diff([*passed_m, passed_m[0] + whole_m]).max() <= hub_m + max(petals_m) + 1e-9


def test_petals_find_their_own_vertices_of_the_hub(problem: Problem) -> None:
    _, samples = prepare_with(problem, no_points())
    tours = nest(problem)[:4]
    tours[2] = replace(tours[2], vertices_m=np.array([[3.0, 9.0], [12.0, 10.0]]))
    begins: list[list[int]] = []
    for seed in (1, 2, 3):
        search = Annealing(
            tours, samples, problem.paths.grid,
            length_weight=np.full(4, 0.3), budget_penalty=np.full(4, 6.0), seed=seed,
            range_margin_m=problem.range_margin_m,
        )  # fmt: skip
        before = search.unseen_share
        assert search.run(60_000, hot_m=1.5, cold_m=0.02, should_stop=lambda: False)
        assert search.unseen_share < 0.7 * before
        assert over_budget_share(search.tours) < 0.01
        assert_books_are_true(search)
        hub, *petals = search.tours
        # each of them begins at a vertex of the hub: where it does not, there is none to be found
        begins.append([meeting(hub.vertices_m, petal.vertices_m) for petal in petals])
    assert max(len(set(one)) for one in begins) > 1
    assert len({tuple(one) for one in begins}) > 1


def test_spare_metres_by_hand(problem: Problem) -> None:
    hub = nest(problem)[0]
    # three rounds of 40 m less 1.15 x 20 m, four fifths of which are spent on the ground
    assert spare_m(hub, 20.0, 60.0, USUAL) == pytest.approx(0.8 * 3 * (40 - 23), rel=1e-4)
    # one round only: a longer tour, and no excursion
    assert petals_of(hub, 39.0) == 0
    assert spare_m(hub, 20.0, 39.0, USUAL) == pytest.approx(0.8 * (40 - 23), rel=1e-4)
    # two robots have 80 m for each of their rounds, and still begin one every 20 s
    assert spare_m(replace(hub, robots=2), 20.0, 60.0, USUAL) == pytest.approx(0.8 * 3 * (80 - 23), rel=1e-4)
    assert spare_m(hub, 60.0, 60.0, USUAL) == 0


def test_metres_for_petals_from_different_vertices_by_hand(problem: Problem) -> None:
    hub = nest(problem)[0]
    # hub rounds of 1.15 x 20 = 23 m: two petals have 17 m each, for 120 m less three rounds leave 51; three have 28
    petals, metres = separate_petals(hub, 20.0, 60.0, 1.15)
    assert (petals, metres) == (2, pytest.approx(34, rel=1e-4))
    # with rounds of 11.5 m three petals have 28.5 m each, and 120 m less four rounds are 74 m; two have 57
    assert separate_petals(hub, 10.0, 60.0, 1.15) == (3, pytest.approx(74, rel=1e-4))
    assert separate_petals(hub, 10.0, 39.0, 1.15) == (0, 0.0)  # time for one round
    assert separate_petals(replace(hub, robots=2), 10.0, 60.0, 1.15) == (0, 0.0)  # these keep in step
    # 0.95 x 74 m are worth it beside 0.8 x 3 x 28.5, 0.95 x 34 m beside 0.8 x 3 x 17 as well
    assert excursions(hub, 10.0, 60.0, USUAL, separate=True)[1:] == (pytest.approx(0.95 * 74, rel=1e-4), True)
    assert excursions(hub, 20.0, 60.0, USUAL, separate=True)[0] == 2
    assert excursions(hub, 10.0, 60.0, USUAL, separate=False)[1:] == (spare_m(hub, 10.0, 60.0, USUAL), False)


def test_metres_of_excursions_as_generously_as_the_estimate_says(problem: Problem) -> None:
    hub, generous = nest(problem)[0], ExcursionEstimate(hub_detour=0.5, travel_share=0.6)
    # rounds of 0.5 x 20 m leave 30 m, of which excursions from one vertex spend three fifths on their ground
    assert spare_m(hub, 20.0, 60.0, generous) == pytest.approx(0.6 * 3 * 30, rel=1e-4)
    # four rounds of 10 m leave 80 of 120 m for three that begin elsewhere; they spend a fifth more or so
    assert separate_petals(hub, 20.0, 60.0, 0.5) == (3, pytest.approx(80, rel=1e-4))
    spent = excursions(hub, 20.0, 60.0, generous, separate=True)
    assert spent == (3, pytest.approx(0.6 * 0.95 / 0.8 * 80, rel=1e-4), True)


@pytest.mark.parametrize("robots", [2, 3, 4])
def test_robots_of_one_hub_begin_its_rounds_in_turn(problem: Problem, robots: int) -> None:
    hub, *petals, _ = nest(problem)
    loops = unfold_nests([replace(hub, robots=robots), *petals])
    assert [loop.robots for loop in loops] == [1] * robots
    # a round takes as long as the longest: 24 + 16 m; three petals come round after three rounds of the whole hub
    starts_s: list[float] = []
    far_s: list[float] = []
    rounds = 3 // math.gcd(3, robots)
    for loop in loops:
        assert loop.pace is not None
        times, places, _ = paced_timetable(loop.vertices_m, problem.robot, loop.pace)
        assert times[-1] == pytest.approx(rounds * 20, rel=1e-5)
        assert (np.hypot(*np.diff(places, axis=0).T) <= 2 * np.diff(times) * (1 + 1e-9)).all()
        starts_s += times[:-1][(places[:-1] == [3, 9]).all(axis=1)].tolist()  # once a round of the hub
        far_s += times[:-1][(places[:-1] == [17, 3]).all(axis=1)].tolist()  # the end of one petal
    whole_s = rounds * 20 * (1 + 1e-6)
    assert len(starts_s) == robots * rounds
    assert np.diff(np.sort([*starts_s, min(starts_s) + whole_s])) == pytest.approx(20 / robots, abs=1e-3)
    assert len(far_s) == robots * rounds // 3
    assert np.diff(np.sort([*far_s, min(far_s) + whole_s])) == pytest.approx(3 * 20 / robots, abs=1e-3)


def test_excursions_take_the_slow_ground_next_to_their_hub(problem: Problem) -> None:
    grouping = next(grouping for grouping in period_groupings(problem, 4) if len(grouping.tours) == 2)
    one_each = [replace(t, robots=1) for t in grouping.tours]
    found = nest_tours(
        problem, grouping.groups, one_each, grouping.ideal_m, least_slack=1.0, separate=False, estimate=USUAL
    )
    assert found is not None
    slack, tours = found
    spare = spare_m(one_each[0], grouping.ideal_m[0], 60.0, USUAL)
    assert slack == pytest.approx((one_each[1].budget_m + spare) / grouping.ideal_m[1])
    assert (
        nest_tours(
            problem,
            grouping.groups,
            one_each,
            grouping.ideal_m,
            least_slack=1.01 * slack,
            separate=False,
            estimate=USUAL,
        )
        is None
    )
    hub, *petals, slow = tours
    assert [tour.nest for tour in tours] == [0, 0, 0, 0, -1]
    assert all((petal.vertices_m[0] == hub.vertices_m[0]).all() for petal in petals)
    assert (hub.period_class, slow.period_class, slow.robots) == (0, 1, 1)
    nearest = min(petal.vertices_m[:, 0].max() for petal in petals)
    assert nearest < slow.vertices_m[:, 0].max()


def test_separate_excursions_begin_where_their_ground_is(problem: Problem) -> None:
    grouping = next(grouping for grouping in period_groupings(problem, 4) if len(grouping.tours) == 2)
    one_each = [replace(t, robots=1) for t in grouping.tours]
    found = nest_tours(problem, grouping.groups, one_each, grouping.ideal_m, **loops_of(1.0, separate=True))
    assert found is not None
    slack, (hub, *petals, _) = found
    count, spare = separate_petals(one_each[0], grouping.ideal_m[0], 60.0, 1.15)
    assert slack == pytest.approx((one_each[1].budget_m + 0.95 * spare) / grouping.ideal_m[1])
    assert len(petals) == count
    for petal in petals:
        away_m = np.hypot(*(hub.vertices_m - petal.vertices_m[1:].mean(axis=0)).T)
        own = meeting(hub.vertices_m, petal.vertices_m)
        assert away_m[own] < away_m.min() + problem.swath_m  # as near as any vertex is, but for the way there
    # where they cannot: robots that keep in step
    two = [replace(grouping.tours[0], robots=2), one_each[1]]
    assert nest_tours(problem, grouping.groups, two, grouping.ideal_m, **loops_of(1.0, separate=True)) is None


def test_quick_ground_with_two_robots_gives_one_hub_or_two(problem: Problem) -> None:
    grouping = next(grouping for grouping in period_groupings(problem, 4) if len(grouping.tours) == 2)
    quick_m = replace(grouping.tours[0], robots=1).budget_m
    # the gate takes a robot and a half, which three robots would share with the rest as their loads are: one and two
    grouping = replace(grouping, ideal_m=[1.2 * quick_m, 2.1 * replace(grouping.tours[1], robots=1).budget_m])
    first, second, third = nesting_bases(problem, grouping, [1, 2], 3)
    assert [tour.robots for tour in first.tours] == [1, 2]
    assert [(tour.period_class, tour.robots) for tour in second.tours] == [(0, 2), (1, 1)]
    assert [(tour.period_class, tour.robots) for tour in third.tours] == [(0, 1), (0, 1), (1, 1)]
    assert third.ideal_m[0] + third.ideal_m[1] == pytest.approx(1.2 * quick_m)
    assert third.ideal_m[2] == grouping.ideal_m[1]
    # with two robots nothing would be left for the rest
    assert len(nesting_bases(problem, grouping, [1, 1], 2)) == 1


def test_quick_ground_that_takes_no_sweeping_may_have_a_nest_too(problem: Problem) -> None:
    # a zone that is visited, say: no budget can be too tight for its lanes
    grouping = next(grouping for grouping in period_groupings(problem, 4) if len(grouping.tours) == 2)
    one_each = [replace(t, robots=1) for t in grouping.tours]
    visited = replace(grouping, tours=one_each, ideal_m=[0.0, grouping.ideal_m[1]])
    [allocation] = nested_allocations(problem, [visited], EFFORTS["quick"].allocation, least_slack=1.0)
    found = nest_tours(problem, visited.groups, one_each, visited.ideal_m, **loops_of(1.0))
    assert found is not None
    assert allocation.slack == found[0]


def test_every_estimate_gives_a_nest_of_its_own(problem: Problem) -> None:
    grouping = next(grouping for grouping in period_groupings(problem, 4) if len(grouping.tours) == 2)
    # so much slow ground that no excursions sweep it all
    base = replace(grouping, tours=[replace(t, robots=1) for t in grouping.tours], ideal_m=[grouping.ideal_m[0], 200.0])
    [usual] = nested_allocations(problem, [base], EFFORTS["quick"].allocation, least_slack=0.1)
    settings = replace(EFFORTS["quick"].allocation, estimates=ESTIMATES[:3])
    found = list(nested_allocations(problem, [base], settings, least_slack=0.1))
    assert len(found) == 6  # from one vertex, then from several
    assert all(allocation.nested for allocation in found)
    assert [tour.vertices_m.tolist() for tour in found[0].tours] == [t.vertices_m.tolist() for t in usual.tours]
    # what an estimate promises is what its excursions are handed, and the slow tour is left with the rest
    spare = [spare_m(base.tours[0], base.ideal_m[0], 60.0, estimate) for estimate in settings.estimates]
    left = [len(allocation.tours[-1].vertices_m) for allocation in found[:3]]
    assert left[np.argmax(spare)] < left[np.argmin(spare)]


def test_no_nest_where_the_slow_ground_is_one_place(problem: Problem) -> None:
    grouping = next(grouping for grouping in period_groupings(problem, 4) if len(grouping.tours) == 2)
    one_place = replace(grouping.groups[1], places=grouping.groups[1].places[:1])
    one_each = [replace(t, robots=1) for t in grouping.tours]
    assert (
        nest_tours(
            problem,
            [grouping.groups[0], one_place],
            one_each,
            grouping.ideal_m,
            least_slack=1.0,
            separate=False,
            estimate=USUAL,
        )
        is None
    )
