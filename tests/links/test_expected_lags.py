"""Where on its round a copter on its mission is late by its firmware alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.planners.patrol.driving.test_auto import driving

from rota.links.expected_lags import expected_lags_s
from rota.model.motion_limits import AT_ONCE

# 60 m by 20 m, and a needle of 40 m, at whose end a copter turns back
NEEDLE = np.array([[0.0, 0.0], [60.0, 0.0], [60.0, 20.0], [30.0, 20.0], [29.5, 60.0], [29.0, 20.0], [0.0, 20.0]])


def test_a_copter_falls_behind_where_it_turns_back_and_makes_it_up_on_the_rest_of_the_round() -> None:
    made = driving("arducopter-tuned")
    begun = {phase_s: made.begun_at_a_corner("a", NEEDLE, phase_s) for phase_s in (0.0, 20.0)}
    found = {}
    for phase_s, way in begun.items():
        assert way is not None
        assert way.waypoints is not None
        lags_s = expected_lags_s(way, made.robot, 25.0)
        assert lags_s is not None
        assert lags_s[-1] == pytest.approx(lags_s[0], abs=1e-9)
        first = int(np.argmin(np.hypot(*(way.waypoints.places_m - NEEDLE[0]).T)))
        found[phase_s] = np.roll(lags_s[:-1], -first)
    # wherever they begin, robots on one loop are late at the same places
    assert found[0.0] == pytest.approx(found[20.0], abs=0.1)
    steps_s = np.diff(found[0.0])
    assert int(np.argmax(steps_s)) == 4  # on the leg back from the needle's end
    assert steps_s[4] > 0.3
    assert steps_s[0] < 0  # along the straight first leg it makes some of it up


def test_nothing_is_known_of_other_vehicles_and_of_plans_without_waypoints() -> None:
    made = driving("arducopter-tuned")
    way = made.begun_at_a_corner("a", NEEDLE, 0.0)
    assert way is not None
    assert expected_lags_s(way, replace(made.robot, motion=AT_ONCE), 25.0) is None
    assert expected_lags_s(replace(way, waypoints=None), made.robot, 25.0) is None
