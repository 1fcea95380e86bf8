"""What a swarm's robots have in range and see where they hold, against areas by formulas and by brute force."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box

from rota.cells.importance_cells import importance_in_range
from rota.check import check_plan, report_table, report_to_json
from rota.check.holding import Holding, holding_of, shadows
from rota.model.mission import DiscSensor, Fleet, ImportanceMap, Mission, Obstacle, Robot, SquareSensor, Zone
from rota.model.plan import Plan, Trajectory
from rota.planners.swarm.planner_settings import SwarmSettings

SIZE_M, REACH_M, BODY_M = 40.0, 10.0, 0.5


def held(*places: tuple[float, float], obstacles: tuple[Obstacle, ...] = (), square: bool = False) -> Plan:
    """Robots of a swarm that hold where they begin, in a square of 40 m."""
    sensor = SquareSensor(side_m=2 * REACH_M) if square else DiscSensor(radius_m=REACH_M)
    robots = tuple(
        Robot(name=f"r{k}", speed_m_s=1.0, sensor=sensor, body_radius_m=BODY_M, start=place)
        for k, place in enumerate(places)
    )
    mission = Mission(
        name="held",
        area=MultiPolygon([box(0, 0, SIZE_M, SIZE_M)]),
        obstacles=obstacles,
        fleet=Fleet(speed_m_s=1.0, sensor=sensor, body_radius_m=BODY_M, robots=robots),
        planning=SwarmSettings(),
    )
    ways = tuple(
        Trajectory(robot=robot.name, times_s=np.zeros(1), positions_m=np.array([robot.start]), loop_start_s=0.0)
        for robot in robots
    )
    return Plan(mission=mission, trajectories=ways, seed=0)


def holding(plan: Plan) -> Holding:
    found = holding_of(plan)
    assert found is not None
    return found


def wall(x0: float, y0: float, x1: float, y1: float) -> Obstacle:
    return Obstacle(shape=MultiPolygon([box(x0, y0, x1, y1)]))


def test_a_disc_and_a_square_in_the_open_are_seen_in_full() -> None:
    one = holding(held((20, 20)))
    assert one.ground_m2 == pytest.approx(1600)
    assert (one.in_range_m2, one.seen_m2) == pytest.approx((math.pi * REACH_M**2,) * 2)
    assert holding(held((20, 20), square=True)).seen_m2 == pytest.approx(400)
    assert one.unreached == ()


def test_a_long_wall_hides_the_cap_behind_it() -> None:
    one = holding(held((20, 20), obstacles=(wall(25, 5, 26, 35),)))
    cap = lambda off_m: REACH_M**2 * math.acos(off_m / REACH_M) - off_m * math.sqrt(REACH_M**2 - off_m**2)  # noqa: E731
    whole = math.pi * REACH_M**2
    assert one.in_range_m2 == pytest.approx(whole - cap(5) + cap(6), rel=1e-4)
    assert one.seen_m2 == pytest.approx(whole - cap(5), rel=1e-4)


def test_a_short_wall_hides_the_sector_behind_it() -> None:
    one = holding(held((20, 20), obstacles=(wall(25, 18, 25.001, 22),)))
    angle = 2 * math.atan2(2, 5)
    assert one.in_range_m2 - one.seen_m2 == pytest.approx(angle / 2 * REACH_M**2 - 10, rel=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_shadows_hide_what_lines_of_sight_say(seed: int) -> None:
    rng = np.random.default_rng(seed)
    ends = rng.uniform(-REACH_M, REACH_M, (12, 2))
    walls = np.hstack([ends, ends + rng.uniform(-6, 6, (12, 2))])
    hidden = shadows(np.zeros(2), walls, REACH_M)
    points = rng.uniform(-REACH_M, REACH_M, (4000, 2))
    points = points[np.hypot(*points.T) < REACH_M]
    lines = shapely.linestrings(np.stack([np.zeros_like(points), points], axis=1))
    crossed = shapely.intersects(lines[:, None], shapely.linestrings(walls.reshape(-1, 2, 2))[None]).any(axis=1)
    assert (shapely.contains_xy(hidden, *points.T) == crossed).mean() == 1


def test_rooms_without_a_door_or_with_a_narrow_one_are_told_and_corners_are_not() -> None:
    closed = (wall(0, 10, 12, 10.2), wall(12, 0, 12.2, 10.2))
    narrow = (wall(30, 0, 30.2, 19.6), wall(30, 20.4, 30.2, 40))  # 0.8 m; bodies have 1 m
    one = holding(held((20, 20), obstacles=(*closed, *narrow)))
    areas = [area_m2 for *_, area_m2 in one.unreached]
    assert areas == pytest.approx([9.8 * 40, 120], rel=0.01)
    assert one.unreached[0][0] > 30.2
    assert max(one.unreached[1][:2]) < 12
    both = holding(held((20, 20), (35, 20), obstacles=(*closed, *narrow)))
    assert [area_m2 for *_, area_m2 in both.unreached] == pytest.approx([120], rel=0.01)


def test_the_report_tells_it_as_text_and_as_json() -> None:
    plan = held((20, 20), obstacles=(wall(25, 0, 26, 40),))
    report = check_plan(plan)
    assert report.holding is not None
    text = report_table(report)
    assert f"held at last: {report.holding.in_range_m2 / 1560:.1%} of the ground in range" in text
    assert f"{report.holding.seen_m2 / 1560:.1%} seen through no wall" in text
    x, y, area_m2 = report.holding.unreached[0]
    assert f"no robot can reach {area_m2:.3f}".rstrip("0").rstrip(".") in text
    told = json.loads(json.dumps(report_to_json(report)))["holding"]
    assert told["unreached"] == [{"x": x, "y": y, "area_m2": area_m2}]
    assert told["seen_m2"] == report.holding.seen_m2


def test_no_robots_hold_nothing() -> None:
    nobody = holding(replace(held((20, 20)), trajectories=()))
    assert nobody == Holding(ground_m2=1600.0, in_range_m2=0.0, seen_m2=0.0, unreached=())


def test_robots_that_leave_hold_nothing() -> None:
    plan = held((10, 20), (30, 20))
    robots = plan.mission.fleet.robots or ()
    fleet = replace(plan.mission.fleet, robots=(replace(robots[0], leaves_s=5.0), robots[1]))
    gone = replace(plan, mission=replace(plan.mission, fleet=fleet))
    assert holding(gone).in_range_m2 == pytest.approx(math.pi * REACH_M**2)


def test_importance_in_range_is_that_of_closed_forms_and_of_the_planner_s_own_count() -> None:
    plan = held((20, 20), (12, 34), obstacles=(wall(0, 0, 10, 20),))
    assert holding(plan).importance_in_range is None
    half = Zone(name="z", shape=MultiPolygon([box(20, 0, 40, 40)]), period_s=None, importance=3)
    valued = replace(plan, mission=replace(plan.mission, zones=(half,)))
    # half a disc lies in the zone; of the ground 600 m2 are worth 1 and 800 m2 3; the discs overlap by nothing
    inside_m2, outside_m2 = math.pi * REACH_M**2 / 2, math.pi * REACH_M**2 / 2
    corner_m2 = holding(plan).in_range_m2 - inside_m2 - outside_m2
    share = (3 * inside_m2 + outside_m2 + corner_m2) / (3 * 800 + 600)
    told = holding(valued).importance_in_range
    sticking_m2 = shapely.Point(12, 34).buffer(REACH_M, quad_segs=64).intersection(box(20, 0, 40, 40)).area
    assert told == pytest.approx(share + 2 * sticking_m2 / 3000, abs=2e-3)
    rng = np.random.default_rng(3)
    hills = ImportanceMap(values=rng.uniform(0, 5, (7, 9)), low_m=(2, 3), step_m=(4.5, 5.5))
    valued = replace(plan, mission=replace(plan.mission, zones=(half,), importance=hills))
    assert holding(valued).importance_in_range == pytest.approx(importance_in_range(valued), abs=3e-3)
    report = check_plan(valued)
    assert report.holding is not None
    assert f"{report.holding.importance_in_range:.1%} of its importance in range" in report_table(report)
    assert json.loads(json.dumps(report_to_json(report)))["holding"]["importance_in_range"] is not None
