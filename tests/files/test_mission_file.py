import json
import math
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from benchmarks.missions import example_missions
from pyproj import Geod
from shapely import Point, Polygon, box, unary_union

from rota.errors import MissionError
from rota.files.example_mission import example_mission_text
from rota.files.geodesy import Projection
from rota.files.mission_file import mission_schema, read_mission
from rota.files.yaml_text import parse_text
from rota.model.mission import DiscSensor, Fleet, GeoPoint, Robot, SquareSensor
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planners.patrol.planner_settings import PatrolSettings

ROOT = Path(__file__).parent.parent.parent
EXAMPLES = example_missions()
SHARED = ROOT.parent / "shared" / "data"

BASE = """\
rota: 1
name: yard
area: [[0, 0], [60, 0], [60, 40], [0, 40]]
period_s: 60
fleet: {speed_m_s: 4, sensor: {shape: disc, radius_m: 5}}
"""


def read(tmp_path, text, **options):
    path = tmp_path / "mission.yaml"
    path.write_text(text, encoding="utf-8")
    return read_mission(path, **options)


def write_geojson(path, *features):
    entries = [
        {"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}}
        for properties, ring in features
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": entries}))


def test_defaults_are_those_of_the_format(tmp_path):
    mission, warnings = read(tmp_path, BASE)
    assert warnings == ()
    assert mission.fleet.robots is None
    assert (mission.fleet.body_radius_m, mission.fleet.turn_rate_rad_s, mission.fleet.altitude_m) == (0, None, 30)
    assert (mission.origin, mission.unseeable, mission.zones, mission.obstacles) == (None, "exclude", (), ())
    assert mission.planning == PatrolSettings(effort="normal", method="tours")


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_read_without_a_warning_and_fit_the_published_schema(path):
    assert read_mission(path).warnings == ()
    value = parse_text(path.read_text(), path.name, "a mission file").value
    jsonschema.Draft202012Validator(mission_schema()).validate(value)


def test_the_new_mission_reads_without_a_warning(tmp_path):
    mission, warnings = read(tmp_path, example_mission_text())
    assert warnings == ()
    assert [zone.name for zone in mission.zones] == ["gate", "tank"]


def test_sun2019_fig16_has_the_sizes_of_the_reconstruction():
    mission = read_mission(ROOT / "examples" / "sun2019-fig16.yaml").mission
    assert mission.area.area == pytest.approx(2.5 * 72**2 * math.sin(math.radians(72)), rel=1e-12)
    hexagon, circle = (zone.shape for zone in mission.zones)
    assert hexagon.area == pytest.approx(1.5 * math.sqrt(3) * 16**2, rel=1e-12)
    assert circle.area == pytest.approx(64 * 12**2 * math.tan(math.pi / 64), rel=1e-9)


def test_schema_and_reader_agree_on_single_faults():
    validator = jsonschema.Draft202012Validator(mission_schema())
    good = parse_text(BASE, "good", "a mission file").value
    validator.validate(good)
    ring = good["area"]
    for change in (
        {"period_s": 0},
        {"period_s": "60"},
        {"colour": "red"},
        {"rota": 2},
        {"planner": "crawl"},
        {"area": {"ring": ring, "geojson": "a.geojson"}},
        {"area": {"map": "a.yaml"}},
        {"zones": [{"name": "gate", "ring": ring}]},
        {"fleet": {"speed_m_s": 1, "sensor": {"shape": "disc", "side_m": 1}}},
        {"fleet": {"speed_m_s": 1, "robots": 0, "sensor": {"shape": "disc", "radius_m": 1}}},
    ):
        assert not validator.is_valid({**good, **change}), change


def test_json_and_yaml_give_the_same_mission(tmp_path):
    path = ROOT / "examples" / "sun2019-fig13.yaml"
    value = parse_text(path.read_text(), "m", "a mission file").value
    for indent in (None, "\t"):
        (tmp_path / "m.json").write_text(json.dumps(value, indent=indent))
        assert read_mission(tmp_path / "m.json") == read_mission(path)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0x1F", 31),
        ("0o17", 15),
        ("-12", -12),
        ("+.5e1", 5.0),
        ("1e3", 1000.0),
        ("yes", "yes"),
        ("2024-01-01", "2024-01-01"),
        ("1_000", "1_000"),
        ("~", None),
        ("True", True),
        ("'20'", "20"),
        ("!!str 20", "20"),
        ("-.inf", -math.inf),
        ("9" * 400, math.inf),
    ],
)
def test_scalars_follow_the_core_schema_of_yaml_1_2(text, value):
    assert parse_text(f"a: {text}", "m.yaml", "a file").value == {"a": value}


def test_json_escapes_beyond_the_first_plane(tmp_path):
    assert parse_text('{"a": "\\ud83d\\ude81"}', "m.json", "a file").value == {"a": "\U0001f681"}


def test_rings_may_be_closed_and_repeat_points(tmp_path):
    closed = BASE.replace("[0, 40]]", "[0, 40], [0, 40], [0, 0]]")
    assert read(tmp_path, closed).mission == read(tmp_path, BASE).mission


def test_holes_circles_and_what_obstacles_block(tmp_path):
    text = BASE.replace(
        "area: [[0, 0], [60, 0], [60, 40], [0, 40]]",
        "area: {outer: [[0, 0], [60, 0], [60, 40], [0, 40]], holes: [[[5, 5], [10, 5], [10, 10], [5, 10]]]}\n"
        "obstacles:\n"
        "  - {circle: {centre: [30, 20], radius_m: 3}, blocks: motion}\n"
        "  - {ring: {outer: [[40, 10], [50, 10], [50, 20], [40, 20]], holes: [[[44, 14], [46, 14], [46, 16]]]}}",
    )
    mission = read(tmp_path, text).mission
    assert mission.area.area == 2400 - 25
    circle, ring = mission.obstacles
    assert (circle.blocks, ring.blocks) == ("motion", "both")
    assert (circle.asks, ring.asks) == ("all", "all")
    silent = read(tmp_path, text.replace("blocks: motion", "blocks: motion, asks: nothing")).mission.obstacles[0]
    assert (silent.blocks, silent.asks, silent.shape) == ("motion", "nothing", circle.shape)
    assert ring.shape.area == 100 - 2
    assert circle.shape.contains(Point(30, 20).buffer(3, quad_segs=500))
    corners = np.asarray(circle.shape.geoms[0].exterior.coords)[:-1]
    assert len(corners) == 64
    assert np.hypot(*(corners - [30, 20]).T).max() == pytest.approx(3 / math.cos(math.pi / 64))


def test_robots_as_a_number_and_as_a_list(tmp_path):
    mission = read(tmp_path, BASE.replace("fleet: {", "fleet: {robots: 3, ")).mission
    assert mission.fleet.robots is not None
    assert [robot.name for robot in mission.fleet.robots] == ["robot-1", "robot-2", "robot-3"]
    assert mission.fleet.robots[1] == mission.fleet.equal_robot("robot-2")
    robots = "[{name: a}, {name: b, speed_m_s: 2, sensor: {shape: square, side_m: 8}, turn_rate_rad_s: null}]"
    text = BASE.replace("fleet: {", f"fleet: {{turn_rate_rad_s: 1.5, body_radius_m: 0.3, robots: {robots}, ")
    fleet = Fleet(
        speed_m_s=4,
        sensor=DiscSensor(radius_m=5),
        body_radius_m=0.3,
        turn_rate_rad_s=1.5,
        robots=[Robot(name="a"), Robot(name="b", speed_m_s=2, sensor=SquareSensor(side_m=8), turn_rate_rad_s=None)],
    )
    assert read(tmp_path, text).mission.fleet == fleet


def test_zones_sticking_out_are_cut_with_a_warning(tmp_path):
    text = BASE + "zones:\n  - {name: gate, period_s: 20, ring: [[50, 10], [70, 10], [70, 20], [50, 20]]}\n"
    mission, warnings = read(tmp_path, text)
    assert mission.zones[0].shape.area == 100
    assert warnings == (
        f"{tmp_path / 'mission.yaml'}:7:5: zones[0]: zone 'gate' sticks out of the area: "
        "100 m2 (50 %) of it are cut off",
    )


def test_sensors_that_reach_no_farther_than_their_bodies_are_warned_of(tmp_path):
    listed = "[{name: a, body_radius_m: 6}, {name: b}, {name: c, body_radius_m: 5}]"
    _, warnings = read(tmp_path, BASE.replace("fleet: {", f"fleet: {{robots: {listed}, "))
    assert warnings == (
        f"{tmp_path / 'mission.yaml'}:5:8: fleet: the sensor of robot a reaches 5 m, no farther than its body of 6 m,"
        " and so do those of 1 more: it sees no ground but what it stands on",
    )


def test_a_zone_along_the_border_is_no_reason_to_warn(tmp_path):
    ring = "[[0, 0], [20, 13.333333333333334], [20, 0]]"
    text = BASE.replace("[60, 0], [60, 40], [0, 40]", "[60, 0], [60, 40]")
    mission, warnings = read(tmp_path, text + f"zones:\n  - {{name: gate, period_s: 20, ring: {ring}}}\n")
    assert warnings == ()
    assert mission.zones[0].shape.area == pytest.approx(400 / 3)


def test_an_obstacle_outside_the_area_is_told(tmp_path):
    _, warnings = read(tmp_path, BASE + "obstacles: [[[80, 10], [90, 10], [90, 20]]]\n")
    assert len(warnings) == 1
    assert warnings[0].endswith(":6:13: obstacles[0]: lies wholly outside the area")


def test_overrides_replace_values_and_are_named_when_at_fault(tmp_path):
    mission = read(tmp_path, BASE, overrides={"patrol.effort": "quick", "fleet.robots": 2, "period_s": 30}).mission
    assert mission.fleet.robots is not None
    assert (PatrolSettings.of(mission).effort, len(mission.fleet.robots), mission.period_s) == ("quick", 2, 30)
    with pytest.raises(MissionError) as caught:
        read(tmp_path, BASE, overrides={"patrol.effort": "wild", "fleet.robot": 2})
    assert sorted(caught.value.faults) == [
        "override: fleet.robot: unknown key; did you mean 'robots'?",
        'override: patrol.effort: "wild" is not allowed; quick, normal or high is needed',
    ]


def test_the_smallest_sensor_named_in_the_refusal_is_accepted(tmp_path):
    # 2400 m2 in 50 million squares of a quarter of the radius
    least_m = 4 * math.sqrt(2400 / 50e6)
    with pytest.raises(MissionError, match=r"radius_m of at least 0\.0278"):
        read(tmp_path, BASE.replace("radius_m: 5", f"radius_m: {least_m * 0.999}"))
    assert 0.0277 < least_m < 0.0278
    read(tmp_path, BASE.replace("radius_m: 5", "radius_m: 0.0278"))


def test_what_needs_no_seeing_needs_no_cells(tmp_path):
    zone = "zones: [{name: idle, period_s: null, ring: [[0, 0], [59, 0], [59, 40], [0, 40]]}]\n"
    assert read(tmp_path, BASE.replace("radius_m: 5", "radius_m: 0.004") + zone).mission.zones[0].period_s is None


# ---- longitude and latitude

GEOD = Geod(ellps="WGS84")
PARCEL = [[11.5, 48.1], [11.503, 48.1], [11.503, 48.102], [11.5, 48.102]]


def test_wgs84_rings_keep_their_geodesic_lengths(tmp_path):
    text = BASE.replace("name: yard", "name: yard\ncoordinates: wgs84").replace(
        "[[0, 0], [60, 0], [60, 40], [0, 40]]", json.dumps(PARCEL)
    )
    text += "zones: [{name: tank, period_s: 9, circle: {centre: [11.5015, 48.101], radius_m: 20}}]\n"
    mission = read(tmp_path, text).mission
    assert mission.origin == GeoPoint(lat=48.101, lon=11.5015)
    corners = np.asarray(mission.area.geoms[0].exterior.coords)
    lon, lat = np.array([*PARCEL, PARCEL[0]]).T
    _, _, geodesic_m = GEOD.inv(lon[:-1], lat[:-1], lon[1:], lat[1:])
    assert np.hypot(*np.diff(corners, axis=0).T) == pytest.approx(geodesic_m, rel=1e-8)
    assert mission.zones[0].shape.centroid.distance(Point(0, 0)) < 1e-6


def test_geojson_in_a_mission_in_metres_is_placed_by_the_origin(tmp_path):
    write_geojson(tmp_path / "p.geojson", ({"name": "field"}, [[*point, 412.0] for point in [*PARCEL, PARCEL[0]]]))
    origin = GeoPoint(lat=48.0995, lon=11.4995)
    area = "{geojson: p.geojson, feature: field}"
    text = BASE.replace("[[0, 0], [60, 0], [60, 40], [0, 40]]", area)
    placed = read(tmp_path, text + f"origin: {{lat: {origin.lat}, lon: {origin.lon}}}\n").mission
    assert placed.origin == origin
    x, y = Projection(origin).to_metres(*np.array(PARCEL).T)
    expected = Polygon(np.column_stack([x, y])).normalize()
    assert placed.area.geoms[0].normalize().equals_exact(expected, 1e-6)


def test_a_geojson_area_gives_a_mission_in_metres_its_origin(tmp_path):
    write_geojson(tmp_path / "p.geojson", ({}, [*PARCEL, PARCEL[0]]))
    text = BASE.replace("[[0, 0], [60, 0], [60, 40], [0, 40]]", "{geojson: p.geojson}")
    mission = read(tmp_path, text + "obstacles: [[[-10, -10], [10, -10], [10, 10], [-10, 10]]]\n").mission
    assert mission.origin == GeoPoint(lat=48.101, lon=11.5015)
    assert mission.obstacles[0].shape.bounds == (-10, -10, 10, 10)
    assert mission.area.contains(mission.obstacles[0].shape)


def test_one_zone_per_feature(tmp_path):
    write_geojson(tmp_path / "p.geojson", ({}, [*PARCEL, PARCEL[0]]))

    def square(lon, lat):
        return [[lon, lat], [lon + 5e-4, lat], [lon + 5e-4, lat + 5e-4], [lon, lat + 5e-4], [lon, lat]]

    write_geojson(
        tmp_path / "z.geojson",
        ({"name": "gate", "period_s": 20}, square(11.5005, 48.1005)),
        ({"period_s": 30.5, "demand": "visit"}, square(11.5015, 48.1005)),
        ({}, square(11.502, 48.101)),
    )
    text = BASE.replace("[[0, 0], [60, 0], [60, 40], [0, 40]]", "{geojson: p.geojson}")
    mission = read(tmp_path, text + "zones: [{geojson: z.geojson, period_s: 50}]\n").mission
    assert [(zone.name, zone.period_s, zone.demand) for zone in mission.zones] == [
        ("gate", 20, "every_point"),
        ("zone-1", 30.5, "visit"),
        ("zone-2", 50, "every_point"),
    ]
    one = read(tmp_path, text + "zones: [{geojson: z.geojson, feature: gate, name: door}]\n").mission
    assert [(zone.name, zone.period_s) for zone in one.zones] == [("door", 20)]
    write_geojson(tmp_path / "a.geojson", ({"name": "area"}, square(11.5005, 48.1005)))
    with pytest.raises(
        MissionError, match=r":6:19: zones\[0\]\.geojson: 'area' is not allowed; it stands for the ground"
    ):
        read(tmp_path, text + "zones: [{geojson: a.geojson, period_s: 50}]\n")


PARCELS = [(ROOT / "examples" / "parcel.geojson", "field"), (SHARED / "parcel-nl.geojson", "test parcel")]


@pytest.mark.parametrize(("parcel", "name"), [given for given in PARCELS if given[0].exists()])
def test_a_parcel_has_its_geodesic_area(tmp_path, parcel, name):
    text = BASE.replace("[[0, 0], [60, 0], [60, 40], [0, 40]]", f"{{geojson: {parcel}, feature: {name}}}")
    mission = read(tmp_path, text.replace("name: yard", "name: yard\ncoordinates: wgs84")).mission
    ring = json.loads(parcel.read_text())["features"][0]["geometry"]["coordinates"][0]
    lon, lat = np.array(ring).T[:2]
    area_m2, _ = GEOD.polygon_area_perimeter(lon, lat)
    assert mission.area.area == pytest.approx(abs(area_m2), rel=1e-7)


TYPED = """\
rota: 1
name: typed
area:
  text: |
    ..#.
    ....
    #...
  cell_m: 0.5
fleet: {robots: 2, speed_m_s: 0.2, sensor: {shape: disc, radius_m: 1}, body_radius_m: 0.2}
planner: bounce
bounce: {task: cover, bouncing_angles_deg: [135, 90]}
"""


def test_a_typed_map_is_a_rectangle_with_its_first_line_in_the_north(tmp_path):
    mission = read(tmp_path, TYPED).mission
    assert mission.area.bounds == (0, 0, 2, 1.5)
    (walls,) = mission.obstacles
    assert walls.shape.equals(unary_union([box(1, 1, 1.5, 1.5), box(0, 0, 0.5, 0.5)]))
    assert mission.planning == BounceSettings(cell_m=0.5, task="cover", bouncing_angles_deg=(135.0, 90.0))


def test_a_cell_of_its_own_goes_before_the_typed_one(tmp_path):
    mission = read(tmp_path, TYPED.replace("{task", "{cell_m: 0.25, task")).mission
    assert BounceSettings.of(mission).cell_m == 0.25


def test_entrances_and_rally_points_become_places_in_local_metres(tmp_path):
    text = BASE.replace("fleet: {", "fleet: {entrances: [[1, 2], [50.5, 30]], rally_points: [[3, 4.5]], ")
    assert read(tmp_path, text).mission.fleet.entrances == ((1.0, 2.0), (50.5, 30.0))
    assert read(tmp_path, text).mission.fleet.rally_points == ((3.0, 4.5),)
    assert read(tmp_path, BASE).mission.fleet.entrances is None
    assert read(tmp_path, BASE).mission.fleet.rally_points == ()
    degrees = BASE.replace("name: yard", "name: yard\ncoordinates: wgs84").replace(
        "[[0, 0], [60, 0], [60, 40], [0, 40]]", "[[11.5, 48.1], [11.501, 48.1], [11.501, 48.1005], [11.5, 48.1005]]"
    )
    given = "fleet: {entrances: [[11.5002, 48.1001]], rally_points: [[11.5002, 48.1001]], "
    mission = read(tmp_path, degrees.replace("fleet: {", given)).mission
    ((x, y),) = mission.fleet.entrances
    assert mission.fleet.rally_points == ((x, y),)
    west, south = mission.area.bounds[:2]
    east_m, north_m = GEOD.inv(11.5, 48.1001, 11.5002, 48.1001)[2], GEOD.inv(11.5002, 48.1, 11.5002, 48.1001)[2]
    assert (x - west, y - south) == pytest.approx((east_m, north_m), abs=1e-3)
