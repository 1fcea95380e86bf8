"""Missions written as files: they read back equal, whatever their shapes, fleets and settings."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from benchmarks.missions import example_missions
from hypothesis import HealthCheck, assume, given, settings, strategies as st
from shapely import MultiPolygon, Polygon, box

from rota import read_mission, write_mission
from rota.errors import MissionError, RotaError
from rota.model.fields import REQUIRED, Field, fields_of
from rota.model.fleet import Fleet, Robot
from rota.model.mission import DiscSensor, GeoPoint, ImportanceMap, Mission, Obstacle, SquareSensor, StartBox, Zone
from rota.model.motion_limits import MotionLimits
from rota.model.planner_registry import PLANNERS
from rota.planners.patrol.method_table import METHOD_SETTINGS, METHODS
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planning.planner import planner_named

FLEET = "fleet: {speed_m_s: 5, sensor: {shape: disc, radius_m: 4}}\n"
SENSOR = DiscSensor(radius_m=0.1 + 0.2 + 4)
TWO = MultiPolygon([Polygon([(0, 0), (90, 0), (1 / 3 + 90, 90), (0, 90)], [box(10, 10, 20, 20).exterior.coords]),
                    box(100, 0, 110, 10)])  # fmt: skip
SHAPES = [box(30, 30, 35, 40), Polygon(box(30, 30, 60, 60).exterior.coords, [box(40, 40, 45, 45).exterior.coords])]
SHAPES.append(MultiPolygon([box(30, 30, 35, 35), box(0.7 - 0.1 + 40, 30, 45, 33)]))


def read_back(mission: Mission, folder: Path) -> Mission:
    write_mission(mission, folder / "it.yaml")
    return read_mission(folder / "it.yaml").mission


@pytest.mark.parametrize("path", example_missions(), ids=lambda path: path.stem)
def test_examples_read_back_equal(path: Path, tmp_path: Path) -> None:
    mission = read_mission(path).mission
    assert read_back(mission, tmp_path) == mission


def test_several_polygons_are_well_known_text_that_people_can_write_too(tmp_path: Path) -> None:
    mission = Mission(name="m", area=TWO, period_s=60, fleet=Fleet(robots=2, speed_m_s=5, sensor=SENSOR))
    again = read_back(mission, tmp_path)
    text = (tmp_path / "it.yaml").read_text()
    assert "MULTIPOLYGON (((0.0 0.0, 90.0 0.0, 90.33333333333333 90.0," in text
    assert again == mission
    assert again.area.equals_exact(TWO, 0)


@pytest.mark.parametrize(
    ("wkt", "message"),
    [
        ("LINESTRING (0 0, 1 1)", "a POLYGON or a MULTIPOLYGON with corners is needed, not LINESTRING"),
        ("POLYGON EMPTY", "a POLYGON or a MULTIPOLYGON with corners is needed, not POLYGON"),
        ("POLYGON ((0 0, 9 9, 9 0, 0 9, 0 0))", "the rings cross, touch along a line or enclose nothing near"),
        ("POLYGON ((0 0, 1e300 0, 1 1, 0 0))", "reaches beyond 1e+"),
        ("POLYGON ((0 0, 9 0, 5 0, 0 0))", "the rings cross, touch along a line or enclose nothing"),
        ("here", "no well-known text: ParseException"),
    ],
)
def test_text_that_is_no_shape_is_refused_where_it_stands(wkt: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(f'rota: 1\nname: m\narea: {{wkt: "{wkt}"}}\nperiod_s: 60\n{FLEET}')
    with pytest.raises(MissionError) as caught:
        read_mission(tmp_path / "m.yaml")
    assert [fault.partition("m.yaml:")[2][:18] for fault in caught.value.faults] == ["3:13: area.wkt: " + message[:2]]
    assert message in str(caught.value)


def test_text_in_degrees_lies_on_the_globe(tmp_path: Path) -> None:
    head = "rota: 1\nname: m\ncoordinates: wgs84\nperiod_s: 60\n" + FLEET
    ring, text = tmp_path / "ring.yaml", tmp_path / "text.yaml"
    ring.write_text(head + "area: [[13, 54], [13.01, 54], [13.01, 54.01]]\n")
    text.write_text(head + 'area: {wkt: "POLYGON ((13 54 7, 13.01 54 7, 13.01 54.01 7, 13 54 7))"}\n')
    assert read_mission(text).mission.area == read_mission(ring).mission.area
    text.write_text(head + 'area: {wkt: "POLYGON ((1300 54, 1301 54, 1301 55, 1300 54))"}\n')
    with pytest.raises(MissionError, match=r"text\.yaml:6:13: area\.wkt: .*coordinates: metres"):
        read_mission(text)


def test_robots_say_what_is_unlike_their_fleet_and_its_vehicle(tmp_path: Path) -> None:
    motion = MotionLimits(vehicle="arducopter", acceleration_m_s2=2.5, corner_m=0.3)
    fleet = Fleet(
        robots=[
            Robot(name="as the fleet"),
            Robot(name="free", motion=MotionLimits(), speed_m_s=7),
            Robot(name="px4", motion=MotionLimits(vehicle="px4", acceleration_m_s2=1), sensor=SquareSensor(side_m=3)),
            Robot(name="light", motion=MotionLimits(vehicle="arducopter", acceleration_m_s2=3), body_radius_m=0.1),
        ],
        speed_m_s=5, sensor=SENSOR, motion=motion, entrances=[(3, 3)], rally_points=[(4, 4)],
    )  # fmt: skip
    mission = Mission(name="m", area=TWO, period_s=60, fleet=fleet, origin=GeoPoint(lat=1 / 3, lon=10))
    assert read_back(mission, tmp_path) == mission


def test_a_map_of_importance_stands_in_the_file(tmp_path: Path) -> None:
    worth = ImportanceMap(low_m=(1 / 3, 0), step_m=(0.1, 2), values=np.array([[0, 1 / 7], [2, 3]]))
    fleet = Fleet(robots=3, speed_m_s=1, sensor=SENSOR, body_radius_m=0.2, start=StartBox(low_m=(1, 1), high_m=(9, 9)))
    mission = Mission(name="m", area=TWO, importance=worth, fleet=fleet, planning=SwarmSettings())
    assert read_back(mission, tmp_path) == mission
    text = (tmp_path / "it.yaml").read_text()
    for old, new, message in [
        ("values: [[0.0, ", "values: [[", "importance.values: rows of different lengths"),
        ("  step_m: [0.1, 2.0]\n", "", "importance.step_m: is missing; it goes with low_m"),
        ("  low_m", "  map: a.png\n  low_m", "importance: give exactly one of map and values"),
    ]:
        assert old in text
        (tmp_path / "it.yaml").write_text(text.replace(old, new))
        with pytest.raises(MissionError, match=message.replace("[", r"\[")):
            read_mission(tmp_path / "it.yaml")


def test_what_no_mission_file_can_say_is_refused_and_nothing_is_written(tmp_path: Path) -> None:
    fleet = Fleet(robots=1, speed_m_s=1, sensor=SENSOR)
    sticking_out = Zone(name="z", shape=box(-5, 0, 5, 5), period_s=9)
    with pytest.raises(MissionError, match="zones: a mission file cannot say this"):
        write_mission(Mission(name="m", area=TWO, zones=(sticking_out,), fleet=fleet), tmp_path / "m.yaml")
    with pytest.raises(MissionError, match="period_s: 1e-07 is not allowed"):
        write_mission(Mission(name="m", area=TWO, period_s=1e-7, fleet=fleet), tmp_path / "m.yaml")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(RotaError, match="nowhere"):
        write_mission(Mission(name="m", area=TWO, period_s=1, fleet=fleet), tmp_path / "nowhere" / "m.yaml")


# ---------------------------------------------------------------- any mission


def values_of(item: Field) -> st.SearchStrategy[Any]:
    """Values that a field of settings takes in mission files."""
    if item.kind == "option":
        return st.sampled_from(item.options)
    if item.kind == "truth":
        return st.booleans()
    if item.kind in ("number", "whole"):
        bounds = item.bounds(in_mission_file=True)
        low, high = bounds.get("ge", bounds.get("gt", -1e3)), bounds.get("le", bounds.get("lt", 1e3))
        if item.kind == "whole":
            return st.integers(int(low) + ("gt" in bounds), min(int(high), 10**6))
        return st.floats(low, high, exclude_min="gt" in bounds and "ge" not in bounds, exclude_max="lt" in bounds)
    if item.item is not None:
        least, most = item.count or (1, 3)
        return st.lists(values_of(item.item), min_size=least, max_size=min(most or 3, 3)).map(tuple)
    return st.nothing()


@st.composite
def blocks(draw: Any, kind: type[Any], **fixed: Any) -> Any:
    """Settings of a type: some fields at their defaults, the others drawn, and none that others make useless."""
    told = dict(fixed)
    for item in fields_of(kind):
        if item.name in fixed or item.name in METHOD_SETTINGS:
            continue
        drawn = blocks(item.block) if item.kind == "block" else values_of(item)
        if item.default is REQUIRED or draw(st.booleans()):
            told[item.name] = None if item.optional and draw(st.booleans()) else draw(drawn)
    for where, _ in [*kind.useless_values(told)]:
        told.pop(where[0], None)
    try:
        return kind(**told)
    except MissionError:
        assume(False)


@st.composite
def plannings(draw: Any) -> Any:
    """The settings of any planner, of patrol by any method with settings of its own."""
    planner = draw(st.sampled_from(sorted(PLANNERS)))
    kind = planner_named(planner).settings
    if planner != "patrol":
        return draw(blocks(kind))
    method = draw(st.sampled_from(sorted(METHODS)))
    own = kind.method_blocks().get(method)
    return draw(blocks(kind, method=method, **({} if own is None else {"method_settings": draw(blocks(own))})))


@st.composite
def missions(draw: Any) -> Mission:
    """Missions of any planner with shapes of one part and of several."""
    planning = draw(plannings())
    robots = draw(st.integers(1, 4)) if planning.planner != "patrol" else draw(st.sampled_from(["fewest", 3]))
    fleet = Fleet(
        robots=robots,
        speed_m_s=draw(st.floats(1e-3, 1e3)),
        sensor=draw(st.sampled_from([SENSOR, SquareSensor(side_m=7.7)])),
        body_radius_m=draw(st.sampled_from([0, 0.25])),
        altitude_m=draw(st.sampled_from([30.0, 12.5])),
    )
    periods = st.none() | st.floats(1e-3, 1e6)
    zones = [
        Zone(name=f"z{k}", shape=shape, period_s=draw(periods), demand=draw(st.sampled_from(["every_point", "visit"])))
        for k, shape in enumerate(draw(st.lists(st.sampled_from(SHAPES), max_size=2)))
    ]
    obstacle = st.builds(
        Obstacle, shape=st.sampled_from([shapely.affinity.translate(shape, 30, 30) for shape in SHAPES[:2]]),
        blocks=st.sampled_from(["both", "motion", "sight"]), asks=st.sampled_from(["all", "nothing"]),
    )  # fmt: skip
    try:
        return Mission(
            name=draw(st.sampled_from(["m", "null", "a: b", "Zoë #1"])), area=TWO, period_s=draw(periods),
            zones=tuple(zones), obstacles=tuple(draw(st.lists(obstacle, max_size=2))), fleet=fleet, planning=planning,
            holds_within_s=draw(st.none() | st.floats(0, 1e4)),
            origin=draw(st.none() | st.just(GeoPoint(lat=5, lon=6))),
        )  # fmt: skip
    except MissionError:
        assume(False)
        raise


@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
@given(mission=missions())
def test_any_mission_reads_back_equal(mission: Mission) -> None:
    with tempfile.TemporaryDirectory() as folder:
        assert read_back(mission, Path(folder)) == mission
