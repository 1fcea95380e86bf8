"""When swarms rest: short steps, late news, crowds, a robot that trembled, doors, and robots that others block."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from shapely import MultiPolygon, Polygon, box

from rota.errors import PlanError
from rota.files.plan_file import plan_from_json, plan_to_json
from rota.model.mission import DiscSensor, Fleet, Mission, MovingObstacle, Obstacle, Robot, StartBox
from rota.model.plan import RunEnd
from rota.planners.swarm.metrics import covered_share
from rota.planners.swarm.planner import SwarmRun, run_mission
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planning.make_plan import search_plan


def swarm(
    size_m: tuple[float, float],
    *,
    robots: int,
    sensor_m: float,
    speed_m_s: float = 2.0,
    body_m: float = 0.5,
    start: StartBox | list[tuple[float, float]],
    obstacles: tuple[Polygon, ...] = (),
    moving: tuple[MovingObstacle, ...] = (),
    **settings: Any,
) -> Mission:
    """Equal robots in a rectangle, from a box or from places."""
    sensor = DiscSensor(radius_m=sensor_m)
    places = [None] * robots if isinstance(start, StartBox) else start
    return Mission(
        name="rest",
        area=MultiPolygon([box(0, 0, *size_m)]),
        obstacles=tuple(Obstacle(shape=MultiPolygon([shape])) for shape in obstacles),
        moving_obstacles=moving,
        fleet=Fleet(
            speed_m_s=speed_m_s,
            sensor=sensor,
            body_radius_m=body_m,
            robots=tuple(
                Robot(name=f"r{k}", speed_m_s=speed_m_s, sensor=sensor, body_radius_m=body_m, start=place)
                for k, place in enumerate(places)
            ),
            start=start if isinstance(start, StartBox) else None,
        ),
        planning=SwarmSettings(**settings),
    )


def last_places(run: SwarmRun) -> np.ndarray:
    """(n, 2): where the robots hold."""
    return np.array([trajectory.positions_m[-1] for trajectory in run.plan])


def doored(door_m: float, body_m: float, **changed: Any) -> Mission:
    """12 robots in a room of 10 m x 20 m; beyond a door in the middle of a wall lies three times as much ground."""
    walls = (box(10, 0, 10.2, 10 - door_m / 2), box(10, 10 + door_m / 2, 10.2, 20))
    settings: dict[str, Any] = {
        "robots": 12, "sensor_m": 5.0, "speed_m_s": 1.0, "body_m": body_m, "obstacles": walls,
        "start": StartBox(low_m=(1, 5), high_m=(9, 15)),
    }  # fmt: skip
    return swarm((40, 20), **(settings | changed))


@pytest.mark.parametrize(("step_share", "delay_steps"), [(3e-4, 1), (1e-3, 2), (0.1, 1)])
def test_short_steps_and_late_news_cover_what_prompt_ones_do(step_share: float, delay_steps: int) -> None:
    starts = [(30 + 4 * (k % 3 - 1), 30 + 4 * (k // 3 - 1)) for k in range(9)]
    asked = swarm(
        (60, 60), robots=9, sensor_m=10, speed_m_s=40 * step_share, body_m=0.2, start=starts,
        delay_steps=delay_steps, most_steps=100_000,
    )  # fmt: skip
    run = run_mission(asked, seed=0)
    assert run.at_rest
    covered = covered_share(last_places(run), np.full(9, 10.0), asked.area)
    # nine discs have room beside each other
    assert covered >= 0.95 * 9 * math.pi * 100 / 3600


def test_nothing_rests_before_news_of_free_ground_have_come() -> None:
    # robots at a wall neither push nor are pushed; free ground begins 25 m off, three steps of news away
    starts = [(0.6 + 1.1 * (k % 4), 0.6 + 1.1 * (k // 4)) for k in range(8)]
    run = run_mission(swarm((80, 10), robots=8, sensor_m=10, start=starts), seed=0)
    assert run.at_rest
    assert np.ptp(last_places(run)[:, 0]) > 40


@pytest.mark.parametrize(("robots", "delay_steps"), [(45, 0), (60, 0), (100, 0), (60, 1)])
def test_robots_that_nobody_needs_park(robots: int, delay_steps: int) -> None:
    for seed in range(5):
        asked = swarm(
            (60, 60), robots=robots, sensor_m=20, start=StartBox(low_m=(2, 2), high_m=(58, 58)), most_steps=500,
            delay_steps=delay_steps,
        )  # fmt: skip
        run = run_mission(asked, seed=seed)
        assert run.at_rest
        assert covered_share(last_places(run), np.full(robots, 20.0), asked.area) > 1 - 1e-9


def test_a_robot_that_trembles_behind_a_wall_comes_to_rest() -> None:
    u = Polygon([(40, 40), (110, 40), (110, 120), (105, 120), (105, 45), (45, 45), (45, 120), (40, 120)])
    asked = swarm(
        (150, 150), robots=25, sensor_m=16, start=StartBox(low_m=(52, 52), high_m=(98, 98)), obstacles=(u,),
        most_steps=6000,
    )  # fmt: skip
    assert run_mission(asked, seed=0).at_rest


@pytest.mark.parametrize("body_m", [0.15, 0.2, 0.5])
def test_doors_that_bodies_fit_through_are_passed(body_m: float) -> None:
    run = run_mission(doored(2 * body_m + 0.1, body_m), seed=0)
    assert run.at_rest
    assert (last_places(run)[:, 0] > 10.2).sum() >= 6


def test_robots_behind_one_that_stands_in_the_door_are_blocked() -> None:
    asked = doored(0.5, 0.2)
    assert asked.fleet.robots is not None
    gate = replace(asked.fleet.robots[0], name="gate", start=(10.1, 10.0), leaves_s=0.25)
    asked = replace(asked, fleet=replace(asked.fleet, robots=(gate, *asked.fleet.robots[1:])))
    run = run_mission(asked, seed=0)
    end = run.plan.run_end
    assert end is not None
    assert (end.reason, run.at_rest, end.goes_on) == ("blocked", False, False)
    assert "r1" in end.blocked
    assert "gate" not in end.blocked
    assert f"{len(end.blocked)} robots want to move on and cannot (r1, " in end.text()
    assert plan_from_json(plan_to_json(run.plan)).run_end == end


def test_nobody_is_blocked_in_a_crowd_without_free_ground() -> None:
    # others hold one that they push; it has nowhere to go
    assert run_mission(doored(0.0, 0.3, robots=20), seed=25).at_rest


def test_who_is_blocked_is_told_for_blocked_runs_only() -> None:
    with pytest.raises(PlanError, match="0 robots with the reason 'blocked'"):
        RunEnd(at_rest=False, steps=3, reason="blocked")
    with pytest.raises(PlanError, match="1 robots with the reason 'rest'"):
        RunEnd(at_rest=True, steps=3, reason="rest", blocked=("r1",))


@pytest.mark.parametrize("seed", range(4))
def test_robots_in_a_heap_at_a_wall_give_way_to_an_obstacle(seed: int) -> None:
    rng = np.random.default_rng(seed)
    starts = [(29.0 + k // 4, 0.5 + k % 4) for k in range(24)]
    middle, angle = rng.uniform(10, 50, 2), rng.uniform(0, 2 * np.pi)
    way = 60 * np.array([np.cos(angle), np.sin(angle)])
    disc = MovingObstacle(radius_m=1.0, times_s=(0, 40), positions_m=(tuple(middle - way), tuple(middle + way)))
    asked = swarm((60, 60), robots=24, sensor_m=20, speed_m_s=10, start=starts, moving=(disc,), most_steps=600)
    assert not search_plan(asked, seed=0).report.violations
