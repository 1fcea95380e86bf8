"""Robots that can be only where their bodies can be driven to from the fleet's entrances."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box

from rota.check import check_plan
from rota.check.seeable import seeable
from rota.check.standing import standing_area_of, standing_areas
from rota.errors import MissionError
from rota.geometry.free_space import sight_walls
from rota.geometry.line_of_sight import visibility_polygon
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot
from rota.model.plan import Plan, Trajectory

WALLS = box(14, 3, 18, 7) - box(14.5, 3.5, 17.5, 6.5)
Entrances = tuple[tuple[float, float], ...] | None
NICHE = (16.0, 5.0)  # the middle of the ground that the walls enclose, but for a slit


def walled(slit_m: float, *, reach_m: float = 12.0, entrances: Entrances = None) -> Mission:
    """Ground of 20 m x 10 m with a niche of 9 m2 behind a slit in its western wall; bodies of 0.3 m."""
    slit = box(13, 5 - slit_m / 2, 16, 5 + slit_m / 2)
    fleet = Fleet(speed_m_s=2.0, sensor=DiscSensor(radius_m=reach_m), body_radius_m=0.3, entrances=entrances)
    wall = Obstacle(shape=MultiPolygon([WALLS - slit]))
    return Mission(name="walled", area=MultiPolygon([box(0, 0, 20, 10)]), obstacles=(wall,), fleet=fleet, period_s=30.0)


def into_the_slit_m2(slit_m: float) -> float:
    """How much room the centre of a body of 0.3 m has at the mouth of a slit that is too narrow for it."""
    half = slit_m / 2
    depths = [0.3 - math.sqrt(0.3**2 - y**2) for y in np.linspace(0, half, 2001)]
    return 2 * half * (0.3 - float(np.mean([0.3 - depth for depth in depths])))


def standing_still(mission: Mission, *places: tuple[float, float]) -> Plan:
    trajectories = tuple(
        Trajectory(robot=f"robot-{k + 1}", times_s=np.zeros(1), positions_m=np.array([place]), loop_start_s=0.0)
        for k, place in enumerate(places)
    )
    return Plan(mission=mission, trajectories=trajectories, seed=0)


@pytest.mark.parametrize(
    ("slit_m", "inside"),
    [(0.7, True), (0.601, True), (0.6, False), (0.5, False)],
    ids=["wide", "a little wider", "just as wide", "narrow"],
)
def test_a_body_stands_only_where_the_entrance_leads(slit_m: float, inside: bool) -> None:
    everywhere = standing_areas(walled(slit_m))[0].shape
    entered = standing_areas(walled(slit_m, entrances=((1.0, 1.0),)))[0].shape
    behind = standing_areas(walled(slit_m, entrances=(NICHE,)))[0].shape
    niche = everywhere.area if inside else 2.4 * 2.4 + into_the_slit_m2(slit_m)
    assert behind.area == pytest.approx(niche, rel=0.001)
    assert entered.area == pytest.approx(everywhere.area if inside else everywhere.area - niche, rel=0.001)


def test_a_fleet_of_two_sizes_has_ground_for_each() -> None:
    mission = walled(0.5, entrances=((1.0, 1.0),))
    small, large = (mission.fleet.equal_robot(name) for name in ("small", "large"))
    fleet = replace(mission.fleet, robots=(replace(small, body_radius_m=0.2), large))
    mission = replace(mission, fleet=fleet)
    areas = {robot.name: standing_area_of(mission, robot).shape.area for robot in fleet.robots or ()}
    assert areas["small"] == pytest.approx(areas["large"] + 2.6 * 2.6, abs=12)
    assert areas["small"] > areas["large"] + 2.6 * 2.6


def test_who_begins_where_no_way_leads_is_told() -> None:
    mission = walled(0.5, entrances=((1.0, 1.0),))
    report = check_plan(standing_still(mission, (0.3, 5.0), NICHE, (10.0, 5.0)))  # the first touches the border
    told = [v for v in report.violations if v.kind == "no way there from the entrances"]
    assert [(v.who, v.place_m) for v in told] == [("robot-2", NICHE)]
    assert told[0].value == pytest.approx(16 - (14 - math.sqrt(0.3**2 - 0.25**2)), abs=0.001)
    kinds = {
        v.kind for v in check_plan(standing_still(replace_entrances(mission, None), (10.0, 5.0), NICHE)).violations
    }
    assert "no way there from the entrances" not in kinds


@pytest.mark.parametrize("first", [0, 1, 2], ids=["outside", "in the slit", "behind it"])
@pytest.mark.parametrize("slit_m", [0.6, 0.602], ids=["just as wide", "a little wider"])
def test_a_gap_just_as_wide_as_the_body_is_no_way_in_wherever_a_loop_begins(slit_m: float, first: int) -> None:
    mission = walled(slit_m, entrances=((1.0, 1.0),))
    places = [(12.0, 5.0), (14.25, 5.0), NICHE, (14.25, 5.0)]
    loop_m = np.array([*places[first:], *places[:first], places[first]])
    times_s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(loop_m, axis=0).T))])
    loop = Trajectory(robot="robot-1", times_s=times_s, positions_m=loop_m, loop_start_s=0.0)
    report = check_plan(Plan(mission=mission, trajectories=(loop,), seed=0))
    told = [v for v in report.violations if v.kind == "no way there from the entrances"]
    if slit_m > 0.6:
        assert not told
        return
    # the first place of the loop to which no way leads, and the moment
    k = next(k for k, place in enumerate(loop_m) if place[0] > 13)
    assert [(v.place_m, v.time_s) for v in told] == [(tuple(loop_m[k]), times_s[k])]


@pytest.mark.parametrize("degrees", [60, 12, 5])
def test_a_body_may_drive_into_a_corner_as_far_as_it_fits(degrees: float) -> None:
    corner = shapely.Polygon([(0, 0), (20, 0), (20, 20 * math.tan(math.radians(degrees)))])
    fleet = Fleet(speed_m_s=2.0, sensor=DiscSensor(radius_m=30.0), body_radius_m=0.3, entrances=((18.0, 0.8),))
    mission = Mission(name="corner", area=MultiPolygon([corner]), fleet=fleet, period_s=60.0)
    in_the_tip = (0.3 / math.tan(math.radians(degrees / 2)), 0.3)
    loop_m = np.array([(18.0, 0.8), in_the_tip, (18.0, 0.8)])
    times_s = np.array([0.0, 10.0, 20.0])
    loop = Trajectory(robot="robot-1", times_s=times_s, positions_m=loop_m, loop_start_s=0.0)
    report = check_plan(Plan(mission=mission, trajectories=(loop,), seed=0))
    assert "no way there from the entrances" not in {v.kind for v in report.violations}


def test_what_is_seen_from_behind_no_entrance_is_excluded() -> None:
    mission = walled(0.5, reach_m=3.0, entrances=((1.0, 1.0),))
    areas = standing_areas(mission)
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(12.5, 14, 61), np.linspace(4, 6, 81)))
    before_slit = np.column_stack([x, y])[shapely.intersects_xy(areas[0].shape, x, y)]
    walls = sight_walls(mission)
    views = shapely.union_all([visibility_polygon(place, walls, 3.0) for place in before_slit])
    niche_m = np.random.default_rng(0).uniform((14.51, 3.51), (17.49, 6.49), (400, 2))
    seen, away_m = seeable(mission, areas, niche_m), shapely.distance(views, shapely.points(niche_m))
    assert seen[away_m == 0].all()
    assert (away_m > 0.15).sum() > 100
    assert not seen[away_m > 0.15].any()
    anywhere = replace_entrances(mission, None)
    assert seeable(anywhere, standing_areas(anywhere), niche_m).all()


def test_a_place_in_the_niche_alone_asks_for_the_niche_alone() -> None:
    report = check_plan(standing_still(walled(0.5, entrances=(NICHE,)), NICHE))
    assert report.demands[0].excluded_area_m2 > 80  # of 193 m2, and a plan may leave out 10
    assert "unseeable" in [violation.kind for violation in report.violations]


@pytest.mark.parametrize(
    ("entrance", "told"),
    [
        ((14.2, 5.4), r"fleet.entrances\[0\]: \[14.2, 5.4\] lies in an obstacle"),
        ((-1.0, 5.0), r"fleet.entrances\[0\]: \[-1, 5\] lies 1 m outside the area"),
        ((0.2, 5.0), r"fleet.entrances\[0\]: \[0.2, 5\] is 0.2 m from the area's border; a body of radius 0.3 m"),
        ((math.nan, 5.0), r"fleet.entrances\[0\]\[0\]: \.nan is not allowed; a finite number is needed"),
    ],
    ids=["in a wall", "outside", "too near the border", "no number"],
)
def test_an_entrance_where_no_body_fits_is_refused(entrance: tuple[float, float], told: str) -> None:
    with pytest.raises(MissionError, match=told):
        walled(0.5, entrances=(entrance,))


@pytest.mark.parametrize(("slit_m", "leads_on"), [(0.6, False), (0.6005, False), (0.602, True)])
def test_an_entrance_in_a_gap_just_as_wide_as_the_body_is_refused(slit_m: float, leads_on: bool) -> None:
    if leads_on:
        assert walled(slit_m, entrances=((14.25, 5.0),)).fleet.entrances == ((14.25, 5.0),)
        return
    told = r"fleet.entrances\[0\]: \[14.25, 5\] leaves a body of radius 0.3 m no way on; gaps must be wider than it by"
    with pytest.raises(MissionError, match=told):
        walled(slit_m, entrances=((14.25, 5.0),))


def test_an_entrance_may_touch_walls() -> None:
    for entrance in [(0.3, 5.0), (0.3, 0.3), (13.7, 5.0)]:
        assert walled(0.5, entrances=(entrance,)).fleet.entrances == (entrance,)


def test_an_empty_list_of_entrances_is_refused() -> None:
    with pytest.raises(MissionError, match=r"fleet.entrances: \[\] is not allowed; it must not be empty"):
        walled(0.5, entrances=())


def test_every_body_of_the_fleet_must_fit_into_an_entrance() -> None:
    fleet = walled(0.5).fleet
    robots = (fleet.equal_robot("small"), Robot(name="wide", speed_m_s=1, sensor=fleet.sensor, body_radius_m=1.5))
    with pytest.raises(MissionError, match=r"a body of radius 1\.5 m does not fit there"):
        replace(walled(0.5), fleet=replace(fleet, robots=robots, entrances=((1.0, 1.0),)))


def replace_entrances(mission: Mission, entrances: Entrances) -> Mission:
    return replace(mission, fleet=replace(mission.fleet, entrances=entrances))
