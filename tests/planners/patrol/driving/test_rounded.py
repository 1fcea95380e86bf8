"""Rounds of robots with mass: closed forms, limits kept at every moment, and a search for anything faster."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from shapely import LineString, distance, points

from rota.check.accelerations import acceleration_violations
from rota.model.mission import DiscSensor, Fleet, Robot
from rota.model.motion_limits import MotionLimits
from rota.model.plan import Trajectory
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.driving.rounded import Rounded
from rota.planners.patrol.driving.timed_line import TimedLine, start_at
from rota.planners.patrol.tours.timetable import as_trajectories

Floats = NDArray[np.float64]
SQUARE = np.array([[0.0, 0], [50, 0], [50, 50], [0, 50]])
NEARLY = 2e-3  # limits are planned a thousandth below what they are


def robot(speed_m_s: float = 8.0, **limits: float) -> Robot:
    motion = MotionLimits(acceleration_m_s2=limits.pop("acceleration_m_s2", 3.0), **limits)  # type: ignore[arg-type]
    return Fleet(speed_m_s=speed_m_s, sensor=DiscSensor(radius_m=5), motion=motion).equal_robot("r")


def seconds(vertices_m: Floats, one: Robot) -> float:
    driving = driving_of(one)
    return driving.round_m(vertices_m) / driving.pace_m_s


def velocities(line: TimedLine) -> tuple[Floats, Floats]:
    """Velocities (k, 2) at which legs begin and end."""
    steps, lasts_s = np.diff(line.places_m, axis=0), np.diff(line.times_s)[:, None]
    units = steps / np.maximum(np.hypot(*steps.T), 1e-300)[:, None]
    change = units * line.accelerations_m_s2[:, None] * lasts_s / 2
    return steps / lasts_s - change, steps / lasts_s + change


def test_who_stops_at_corners_takes_a_ramp_more_at_either_end_of_a_leg() -> None:
    # v / a more for each leg that is long enough to get to full speed: v^2 / a = 21.3 m
    assert seconds(SQUARE, robot()) == pytest.approx(4 * (50 / 8 + 8 / 3), rel=NEARLY)
    # 2 sqrt(L / a) where it is not
    assert seconds(SQUARE / 5, robot()) == pytest.approx(4 * 2 * math.sqrt(10 / 3), rel=NEARLY)


def test_a_rounded_right_angle_in_closed_form() -> None:
    # a parabola that passes 1 m from the corner: v^2 sin^2(45) / (2 a) = 1, T = 2 v sin(45) / a; it begins v T / 2 off
    v = math.sqrt(2 * 3 * 1 / 0.5)
    turn_s = 2 * v * math.sqrt(0.5) / 3
    straight_m = 50 - v * turn_s
    ramps_m, ramps_s = (64 - v * v) / 3, 2 * (8 - v) / 3
    whole_s = 4 * (turn_s + ramps_s + (straight_m - ramps_m) / 8)
    assert seconds(SQUARE, robot(corner_m=1.0)) == pytest.approx(whole_s, rel=NEARLY)
    line = driving_of(robot(corner_m=1.0)).timed(SQUARE)
    off_m = distance(points(SQUARE), LineString(line.places_m))
    assert off_m == pytest.approx([1.0] * 4, abs=0.06)


def test_an_s_curve_takes_as_much_longer_as_the_jerk_needs_to_build_up() -> None:
    # from rest to v: v / a + a / j, here with legs long enough for it
    slow = seconds(SQUARE, robot(jerk_m_s3=4.0))
    assert slow == pytest.approx(4 * (50 / 8 + 8 / 3 + 3 / 4), rel=NEARLY)


@pytest.mark.parametrize("limits", [{}, {"corner_m": 1.0}, {"corner_m": 2.5, "corner_acceleration_m_s2": 5.0}])
@pytest.mark.parametrize("jerk", [{}, {"jerk_m_s3": 4.0}])
def test_random_rounds_keep_every_limit(limits: dict[str, float], jerk: dict[str, float]) -> None:
    rng = np.random.default_rng(0)
    one = robot(**limits, **jerk)
    driving = Rounded(one)
    along = 3.0
    for _ in range(60):
        ring = rng.uniform(0, rng.choice([6.0, 60.0, 300.0]), (int(rng.integers(2, 12)), 2))
        line = driving.timed(ring)
        assert line.duration_s == pytest.approx(seconds(ring, one), rel=1e-9)
        assert line.places_m[0].tolist() == line.places_m[-1].tolist()
        begins, ends = velocities(line)
        assert max(np.hypot(*begins.T).max(), np.hypot(*ends.T).max()) <= 8
        assert np.abs(line.accelerations_m_s2).max() <= along
        way = Trajectory(
            robot="r",
            times_s=line.times_s,
            positions_m=line.places_m,
            accelerations_m_s2=line.accelerations_m_s2,
        )
        assert [each.text() for each in acceleration_violations(way, one)] == []
        assert distance(points(line.places_m), LineString(np.vstack([ring, ring[:1]]))).max() <= driving.off_m + 1e-6


def test_no_other_speeds_at_corners_are_faster() -> None:
    # speeds at three corners by brute force: all that legs leave room for, ramps and parabolas by hand
    rng = np.random.default_rng(1)
    a = 3.0 * (1 - 1e-3)
    for _ in range(5):
        ring = rng.uniform(0, 40, (3, 2))
        legs = np.roll(ring, -1, axis=0) - ring
        lengths = np.hypot(*legs.T)
        cosines = (legs * np.roll(legs, 1, axis=0)).sum(axis=1) / (lengths * np.roll(lengths, 1))
        sines = np.sqrt((1 - cosines) / 2)
        speeds = np.stack(np.meshgrid(*[np.linspace(0.2, 8, 79)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        off_m, half_m = speeds**2 * sines**2 / (2 * a), speeds**2 * sines / a
        to, to_half = np.roll(speeds, -1, axis=1), np.roll(half_m, -1, axis=1)
        room_m = lengths - half_m - to_half
        possible = (off_m <= 1.0).all(axis=1) & (room_m >= np.abs(to**2 - speeds**2) / (2 * a)).all(axis=1)
        peak = np.minimum(8.0, np.sqrt(np.maximum((2 * a * room_m + speeds**2 + to**2) / 2, 1e-9)))
        ramps_m = (2 * peak**2 - speeds**2 - to**2) / (2 * a)
        leg_s = (2 * peak - speeds - to) / a + (room_m - ramps_m) / peak
        whole_s = (2 * speeds * sines / a + leg_s).sum(axis=1)
        fastest_s = float(whole_s[possible].min())
        found_s = seconds(ring, robot(corner_m=1.0))
        assert found_s <= fastest_s * (1 + 1e-3)
        assert found_s >= fastest_s * (1 - 0.02)  # a tenth of a metre per second apart


def test_a_robot_that_turns_on_the_spot_stops_and_turns() -> None:
    turning = replace(robot(), turn_rate_rad_s=0.5)
    assert seconds(SQUARE, turning) == pytest.approx(4 * (50 / 8 + 8 / 3 + math.pi), rel=NEARLY)
    line = driving_of(turning).timed(SQUARE)
    pauses = np.diff(line.times_s)[(np.diff(line.places_m, axis=0) == 0).all(axis=1)]
    assert pauses == pytest.approx([math.pi] * 4, rel=1e-5)


def test_places_on_the_way_follow_the_ramps() -> None:
    line = driving_of(robot()).timed(SQUARE)
    # from rest at the first corner: a t^2 / 2
    assert line.at(np.array([1.0]))[0] == pytest.approx([1.5, 0], rel=NEARLY)
    back = line.backwards()
    assert back.at(line.duration_s - np.array([1.0, 20.0])) == pytest.approx(line.at(np.array([1.0, 20.0])))


def test_a_start_from_rest_gets_to_its_speed_where_it_is_to() -> None:
    driving = Rounded(robot())
    way = driving.run_up(np.array([10.0, 5.0]), np.array([0.0, 1.0]), 6.0)
    assert way.places_m[0] == pytest.approx([10, 5 - 6], abs=0.01)  # v^2 / (2 a)
    assert velocities(way)[1][-1] == pytest.approx([0, 6])


def test_a_loop_may_begin_in_the_midst_of_any_leg() -> None:
    # the same curves of tangents, begun anywhere: where a loop begins says nothing of what can be driven
    rng = np.random.default_rng(5)
    motion = MotionLimits(acceleration_m_s2=3.0, corner_m=1.0)
    one = Fleet(speed_m_s=8, sensor=DiscSensor(radius_m=5), motion=motion).equal_robot("r")
    for _ in range(20):
        line = driving_of(one).timed(rng.uniform(0, 60, (6, 2)))
        for phase_s in rng.uniform(0, line.duration_s, 10):
            (begun,) = as_trajectories([start_at(line, float(phase_s))], ["r"])
            assert acceleration_violations(begun, one) == []
            # and what cannot be driven is found wherever it begins: a tenth faster
            faster = start_at(line, float(phase_s))
            hurried = TimedLine(faster.times_s / 1.1, faster.places_m, faster.accelerations_m_s2 * 1.21)
            (begun,) = as_trajectories([hurried], ["r"])
            assert acceleration_violations(begun, one)


def test_vertices_that_hardly_turn_take_no_time_from_the_windows_beside_them() -> None:
    # a bend of a degree, braked for, 5 m after a vertex that turns by 1e-9 to 1e-4 rad
    one = robot(20.0, corner_m=1.0)
    for turn in 10.0 ** np.arange(-9, -3):
        headings = np.cumsum([0.0, turn, 0.02, 0.02, math.pi / 2])
        ends = np.cumsum(4.8 * np.column_stack([np.cos(headings), np.sin(headings)]), axis=0)
        line = driving_of(one).timed(np.vstack([[-40.0, 0.0], [0.0, 0.0], ends, [-40.0, 20.0]]))
        (begun,) = as_trajectories([line], ["r"])
        assert acceleration_violations(begun, one) == []


@pytest.mark.parametrize("limits", [{"corner_m": 1.0}, {"corner_m": 1.0, "corner_acceleration_m_s2": 5.0}, {}])
def test_slopes_are_differences_of_rounds(limits: dict[str, float]) -> None:
    one, rng = driving_of(robot(20.0, **limits)), np.random.default_rng(3)
    turns = np.linspace(0, 2 * math.pi, 9)[:-1]
    ring = np.column_stack([40 * np.cos(turns), 30 * np.sin(turns)]) + rng.uniform(-4, 4, (8, 2))
    ring = np.insert(ring, 3, ring[2:4].mean(axis=0), axis=0)  # one vertex on a straight way
    assert one.slopes is not None
    growth, bends = one.slopes(ring)
    for v, axis in np.ndindex(ring.shape):
        move = np.zeros_like(ring)
        move[v, axis] = 0.02
        ahead, back, here = one.round_m(ring + move), one.round_m(ring - move), one.round_m(ring)
        assert growth[v, axis] == pytest.approx((ahead - back) / 0.04, abs=1e-4)
        assert bends[v, axis] == pytest.approx(max(0.0, (ahead + back - 2 * here) / 0.04), abs=1e-4)
