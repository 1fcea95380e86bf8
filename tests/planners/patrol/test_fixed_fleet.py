"""Fleets with a fixed number of robots: spare ones join, too few are told why with the ratio and the bound."""

import numpy as np
import pytest
from shapely import MultiPolygon, box

import rota
from rota.check import check_plan
from rota.mission import DiscSensor, Fleet, Mission, Obstacle, PatrolSettings


def square_yard(robots: int, obstacles: tuple[Obstacle, ...] = ()) -> Mission:
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=4))
    named = tuple(fleet.equal_robot(f"guard-{k}") for k in range(robots))
    return Mission(
        name="yard",
        area=MultiPolygon([box(0, 0, 40, 40)]),
        obstacles=obstacles,
        period_s=40,
        fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=4), robots=named),
        planning=PatrolSettings(effort="quick"),
    )


def test_spare_robots_join_and_keep_their_names() -> None:
    plan = rota.make_plan(square_yard(9))
    assert [trajectory.robot for trajectory in plan] == [f"guard-{k}" for k in range(9)]
    assert check_plan(plan).verdict == "met"


def test_too_few_robots_are_told_the_ratio_and_the_bound() -> None:
    with pytest.raises(
        rota.NoPlanFound, match=r"1 robot cannot .* at least 5 robots \(.*sweeps.*\); .* times its period"
    ) as caught:
        rota.make_plan(square_yard(1))
    best = caught.value.best
    assert isinstance(best, rota.Plan)
    assert len(best.trajectories) == 1
    # 1600 m2 at 8 m2/s less what the disc holds: no single loop can be shorter
    worst = check_plan(best).demands[0].worst_gap_at_least_s
    assert worst > (1600 - np.pi * 16) / 8


def test_ground_in_two_parts_needs_two_robots() -> None:
    wall = Obstacle(shape=MultiPolygon([box(18, 0, 22, 40)]))
    with pytest.raises(rota.NoPlanFound, match="falls into 2 parts between which no robot can travel"):
        rota.make_plan(square_yard(1, (wall,)))
