"""Missions planned by the swarm: the plan, its thinning, its starts, and the check's verdict."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from shapely import MultiPolygon, Point, box, union_all

from rota.check import check_plan, report_table, report_to_json
from rota.errors import MissionError, NoPlanFound, PlanError
from rota.files.plan_file import plan_from_text, plan_text
from rota.geometry.free_space import free_ground
from rota.model.mission import DiscSensor, Fleet, Mission, MovingObstacle, Obstacle, Robot, SquareSensor, StartBox, Zone
from rota.model.plan import RunEnd
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.swarm.metrics import covered_share
from rota.planners.swarm.planner import make_swarm, run_mission
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.sentences import covered_sentence, holding_sentence
from rota.planners.swarm.sorted_robots import Beginning
from rota.planners.swarm.starts import place_starts
from rota.planners.swarm.thinning_kernels import thin
from rota.planning.make_plan import search_plan


def mission(robots: int = 12, side_m: float = 150, body_m: float = 0.5, **changed: Any) -> Mission:
    sensor = DiscSensor(radius_m=25)
    fleet = Fleet(speed_m_s=2, sensor=sensor, body_radius_m=body_m, start=StartBox(low_m=(1, 1), high_m=(40, 40)))
    listed = tuple(fleet.equal_robot(f"robot-{k + 1}") for k in range(robots))
    fields: dict[str, Any] = {
        "name": "square",
        "area": MultiPolygon([box(0, 0, side_m, side_m)]),
        "fleet": dataclasses.replace(fleet, robots=listed),
        "planning": SwarmSettings(),
    }
    return Mission(**fields | changed)


def with_robots(*robots: Robot, **changed: Any) -> Mission:
    return mission(fleet=Fleet(speed_m_s=2, sensor=robots[0].sensor, robots=robots), **changed)


def robot(name: str, start: tuple[float, float] | None, body_m: float = 0.5, sensor_m: float = 25) -> Robot:
    return Robot(name=name, speed_m_s=2, sensor=DiscSensor(radius_m=sensor_m), body_radius_m=body_m, start=start)


@pytest.mark.parametrize("controller", ["settle", "reciprocal", "voronoi", "virtual_force"])
def test_a_plan_holds_at_the_end_and_passes_the_check(controller: Any) -> None:
    settings = SwarmSettings(controller=controller, most_steps=600)
    obstacle = Obstacle(shape=MultiPolygon([box(60, 60, 75, 70)]))
    found = search_plan(mission(planning=settings, obstacles=(obstacle,)), seed=3)
    assert found.report.violations == ()
    assert found.report.verdict == "met"
    for trajectory in found.plan:
        assert trajectory.loop_duration_s == 0
        assert Point(trajectory.positions_m[0]).within(box(1, 1, 40, 40))
    assert plan_from_text(plan_text(found.plan), "plan") == found.plan


CORNER = [(k + 0.5, 0.5) for k in range(6)] + [(0.5, k + 1.5) for k in range(5)]
TOUCHING = {
    "along two walls": (box(0, 0, 60, 60), CORNER),
    "along a wall": (box(0, 0, 60, 60), [(10.0 + k, 0.5) for k in range(12)]),
    "in a lane": (box(0, 0, 1.52, 12), [(0.5, k + 0.5) for k in range(8)]),
    "in a square": (box(0, 0, 60, 60), [(20.5 + k % 4, 30.5 + k // 4) for k in range(16)]),
}


@pytest.mark.parametrize("controller", ["settle", "reciprocal", "voronoi", "virtual_force"])
@pytest.mark.parametrize("where", TOUCHING)
def test_bodies_that_touch_exactly_at_the_start_get_a_plan(controller: Any, where: str) -> None:
    area, starts = TOUCHING[where]
    robots = (robot(f"r{k}", start, sensor_m=10) for k, start in enumerate(starts))
    settings = SwarmSettings(controller=controller, most_steps=60)
    found = search_plan(with_robots(*robots, area=MultiPolygon([area]), planning=settings), seed=0)
    assert found.report.verdict == "met"
    assert found.report.violations == ()


def test_a_zone_that_the_holding_robots_see_is_met_and_one_beyond_them_is_not() -> None:
    still = robot("a", (50, 50))
    near = Zone(name="near", shape=MultiPolygon([box(45, 45, 55, 55)]), period_s=10)
    far = Zone(name="far", shape=MultiPolygon([box(95, 95, 105, 105)]), period_s=10)
    assert search_plan(with_robots(still, zones=(near,))).report.verdict == "met"
    with pytest.raises(NoPlanFound, match="violated"):
        search_plan(with_robots(still, zones=(near, far)))


def test_the_same_seed_gives_the_same_plan_on_any_number_of_threads() -> None:
    asked = mission(robots=600, side_m=1300, planning=SwarmSettings(most_steps=30), fleet=mission().fleet)
    fleet = asked.fleet
    many = tuple(fleet.equal_robot(f"r{k}") for k in range(600))
    asked = dataclasses.replace(asked, fleet=dataclasses.replace(fleet, robots=many, start=None))
    one, two = (run_mission(asked, seed=1, threads=threads).plan for threads in (1, 2))
    assert one == two
    assert run_mission(asked, seed=2).plan != one


def test_a_run_with_momentum_does_not_end_where_a_robot_turns() -> None:
    corridor = with_robots(robot("a", (15, 75)), area=MultiPolygon([box(0, 0, 40, 150)]))
    swarm = make_swarm(corridor, free_ground(corridor), Beginning(np.array([[15.0, 75.0]])), seed=0, reserve_m=0.05)
    moved = [swarm.step() for _ in range(40)]
    turn = next(k for k in range(1, 39) if moved[k - 1] > moved[k] < moved[k + 1])
    settings = SwarmSettings(stop_m=moved[turn])
    run = run_mission(dataclasses.replace(corridor, planning=settings), seed=0)
    assert run.at_rest
    assert run.steps > turn + 1
    assert abs(run.plan.trajectories[0].positions_m[-1, 0] - 20) < abs(15 - 20) / 4


def test_a_seed_of_any_size_will_do() -> None:
    settings = SwarmSettings(controller="reciprocal", velocity="sampled", samples=50, most_steps=3)
    plans = [run_mission(mission(planning=settings), seed=seed).plan for seed in (2**70, 2**70, 2**70 + 1)]
    assert plans[0] == plans[1]
    assert plans[0].trajectories != plans[2].trajectories


def test_thinned_trajectories_stay_as_near_as_stated_to_every_step() -> None:
    asked = mission(planning=SwarmSettings(controller="reciprocal", thinning_m=0.05, most_steps=400))
    plan = run_mission(asked, seed=5).plan
    ground = free_ground(asked)
    starts = place_starts(asked, ground, seed=5, reserve_m=0.05)
    swarm = make_swarm(asked, ground, Beginning(starts), seed=5, reserve_m=0.05)
    steps = [starts]
    while len(steps) <= 400 and swarm.step() > 1e-5:
        steps.append(swarm.places_m)
    places = np.array(steps)
    times = 0.25 * np.arange(len(places))
    worst, points = 0.0, 0
    for k, trajectory in enumerate(plan):
        line = [np.interp(times, trajectory.times_s, trajectory.positions_m[:, axis]) for axis in (0, 1)]
        worst = max(worst, float(np.hypot(*(np.array(line).T - places[:, k]).T).max()))
        points += len(trajectory.times_s)
    assert 0.005 < worst <= 0.05
    assert points < len(places) * 12 / 4


def test_thinning_by_nothing_keeps_corners_and_drops_straight_steps() -> None:
    path = np.array([[0, 0], [1, 0], [2, 0], [3, 0], [3, 1], [3, 2], [3, 2], [3, 2]], float)
    kept = np.zeros((8, 1), np.int8)
    thin(path[:, None].copy(), 0.0, kept)
    assert np.flatnonzero(kept[:, 0]).tolist() == [0, 3, 5, 7]


def test_robots_that_begin_closer_than_thinning_needs_are_thinned_less() -> None:
    pair = (robot("a", (50, 50)), robot("b", (51.004, 50)), robot("c", (90, 90)))
    plan = run_mission(with_robots(*pair, planning=SwarmSettings(most_steps=200, thinning_m=0.1)), seed=0).plan
    assert check_plan(plan).violations == ()


def test_moving_obstacles_are_made_way_for_also_by_robots_that_rest() -> None:
    # both rest, out of each other's range, long before the obstacle sets out
    obstacle = MovingObstacle(radius_m=2, times_s=(0, 200, 300), positions_m=((-5, 51), (-5, 51), (160, 51)))
    robots = (robot("a", (40, 50)), robot("b", (105, 52)))
    moving = with_robots(
        *robots, moving_obstacles=(obstacle,), planning=SwarmSettings(controller="reciprocal", most_steps=2000)
    )
    alone = run_mission(dataclasses.replace(moving, moving_obstacles=()), seed=0)
    assert alone.at_rest
    assert alone.steps * 0.25 < 150
    run = run_mission(moving, seed=0)
    plan = run.plan
    assert run.at_rest
    assert run.steps * 0.25 > 300
    assert check_plan(plan).violations == ()
    assert math.dist(plan.trajectories[0].positions_m[0], plan.trajectories[0].positions_m[-1]) > 1
    still = dataclasses.replace(plan, trajectories=tuple(hold(t) for t in plan))
    assert {v.kind for v in check_plan(still).violations} == {"moving obstacle"}


def test_a_run_that_ends_before_the_obstacle_has_passed_is_cut_off() -> None:
    obstacle = MovingObstacle(radius_m=2, times_s=(0, 200, 300), positions_m=((-5, 51), (-5, 51), (-5, 60)))
    moving = with_robots(
        robot("a", (75, 75)), moving_obstacles=(obstacle,), planning=SwarmSettings(most_steps=900, neighbours=0)
    )
    run = run_mission(moving, seed=0)
    assert not run.at_rest
    assert run.plan.run_end == RunEnd(at_rest=False, steps=900, reason="most_steps")


def test_a_plan_says_how_its_run_ended_in_its_file_its_table_and_its_report() -> None:
    asked = mission(planning=SwarmSettings(most_steps=20))
    ended = {"most_steps": run_mission(asked, seed=0)}
    ended["stopped"] = run_mission(asked, seed=0, should_stop=iter([False] * 7 + [True]).__next__)
    ended["rest"] = run_mission(with_robots(robot("a", (75, 75))), seed=0)
    for reason, run in ended.items():
        end = run.plan.run_end
        assert end is not None
        assert (end.reason, end.at_rest, end.steps) == (reason, run.at_rest, run.steps)
        assert plan_from_text(plan_text(run.plan), "plan") == run.plan
        report = check_plan(run.plan)
        assert f"the plan says that its run was {end.text()}" in report_table(report)
        told = {"at_rest": end.at_rest, "steps": end.steps, "reason": reason, "blocked": []}
        assert report_to_json(report)["run_end"] == told
        assert ("cut off" in holding_sentence(run.plan)) == (reason != "rest")
    assert ended["stopped"].steps == 7
    text = plan_text(ended["stopped"].plan).replace('"reason": "stopped"', '"reason": "rest"')
    with pytest.raises(PlanError, match=r"plan: run_end: reason: 'rest' with at_rest False; rest for robots at rest"):
        plan_from_text(text, "plan")


def test_square_sensors_are_planned_as_the_discs_within_and_measured_as_squares() -> None:
    square = dataclasses.replace(mission().fleet, sensor=SquareSensor(side_m=50), robots=None)
    listed = tuple(square.equal_robot(f"robot-{k + 1}") for k in range(12))
    asked = mission(fleet=dataclasses.replace(square, robots=listed))
    run, discs = (run_mission(one, seed=3, observed=True) for one in (asked, mission()))
    assert [t.positions_m.tolist() for t in run.plan] == [t.positions_m.tolist() for t in discs.plan]
    ends = [trajectory.positions_m[-1] for trajectory in run.plan]
    squares = union_all([box(x - 25, y - 25, x + 25, y + 25) for x, y in ends]).intersection(asked.area)
    assert run.history is not None
    assert run.history.coverage[-1] == pytest.approx(squares.area / 150**2, abs=0.002)
    assert run.history.deadweight_loss[-1] == pytest.approx(1 - squares.area / (12 * 50**2), abs=0.003)
    assert covered_share(np.array(ends), np.full(12, 25.0), asked.area, np.full(12, True)) == pytest.approx(
        squares.area / 150**2
    )
    assert check_plan(run.plan).verdict == "met"
    assert f"{squares.area / 150**2:.1%} of the area in range" in covered_sentence(run.plan)


def hold(trajectory: Any) -> Any:
    return dataclasses.replace(trajectory, times_s=[0.0], positions_m=trajectory.positions_m[:1], loop_start_s=0.0)


def test_every_kind_of_robot_has_its_own_sizes() -> None:
    robots = (robot("a", (40, 40), 0.5, 25), robot("b", (44, 40), 3.0, 12), robot("c", (40, 46), 1.0, 18))
    plan = run_mission(with_robots(*robots, planning=SwarmSettings(most_steps=300)), seed=0).plan
    assert check_plan(plan).violations == ()


# ---------------------------------------------------------------- refused


@pytest.mark.parametrize(
    ("starts", "words"),
    [
        ([(10, 10), (10.5, 10)], "is 0.5 m from"),
        ([(-1, 10)], "1 m outside the area"),
        ([(62, 62)], "lies in an obstacle"),
        ([(math.nan, 3)], r"robot r0: start\[0\]: \.nan is not allowed; a finite number is needed"),
    ],
)
def test_starts_that_cannot_be_are_refused(starts: list[tuple[float, float]], words: str) -> None:
    obstacles = (Obstacle(shape=MultiPolygon([box(60, 60, 75, 70)])),)
    with pytest.raises(MissionError, match=words):
        with_robots(*(robot(f"r{k}", start) for k, start in enumerate(starts)), obstacles=obstacles)


def test_more_robots_than_fit_are_refused() -> None:
    # centres in 34.95 m x 34.95 m, bodies up to 5 m beyond: 34.95^2 + 4 x 34.95 x 5 + pi 5^2 = 1999 m2
    with pytest.raises(
        MissionError, match=r"fleet.start.box: 30 bodies of 2356.19 m2 do not fit in 1998.92 m2; .*larger box"
    ):
        run_mission(mission(robots=30, body_m=5), seed=0)
    # centres in 35 m x 35 m, 10 m apart: rows of four, every other one shifted by 5 m, and five of them in 4 x 8.66 m
    with pytest.raises(
        MissionError, match=r"no room was found for 22 robots .*; a lattice holds 20 of them; give fewer"
    ):
        run_mission(mission(robots=22, body_m=5), seed=0)
    with pytest.raises(MissionError, match="fits nowhere"):
        run_mission(mission(robots=1, side_m=40, body_m=21), seed=0)


def test_a_step_that_jumps_through_walls_is_refused_without_the_filter() -> None:
    settings = SwarmSettings(filter=False, time_step_s=13)
    with pytest.raises(
        MissionError, match=r"time_step_s: 13 is not allowed.*26 m in a step and heeds walls within 25 m"
    ):
        run_mission(mission(planning=settings), seed=0)
    plan = run_mission(mission(planning=SwarmSettings(time_step_s=13, most_steps=30)), seed=0).plan
    assert check_plan(plan).violations == ()


def test_a_fleet_that_no_swarm_can_be_is_refused() -> None:
    with pytest.raises(MissionError, match=r"fleet.robots: fewest is not allowed"):
        mission(fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=25)))
    square = dataclasses.replace(robot("a", None), sensor=SquareSensor(side_m=9))
    with pytest.raises(MissionError, match="square is not allowed: a swarm with altitudes_m has discs"):
        with_robots(square, planning=SwarmSettings(controller="reciprocal", altitudes_m=(1, 2)))
    with pytest.raises(MissionError, match="robots of a swarm turn at once"):
        with_robots(dataclasses.replace(robot("a", None), turn_rate_rad_s=1.0))
    moving = MovingObstacle(radius_m=1, times_s=(0,), positions_m=((1, 1),))
    with pytest.raises(MissionError, match="moving_obstacles: the patrol planner has no use for moving_obstacles"):
        mission(planning=PatrolSettings(), period_s=9, moving_obstacles=(moving,))
    with pytest.raises(MissionError, match="effort"):
        mission().with_effort("quick")


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"controller": "boids"}, 'swarm.controller: "boids"'),
        ({"time_step_s": math.nan}, r"swarm\.time_step_s: \.nan"),
        ({"alpha": 0.9}, "swarm.alpha"),
        ({"neighbours": -1}, "swarm.neighbours"),
        ({"neighbour_range_m": 0.0}, "swarm.neighbour_range_m"),
        ({"thinning_m": math.inf}, "swarm.thinning_m"),
        ({"most_steps": 0}, "swarm.most_steps"),
        ({"delay_steps": 21}, "swarm.delay_steps"),
        ({"messages_lost": 1.0}, "swarm.messages_lost"),
        ({"messages_lost": math.nan}, "swarm.messages_lost"),
    ],
)
def test_settings_out_of_range_are_refused(wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(MissionError, match=words):
        SwarmSettings(**wrong)


def test_no_neighbours_at_all_leave_a_robot_where_walls_let_it_be() -> None:
    plan = run_mission(with_robots(robot("a", (75, 75)), planning=SwarmSettings(neighbours=0)), seed=0).plan
    assert plan.trajectories[0].positions_m[-1].tolist() == [75, 75]
