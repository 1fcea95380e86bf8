"""Missions in which robots get in each other's way, planned whole: the check's verdict, and distances simulated."""

from dataclasses import replace

import pytest
from shapely import MultiPolygon, Polygon, box
from tests.planners.patrol.traffic.bodies.driving import closest_m

from rota.check import check_plan
from rota.errors import NoPlanFound
from rota.model.mission import DiscSensor, Fleet, Mission, Zone
from rota.model.plan import Plan
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planning.make_plan import make_plan

BODY_M = 0.3


def mission_of(
    ground: Polygon, period_s: float | None, zones: tuple[Zone, ...] = (), robots: int | None = None
) -> Mission:
    fleet = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=2.0), body_radius_m=BODY_M)
    if robots is not None:
        fleet = replace(fleet, robots=tuple(fleet.equal_robot(f"robot-{k + 1}") for k in range(robots)))
    return Mission(
        name="crowded", area=MultiPolygon([ground]), period_s=period_s, zones=zones, fleet=fleet,
        planning=PatrolSettings(effort="quick"),
    )  # fmt: skip


def zone(shape: Polygon, period_s: float, demand: str = "every_point") -> Zone:
    return Zone(name="zone", shape=MultiPolygon([shape]), period_s=period_s, demand=demand)  # type: ignore[arg-type]


def least_distance_m(plan: Plan) -> float:
    rounds = [(one.times_s, one.positions_m) for one in plan]
    return closest_m(rounds, 6 * max(one.loop_duration_s for one in plan))


@pytest.mark.parametrize(
    ("width_m", "where", "period_s", "robots"),
    [
        # a robot must stay in the middle and be passed: two robots are the fewest that there can be
        (2.4, zone(box(10, 0, 12, 2.4), 4.0), 50.0, 2),
        (2.4, zone(box(11.8, 1.1, 12.2, 1.3), 1.0, "visit"), 60.0, 2),
        # it cannot be passed: there must be one on either side
        (1.0, zone(box(11.8, 0.4, 12.2, 0.6), 1.0, "visit"), 60.0, 3),
    ],
)
def test_a_robot_in_the_middle_of_a_corridor(width_m: float, where: Zone, period_s: float, robots: int) -> None:
    plan = make_plan(mission_of(box(0, 0, 24, width_m), period_s, (where,)), seed=0)
    assert check_plan(plan).verdict == "met"
    assert len(plan.trajectories) == robots
    assert least_distance_m(plan) >= 2 * BODY_M - 1e-6


def test_too_many_robots_for_the_ground_are_told_who_meets_and_where() -> None:
    # six bodies of 0.6 m in a row take 3.6 m, and the corridor has 3 m and is too narrow for two side by side
    mission = mission_of(box(0, 0, 3, 1.0), 30.0, robots=6)
    with pytest.raises(
        NoPlanFound, match=r"no way was found to keep bodies apart: robot-\d and robot-\d come"
    ) as raised:
        make_plan(mission)
    assert "where 0.600 m between their centres are needed" in str(raised.value)
    assert isinstance(raised.value.best, Plan)
    report = check_plan(raised.value.best)
    assert report.verdict == "violated"
    assert {fault.kind for fault in report.violations} == {"bodies touch"}


def test_the_same_seed_gives_the_same_plan() -> None:
    mission = mission_of(box(0, 0, 24, 2.4), 50.0, (zone(box(10, 0, 12, 2.4), 4.0),))
    assert make_plan(mission, seed=3) == make_plan(mission, seed=3)
