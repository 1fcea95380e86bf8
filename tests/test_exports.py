"""Exports from Python: the same files as by the command line."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest
import shapely

import rota
from rota import DiscSensor, Fleet, GeoPoint, Mission, Plan, RotaError, Trajectory
from rota.files.plan_table import csv_text

MISSION = Mission(
    name="yard",
    area=shapely.box(0, 0, 40, 30),
    period_s=60,
    fleet=Fleet(speed_m_s=5, sensor=DiscSensor(radius_m=4)),
    origin=GeoPoint(lat=48, lon=11),
)
LOOP = Trajectory(robot="robot-1", times_s=[0, 4, 8], positions_m=[[5, 5], [25, 5], [5, 5]])
PLAN = Plan(mission=MISSION, trajectories=(LOOP,))


def test_a_file_and_a_folder(tmp_path: Path) -> None:
    assert rota.export_plan(PLAN, "csv", tmp_path / "plan.csv") == (tmp_path / "plan.csv",)
    assert (tmp_path / "plan.csv").read_text() == csv_text(PLAN)
    paths = rota.export_plan(PLAN, "waypoints", tmp_path / "lists")
    assert [path.parent for path in paths] == [tmp_path / "lists"]
    assert paths[0].read_text().startswith("QGC WPL 110")


def test_what_is_text_in_the_shell_may_be_a_value_of_python(tmp_path: Path) -> None:
    nowhere = replace(PLAN, mission=replace(MISSION, origin=None))
    kml, dji = tmp_path / "plan.kml", tmp_path / "dji"
    rota.export_plan(nowhere, "kml", kml, origin=(48, 11), start_time=datetime(2026, 5, 4, 10, tzinfo=UTC))
    typed = kml.read_text()
    rota.export_plan(nowhere, "kml", kml, origin="48,11", start_time="2026-05-04T10:00:00Z")
    assert kml.read_text() == typed
    (path,) = rota.export_plan(PLAN, "dji-wpml", dji, settings={"drone": "M30"})
    named = path.read_bytes()
    rota.export_plan(PLAN, "dji-wpml", dji, settings=["drone=M30"])
    assert path.read_bytes() == named
    for origin in ((48,), (91, 0), ("north", 3), (None, 0)):
        with pytest.raises(RotaError, match="LAT,LON in degrees is needed"):
            rota.export_plan(nowhere, "kml", kml, origin=origin)  # type: ignore[arg-type]


def test_what_a_format_does_not_take_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RotaError, match="'wkt' is not one of 'geojson'"):
        rota.export_plan(PLAN, "wkt", tmp_path / "plan.wkt")
    with pytest.raises(RotaError, match="csv has no clock"):
        rota.export_plan(PLAN, "csv", tmp_path / "plan.csv", start_time="2026-11-27T12:00:00Z")
    assert list(tmp_path.iterdir()) == []


def test_a_bound_is_proved_without_a_plan() -> None:
    # 1,200 m2 in 60 s by robots that sweep 5 m/s * 8 m and the disc they begin with: (40 * 60 + 16 pi) / 60 > 20
    assert rota.prove_bound(MISSION)[0] == 1
    swarm = Mission(
        name="yard",
        area=MISSION.area,
        fleet=rota.Fleet(
            speed_m_s=5,
            sensor=DiscSensor(radius_m=4),
            robots=(rota.Robot(name="r", speed_m_s=5, sensor=DiscSensor(radius_m=4)),),
        ),
        planning=rota.SwarmSettings(),
    )
    assert rota.prove_bound(swarm) is None
