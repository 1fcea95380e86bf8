"""Where on its round a copter on its mission is late by its firmware alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapely import box
from tests.planners.patrol.driving.test_auto import driving

from rota.links.expected_lags import expected_lags, lags_on_round
from rota.model.mission import Fleet, Mission
from rota.model.motion_limits import AT_ONCE
from rota.model.plan import Plan

# 60 m by 20 m, and a needle of 40 m, at whose end a copter turns back
NEEDLE = np.array([[0.0, 0.0], [60.0, 0.0], [60.0, 20.0], [30.0, 20.0], [29.5, 60.0], [29.0, 20.0], [0.0, 20.0]])


def test_a_copter_falls_behind_where_it_turns_back_and_makes_it_up_on_the_rest_of_the_round() -> None:
    made = driving("arducopter-tuned")
    begun = {phase_s: made.begin_at_a_corner("a", NEEDLE, phase_s) for phase_s in (0.0, 20.0)}
    found = {}
    for phase_s, way in begun.items():
        assert way is not None
        assert way.waypoints is not None
        lags = lags_on_round(way, made.robot, 25.0)
        assert lags is not None
        told = way.waypoints
        first = int(np.argmin(np.hypot(*(told.places_m - NEEDLE[0]).T)))
        passed_s = np.append(told.times_s[-1] - lags.round_s, told.times_s[1:-1])
        middles_s = np.roll((passed_s + np.append(passed_s[1:], told.times_s[-1])) / 2, -first)
        found[phase_s] = np.array([lags.at(at_s + lags.round_s) for at_s in middles_s])
        needle_s = float(np.roll(passed_s, -first)[4])
        assert lags.least_m_s(needle_s - 1, needle_s + 1) < 2  # where it turns back
        assert lags.least_m_s(needle_s - 3, needle_s - 2) > 4
    # wherever they begin, robots on one loop are late at the same places
    assert found[0.0] == pytest.approx(found[20.0], abs=0.1)
    steps_s = np.diff(found[0.0], append=found[0.0][:1])
    assert int(np.argmax(steps_s)) == 3  # from the leg to the needle's end to the leg back
    assert steps_s[3] > 0.3
    assert steps_s[0] < -0.1  # along the straight first leg it makes some of it up
    assert 0.9 < lags.pace < 1.1


def test_nothing_is_known_of_other_vehicles_and_of_plans_without_waypoints() -> None:
    made = driving("arducopter-tuned")
    way = made.begin_at_a_corner("a", NEEDLE, 0.0)
    assert way is not None
    assert lags_on_round(way, replace(made.robot, motion=AT_ONCE), 25.0) is None
    assert lags_on_round(replace(way, waypoints=None), made.robot, 25.0) is None
    longest = made.begin_at_a_corner("a", np.array([[0.0, 0.0], [30_000.0, 0.0], [30_000.0, 20.0], [0.0, 20.0]]), 0.0)
    assert longest is not None
    assert lags_on_round(longest, made.robot, 25.0) is None  # motion is worked out for 20,000 s


def test_those_that_are_to_be_later_where_they_begin_start_later() -> None:
    """A robot that leaves at its plan's time from where others come past late would be ahead of them for ever."""
    made = driving("arducopter-tuned")
    ways = [made.begin_at_a_corner(name, NEEDLE, phase_s) for name, phase_s in (("a", 0.0), ("b", 20.0), ("c", 30.0))]
    assert all(way is not None for way in ways)
    area, sensor = box(-50, -50, 150, 150), made.robot.sensor
    names = [replace(made.robot, name=name) for name in "abc"]
    fleet = Fleet(speed_m_s=made.robot.speed_m_s, sensor=sensor, robots=tuple(names), altitude_m=25.0)
    mission = Mission(name="needle", area=area, period_s=100, fleet=fleet)
    lags = expected_lags(Plan(mission=mission, trajectories=tuple(way for way in ways if way is not None), seed=0))
    starts_s = {name: each.starts_s for name, each in lags.items()}
    assert min(starts_s.values()) == 0
    assert max(starts_s.values()) > 0.2
    for name, way in zip("abc", ways, strict=True):
        assert way is not None
        assert way.waypoints is not None
        # as late as it is to be at the end of its first leg, and wherever it begins as late on the whole
        assert lags[name].at(way.waypoints.times_s[1]) == pytest.approx(starts_s[name])
        assert lags[name].lags_s.mean() == pytest.approx(lags["a"].lags_s.mean(), abs=0.1)
