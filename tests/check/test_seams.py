"""Where a plan takes over: what is judged with what was driven before, what is believed, and what ends no check."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota.check.motion import motion_violations
from rota.check.seams import seam_violations
from rota.model.mission import DiscSensor, Fleet, Mission
from rota.model.motion_limits import MotionLimits
from rota.model.plan import Driven, Plan, Seam, Trajectory

SENSOR = DiscSensor(radius_m=9)


def told(before: Any, after: Any, *, accelerations: tuple[Any, Any] = (None, None), **fleet: Any) -> list[str]:
    """Kinds of what is wrong with a robot that drove rows (time, x, y) before, drives others after, and stays there."""
    mission = Mission(
        name="m", area=MultiPolygon([box(-900, -900, 900, 900)]), period_s=9,
        fleet=Fleet(speed_m_s=20, sensor=SENSOR, **fleet),
    )  # fmt: skip
    was, then = np.array(before, float), np.array(after, float)
    driven = Driven(
        robot="a", sensor=SENSOR, times_s=was[:, 0], positions_m=was[:, 1:], accelerations_m_s2=accelerations[0]
    )
    trajectory = Trajectory(
        robot="a", times_s=then[:, 0], positions_m=then[:, 1:], accelerations_m_s2=accelerations[1],
        loop_start_s=then[-1, 0],
    )  # fmt: skip
    plan = Plan(mission=mission, trajectories=(trajectory,), seam=Seam(at_s=99, driven=(driven,)))
    return [one.kind for one in (*motion_violations(plan), *seam_violations(plan))]


def bent(later_m_s: float, rows: int = 2) -> list[str]:
    """At 1 m/s2: a corner by 0.3 m/s 0.05 s before the change, and one back by that much 0.12 s after it.

    rows: of what was driven since the corner.
    """
    v0, v1 = np.array([2.0, 0]), np.array([2.0, 0.3])
    v2 = v1 - [0, later_m_s]
    at = -0.05 * v1, 0.12 * v1, 0.12 * v1 + 2 * v2
    stops_s = float(np.hypot(*v2)) / 0.9
    before = [(-10, *(at[0] - 9.95 * v0)), *((-0.05 * share, *(share * at[0])) for share in np.linspace(1, 0, rows))]
    after = [(0, 0, 0), (0.12, *at[1]), (2.12, *at[2]), (2.12 + stops_s, *(at[2] + v2 * stops_s / 2))]
    limits = MotionLimits(acceleration_m_s2=1.0)
    return told(before, after, accelerations=(None, [0, 0, -0.9]), motion=limits)


def test_a_corner_driven_last_needs_room_that_the_plan_must_leave_it() -> None:
    # it takes 0.15 s, and the next one half of what it needs beside it
    assert bent(0.0) == []
    assert bent(0.1) == ["corner acceleration"]


@pytest.mark.parametrize("rows", [2, 30])
def test_no_rows_of_a_moment_hide_what_was_driven_before(rows: int) -> None:
    """A corner 0.05 s, or 0.3 m, before the change, with the leg since then told in so many rows."""
    assert bent(0.1, rows) == ["corner acceleration"]
    assert bent(0.0, rows) == []
    assert turned(0.3, 0.3, rows) == ["turn radius"] * 2
    assert turned(0.5, 0.5, rows) == []


def turned(before_m: float, after_m: float, rows: int) -> list[str]:
    """At 1 m/s on arcs of 5 m: corners of 0.19 rad, each of which takes 0.48 m, before the change and after it."""
    at = np.linspace(-before_m, 0, rows)
    x, y = 9 * math.cos(0.19), 9 * math.sin(0.19)
    before = [(-9 - before_m, -before_m - x, y), *((each, each, 0.0) for each in at)]
    return told(before, [(0, 0, 0), (after_m, after_m, 0), (9 + after_m, after_m + x, y)], turn_radius_m=5.0)


def test_a_leg_of_which_only_the_end_is_told_has_room_enough() -> None:
    """The plan before began, or what is told of it does, a millisecond before the change, in the midst of a leg."""
    x, y = 9 * math.cos(0.19), 9 * math.sin(0.19)
    for before, kinds in (([(-1e-3, -1e-3, 0)], []), ([], ["turn radius"])):
        after = [(0, 0, 0), (0.3, 0.3, 0), (9.3, 0.3 + x, y)]
        assert told([*before, (0, 0, 0)], after, turn_radius_m=5.0) == kinds


def test_what_was_wrong_before_is_believed() -> None:
    limits = MotionLimits(acceleration_m_s2=1.0)
    back = [(-20, 0, 0), (-10, 50, 0), (0, 0, 0)]  # a turn on the spot at 5 m/s
    stops = [(0, 0, 0), (5, -12.5, 0)]
    assert told(back, stops, accelerations=(None, [-1.0]), motion=limits) == []
    assert told([(-10, 0, 0), (0, 50, 0)], [(0, 50, 0), (2, 40, 0), (3, 40, 0)], turn_radius_m=5.0) == ["turn radius"]
    assert told([(-20, 0, 0), (-10, 50, 0), (0, 0, 0)], [(0, 0, 0), (2, -10, 0)], turn_radius_m=5.0) == []


@pytest.mark.parametrize(("before_s", "kinds"), [(1.0, ["jerk"]), (30.0, [])])
def test_a_robot_that_was_under_way_did_not_begin_at_rest(before_s: float, kinds: list[str]) -> None:
    """From 2 m/s to 4 m/s in 2 s at once: from standing it would have been accelerating before."""
    after = [(0, 0, 0), (2, 6, 0), (32, 126, 0)]
    limits = MotionLimits(acceleration_m_s2=2.0, jerk_m_s3=0.3)
    found = told([(-before_s, -2 * before_s, 0), (0, 0, 0)], after, accelerations=(None, [1.0, 0.0]), motion=limits)
    assert [kind for kind in found if kind == "jerk"] == kinds


@pytest.mark.parametrize("last_m", [0.0, 5e-10, 1e-8])
def test_a_last_step_of_next_to_nothing_hides_no_turn(last_m: float) -> None:
    before, after = [(-10, -10, 0), (-1e-3, -last_m, 0), (0, 0, 0)], [(0, 0, 0), (1, -1, 0)]
    assert told(before, after, turn_rate_rad_s=1.0) == ["turn"]
    assert told(before, after, turn_radius_m=5.0) == ["turn radius"]


def test_a_plan_may_begin_where_a_hair_is_lacking_of_the_way_to_rest() -> None:
    limits = MotionLimits(acceleration_m_s2=0.3)
    rests = [(0, -5e-7, 0), (9, -5e-7, 0)]
    assert told([(-10, -10, 0), (0, 0, 0)], rests, accelerations=([-0.2], None), motion=limits) == []


def test_after_a_long_stay_times_that_round_lead_nothing_backwards() -> None:
    begins = [(0, 0, 0), (0.01, 5e-5, 0), (0.02, 1e-4, 0)]
    before = [(-1e5 - 0.3, 0, 0), (-1e5, 0, 0), (0, 0, 0)]
    limits = MotionLimits(acceleration_m_s2=1.1)
    assert told(before, begins, accelerations=(None, [1.0, -1.0]), motion=limits) == []


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ([(-1e9, 0, 0), (-1e-7, 0, 0), (-1e-8, 0, 0), (0, 0, 0)], [(0, 0, 0), (9, 0, 0)]),
        ([(-9e9, 0, 0), (0, 0, 0)], [(0, 0, 0), (9e9, 0, 0)]),
    ],
)
def test_times_that_cannot_be_joined_are_told(before: Any, after: Any) -> None:
    assert told(before, after, turn_rate_rad_s=math.pi) == ["turn"]
