"""S-curves: limits kept, motion that is the integral of itself, and blends found by looking at all times."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from rota.vehicles.scurve_kernels import (
    ACCELERATION,
    LENGTH,
    RAMP,
    RISE,
    SPEED,
    STEADY,
    WHOLE,
    Shape,
    along,
    blend_s,
    legs_of,
    may_blend,
)

CLIMBING = np.array([2.5, 1.5])
CASES = list(itertools.product([0.05, 2.0, 9.0, 300.0], [0.5, 3.0, 12.0], [1.0, 5.0], [0.5, 1.0, 6.0]))


def legs(points_m: list[list[float]], speed_m_s: float, accel: float, shape: Shape) -> np.ndarray:
    points = np.array(points_m, dtype=np.float64)
    return legs_of(points, np.full(len(points) - 1, speed_m_s), CLIMBING, np.array([accel, 1.0]), shape)


@pytest.mark.parametrize(("length_m", "speed_m_s", "accel", "jerk"), CASES)
def test_legs_go_from_rest_to_rest_within_their_limits(
    length_m: float, speed_m_s: float, accel: float, jerk: float
) -> None:
    (leg,) = legs([[0, 0, 5], [length_m, 0, 5]], speed_m_s, accel, Shape(jerk, 0.3, 2.0, 2 * accel))
    times_s = np.linspace(0, leg[RAMP], 2001)
    metres, speeds, accels = np.array([along(t, leg) for t in times_s]).T
    step_s = np.diff(times_s)
    assert (metres[0], speeds[0], accels[0]) == (0, 0, 0)
    mirrored = np.array([along(leg[WHOLE] - t, leg) for t in times_s[1:]]).T
    for forth, back in zip((length_m - metres, speeds, -accels), mirrored, strict=True):
        np.testing.assert_allclose(back, forth[1:], atol=1e-6 * max(1, length_m))
    np.testing.assert_allclose(np.diff(metres) / step_s, (speeds[1:] + speeds[:-1]) / 2, atol=2e-3 * speeds.max())
    np.testing.assert_allclose(np.diff(speeds) / step_s, (accels[1:] + accels[:-1]) / 2, atol=5e-3 * accels.max())
    assert speeds.max() <= speed_m_s * (1 + 1e-9)
    assert np.abs(accels).max() <= accel * (1 + 1e-9)
    # half of a raised cosine of the full height rises by at most pi / 2 of the mean jerk
    assert np.abs(np.diff(accels) / step_s).max() <= np.pi / 2 * jerk * (1 + 1e-3)
    assert leg[WHOLE] >= length_m / speed_m_s


def test_a_long_leg_gets_to_its_speed_and_a_short_one_does_not() -> None:
    shape = Shape(5.0, 0.3, 2.0, 10.0)
    long, short = legs([[0, 0, 0], [200, 0, 0], [202, 0, 0]], 8.0, 5.0, shape)
    assert long[ACCELERATION] * (long[RISE] + long[STEADY]) == pytest.approx(8.0)
    assert long[WHOLE] - 2 * long[RAMP] == pytest.approx((200 - 8 * long[RAMP]) / 8)
    assert short[ACCELERATION] * (short[RISE] + short[STEADY]) < 3
    assert short[WHOLE] == pytest.approx(2 * short[RAMP])


def test_legs_that_climb_are_as_fast_as_both_parts_allow() -> None:
    shape = Shape(5.0, 0.3, 2.0, 10.0)
    up, down, flat, none = legs([[0, 0, 0], [30, 0, 40], [60, 0, 0], [60, 50, 0], [60, 50, 0]], 8.0, 5.0, shape)
    assert up[SPEED] == pytest.approx(2.5 * 50 / 40)
    assert down[SPEED] == pytest.approx(1.5 * 50 / 40)
    assert flat[SPEED] == 8
    assert (none[LENGTH], none[WHOLE]) == (0, 0)


@pytest.mark.parametrize("turn_deg", [0, 20, 60, 90, 150, 180])
@pytest.mark.parametrize("shape", [Shape(1.0, 0.3, 2.0, 5.0), Shape(5.0, 0.3, 0.5, 10.0)])
def test_legs_blend_for_the_longest_time_that_is_allowed(turn_deg: float, shape: Shape) -> None:
    angle = np.radians(turn_deg)
    end = [30 + 25 * np.cos(angle), 25 * np.sin(angle), 0.0]
    points_m = np.array([[0, 0, 0], [30, 0, 0], end], dtype=np.float64)
    before, after = legs(points_m.tolist(), 8.0, shape.corner_m_s2 / 2, shape)
    found_s = blend_s(points_m, 1, before, after, shape)
    most_s = min(before[WHOLE], after[WHOLE]) / 2
    times_s = np.linspace(0, most_s, 2000)
    allowed = np.array([may_blend(t, points_m, 1, before, after, shape) for t in times_s])
    assert found_s == pytest.approx(times_s[allowed].max(), abs=2 * most_s / 2000)
    assert 0 < found_s <= most_s
