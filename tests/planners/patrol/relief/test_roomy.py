"""Robots that take turns where chargers have few places: no plan was found for any of these missions without heed."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from rota import DiscSensor, Fleet, Mission, PatrolSettings, Zone, check_plan, make_plan
from rota.errors import NoPlanFound
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger
from rota.model.plan import Plan
from rota.routes.flights import on_charger


def posts(zones: dict[float, float], pads: dict[float, int], *, endurance_s: float, recharge_s: float) -> Mission:
    """A corridor along which zones of 4 m are visited in periods of seconds, and pads have places, each by its x."""
    return Mission(
        name="corridor",
        area=shapely.MultiPolygon([shapely.box(0, 0, 120, 12)]),
        zones=tuple(
            Zone(name=f"zone {x:g}", shape=shapely.MultiPolygon([shapely.box(x - 2, 4, x + 2, 8)]), period_s=period_s,
                 demand="visit")
            for x, period_s in zones.items()
        ),
        fleet=Fleet(
            speed_m_s=4,
            sensor=DiscSensor(radius_m=3),
            battery=BatteryLimits(endurance_s=endurance_s, recharge_s=recharge_s),
        ),
        chargers=tuple(Charger(name=f"pad {x:g}", at=(x, 6), places=places) for x, places in pads.items()),
        planning=PatrolSettings(effort="quick"),
    )  # fmt: skip


def most_on(plan: Plan, charger: str) -> int:
    """How many robots are on a charger at once, of a thousand moments."""
    lasts_s = max(robot.loop_duration_s for robot in plan)
    moments_s = (np.arange(1000) + 0.5) * lasts_s / 1000
    own = [robot for robot in plan if any(stay.charger == charger for stay in robot.charges)]
    return int(sum((on_charger(robot, moments_s) for robot in own), np.zeros(len(moments_s), int)).max())


@pytest.mark.parametrize(
    ("mission", "robots"),
    [
        # a pause of 8 s is longer than both ways of 2.75 s: both robots would be on the pad
        (posts({60: 8}, {73: 1}, endurance_s=350, recharge_s=245), 2),
        # two in the air at least: at the second post pauses of 30 s would leave one more on the pad
        (posts({40: 8, 90: 30}, {80: 1}, endurance_s=400, recharge_s=80), 3),
        # a pad of two places is farther away than one of one
        (posts({60: 8}, {72: 1, 10: 2}, endurance_s=400, recharge_s=600), 3),
        # all places are in use all the time, by two of four robots
        (posts({30: 16, 90: 16}, {60: 2}, endurance_s=400, recharge_s=400), 4),
    ],
)
def test_no_more_robots_are_on_a_charger_than_it_has_places(mission: Mission, robots: int) -> None:
    plan = make_plan(mission)
    assert (check_plan(plan).verdict, len(plan)) == ("met", robots)
    for charger in mission.chargers:
        assert most_on(plan, charger.name) <= charger.places


def test_where_robots_must_charge_longer_than_there_are_places_no_plan_is_found() -> None:
    """One robot at the post all the time, and 1.5 s on the pad for each second in the air: 1.5 places."""
    with pytest.raises(NoPlanFound, match=r"charger 'pad 70' has 1 place, and \d robots are there at once"):
        make_plan(posts({60: 3}, {70: 1}, endurance_s=300, recharge_s=450))
