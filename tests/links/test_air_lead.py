"""By how much targets are off the way against the air, beside the same filter as a transfer function by scipy."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rota.links.air_lead import AirLead, Drag, Gains, drag_of, gains_of

GAINS = Gains(position=1.2, velocity=2.5, integral=0.8, slope=0.4)


def test_a_copter_that_needs_more_from_now_on_is_led_as_its_controllers_answer_to_that() -> None:
    from scipy.signal import TransferFunction, step  # half a second, which all who collect tests would wait for

    lead = AirLead(GAINS, Drag(0.0, 0.0))
    found = []
    for _ in range(100):
        lead.step(0.1, np.zeros(2), np.array([3.0, -1.0]))
        found.append(lead.off_m)
    x, p, i, d = GAINS
    answer = TransferFunction([1, 0], [1 + d, d * x + p, p * x + i, i * x])
    # what is needed is told with a step, and holds for the time after it
    _, expected = step(answer, T=np.arange(100) * 0.1)
    assert np.array(found) == pytest.approx(np.outer(expected, [3.0, -1.0]), abs=0.02)
    assert np.abs(found).max() > 0.5
    assert np.hypot(*lead.off_m) < 0.1  # the copter has learned it by then


def test_the_air_holds_a_copter_at_its_top_speed_as_its_greatest_lean_pushes() -> None:
    drag = drag_of(12.0, 30.0)
    assert drag.at(np.array([0.0, -12.0])) == pytest.approx([0.0, -9.80665 * math.tan(math.radians(30))])
    slow, fast = (np.linalg.norm(drag.at(np.array([speed, 0.0]))) for speed in (1.0, 6.0))
    assert 6 < fast / slow < 36  # between a drag as the speed and one as its square


def test_gains_are_the_vehicles_own_as_far_as_it_has_them() -> None:
    assert gains_of({"PSC_POSXY_P": 1.5, "PSC_VELXY_D": 0.3, "FENCE_ENABLE": 1.0}) == Gains(1.5, 2.0, 1.0, 0.3)


def test_it_begins_anew_on_the_way() -> None:
    lead = AirLead(GAINS, Drag())
    for _ in range(5):
        lead.step(0.1, np.array([8.0, 0.0]), np.zeros(2))
    assert lead.off_m[0] > 0.1
    lead.begin()
    assert np.all(lead.off_m == 0)
    lead.step(0.1, np.zeros(2), np.zeros(2))
    assert np.all(lead.off_m == 0)
    assert np.all(lead.acceleration_m_s2 == 0)
