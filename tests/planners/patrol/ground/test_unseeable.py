"""How much nobody can see, against closed forms and against a look from everywhere to everywhere."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from pyproj import Geod
from shapely import MultiPolygon, Polygon, box
from tests.files.test_occupancy_map import write_map

from rota import NoPlanFound, check_plan, make_plan
from rota.files.mission_file import read_mission
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, SquareSensor, Zone
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.left_out import sentence_of_what_is_left_out

DISC, SQUARE = DiscSensor(radius_m=5), SquareSensor(side_m=10)
BLOCK = box(30, 10, 80, 55)
HOLED = Polygon(BLOCK.exterior, [box(50, 25, 60, 35).exterior])
INNER_M2 = 40.0 * 35
ZONES = (
    Zone(name="west", shape=box(0, 0, 45, 60), period_s=90),
    Zone(name="east", shape=box(40, 0, 100, 60), period_s=200),
)


def field(*no_fly: Polygon, sensor: Any = DISC, area: Polygon | None = None, **fleet: Any) -> Mission:
    return Mission(
        name="field", area=area or box(0, 0, 100, 60), period_s=120,
        obstacles=tuple(Obstacle(shape=shape, blocks="motion") for shape in no_fly),
        fleet=Fleet(speed_m_s=5, sensor=sensor, **fleet),
    )  # fmt: skip


def told(mission: Mission) -> tuple[float, float]:
    """The m2 and the percent of the refusal."""
    with pytest.raises(NoPlanFound) as caught:
        set_up_problem(mission)
    found = re.match(r"about ([\d.]+) m2 \(([\d.]+)% of what is asked\) cannot be seen", str(caught.value))
    assert found is not None
    return float(found[1]), float(found[2])


@pytest.mark.parametrize(
    ("mission", "m2"),
    [
        (field(BLOCK), INNER_M2),
        (field(BLOCK, sensor=SQUARE), INNER_M2),
        (field(BLOCK, turn_radius_m=2), INNER_M2),
        (field(BLOCK, body_radius_m=0.5), 41 * 36),
        (field(BLOCK, sensor=SQUARE, body_radius_m=1.0), 42 * 37),
        (field(box(10, 10, 40, 50), box(60, 10, 90, 50)), 2 * 20 * 30),
        (field(HOLED), INNER_M2 - (100 + 40 * 5 + math.pi * 25)),
        (field(HOLED, sensor=SQUARE), INNER_M2 - 20 * 20),
        (field(HOLED, entrances=((1, 1),)), INNER_M2),
        (field(BLOCK, area=Polygon(box(0, 0, 100, 60).exterior, [box(40, 20, 70, 45).exterior])), INNER_M2 - 30 * 25),
        (replace(field(BLOCK), zones=ZONES, period_s=None), INNER_M2),
        (replace(field(BLOCK), zones=(Zone(name="idle", shape=box(0, 0, 50, 60), period_s=None),)), 25 * 35),
    ],
)  # fmt: skip
def test_what_is_out_of_range_is_told_as_it_is(mission: Mission, m2: float) -> None:
    asked_m2 = (
        6000.0 - 30 * 25 * bool(mission.area.geoms[0].interiors) - 3000 * any(z.period_s is None for z in mission.zones)
    )
    lost_m2, percent = told(mission)
    assert lost_m2 == pytest.approx(m2, rel=1e-3)
    assert percent == pytest.approx(100 * m2 / asked_m2, abs=0.06)
    assert told(replace(mission, unseeable="refuse")) == (lost_m2, percent)


@pytest.mark.parametrize(
    ("sensor", "body_m"),
    [
        (DiscSensor(radius_m=3), 0.4),
        (SquareSensor(side_m=6), 0.0),
        pytest.param(DiscSensor(radius_m=3), 0.0, marks=pytest.mark.slow),
        pytest.param(SquareSensor(side_m=6), 0.4, marks=pytest.mark.slow),
    ],
)
def test_what_walls_hide_is_counted_as_looks_from_everywhere_count_it(sensor: Any, body_m: float) -> None:
    # a court that nobody may enter, seen through a door in the west and over a low fence in the east
    no_fly, walls = box(6, 3, 14, 9), box(5.8, 2.8, 14, 9.2) - box(6, 3, 14, 9) - box(5.8, 5.5, 6, 7)
    mission = replace(
        field(no_fly, sensor=sensor, area=box(0, 0, 20, 12), body_radius_m=body_m),
        obstacles=(Obstacle(shape=no_fly, blocks="motion"), Obstacle(shape=walls)),
    )
    lost_m2, _ = told(mission)
    assert lost_m2 == pytest.approx(hidden_m2(mission, 0.2, 0.1), rel=0.02)


def hidden_m2(mission: Mission, cell_m: float, apart_m: float) -> float:
    """The cells whose middles no place on the border of where robots stand has in range and in sight."""
    motion = shapely.union_all([o.shape for o in mission.obstacles if o.blocks_motion])
    sight = shapely.union_all([o.shape for o in mission.obstacles if o.blocks_sight])
    body_m, sensor = mission.fleet.body_radius_m, mission.fleet.sensor
    free = mission.area.difference(motion).buffer(-body_m, quad_segs=64) if body_m else mission.area.difference(motion)
    places = shapely.get_coordinates(shapely.segmentize(free.boundary, apart_m))
    x, y = np.meshgrid(np.arange(cell_m / 2, 20, cell_m), np.arange(cell_m / 2, 12, cell_m))
    cells = np.column_stack([x.ravel(), y.ravel()])
    cells = cells[shapely.contains_xy(mission.area.difference(sight).difference(free), *cells.T)]
    solid = sight.buffer(-1e-9)
    shapely.prepare(solid)
    hidden = 0
    for cell in cells:
        away = np.abs(places - cell)
        far = away.max(axis=1) if isinstance(sensor, SquareSensor) else np.hypot(*away.T)
        near = places[far <= (sensor.side_m / 2 if isinstance(sensor, SquareSensor) else sensor.radius_m)]
        # where a few far apart see the cell, the others need not be asked
        hidden += not any(sees_any(cell, some, solid) for some in (near[::16], near))
    return hidden * cell_m**2


def sees_any(cell: Any, places: Any, solid: Any) -> bool:
    """Whether nothing solid lies between a cell and any of (n, 2) places."""
    lines = shapely.linestrings(np.stack([places, np.broadcast_to(cell, places.shape)], axis=1))
    return bool((~shapely.intersects(solid, lines)).any())


def test_nooks_beside_ground_that_is_seen_are_counted_each() -> None:
    """Chambers of 0.6 m inside, round each of which robots see five times as much that they do not stand on."""
    shells = [box(x, y, x + 0.8, y + 0.8) - box(x + 0.1, y + 0.1, x + 0.7, y + 0.7)
              for x in np.arange(4.2, 96, 9.3) for y in np.arange(4.3, 56, 5.7)]  # fmt: skip
    walls = Obstacle(shape=MultiPolygon(shells))
    sentence = sentence_of_what_is_left_out(replace(field(body_radius_m=0.4), obstacles=(walls,)))
    assert sentence is not None
    assert float(sentence.split()[1]) == pytest.approx(0.36 * len(shells), rel=0.02)


@pytest.mark.parametrize(("side_m", "allowed"), [(27.0, True), (27.7, False)])
def test_five_percent_may_be_left_out_and_no_more(side_m: float, allowed: bool) -> None:
    # (27 - 10)^2 / 6000 = 4.8 %, (27.7 - 10)^2 / 6000 = 5.2 %
    mission = field(box(30, 15, 30 + side_m, 15 + side_m))
    if allowed:
        set_up_problem(mission)
    else:
        assert told(mission) == pytest.approx((17.7**2, 5.2), rel=0.01)


def test_the_refusal_says_how_to_leave_the_ground_out_and_that_serves() -> None:
    with pytest.raises(NoPlanFound, match=r"100% of it is under obstacles with blocks: motion.* asks: nothing"):
        make_plan(field(BLOCK))
    silent = replace(field(), obstacles=(Obstacle(shape=BLOCK, blocks="motion", asks="nothing"),))
    report = check_plan(make_plan(silent.with_effort("quick")))
    assert report.verdict == "met"
    assert report.demands[0].area_m2 == pytest.approx(6000 - 50 * 45)
    assert report.demands[0].excluded_area_m2 == 0


def test_a_part_of_a_mission_may_hold_all_that_nobody_sees_of_it() -> None:
    part = field(box(10, 5, 30, 25), area=box(0, 0, 40, 30))
    assert told(part) == (100.0, 8.3)
    assert len(set_up_problem(part, is_whole=False).points) > 0
    core = Zone(name="rest", shape=MultiPolygon([box(0, 0, 40, 30) - box(15, 10, 25, 20)]), period_s=None)
    with pytest.raises(NoPlanFound, match="nothing of what is asked can be seen"):
        set_up_problem(replace(part, zones=(core,)), is_whole=False)


def ring_on_globe(x0: float, y0: float, x1: float, y1: float) -> list[list[float]]:
    """A box in metres about a place on the ellipsoid, by its geodesics."""
    globe, corners = Geod(ellps="WGS84"), [(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)]
    return [list(globe.fwd(12.1, 54.1, math.degrees(math.atan2(x, y)), math.hypot(x, y))[:2]) for x, y in corners]


def test_a_no_fly_zone_of_a_geojson_file_is_counted_the_same(tmp_path: Path) -> None:
    rings = {"site": ring_on_globe(-50, -30, 50, 30), "no-fly": ring_on_globe(-20, -20, 30, 25)}
    features = [
        {"type": "Feature", "properties": {"name": name}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
        for name, ring in rings.items()
    ]
    (tmp_path / "site.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    path = tmp_path / "mission.yaml"
    path.write_text(
        "rota: 1\nname: site\ncoordinates: wgs84\narea: {geojson: site.geojson, feature: site}\nperiod_s: 120\n"
        "obstacles: [{geojson: site.geojson, feature: no-fly, blocks: motion}]\n"
        "fleet: {speed_m_s: 5, sensor: {shape: disc, radius_m: 5}}\n"
    )
    assert told(read_mission(path).mission) == (pytest.approx(INNER_M2, rel=1e-3), 23.3)


def test_a_no_fly_zone_on_a_map_is_counted_the_same(tmp_path: Path) -> None:
    pixels = np.zeros((26, 42), dtype=np.uint8)
    pixels[1:-1, 1:-1] = 254  # 20 m x 12 m
    write_map(tmp_path, pixels)
    path = tmp_path / "mission.yaml"
    path.write_text(
        "rota: 1\nname: room\narea: {map: room.yaml, inside: [1.5, 1.5]}\nperiod_s: 60\n"
        "obstacles: [{ring: [[5, 2], [15, 2], [15, 10], [5, 10]], blocks: motion}]\n"
        "fleet: {speed_m_s: 1, sensor: {shape: square, side_m: 4}, body_radius_m: 0.2}\n"
    )
    # out of range is what is 2 m - 0.2 m within the zone, which bodies keep 0.2 m off; from an entrance a hair more
    assert told(read_mission(path).mission)[0] == pytest.approx((10 - 3.6) * (8 - 3.6), rel=2e-3)
