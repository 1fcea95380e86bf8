"""Large ground end to end: it goes the way of districts, and what comes back passes the check."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapely import MultiPolygon, box
from tests.planners.patrol.searching import search_on

import rota
from rota.engines.processes import LocalProcesses
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota.planners.patrol.context import Context
from rota.planners.patrol.method_settings import DistrictSettings
from rota.planners.patrol.methods.fewest.search import fewest_robots
from rota.planners.patrol.methods.large.cells import boxes_for, missions_of
from rota.planners.patrol.methods.large.districts import by_districts, join
from rota.planners.patrol.methods.large.search import (
    fewest_on_large,
    is_large,
    repair_together,
)
from rota.planners.patrol.methods.sweeping.search import sweep_sequentially
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.repair import Repaired

FIELD = Mission(
    name="field",
    area=MultiPolygon([box(0, 0, 380, 280)]),
    obstacles=(Obstacle(shape=MultiPolygon([box(100, 60, 140, 110)])),),
    period_s=80,
    fleet=Fleet(speed_m_s=10, sensor=DiscSensor(radius_m=5)),
    planning=PatrolSettings(effort="quick"),
)
STREETS = Mission(
    name="streets",
    area=MultiPolygon([box(0, 0, 40, 20)]),
    obstacles=tuple(Obstacle(shape=MultiPolygon([box(x, 6, x + 10, 15)])) for x in (5, 25)),
    zones=(
        Zone(name="gate", shape=MultiPolygon([box(15, 0, 30, 5)]), period_s=30),
        Zone(name="desk", shape=MultiPolygon([box(36, 8, 40, 12)]), period_s=40, demand="visit"),
    ),
    period_s=50,
    fleet=Fleet(speed_m_s=3, sensor=DiscSensor(radius_m=4)),
    planning=PatrolSettings(effort="quick"),
)


def met(plan: rota.Plan) -> bool:
    report = rota.check_plan(plan)
    return report.verdict == "met" and not report.violations


@pytest.mark.slow  # the largest search of all tests
def test_a_large_field_takes_hardly_more_robots_than_it_must() -> None:
    plan = rota.make_plan(FIELD)
    assert met(plan)
    # 104,400 m2, of which a robot sees at most 10 * 800 m2 and its footprint in a period: 12.92 robots
    assert plan.lower_bound_robots == 13
    assert len(plan.trajectories) <= 15
    lengths = {round(trajectory.loop_duration_s, 6) for trajectory in plan}
    assert len(lengths) >= 2  # districts, of which each has its route


@pytest.mark.parametrize(("width_m", "large"), [(100.1, True), (99.9, False)])
def test_ground_is_large_by_its_area_in_squares_of_the_reach(width_m: float, large: bool) -> None:
    # a sensor that reaches 5 m: 40 squares are 1,000 m2
    field = replace(FIELD, obstacles=(), area=MultiPolygon([box(0, 0, width_m, 10)]))
    context = search_on(field)
    assert not is_large(context)
    districts = replace(context.settings.districts, large_from=40.0)
    assert is_large(replace(context, settings=replace(context.settings, districts=districts))) is large


@pytest.mark.parametrize(("period_s", "large"), [(48, True), (50, False)])
def test_ground_is_large_for_many_robots(period_s: float, large: bool) -> None:
    # 100 m x 100 m, of which a robot sees 10 * 10 * 48 m2 and its footprint, 78.5 m2, in 48 s: 2.05 robots
    field = replace(FIELD, obstacles=(), area=MultiPolygon([box(0, 0, 100, 100)]), period_s=period_s)
    context = search_on(field)
    districts = replace(context.settings.districts, many_robots=3)
    assert is_large(replace(context, settings=replace(context.settings, districts=districts))) is large


def test_districts_searched_by_themselves_give_one_plan() -> None:
    context = search_on(STREETS)
    # 604 m2 to be seen point by point are 38 squares of 4 m
    missions = missions_of(STREETS, boxes_for(context.problem.asked_m2, 25 * 4**2), 16.0)
    assert len(missions) == 2
    assert met(repair_together(context, by_districts(context, fewest_robots, missions)).plan)


@pytest.mark.slow  # starts processes anew
def test_other_processes_find_the_same_tours_of_districts() -> None:
    context = search_on(STREETS)
    missions = missions_of(STREETS, 2, 16.0)
    found = by_districts(context, sweep_sequentially, missions)
    with LocalProcesses(1) as processes:
        again = by_districts(replace(context, executor=processes), sweep_sequentially, missions)
    assert [len(tours) for tours in found] == [len(tours) for tours in again]
    for a, b in zip(join(found), join(again), strict=True):
        assert np.array_equal(a.vertices_m, b.vertices_m)
        assert a.robots == b.robots


def test_districts_end_at_once_when_the_search_is_to_end() -> None:
    context = replace(search_on(STREETS), should_stop=lambda: True)
    missions = missions_of(STREETS, 2, 16.0)

    def search(_district: Context) -> Repaired:
        raise AssertionError("nothing more is to be searched")

    assert by_districts(context, search, missions) == [[], []]


def test_districts_are_searched_where_lanes_do_not_do(monkeypatch: pytest.MonkeyPatch) -> None:
    context = search_on(replace(STREETS, period_s=25))
    districts = DistrictSettings(enough=0.0, piece_moves=10, most_area=25.0, built_up_corner=0.0)
    context = replace(context, settings=replace(context.settings, districts=districts))
    asked: list[Mission] = []

    def search(district: Context) -> Repaired:
        asked.append(district.problem.mission)
        return fewest_robots(replace(district, should_stop=lambda: True))

    with monkeypatch.context() as patch:
        patch.setattr("rota.planners.patrol.methods.large.search.in_lanes", lambda _context: None)
        fewest_on_large(context, search)
    assert len(asked) == 2
    asked.clear()
    # two robots in lanes meet 50 s, and each of two districts would take a robot
    lanes = fewest_on_large(replace(search_on(STREETS), settings=context.settings), search)
    assert met(lanes.plan)
    assert asked == []
