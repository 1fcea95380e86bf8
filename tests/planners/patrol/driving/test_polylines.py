"""What of closed polylines is told: whether they keep a turn radius, against circles."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rota.model.mission import DiscSensor, Fleet
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.driving.polylines import keeps_radius


def circle(legs: int, radius_m: float) -> np.ndarray:
    """The corners of legs that touch a circle."""
    angles = np.arange(legs) * (2 * math.pi / legs)
    return radius_m / math.cos(math.pi / legs) * np.column_stack([np.cos(angles), np.sin(angles)])


def test_legs_that_touch_a_circle_keep_its_radius_and_no_greater_one() -> None:
    assert keeps_radius(circle(32, 50.0), 50.0 * (1 - 1e-9))
    assert not keeps_radius(circle(32, 50.0), 50.0 * (1 + 1e-6))


def test_few_legs_are_too_far_off_their_circle() -> None:
    assert not keeps_radius(circle(24, 50.0), 1.0)  # more than a 200th of the radius, whichever that is


def test_a_vertex_on_a_straight_changes_nothing() -> None:
    way = circle(32, 50.0)
    assert keeps_radius(np.insert(way, 5, (way[4] + way[5]) / 2, axis=0), 50.0 * (1 - 1e-9))


def test_a_curve_takes_no_time_for_its_turns_beside_its_length() -> None:
    robot = Fleet(speed_m_s=10.0, sensor=DiscSensor(radius_m=5.0), turn_radius_m=50.0).equal_robot("wing")
    around_m = 2 * 32 * 50.01 * math.tan(math.pi / 32)
    assert driving_of(robot).round_m(circle(32, 50.01)) == pytest.approx(around_m)
    assert driving_of(robot).round_m(circle(8, 50.01)) > around_m
