"""Turns at chargers in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rota.errors import NoPlanFound
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, DiscSensor, Robot
from rota.planners.swarm.charging.turns import Allowed, Needs, needs_of, roster_of, turns_in, turns_of

AT_ONCE = Allowed(in_s=0.0, out_s=0.0, between_s=0.0, spread_s=0.0)


def needs(count: int, usable_s: float, share: float = 0.0, stays_s: float = 0.0) -> Needs:
    return Needs(usable_s=np.full(count, usable_s), share=np.full(count, share), stays_s=np.full(count, stays_s))


def robot(**battery: float) -> Robot:
    return Robot(name="r", speed_m_s=1, sensor=DiscSensor(radius_m=1), battery=BatteryLimits(**battery))


def test_what_a_battery_asks() -> None:
    pad, swaps = Charger(name="pad", at=(0, 0)), Charger(name="swaps", at=(9, 0), swap_s=40)
    filled = needs_of((robot(endurance_s=600, recharge_s=300, reserve_s=60),), (pad,))
    assert (filled.usable_s[0], filled.share[0], filled.stays_s[0]) == (540, pytest.approx(1 / 3), 0)
    swapped = needs_of((robot(endurance_s=600),), (swaps,))
    assert (swapped.usable_s[0], swapped.share[0], swapped.stays_s[0]) == (600, 0, 40)
    either = needs_of((robot(endurance_s=600, recharge_s=300, reserve_s=60),), (swaps, pad))
    assert (either.share[0], either.stays_s[0]) == (0, pytest.approx(300 * 540 / 600))
    hovers = needs_of((robot(endurance_s=600, recharge_s=300, standing_endurance_s=300),), (pad,))
    assert (hovers.usable_s[0], hovers.share[0]) == (300, pytest.approx(1 / 2))
    climbs = needs_of((robot(endurance_s=600, recharge_s=300, reserve_s=60, takeoff_s=60),), (pad,))
    # a round of 750 s: 480 s away and 60 s to take off are used, and half as long it charges
    assert climbs.longest_round_s() == pytest.approx(750)
    assert climbs.charge_s(750) == pytest.approx((480 + 60) / 2) == pytest.approx(climbs.fills_s(480))
    lands = {"takeoff_s": 60, "landing_s": 26, "climbing_s": 13}
    grounded = needs_of((robot(endurance_s=600, recharge_s=300, reserve_s=60, **lands),), (pad,))
    assert grounded.longest_round_s() == pytest.approx(750 + 39)
    assert grounded.charge_s(789) == pytest.approx((480 + 60) / 2 + 39) == pytest.approx(grounded.fills_s(480))
    assert needs_of((robot(endurance_s=600, **lands),), (swaps,)).stays_s[0] == 40 + 39


def test_one_robot_with_one_pad_flies_until_its_reserve_and_fills_what_it_used() -> None:
    turns = turns_of(needs(1, 540, 1 / 3), 1, AT_ONCE)
    assert turns.period_s == turns.round_s == pytest.approx(540 + 270)
    assert turns.charge_s == pytest.approx(270)
    assert (turns.places, len(turns.begins_s), turns.docked.any()) == (1, 1, False)


@pytest.mark.parametrize(("count", "share", "places"), [(12, 1 / 2, 6), (12, 1 / 3, 4), (7, 2 / 5, 3), (5, 1 / 10, 1)])
def test_as_many_places_do_as_robots_charge_on_average(count: int, share: float, places: int) -> None:
    turns = turns_in(1000.0, needs(count, 1e6, share), 50, AT_ONCE)
    assert places == math.ceil(count * share - 1e-9) <= turns.places
    assert len(turns.begins_s) == math.lcm(count, turns.places) == count  # some number that suffices divides it
    assert turns.period_s == pytest.approx(1000)
    exact = turns_in(1000.0, needs(count, 1e6, share), places, AT_ONCE)
    assert exact.places == places
    assert exact.period_s == pytest.approx(1000 * math.lcm(count, places) / count)
    with pytest.raises(
        NoPlanFound, match=rf"{places - 1} places? cannot suffice for {count} robots, {places} would do"
    ):
        turns_in(1000.0, needs(count, 1e6, share), places - 1, AT_ONCE)


def test_the_least_round_of_robots_that_take_turns_at_places() -> None:
    """n robots, p places, a swap of w and b between two: a place is free again after p T / n, w + b at least."""
    allowed = Allowed(in_s=10.0, out_s=0.0, between_s=5.0, spread_s=0.0)
    least_s = 6 / 2 * (60 + 5)
    turns_in(least_s + 1e-6, needs(6, 1e6, stays_s=60), 2, allowed)
    with pytest.raises(NoPlanFound, match="2 places cannot suffice for 6 robots, 3 would do"):
        turns_in(least_s - 1e-3, needs(6, 1e6, stays_s=60), 2, allowed)


def test_the_last_turn_leaves_time_to_come_home_and_nobody_leaves_its_charger_meanwhile() -> None:
    allowed = Allowed(in_s=40.0, out_s=50.0, between_s=5.0, spread_s=0.0)
    turns = turns_in(600.0, needs(12, 1e6, stays_s=55), 12, allowed)
    assert turns.period_s - turns.begins_s[-1] == pytest.approx(90)
    assert turns.period_s == pytest.approx(600)
    assert not ((turns.ends_s > 550) & (turns.ends_s < 600)).any()


def test_no_robot_has_to_drive_on_longer_than_its_battery_lasts_before_its_first_turn() -> None:
    allowed = Allowed(in_s=30.0, out_s=30.0, between_s=5.0, spread_s=200.0)
    asked = needs(8, 900, 1 / 4)
    turns = turns_of(asked, 8, allowed)
    assert 0.9 * 900 < turns.longest_flight_s(8, allowed) <= 900
    assert turns.round_s < asked.longest_round_s()
    with pytest.raises(NoPlanFound, match=r"fleet\.endurance_s: batteries that last for 240 s are too short for 8 rob"):
        turns_of(needs(8, 240, 1 / 4), 8, allowed)


def test_places_are_dealt_out_and_ways_are_short() -> None:
    turns = turns_in(1000.0, needs(4, 1e6, 0.4), 2, AT_ONCE)
    ways_s = np.array([[1.0, 9.0], [9.0, 1.0], [2.0, 9.0], [9.0, 2.0]])
    roster = roster_of(ways_s, np.array([1, 1]), turns)
    assert sorted(roster.robot.tolist()) == [0, 1, 2, 3]
    assert (ways_s[roster.robot, roster.charger] < 9).all()
    with pytest.raises(NoPlanFound, match="not all are in the same part"):
        roster_of(np.full((4, 2), np.inf), np.array([1, 1]), turns)
