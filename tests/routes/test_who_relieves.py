"""Who relieves whom, read from plans of one loop with a robot on it and one on its way, and from circuits."""

from __future__ import annotations

import dataclasses

from tests.planners.patrol.circuits.test_circuits import CORRIDOR as CIRCUITS
from tests.planners.patrol.relief.test_relief import CORRIDOR as LOOP

from rota import make_plan
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.routes.who_relieves import robots_that_relieve


def test_robots_that_take_turns_at_a_loop_without_a_pause_relieve_each_other() -> None:
    # a round takes 36.5 s, so that a period of 37 leaves half a second without a robot
    plan = make_plan(dataclasses.replace(LOOP, period_s=37.0))
    assert robots_that_relieve(plan) == {way.robot for way in plan}


def test_nobody_holds_a_post_for_robots_that_are_launched_on_circuits() -> None:
    assert robots_that_relieve(make_plan(CIRCUITS)) == frozenset()


def test_robots_that_never_charge_relieve_nobody() -> None:
    endless = dataclasses.replace(
        LOOP, chargers=(), fleet=dataclasses.replace(LOOP.fleet, battery=type(LOOP.fleet.battery)())
    )
    assert isinstance(endless.planning, PatrolSettings)
    assert robots_that_relieve(make_plan(endless)) == frozenset()
