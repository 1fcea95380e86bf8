"""Robots with bodies that relieve each other on loops: their ways are led apart."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota import DiscSensor, Fleet, Mission, PatrolSettings, Zone, check_plan, make_plan
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger
from rota.model.plan import Plan
from rota.routes.flights import on_charger


@pytest.mark.parametrize(
    ("length_m", "period_s", "slow"),
    [
        pytest.param(40.0, 30.0, {}, id="two loops side by side, both past the pad"),
        pytest.param(30.0, 20.0, {}, id="nobody takes off before the other has landed"),
        pytest.param(20.0, 14.0, {}, id="a loop that is driven forth and back", marks=pytest.mark.slow),
        pytest.param(20.0, 14.0, {"turn_rate_rad_s": 1.5}, id="which takes time to turn"),
    ],
)
def test_robots_relieve_each_other_on_loops_without_touching(
    length_m: float, period_s: float, slow: dict[str, Any]
) -> None:
    mission = Mission(
        name="corridor",
        area=MultiPolygon([box(0, 0, length_m, 4)]),
        period_s=period_s,
        fleet=Fleet(
            speed_m_s=2, sensor=DiscSensor(radius_m=3), body_radius_m=0.3,
            battery=BatteryLimits(endurance_s=120, recharge_s=120), **slow,
        ),
        chargers=(Charger(name="pad", at=(2, 2), places=4),),
        planning=PatrolSettings(effort="quick"),
    )  # fmt: skip
    plan = make_plan(mission)
    assert check_plan(plan).verdict == "met"
    assert len(plan) <= 5
    assert nearest_m(plan, step_s=0.05) >= 2 * 0.3 - 1e-6


def test_who_takes_off_makes_room_for_who_lands_where_a_charger_has_one_place() -> None:
    zone = Zone(name="gate", shape=MultiPolygon([box(28, 36, 35, 44)]), period_s=78)
    mission = Mission(
        name="one place",
        area=MultiPolygon([box(0, 0, 40, 70)]),
        zones=(zone,),
        period_s=336,
        fleet=Fleet(
            speed_m_s=1, sensor=DiscSensor(radius_m=12), body_radius_m=0.2, battery=BatteryLimits(endurance_s=3780)
        ),
        chargers=(Charger(name="pad", at=(9, 47), places=1, swap_s=90),),
        planning=PatrolSettings(effort="quick"),
    )
    plan = make_plan(mission)
    assert check_plan(plan).verdict == "met"
    assert len(plan) == 3


def nearest_m(plan: Plan, step_s: float) -> float:
    """How near two robots come at moments ``step_s`` apart while neither is on a charger."""
    moments_s = np.arange(0.0, 2 * max(one.loop_duration_s for one in plan), step_s)
    places = [np.where(on_charger(one, moments_s)[:, None], np.nan, one.at(moments_s)) for one in plan]
    return min(float(np.nanmin(np.hypot(*(a - b).T), initial=np.inf)) for a, b in itertools.combinations(places, 2))
