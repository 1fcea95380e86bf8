"""Robots that take turns at places, beside brute force in steps of a second; a robot flies a place a second."""

from __future__ import annotations

import dataclasses

import pytest
from benchmarks.charging import Tiny, fewest_by_force, mission_of
from tests.planners.patrol.relief.test_relief import with_battery

from rota import check_plan, make_plan
from rota.model.fleet import Robot


@pytest.mark.parametrize(
    ("tiny", "robots"),
    [
        # 2 s there, 4 s on the post, 2 s back and 4 s of charging, a pause of 2 s after each: 12 s for two turns of 6 s
        (Tiny(places=4, charger=1, periods_s={3: 2}, endurance_s=8, recharge=0.5), 2),
        # the same, past a place that is seen on the way
        (Tiny(places=4, charger=3, periods_s={2: 10, 0: 4}, endurance_s=8, recharge=0.5), 2),
        # 6 s of flight and 6 s of charging: every 6 s one comes past both places, though 9 s would do for the first
        (Tiny(places=4, charger=3, periods_s={0: 9, 2: 4}, endurance_s=10, recharge=1.0), 2),
        # the charger is in the zone of one of them
        (Tiny(places=4, charger=0, periods_s={2: 2, 0: 10}, endurance_s=8, recharge=0.5), 2),
    ],
)
def test_robots_leave_posts_alone_as_long_as_they_may_and_serve_others_on_their_ways(tiny: Tiny, robots: int) -> None:
    plan = make_plan(mission_of(tiny))
    assert (check_plan(plan).verdict, len(plan)) == ("met", robots)
    assert fewest_by_force(tiny) == robots


def test_a_team_that_is_named_keeps_all_robots_at_posts() -> None:
    mission = with_battery(mission_of(Tiny(4, 3, {2: 10, 0: 4}, 8, 0.5)), endurance_s=8, recharge_s=4)
    team = tuple(
        Robot(name=name, speed_m_s=1, sensor=mission.fleet.sensor, battery=mission.fleet.battery) for name in "abc"
    )
    plan = make_plan(dataclasses.replace(mission, fleet=dataclasses.replace(mission.fleet, robots=team)))
    assert check_plan(plan).verdict == "met"
    assert [line.robot for line in plan] == ["a", "b", "c"]
