"""What robots that charge drove by a log: on a charger they see nothing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from shapely import box
from tests.rehearsal.rehearsed_plans import taking_turns

from rota.check.recorded import check_recording
from rota.live.events import Event, Heard, Tick
from rota.live.recording import Recording, recording_of
from rota.live.settings import WatchSettings
from rota.model.mission import Zone
from rota.model.plan import Plan

LAST_S, EVERY_S, NOISE_M = 480.0, 0.5, 0.05


def heard(plan: Plan, late_s: float) -> Iterator[Event]:
    """Reports of robots that do all so much later than planned; two take turns on a road of 30 m, 60 s each."""
    chance = np.random.default_rng(0)
    yield Tick(0.0)
    for now_s in np.arange(0, LAST_S + EVERY_S, EVERY_S).tolist():
        for number, way in enumerate(plan):
            x, y = way.at(max(now_s - late_s, 0.0))[:2] + chance.normal(0, NOISE_M, 2)
            yield Heard(now_s, number, now_s, x, y, 0.0, None, "running")
    yield Tick(LAST_S)


def recorded(plan: Plan, late_s: float) -> Recording:
    return recording_of(plan, heard(plan, late_s), WatchSettings())


@pytest.mark.parametrize("late_s", [0.0, 7.0])
def test_on_its_charger_a_robot_drives_nothing_however_late_it_is(late_s: float) -> None:
    for k, track in enumerate(recorded(taking_turns(), late_s).tracks):
        middles_s = track.times_s.mean(axis=1)
        turns_s = np.mod(middles_s - late_s - 60 * k, 120)  # for the first 60 s of which it flies
        # who is there when the recording begins or ends may have come past it
        known = (middles_s > 2) & (middles_s < LAST_S - 2)
        assert ((turns_s > 1) & (turns_s < 59))[known].all()
        away_s = np.arange(late_s + 60 * k + 3, late_s + 60 * k + 57, EVERY_S)
        assert all(np.abs(middles_s - now_s).min() <= EVERY_S for now_s in away_s)


def test_who_comes_past_a_charger_is_credited() -> None:
    plan = taking_turns()
    there = tuple(replace(pad, at=(16.0, 2.0)) for pad in plan.mission.chargers)
    plan = replace(plan, mission=replace(plan.mission, chargers=there))
    for track in recorded(plan, 0.0).tracks:
        assert len(track.legs_m) == LAST_S / EVERY_S + 1


def test_what_lies_round_a_charger_is_late_while_robots_stand_there_and_it_is_told_where() -> None:
    """Who flies is out of reach, 8 m, of the pad from 8 to 52 s of each minute; both would see it from there."""
    plan = taking_turns()
    zone = Zone(name="shed", shape=box(1.9, 1.9, 2.1, 2.1), period_s=40.0)
    mission = replace(plan.mission, zones=(zone,))
    made = recorded(plan, 0.0)
    report = check_recording(mission, made.tracks, made.window_s, robots=2)
    (late,) = [one for one in report.violations if one.who == "shed"]
    assert late.value == pytest.approx(44.0, abs=1.0)
    assert late.time_s is not None
    assert np.mod(late.time_s, 60) == pytest.approx(8.0, abs=1.0)
    assert late.place_m == pytest.approx((2, 2), abs=0.2)
    assert "batteries: a recording is judged by what was seen" in report.not_judged
