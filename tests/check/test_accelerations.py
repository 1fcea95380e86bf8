"""Accelerations: closed forms, the tangents of parabolas, and the motion that a kept plan promises, built by itself."""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.seeds import seeds

from rota.check.accelerations import acceleration_violations
from rota.check.motion import speed_violations
from rota.check.report import Violation
from rota.check.tolerances import OFF_M
from rota.model.mission import DiscSensor, Robot
from rota.model.motion_limits import MotionLimits
from rota.model.plan import Trajectory
from rota.routes.moments import go_on

Floats = NDArray[np.float64]


def robot(**limits: Any) -> Robot:
    return Robot(name="a", speed_m_s=20, sensor=DiscSensor(radius_m=5), motion=MotionLimits(**limits))


def found(way: Trajectory, **limits: Any) -> list[Violation]:
    return acceleration_violations(way, robot(**limits))


def driven(legs: list[tuple[float, Any, float]], *, loop: bool = False) -> Trajectory:
    """Legs one after the other: seconds, the mean velocity (2,), and the acceleration along it."""
    seconds, velocities, accelerations = zip(*legs, strict=True)
    steps = np.array(velocities, float) * np.array(seconds)[:, None]
    places = np.vstack([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    if loop:
        assert np.abs(places[-1]).max() < 1e-9
        places[-1] = places[0]
    times = np.concatenate([[0.0], np.cumsum(seconds)])
    start = 0.0 if loop else times[-1]
    return Trajectory(
        robot="a", times_s=times, positions_m=places, accelerations_m_s2=accelerations, loop_start_s=start
    )


def tangents(velocity: Any, acceleration: Any, lasts_s: float, parts: int) -> list[tuple[float, Any, float]]:
    """A parabola as legs along its tangents."""
    step_s = lasts_s / parts
    velocities = np.array(velocity, float) + np.arange(parts + 1)[:, None] * step_s * np.array(acceleration, float)
    return [(step_s / (2 if k in (0, parts) else 1), each, 0.0) for k, each in enumerate(velocities)]


def ramp(direction: Any, begin_m_s: float, end_m_s: float, most_m_s2: float) -> tuple[float, Any, float]:
    """A leg whose speed changes at a constant acceleration."""
    sign = math.copysign(1.0, end_m_s - begin_m_s)
    mean = (begin_m_s + end_m_s) / 2
    return abs(end_m_s - begin_m_s) / most_m_s2, mean * np.array(direction, float), sign * most_m_s2


def rounded_square(most_m_s2: float = 3.0, corner_m_s2: float = 3.0) -> Trajectory:
    """A square whose corners are parabolas driven at 5 m/s, at the limit, between sides driven at 8 m/s."""
    ways, legs = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)], float), []
    for way, after in zip(ways, np.roll(ways, -1, axis=0), strict=True):
        legs += [ramp(way, 5, 8, most_m_s2), (2.0, 8 * way, 0.0), ramp(way, 8, 5, most_m_s2)]
        change = 5 * (after - way)
        lasts_s = float(np.hypot(*change)) / corner_m_s2
        parts = math.ceil(lasts_s / math.sqrt(8 * OFF_M / corner_m_s2) - 1e-9)
        legs += tangents(5 * way, change / lasts_s, lasts_s, parts)
    return driven(legs, loop=True)


# ------------------------------------------------------------------ closed forms


def test_a_start_from_rest_and_a_stop_keep_the_limit_exactly() -> None:
    way = driven([ramp((1, 0), 0, 6, 2), (3.0, (6, 0), 0.0), ramp((1, 0), 6, 0, 2)])
    assert found(way, acceleration_m_s2=2) == []
    wrong = found(way, acceleration_m_s2=1.9)
    assert [(each.kind, each.value, each.limit, each.time_s) for each in wrong] == [
        ("acceleration", pytest.approx(2), 1.9, 0.0),
        ("acceleration", pytest.approx(2), 1.9, 6.0),
    ]


def test_a_robot_begins_and_ends_at_rest() -> None:
    """At 6 m/s at once: within 5 cm a window of 1 / 30 s is left, which asks for 90 m/s2."""
    at_once = driven([(3.0, (6, 0), 0.0)])
    wrong = found(at_once, acceleration_m_s2=2)
    assert [(each.kind, each.time_s) for each in wrong] == [("acceleration", 0.0), ("acceleration", 3.0)]
    assert [each.value for each in wrong] == pytest.approx([90, 90])
    assert wrong[1].place_m == pytest.approx((18, 0))
    to_and_fro = Trajectory(robot="a", times_s=[0, 3, 6], positions_m=[(0, 0), (18, 0), (0, 0)])
    # a loop that begins at 0 is under way; its turns ask for 12 m/s at once
    assert {each.time_s for each in found(to_and_fro, acceleration_m_s2=2)} == {0.0, 3.0}
    wait = Trajectory(robot="a", times_s=[0, 3], positions_m=[(0, 0), (0, 0)])
    assert found(wait, acceleration_m_s2=2) == []
    assert found(Trajectory(robot="a", times_s=[0], positions_m=[(0, 0)]), acceleration_m_s2=2) == []


def test_speeds_may_jump_as_far_as_five_centimetres_smooth_it() -> None:
    """A jump J takes J / (2 A) either side, and is off by J^2 / (8 A)."""
    most = math.sqrt(8 * OFF_M * 2)
    for jump, kept in ((0.999 * most, True), (1.001 * most, False)):
        way = driven(
            [ramp((1, 0), 0, 4, 1.5), (2.0, (4, 0), 0.0), (2.0, (4 + jump, 0), 0.0), ramp((1, 0), 4 + jump, 0, 1)]
        )
        wrong = found(way, acceleration_m_s2=2)
        assert (wrong == []) == kept
        if not kept:
            assert (wrong[0].kind, wrong[0].value) == ("acceleration", pytest.approx(jump**2 / (8 * OFF_M)))


def test_windows_of_two_jumps_do_not_overlap() -> None:
    """0.4 m/s more and back again, at 2 m/s2: each takes 0.1 s either side, so that 0.2 s must lie between."""
    for between_s, kept in ((0.2001, True), (0.1999, False)):
        way = driven(
            [ramp((1, 0), 0, 4, 2), (1, (4, 0), 0), (between_s, (4.4, 0), 0), (1, (4, 0), 0), ramp((1, 0), 4, 0, 2)]
        )
        assert (found(way, acceleration_m_s2=2) == []) == kept


def test_a_jump_adds_to_what_the_leg_accelerates() -> None:
    """Beside a leg that is at the limit there is no room for more of it; against it there is."""
    more = driven([ramp((1, 0), 0, 4, 2), (2.0, (4.1, 0), 0.0), ramp((1, 0), 4.1, 0, 2)])
    less = driven([ramp((1, 0), 0, 4, 2), (2.0, (3.9, 0), 0.0), ramp((1, 0), 3.9, 0, 2)])
    assert [each.time_s for each in found(more, acceleration_m_s2=2)] == [2.0]
    assert found(more, acceleration_m_s2=2.2) == []
    assert found(less, acceleration_m_s2=2) == []


def test_a_corner_at_speed_cannot_be_driven_and_a_stop_there_can() -> None:
    corner = driven([ramp((1, 0), 0, 4, 2), (1.0, (4, 0), 0.0), (1.0, (0, 4), 0.0), ramp((0, 1), 4, 0, 2)])
    (wrong,) = found(corner, acceleration_m_s2=2)
    assert (wrong.kind, wrong.time_s, wrong.limit, wrong.unit) == ("corner acceleration", 3.0, 2.0, "m/s2")
    assert wrong.place_m == pytest.approx((8, 0))
    assert wrong.value == pytest.approx(32 / (8 * OFF_M))
    stop = driven([ramp((1, 0), 0, 4, 2), ramp((1, 0), 4, 0, 2), ramp((0, 1), 0, 4, 2), ramp((0, 1), 4, 0, 2)])
    assert found(stop, acceleration_m_s2=2) == []


@pytest.mark.parametrize("corner", [1.0, 3.0, 5.0])
def test_tangents_of_a_parabola_keep_its_acceleration_exactly(corner: float) -> None:
    way = rounded_square(3.0, corner)
    limits = {"acceleration_m_s2": 3.0, "corner_acceleration_m_s2": corner}
    assert found(way, **limits) == []
    wrong = found(way, **{**limits, "corner_acceleration_m_s2": 0.99 * corner})
    assert {each.kind for each in wrong} == {"corner acceleration"}
    assert all(each.value == pytest.approx(corner, rel=0.02) for each in wrong)
    assert {each.kind for each in found(way, **{**limits, "acceleration_m_s2": 2.99})} >= {"acceleration"}


@pytest.mark.parametrize("moment_s", [1e-6, 1e-9, 1e-10, 1e-11])
def test_a_leg_of_a_moment_hides_no_corner(moment_s: float) -> None:
    """Nobody can tell its velocity, but there and back at 5 m/s is a jump by 10 m/s, at the seam, too."""
    way = driven([(10, (5, 0), 0), (moment_s, (0, 0), 0), (10, (-5, 0), 0), (moment_s, (0, 0), 0)], loop=True)
    assert {round(each.time_s or 0.0, 5) for each in found(way, acceleration_m_s2=1.0)} == {0.0, 10.0}


@pytest.mark.parametrize(("bend_rad", "kinds"), [(0.098, set()), (math.pi / 2, {"corner acceleration"})])
def test_rows_without_end_hide_no_curve(bend_rad: float, kinds: set[str]) -> None:
    """At 5 m/s in half a second, by legs each of which bends by less than rounding might: a curve of 1 and 16 m/s2."""
    chance, count = np.random.default_rng(3), 50_000
    seconds = chance.uniform(0.9e-5, 1.1e-5, count)
    at = (np.cumsum(seconds) - seconds / 2) / seconds.sum() * bend_rad
    on = (math.cos(bend_rad), math.sin(bend_rad))
    before = [ramp((1, 0), 0.0, 5.0, 1.0), (2.0, (5.0, 0), 0.0)]
    curve = [(s, (5 * math.cos(angle), 5 * math.sin(angle)), 0.0) for s, angle in zip(seconds, at, strict=True)]
    way = driven([*before, *curve, (2.0, (5 * on[0], 5 * on[1]), 0.0), ramp(on, 5.0, 0.0, 1.0)])
    assert {each.kind for each in found(way, acceleration_m_s2=1.0)} == kinds


@pytest.mark.parametrize("leg_s", [0.9e-6, 1e-4])
def test_legs_that_tell_no_velocity_hide_no_round(leg_s: float) -> None:
    """At 10 m/s a whole circle in 0.1 s, at 628 m/s2, in 111,000 legs none of which tells how fast, or 1,000."""
    count = round(0.1 / leg_s)
    angles = np.linspace(0, 2 * math.pi, count)
    circle = [(leg_s, (10 * math.cos(angle), 10 * math.sin(angle)), 0.0) for angle in angles]
    straight = (2.0, (10.0, 0.0), 0.0)
    way = driven([ramp((1, 0), 0, 10, 1.0), straight, *circle, straight, ramp((1, 0), 10, 0, 1.0)])
    assert {each.kind for each in found(way, acceleration_m_s2=1.0)} == {"corner acceleration"}


@pytest.mark.parametrize(("leg_s", "far_m"), [(5e-5, 0.0), (5e-4, 5e6)])
@pytest.mark.parametrize(("turn", "kinds"), [(0.04, set()), (0.12, set()), (0.4, {"corner acceleration"})])
def test_rows_of_short_legs_take_no_room_from_a_corner(
    leg_s: float, far_m: float, turn: float, kinds: set[str]
) -> None:
    """At 5 m/s and 1 m/s2, a second before and after it in short legs; brute force drives the turns that are right."""
    ways, count = np.array([(1.0, 0.0), (math.cos(turn), math.sin(turn))]), round(1 / leg_s)
    rows = [[(leg_s, 5 * on, 0.0)] * count for on in ways]
    way = driven([ramp(ways[0], 0, 5, 0.999), *rows[0], *rows[1], ramp(ways[1], 5, 0, 0.999)])
    way = dataclasses.replace(way, positions_m=way.positions_m + far_m)
    assert {each.kind for each in found(way, acceleration_m_s2=1.0)} == kinds
    jump_m_s, corner_s = float(np.hypot(*(5 * ways[1] - 5 * ways[0]))), 5 / 0.999 + 1
    h_s = jump_m_s / 2  # either way: the velocity changes evenly, at 1 m/s2
    times_s = np.linspace(corner_s - 0.9, corner_s + 0.9, 18_001)
    share = np.clip((times_s - corner_s + h_s) / (2 * h_s), 0, 1)[:, None]
    velocity = 5 * (ways[0] + share * (ways[1] - ways[0]))
    steps = (velocity[1:] + velocity[:-1]) / 2 * np.diff(times_s)[:, None]
    places_m = way.at(times_s[0]) + np.vstack([[0.0, 0.0], np.cumsum(steps, axis=0)])
    assert np.hypot(*np.diff(velocity, axis=0).T).max() / np.diff(times_s).min() <= 1 + 1e-6
    assert (np.hypot(*(places_m - way.at(times_s)).T).max() <= OFF_M) == (not kinds)


@pytest.mark.parametrize(("lateral_m_s2", "kinds"), [(0.99, set()), (1.7, {"corner acceleration"})])
def test_far_away_legs_below_a_millisecond_hide_no_curve(lateral_m_s2: float, kinds: set[str]) -> None:
    """At 5 m/s for 2 s, in legs of 0.11 ms, of which rounding at the northings of UTM hides 4e-4 m/s each."""
    angles = np.arange(18_000) * 1.1e-4 * lateral_m_s2 / 5
    curve = [(1.1e-4, (5 * math.cos(angle), 5 * math.sin(angle)), 0.0) for angle in angles]
    on = (math.cos(angles[-1]), math.sin(angles[-1]))
    straight = (2.0, (5 * on[0], 5 * on[1]), 0.0)
    way = driven([ramp((1, 0), 0, 5, 0.999), (2.0, (5.0, 0), 0.0), *curve, straight, ramp(on, 5, 0, 0.999)])
    way = dataclasses.replace(way, positions_m=way.positions_m + 5e6)
    assert {each.kind for each in found(way, acceleration_m_s2=1.0)} == kinds


@pytest.mark.parametrize(("limit_m_s2", "kinds"), [(35.0, set()), (4.0, {"corner acceleration"})])
def test_loops_of_short_legs_alone_hide_no_curve(limit_m_s2: float, kinds: set[str]) -> None:
    """Round and round at 5 m/s in a second, at 31.4 m/s2."""
    angles = np.linspace(0, 2 * math.pi, 200_000, endpoint=False)
    way = driven([(5e-6, (5 * math.cos(angle), 5 * math.sin(angle)), 0.0) for angle in angles], loop=True)
    assert {each.kind for each in found(way, acceleration_m_s2=limit_m_s2)} == kinds


def test_a_leg_of_a_moment_in_a_ramp_changes_nothing() -> None:
    begin, end = ramp((1, 0), 0.0, 4.0, 2.0), ramp((1, 0), 4.0, 0.0, 2.0)
    for parts in (1.0, 1e-7), (1e-7, 1.0):
        cut = [(0.5 * parts[0], (parts[0] / 2, 0), 2.0), (0.5 * parts[1], (parts[0] + parts[1] / 2, 0), 2.0)]
        rest_s = 2.0 - 0.5 * sum(parts)
        cut.append((rest_s, (4.0 - rest_s, 0), 2.0))
        assert found(driven([*cut, (3, (4, 0), 0), end]), acceleration_m_s2=2.0) == []
    assert found(driven([begin, (3, (4, 0), 0), end]), acceleration_m_s2=2.0) == []


def test_the_seam_of_a_loop_is_a_vertex_like_the_others() -> None:
    """The same loop, begun in the middle of a rounding, of a ramp, and at its beginning."""
    way = rounded_square()
    for begin in range(len(way.times_s) - 1):
        times = np.concatenate([way.times_s[begin:], way.times_s[1 : begin + 1] + way.times_s[-1]])
        places = np.vstack([way.positions_m[begin:], way.positions_m[1 : begin + 1]])
        assert way.accelerations_m_s2 is not None
        turned = Trajectory(
            robot="a", times_s=times - times[0], positions_m=places,
            accelerations_m_s2=np.roll(way.accelerations_m_s2, -begin),
        )  # fmt: skip
        assert found(turned, acceleration_m_s2=3) == []
        assert len(found(turned, acceleration_m_s2=2.99)) == len(found(way, acceleration_m_s2=2.99))


def test_robots_without_limits_are_judged_by_their_speed_alone() -> None:
    way = driven([ramp((1, 0), 0, 30, 90)])
    assert acceleration_violations(way, robot()) == []
    (wrong,) = speed_violations(way, robot())
    assert (wrong.kind, wrong.value, wrong.limit) == ("speed", pytest.approx(30), 20)
    assert speed_violations(driven([ramp((1, 0), 0, 20, 90)]), robot()) == []


# ------------------------------------------------------------------ jerk


def test_a_ramp_of_three_parts_keeps_the_jerk_exactly() -> None:
    """2 m/s2 and 4 m/s3: half of it for half a second, then all of it, then half again."""
    ways = [(0.0, 0.5, 1.0), (0.5, 4.5, 2.0), (4.5, 5.0, 1.0)]
    up = [ramp((1, 0), *part) for part in ways]
    down = [ramp((1, 0), end, begin, most) for begin, end, most in ways[::-1]]
    way = driven([*up, *down])
    assert found(way, acceleration_m_s2=2, jerk_m_s3=4) == []
    wrong = found(way, acceleration_m_s2=2, jerk_m_s3=3.9)
    assert {each.kind for each in wrong} == {"jerk"}
    assert (wrong[0].value, wrong[0].unit, wrong[0].time_s) == (pytest.approx(4), "m/s3", pytest.approx(3.0))
    # cut into many legs it is the same motion
    fine = []
    for seconds, mean, acceleration in [*up, *down]:
        for k in range(5):
            fine.append((seconds / 5, mean + np.array([acceleration * seconds * (k - 2) / 5, 0]), acceleration))
    assert found(driven(fine), acceleration_m_s2=2, jerk_m_s3=4) == []
    assert [each.value for each in found(driven(fine), acceleration_m_s2=2, jerk_m_s3=3.9)] == pytest.approx([4.0])


def test_full_acceleration_at_once_breaks_the_jerk() -> None:
    way = driven([ramp((1, 0), 0, 2, 2), ramp((1, 0), 2, 0, 2)])
    (wrong,) = found(way, acceleration_m_s2=2, jerk_m_s3=3)
    assert (wrong.kind, wrong.value, wrong.time_s) == ("jerk", pytest.approx(4), 1.0)  # 4 m/s2 from 1 s to the next
    assert found(way, acceleration_m_s2=2, jerk_m_s3=4) == []


def corners() -> tuple[Trajectory, float]:
    """Four corners at 5 m/s and 3 m/s2, 2.36 s each, a second apart, and the jerk: by 3 m/s2 in 1.68 s."""
    legs, ways, corner_s = [], np.array([(5, 0), (0, 5), (-5, 0), (0, -5)], float), math.hypot(5, 5) / 3
    for way, after in zip(ways, np.roll(ways, -1, axis=0), strict=True):
        legs += [(1.0, way, 0.0), *tangents(way, (after - way) / corner_s, corner_s, 7)]
    return driven(legs, loop=True), 3 / ((1 + corner_s) / 2)


def test_where_a_loop_begins_changes_nothing_about_its_jerk() -> None:
    loop, jerk_m_s3 = corners()
    for at_s in np.linspace(0.01, loop.loop_duration_s, 60, endpoint=False):
        way = go_on(loop, at_s)
        assert found(way, acceleration_m_s2=3, jerk_m_s3=1.001 * jerk_m_s3) == []
        wrong = found(way, acceleration_m_s2=3, jerk_m_s3=0.999 * jerk_m_s3)
        assert len(wrong) in (7, 8)  # the straight beside which it begins may be one with the curve's first piece
        assert [each.value for each in wrong] == pytest.approx([jerk_m_s3] * len(wrong), rel=1e-4)


def test_where_a_plan_takes_over_changes_nothing_about_the_jerk() -> None:
    loop, jerk_m_s3 = corners()
    refused = 0
    for at_s in np.linspace(0.01, loop.loop_duration_s, 40, endpoint=False):
        k = int(np.searchsorted(loop.times_s, at_s))
        way = dataclasses.replace(
            loop,
            times_s=np.insert(loop.times_s, k, at_s),
            positions_m=np.insert(loop.positions_m, k, loop.at(at_s), axis=0),
            accelerations_m_s2=np.zeros(len(loop.times_s)),
        )
        limits = robot(acceleration_m_s2=3, jerk_m_s3=1.001 * jerk_m_s3)
        assert acceleration_violations(way, limits, seam=k) == []
        refused += acceleration_violations(way, limits) != []
    assert refused > 0


@pytest.mark.parametrize("beside_s", [-1e-4, -5e-5, -3e-5, -2e-5, -2e-6, 0.0, 5e-6, 2e-5, 3e-5, 5e-5, 1e-4])
def test_a_loop_that_begins_a_moment_beside_a_jump_of_acceleration_hides_no_jerk(beside_s: float) -> None:
    """From 5 m/s by 2 m/s2 for 0.6 s, held for 3 s, and gently back: 2 m/s2 from the middle of 0.6 s to that of 3 s."""
    ways, corner_s = np.array([(5, 0), (0, 5), (-5, 0), (0, -5)], float), math.hypot(5, 5)
    ahead = np.array([1.0, 0.0])
    faster = [(4.0, 5 * ahead, 0.0), (0.6, 5.6 * ahead, 2.0), (3.0, 6.2 * ahead, 0.0), (6.0, 5.6 * ahead, -0.2)]
    there_s = sum(lasts_s * float(mean_m_s[0]) for lasts_s, mean_m_s, _ in faster) / 5
    sides = [faster, [(6.0, ways[1], 0.0)], [(there_s, ways[2], 0.0)], [(6.0, ways[3], 0.0)]]
    legs = []
    for side, way, after in zip(sides, ways, np.roll(ways, -1, axis=0), strict=True):
        legs += [*side, *tangents(way, (after - way) / corner_s, corner_s, 7)]
    way = go_on(driven(legs, loop=True), 4.6 + beside_s)
    wrong = [each.value for each in found(way, acceleration_m_s2=3, jerk_m_s3=0.5) if each.kind == "jerk"]
    assert max(wrong) == pytest.approx(2 / ((0.6 + 3) / 2), rel=1e-3)


@pytest.mark.parametrize("seed", range(20))
def test_points_beside_jumps_of_acceleration_hide_no_jerk(seed: int) -> None:
    """From rest to rest in phases, with points a millionth to a hundredth of a second beside their ends."""
    rng = np.random.default_rng(seed)
    lasts_s, most = (
        np.append(3.0, rng.uniform(0.3, 3, 5)),
        np.append(3.0, rng.uniform(0.2, 0.9, 5) * [-1, 1, -1, 1, -1]),
    )
    lasts_s, most = np.append(lasts_s, lasts_s @ most / 2.5), np.append(most, -2.5)
    ends_s, speeds = np.cumsum(lasts_s), np.append(0, np.cumsum(lasts_s * most))
    beside = rng.choice([-1, 1], 18) * 10 ** rng.uniform(-6, -2, 18)
    times_s = np.sort(np.concatenate([[0.0], ends_s, np.repeat(ends_s[:-1], 3) + beside]))
    legs = []
    for from_s, until_s in itertools.pairwise(times_s):
        k = int(np.searchsorted(ends_s, (from_s + until_s) / 2))
        mean = speeds[k] + most[k] * ((from_s + until_s) / 2 - ends_s[k] + lasts_s[k])
        legs.append((until_s - from_s, np.array([mean, 0.0]), float(most[k])))
    jerk_m_s3 = max(np.abs(np.diff(most)) / ((lasts_s[1:] + lasts_s[:-1]) / 2))
    told = [each.value for each in found(driven(legs), acceleration_m_s2=20, jerk_m_s3=1e-3) if each.kind == "jerk"]
    assert max(told) > 0.99 * jerk_m_s3


@pytest.mark.parametrize("beside_s", [2e-6, 1e-5, 2e-5, 1e-4])
def test_a_point_beside_a_jump_of_acceleration_leaves_a_corner_no_room(beside_s: float) -> None:
    """A robot that brakes into a corner, as if a point just behind where it begins to brake were not there."""
    after = np.array([2.9, 0.7])

    def way(*brakes: tuple[float, Any, float]) -> Trajectory:
        return driven([ramp((1, 0), 0, 5, 2.4), (3.0, np.array([5.0, 0.0]), 0.0), *brakes, (3.0, after, 0.0)])

    whole = way(ramp((1, 0), 5, 3, 2))
    cut = way(ramp((1, 0), 5, 5 - 2 * beside_s, 2), ramp((1, 0), 5 - 2 * beside_s, 3, 2))
    corners = [
        [each.value for each in found(one, acceleration_m_s2=2.4) if each.kind == "corner acceleration"]
        for one in (whole, cut)
    ]
    window_s = 4 * OFF_M / math.hypot(0.1, 0.7)
    assert corners[0] == pytest.approx([math.hypot(2 + 0.1 / (2 * window_s), 0.7 / (2 * window_s))])
    assert corners[1] == pytest.approx(corners[0], rel=1e-3)


# ------------------------------------------------------------------ what a kept plan promises


def promised(way: Trajectory, most_m_s2: float, times_s: Floats) -> Floats:
    """The motion (n, 2) that spreads each jump over the least window, written from the definition for even corners."""
    assert way.accelerations_m_s2 is not None
    places = way.at(times_s)
    steps, lasts = np.diff(way.positions_m, axis=0), np.diff(way.times_s)
    mean = steps / lasts[:, None]
    lengths = np.hypot(*steps.T)
    directions = steps / np.where(lengths > 0, lengths, 1)[:, None]
    ends = mean + directions * (way.accelerations_m_s2 * lasts / 2)[:, None]
    begins = mean - directions * (way.accelerations_m_s2 * lasts / 2)[:, None]
    jumps = np.roll(begins, -1, axis=0) - ends
    for jump, at_s in zip(jumps, way.times_s[1:], strict=True):
        window_s = float(np.hypot(*jump)) / (2 * most_m_s2)
        if window_s < 1e-9:
            continue
        off_s = (times_s - at_s + way.loop_duration_s / 2) % way.loop_duration_s - way.loop_duration_s / 2
        near = np.abs(off_s) < window_s
        places[near] += (window_s - np.abs(off_s[near]))[:, None] ** 2 / (4 * window_s) * jump
    return places


@pytest.mark.parametrize("corner", [1.0, 3.0, 5.0])
def test_a_motion_within_five_centimetres_keeps_the_limit(corner: float) -> None:
    way = rounded_square(1.0, corner)
    step_s = 1e-3
    times = np.arange(0, way.loop_duration_s, step_s)
    smooth = promised(way, corner, times)
    off = np.hypot(*(smooth - way.at(times)).T)
    assert 0.02 < off.max() <= OFF_M * (1 + 1e-9)
    second = (smooth[2:] - 2 * smooth[1:-1] + smooth[:-2]) / step_s**2
    assert np.hypot(*second.T).max() <= max(corner, 1.0) * (1 + 1e-4)
    assert found(way, acceleration_m_s2=1.0, corner_acceleration_m_s2=corner) == []


@pytest.mark.parametrize("seed", seeds(20, at_once=6))
def test_no_random_plan_is_kept_whose_velocity_changes_faster_than_five_centimetres_hide(seed: int) -> None:
    """Any motion within OFF_M of the plan gains at most A t in t; so over long times the plan's own mean velocities
    differ by no more than that and 4 OFF_M / t, whatever the windows."""
    rng = np.random.default_rng(seed)
    kept = 0
    for _ in range(200):
        n = int(rng.integers(2, 6))
        mean = np.cumsum(rng.normal(0, rng.choice([0.1, 0.3, 1.0]), (n, 2)), axis=0)
        legs = [(float(rng.uniform(0.05, 1.0)), each, 0.0) for each in mean]
        way = driven(legs)
        if found(way, acceleration_m_s2=2):
            continue
        kept += 1
        times = np.linspace(-1, way.times_s[-1] + 1, 4001)
        places = way.at(times)
        for steps in (50, 200, 500):
            span_s = steps * (times[1] - times[0])
            velocity = (places[steps:] - places[:-steps]) / span_s
            change = np.hypot(*(velocity[steps:] - velocity[:-steps]).T)
            assert change.max() <= 2 * span_s + 4 * OFF_M / span_s + 1e-9
    assert kept > 5
