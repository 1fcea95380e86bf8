"""Eq. 26 as printed: lengths of closed routes, against the routes themselves, and partitions by them."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.sun_tables import TABLE_4
from shapely import box

from rota.geometry.free_space import standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota.planners.patrol.ground.problem import common_robot
from rota.planners.patrol.methods.sun2019.route import route_round
from rota_studies.sun2019_method.algorithms import algorithms_of
from rota_studies.sun2019_method.mission_settings import Sun2019
from rota_studies.sun2019_method.partition import PartitionSettings, cut_frame
from rota_studies.sun2019_method.pso import rules_of
from rota_studies.sun2019_method.pso_kernels import cost_of
from rota_studies.sun2019_method.route_lengths import route_lengths_m, segment_lengths_m, segment_periods_s
from rota_studies.sun2019_stages.stages import Framed, cut_in_segments, framed_sensors, measure
from rota_studies.sun2019_stages.stretches import length_m, stretch_line

SMALL_SWARMS = replace(TABLE_4, swarms=20, particles=40)
SETTINGS = replace(algorithms_of(Sun2019(), "quick"), partition=SMALL_SWARMS)
MISSION = Mission(
    name="yard",
    area=box(0, 0, 70, 60),
    obstacles=(Obstacle(shape=box(20, 20, 50, 40), blocks="sight"),),  # routes go round it, and may go through
    zones=(Zone(name="gate", shape=box(40, 40, 65, 55), period_s=5),),
    period_s=20,
    fleet=Fleet(speed_m_s=20, sensor=DiscSensor(radius_m=5)),
)
PATHS = ShortestPaths(standing_space(MISSION, 0.0))


@pytest.fixture(scope="module")
def framed() -> Framed:
    return framed_sensors(MISSION, PATHS, SETTINGS.deployments[0], SETTINGS, seed=0)


def test_lengths_are_those_of_the_routes(framed: Framed) -> None:
    (part,) = framed.parts
    frame, n = part.frame, len(part.frame.order)
    found_m = route_lengths_m(frame, part.waypoint_periods_s, PATHS, speed_m_s=20, radius_m=5, joining_legs=False)
    assert found_m.shape == (n, n)
    allowed_m = 20 * segment_periods_s(part.waypoint_periods_s)
    estimate_m = 2 * segment_lengths_m(frame.legs_m, joining_legs=False) + 10 * np.pi
    rng = np.random.default_rng(4)
    near = np.argwhere(found_m <= 1.3 * allowed_m)
    for a, k in rng.permutation(near)[:200].tolist():
        line_m = stretch_line(frame, (a + np.arange(k + 1)) % n, joining_legs=False)
        really_m = length_m(route_round(line_m, PATHS, radius_m=5))
        assert found_m[a, k] == pytest.approx(really_m, rel=1e-9)
    far = estimate_m > 3 * allowed_m
    assert found_m[far].tolist() == estimate_m[far].tolist()
    assert (found_m[~far & (found_m > 1.3 * allowed_m)] > 0).all()


def test_the_routes_that_are_led_are_as_long_as_the_partition_counted(framed: Framed) -> None:
    stages = cut_in_segments(framed, common_robot(MISSION.fleet), PATHS, SETTINGS)
    for segment in stages.segments:
        assert segment.time_s == pytest.approx(length_m(segment.route_m) / 20)


def test_measured_routes_move_the_cuts_by_their_lengths(framed: Framed) -> None:
    robot = common_robot(MISSION.fleet)
    stages = cut_in_segments(framed, robot, PATHS, SETTINGS)
    driven_m = np.array([20 * segment.time_s for segment in stages.segments])
    alike = measure(stages, driven_m, robot)
    assert alike.parts[0].legs_m == pytest.approx(framed.parts[0].legs_m)
    driven_m[0] *= 1.5
    inner = stages.partitions[0].places(0, len(framed.parts[0].legs_m))[:-1]
    longer = measure(stages, driven_m, robot)
    assert longer.parts[0].legs_m[inner] == pytest.approx(1.5 * framed.parts[0].legs_m[inner])
    again = cut_in_segments(longer, robot, PATHS, SETTINGS)
    times_s = {tuple(one.line_m[0]): one.time_s for one in again.segments}
    first = stages.segments[0]
    assert times_s.get(tuple(first.line_m[0]), np.inf) != pytest.approx(first.time_s)


def by_eq_28(first: tuple[int, ...], routes_m: np.ndarray, periods_s: np.ndarray, settings: PartitionSettings) -> float:
    n, rules, total = len(routes_m), rules_of(settings), 0.0
    for at, then in zip(first, (*first[1:], first[0]), strict=True):
        count = (then - at - 1) % n + 1
        period_s = min(periods_s[(at + k) % n] for k in range(count))
        total += cost_of(routes_m[at, count - 1] / 2.0 - period_s + settings.margin_s, rules)
    return total


@pytest.mark.parametrize("seed", range(6))
def test_the_cheapest_partition_is_the_cheapest_of_all(seed: int) -> None:
    # lengths at random, so that longer segments have shorter routes as often as not
    rng = np.random.default_rng(seed)
    n, settings = 7, PartitionSettings(times="routes", margin_s=0.5, weight_late=float(rng.choice([50, 300, 5000])))
    routes_m, periods_s = rng.uniform(5, 60, (n, n)), rng.choice([8.0, 12, 20], n)
    for segments in (None, 1, 3, n):
        found = cut_frame(
            np.ones(n), periods_s, speed_m_s=2, sensor_radius_m=1, segments=segments, route_lengths_m=routes_m,
            settings=settings,
        )  # fmt: skip
        counts = range(1, n + 1) if segments is None else [segments]
        costs = [
            by_eq_28(first, routes_m, periods_s, settings)
            for count in counts
            for first in itertools.combinations(range(n), count)
        ]
        assert found.cost == pytest.approx(min(costs))
        assert by_eq_28(tuple(found.first.tolist()), routes_m, periods_s, settings) == pytest.approx(found.cost)
        assert segments is None or len(found.first) == segments


def test_swarms_come_near_the_cheapest_partition(framed: Framed) -> None:
    (part,) = framed.parts
    cheapest, swarms = (
        cut_frame(
            part.legs_m, part.waypoint_periods_s, speed_m_s=20, sensor_radius_m=5,
            route_lengths_m=part.route_lengths_m, settings=settings,
        )
        for settings in (replace(SMALL_SWARMS, method="exact"), replace(TABLE_4, swarms=60, particles=200))
    )  # fmt: skip
    assert cheapest.cost <= swarms.cost <= 1.15 * cheapest.cost
    assert abs(len(swarms.first) - len(cheapest.first)) <= 1


def test_lengths_that_cannot_be_are_refused() -> None:
    for wrong in (np.ones((2, 3)), np.zeros((2, 2)), np.full((2, 2), np.nan)):
        with pytest.raises(ValueError, match=r"route_lengths_m: .*must be \(2, 2\) finite numbers"):
            cut_frame(np.ones(2), np.ones(2), speed_m_s=1, sensor_radius_m=1, route_lengths_m=wrong, settings=TABLE_4)
