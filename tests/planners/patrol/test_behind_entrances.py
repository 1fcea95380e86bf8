"""Patrols that stay where the fleet's entrances lead."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
import shapely
from shapely import MultiPolygon, box

import rota
from rota.check import check_plan
from rota.geometry.free_space import standing_anywhere, standing_space
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, StartPoints
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.ground.standing import space_for
from rota.planners.patrol.methods.large.cells import missions_of, where_robots_come
from rota.planners.patrol.planner_settings import PatrolSettings

OUTSIDE, NICHE = (1.0, 1.0), (9.0, 4.0)


def yard(slit_m: float, **fleet: Any) -> Mission:
    """Ground of 12 m x 8 m with a niche of 1 m2 behind a slit."""
    slit = box(7, 4 - slit_m / 2, 9, 4 + slit_m / 2)
    walls = box(8, 3, 10, 5) - box(8.5, 3.5, 9.5, 4.5) - slit
    return Mission(
        name="yard",
        area=MultiPolygon([box(0, 0, 12, 8)]),
        obstacles=(Obstacle(shape=MultiPolygon([walls])),),
        period_s=60,
        fleet=Fleet(**{"speed_m_s": 1.0, "sensor": DiscSensor(radius_m=2.5), "body_radius_m": 0.2, **fleet}),
        planning=PatrolSettings(effort="quick"),
    )


def test_nobody_is_sent_behind_a_slit_and_what_is_hidden_there_is_left_out() -> None:
    anywhere, entered = rota.make_plan(yard(0.3)), rota.make_plan(yard(0.3, entrances=(OUTSIDE,)))
    niche = box(8, 3, 10, 5)
    inside = [t for t in anywhere if niche.contains(shapely.LineString(t.positions_m[[0, *range(len(t.times_s))]]))]
    assert len(inside) == 1
    assert not any(niche.buffer(-0.5).intersects(shapely.LineString(t.positions_m)) for t in entered)
    report = check_plan(entered)
    assert report.verdict == "met"
    assert 0 < report.demands[0].excluded_area_m2 < 1
    assert len(list(entered)) == len(list(anywhere)) - 1
    # what is proved for entrances is proved for less ground, by robots that may go to fewer places
    assert (entered.lower_bound_robots or 0) <= len(list(entered))


def test_a_gap_must_be_wider_than_the_body_to_be_a_way_in() -> None:
    for slit_m, leads_in in [(0.4, False), (0.4005, False), (0.402, True)]:
        mission = yard(slit_m, entrances=(OUTSIDE,))
        space = space_for(mission, (), mission.fleet.equal_robot("any"), 0.0).whole
        assert (len(space.geoms), space.covers(shapely.Point(NICHE))) == (1, leads_in)
    assert check_plan(rota.make_plan(yard(0.4, entrances=(OUTSIDE,)))).verdict == "met"


def test_coarse_arcs_close_no_way_in() -> None:
    """Between two corners that stand across from each other the arcs of bodies all but touch."""
    pillars = [box(5, 0, 6, 4), box(6.3355, 4.2242, 7.3, 8)]  # 0.4035 m from corner to corner; arcs stand out 0.4078 m
    mission = replace(
        yard(0.3, entrances=(OUTSIDE,)), obstacles=tuple(Obstacle(shape=MultiPolygon([pillar])) for pillar in pillars)
    )
    assert len(standing_anywhere(mission, 0.2, arc_corners=16).geoms) == 2
    assert standing_space(mission, 0.2).covers(shapely.Point(11, 4))
    space = space_for(mission, (), mission.fleet.equal_robot("any"), 0.0).whole
    assert space.covers(shapely.Point(11, 4))


@pytest.mark.parametrize(
    ("slit_m", "fleet"),
    [
        (0.3, {"start": StartPoints(points_m=(OUTSIDE, NICHE))}),
        (0.4, {"start": StartPoints(points_m=(OUTSIDE, NICHE))}),
        (0.3, {"start_of_robot": NICHE}),
    ],
    ids=["points", "points behind a slit just as wide as the body", "a robot of its own"],
)
def test_starts_to_which_no_way_leads_are_refused(slit_m: float, fleet: dict[str, Any]) -> None:
    mission = yard(slit_m, entrances=(OUTSIDE,), **{k: v for k, v in fleet.items() if k == "start"})
    field = r"fleet.start.points\[1\]"
    if "start_of_robot" in fleet:
        robots = tuple(
            replace(mission.fleet.equal_robot(name), start=place) for name, place in [("a", OUTSIDE), ("b", NICHE)]
        )
        mission, field = replace(mission, fleet=replace(mission.fleet, robots=robots)), r"fleet.robots\[1\].start"
    with pytest.raises(rota.MissionError, match=field + r": \[9, 4\]: no way leads there from fleet.entrances"):
        rota.make_plan(mission)


def test_starts_outside_lead_to_loops_outside() -> None:
    mission = yard(0.3, entrances=(OUTSIDE,), start=StartPoints(points_m=(OUTSIDE, (11.0, 7.0))))
    assert check_plan(rota.make_plan(mission)).verdict == "met"


def test_the_ways_from_starts_go_through_all_gaps_that_are_ways_in() -> None:
    pillars = [box(5, 0, 6, 4), box(6.3355, 4.2242, 7.3, 8)]
    mission = yard(0.3, entrances=(OUTSIDE,))
    robots = [replace(mission.fleet.equal_robot(name), start=at) for name, at in [("a", OUTSIDE), ("b", (10.0, 4.0))]]
    fleet = replace(mission.fleet, robots=tuple(robots))
    obstacles = tuple(Obstacle(shape=MultiPolygon([pillar])) for pillar in pillars)
    plan = rota.make_plan(replace(mission, fleet=fleet, obstacles=obstacles))
    assert check_plan(plan).verdict == "met"


def test_an_entrance_where_a_body_touches_a_wall_leads_in() -> None:
    corridor = replace(yard(0.3), area=MultiPolygon([box(0, 0, 12, 3)]), obstacles=())
    for entrance in [(0.2, 1.5), (0.2, 0.2)]:
        fleet = replace(corridor.fleet, entrances=(entrance,), sensor=DiscSensor(radius_m=0.27))
        mission = replace(corridor, fleet=fleet)
        for arc_corners in (8, 16, 256):
            assert len(standing_space(mission, 0.2, arc_corners=arc_corners).geoms) == 1
        space, sure, *_ = space_for(mission, (), mission.fleet.equal_robot("any"), 0.0)
        assert (len(space.geoms), len(sure.geoms)) == (1, 1)


@pytest.mark.parametrize(("unseeable", "reach_m"), [("exclude", 2.5), ("exclude", 12.0), ("refuse", 2.5)])
def test_what_no_way_leads_to_is_told_before_the_search(unseeable: Any, reach_m: float) -> None:
    wall = Obstacle(shape=MultiPolygon([box(8, 0, 8.2, 3.85), box(8, 4.15, 8.2, 8)]))
    mission = yard(0.3, entrances=(OUTSIDE,), sensor=DiscSensor(radius_m=reach_m))
    mission = replace(mission, obstacles=(wall,) if unseeable == "exclude" else mission.obstacles, unseeable=unseeable)
    with pytest.raises(
        rota.NoPlanFound, match=r"cannot be seen from anywhere a robot can come to from fleet.entrances"
    ):
        set_up_problem(mission)


def test_pieces_of_large_ground_have_entrances_of_their_own_to_what_ways_lead_to() -> None:
    ground = MultiPolygon([box(0, 0, 60, 30)])
    room = box(41, 11, 45, 14) - box(41.5, 11.5, 44.5, 13.5)
    mission = yard(0.3, entrances=(OUTSIDE,), sensor=DiscSensor(radius_m=2.0))
    mission = replace(mission, area=ground, obstacles=(Obstacle(shape=MultiPolygon([room])),))
    problem = set_up_problem(mission)
    pieces = missions_of(mission, 6, 4.0, where_robots_come(problem))
    assert len(pieces) == 6
    assert sum(entrance == OUTSIDE for piece in pieces for entrance in piece.fleet.entrances or ()) == 0
    for piece in pieces:
        space = set_up_problem(piece).space
        assert space.area > 0.9 * piece.area.intersection(problem.space).buffer(-0.2).area
        assert space.difference(problem.space.buffer(1e-6)).is_empty
        assert not space.intersects(shapely.Point(43, 12.5))


def test_a_narrow_corner_whose_space_crosses_itself_by_rounding_is_planned() -> None:
    corner = shapely.Polygon([(0, 0), (20, 0), (20, 20 * math.tan(math.radians(6)))])
    mission = yard(0.3, sensor=DiscSensor(radius_m=3.0), body_radius_m=0.3)
    fleet = replace(mission.fleet, entrances=((18.0, 0.8),))
    plan = rota.make_plan(replace(mission, area=MultiPolygon([corner]), obstacles=(), period_s=100, fleet=fleet))
    assert check_plan(plan).verdict == "met"
