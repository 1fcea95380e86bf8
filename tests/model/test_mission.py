"""What a mission refuses whatever it is made from."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, Point, box

from rota.errors import MissionError
from rota.files.mission_file import read_mission
from rota.model.mission import (
    DiscSensor,
    Fleet,
    Mission,
    MovingObstacle,
    Obstacle,
    Robot,
    SquareSensor,
    Zone,
    start_faults,
)
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planning.planner import planner_named


def with_zones(*names: str) -> Mission:
    zones = tuple(Zone(name=name, shape=box(0, 0, 5, 5), period_s=9) for name in names)
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1))
    return Mission(name="yard", area=box(0, 0, 10, 10), zones=zones, period_s=40, fleet=fleet)


def test_no_zone_takes_the_name_of_the_ground_outside_zones() -> None:
    with pytest.raises(
        MissionError, match=r"^zone\.name: 'area' is not allowed; it stands for the ground outside zones"
    ):
        with_zones("gate", "area")
    assert [zone.name for zone in with_zones("Area", "the area").zones] == ["Area", "the area"]


def test_lists_serve_where_tuples_do() -> None:
    robot, zone = (
        Robot(name="a", speed_m_s=1, sensor=DiscSensor(radius_m=2)),
        Zone(name="z", shape=box(0, 0, 1, 1), period_s=5),
    )
    made = [
        Mission(
            name="m", area=box(0, 0, 9, 9), period_s=9, zones=kind([zone]), obstacles=kind([]),
            fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=2), robots=kind([robot])),
        )
        for kind in (list, tuple)
    ]  # fmt: skip
    assert made[0] == made[1]
    assert hash(made[0]) == hash(made[1])


@pytest.mark.parametrize("kind", [int, np.int64, np.float32])
def test_numbers_are_floats_whatever_they_were_given_as(kind) -> None:
    # equal missions share what is cached by them, and a report that says 60 is not the same text as one that says 60.0
    made = Mission(
        name="m", area=box(0, 0, 9, 9), period_s=kind(60), importance=kind(2),
        zones=[Zone(name="z", shape=box(0, 0, 1, 1), period_s=kind(5))],
        fleet=Fleet(speed_m_s=kind(1), sensor=DiscSensor(radius_m=kind(2)), body_radius_m=kind(0)),
    )  # fmt: skip
    told = made.period_s, made.importance, made.zones[0].period_s, made.fleet.speed_m_s, made.fleet.body_radius_m
    assert repr(told) == "(60.0, 2.0, 5.0, 1.0, 0.0)"
    assert repr(made.fleet.sensor.radius_m) == "2.0"


def test_names_of_zones_are_unique() -> None:
    with pytest.raises(MissionError, match="zones: 'gate' is not allowed; names must be unique"):
        with_zones("gate", "gate")


def test_a_name_is_text_that_a_file_can_hold() -> None:
    # half a character, which JSON's escapes can make
    with pytest.raises(MissionError, match=r"zone\.name: .*lone surrogates"):
        with_zones("gate", "\ud800")
    with pytest.raises(MissionError, match=r"robot\.name: .*lone surrogates"):
        Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1)).equal_robot("a\udfff")
    assert with_zones("\U0001f6a2").zones[0].name == "\U0001f6a2"


@pytest.mark.parametrize("mark", ["\n", "\r", "\t", "\x1b", "\x00", "\x7f", "\x9b", "\u2028", "\u202e", "\u2066"])
def test_names_cannot_write_to_the_terminal(mark: str) -> None:
    for make in (
        lambda name: Robot(name=name, speed_m_s=1, sensor=DiscSensor(radius_m=1)),
        lambda name: Zone(name=name, shape=box(0, 0, 1, 1), period_s=1),
    ):
        with pytest.raises(MissionError) as caught:
            make(f"gate{mark}verdict: met")
        assert "must be one line of text" in str(caught.value)
        assert mark not in str(caught.value)
    Zone(name="Kai 3 – ميناء 港 👩‍🚀", shape=box(0, 0, 1, 1), period_s=1)  # any writing may be used


def test_lengths_and_times_that_float64_tells_not_apart_are_refused() -> None:
    for far in (box(0, 0, 1e40, 1), box(0, -1.1e8, 1, 1)):
        with pytest.raises(MissionError, match=r"zone gate: .* coordinates must be within 1e\+08 m of 0"):
            Zone(name="gate", shape=far, period_s=9)
    with pytest.raises(MissionError, match=r"sensor\.radius_m: 1e\+155 .* at most 100000000"):
        DiscSensor(radius_m=1e155)
    with pytest.raises(MissionError, match=r"period_s: 1\d+ .* at most 1e\+10"):
        Zone(name="gate", shape=box(0, 0, 1, 1), period_s=1e11)


@pytest.mark.parametrize(
    ("side_m", "told"),
    [
        (0.0, "0 is not allowed; it must be greater than 0"),
        (-1.0, "-1 is not allowed; it must be greater than 0"),
        (math.nan, r"\.nan is not allowed; a finite number is needed"),
        (math.inf, r"\.inf is not allowed; a finite number is needed"),
        # the smallest number above 0: half of it is 0
        (5e-324, "5e-324 is not allowed; half of it must be greater than 0, too"),
    ],
)
def test_a_square_sensor_sees_some_way_in_every_direction(side_m: float, told: str) -> None:
    with pytest.raises(MissionError, match=rf"^sensor\.side_m: {told}$"):
        SquareSensor(side_m=side_m)
    assert SquareSensor(side_m=1e-323).reach_m > 0


def test_a_shape_on_a_grid_is_taken_off_it() -> None:
    coarse = shapely.set_precision(box(0, 0, 10, 10), 0.5)
    mission = Mission(name="m", area=coarse, period_s=10, fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1)))
    assert shapely.get_precision(mission.area) == 0
    assert mission.area.equals(box(0, 0, 10, 10))
    assert mission.area.intersection(box(0.1, 0.1, 20, 20)).bounds == (0.1, 0.1, 10, 10)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"zones": ()}, "^period_s: is missing; give seconds for the area, or a zone with a period_s"),
        ({"period_s": 9.0}, "^period_s: bouncing robots monitor zones, not the area"),
        (
            {"planning": BounceSettings(cell_m=1, task="cover")},
            r"^fleet\.robots: a number of robots, .* to cover an area",
        ),
        (
            {"zones": (Zone(name="gate", shape=box(0, 0, 1, 1), period_s=5),)},
            r"^zones\[0\]\.demand: every_point is not allowed",
        ),
        (
            {"planning": BounceSettings(cell_m=1, bouncing_angles_deg=(90, 45))},
            "2 angles .* one for all robots is needed",
        ),
    ],
)
def test_what_bouncing_robots_cannot_do_is_refused(changes, words):
    good = {
        "name": "hall",
        "area": box(0, 0, 4, 4),
        "zones": (Zone(name="gate", shape=box(0, 0, 1, 1), period_s=5, demand="visit"),),
        "fleet": Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1)),
        "planning": BounceSettings(cell_m=1),
    }
    assert BounceSettings.of(Mission(**good)).cell_m == 1
    with pytest.raises(MissionError, match=words):
        Mission(**{**good, **changes})


SENSORS = {"disc": DiscSensor(radius_m=1), "square": SquareSensor(side_m=2)}
MOVING = {"radius_m": 1, "times_s": [0, 1], "positions_m": [[1, 1], [2, 2]]}


@pytest.mark.parametrize(
    ("planner", "settings", "fleet", "more", "told"),
    [
        ("patrol", {}, {}, {"moving_obstacles": [MOVING]}, "moving_obstacles: the patrol planner has no use for"),
        ("patrol", {"range_margin_m": 1.0}, {}, {}, r"patrol\.range_margin_m: 1 is not allowed; it must be less"),
        ("patrol", {"period_margin": 1.0}, {}, {}, r"patrol\.period_margin: 1 is not allowed; it must be less than 1"),
        ("patrol", {"method": "sun2019"}, {"shape": "square"}, {}, r"fleet\.sensor\.shape: square is not allowed"),
        ("patrol", {}, {}, {"period_s": None}, "period_s: is missing; give seconds for the area, or a zone"),
        ("swarm", {}, {"robots": "fewest"}, {}, r"fleet\.robots: fewest is not allowed: a swarm needs"),
        ("swarm", {}, {"robots": 2, "turn_rate_rad_s": 1}, {}, r"fleet\.turn_rate_rad_s: robots of a swarm turn"),
        ("swarm", {"controller": "voronoi", "altitudes_m": [1.0, 2.0]}, {"robots": 2}, {"period_s": None},
         r"swarm\.controller: voronoi is not allowed; robots with altitudes_m are moved by settle or reciprocal only"),
        ("bounce", {"cell_m": 1.0}, {}, {}, "period_s: bouncing robots monitor zones, not the area: remove it"),
        ("bounce", {"cell_m": 1.0, "clock_drift": 0.2}, {}, {}, r"bounce\.clock_drift: 0\.2 is not allowed; it must"),
    ],
)  # fmt: skip
def test_a_mission_is_refused_in_the_same_words_in_python_and_in_a_file(planner, settings, fleet, more, told, tmp_path):
    shape, robots, turns = fleet.get("shape", "disc"), fleet.get("robots", "fewest"), fleet.get("turn_rate_rad_s")
    sensor = {"shape": shape, "radius_m" if shape == "disc" else "side_m": 1 if shape == "disc" else 2}
    document = {
        "rota": 1, "name": "m", "area": [[0, 0], [9, 0], [9, 9], [0, 9]], "period_s": 60, "planner": planner, **more,
        planner: settings, "fleet": {"speed_m_s": 1, "sensor": sensor, "robots": robots, "turn_rate_rad_s": turns},
    }  # fmt: skip
    path = tmp_path / "m.json"
    path.write_text(json.dumps(document))
    with pytest.raises(MissionError) as read:
        read_mission(path)
    by_name = Robot(name="a", speed_m_s=1, sensor=SENSORS[shape], turn_rate_rad_s=turns)
    team = None if robots == "fewest" else (by_name, replace(by_name, name="b"))
    moving = [MovingObstacle(**MOVING)] if "moving_obstacles" in more else []
    with pytest.raises(MissionError) as made:
        Mission(
            name="m", area=box(0, 0, 9, 9), period_s=document["period_s"], moving_obstacles=tuple(moving),
            fleet=Fleet(speed_m_s=1, sensor=SENSORS[shape], robots=team, turn_rate_rad_s=turns),
            planning=planner_named(planner).settings(**settings),
        )  # fmt: skip
    assert re.match(told, made.value.faults[0])
    assert made.value.faults[0] in [fault.split(": ", 1)[1] for fault in read.value.faults]


def crowd(points: list[tuple[float, float]], *bodies_m: float) -> Fleet:
    sensor = DiscSensor(radius_m=5)
    robots = [
        Robot(name=f"r{k}", speed_m_s=1, sensor=sensor, body_radius_m=bodies_m[k % len(bodies_m)], start=point)
        for k, point in enumerate(points)
    ]
    return Fleet(speed_m_s=1, sensor=sensor, robots=tuple(robots))


@pytest.mark.parametrize("seed", range(4))
def test_starts_at_fault_are_those_that_comparing_all_pairs_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = [tuple(at) for at in rng.uniform(-1, 41, (60, 2)).round(0).tolist()]
    bodies_m = (0.0, 0.4, 2.0)
    blocks = (Obstacle(shape=MultiPolygon([box(10, 10, 14, 30)])), Obstacle(shape=MultiPolygon([box(20, 0, 21, 9)])))
    area = MultiPolygon([box(0, 0, 40, 40)])
    found = {field for field, _ in start_faults(area, [block.shape for block in blocks], crowd(points, *bodies_m))}
    wanted = set()
    for i, point in enumerate(points):
        body_m, at = bodies_m[i % 3], Point(point)
        alone = area.covers(at) and area.boundary.distance(at) >= body_m - 1e-6
        alone &= all(not b.shape.contains(at) and b.shape.distance(at) >= body_m - 1e-6 for b in blocks)
        near = any(math.dist(point, points[j]) < max(body_m + bodies_m[j % 3] - 1e-6, 1e-6) for j in range(i))
        wanted |= set() if alone and not near else {f"fleet.robots[{i}].start"}
    assert found == wanted
    assert 10 < len(found) < 60


def test_a_crowd_in_one_place_is_told_by_its_first_hundred() -> None:
    found = start_faults(MultiPolygon([box(0, 0, 10, 10)]), (), crowd([(5.0, 5.0)] * 3000, 0.1))
    assert len(found) == 100
    where, message = found[0]
    assert where == "fleet.robots[1].start"
    assert message == "[5, 5] is 0 m from fleet.robots[0].start; bodies need 0.2 m, and no two may be equal"
