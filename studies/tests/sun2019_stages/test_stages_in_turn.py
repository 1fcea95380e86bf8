"""The stages one after the other, by whatever algorithm: what follows from what, and routes that are only printed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.missions import EXAMPLES
from shapely import LinearRing, LineString, MultiPolygon, box

import rota
from rota.check import check_plan
from rota.errors import NoPlanFound
from rota.files.mission_file import read_mission
from rota.geometry.free_space import standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota.planners.patrol.ground.problem import common_robot
from rota.planners.patrol.planner_settings import PatrolSettings
from rota_studies.sun2019_method.mission_settings import FrameSettings, SensorSettings, Sun2019
from rota_studies.sun2019_stages.algorithms import Algorithms
from rota_studies.sun2019_stages.partition import partition_frame
from rota_studies.sun2019_stages.stages import cut_in_segments, framed_sensors, measure, share_out

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


def with_stages(mission: Mission, **stages: object) -> Mission:
    return replace(mission, planning=replace(mission.planning, method_settings=Sun2019(**stages)))  # type: ignore[arg-type]


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


@pytest.mark.parametrize(
    "stages",
    [
        {"routes": "repaired"},
        {"sensors": SensorSettings(cell_m=2.0, border_cells="centre"), "frame": FrameSettings(distance="euclidean")},
    ],
    ids=lambda stages: "-".join(stages),
)
def test_what_rota_alone_does_not_do_is_done_here(stages: dict[str, object]) -> None:
    assert "rota_studies" in Sun2019(**stages).search  # type: ignore[arg-type]
    plan = rota.make_plan(with_stages(YARD, **stages), seed=0)
    assert check_plan(plan).verdict == "met"
    assert len(plan.trajectories) <= 8


def test_routes_as_printed_leave_pockets_and_say_so() -> None:
    with pytest.raises(NoPlanFound, match="does not meet the demand") as caught:
        rota.make_plan(with_stages(YARD, routes="printed"))
    report = check_plan(caught.value.best)
    unseen_m2 = sum(demand.unseen_area_m2 for demand in report.demands)
    assert 0.005 * 2300 < unseen_m2 < 0.2 * 2300


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
