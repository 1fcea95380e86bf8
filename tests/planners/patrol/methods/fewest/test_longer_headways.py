"""Robots on a shared tour that follow each other in more than a period."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from shapely import MultiPolygon, box
from tests.planners.patrol.searching import YARD, search_on

from rota.check import check_plan
from rota.errors import NoPlanFound
from rota.model.mission import DiscSensor, Obstacle, SquareSensor, Zone
from rota.planners.patrol.context import Context
from rota.planners.patrol.efforts import EARLY
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.methods.fewest import longer_headways
from rota.planners.patrol.methods.fewest.longer_headways import (
    least_lacking_m,
    mission_with_longer_headways,
    on_other_terms,
    reaching_less,
    with_longer_headways,
    with_time_in_sight,
)
from rota.planners.patrol.methods.sweeping.first_plan import sweep
from rota.planners.patrol.repair.repair import Repaired
from rota.planners.patrol.shortening.search import with_better_loops
from rota.planners.patrol.tours.tour import tour_length_m

FAR = replace(YARD, obstacles=(), period_s=15, fleet=replace(YARD.fleet, sensor=DiscSensor(radius_m=6)))


def shared_by(robots: int, lacking_m: float) -> tuple[Context, Repaired]:
    """A short loop round the yard, and a search whose period leaves each of so many robots that many metres too few."""
    plan = sweep(search_on(FAR), EARLY)
    assert plan is not None
    (loop,) = with_better_loops(search_on(FAR), plan).tours
    period_s = (tour_length_m(loop) / robots - lacking_m) / FAR.fleet.speed_m_s
    context = search_on(replace(FAR, period_s=period_s))
    return context, replace(plan, tours=[replace(loop, period_s=period_s, robots=robots + 1)])


def test_a_robot_is_spared_where_places_are_seen_for_long() -> None:
    context, found = shared_by(4, 0.05 * FAR.fleet.sensor.reach_m)
    assert found.robots == 5
    fewer = with_longer_headways(context, found)
    assert (fewer.robots, fewer.met) == (4, True)
    assert fewer.plan.mission is context.problem.mission
    assert {(tour.period_s, tour.robot) for tour in fewer.tours} == {
        (context.problem.periods_s[0], context.problem.robot)
    }
    assert check_plan(fewer.plan).verdict == "met"
    # they follow each other in more than the period
    one = fewer.plan.trajectories[0]
    round_m = float(np.hypot(*np.diff(one.positions_m, axis=0).T).sum())
    assert round_m / 4 > FAR.fleet.speed_m_s * context.problem.periods_s[0]


def test_what_lacks_much_and_what_is_proved_stays() -> None:
    context, found = shared_by(2, 0.4 * FAR.fleet.sensor.reach_m)
    assert with_longer_headways(context, found) is found
    proved = replace(context, enough_robots=found.robots)
    assert with_longer_headways(proved, found) is found
    assert with_longer_headways(replace(context, should_stop=lambda: True), found) is found


def test_what_only_the_whole_reach_sees_is_not_given_up() -> None:
    """Behind a no-fly zone as deep as the sensor reaches, which the mission asks to see all of."""
    context, found = shared_by(4, 0.05 * FAR.fleet.sensor.reach_m)
    no_fly = Obstacle(shape=MultiPolygon([box(24.1, 0, 30, 20)]), blocks="motion")
    deep = replace(FAR, period_s=context.problem.mission.period_s, obstacles=(no_fly,), unseeable="refuse")
    with pytest.raises(NoPlanFound):
        set_up_problem(mission_with_longer_headways(deep, 1.0))
    assert with_longer_headways(replace(context, problem=set_up_problem(deep)), found) is found


def test_curves_and_very_large_ground_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    context, found = shared_by(4, 0.05 * FAR.fleet.sensor.reach_m)
    curving = replace(context.problem, robot=replace(context.problem.robot, turn_radius_m=1.0))
    assert with_longer_headways(replace(context, problem=curving), found) is found
    monkeypatch.setattr(longer_headways, "LARGEST", 1.0)
    assert with_longer_headways(context, found) is found


def test_what_is_lacking_for_one_robot_less() -> None:
    context, found = shared_by(2, 0.25)
    (tour,) = found.tours
    assert least_lacking_m([tour]) == pytest.approx(0.25, abs=1e-3)
    assert least_lacking_m([tour, replace(tour, robots=4)]) == 0.0
    assert least_lacking_m([replace(tour, robots=1), replace(tour, nest=0)]) == math.inf
    assert context.problem.mission.period_s is not None


@pytest.mark.parametrize("seen_m", [0.1, 1.0, 3.0])
def test_what_is_seen_beside_straight_ways_is_seen_for_so_long(seen_m: float) -> None:
    less = reaching_less(DiscSensor(radius_m=5.0), seen_m)
    assert isinstance(less, DiscSensor)
    # a place at the end of the shorter reach is within the whole reach for the length of a chord
    assert 2 * math.sqrt(5.0**2 - less.radius_m**2) >= seen_m
    assert 5.0 - seen_m / 2 < less.radius_m < 5.0
    square = reaching_less(SquareSensor(side_m=10.0), seen_m)
    assert isinstance(square, SquareSensor)
    assert square.side_m == pytest.approx(2 * less.radius_m)


def test_periods_are_longer_but_for_visits() -> None:
    zones = (
        Zone(name="gate", shape=YARD.area, period_s=20.0, demand="visit"),
        Zone(name="tank", shape=YARD.area.buffer(-2.0), period_s=30.0),
        Zone(name="free", shape=YARD.area.buffer(-8.0), period_s=None),
    )
    mission = replace(YARD, zones=zones)
    longer = mission_with_longer_headways(mission, 2.0)
    more_s = 2.0 / YARD.fleet.speed_m_s
    assert [zone.period_s for zone in longer.zones] == [20.0, 30.0 + more_s, None]
    assert longer.period_s == YARD.period_s + more_s
    assert mission_with_longer_headways(replace(mission, period_s=None), 2.0).period_s is None


def test_tours_get_the_class_of_their_longer_period() -> None:
    """A visit's period was the longer one, and is the shorter one now."""
    west, east = YARD.area.intersection(YARD.area.buffer(-1.0)), YARD.area
    zones = (
        Zone(name="tank", shape=west, period_s=29.9),
        Zone(name="gate", shape=east, period_s=30.0, demand="visit"),
    )
    mission = replace(YARD, zones=zones, period_s=None)
    problem, easier = set_up_problem(mission), set_up_problem(mission_with_longer_headways(mission, 1.0))
    assert problem.periods_s == (29.9, 30.0)
    assert easier.periods_s == (30.0, 29.9 + 1.0 / YARD.fleet.speed_m_s)
    _, found = shared_by(2, 0.1)
    (tour,) = found.tours
    tours = [replace(tour, period_class=k, period_s=problem.periods_s[k]) for k in (0, 1)]
    moved = on_other_terms(replace(found, tours=tours), problem, easier).tours
    assert [(t.period_class, t.period_s) for t in moved] == [(1, easier.periods_s[1]), (0, 30.0)]
    assert all(t.robot is easier.robot for t in moved)
    back = on_other_terms(replace(found, tours=moved), easier, problem).tours
    assert [(t.period_class, t.period_s) for t in back] == [(0, 29.9), (1, 30.0)]


def test_the_judge_is_asked_for_the_mission() -> None:
    context, _ = shared_by(2, 0.1)
    easier = with_time_in_sight(context, 0.5)
    assert easier.problem.mission is context.problem.mission
    assert easier.problem.reach_m < context.problem.reach_m
    assert easier.problem.periods_s[0] == context.problem.periods_s[0] + 0.5 / YARD.fleet.speed_m_s
    assert easier.settings.repair.tight_bend_growth >= context.settings.repair.tight_bend_growth
