"""Single flights as files, as programs of others read them, and the table of when each starts."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from datetime import datetime
from itertools import pairwise
from pathlib import Path
from typing import Any

import fastkml
import gpxpy
import numpy as np
import pytest
import yaml
from djikmz.model import KML
from fastkml import Folder, Placemark
from fastkml.utils import find_all
from pymavlink import mavwp
from pyproj import Geod
from tests.files.test_dji_waylines import kmz_documents, read_by_djikmz
from tests.files.test_vda5050_orders import drive
from tests.relieved import SQUARE_M, relieved, with_battery

from rota import export_plan
from rota.errors import PlanError, RotaError
from rota.exports import FORMATS
from rota.files.timed_places import START
from rota.model.mission import Charger
from rota.model.plan import Plan

TAKEOFF, SPEED, WAYPOINT, LAND = 22, 178, 16, 21
GEOD = Geod(ellps="WGS84")
PLACES_M = [(0.0, 0.0), *SQUARE_M, *SQUARE_M[1:], (0.0, 0.0)]


def metres(lon: float, lat: float) -> tuple[float, float]:
    """Beside the place where x = y = 0; the projection has another middle, which is not noticed so near."""
    azimuth, _, distance_m = GEOD.inv(9.9, 53.5, lon, lat)
    return distance_m * np.sin(np.radians(azimuth)), distance_m * np.cos(np.radians(azimuth))


def rows_of(paths: tuple[Path, ...]) -> list[dict[str, str]]:
    assert paths[-1].name == "flights.csv"
    with paths[-1].open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_flight_takes_off_serves_its_loop_and_lands_on_the_charger(tmp_path: Path) -> None:
    paths = export_plan(relieved(3), "waypoints", tmp_path / "out")
    assert [path.name for path in paths[:-1]] == [f"robot-{k}.1.waypoints" for k in (1, 2, 3)]
    for path in paths[:-1]:
        loader = mavwp.MAVWPLoader()
        loader.load(str(path))
        items = [loader.wp(k) for k in range(1, loader.count())]
        commands = [item.command for item in items]
        assert (commands[0], commands[-1]) == (TAKEOFF, LAND)
        assert set(commands[1:-1]) == {SPEED, WAYPOINT}, "no jump back and no loitering"
        flown = [metres(item.y, item.x) for item in items if item.command in (TAKEOFF, WAYPOINT)]
        np.testing.assert_allclose(flown, PLACES_M, atol=2e-3)
        np.testing.assert_allclose(metres(items[-1].y, items[-1].x), (0, 0), atol=2e-3)
        assert (items[-1].z, items[-2].z) == (0, 30)


def test_the_table_says_when_each_flight_starts(tmp_path: Path) -> None:
    rows = rows_of(export_plan(relieved(3), "qgroundcontrol", tmp_path / "out"))
    assert [row["files"] for row in rows] == [f"robot-{k}.1.plan" for k in (3, 1, 2)]
    told = [[float(row[name]) for name in ("starts_s", "every_s", "lasts_s", "length_m", "charges_s")] for row in rows]
    np.testing.assert_allclose(told, [[starts_s, 480, 180, 180, 300] for starts_s in (-160, 0, 160)], atol=1e-3)
    assert {(row["serves"], row["from_charger"], row["charger"]) for row in rows} == {("A", "pad", "pad")}
    document = json.loads((tmp_path / "out" / rows[0]["files"]).read_text())
    assert "it lands on pad 180.0 s after its start" in document["description"]
    assert "all starting at the same instant" not in document["description"]


def test_the_table_says_when_a_robot_has_to_leave_the_ground(tmp_path: Path) -> None:
    plan = with_battery(relieved(3), landing_s=26, climbing_s=13)
    rows = rows_of(export_plan(plan, "qgroundcontrol", tmp_path / "out"))
    told = [[float(row[name]) for name in ("starts_s", "takes_off_s", "charges_s")] for row in rows]
    np.testing.assert_allclose(told, [[s, s - 13, 300 - 39] for s in (-160, 0, 160)], atol=1e-3)


def test_djikmz_reads_a_flight_that_lands_where_it_ends(tmp_path: Path) -> None:
    path, *_ = export_plan(relieved(3), "dji-wpml", tmp_path / "out")
    kml: KML = read_by_djikmz(kmz_documents(path)[0])
    assert kml.mission_config.finish_action == "autoLand"
    read = [metres(waypoint.longitude, waypoint.latitude) for waypoint in kml.waypoints]
    np.testing.assert_allclose(read, PLACES_M, atol=2e-3)


def slowed(plan: Plan, times: float) -> Plan:
    """The plan with all that it has take so many times as long."""
    made = [
        replace(
            one,
            times_s=one.times_s * times,
            charges=tuple(replace(c, from_s=c.from_s * times, until_s=c.until_s * times) for c in one.charges),
        )
        for one in plan
    ]
    return replace(plan, trajectories=tuple(made))


def test_a_flight_that_an_aircraft_cannot_last_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match=r"robot robot-1.1: its flight takes 45.9 min; an M3E flies for 45 min at most"):
        export_plan(slowed(relieved(3), 15.3), "dji-wpml", tmp_path / "out")
    assert not (tmp_path / "out").exists()
    export_plan(slowed(relieved(3), 15.3), "dji-wpml", tmp_path / "out", settings=["drone=M3D"])


def test_nav2_is_told_the_way_until_the_robot_is_on_its_charger(tmp_path: Path) -> None:
    paths = export_plan(relieved(3), "nav2", tmp_path / "out")
    assert rows_of(paths)[1]["files"] == "robot-1.1.approach.yaml robot-1.1.loop.yaml robot-1.1.path.yaml"
    waypoints = yaml.safe_load(paths[0].read_text())["waypoints"].values()
    np.testing.assert_allclose([each["pose"][:2] for each in waypoints], PLACES_M, atol=1e-9)
    assert list(waypoints)[-1]["wait_s"] == 0


def test_a_vda_5050_vehicle_drives_until_it_charges(tmp_path: Path) -> None:
    start = "2026-05-01T12:00:00Z"
    paths = export_plan(relieved(3), "vda5050", tmp_path / "out", start_time=start)
    rows = rows_of(paths)
    assert [row["files"] for row in rows] == [f"robot-{k}.1.orders.jsonl" for k in (3, 1, 2)]
    orders = {path.name: [json.loads(line) for line in path.read_text().splitlines()] for path in paths[:-1]}
    for row in rows:
        sent = orders[row["files"]]
        np.testing.assert_allclose([place[:2] for place in drive(sent)], PLACES_M, atol=1e-9)
        assert {message["serialNumber"] for message in sent} == {row["robot"]}
        due = datetime.fromisoformat(sent[0]["timestamp"]) - datetime.fromisoformat(start)
        assert due.total_seconds() == pytest.approx(float(row["starts_s"]), abs=1e-3)
        assert [action_types(sent[0]["nodes"][k]) for k in (0, 1, -1)] == [[], [], ["startCharging"]]
    assert len({sent[0]["orderId"] for sent in orders.values()}) == 3, "a vehicle takes an order's id once"
    swapped = replace(relieved(3).mission, chargers=(Charger(name="pad", at=(0, 0), places=99, swap_s=60),))
    for plan, settings in ((replace(relieved(3), mission=swapped), []), (relieved(3), ["charging=false"])):
        path, *_ = export_plan(plan, "vda5050", tmp_path / "bare", settings=settings)
        assert not any(
            action_types(node) for line in path.read_text().splitlines() for node in json.loads(line)["nodes"]
        )


def action_types(node: dict[str, Any]) -> list[str]:
    return [action["actionType"] for action in node["actions"]]


def placed_rows(text: str) -> dict[str, list[tuple[float, float, float]]]:
    """Time, latitude and longitude of each robot's points in a table."""
    told: dict[str, list[tuple[float, float, float]]] = {}
    for row in csv.DictReader(io.StringIO(text)):
        told.setdefault(row["robot"], []).append((float(row["t_s"]), float(row["lat"]), float(row["lon"])))
    return told


def placed_features(text: str) -> dict[str, list[tuple[float, float, float]]]:
    """The same of a map's loops."""
    loops = [each for each in json.loads(text)["features"] if each["properties"]["kind"] == "loop"]
    return {
        each["properties"]["robot"]: [
            (time_s, lat, lon)
            for time_s, (lon, lat) in zip(each["properties"]["times_s"], each["geometry"]["coordinates"], strict=True)
        ]
        for each in loops
    }


def placed_tracks(text: str) -> dict[str, list[tuple[float, float, float]]]:
    """The same of tracks with times, as gpxpy reads them."""
    return {
        track.name or "": [
            ((point.time - START).total_seconds(), point.latitude, point.longitude)
            for point in track.segments[0].points
            if point.time is not None
        ]
        for track in gpxpy.parse(text).tracks
    }


def placed_globe(text: str) -> dict[str, list[tuple[float, float, float]]]:
    """The same of a globe's tour, as fastkml reads it."""
    (robots,) = find_all(fastkml.KML.from_string(text.partition("\n")[2]), of_type=Folder, name="robots")
    return {
        each.name: [
            ((item.when.dt - START).total_seconds(), item.coord.coords[0][1], item.coord.coords[0][0])
            for item in each.kml_geometry.track_items
        ]
        for each in find_all(robots, of_type=Placemark)
    }


READERS = {"csv": placed_rows, "geojson": placed_features, "gpx": placed_tracks, "kml": placed_globe}


@pytest.mark.parametrize("name", READERS)
def test_a_record_holds_every_robots_whole_round_with_its_stays_on_the_charger(name: str, tmp_path: Path) -> None:
    """Each robot repeats after 480 s, of which it is under way for 180 and on the pad for 300."""
    (path,) = export_plan(relieved(3), name, tmp_path / "out")
    told = READERS[name](path.read_text())
    assert list(told) == ["robot-1", "robot-2", "robot-3"]
    for points in told.values():
        assert (points[0][0], points[-1][0]) == (0, 480)
        places = [(time_s, metres(lon, lat)) for time_s, lat, lon in points]
        on_pad_s = sum(b - a for (a, at), (b, to) in pairwise(places) if max(map(abs, (*at, *to))) < 2e-3)
        assert on_pad_s == pytest.approx(300)


@pytest.mark.parametrize("name", sorted(FORMATS))
def test_each_format_tells_flights_or_the_whole_by_a_clock_or_refuses(name: str, tmp_path: Path) -> None:
    plan = relieved(2)
    kind = FORMATS[name]
    if kind.charging == "refused":
        with pytest.raises(RotaError, match=f"--to: '{name}' is not allowed for a plan whose robots charge"):
            export_plan(plan, name, tmp_path / "out")
    elif kind.charging == "flights":
        assert rows_of(export_plan(plan, name, tmp_path / "out"))
    else:
        assert kind.folder is None, "a folder has what vehicles are sent, for ever"
