"""Single flights as files: as pymavlink, djikmz and a YAML reader read them, and the table of when each starts."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from djikmz.model import KML
from pymavlink import mavwp
from pyproj import Geod
from tests.files.test_dji_waylines import kmz_documents, read_by_djikmz
from tests.relieved import SQUARE_M, relieved

from rota import export_plan
from rota.command.executed import executed_plan
from rota.errors import PlanError, RotaError
from rota.exports import FORMATS
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
    with pytest.raises(RotaError, match="--executed: not allowed for a plan whose robots charge"):
        executed_plan(plan, name)
