"""Large ground end to end: it goes the way of districts, and what comes back passes the check."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest
from shapely import MultiPolygon, box

import rota
from rota.mission import DiscSensor, Fleet, Mission, Obstacle, PatrolSettings, Zone
from rota.planners.patrol.methods import registry
from rota.planners.patrol.methods.large import search

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


def test_a_large_field_takes_hardly_more_robots_than_it_must() -> None:
    plan = rota.make_plan(FIELD)
    assert met(plan)
    # 104,400 m2, of which a robot sees at most 10 * 800 m2 and its footprint in a period: 12.92 robots
    assert plan.lower_bound_robots == 13
    assert len(plan.trajectories) <= 15
    lengths = {round(trajectory.loop_duration_s, 6) for trajectory in plan}
    assert len(lengths) >= 2  # districts, of which each has its route


def test_ground_is_large_by_its_area_in_squares_of_the_reach(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def refuse(context: object, _: object) -> None:
        asked.append(context)
        raise rota.NoPlanFound("seen")

    monkeypatch.setattr(registry, "fewest_on_large", refuse)
    large = replace(FIELD, obstacles=(), area=MultiPolygon([box(0, 0, 400.1, 250)]))  # 4,000 squares of 5 m: 100,000 m2
    with pytest.raises(rota.NoPlanFound, match="seen"):
        rota.make_plan(large)
    monkeypatch.setattr(registry, "fewest_robots", refuse_small)
    with pytest.raises(rota.NoPlanFound, match="small"):
        rota.make_plan(replace(large, area=MultiPolygon([box(0, 0, 399.9, 250)])))
    assert len(asked) == 1


def refuse_small(context: object) -> None:
    raise rota.NoPlanFound("small")


def test_districts_searched_by_themselves_give_one_plan_and_always_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "LARGE", 30.0)
    monkeypatch.setattr(search, "MOST_SEARCHED", 25.0)
    monkeypatch.setattr(search, "NEAR_BOUND", {"quick": 0.0})
    counted = []
    whole = search.by_districts

    def by_districts(context: object, searched: object, missions: list[Mission]) -> object:
        counted.append(len(missions))
        return whole(context, searched, missions)  # type: ignore[arg-type]

    monkeypatch.setattr(search, "by_districts", by_districts)
    monkeypatch.setattr(search, "in_lanes", lambda context: None)
    one = rota.make_plan(STREETS)
    monkeypatch.setattr(os, "cpu_count", lambda: 1)
    other = rota.make_plan(STREETS)
    assert counted == [2, 2]  # 604 m2 to be seen point by point are 38 squares of 4 m
    assert met(one)
    assert len(one.trajectories) == len(other.trajectories)
    for a, b in zip(one, other, strict=True):
        assert np.array_equal(a.positions_m, b.positions_m)
        assert np.array_equal(a.times_s, b.times_s)
