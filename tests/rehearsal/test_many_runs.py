"""Rehearsals of many runs: the same by whoever makes them, and what they say of chance."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.rehearsal.rehearsed_plans import crossing, post, round_a_block, taking_turns
from tests.replanning.relays import relay

import rota
from rota.engines.processes import LocalProcesses
from rota.rehearsal import rehearsal_table, rehearsal_to_json
from rota.rehearsal.estimates import mean_over_runs, share_of_runs

ASKED = {"hours": 1.0, "failures_per_hour": 0.5, "speed_noise": 0.05, "wind_m_s": 0.2, "runs": 10, "seed": 4}


@pytest.mark.slow  # starts processes anew
def test_the_same_seed_gives_the_same_on_any_number_of_processes() -> None:
    plan = round_a_block(body_m=0.3)
    by_threads = rota.rehearse(plan, **ASKED)
    told = rehearsal_to_json(by_threads)
    with LocalProcesses(2) as executor:
        made = rota.rehearse(plan, **ASKED, executor=executor)
    assert rehearsal_to_json(made) == told
    assert (made.places_available == by_threads.places_available).all()
    assert rehearsal_to_json(rota.rehearse(plan, **{**ASKED, "seed": 5})) != told


def test_more_runs_begin_with_the_same_ones() -> None:
    plan = round_a_block()
    few, many = (rota.rehearse(plan, **{**ASKED, "runs": runs}) for runs in (5, 10))
    assert (few.parts_available == many.parts_available[:, :5]).all()


def test_failures_are_as_frequent_as_asked_and_availability_as_in_closed_form() -> None:
    hours, period_s, rate, robots = 2.0, 600.0, 0.5, 2
    made = rota.rehearse(post(period_s, robots), hours=hours, failures_per_hour=rate, runs=1000)
    failed = robots * (1 - math.exp(-rate * hours))
    assert abs(made.failed.mean - failed) < 4 * math.sqrt(robots * 0.25 / 1000)
    # both have failed by s with probability (1 - exp(-rate s))^2, and from a period later on all is late
    left_h = hours - period_s / 3600
    late = left_h - 2 * (1 - math.exp(-rate * left_h)) / rate + (1 - math.exp(-2 * rate * left_h)) / (2 * rate)
    low, high = made.available.low, made.available.high
    assert low is not None and high is not None  # noqa: PT018
    half = (high - low) / 2
    assert abs(made.available.mean - (1 - late / hours)) < 2 * half
    assert made.places_available == pytest.approx(np.full(len(made.places_m), made.available.mean))
    on_time = math.exp(-rate * left_h) * (2 - math.exp(-rate * left_h))
    assert abs(made.demands[0].on_time.mean - on_time) < 4 * math.sqrt(on_time * (1 - on_time) / 1000)


def test_what_leaves_nothing_to_chance_is_run_once() -> None:
    made = rota.rehearse(round_a_block(), hours=0.5, runs=50)
    assert (made.runs, made.available.low) == (1, None)
    assert rota.rehearse(round_a_block(), hours=0.5, runs=3, wind_m_s=0.1).runs == 3
    assert rota.rehearse(round_a_block(), hours=0.5, runs=3, wind_m_s=0.1, wind_from_deg=10).runs == 1


def test_the_table_tells_who_is_late_and_who_touches() -> None:
    made = rota.rehearse(crossing(), hours=1.0, wind_m_s=0.3, wind_from_deg=90.0, hands_off=True)
    lines = rehearsal_table(made).splitlines()
    assert lines[0] == ("1 run of 1 h, 2 robots, seed 0: wind of 0.3 m/s from 90 degrees, nobody keeps them in phase")
    assert "contacts: bodies of robots that drive touch in 100.0 % of the runs" in lines
    assert any(line.startswith("first: a and b touch at (10.") for line in lines)
    assert made.contacts is not None
    assert made.contacts.driving.mean == 1
    quiet = rota.rehearse(round_a_block((64.0,)), hours=0.5)
    assert quiet.contacts is None
    assert "never" not in rehearsal_table(quiet)


def test_intervals_are_those_of_tables() -> None:
    """Student: t(0.975, 3) is 3.182; Wilson for 2 of 10 is 0.0567 to 0.5098 (Brown, Cai, DasGupta 2001)."""
    mean = mean_over_runs([1.0, 2.0, 3.0, 4.0])
    assert mean.low == pytest.approx(2.5 - 3.182 * math.sqrt(5 / 3) / 2, abs=1e-3)
    share = share_of_runs(2, 10)
    assert (share.low, share.high) == (pytest.approx(0.0567, abs=1e-4), pytest.approx(0.5098, abs=1e-4))
    assert mean_over_runs([0.5]).low is None
    assert share_of_runs(0, 100).high == pytest.approx(0.037, abs=1e-3)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"hours": math.nan}, "hours: nan is not allowed"),
        ({"hours": 0.0}, "hours: 0 is not allowed; must be a finite number greater than 0"),
        ({"hours": 9000.0, "runs": 1, "speed_noise": 0.1}, "hours: 9000 is not allowed; at most 3472 are"),
        ({"failures_per_hour": -1.0}, "failures_per_hour: -1 is not allowed; must be at least 0"),
        ({"failures_per_hour": math.inf}, "failures_per_hour: inf is not allowed"),
        ({"speed_noise": 0.5}, "speed_noise: 0.5 is not allowed; must be at least 0 and at most 0.3"),
        ({"speed_noise": math.nan}, "speed_noise: nan is not allowed"),
        ({"wind_m_s": 1.0}, "wind_m_s: 1 is not allowed; r0 makes 1 m/s through the air and does not get on"),
        ({"wind_from_deg": math.nan}, "wind_from_deg: nan is not allowed; must be -360 to 360"),
        ({"runs": 0}, "runs: 0 is not allowed; must be 1 to 100000"),
        ({"seed": -1}, "seed: -1 is not allowed; must be a whole number of at least 0"),
    ],
)
def test_values_out_of_range_are_refused(given: dict[str, float], told: str) -> None:
    with pytest.raises(rota.MissionError) as refused:
        rota.rehearse(round_a_block(), **given)  # type: ignore[arg-type]
    assert str(refused.value).startswith(told)


def test_a_plan_of_nobody_is_refused() -> None:
    plan = rota.Plan(mission=post().mission, trajectories=())
    with pytest.raises(rota.RotaError, match="the plan has no robots; there is nothing to rehearse"):
        rota.rehearse(plan)


def test_who_waits_for_whom_is_told_as_it_is() -> None:
    plan = taking_turns()
    alone = replace(plan, trajectories=plan.trajectories[:1])  # nobody holds the road for it
    spare = relay(spare=True)  # who stays on its charger can be late for nobody
    told = []
    for one, hands_off in ((plan, False), (plan, True), (alone, False), (spare, False)):
        made = rota.rehearse(one, hours=0.2, speed_noise=0.05, runs=1, hands_off=hands_off)
        told.append((made.relieve_nobody, rehearsal_table(made).splitlines()[0].split(", ")[-1]))
    assert told == [
        (0, "all wait for who is late"),
        (0, "nobody keeps them in phase"),
        (1, "nobody waits for who is late: no robot relieves another"),
        (0, "all wait for who is late"),
    ]
    some = rehearsal_table(replace(made, relieve_nobody=2)).splitlines()[0]
    assert some.endswith(", all wait for who is late but for 2 robots that relieve nobody")
