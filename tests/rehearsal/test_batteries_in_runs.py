"""Batteries, reliefs and chargers in runs, beside the check, closed forms and brute force."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.rehearsal.rehearsed_plans import post, taking_turns
from tests.relieved import FLIGHT_S, TURN_S, relieved, with_battery

import rota
from rota import Plan
from rota.check.charging import battery_levels
from rota.engines.processes import LocalProcesses
from rota.model.mission import Charger
from rota.rehearsal import rehearsal_table, rehearsal_to_json
from rota.rehearsal.conditions import Conditions
from rota.rehearsal.drive_kernels import Fills
from rota.rehearsal.kernels import Driven
from rota.rehearsal.many_runs import rehearse_once
from rota.rehearsal.scene import Scene, scene_of
from rota.rehearsal.stages import drive_in_stages


def drive(scene: Scene, seed: int, number: int) -> tuple[Driven, Fills]:
    """How robots drive in a run, and their batteries."""
    stage = drive_in_stages(scene, seed, number)[0][0]
    return stage.driven, stage.fills


def with_swaps(plan: Plan, swap_s: float) -> Plan:
    """The same with chargers that swap batteries."""
    chargers = tuple(replace(charger, swap_s=swap_s) for charger in plan.mission.chargers)
    return replace(plan, mission=replace(plan.mission, chargers=chargers))


def with_places(plan: Plan, places: int) -> Plan:
    """The same with so many places at its first charger."""
    charger = plan.mission.chargers[0]
    pad = Charger(name=charger.name, at=charger.at, places=places)
    return replace(plan, mission=replace(plan.mission, chargers=(pad,)))


GROUNDING = {"landing_s": 26, "climbing_s": 13, "takeoff_s": 5}


@pytest.mark.parametrize(
    "plan",
    [
        taking_turns(),
        relieved(2),
        relieved(3),
        with_swaps(relieved(3), 50.0),
        with_battery(relieved(3), takeoff_s=30),
        with_battery(relieved(2), **GROUNDING),
        with_swaps(with_battery(relieved(2), **GROUNDING), 100),
    ],
    ids=["road", "2", "3", "swaps", "take-offs", "climbs", "climbs, swaps"],
)
def test_without_chance_batteries_are_those_of_the_check(plan: Plan) -> None:
    scene = scene_of(plan, Conditions(hours=1.0))
    charging = rehearse_once(scene, 0, 0)[0].charging
    assert charging is not None
    for k, way in enumerate(plan):
        levels = battery_levels(plan, way)
        assert charging.least_s[k] == pytest.approx(levels.levels_s.min(), abs=1e-6)
    assert charging.hurries_s.max() == 0
    assert charging.crowd is None


def test_batteries_in_wind_and_noise_are_as_brute_force_has_them() -> None:
    """Levels moment by moment from where robots are: a second away takes one, a second at the pad gives 100 / 80."""
    plan = taking_turns()
    scene = scene_of(plan, Conditions(hours=1.0, speed_noise=0.1, wind_m_s=0.1, wind_from_deg=90.0, late_relief_s=4.0))
    driven, fills = drive(scene, 2, 5)
    step_s = 0.02
    moments_s = np.arange(0, scene.end_s, step_s)
    for k in range(len(plan)):
        planned_s = np.interp(moments_s, driven.times_s[k], scene.tick_s * np.arange(driven.times_s.shape[1]))
        away = np.mod(planned_s + 60 * k, 120) < 60
        level_s, least_s = 100.0, math.inf
        for is_away in away:
            level_s = level_s - step_s if is_away else min(100.0, level_s + step_s * 100 / 80)
            least_s = min(least_s, level_s)
        assert least_s < 39
        assert fills.least_s[k] == pytest.approx(least_s, abs=0.5)


def test_a_late_robot_leaves_by_the_clock_where_its_battery_will_do() -> None:
    """Against wind of 0.3 m/s it comes home late by 30 / 0.7 - 30 = 12.9 s of 60 s on the pad; 48 s fill it."""
    plan = taking_turns()
    asked = Conditions(hours=1.0, wind_m_s=0.3, wind_from_deg=90.0, hands_off=True)
    driven, _ = drive(scene_of(plan, asked), 0, 0)
    assert driven.times_s[0, 60] == pytest.approx(30 / 0.7 + 30)
    assert driven.times_s[0, 120] == pytest.approx(120.0)


@pytest.mark.parametrize("grounding", [{}, GROUNDING], ids=["at once", "climbs"])
def test_who_has_not_charged_enough_stays_until_it_has(grounding: dict[str, float]) -> None:
    """40 s of 400 are the reserve. The slower robots fly, the longer they charge, at 2 s a second."""
    wind_m_s = 0.5
    plan = with_battery(relieved(2), **grounding)
    asked = Conditions(hours=2.0, wind_m_s=wind_m_s, wind_from_deg=90.0, hands_off=True)
    driven, fills = drive(scene_of(plan, asked), 0, 0)
    east, north = 1 / (1 - wind_m_s), 1 / math.sqrt(1 - wind_m_s**2)
    flown_s = 10 + 10 * east + 2 * (20 + 20 * east + 40 * north)
    left_s = 400 - flown_s - grounding.get("takeoff_s", 0)
    stays = fills.stays_s[: fills.noted[0]][fills.stays[: fills.noted[0], 0] == 0]
    # it leaves with what it has planned for the next flight and the reserve, if it is not time sooner
    enough_s = FLIGHT_S + 40 + grounding.get("takeoff_s", 0)
    least_stay_s = (enough_s - left_s) / 2 + (26 + 13 if grounding else 0)
    assert least_stay_s < stays[0, 1] - stays[0, 0] + 1e-6
    assert stays[0, 0] == pytest.approx(flown_s)
    assert stays[0, 1] == pytest.approx(max(2 * TURN_S, flown_s + least_stay_s), abs=1e-5)
    assert driven.times_s[0, int(2 * TURN_S)] == pytest.approx(stays[0, 1])


def test_reliefs_are_late_by_as_much_as_is_asked_in_the_mean() -> None:
    plan = relieved(3)
    late_s = []
    for number in range(40):
        asked = Conditions(hours=2.0, late_relief_s=20.0, hands_off=True)
        _, fills = drive(scene_of(plan, asked), 0, number)
        rows = fills.noted[0]
        for (_, until_s), (robot, _) in zip(fills.stays_s[:rows], fills.stays[:rows], strict=True):
            if until_s < 7200:
                late_s.append(np.mod(until_s - robot * TURN_S + 240, 3 * TURN_S) - 240)
    assert min(late_s) >= 0
    assert np.mean(late_s) == pytest.approx(20.0, abs=4 * 20 / math.sqrt(len(late_s)))
    assert np.median(late_s) == pytest.approx(20 * math.log(2), rel=0.2)


def test_all_hold_for_a_late_relief_as_long_as_batteries_let_them() -> None:
    """The battery holds 180 s more than a flight and its reserve: it waits so long less a twentieth of its way home."""
    plan = relieved(3)
    held = scene_of(plan, Conditions(hours=1.0, late_relief_s=20.0))
    driven, fills = drive(held, 0, 0)
    assert np.ptp(driven.times_s, axis=0).max() <= 1.0 + 1e-6  # nobody is more than a second off the clock of all
    assert fills.hurries_s.max() == 0
    assert fills.least_s.min() < 400 - FLIGHT_S - 20
    later = scene_of(plan, Conditions(hours=1.0, late_relief_s=400.0))
    driven, fills = drive(later, 0, 0)
    assert fills.hurries_s.max() > 60
    assert 40 - 1e-6 <= fills.least_s.min() < 40 + 0.05 * FLIGHT_S


def test_a_charger_is_told_that_has_more_robots_than_places() -> None:
    plan = with_places(relieved(2), 1)  # each comes home 20 s after the other has left
    calm = rehearse_once(scene_of(plan, Conditions(hours=1.0)), 0, 0)[0].charging
    assert calm is not None
    assert calm.crowd is None
    scene = scene_of(plan, Conditions(hours=1.0, late_relief_s=60.0, hands_off=True))
    late = rehearse_once(scene, 0, 0)[0].charging
    assert late is not None
    assert late.crowd is not None
    _, fills = drive(scene, 0, 0)
    stays_s = fills.stays_s[: fills.noted[0]]
    moments_s = np.arange(0, 3600, 0.5)[:, None]
    present = ((stays_s[:, 0] <= moments_s) & (moments_s < stays_s[:, 1] - 1)).sum(axis=1)
    assert late.crowd.time_s == pytest.approx(moments_s[np.argmax(present > 1), 0], abs=0.5)
    assert late.crowd.robots == 2


def test_the_table_and_json_tell_of_batteries() -> None:
    plan = with_places(relieved(2), 1)
    plan = replace(
        plan, mission=replace(plan.mission, fleet=replace(plan.mission.fleet, battery=replace(
            plan.mission.fleet.battery, reserve_s=215.0)))
    )  # fmt: skip
    made = rota.rehearse(plan, hours=1.0, late_relief_s=60.0, speed_noise=0.1, hands_off=True, runs=20)
    lines = rehearsal_table(made).splitlines()
    assert any(
        line.startswith("batteries: ") and "beyond the reserve at the least; one falls" in line for line in lines
    )
    assert any(line.startswith("robot-1: below its reserve of 215 s in ") for line in lines)
    assert any(
        line.startswith("chargers too full, in ") and "robots are at pad, which has 1 places" in line for line in lines
    )
    told = rehearsal_to_json(made)["charging"]
    assert [each["name"] for each in told["robots"]] == ["robot-1", "robot-2"]
    assert made.charging is not None
    for each, robot in zip(told["robots"], made.charging.robots, strict=True):
        assert each["least_s"]["mean"] == pytest.approx(robot.levels_s.mean())
        assert each["runs_below_reserve"]["mean"] == np.mean(robot.levels_s < 215 - 1e-6)
    assert rota.draw_rehearsal(plan, made) is not None


@pytest.mark.slow  # starts processes anew
def test_processes_tell_the_same_of_batteries_as_threads() -> None:
    asked = {"hours": 0.5, "late_relief_s": 5.0, "speed_noise": 0.05, "failures_per_hour": 0.5, "runs": 8}
    with LocalProcesses(2) as executor:
        by_processes = rehearsal_to_json(rota.rehearse(relieved(3), **asked, executor=executor))
    assert by_processes == rehearsal_to_json(rota.rehearse(relieved(3), **asked))


def test_late_reliefs_need_somebody_who_charges() -> None:
    with pytest.raises(rota.MissionError, match="late_relief_s: 5 is not allowed; nobody charges in this plan"):
        rota.rehearse(post(), late_relief_s=5.0)
    assert rota.rehearse(post(), hours=0.1).charging is None
