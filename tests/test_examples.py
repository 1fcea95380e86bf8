"""The examples and the real inputs: each reads as what it is meant to be, and some are planned from end to end."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from docs.crowds_picture import PICTURE, picture
from PIL import Image
from pyproj import Geod
from scipy.ndimage import label
from shapely import LineString, Point, box, union_all
from tests.planners.patrol.tours.test_curves import assert_driven_on_arcs

from rota import make_plan
from rota.command.cli import run
from rota.files.mission_file import read_mission
from rota.files.plan_file import read_plan
from rota.model.mission import DiscSensor, Mission
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planners.patrol.bounds.area_bound import area_rate_bound
from rota.planners.swarm.planner_settings import SwarmSettings

PROJECT = Path(__file__).parents[1]
EXAMPLES = PROJECT / "examples"
DATA = PROJECT.parent / "shared" / "data"
MISSIONS = [
    "building",
    "coast",
    "farm",
    "harbour",
    "harbour-copters",
    "parcel",
    "port-relief",
    "sun2019-fig13",
    "sun2019-fig16",
    "warehouse",
    "warehouse-relief",
]
needs_real_inputs = pytest.mark.skipif(not DATA.is_dir(), reason="../shared/data is missing")

PARCEL_NL = """\
rota: 1
name: parcel-nl
coordinates: wgs84
area: {{geojson: "{data}/parcel-nl.geojson"}}
period_s: 120
fleet: {{speed_m_s: 8, sensor: {{shape: disc, radius_m: 8}}}}
"""
CUMBERLAND = """\
rota: 1
name: cumberland
area: {{map: "{data}/maps/cumberland.yaml", inside: [44, 7]}}
period_s: 300
fleet: {{speed_m_s: 0.6, sensor: {{shape: disc, radius_m: 2}}, body_radius_m: 0.2}}
"""


def example(name: str) -> Mission:
    return read_mission(EXAMPLES / f"{name}.yaml").mission


def real_mission(text: str, folder: Path) -> Path:
    path = folder / "mission.yaml"
    path.write_text(text.format(data=DATA.as_posix()))
    return path


def geodesic_area_m2(ring_deg: list[list[float]]) -> float:
    """Of a ring of longitude and latitude, on the ellipsoid: GeographicLib knows nothing of our projection."""
    longitude_deg, latitude_deg = np.array([point[:2] for point in ring_deg]).T
    return abs(Geod(ellps="WGS84").polygon_area_perimeter(longitude_deg, latitude_deg)[0])


def geojson_areas_m2(path: Path) -> list[float]:
    features = json.loads(path.read_text())["features"]
    return [geodesic_area_m2(feature["geometry"]["coordinates"][0]) for feature in features]


def free_pixels_m2(image: Path, resolution_m: float, inside_m: tuple[float, float], free_below: float) -> float:
    """Area of the free pixels joined with the one at ``inside_m`` (from the sheet's lower left corner), by counting."""
    darkness = (255 - np.asarray(Image.open(image).convert("L"), dtype=float)) / 255
    parts, _ = label(darkness < free_below)
    part = parts[len(parts) - 1 - int(inside_m[1] / resolution_m), int(inside_m[0] / resolution_m)]
    assert part > 0
    return float((parts == part).sum()) * resolution_m**2


def bound_of_the_whole_area(mission: Mission) -> int:
    assert mission.period_s is not None
    return area_rate_bound([mission.area.area], [mission.period_s], mission.fleet.equal_robot("robot-1"))


# ---------------------------------------------------------------- reading


def test_these_are_all_the_examples() -> None:
    named = {path.stem for path in EXAMPLES.glob("*.yaml")}
    swarms = {
        "swarm-charging",
        "swarm-hills",
        "swarm-importance",
        "swarm-port",
        "swarm-space",
        "swarm-square",
        "swarm-squares",
    }
    others = {"building_map", "bounce-cover", "bounce-free", "bounce-monitor", *swarms}
    assert named == {*MISSIONS, *others, "sweep"}


@pytest.mark.parametrize("name", MISSIONS)
def test_an_example_reads_without_a_warning(name: str) -> None:
    read = read_mission(EXAMPLES / f"{name}.yaml")
    assert read.warnings == ()
    assert read.mission.name == name
    assert read.mission.fleet.robots is None


def test_the_harbour_stands_where_its_file_says() -> None:
    mission = example("harbour")
    assert mission.origin is not None
    assert (mission.origin.lat, mission.origin.lon) == pytest.approx((54.362, 13.084), abs=1e-6)
    assert mission.area.bounds == pytest.approx((-210, -140, 210, 140), abs=0.02)
    assert {zone.name: zone.period_s for zone in mission.zones} == {"gate": 40, "fuel berth": 30, "container yard": 60}
    assert [obstacle.blocks for obstacle in mission.obstacles] == ["both"] * 4 + ["motion"]
    berth = next(zone.shape for zone in mission.zones if zone.name == "fuel berth")
    # a 64-gon round a circle of 25 m: r tan(pi / n) n r
    assert berth.area == pytest.approx(64 * math.tan(math.pi / 64) * 25**2, rel=1e-6)


def test_the_parcel_is_as_large_as_on_the_ellipsoid() -> None:
    mission = example("parcel")
    field_m2, pond_m2 = geojson_areas_m2(EXAMPLES / "parcel.geojson")
    assert mission.area.area == pytest.approx(field_m2, rel=1e-6)
    assert mission.obstacles[0].shape.area == pytest.approx(pond_m2, rel=1e-6)
    assert bound_of_the_whole_area(mission) == 3


def test_the_building_is_as_large_as_its_free_pixels() -> None:
    mission = example("building")
    counted_m2 = free_pixels_m2(EXAMPLES / "building_map.png", 0.05, (12.5, 8.5), 0.196)
    assert mission.area.area == pytest.approx(counted_m2, rel=1e-3)
    assert mission.area.contains(Point(12, 8))


def test_sun_2019_figure_13_is_the_published_reconstruction() -> None:
    mission = example("sun2019-fig13")
    assert mission.area.equals(Point(60, 60).buffer(60, cap_style="square"))
    assert union_all([obstacle.shape for obstacle in mission.obstacles]).area == pytest.approx(2 * 30 * 25)
    assert [(zone.period_s, zone.shape.area) for zone in mission.zones] == [(8, 1050), (20, 2025)]
    assert (mission.period_s, mission.fleet.speed_m_s, mission.fleet.sensor) == (40, 20, DiscSensor(radius_m=5))


def test_sun_2019_figure_16_is_the_published_reconstruction() -> None:
    mission = example("sun2019-fig16")
    assert mission.area.area == pytest.approx(2.5 * 72**2 * math.sin(math.tau / 5), rel=1e-9)
    assert (mission.area.centroid.x, mission.area.centroid.y) == pytest.approx((72, 72))
    hexagon, circle = mission.zones
    assert hexagon.shape.area == pytest.approx(1.5 * math.sqrt(3) * 16**2, rel=1e-9)
    assert (hexagon.shape.centroid.x, hexagon.shape.centroid.y) == pytest.approx((50, 85))
    assert circle.shape.area == pytest.approx(64 * math.tan(math.pi / 64) * 12**2, rel=1e-9)
    assert (hexagon.period_s, circle.period_s, mission.period_s) == (10, 12, 45)
    assert (mission.fleet.speed_m_s, mission.fleet.sensor) == (10, DiscSensor(radius_m=5))


def test_the_swarm_s_square_is_the_small_case_of_chen_2018() -> None:
    mission = example("swarm-square")
    robots = mission.fleet.robots or ()
    # Table 2: a square of 250 m, 25 robots of 0.5 m, 25 m and 2 m/s, steps of 0.25 s; discs cover 78.54 % at most
    assert mission.area.equals(box(0, 0, 250, 250))
    assert {(r.body_radius_m, r.sensor, r.speed_m_s) for r in robots} == {(0.5, DiscSensor(radius_m=25), 2)}
    assert len(robots) * math.pi * 25**2 / mission.area.area == pytest.approx(0.7854, abs=1e-4)
    assert isinstance(mission.planning, SwarmSettings)
    assert (
        SwarmSettings.of(mission).time_step_s,
        SwarmSettings.of(mission).stop_m,
        SwarmSettings.of(mission).neighbours,
    ) == (0.25, 1e-5, 4)


@needs_real_inputs
def test_a_dutch_parcel_reads_and_needs_three_robots(tmp_path: Path) -> None:
    read = read_mission(real_mission(PARCEL_NL, tmp_path))
    assert read.warnings == ()
    assert [read.mission.area.area] == pytest.approx(geojson_areas_m2(DATA / "parcel-nl.geojson"), rel=1e-6)
    # A / (2 r V T + pi r^2) = 35,955 / (15,360 + 201) = 2.3
    assert bound_of_the_whole_area(read.mission) == 3


@needs_real_inputs
def test_a_scanned_building_reads_and_needs_two_robots(tmp_path: Path) -> None:
    read = read_mission(real_mission(CUMBERLAND, tmp_path))
    assert read.warnings == ()
    counted_m2 = free_pixels_m2(DATA / "maps" / "cumberland.pgm", 0.075, (44, 7), 0.19)
    # outlines are simplified by at most half a pixel; where steps of a scan are cut, gains and losses nearly cancel
    assert read.mission.area.area == pytest.approx(counted_m2, rel=1e-3)
    assert len(read.mission.area.geoms) == 1
    # A / (2 r V T + pi r^2) = 966 / (720 + 13) = 1.3
    assert bound_of_the_whole_area(read.mission) == 2


@pytest.mark.parametrize(("name", "size_m2", "walls"), [("bounce-cover", 25, 12), ("bounce-monitor", 17.5, 2)])
def test_bouncing_robots_fit_in_every_cell_of_their_typed_map(name: str, size_m2: float, walls: int) -> None:
    mission = example(name)
    assert mission.area.area == pytest.approx(size_m2)
    assert union_all([obstacle.shape for obstacle in mission.obstacles]).area == pytest.approx(walls * 0.25)
    # an iRobot Create 2 is 0.34 m wide
    assert mission.fleet.body_radius_m == 0.17 < BounceSettings.of(mission).cell_m / 2
    assert BounceSettings.of(mission).task == name.split("-")[1]


# ---------------------------------------------------------------- planning


def plan_and_check(mission: Path, folder: Path, capsys: pytest.CaptureFixture[str]) -> tuple[int, int, int]:
    """Plan at quick effort and check, through the command line; returns robots, bound and trajectories in the file."""
    plan_file = folder / "plan.json"
    assert run(["plan", str(mission), "--effort", "quick", "-o", str(plan_file)]) == 0
    assert "Check: met" in capsys.readouterr().out
    assert run(["check", str(plan_file), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["verdict"] == "met"
    assert report["violations"] == []
    assert all(demand["worst_gap_s"] <= demand["period_s"] for demand in report["demands"])
    return report["robots"], report["lower_bound_robots"], len(read_plan(plan_file).trajectories)


@pytest.mark.slow  # plans two examples
def test_the_bouncing_robots_cover_and_monitor(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan_file = tmp_path / "plan.json"
    assert run(["plan", str(EXAMPLES / "bounce-cover.yaml"), "-o", str(plan_file)]) == 0
    assert "3 robots enter 88 of 88 cells (100.0%)" in capsys.readouterr().out
    assert run(["check", str(plan_file)]) == 0
    assert run(["plan", str(EXAMPLES / "bounce-monitor.yaml"), "-o", str(plan_file)]) == 0
    capsys.readouterr()
    assert run(["check", str(plan_file), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["robots"] == 2
    assert report["verdict"] == "met"
    assert len(report["demands"]) == 2
    plan = read_plan(plan_file)
    assert all(trajectory.loop_start_s == 0 for trajectory in plan)
    # they cross each other's way, and never meet
    one, other = (LineString(trajectory.positions_m) for trajectory in plan)
    assert one.crosses(other)
    assert run(["export", str(plan_file), "--to", "geojson", "-o", str(tmp_path / "plan.geojson")]) == 0
    assert run(["draw", str(plan_file), "-o", str(tmp_path / "plan.svg")]) == 0


# open ground with zones; a building whose walls cut sight, with bodies that must not touch: a search of half a minute,
# of the kind that the random missions among blocks are planned by
@pytest.mark.parametrize(
    ("name", "least_robots"),
    [pytest.param("harbour", 4, marks=pytest.mark.slow), pytest.param("building", 1, marks=pytest.mark.slow)],
)
def test_an_example_is_planned_and_the_plan_passes(
    name: str, least_robots: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robots, bound, trajectories = plan_and_check(EXAMPLES / f"{name}.yaml", tmp_path, capsys)
    assert bound == least_robots
    assert bound <= robots <= 2 * bound + 1
    assert trajectories == robots


def test_the_swarm_s_square_is_planned_and_nothing_is_wrong_with_the_plan(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan_file = tmp_path / "plan.json"
    assert run(["plan", str(EXAMPLES / "swarm-square.yaml"), "-o", str(plan_file)]) == 0
    told = capsys.readouterr().out
    assert "25 robots hold" in told
    assert "footprints without overlap would have 78.5%" in told
    assert "Check: no violations." in told
    assert run(["check", str(plan_file)]) == 0


def test_square_sensors_spread_over_the_square_and_hold(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan_file = tmp_path / "plan.json"
    assert run(["plan", str(EXAMPLES / "swarm-squares.yaml"), "-o", str(plan_file)]) == 0
    told = capsys.readouterr().out
    assert "footprints without overlap would have 87.9%" in told
    plan = read_plan(plan_file)
    assert plan.run_end is not None
    assert plan.run_end.at_rest
    ends = [trajectory.positions_m[-1] for trajectory in plan]
    squares = union_all([box(x - 15, y - 15, x + 15, y + 15) for x, y in ends])
    assert squares.intersection(box(0, 0, 128, 128)).area / 128**2 > 0.8


def test_the_robots_in_space_climb_and_spread_and_nothing_is_wrong(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan_file = tmp_path / "plan.json"
    assert run(["plan", str(EXAMPLES / "swarm-space.yaml"), "-o", str(plan_file)]) == 0
    assert "Check: no violations." in capsys.readouterr().out
    ends = np.array([trajectory.positions_m[-1] for trajectory in read_plan(plan_file)])
    # most have climbed to the ceiling; one below the others may be kept from it by those round about
    assert ((ends[:, 2] >= 20) & (ends[:, 2] <= 45)).all()
    assert (ends[:, 2] > 44.99).sum() >= 18
    discs = union_all([Point(x, y).buffer(z / math.sqrt(3), quad_segs=64) for x, y, z in ends])
    assert discs.intersection(box(0, 0, 250, 250)).area / 250**2 > 0.66


def test_robots_leave_for_ground_that_matters(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`python -m docs.crowds_picture` writes its map anew."""
    assert np.array_equal(np.asarray(Image.open(PICTURE)), np.asarray(picture()))
    plan_file = tmp_path / "plan.json"
    assert run(["plan", str(EXAMPLES / "swarm-importance.yaml"), "-o", str(plan_file)]) == 0
    told = capsys.readouterr().out
    plan = read_plan(plan_file)
    assert plan.run_end is not None
    assert plan.run_end.at_rest
    ends = [trajectory.positions_m[-1] for trajectory in plan]
    # by hand: worth by pixels of 2 m, the gate's 2 in place of the map's
    x, y = np.meshgrid(np.arange(1, 240, 2), np.arange(1, 160, 2)[::-1])
    worth = 0.02 + 0.98 * np.asarray(picture(), float) / 255
    worth[(x > 225) & (y > 70) & (y < 95)] = 2
    for left, bottom, right, top in [(98, 0, 102, 76), (98, 86, 102, 160), (140, 60, 170, 80)]:
        worth[(x > left) & (x < right) & (y > bottom) & (y < top)] = 0
    near = np.min([np.hypot(x - at[0], y - at[1]) for at in ends], axis=0) <= 20
    share = worth[near].sum() / worth.sum()
    assert share > 0.7
    number = re.search(r"Of the ground's importance they have ([0-9.]+)% in range", told)
    assert number is not None
    assert float(number[1]) / 100 == pytest.approx(share, abs=0.01)


@pytest.mark.slow  # a swarm of the largest example
def test_the_port_s_robots_spread_round_its_buildings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan_file = tmp_path / "plan.json"
    assert run(["plan", str(EXAMPLES / "swarm-port.yaml"), "-o", str(plan_file)]) == 0
    assert "Check: no violations." in capsys.readouterr().out
    plan = read_plan(plan_file)
    assert plan.run_end is not None
    assert plan.run_end.at_rest
    ends = [trajectory.positions_m[-1] for trajectory in plan]
    assert len(ends) == 60
    free = plan.mission.area.difference(union_all([obstacle.shape for obstacle in plan.mission.obstacles]))
    share = union_all([Point(end).buffer(25) for end in ends]).intersection(free).area / free.area
    assert share > 0.8
    assert max(x for x, _ in ends) > 430
    assert max(y for _, y in ends) > 260


# bounds: A / (2 r V T + pi r^2) is 35,955 / (15,360 + 201) = 2.3 and 966 / (720 + 13) = 1.3
@pytest.mark.slow  # a search of 15 s; a small field is planned by the same code
def test_the_coast_is_watched_by_as_few_wings_as_can_be() -> None:
    plan = make_plan(example("coast"), seed=0)
    assert_driven_on_arcs(plan)
    assert len(plan.trajectories) == plan.lower_bound_robots == 2


@pytest.mark.slow  # the largest searches of all tests, where the inputs are there
@needs_real_inputs
@pytest.mark.parametrize(("text", "least_robots"), [(PARCEL_NL, 3), (CUMBERLAND, 2)], ids=["parcel-nl", "cumberland"])
def test_a_real_input_is_planned_and_the_plan_passes(
    text: str, least_robots: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robots, bound, trajectories = plan_and_check(real_mission(text, tmp_path), tmp_path, capsys)
    assert bound == least_robots
    assert bound <= robots <= 2 * bound + 1
    assert trajectories == robots
