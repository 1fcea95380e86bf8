"""The method as a whole: plans that the check passes, every stage exchangeable, what it cannot do told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import shapely
from benchmarks.missions import EXAMPLES
from shapely import LineString, MultiPolygon, box

import rota
from rota.check import check_plan
from rota.errors import MissionError, NoPlanFound
from rota.files.mission_file import read_mission
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot, SquareSensor, StartBox, Zone
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.methods.sun2019.mission_settings import Sun2019
from rota.planners.patrol.methods.sun2019.search import Cutting
from rota.planners.patrol.methods.sun2019.sensors import Frame, deployed_sensors, frames_past_sensors
from rota.planners.patrol.planner_settings import PatrolSettings

QUICK = PatrolSettings(effort="quick", method="sun2019")
FIGURE_13 = read_mission(EXAMPLES / "sun2019-fig13.yaml").mission
YARD = Mission(
    name="yard",
    area=MultiPolygon([box(0, 0, 60, 40)]),
    obstacles=(Obstacle(shape=MultiPolygon([box(10, 10, 20, 20)])),),
    zones=(
        Zone(name="gate", shape=MultiPolygon([box(40, 20, 55, 35)]), period_s=20),
        Zone(name="tank", shape=MultiPolygon([box(5, 25, 15, 35)]), period_s=30),
    ),
    period_s=60,
    fleet=Fleet(speed_m_s=4, sensor=DiscSensor(radius_m=5)),
    planning=QUICK,
)


def planned(mission: Mission, seed: int = 0) -> rota.Plan:
    plan = rota.make_plan(mission, seed=seed)
    report = check_plan(plan)
    assert (report.verdict, report.violations) == ("met", ())
    assert plan.lower_bound_robots is not None
    assert plan.lower_bound_robots <= len(plan.trajectories)
    return plan


def with_stages(mission: Mission, **stages: str) -> Mission:
    return replace(mission, planning=replace(mission.planning, method_settings=Sun2019(**stages)))


@pytest.mark.slow  # the longest search of this method
def test_figure_13_takes_no_more_robots_than_the_paper() -> None:
    plan = planned(replace(FIGURE_13, planning=QUICK))
    assert len(plan.trajectories) <= 5  # Table 5
    for one in plan:
        for obstacle in plan.mission.obstacles:
            assert LineString(one.positions_m).intersection(obstacle.shape.buffer(-1e-6)).is_empty


def test_a_yard_with_an_obstacle_and_two_zones_is_met() -> None:
    plan = planned(YARD)
    assert len(plan.trajectories) <= 5
    for one in plan:
        assert LineString(one.positions_m).intersection(box(10, 10, 20, 20).buffer(-1e-6)).is_empty


@pytest.mark.parametrize(
    "stages",
    [
        {"deployment": "exact"},
        {"deployment": "greedy"},
    ],
    ids=lambda stages: "-".join(stages),
)
def test_each_stage_is_exchangeable(stages: dict[str, str]) -> None:
    assert len(planned(with_stages(YARD, **stages)).trajectories) <= 8


def test_best_is_of_covers_as_many_as_the_effort_allows() -> None:
    assert Sun2019().covers("quick") == ("greedy",)
    assert Sun2019().covers("normal") == Sun2019().covers("high") == ("greedy", "exact")
    assert Sun2019(deployment="exact").covers("quick") == ("exact",)


def test_stages_are_read_from_mission_files_and_kept_in_plan_files(tmp_path: Path) -> None:
    text = """\
rota: 1
name: yard
area: [[0, 0], [12, 0], [12, 12], [0, 12]]
period_s: 60
fleet: {speed_m_s: 2, sensor: {shape: disc, radius_m: 5}}
patrol: {effort: quick, method: sun2019, sun2019: {deployment: exact}}
"""
    (tmp_path / "yard.yaml").write_text(text)
    mission = rota.read_mission(tmp_path / "yard.yaml").mission
    stages = PatrolSettings.of(mission).method_settings
    assert stages == Sun2019(deployment="exact")
    assert (stages.tour, stages.partition) == ("local_search", "exact")
    plan = planned(mission)
    rota.write_plan(plan, tmp_path / "yard.rota.json")
    assert rota.read_plan(tmp_path / "yard.rota.json") == plan


def test_bodies_turning_times_reserves_and_starts_are_kept() -> None:
    fleet = Fleet(
        speed_m_s=4, sensor=DiscSensor(radius_m=5), body_radius_m=0.3, turn_rate_rad_s=2.0,
        start=StartBox(low_m=(22, 22), high_m=(30, 30)),
    )  # fmt: skip
    planning = replace(QUICK, period_margin=0.05, range_margin_m=0.2)
    plan = planned(replace(YARD, fleet=fleet, planning=planning))
    assert all(trajectory.loop_start_s > 0 for trajectory in plan)


def test_zones_are_visited_and_ground_in_two_parts_has_robots_in_both() -> None:
    wall = Obstacle(shape=MultiPolygon([box(28, 0, 32, 40)]))
    visit = Zone(name="door", shape=MultiPolygon([box(50, 2, 51, 3)]), period_s=40, demand="visit")
    plan = planned(replace(YARD, obstacles=(*YARD.obstacles, wall), zones=(*YARD.zones, visit)))
    assert {bool(one.positions_m[0, 0] < 30) for one in plan} == {True, False}


def test_a_fixed_fleet_of_different_robots_is_planned_as_a_whole() -> None:
    robots = tuple(
        Robot(name=name, speed_m_s=speed, sensor=DiscSensor(radius_m=5), body_radius_m=0, turn_rate_rad_s=None)
        for name, speed in (("slow", 4), ("fast", 8))
    )
    field = replace(YARD, area=MultiPolygon([box(0, 0, 45, 30)]), obstacles=(), zones=())
    plan = planned(replace(field, fleet=replace(YARD.fleet, robots=robots)))
    assert [one.robot for one in plan] == ["slow", "fast"]


def test_sensors_see_all_ground_twice_as_far_and_frames_lead_past_each_once() -> None:
    problem = set_up_problem(YARD)
    for cover in ("greedy", "exact"):
        places_m, period_class = deployed_sensors(problem, cover)
        seen = shapely.union_all(shapely.buffer(shapely.points(places_m), 10))
        assert seen.intersection(problem.space).area > 0.97 * problem.space.area
        near_gate = shapely.distance(YARD.zones[0].shape, shapely.points(places_m[period_class == 0]))
        assert near_gate.max() <= 10
        (frame,) = frames_past_sensors(problem, cover)
        assert sorted(map(tuple, frame.places_m)) == sorted(map(tuple, places_m))
        assert len(frame.legs_m) == len(places_m)
    assert len(places_m) <= len(deployed_sensors(problem, "greedy")[0])


def test_square_sensors_are_refused_by_name() -> None:
    fleet = Fleet(speed_m_s=4, sensor=SquareSensor(side_m=10))
    told = r"fleet\.sensor\.shape: square is not allowed: patrol\.method sun2019 .*; give disc"
    with pytest.raises(MissionError, match=told):
        replace(YARD, fleet=fleet)


def test_stopped_at_once_it_gives_the_first_plan_it_has() -> None:
    told: list[str] = []
    with pytest.raises(NoPlanFound, match="stopped early") as caught:
        rota.make_plan(YARD, should_stop=lambda: True, progress=lambda _, what: told.append(what))
    assert caught.value.best is not None
    assert any("deploying sensors (greedy)" in what for what in told)


@pytest.mark.parametrize("name", ["deployment", "tour", "partition", "routes"])
def test_unknown_stages_are_refused_by_name(name: str) -> None:
    with pytest.raises(MissionError, match=rf"patrol\.sun2019\.{name}: \"best guess\" is not allowed"):
        Sun2019(**{name: "best guess"})


def by_brute_force(share: Callable[[int, int], float], n: int, segments: int) -> float:
    """The smallest largest share of all ways to cut a ring of n in so many segments."""

    def largest(cuts: tuple[int, ...]) -> float:
        return max(share(a, (b - a - 1) % n + 1) for a, b in zip(cuts, (*cuts[1:], cuts[0]), strict=True))

    return min(largest(cuts) for cuts in combinations(range(n), segments))


@pytest.mark.parametrize("seed", range(6))
def test_frames_are_cut_so_that_the_fullest_segment_takes_least(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = 9
    periods_s = (2.0, 3.0, 5.0)
    frame = Frame(
        places_m=np.zeros((n, 2)), period_class=rng.integers(0, 3, n), legs_m=rng.uniform(5, 15, n), part=0
    )  # fmt: skip
    cutting = Cutting(frame, periods_s, 20.0, 5.0)

    def share(first: int, count: int) -> float:
        places = (first + np.arange(count)) % n
        period_s = min(periods_s[k] for k in frame.period_class[places])
        return float((2 * frame.legs_m[places[:-1]].sum() + 10 * np.pi) / 20 / period_s)

    for segments in (1, 3, 5):
        found = cutting.best(segments)
        assert sorted(np.concatenate(found.segments).tolist()) == list(range(n))
        assert len(found.segments) <= segments
        assert found.share == pytest.approx(min(by_brute_force(share, n, k) for k in range(1, segments + 1)))
    fewest = cutting.best()
    assert fewest.share <= 1 or len(fewest.segments) == n
    if len(fewest.segments) > 1:
        assert cutting.best(len(fewest.segments) - 1).share > 1
