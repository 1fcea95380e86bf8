"""Rounded corners against their closed forms, and against derivatives by differences."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rota.links.rounded_track import RoundedTrack
from rota.model.plan import Trajectory


def corner(angle_deg: float, speed_m_s: float) -> Trajectory:
    """50 m straight, a turn by an angle, and 50 m on; there it stays."""
    leg_s, angle = 50 / speed_m_s, math.radians(angle_deg)
    there = [50.0, 0.0]
    return Trajectory(
        robot="a",
        times_s=[0, leg_s, 2 * leg_s],
        positions_m=[[0, 0], there, [50 + 50 * math.cos(angle), 50 * math.sin(angle)]],
        loop_start_s=2 * leg_s,
    )


SQUARE = Trajectory(robot="a", times_s=[0, 10, 20, 30, 40], positions_m=[[0, 0], [40, 0], [40, 40], [0, 40], [0, 0]])
STOPS = Trajectory(  # from rest to rest on each side: two legs with accelerations
    robot="a",
    times_s=[0, 5, 10, 15, 20, 25, 30],
    positions_m=[[-10, 0], [0, 0], [10, 0], [10, 5], [10, 10], [5, 5], [-10, 0]],
    accelerations_m_s2=[0.8, -0.8, 0.4, -0.4, 0, 0],
)


@pytest.mark.parametrize("angle_deg", [20, 90, 150])
def test_corners_are_cut_by_what_the_closed_form_says(angle_deg: float) -> None:
    speed, limit = 4.0, 2.5
    track = RoundedTrack(corner(angle_deg, speed), limit, 5.0)
    cut_m = speed**2 * math.sin(math.radians(angle_deg) / 2) ** 2 / (2 * limit)
    middle = track.at(12.5)
    assert math.dist(middle.place_m, (50, 0)) == pytest.approx(cut_m)
    assert np.hypot(*middle.acceleration_m_s2) == pytest.approx(limit)
    assert track.hardest.acceleration_m_s2 == pytest.approx(limit)


def test_a_corner_that_may_hardly_be_cut_takes_more() -> None:
    track = RoundedTrack(corner(90, 8.0), 2.5, 1.5)
    change = 8 * math.sqrt(2)
    assert math.dist(track.at(6.25).place_m, (50, 0)) == pytest.approx(1.5)
    assert track.hardest.acceleration_m_s2 == pytest.approx(change**2 / (8 * 1.5))
    assert track.hardest.place_m == (50.0, 0.0)
    assert track.top_m_s == pytest.approx(8.0)


@pytest.mark.parametrize("way", [SQUARE, STOPS, corner(90, 4.0)], ids=["square", "stops", "stays"])
def test_velocities_and_accelerations_are_the_derivatives_and_nothing_jumps(way: Trajectory) -> None:
    track = RoundedTrack(way, 2.5, 1.5)
    step = 1e-4
    for time_s in np.arange(way.times_s[1] - 0.9, 2.3 * way.times_s[-1], 0.137):
        before, at, after = (track.at(time_s + k * step) for k in (-1, 0, 1))
        if time_s + step < way.times_s[-1] or way.loop_duration_s:
            slope = (after.place_m - before.place_m) / (2 * step)
            np.testing.assert_allclose(at.velocity_m_s, slope, atol=2e-3)
        assert np.linalg.norm(after.place_m - before.place_m) < 5 * 2 * step
        assert np.linalg.norm(after.velocity_m_s - before.velocity_m_s) < 0.01 or time_s > way.times_s[-1] - 0.1


def test_it_is_where_the_plan_has_it_but_at_corners_in_every_round() -> None:
    track = RoundedTrack(SQUARE, 2.5, 5.0)
    for time_s in np.arange(0.0, 170.0, 0.3):
        off_m = math.dist(track.at(time_s).place_m, SQUARE.at(time_s))
        assert off_m <= 4**2 * 0.5 / 5 + 1e-9
    assert math.dist(track.at(80.0).place_m, (0, 0)) == pytest.approx(4**2 * 0.5 / 5)
    np.testing.assert_allclose(track.at(85.0).velocity_m_s, [4, 0])


def test_the_nearest_moment_is_found_within_a_round() -> None:
    track = RoundedTrack(SQUARE, 2.5, 1.5)
    assert track.nearest_s(np.array([20.0, 1.0]), 80.0, 95.0) == pytest.approx(85.0, abs=0.051)
    assert track.nearest_s(np.array([20.0, 1.0]), 0.0, 20.0) == pytest.approx(5.0, abs=0.051)


def test_an_arc_of_short_legs_takes_what_its_curve_takes() -> None:
    radius_m, speed_m_s, legs = 10.0, 5.0, 8  # 25 / 10 m/s2 towards the middle
    half_s = math.pi * radius_m / legs / 2 / speed_m_s
    angles = [math.pi * (k + 0.5) / legs for k in range(legs)]
    tangents = [[0.0, -50.0], [0.0, 0.0]]  # the corners of a circumscribed polyline, with the points where it touches
    for k, angle in enumerate(angles):
        out_m = radius_m / math.cos(math.pi / legs / 2)
        tangents.append([out_m * math.cos(angle) - radius_m, out_m * math.sin(angle)])
        end = math.pi * (k + 1) / legs
        tangents.append([radius_m * math.cos(end) - radius_m, radius_m * math.sin(end)])
    tangents.append([-2 * radius_m, -50.0])
    times_s = [0.0, 10.0, *(10.0 + half_s * (k + 1) for k in range(2 * legs))]
    times_s.append(times_s[-1] + 10.0)
    way = Trajectory(robot="a", times_s=times_s, positions_m=tangents, loop_start_s=times_s[-1])
    track = RoundedTrack(way, 2.5, 1.5)
    assert track.hardest.acceleration_m_s2 == pytest.approx(2.5, rel=0.05)
    for time_s in np.arange(10.5, times_s[-2] - 0.5, 0.1):
        assert math.dist(track.at(float(time_s)).place_m, (-radius_m, 0.0)) == pytest.approx(radius_m, abs=0.06)


def test_a_loop_that_begins_just_before_a_corner_passes_it_as_any_other() -> None:
    whole = RoundedTrack(SQUARE, 2.5, 1.5)
    begun = Trajectory(
        robot="a",
        times_s=[0, 0.1, 10.1, 20.1, 30.1, 40],
        positions_m=[[39.6, 0], [40, 0], [40, 40], [0, 40], [0, 0], [39.6, 0]],
    )
    track = RoundedTrack(begun, 2.5, 1.5)
    assert track.hardest.acceleration_m_s2 == pytest.approx(whole.hardest.acceleration_m_s2)
    for time_s in np.arange(0.05, 85, 0.173):
        for found, expected in zip(track.at(time_s), whole.at(time_s + 49.9), strict=True):
            assert found == pytest.approx(expected, abs=1e-9)
    assert track.at(0.0).place_m == pytest.approx([39.6, 0.0])
