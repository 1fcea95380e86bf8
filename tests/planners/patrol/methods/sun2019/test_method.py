"""The method as a whole: plans that the check passes, every stage exchangeable, what it cannot do told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from benchmarks.missions import EXAMPLES
from shapely import LinearRing, LineString, MultiPolygon, box

import rota
from rota.check import check_plan
from rota.errors import MissionError, NoPlanFound
from rota.files.mission_file import read_mission
from rota.geometry.free_space import standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot, SquareSensor, StartBox, Zone
from rota.planners.patrol.context import Context, begin_search
from rota.planners.patrol.ground.problem import common_robot, set_up_problem
from rota.planners.patrol.methods.sun2019.algorithms import Algorithms, SensorCover, deployments_tried
from rota.planners.patrol.methods.sun2019.mission_settings import Sun2019
from rota.planners.patrol.methods.sun2019.partition import partition_frame
from rota.planners.patrol.methods.sun2019.stages import cut_in_segments, framed_sensors, measure, share_out
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


def context_of(mission: Mission) -> Context:
    return begin_search(
        set_up_problem(mission), asked=mission, seed=0, judge=check_plan, progress=lambda share, what: None,
        should_stop=lambda: False,
    )  # fmt: skip


@pytest.mark.slow  # the longest search of this method
def test_figure_13_takes_no_more_robots_than_the_paper() -> None:
    plan = planned(replace(FIGURE_13, planning=QUICK))
    assert len(plan.trajectories) <= 5  # Table 5
    for one in plan:
        for obstacle in plan.mission.obstacles:
            assert LineString(one.positions_m).intersection(obstacle.shape.buffer(-1e-6)).is_empty


def test_deployment_frame_partition_and_routes_follow_from_each_other() -> None:
    mission = FIGURE_13
    space, robot = standing_space(mission, 0.0), common_robot(mission.fleet)
    paths, settings = ShortestPaths(space), Algorithms()
    framed = framed_sensors(mission, paths, settings.deployments[0], settings, seed=0)
    (part,) = framed.parts
    assert sorted(part.sensors[part.frame.order].tolist()) == list(range(len(framed.deployment.positions_m)))
    periods = framed.deployment.periods_s
    assert part.waypoint_periods_s.tolist() == periods[part.frame.order].tolist()
    stages = cut_in_segments(framed, robot, paths, settings)
    (partition,) = stages.partitions
    assert partition.kept
    for segment in stages.segments:
        # Eq. 26; borders and obstacles only cut the route, which is shorter for it
        assert segment.time_s * 20 == pytest.approx(2 * LineString(segment.line_m).length + 10 * np.pi)
        ring = LinearRing(segment.route_m)
        assert ring.difference(space.buffer(1e-6)).is_empty
        assert ring.length <= 1.02 * segment.time_s * 20
        assert segment.time_s < segment.period_s
    fewer = cut_in_segments(framed, robot, paths, settings, robots=len(stages.segments) - 1)
    assert len(fewer.segments) == len(stages.segments) - 1
    assert fewer.load > stages.load


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
        {"routes": "repaired"},
    ],
    ids=lambda stages: "-".join(stages),
)
def test_each_stage_is_exchangeable(stages: dict[str, str]) -> None:
    assert len(planned(with_stages(YARD, **stages)).trajectories) <= 8


def test_best_is_of_our_covers_alone_as_many_as_the_effort_allows() -> None:
    assert deployments_tried("best", "quick") == ("greedy",)
    for effort in ("normal", "high"):
        assert deployments_tried("best", effort) == ("greedy", "exact")
        covers = Sun2019().algorithms(effort).deployments
        assert [cover.method for cover in covers] == ["greedy", "exact"]
        assert all(isinstance(cover, SensorCover) for cover in covers)


def test_stages_are_read_from_mission_files_and_kept_in_plan_files(tmp_path: Path) -> None:
    text = """\
rota: 1
name: yard
area: [[0, 0], [12, 0], [12, 12], [0, 12]]
period_s: 60
fleet: {speed_m_s: 2, sensor: {shape: disc, radius_m: 5}}
patrol: {effort: quick, method: sun2019, sun2019: {deployment: exact, routes: repaired}}
"""
    (tmp_path / "yard.yaml").write_text(text)
    mission = rota.read_mission(tmp_path / "yard.yaml").mission
    stages = PatrolSettings.of(mission).method_settings
    assert stages == Sun2019(deployment="exact", routes="repaired")
    assert (stages.tour, stages.partition) == ("local_search", "exact")
    plan = planned(mission)
    rota.write_plan(plan, tmp_path / "yard.rota.json")
    assert rota.read_plan(tmp_path / "yard.rota.json") == plan


def test_routes_as_printed_leave_pockets_and_say_so() -> None:
    with pytest.raises(NoPlanFound, match="does not meet the demand") as caught:
        rota.make_plan(with_stages(YARD, routes="printed"))
    report = check_plan(caught.value.best)
    unseen_m2 = sum(demand.unseen_area_m2 for demand in report.demands)
    assert 0.005 * 2300 < unseen_m2 < 0.2 * 2300


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


def test_lengths_measured_on_routes_move_the_cuts() -> None:
    mission = FIGURE_13
    robot, settings = common_robot(mission.fleet), Algorithms()
    paths = ShortestPaths(standing_space(mission, 0.0))
    framed = framed_sensors(mission, paths, settings.deployments[0], settings, seed=0)
    stages = cut_in_segments(framed, robot, paths, settings)
    lengths = np.array([20 * segment.time_s for segment in stages.segments])
    alike = measure(stages, lengths, robot)
    assert alike.parts[0].legs_m == pytest.approx(framed.parts[0].legs_m)
    longer = lengths.copy()
    longer[0] += 60
    legs_m = measure(stages, longer, robot).parts[0].legs_m
    inner = stages.partitions[0].places(0, len(legs_m))[:-1]
    assert legs_m[inner].sum() == pytest.approx(framed.parts[0].legs_m[inner].sum() + 30)
    assert np.delete(legs_m, inner) == pytest.approx(np.delete(framed.parts[0].legs_m, inner))


def test_robots_are_shared_out_among_parts_by_their_load() -> None:
    parts = MultiPolygon([box(0, 0, 60, 40), box(70, 0, 90, 40)])
    mission = replace(YARD, area=parts, obstacles=(), zones=())
    robot, settings = common_robot(mission.fleet), Algorithms()
    framed = framed_sensors(mission, ShortestPaths(parts), settings.deployments[0], settings, seed=0)
    assert len(framed.parts) == 2
    counts = share_out(framed, robot, settings.partition, 4)
    assert sorted(counts) == [1, 3]
    assert sum(share_out(framed, robot, settings.partition, 9)) == 9
    assert share_out(framed, robot, settings.partition, 1) == [1, 1]


def by_brute_force(share: Callable[[int, int], float], n: int, segments: int) -> float:
    """The smallest largest share of all ways to cut a ring of n in so many segments."""
    from itertools import combinations

    def largest(cuts: tuple[int, ...]) -> float:
        return max(share(a, (b - a - 1) % n + 1) for a, b in zip(cuts, (*cuts[1:], cuts[0]), strict=True))

    return min(largest(cuts) for cuts in combinations(range(n), segments))


@pytest.mark.parametrize("seed", range(6))
def test_too_few_segments_are_late_alike(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, segments = 9, 3
    legs, periods = rng.uniform(5, 15, n), rng.choice([2.0, 3, 5], n)

    def share(first: int, count: int) -> float:
        places = (first + np.arange(count)) % n
        return float((2 * legs[places[:-1]].sum() + 10 * np.pi) / 20 / periods[places].min())

    found = partition_frame(legs, periods, speed_m_s=20, sensor_radius_m=5, segments=segments)
    assert len(found.first) == segments
    assert not found.kept
    assert (found.times_s / found.periods_s).max() == pytest.approx(by_brute_force(share, n, segments))
