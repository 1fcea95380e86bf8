"""Fleets with a fixed number of robots: spare ones join, too few are told why with the ratio and the bound."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from shapely import MultiPolygon, box

import rota
from rota.check import check_plan
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.verdict import worst_reached


def square_yard(robots: int, obstacles: tuple[Obstacle, ...] = ()) -> Mission:
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=4))
    named = tuple(fleet.equal_robot(f"guard-{k}") for k in range(robots))
    return Mission(
        name="yard",
        area=MultiPolygon([box(0, 0, 16, 16)]),
        obstacles=obstacles,
        period_s=16,
        fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=4), robots=named),
        planning=PatrolSettings(effort="quick"),
    )


def test_spare_robots_join_and_keep_their_names() -> None:
    plan = rota.make_plan(square_yard(4))
    assert [trajectory.robot for trajectory in plan] == [f"guard-{k}" for k in range(4)]
    assert check_plan(plan).verdict == "met"


def test_too_few_robots_are_told_the_ratio_and_the_bound() -> None:
    with pytest.raises(
        rota.NoPlanFound, match=r"1 robot cannot .* times its period; .* at least 2 robots \(.*sweeps.*\)"
    ) as caught:
        rota.make_plan(square_yard(1))
    best = caught.value.best
    assert isinstance(best, rota.Plan)
    assert len(best.trajectories) == 1
    # 256 m2 at 8 m2/s less what the disc holds: no single loop can be shorter
    worst = check_plan(best).demands[0].worst_gap_at_least_s
    assert worst > (256 - np.pi * 16) / 8


def test_ground_in_two_parts_needs_two_robots() -> None:
    wall = Obstacle(shape=MultiPolygon([box(6, 0, 10, 16)]))
    with pytest.raises(rota.NoPlanFound, match="falls into 2 parts between which no robot can travel"):
        rota.make_plan(square_yard(1, (wall,)))


@pytest.mark.parametrize(
    ("name", "at_least_s", "at_most_s", "words"),
    [
        ("zone-1", 41.0, 41.5, "in 'zone-1' the worst gap is 41 s, 1.025 times its period"),
        ("area", 50.0, 50.0, "in the area the worst gap is 50 s, 1.250 times its period"),
        ("area", math.inf, math.inf, "some of the area is never seen"),
        ("gate", 39.0, math.inf, "in 'gate' it is not proven that every gap is within its period of 40 s"),
        ("gate", 39.0, 40.0, "the check finds the routes themselves at fault"),
    ],
)
def test_the_reason_names_what_is_missed_most(name: str, at_least_s: float, at_most_s: float, words: str) -> None:
    met = SimpleNamespace(name="met", period_s=10.0, worst_gap_at_least_s=9.0, worst_gap_s=9.5)
    asked = SimpleNamespace(name=name, period_s=40.0, worst_gap_at_least_s=at_least_s, worst_gap_s=at_most_s)
    assert worst_reached(SimpleNamespace(demands=(met, asked), violations=())) == words


def test_the_reason_names_what_is_wrong_with_the_routes() -> None:
    outside = {"kind": "outside area", "who": "robot-2", "limit": 1e-6, "unit": "m"}
    faults = [SimpleNamespace(**outside, place_m=(3.0, -value), value=value) for value in (2.0, 30.25, 4.0)]
    verdict = SimpleNamespace(demands=(), violations=faults)
    assert worst_reached(verdict) == "robot-2: outside area at (3, -30.25): 30.25 m, allowed 1e-06 m"


def test_the_reason_names_what_nobody_can_see() -> None:
    fault = SimpleNamespace(kind="unseeable", value=301.25, limit=300.0)
    words = "nobody can see 301.25 m2 of what is asked, and 300 m2 may be left out"
    assert worst_reached(SimpleNamespace(demands=(), violations=(fault,))) == words
