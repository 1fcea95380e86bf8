"""The proved number of robots on missions whose best teams are known, and the sentence that tells the proof."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely import MultiPolygon, box, union_all
from tests.planners.patrol.searching import YARD

from rota.files.mission_file import read_mission
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota.planners.patrol.bounds.best_bound import prove_bound, prove_by_area
from rota.planners.patrol.bounds.seeable_area import surely_seeable_m2
from rota.planners.patrol.ground.problem import set_up_problem

EXAMPLES = Path(__file__).parents[4] / "examples"


def fleet(radius_m: float, speed_m_s: float, body_radius_m: float = 0.0) -> Fleet:
    return Fleet(speed_m_s=speed_m_s, sensor=DiscSensor(radius_m=radius_m), body_radius_m=body_radius_m)


def bound(mission: Mission) -> int:
    return proof(mission)[0]


def proof(mission: Mission) -> tuple[int, str]:
    """The bound at effort quick, which looks at fewer orders of places."""
    bound = prove_bound(set_up_problem(mission.with_effort("quick")))
    return bound.robots, bound.reason


@pytest.mark.parametrize("rooms", [2, 3, 5])
def test_rooms_without_doors_take_a_robot_each(rooms: int) -> None:
    boxes = MultiPolygon([box(6 * k, 0, 6 * k + 5, 5) for k in range(rooms)])
    floor = Mission(name="rooms", area=boxes, period_s=1000, fleet=fleet(2, 1))
    robots, reason = proof(floor)
    assert robots == rooms
    assert f"{rooms} parts between which no robot can travel" in reason
    # what lies outside the area can be looked through: from the first room a far-sighted robot sees them all
    assert bound(replace(floor, fleet=fleet(6 * rooms + 5, 1))) == 1
    # unless there are walls
    walls = tuple(Obstacle(shape=MultiPolygon([box(6 * k + 5, -1, 6 * k + 6, 6)])) for k in range(rooms - 1))
    whole = box(0, 0, 6 * rooms - 1, 5)
    walled = replace(floor, area=whole, obstacles=walls, fleet=fleet(6 * rooms + 5, 1))
    assert bound(walled) == rooms
    # glass walls part the robots, not what they see; hedges part what they see, not the robots
    glass = tuple(replace(wall, blocks="motion") for wall in walls)
    hedge = tuple(replace(wall, blocks="sight") for wall in walls)
    assert bound(replace(walled, obstacles=glass)) == 1
    assert bound(replace(walled, obstacles=hedge)) == 1


def test_doors_part_rooms_when_they_are_narrower_than_a_body() -> None:
    def floor(door_m: float) -> Mission:
        walls = union_all([box(9.8, -1, 10, 3), box(9.8, 3 + door_m, 10, 11)])
        parts = tuple(Obstacle(shape=MultiPolygon([part])) for part in walls.geoms)
        area = box(0, 0, 20, 10)
        return Mission(name="door", area=area, obstacles=parts, period_s=600, fleet=fleet(3, 1, 0.3))

    assert bound(floor(0.55)) == 2
    assert bound(floor(0.65)) == 1


def test_parts_that_touch_in_a_point_may_be_passed() -> None:
    corner = MultiPolygon([box(0, 0, 10, 10), box(10, 10, 20, 20)])
    assert bound(Mission(name="corner", area=corner, period_s=1000, fleet=fleet(3, 1))) == 1


@pytest.mark.parametrize("robots", [1, 2, 4, 7])
def test_a_corridor_takes_what_its_best_team_has(robots: int) -> None:
    # each robot goes to and fro over V T / 2 and sees the corridor's full width up to sqrt(r^2 - (w / 2)^2) further
    r, width, speed, period = 4.0, 2.0, 2.0, 30.0
    length = robots * (speed * period / 2 + 2 * math.sqrt(r * r - width * width / 4))
    corridor = Mission(name="corridor", area=box(0, 0, length, width), period_s=period, fleet=fleet(r, speed))
    assert bound(corridor) == robots
    assert bound(replace(corridor, area=box(0, 0, 1.05 * length, width))) == robots + 1


def test_a_corridor_bent_round_walls_is_as_long_as_the_way_through_it() -> None:
    # three lanes of 50 m, 2 m wide: one robot could serve 34 + 8 m of the straight line, but the way is 158 m long
    walls = Obstacle(shape=MultiPolygon([box(2, 2, 50, 4), box(0, 6, 48, 8)]))
    hall = Mission(name="hall", area=box(0, 0, 50, 10), obstacles=(walls,), period_s=34, fleet=fleet(4, 2))
    assert bound(hall) in (3, 4)
    assert bound(replace(hall, area=box(0, 0, 50, 2), obstacles=())) == 2


def test_a_ring_takes_half_of_what_a_corridor_does() -> None:
    # robots that follow each other along the middle of a ring 2 m wide: a lap is 4 x 48 m
    ring = box(0, 0, 50, 50).difference(box(2, 2, 48, 48))
    block = Obstacle(shape=MultiPolygon([box(2, 2, 48, 48)]))
    for robots in (1, 3):
        period = 4 * 48 / (2 * robots)
        mission = Mission(name="ring", area=box(0, 0, 50, 50), obstacles=(block,), period_s=period, fleet=fleet(4, 2))
        assert bound(mission) <= robots
        assert bound(replace(mission, area=ring, obstacles=())) <= robots
        assert bound(replace(mission, period_s=period / 2)) > robots / 2


def test_two_robots_on_a_ring_serve_three_places_a_round_trip_apart() -> None:
    # three corners of a triangle of 60 m sides in a wide field: two robots half a lap apart pass each every 45 s at
    # 2 m/s, though there and back between two of them takes 60 s less what a sensor of 1 m saves
    zones = tuple(
        Zone(name=f"z{k}", shape=box(x - 0.1, y - 0.1, x + 0.1, y + 0.1), period_s=45)
        for k, (x, y) in enumerate([(10, 10), (70, 10), (40, 10 + 60 * math.sin(math.pi / 3))])
    )
    field = Mission(name="field", area=box(0, 0, 80, 80), zones=zones, fleet=fleet(1, 2))
    assert bound(field) == 2
    visits = tuple(replace(zone, demand="visit") for zone in zones)
    assert bound(replace(field, zones=visits)) == 2
    # in 28 s nobody gets from one to the next (58 m less 0.2 m of zone), in 30 s one does
    urgent = tuple(replace(zone, period_s=28) for zone in zones)
    assert bound(replace(field, zones=urgent)) == 3


def test_places_that_one_robot_sees_at_once() -> None:
    # a U whose tips are 4 m apart: by foot 100 m, but a robot in one tip sees the other across the gap
    tips = box(0, 0, 50, 12).difference(box(0, 4, 46, 8))
    zones = (
        Zone(name="a", shape=box(0, 2.5, 2, 4), period_s=3),
        Zone(name="b", shape=box(0, 8, 2, 9.5), period_s=3),
    )
    mission = Mission(name="u", area=tips, zones=zones, fleet=fleet(8, 1))
    assert bound(mission) == 1
    hall = Obstacle(shape=MultiPolygon([box(0, 4, 46, 8)]))
    assert bound(replace(mission, area=box(0, 0, 50, 12), obstacles=(hall,))) == 2
    # a pond is looked at from its shore; who stands at its end sees all of it
    pond = Obstacle(shape=MultiPolygon([box(4, 4, 8, 8)]), blocks="motion")
    lake = Zone(name="lake", shape=box(4, 4, 8, 8), period_s=1)
    shore = Mission(name="shore", area=box(0, 0, 30, 12), zones=(lake,), obstacles=(pond,), fleet=fleet(9, 1))
    assert bound(shore) == 1
    assert bound(replace(shore, fleet=fleet(2, 0.5))) >= 2


def test_zones_to_visit() -> None:
    zones = tuple(
        Zone(name=f"z{k}", shape=box(100 * k, 0, 100 * k + 10, 10), period_s=20, demand="visit") for k in range(4)
    )
    strip = Mission(name="visits", area=box(0, 0, 310, 10), zones=zones, fleet=fleet(1, 4))
    assert bound(strip) == 4  # 90 m apart, 80 m in 20 s
    assert bound(replace(strip, fleet=fleet(1, 5))) == 4  # to and fro takes longer
    assert bound(replace(strip, fleet=fleet(1, 9.1))) < 4
    # a robot at rest is inside all of them
    nested = tuple(replace(zone, shape=box(0, 0, 310 - 60 * k, 10)) for k, zone in enumerate(zones))
    assert bound(replace(strip, zones=nested)) == 1


def test_travel_between_fields_counts() -> None:
    # two fields of 30 m squares, 150 m apart: one robot sweeps 2078 m2 in 20 s and might go from one to the other, but
    # has no time for both
    zones = tuple(Zone(name=f"f{k}", shape=box(180 * k, 0, 180 * k + 30, 30), period_s=20) for k in range(2))
    mission = Mission(name="fields", area=box(0, 0, 210, 30), zones=zones, fleet=fleet(5, 10))
    robots, reason = proof(mission)
    assert robots == 2
    # 2 x 30 / 10 = 6 lanes' worth: in 40 s one robot can do both and come back
    assert "robot" in reason or "travel" in reason
    assert bound(replace(mission, zones=tuple(replace(zone, period_s=100) for zone in zones))) == 1


def test_longer_periods_never_raise_it() -> None:
    rng = np.random.default_rng(12)
    harbour = read_mission(EXAMPLES / "harbour.yaml").mission
    building = read_mission(EXAMPLES / "building.yaml").mission
    for mission in (harbour, building):
        before = None
        for share in (0.3, 1.0, 4.0):
            factor = share * float(rng.uniform(1, 1.2))
            zones = tuple(
                replace(z, period_s=None if z.period_s is None else factor * z.period_s) for z in mission.zones
            )
            period = None if mission.period_s is None else factor * mission.period_s
            now = bound(replace(mission, zones=zones, period_s=period))
            assert before is None or now <= before
            before = now
        assert before is not None
        assert before <= 1 + (mission is harbour)


def test_the_examples_and_what_is_said_about_them() -> None:
    robots, reason = proof(read_mission(EXAMPLES / "harbour.yaml").mission)
    # the areas alone (one window for all zones) prove three
    assert robots == 4
    assert reason == "756.5 m2/s are asked for, a robot sweeps 249 at most"
    assert proof(read_mission(EXAMPLES / "building.yaml").mission) == (1, "something is asked, and it can be seen")


def test_nothing_that_can_be_seen_takes_nobody() -> None:
    # a zone in a shed that nobody can look into: excluded, so that nothing is left
    shed = Obstacle(shape=MultiPolygon([box(4, 4, 6, 6)]))
    hidden = Zone(name="shed", shape=box(4.5, 4.5, 5.5, 5.5), period_s=5)
    yard = Mission(name="yard", area=box(0, 0, 10, 10), zones=(hidden,), obstacles=(shed,), fleet=fleet(2, 1))
    assert bound(replace(yard, period_s=1000)) == 1


def test_areas_and_periods_alone_prove_no_more_than_all_proofs() -> None:
    # a long corridor: far ends take robots that its area does not
    corridor = Mission(name="corridor", area=box(0, 0, 200, 2), period_s=30, fleet=fleet(2, 2))
    problem = set_up_problem(corridor)
    quick, best = prove_by_area(problem), prove_bound(problem)
    assert 1 <= quick.robots <= best.robots
    open_field = set_up_problem(replace(corridor, area=box(0, 0, 60, 60), period_s=60))
    assert prove_by_area(open_field).robots == prove_bound(open_field).robots > 1


def test_what_surely_is_seen_is_worked_out_once_for_all_proofs_of_a_problem(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[float] = []

    def areas(*given: Any) -> list[float]:
        asked.append(given[0][0].shape.area)
        return surely_seeable_m2(*given)

    monkeypatch.setattr("rota.planners.patrol.bounds.best_bound.surely_seeable_m2", areas)
    yard, other = set_up_problem(YARD), set_up_problem(replace(YARD, obstacles=()))
    assert prove_by_area(yard).robots == prove_bound(yard).robots
    assert asked == [584.0]
    assert prove_by_area(other).robots >= 1
    assert asked == [584.0, 600.0]
