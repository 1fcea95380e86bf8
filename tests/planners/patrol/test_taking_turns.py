"""Robots in two pockets of the space beside each other, which would touch if both were where they must come."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, Polygon, box
from tests.planners.patrol.searching import search_on

import rota
from rota.check import check_plan
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.ground import problem as problems
from rota.planners.patrol.ground.keeping_off import farthest_place, keeping_off
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.methods.fewest import search
from rota.planners.patrol.planner import what_helps
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.clear_of_stays import clear_of_who_stays, past_where_they_wait
from rota.planners.patrol.tours.tour import Tour

BODY_M = 0.4


def corridor(*, left_m: float = -0.8, reach_m: float = 0.57) -> Mission:
    """A corridor as wide as 2.5 bodies, with a pinch at 0 that no body passes: one part on each side."""
    pinch = MultiPolygon([Polygon([(-0.01, y), (0.01, y), (0, 0.79 * y)]) for y in (-0.5, 0.5)])
    return Mission(
        name="corridor",
        area=MultiPolygon([box(left_m, -0.5, 1.3, 0.5)]),
        obstacles=(Obstacle(shape=pinch),),
        period_s=60,
        fleet=Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=reach_m), body_radius_m=BODY_M),
        planning=PatrolSettings(effort="quick"),
    )


@pytest.fixture
def ragged(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ground with few corners is planned as if it were a scanned floor."""
    monkeypatch.setattr(problems, "MOST_DENSE", 10)


@pytest.fixture(scope="module")
def beside() -> Problem:
    return set_up_problem(corridor())


def tour_of(problem: Problem, component: int, *places: tuple[float, float]) -> Tour:
    return Tour(
        vertices_m=np.array(places), period_class=0, period_s=60.0, robots=1, robot=problem.robot, component=component
    )


@pytest.mark.usefixtures("ragged")
def test_robots_in_pockets_beside_each_other_take_turns() -> None:
    plan = rota.make_plan(corridor())
    assert check_plan(plan).verdict == "met"
    left, right = sorted((t.positions_m for t in plan), key=lambda places: float(places[0, 0]))
    # each comes to where the other has been too near: no still robot keeps off both
    near_m = shapely.distance(shapely.LineString(left), shapely.LineString(right))
    assert len(list(plan)) == 2
    assert near_m < 2 * BODY_M


@pytest.mark.usefixtures("ragged")
def test_pockets_far_enough_apart_need_no_turns() -> None:
    mission = corridor(left_m=-1.6, reach_m=1.2)
    plan = rota.make_plan(mission)
    assert check_plan(plan).verdict == "met"


def test_no_pocket_is_lost_where_bodies_touch_whatever_they_do() -> None:
    tight = set_up_problem(replace(corridor(), area=MultiPolygon([box(-0.8, -0.5, 0.75, 0.5)])))
    clear = keeping_off(tight, tight.paths.parts, [0, 1])
    assert [k for k, _ in clear.waits_m] == [0, 1]
    assert clear.paths.parts == tight.paths.parts


def test_who_waits_takes_little_of_the_pocket_beside(beside: Problem) -> None:
    left = beside.paths.parts[1]
    clear = keeping_off(beside, [left], [1])
    ((part, (x, y)),) = clear.waits_m
    assert part == 1
    assert x == pytest.approx(-BODY_M, abs=1e-5)
    right = clear.paths.parts[0]
    assert right.distance(shapely.Point(x, y)) >= 2 * BODY_M
    assert right.distance(left) < 2 * BODY_M
    # who stays at one place is kept clear of there
    still = keeping_off(beside, [shapely.Point(-0.2, 0)], [1])
    assert still.waits_m == ()
    assert still.paths.parts[0].distance(shapely.Point(-0.2, 0)) >= 2 * BODY_M


def test_no_robot_waits_where_another_that_stays_has_taken_the_place(beside: Problem) -> None:
    left = beside.paths.parts[1]
    ((_, place_m),) = keeping_off(beside, [left], [1]).waits_m
    gone = replace(beside, waits_m=((0, (50.0, 0.0)),))
    assert keeping_off(gone, [left], [1]).waits_m == ((1, place_m),)


def test_nobody_takes_turns_with_who_drives_about_in_a_hall(beside: Problem) -> None:
    hall = set_up_problem(replace(corridor(), area=MultiPolygon([box(-0.8, -0.5, 0.3, 0.5) | box(0.3, -2, 5, 2)])))
    pocket = len(hall.paths.parts) - 1
    clear = keeping_off(hall, [hall.paths.parts[pocket]], [pocket])
    assert clear.waits_m == ()
    assert clear.paths.parts[0].distance(hall.paths.parts[pocket]) >= 2 * BODY_M


def test_tours_lead_past_where_their_robots_wait(beside: Problem) -> None:
    stays, comes = tour_of(beside, 1, (-0.2, 0.0)), tour_of(beside, 0, (0.5, 0.0), (0.9, 0.0))
    clear, led = clear_of_who_stays(beside, [stays, comes])
    waits = past_where_they_wait(clear, led)
    assert len(waits[0].vertices_m) == 2
    assert tuple(waits[0].vertices_m[1]) == dict(clear.waits_m)[1]
    assert waits[1] is led[1]
    assert past_where_they_wait(clear, waits)[0] is waits[0]


def test_a_pocket_with_no_room_inside_has_one_place() -> None:
    hair = box(0, 0, 1e-6, 1e-6)
    assert hair.covers(farthest_place(hair, [box(1, 0, 2, 1)]))


def test_who_plans_a_scanned_floor_is_told_what_helps(monkeypatch: pytest.MonkeyPatch) -> None:
    mission = corridor()
    plan = rota.make_plan(replace(mission, area=MultiPolygon([box(0.1, -0.5, 1.3, 0.5)]), obstacles=()))
    # of two parts only one has a robot: the other's ground is never seen
    verdict = check_plan(replace(plan, mission=corridor(left_m=-3.0), lower_bound_robots=None, lower_bound_reason=None))
    assert len(verdict.shown_unmet_m)
    assert what_helps(mission, verdict) == ""  # few corners
    monkeypatch.setattr("rota.planners.patrol.planner.has_many_corners", lambda mission: True)
    x, y = verdict.shown_unmet_m[0]
    helps = what_helps(mission, verdict)
    assert f"({x:.2f}, {y:.2f})" in helps
    assert "fleet.entrances" in helps
    assert "close_gaps_m" in helps
    entered = replace(mission, fleet=replace(mission.fleet, entrances=((0.7, 0.0),)))
    helps = what_helps(entered, verdict)
    assert "fleet.entrances" not in helps
    assert "close_gaps_m" in helps


@pytest.mark.usefixtures("ragged")
def test_no_other_tours_are_looked_for_over_so_many_corners(monkeypatch: pytest.MonkeyPatch) -> None:
    context, unmet = search_on(corridor()), SimpleNamespace(met=False, verdict=None)
    monkeypatch.setattr(search, "repair_first_tours", lambda context, groupings: unmet)
    monkeypatch.setattr(search, "has_many_corners", lambda mission: True)
    monkeypatch.setattr(search, "never_seen", lambda verdict: 0)
    assert search.reduce_team(context, None) is unmet
