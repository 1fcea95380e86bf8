"""How far clocks may differ: worked by hand, and against trajectories that are shifted and followed in small steps."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from shapely import box
from tests.check.accelerated import accelerated
from tests.seeds import seeds

from rota import BounceSettings, PatrolSettings
from rota.check import Report, check_plan
from rota.check.clocks import clock_margin_s
from rota.model.mission import DiscSensor, Fleet, Mission, Zone
from rota.model.plan import Plan, Trajectory

Floats = NDArray[np.float64]
BODY_M = 0.5


def plan_of(*trajectories: Trajectory, **settings: object) -> Plan:
    one = Fleet(speed_m_s=10.0, sensor=DiscSensor(radius_m=1.0), body_radius_m=BODY_M)
    robots = tuple(one.equal_robot(trajectory.robot) for trajectory in trajectories)
    area = box(-100, -100, 100, 100)
    zone = Zone(name="all", shape=area, period_s=1e6, demand="visit")
    planning = BounceSettings(cell_m=1.0, **settings)  # type: ignore[arg-type]
    mission = Mission(name="yard", area=area, zones=(zone,), fleet=replace(one, robots=robots), planning=planning)
    return Plan(mission=mission, trajectories=trajectories)


def way(robot: str, points: list[tuple[float, float, float]], loop_start_s: float | None = None) -> Trajectory:
    times, places = [p[0] for p in points], [p[1:] for p in points]
    return Trajectory(
        robot=robot, times_s=times, positions_m=places, loop_start_s=times[-1] if loop_start_s is None else loop_start_s
    )  # fmt: skip


def margin(*trajectories: Trajectory) -> float:
    found = clock_margin_s(plan_of(*trajectories))
    assert found is not None
    return found


def test_a_follower_may_be_as_early_as_its_distance_takes() -> None:
    """Two robots on one line at 1 m/s, 3 m apart with bodies of 0.5 m: 2 s, then they touch."""
    first = way("a", [(0, 0, 0), (50, 50, 0)])
    second = way("b", [(0, -3, 0), (40, 37, 0)])
    assert margin(first, second) == pytest.approx(2.0, abs=1e-5)


def test_ways_that_cross_at_right_angles() -> None:
    """Both at 1 m/s through (0, 0), at 10 and 12 s: nearest sqrt(2) / 2 per second that they differ, so sqrt(2) s."""
    first = way("a", [(0, -10, 0), (20, 10, 0)])
    second = way("b", [(0, 0, -12), (24, 0, 12)])
    assert margin(first, second) == pytest.approx(2 - math.sqrt(2), abs=1e-5)


def test_a_robot_that_waits_beside_a_way_is_passed_in_its_own_time() -> None:
    """It stands on the other's line until 5 s, and is gone 0.9 s later; the other comes within 1 m of it at 9 s."""
    passing = way("a", [(0, -10, 0), (20, 10, 0)])
    waiting = way("b", [(0, 0, 0), (5, 0, 0), (15, 0, 10)])
    found = margin(passing, waiting)
    assert found == pytest.approx(brute_margin(passing, waiting, 60), abs=0.02)


def test_a_robot_that_starts_off_one_s_way_from_rest() -> None:
    """It stands on the other's line until 5 s; the other, at 1 m/s, is 1 m from there at 12 s, as it is 2.45 m off."""
    passing = way("a", [(0, -10, 0), (3, -10, 0), (23, 10, 0)])
    starting = replace(way("b", [(0, 0, 0), (5, 0, 0), (15, 0, 5)]), accelerations_m_s2=[0, 0.1])
    # the other is x short of the line, and 1 m away, as this one is sqrt(1 - x^2) off, the least slack over all x
    x = np.linspace(0, 1, 1_000_001)
    slack_s = (13 - x) - (5 + np.sqrt(2 * np.sqrt(1 - x**2) / 0.1))
    found = margin(passing, starting)
    assert found == pytest.approx(slack_s.min(), abs=1e-5)
    assert found == pytest.approx(brute_margin(passing, starting, 60), abs=0.02)


def test_ways_that_never_come_near_and_bodies_that_touch_already() -> None:
    far = way("a", [(0, 0, 50), (20, 10, 50)])
    assert margin(far, way("b", [(0, 0, 0), (20, 10, 0)])) == math.inf
    assert margin(way("a", [(0, 0, 0), (9, 9, 0)]), way("b", [(0, 0.5, 0), (9, 9.5, 0)])) == 0.0


def test_loops_without_a_common_period_meet_in_every_phase() -> None:
    one = way("a", [(0, 0, 0), (1, 1, 0), (2, 0, 0)], 0)
    other = way("b", [(0, 0.5, 3), (1, 0.5, 0), (1 + math.sqrt(2), 0.5, 3)], 0)
    assert margin(one, other) == 0.0


def test_only_bouncing_robots_are_judged_and_one_alone_has_no_margin() -> None:
    plan = plan_of(way("a", [(0, 0, 0), (9, 9, 0)]))
    assert clock_margin_s(plan) is None
    two = plan_of(way("a", [(0, 0, 0), (9, 9, 0)]), way("b", [(0, 0, 5), (9, 9, 5)]))
    patrol = replace(two, mission=replace(two.mission, planning=PatrolSettings()))
    assert clock_margin_s(patrol) is None


def places_at(trajectory: Trajectory, times: Floats) -> Floats:
    """Places (n, 2); before 0 the robot has not begun to move."""
    return trajectory.at(times)


def brute_margin(one: Trajectory, other: Trajectory, until_s: float) -> float:
    """The smallest shift, either way, at which bodies overlap, by shifts of 5 ms and times of 10 ms."""
    times = np.arange(0.0, until_s, 0.01)
    there = places_at(one, times)
    for shift in np.arange(0.0, 6.0, 0.005):
        for signed in (shift, -shift):
            gap = there - places_at(other, times + signed)
            began = times + signed >= 0
            if (np.hypot(*gap.T)[began] < 2 * BODY_M - 1e-4).any():
                return float(shift)
    return math.inf


def random_loop(robot: str, rng: np.random.Generator, seconds: int) -> Trajectory:
    corners = rng.uniform(-4, 4, (5, 2))
    times = np.sort(rng.choice(np.arange(1, seconds), 4, replace=False))
    places = [*corners, corners[0]]
    return Trajectory(robot=robot, times_s=[0, *times, seconds], positions_m=places, loop_start_s=0)


@pytest.mark.parametrize("bent", [False, True])
@pytest.mark.parametrize("seed", seeds(12, at_once=4))
def test_random_loops_beside_shifted_ones(seed: int, bent: bool) -> None:
    rng = np.random.default_rng(seed)
    one, other = random_loop("a", rng, 12), random_loop("b", rng, 18)
    one, other = (accelerated(each, rng) if bent else each for each in (one, other))
    # a plan has bodies apart: the other is moved until they are
    drawn_m = other.positions_m
    for _ in range(400):
        found = margin(one, other)
        if 0.05 < found < 3:
            break
        other = replace(other, positions_m=drawn_m + rng.uniform(-8, 8, 2))
    assert 0.05 < found < 3
    assert found == pytest.approx(brute_margin(one, other, 36.0), abs=0.02)


def test_the_check_holds_a_plan_against_what_clocks_may_do() -> None:
    """0.5 % fast and 0.5 % slow for 60 s: 0.6 s, where the crossing leaves 0.586."""
    ways = way("a", [(0, -10, 0), (20, 10, 0)]), way("b", [(0, 0, -12), (24, 0, 12)])
    strict = check_plan(plan_of(*ways, clock_drift=0.005, clock_signal_s=60.0))
    assert of_clocks(strict) == ["clocks may differ"]
    assert strict.clock_margin_s == pytest.approx(2 - math.sqrt(2), abs=1e-5)
    assert not of_clocks(check_plan(plan_of(*ways, clock_drift=0.005, clock_signal_s=58.0)))
    # without a signal nothing can be promised
    assert not of_clocks(check_plan(plan_of(*ways, clock_drift=0.005)))


def of_clocks(report: Report) -> list[str]:
    """Violations of what clocks may do; these ways are on no cells, which is told besides."""
    return [violation.kind for violation in report.violations if violation.kind == "clocks may differ"]
