"""Plans whose rounds come to places several times, by the check."""

from __future__ import annotations

from dataclasses import replace

import pytest
from shapely import MultiPolygon, Point, box

from rota import check_plan, make_plan
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota.model.motion_limits import MotionLimits
from rota.planners.patrol.planner_settings import PatrolSettings

FLEET = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=2))
ENDS = {"east": (10.0, 0.0), "north": (-5.0, 8.66), "south": (-5.0, -8.66)}


def hub_mission(ends: int, fleet: Fleet = FLEET, *, hub_s: float = 20.5, radius_m: float = 0.3) -> Mission:
    """A hub, and places 10 m from it, each due once in as many of the hub's periods as there are."""
    disc = Point(0, 0).buffer(radius_m)
    zones = [Zone(name="hub", period_s=hub_s, demand="visit", shape=MultiPolygon([disc]))]
    for name, place in list(ENDS.items())[:ends]:
        shape = MultiPolygon([Point(place).buffer(radius_m)])
        zones.append(Zone(name=name, period_s=ends * hub_s, demand="visit", shape=shape))
    return Mission(
        name="posts", area=MultiPolygon([box(-12, -12, 12, 12)]), period_s=None, zones=tuple(zones), fleet=fleet,
        planning=PatrolSettings(effort="quick"),
    )  # fmt: skip


@pytest.mark.parametrize("ends", [2, 3])
@pytest.mark.parametrize("asks", ["fewest", "one"])
def test_one_robot_passes_the_hub_between_all_ends(ends: int, asks: str) -> None:
    fleet = FLEET if asks == "fewest" else replace(FLEET, robots=(FLEET.equal_robot("lone"),))
    plan = make_plan(hub_mission(ends, fleet), seed=0)
    assert check_plan(plan).verdict == "met"
    assert [trajectory.loop_duration_s <= 20.001 * ends for trajectory in plan] == [True]


def test_ground_seen_from_single_places_is_watched_so_as_well() -> None:
    mission = hub_mission(2)
    seen = tuple(replace(zone, demand="every_point") for zone in mission.zones)
    plan = make_plan(replace(mission, zones=seen), seed=0)
    assert (len(plan), check_plan(plan).verdict) == (1, "met")


@pytest.mark.parametrize(
    "fleet",
    [replace(FLEET, turn_rate_rad_s=2.0), replace(FLEET, motion=MotionLimits(acceleration_m_s2=1.0))],
    ids=["turns", "mass"],
)
def test_what_turning_and_mass_cost_is_counted(fleet: Fleet) -> None:
    plan = make_plan(hub_mission(2, fleet, hub_s=24.5), seed=0)
    assert (len(plan), check_plan(plan).verdict) == (1, "met")


def test_a_wall_makes_the_way_longer() -> None:
    wall = Obstacle(shape=MultiPolygon([box(4, -6, 5, 12)]))
    plan = make_plan(replace(hub_mission(2), obstacles=(wall,)), seed=0)
    assert (len(plan), check_plan(plan).verdict) == (2, "met")
    plan = make_plan(replace(hub_mission(2, hub_s=33.0), obstacles=(wall,)), seed=0)
    assert (len(plan), check_plan(plan).verdict) == (1, "met")


def test_robots_go_no_farther_into_wide_zones_than_spares_a_robot() -> None:
    plan = make_plan(hub_mission(2, hub_s=14.0, radius_m=2.5), seed=0)
    assert (len(plan), check_plan(plan).verdict) == (1, "met")


def test_ground_beside_places_has_robots_of_its_own() -> None:
    plan = make_plan(replace(hub_mission(2), period_s=300.0), seed=0)
    assert check_plan(plan).verdict == "met"
    assert min(trajectory.loop_duration_s for trajectory in plan) == pytest.approx(40, rel=1e-3)
    assert (len(plan), plan.lower_bound_robots) == (2, 2)
