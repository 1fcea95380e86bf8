"""GeoJSON exports: RFC 7946's shape, and lengths on the globe as pyproj's geodesics measure them."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyproj import Geod
from shapely import LinearRing, MultiPolygon, Polygon, box
from shapely.geometry import shape

from rota.errors import MissionError, RotaError
from rota.files.geodesy import Projection
from rota.files.geojson import geojson_text, plan_to_geojson, write_geojson
from rota.files.mission_file import read_mission
from rota.model.mission import DiscSensor, Fleet, GeoPoint, Mission, Obstacle, Robot, Zone
from rota.model.plan import Plan, Trajectory
from rota.planners.swarm.planner_settings import SwarmSettings

ORIGIN = GeoPoint(lat=53.5413871, lon=9.9836)
GEOD = Geod(ellps="WGS84")


def plan(origin: GeoPoint | None = ORIGIN) -> Plan:
    # rings the wrong way round: outer clockwise, hole counter-clockwise
    holed = Polygon(
        [(-300, -300), (-300, 300), (300, 300), (300, -300)], [[(-50, -50), (50, -50), (50, 50), (-50, 50)]]
    )
    mission = Mission(
        name="harbour",
        area=MultiPolygon([holed, box(400, 0, 500, 100)]),
        obstacles=(Obstacle(shape=box(200, 200, 210, 230), blocks="motion", asks="nothing"),),
        zones=(Zone(name="gate", shape=box(-200, -200, -100, -100), period_s=30, demand="visit"),),
        period_s=120,
        origin=origin,
        fleet=Fleet(speed_m_s=10, sensor=DiscSensor(radius_m=50)),
    )
    looping = Trajectory(
        robot="a",
        times_s=[0, 10, 30, 50, 70, 90],
        positions_m=[[-250, -150], [-150, -150], [50, -150], [50, -250], [-150, -250], [-150, -150]],
        loop_start_s=10,
    )
    staying = Trajectory(robot="b", times_s=[0, 5], positions_m=[[410, 10], [450, 50]], loop_start_s=5)
    return Plan(mission=mission, trajectories=(looping, staying))


def features(document: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    return [feature for feature in document["features"] if feature["properties"]["kind"] == kind]


def test_features_and_their_properties() -> None:
    document = plan_to_geojson(plan())
    assert document["type"] == "FeatureCollection"
    assert "coordinates_in" not in document
    kinds = [feature["properties"]["kind"] for feature in document["features"]]
    assert kinds == ["area", "obstacle", "zone", "approach", "loop", "approach", "loop"]
    assert features(document, "area")[0]["properties"] == {"kind": "area", "name": "harbour", "period_s": 120}
    zone = features(document, "zone")[0]["properties"]
    assert zone == {"kind": "zone", "name": "gate", "period_s": 30, "demand": "visit"}
    obstacle = features(document, "obstacle")[0]["properties"]
    assert obstacle == {"kind": "obstacle", "blocks": "motion", "asks": "nothing"}
    loop, stay = features(document, "loop")
    assert loop["properties"] == {
        "kind": "loop",
        "robot": "a",
        "loop_duration_s": 80.0,
        "loop_length_m": 600.0,
        "times_s": [10.0, 30.0, 50.0, 70.0, 90.0],
    }
    assert stay["geometry"]["type"] == "Point"
    assert features(document, "approach")[0]["properties"]["times_s"] == [0.0, 10.0]


def test_zones_come_back_with_their_importance(tmp_path: Path) -> None:
    zone = Zone(name="gate", shape=box(-200, -200, -100, -100), period_s=None, importance=2.5)
    fleet = Fleet(
        speed_m_s=10,
        sensor=DiscSensor(radius_m=50),
        robots=(Robot(name="a", speed_m_s=10, sensor=DiscSensor(radius_m=50)),),
    )
    mission = dataclasses.replace(plan().mission, zones=(zone,), period_s=None, fleet=fleet, planning=SwarmSettings())
    document = plan_to_geojson(Plan(mission=mission, trajectories=()))
    document["features"] = features(document, "zone")
    (tmp_path / "zones.geojson").write_text(json.dumps(document))
    mission_file = {
        "rota": 1,
        "name": "m",
        "coordinates": "metres",
        "origin": {"lat": ORIGIN.lat, "lon": ORIGIN.lon},
        "area": [[-300, -300], [300, -300], [300, 300], [-300, 300]],
        "zones": [{"geojson": "zones.geojson"}],
        "fleet": {"robots": 1, "speed_m_s": 10, "sensor": {"shape": "disc", "radius_m": 50}},
        "planner": "swarm",
    }
    (tmp_path / "m.json").write_text(json.dumps(mission_file))
    (found,) = read_mission(tmp_path / "m.json").mission.zones
    assert (found.name, found.period_s, found.importance) == ("gate", None, 2.5)
    document["features"][0]["properties"]["importance"] = -1
    (tmp_path / "zones.geojson").write_text(json.dumps(document))
    with pytest.raises(MissionError, match=r"\(gate\) has importance -1; a number from 0 to 1e\+06 is needed"):
        read_mission(tmp_path / "m.json")


def test_loops_close_and_have_their_length_on_the_globe() -> None:
    loop = features(plan_to_geojson(plan()), "loop")[0]
    line = np.array(loop["geometry"]["coordinates"])
    assert loop["geometry"]["type"] == "LineString"
    assert line.shape == (5, 2)
    assert (line[0] == line[-1]).all()
    assert GEOD.line_length(line[:, 0], line[:, 1]) == pytest.approx(600, abs=1e-3)
    # [longitude, latitude], east of the origin and south of it
    assert line[1, 0] > ORIGIN.lon
    assert line[1, 1] < ORIGIN.lat
    _, _, distance = GEOD.inv(ORIGIN.lon, ORIGIN.lat, *line[1])
    assert distance == pytest.approx(np.hypot(50, 150), abs=1e-3)


def test_rings_follow_the_right_hand_rule_and_areas_match() -> None:
    area = features(plan_to_geojson(plan()), "area")[0]["geometry"]
    assert area["type"] == "MultiPolygon"
    outer, hole = area["coordinates"][0]
    assert outer[0] == outer[-1]
    assert LinearRing(outer).is_ccw
    assert not LinearRing(hole).is_ccw
    square_m, _ = GEOD.geometry_area_perimeter(shape(area))
    assert square_m == pytest.approx(600**2 - 100**2 + 100**2, rel=1e-4)


def test_a_polygon_of_one_part_is_a_polygon() -> None:
    assert features(plan_to_geojson(plan()), "zone")[0]["geometry"]["type"] == "Polygon"


def test_heights_are_kept() -> None:
    climbing = Trajectory(robot="a", times_s=[0, 5], positions_m=[[410, 10, 3], [450, 50, 4]], loop_start_s=5)
    robots = (Robot(name="a", speed_m_s=10, sensor=DiscSensor(radius_m=50)),)
    mission = dataclasses.replace(
        plan().mission,
        zones=(),
        period_s=None,
        fleet=dataclasses.replace(plan().mission.fleet, robots=robots),
        planning=SwarmSettings(controller="reciprocal", altitudes_m=(2, 5)),
    )
    document = plan_to_geojson(Plan(mission=mission, trajectories=(climbing,)))
    assert features(document, "loop")[0]["geometry"]["coordinates"][2] == 4.0


def test_degrees_come_back_as_metres() -> None:
    loop = features(plan_to_geojson(plan()), "loop")[0]["geometry"]["coordinates"]
    x, y = Projection(ORIGIN).to_metres(*np.array(loop).T)
    expected = plan().trajectories[0].positions_m[1:]
    np.testing.assert_allclose(np.column_stack([x, y]), expected, atol=2e-4)


def test_without_an_origin_coordinates_are_metres_and_say_so() -> None:
    document = plan_to_geojson(plan(origin=None))
    assert document["coordinates_in"] == "metres"
    assert features(document, "loop")[0]["geometry"]["coordinates"][0] == [-150.0, -150.0]


def test_the_file_is_json_one_feature_per_line(tmp_path: Path) -> None:
    path = tmp_path / "plan.geojson"
    write_geojson(plan(), path)
    text = path.read_text()
    assert json.loads(text) == json.loads(json.dumps(plan_to_geojson(plan())))
    assert sum('"Feature"' in line for line in text.splitlines()) == 7
    assert text == geojson_text(plan())
    with pytest.raises(RotaError, match="is a folder"):
        write_geojson(plan(), tmp_path)


def test_a_plan_without_robots_still_shows_the_mission() -> None:
    empty = dataclasses.replace(plan(), trajectories=())
    assert [f["properties"]["kind"] for f in plan_to_geojson(empty)["features"]] == ["area", "obstacle", "zone"]
