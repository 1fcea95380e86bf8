"""The order of plans that take over: where robots are too few, zones come in the order of their importance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from rota import DiscSensor, Fleet, Mission, MissionError, PatrolSettings, Plan, Robot, Trajectory, Zone, replan
from rota.model.importance import ImportanceMap
from rota.replanning.order import Order, levels_of

# a corridor 100 m long; a robot at 1 m/s goes to and fro over 10 m at either end, in 20 s
ENDS = {"west": 0.0, "east": 90.0}
SLOW = pytest.mark.slow  # the same search again


def watched(importance: dict[str, float]) -> Plan:
    """A plan of two robots, each on its own zone, of which a period of 22 s is asked."""
    robots = tuple(Robot(name=f"of {name}", speed_m_s=1, sensor=DiscSensor(radius_m=2)) for name in ENDS)
    zones = tuple(
        Zone(name=name, period_s=22, shape=shapely.box(x, -1, x + 10, 1), importance=importance.get(name))  # type: ignore[arg-type]
        for name, x in ENDS.items()
    )
    mission = Mission(
        name="corridor", area=shapely.MultiPolygon([shapely.box(0, -1, 100, 1)]), zones=zones, period_s=None,
        fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=2), robots=robots), planning=PatrolSettings(effort="quick"),
    )  # fmt: skip
    ways = tuple(
        Trajectory(robot=f"of {name}", times_s=[0, 10, 20], positions_m=np.array([[x, 0], [x + 10, 0], [x, 0]]))
        for name, x in ENDS.items()
    )
    return Plan(mission=mission, trajectories=ways)


def worst_ratios(importance: dict[str, float], lost: str) -> dict[str, float]:
    """The worst ratio of each zone after this loss."""
    found = replan(watched(importance), at_s=100, lost=[lost], time_limit_s=5, should_stop=lambda: False)
    return {one.name: one.worst_gap_at_least_s / one.period_s for one in found.report.demands}


@pytest.mark.parametrize("lost", ["of west", pytest.param("of east", marks=SLOW)])
def test_the_more_important_zone_is_kept_and_the_other_is_left(lost: str) -> None:
    ratios = worst_ratios({"west": 1, "east": 5}, lost)
    assert ratios["east"] <= 1
    assert ratios["west"] == np.inf


@pytest.mark.parametrize(
    "importance", [{"west": 3, "east": 3}, pytest.param({}, marks=SLOW), pytest.param({"west": 1}, marks=SLOW)]
)
def test_zones_of_one_importance_share_what_there_is(importance: dict[str, float]) -> None:
    # from end to end and back is 200 m at 1 m/s, less what is seen from 2 m away at the turns
    ratios = worst_ratios(importance, "of west")
    assert max(ratios.values()) == pytest.approx((200 - 4) / 22, abs=0.3)


def test_nothing_is_left_where_those_that_remain_suffice() -> None:
    plan = watched({"west": 1, "east": 5})
    mission = replace(plan.mission, zones=tuple(replace(zone, period_s=210) for zone in plan.mission.zones))
    found = replan(replace(plan, mission=mission), at_s=100, lost=["of east"], time_limit_s=5)
    assert found.report.verdict == "met"


def test_less_important_demands_are_eased_and_others_kept() -> None:
    mission = replace(watched({"west": 1, "east": 5}).mission, period_s=100.0, importance=1)
    assert levels_of(mission) == [{"east"}, {"west", "area"}]
    for times, asked in ((2.0, (44.0, 200.0)), (np.inf, (None, None))):
        eased = Order(mission).ease_all_but(mission, 1, times)
        west, east = (zone.period_s for zone in eased.zones)
        assert (east, (west, eased.period_s)) == (22, asked)


def test_a_map_of_importance_is_for_swarms() -> None:
    values = ImportanceMap(low_m=(0, 0), step_m=(50, 1), values=np.ones((1, 3)))
    with pytest.raises(MissionError, match="patrol compares whole zones by their importance: give a number"):
        replace(watched({}).mission, importance=values)
