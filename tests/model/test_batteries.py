"""Batteries and chargers that missions may not have: what is said, and where."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota import BounceSettings
from rota.errors import MissionError, PlanError
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, DiscSensor, Fleet, Mission, Obstacle
from rota.model.motion_limits import MotionLimits
from rota.model.plan import Charge, Plan, Trajectory

PAD = Charger(name="pad", at=(5, 5))


def mission(*chargers: Charger, **changed: Any) -> Mission:
    fleet = {"speed_m_s": 1, "sensor": DiscSensor(radius_m=5), "battery": BatteryLimits(endurance_s=100, recharge_s=50)}
    ground = {name: changed.pop(name) for name in ("obstacles", "planning") if name in changed}
    return Mission(
        name="m", area=MultiPolygon([box(0, 0, 40, 40)]), period_s=60, fleet=Fleet(**{**fleet, **changed}),
        chargers=chargers, **ground,
    )  # fmt: skip


WALL = Obstacle(shape=MultiPolygon([box(10, 10, 20, 20)]))


@pytest.mark.parametrize(
    ("chargers", "changed", "message"),
    [
        ((), {}, "chargers: is missing: robots with an endurance_s need at least one charger"),
        ((PAD,), {"battery": BatteryLimits()}, "chargers: nobody needs them"),
        ((PAD, PAD), {}, r"chargers\[0\].name: 'pad' is not allowed; names must be unique"),
        ((dataclasses.replace(PAD, at=(50, 5)),), {}, r"chargers\[0\].at: \[50, 5\] lies 10 m outside the area"),
        ((dataclasses.replace(PAD, at=(15, 15)),), {"obstacles": (WALL,)}, r"chargers\[0\].at: .* lies in an obstacle"),
        (
            (PAD, Charger(name="b", at=(6, 5))),
            {"body_radius_m": 1},
            r"chargers\[1\].at: \[6, 5\] is 1 m from chargers\[0\]; bodies need 2 m",
        ),
        ((PAD,), {"battery": BatteryLimits(endurance_s=9)}, "fleet.recharge_s: is missing; charger 'pad' swaps no"),
        (
            (PAD,),
            {"motion": MotionLimits(vehicle="arducopter", acceleration_m_s2=1)},
            "fleet.vehicle: robots that charge are not planned for as their firmware flies missions",
        ),
        ((PAD,), {"planning": BounceSettings(cell_m=1)}, "fleet.endurance_s: the bounce planner plans no charging"),
    ],
)
def test_what_does_not_go_together_is_told(
    chargers: tuple[Charger, ...], changed: dict[str, Any], message: str
) -> None:
    with pytest.raises(MissionError, match=message):
        mission(*chargers, **changed)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"recharge_s": 5}, "recharge_s: 5 is not allowed; needs endurance_s"),
        ({"endurance_s": 5, "reserve_s": 5}, "reserve_s: 5 is not allowed; must be less than endurance_s, 5"),
        (
            {"endurance_s": 9, "reserve_s": 2, "takeoff_s": 7},
            "takeoff_s: 7 is not allowed; .* beside reserve_s, 7",
        ),
        ({"takeoff_s": 5}, "takeoff_s: 5 is not allowed; needs endurance_s"),
        ({"landing_s": 5}, "landing_s: 5 is not allowed; needs endurance_s"),
        (
            {"endurance_s": 90, "reserve_s": 20, "landing_s": 26, "climbing_s": 9, "standing_endurance_s": 45},
            "landing_s: 26 is not allowed; must be less: hovering while it climbs and lands takes 70 s of driving",
        ),
        ({"standing_endurance_s": 0}, "standing_endurance_s: 0 is not allowed; needs endurance_s"),
        ({"endurance_s": 9, "standing_endurance_s": 1e-4}, "standing_endurance_s: .* must be 0 or at least 0.001"),
        ({"endurance_s": math.nan}, "endurance_s: .nan is not allowed"),
        ({"endurance_s": -1}, "endurance_s: -1 is not allowed"),
    ],
)
def test_batteries_that_contradict_themselves_are_refused(values: dict[str, float], message: str) -> None:
    with pytest.raises(MissionError, match=message):
        BatteryLimits(**values)


def test_a_swap_needs_no_recharging() -> None:
    assert mission(dataclasses.replace(PAD, swap_s=60), battery=BatteryLimits(endurance_s=9)).chargers[0].swap_s == 60


def test_charges_are_at_known_chargers_and_at_times_of_their_trajectory() -> None:
    def trajectory(*charges: Charge) -> Trajectory:
        return Trajectory(robot="r", times_s=np.array([0.0, 10, 20]), positions_m=np.full((3, 2), 5.0), charges=charges)

    plan = Plan(mission=mission(PAD), trajectories=(trajectory(Charge(charger="pad", from_s=0, until_s=10)),))
    assert plan["r"].charges[0].charger == "pad"
    with pytest.raises(PlanError, match=r"charges\[0\].charger: 'pat' is not allowed; the mission has 'pad'"):
        Plan(mission=mission(PAD), trajectories=(trajectory(Charge(charger="pat", from_s=0, until_s=10)),))
    with pytest.raises(PlanError, match=r"charges\[0\] goes from 0 to 11; both must be times"):
        trajectory(Charge(charger="pad", from_s=0, until_s=11))
    with pytest.raises(PlanError, match=r"charges\[1\] goes from 0 to 10; both must be times of the"):
        trajectory(Charge(charger="pad", from_s=0, until_s=20), Charge(charger="pad", from_s=0, until_s=10))
