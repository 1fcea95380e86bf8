"""Docks of one place each: robots land wherever a place is free, so that several chargers serve one loop."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import MultiPolygon, box
from tests.planners.patrol.relief.test_roomy import most_on

from rota import DiscSensor, Fleet, Mission, PatrolSettings, check_plan, make_plan
from rota.errors import NoPlanFound
from rota.files.plan_file import plan_from_text, plan_text
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger
from rota.planners.patrol.relief.landings import as_from_one
from rota.planners.patrol.relief.slots import Handovers

Docks = list[tuple[float, float]]


def yard(docks: Docks, *, period_s: float, recharge_s: float, body_radius_m: float = 0.0) -> Mission:
    """A yard of 200 x 150 m for drones of 40 m reach at 10 m/s that fly for 900 s, with docks for one drone each."""
    return Mission(
        name="yard",
        area=MultiPolygon([box(0, 0, 200, 150)]),
        period_s=period_s,
        fleet=Fleet(
            speed_m_s=10,
            sensor=DiscSensor(radius_m=40),
            body_radius_m=body_radius_m,
            battery=BatteryLimits(endurance_s=900, recharge_s=recharge_s),
        ),
        chargers=tuple(Charger(name=f"dock {k}", at=at, places=1) for k, at in enumerate(docks)),
        planning=PatrolSettings(effort="quick"),
    )


@pytest.mark.parametrize(
    ("mission", "robots"),
    [
        pytest.param(yard([(30, 40), (40, 110), (170, 110)], period_s=60, recharge_s=1700), 3, id="three of each"),
        pytest.param(
            yard([(30, 40), (40, 110), (170, 110)], period_s=60, recharge_s=1400, body_radius_m=0.5), 3, id="bodies"
        ),
        pytest.param(
            yard([(30, 40), (40, 110), (170, 110), (100, 20)], period_s=30, recharge_s=700),
            4,
            id="two loops",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_docks_of_one_place_serve_loops_together(mission: Mission, robots: int) -> None:
    plan = make_plan(mission)
    assert (len(plan), check_plan(plan).verdict) == (robots, "met")
    assert [most_on(plan, dock.name) for dock in mission.chargers].count(1) >= 2
    assert max(most_on(plan, dock.name) for dock in mission.chargers) == 1
    assert check_plan(plan_from_text(plan_text(plan), "plan")).verdict == "met"


def test_with_fewer_docks_than_robots_that_charge_there_is_no_plan() -> None:
    with pytest.raises(NoPlanFound, match="place"):
        make_plan(yard([(30, 40), (170, 110)], period_s=60, recharge_s=2700))


def test_ways_to_several_chargers_are_those_to_the_farthest_of_the_nearest_ones() -> None:
    phases_s, places_m = np.array([0.0, 5.0]), np.zeros((2, 2))
    handovers = [
        Handovers(
            charger=Charger(name=name, at=(0, 0), swap_s=swap_s), phases_s=phases_s, places_m=places_m,
            ways_s=np.array(ways_s), turns_s=0.0,
        )
        for name, ways_s, swap_s in (("far", [9.0, 9.0], 30.0), ("near", [1.0, 4.0], 90.0), ("next", [2.0, 3.0], 60.0))
    ]  # fmt: skip
    battery = BatteryLimits(endurance_s=100)
    assert as_from_one(handovers, 1, battery).ways_s.tolist() == [1.0, 4.0]
    two = as_from_one(handovers, 2, battery)
    assert (two.ways_s.tolist(), two.charger.name) == ([2.0, 4.0], "near")
    assert as_from_one(handovers, 9, battery).ways_s.tolist() == [9.0, 9.0]
