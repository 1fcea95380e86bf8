"""The shortest loop of one robot beside closed forms, and where it is not what is looked for."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import pytest
from shapely import MultiPolygon, box
from tests.planners.patrol.searching import search_on

from rota.check import check_plan
from rota.errors import NoPlanFound
from rota.model.mission import DiscSensor, Fleet, Mission, Zone
from rota.model.plan import Plan
from rota.planners.patrol.methods.fixed_team.one_loop import is_one_loop
from rota.planners.patrol.methods.fixed_team.team import Team
from rota.planners.patrol.methods.tours import fewest_robots_anywhere
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planning.make_plan import search_plan

LENGTH_M, WIDTH_M, REACH_M = 40.0, 2.0, 2.5
# a corridor's ends are seen from where the reach ends at their corners, from the line along its middle
THERE_AND_BACK_M = 2 * (LENGTH_M - 2 * math.sqrt(REACH_M**2 - (WIDTH_M / 2) ** 2))
ALONE = Team(robots=1, starting=Counter(), method=fewest_robots_anywhere)


def corridor(period_s: float, *zones: Zone, turn_rate_rad_s: float | None = None) -> Mission:
    return Mission(
        name="corridor", area=MultiPolygon([box(0, 0, LENGTH_M, WIDTH_M)]), period_s=period_s, zones=zones,
        fleet=Fleet(robots=1, speed_m_s=1, sensor=DiscSensor(radius_m=REACH_M), turn_rate_rad_s=turn_rate_rad_s),
        planning=PatrolSettings(effort="quick"),
    )  # fmt: skip


@pytest.mark.parametrize("spare", [1.02, 30.0])
def test_the_loop_is_as_short_however_long_the_period_is(spare: float) -> None:
    plan = search_plan(corridor(spare * THERE_AND_BACK_M)).plan
    assert check_plan(plan).verdict == "met"
    assert THERE_AND_BACK_M - 1e-6 <= round_s(plan) <= 1.015 * THERE_AND_BACK_M


def test_who_turns_on_the_spot_does_so_at_the_ends_alone() -> None:
    plan = search_plan(corridor(2 * THERE_AND_BACK_M, turn_rate_rad_s=0.3)).plan
    least_s = THERE_AND_BACK_M + 2 * math.pi / 0.3
    assert least_s - 1e-6 <= round_s(plan) <= 1.015 * least_s


def test_a_period_that_is_too_short_is_told_with_the_shortest_loop() -> None:
    with pytest.raises(NoPlanFound) as failure:
        search_plan(corridor(0.8 * THERE_AND_BACK_M))
    assert isinstance(failure.value.best, Plan)
    assert round_s(failure.value.best) <= 1.015 * THERE_AND_BACK_M


def round_s(plan: Plan) -> float:
    """The seconds of the only robot's round."""
    (trajectory,) = plan
    return float(trajectory.times_s[-1] - trajectory.times_s[trajectory.loop_index])


def test_other_periods_and_more_robots_are_no_matter_of_one_loop() -> None:
    one = corridor(200)
    assert is_one_loop(search_on(one), ALONE)
    assert not is_one_loop(search_on(one), replace(ALONE, robots=2))
    urgent = Zone(name="urgent", shape=MultiPolygon([box(0, 0, 2, 2)]), period_s=50)
    assert not is_one_loop(search_on(corridor(200, urgent)), ALONE)
    assert is_one_loop(search_on(corridor(200, turn_rate_rad_s=1.0)), ALONE)
