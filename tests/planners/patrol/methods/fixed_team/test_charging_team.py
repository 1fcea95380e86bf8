"""Fixed teams whose robots charge and are too few: what they come to with longer periods."""

from __future__ import annotations

import dataclasses
import re

import pytest
from benchmarks.charging import docks
from shapely import MultiPolygon, box

from rota import check_plan, make_plan
from rota.errors import NoPlanFound
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, DiscSensor, Fleet, Mission
from rota.planners.patrol import PatrolSettings
from rota.planners.patrol.ground.problem import stretch_mission

# one robot goes to and fro in 37 s, past the charger, and charges twice as long as it is away: 3 robots for 50 s
CORRIDOR = Mission(
    name="corridor",
    area=MultiPolygon([box(0, 0, 200, 10)]),
    period_s=50,
    fleet=Fleet(
        speed_m_s=10, sensor=DiscSensor(radius_m=10), robots=2, battery=BatteryLimits(endurance_s=500, recharge_s=1000)
    ),
    chargers=(Charger(name="pad", at=(100, 5), places=9),),
    planning=PatrolSettings(effort="quick"),
)


def test_two_robots_of_three_keep_periods_half_as_long_again() -> None:
    """Each is away for a third of its time: 2 / 3 of a robot comes to each place every 37 x 3 / 2 s at least."""
    with pytest.raises(NoPlanFound, match=r"3 robots are needed.*the fleet has 2; at best, every gap is") as told:
        make_plan(CORRIDOR)
    (ratio,) = map(float, re.findall(r"within ([\d.]+) times its period", str(told.value)))
    best = told.value.best
    assert 36.5 * 1.5 / 50 <= ratio < 1.3
    assert [one.robot for one in best] == ["robot-1", "robot-2"]
    assert (best.mission, best.lower_bound_robots) == (CORRIDOR, None)
    assert {fault.kind for fault in check_plan(best).violations} == {"gap"}
    eased = dataclasses.replace(best, mission=stretch_mission(CORRIDOR, ratio + 0.001))
    assert check_plan(eased).verdict == "met"


def test_batteries_too_small_for_any_flight_are_told_as_such() -> None:
    fleet = dataclasses.replace(CORRIDOR.fleet, battery=BatteryLimits(endurance_s=500, reserve_s=499))
    far = dataclasses.replace(CORRIDOR, fleet=fleet, chargers=(Charger(name="pad", at=(0, 5), places=9),))
    with pytest.raises(NoPlanFound, match=r"a robot has 1 s to use; .*: give more, or a charger nearer by$") as told:
        make_plan(far)
    assert told.value.best is None


def test_a_plan_that_passes_is_kept_where_slower_rounds_take_more_robots() -> None:
    """Robots that land wherever a dock is free pass; turns at the same loops driven more slowly need a third robot."""
    mission = docks(3)
    two = dataclasses.replace(mission, fleet=dataclasses.replace(mission.fleet, robots=2))
    assert check_plan(make_plan(stretch_mission(two, 1.5))).verdict == "met"
