"""Recordings: the verdict on a time that begins and ends, beside brute force and beside gaps that follow by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from shapely import box

from rota.check.arrays import SeenTimes
from rota.check.recorded import RecordedTrack, check_recording
from rota.check.window_kernels import gap_within
from rota.errors import PlanError
from rota.model.mission import DiscSensor, Fleet, Mission, Robot, Zone

Floats = NDArray[np.float64]


def lane(period_s: float, **changes: object) -> Mission:
    """A lane of 20 m by 1 m and a robot that sees all of its width for 4.8 m to either side."""
    robot = Robot(name="r", speed_m_s=2.0, sensor=DiscSensor(radius_m=5.0))
    fleet = Fleet(speed_m_s=2.0, sensor=DiscSensor(radius_m=5.0), robots=(robot,))
    mission = Mission(name="lane", area=box(0, 0, 20, 1), period_s=period_s, fleet=fleet)
    return replace(mission, **changes)


def track(times_s: list[float], x_m: list[float]) -> RecordedTrack:
    times, x = np.array(times_s), np.array(x_m)
    y = np.full(len(x) - 1, 0.5)
    return RecordedTrack(
        robot="r",
        legs_m=np.column_stack([x[:-1], y, x[1:], y]),
        times_s=np.column_stack([times[:-1], times[1:]]),
        heights_m=np.zeros(len(x) - 1),
    )


TO_AND_FRO = track([0, 10, 20, 30], [0, 20, 0, 20])
REACH_M = np.sqrt(25 - 0.25)  # along the lane, to both sides of it


def brute_gap(starts: Floats, ends: Floats, from_s: float, to_s: float, step: float) -> float:
    times = np.arange(from_s, to_s + step / 2, step)
    seen = ((times[:, None] >= starts - 1e-9) & (times[:, None] <= ends + 1e-9)).any(axis=1)
    if not seen.any():
        return np.inf
    longest = run = 0
    for now in seen:
        run = 0 if now else run + 1
        longest = max(longest, run)
    return longest * step


def test_gaps_within_a_time_agree_with_brute_force() -> None:
    rng = np.random.default_rng(3)
    for _ in range(200):
        n = int(rng.integers(1, 7))
        starts = rng.integers(0, 200, n) / 4
        ends = starts + rng.integers(0, 20, n) / 4
        from_s, to_s = sorted(rng.choice(240, 2, replace=False) / 4)
        bounds = np.array([0, n], np.int64)
        times = SeenTimes(starts, ends, bounds, np.zeros(1, np.int64))
        gap, begin = gap_within(times, 1, from_s, to_s)
        brute = brute_gap(starts, ends, from_s, to_s, 1 / 64)
        if np.isinf(brute):
            assert np.isinf(gap)
            continue
        assert gap == pytest.approx(brute, abs=3 / 64)
        assert from_s <= begin <= to_s


def test_the_ends_of_a_recording_count_as_gaps_do() -> None:
    # the left end is in reach until 2.5 s and from 17.5 to 22.5 s, the right end from 7.5 to 12.5 s and from 27.5 s on
    report = check_recording(lane(16.0), [TO_AND_FRO], (0.0, 30.0), robots=1)
    gap_s = 20.0 - REACH_M
    assert report.verdict == "met"
    assert report.demands[0].worst_gap_s == pytest.approx(gap_s, abs=0.05)
    assert gap_s - 1.0 < report.demands[0].worst_gap_at_least_s <= report.demands[0].worst_gap_s
    report = check_recording(lane(15.0), [TO_AND_FRO], (0.0, 30.0), robots=1)
    assert report.verdict == "violated"
    assert report.violations[0].kind == "gap"
    # from 3 s on the left end waits for 14.5 s, and until 27 s the right end does; until 38 s the left end waits longer
    assert check_recording(lane(15.0), [TO_AND_FRO], (3.0, 27.0), robots=1).verdict == "met"
    late = check_recording(lane(15.0), [TO_AND_FRO], (3.0, 38.0), robots=1)
    assert late.verdict == "violated"
    assert late.violations[0].value == pytest.approx(38 - 20 - REACH_M / 2, abs=0.3)


def test_where_nobody_knows_where_a_robot_was_nothing_is_credited() -> None:
    whole = check_recording(lane(16.0), [TO_AND_FRO], (0.0, 30.0), robots=1)
    cut = replace(
        TO_AND_FRO,
        legs_m=TO_AND_FRO.legs_m[[0, 2]],
        times_s=TO_AND_FRO.times_s[[0, 2]],
        heights_m=np.zeros(2),
    )
    missing = check_recording(lane(16.0), [cut], (0.0, 30.0), robots=1)
    assert (whole.verdict, missing.verdict) == ("met", "violated")
    assert check_recording(lane(16.0), [], (0.0, 30.0), robots=1).demands[0].unseen_area_m2 == pytest.approx(20.0)


def test_a_period_longer_than_the_recording_is_not_judged() -> None:
    zones = (Zone(name="gate", shape=box(0, 0, 2, 1), period_s=25.0, demand="visit"),)
    report = check_recording(lane(31.0, zones=zones), [TO_AND_FRO], (0.0, 30.0), robots=1)
    assert [demand.name for demand in report.demands] == ["gate"]
    assert report.demands[0].worst_gap_s == pytest.approx(18.0)  # from 1 s to 19 s
    assert report.not_judged == ("area: its period, 31 s, is longer than what was recorded, 30.0 s",)
    assert report.verdict == "met"
    nothing = check_recording(lane(31.0), [TO_AND_FRO], (0.0, 30.0), robots=1)
    assert nothing.verdict == "not proven"
    with pytest.raises(PlanError, match="there is nothing to judge"):
        check_recording(lane(31.0), [TO_AND_FRO], (30.0, 30.0), robots=1)


def test_a_tolerance_credits_sensors_with_more_reach() -> None:
    beside = replace(TO_AND_FRO, legs_m=TO_AND_FRO.legs_m + np.array([0, 4.7, 0, 4.7]))
    assert check_recording(lane(20.0), [beside], (0.0, 30.0), robots=1).verdict == "violated"
    assert check_recording(lane(20.0), [beside], (0.0, 30.0), robots=1, tolerance_m=1.0).verdict == "met"


def test_sensors_that_look_down_see_as_far_as_their_height_allows() -> None:
    cone = DiscSensor(radius_m=5.0, half_angle_deg=45.0)
    robot = Fleet(speed_m_s=2.0, sensor=cone).equal_robot("r")
    high = replace(TO_AND_FRO, heights_m=np.array([9.0, 9.0, 9.0]))
    low = replace(TO_AND_FRO, heights_m=np.array([9.0, 0.2, 9.0]))
    ground = lane(16.0)
    # a plan's missions have such sensors for swarms in space only; the rule of sight is the same
    object.__setattr__(ground.fleet, "robots", (robot,))
    ground.fleet.__dict__.pop("_by_name", None)
    assert check_recording(ground, [high], (0.0, 30.0), robots=1).verdict == "met"
    assert check_recording(ground, [low], (0.0, 30.0), robots=1).verdict == "violated"
