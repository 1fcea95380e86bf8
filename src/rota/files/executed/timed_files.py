"""Files with a clock, read again: places and times as their digits have them."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from datetime import datetime
from xml.etree import ElementTree

import numpy as np

from rota.files import gpx_tracks, kml_tour
from rota.files.geodesy import Projection, projection_of
from rota.files.geojson import geojson_text
from rota.files.plan_table import csv_text
from rota.files.spreadsheet_cells import from_cell
from rota.files.timed_places import START
from rota.model.plan import Floats, Plan, Trajectory
from rota.routes.constant_speeds import plan_at_constant_speeds

NAMES = {"k": kml_tour.NAMESPACE, "gx": kml_tour.EXTENSIONS, "g": gpx_tracks.NAMESPACE}
METRE_DIGITS = 8
SAME_SPEED = 1e-9  # share by which the check lets speeds be exceeded


def as_csv(plan: Plan) -> tuple[Trajectory, ...]:
    """All robots as a table of their timed points has them."""
    rows: dict[str, list[dict[str, str]]] = {}
    for row in csv.DictReader(io.StringIO(csv_text(plan))):
        rows.setdefault(from_cell(row["robot"]), []).append(row)
    made = []
    for trajectory in plan:
        own = rows[trajectory.robot]
        columns = ["x_m", "y_m", *(["z_m"] if trajectory.positions_m.shape[1] == 3 else [])]
        places_m = np.array([[float(row[column]) for column in columns] for row in own])
        first = [row["in_loop"] for row in own].index("1")
        made.append(drive_at(plan, trajectory, np.array([float(row["t_s"]) for row in own]), places_m, first))
        if trajectory.accelerations_m_s2 is not None:
            given = np.array([float(row["acceleration_m_s2"]) for row in own[:-1]])
            made[-1] = replace(made[-1], accelerations_m_s2=given)
    return tuple(made)


def as_geojson(plan: Plan) -> tuple[Trajectory, ...]:
    """All robots as the lines of a map have them, with the times that are its properties."""
    projection = Projection(plan.mission.origin) if plan.mission.origin is not None else None
    times: dict[str, list[float]] = {}
    places: dict[str, list[list[float]]] = {}
    first: dict[str, int] = {}
    for feature in json.loads(geojson_text(plan))["features"]:
        told, shape = feature["properties"], feature["geometry"]
        if told["kind"] not in ("approach", "loop"):
            continue
        points = [shape["coordinates"]] if shape["type"] == "Point" else shape["coordinates"]
        known = places.setdefault(told["robot"], [])
        if known:  # the approach ends where the loop begins
            known.pop()
            times[told["robot"]].pop()
        if told["kind"] == "loop":
            first[told["robot"]] = len(known)
        known += points
        times.setdefault(told["robot"], []).extend(told["times_s"])
    made = []
    for trajectory in plan:
        places_m = np.array(places[trajectory.robot], dtype=np.float64)
        if projection is not None:
            places_m[:, :2] = metres_read(places_m, projection)
        made.append(drive_at(plan, trajectory, np.array(times[trajectory.robot]), places_m, first[trajectory.robot]))
    return tuple(made)


def as_kml(plan: Plan) -> tuple[Trajectory, ...]:
    """All robots as a globe plays their tracks, the loop again and again."""
    plan = plan_at_constant_speeds(plan)
    root = ElementTree.fromstring(kml_tour.kml_text(plan))  # of our own making
    projection, made = projection_of(plan.mission, "KML"), []
    for track, trajectory in zip(root.iter(f"{{{NAMES['gx']}}}Track"), plan, strict=True):
        times_s = _seconds([when.text or "" for when in track.findall("k:when", NAMES)])
        places = np.array([(coord.text or "").split() for coord in track.findall("gx:coord", NAMES)], dtype=np.float64)
        made.append(_on_ground(plan, trajectory, times_s, places, projection))
    return tuple(made)


def as_gpx(plan: Plan) -> tuple[Trajectory, ...]:
    """All robots as their tracks' points have them, the loop again and again."""
    plan = plan_at_constant_speeds(plan)
    root = ElementTree.fromstring(gpx_tracks.gpx_text(plan))  # of our own making
    projection, made = projection_of(plan.mission, "GPX"), []
    for track, trajectory in zip(root.findall("g:trk", NAMES), plan, strict=True):
        points = track.findall("g:trkseg/g:trkpt", NAMES)
        times_s = _seconds([point.findtext("g:time", "", NAMES) for point in points])
        rows = [(point.get("lon"), point.get("lat"), point.findtext("g:ele", "", NAMES)) for point in points]
        made.append(_on_ground(plan, trajectory, times_s, np.array(rows, dtype=np.float64), projection))
    return tuple(made)


def metres_read(degrees: Floats, projection: Projection) -> Floats:
    """x, y (n, 2) in metres of degrees (n, 2 or 3) with all digits of float64, longitude first.

    They are rounded to 1e-8 m: float64 holds degrees, and the projection is exact, to 5e-9 m. So places on a lattice,
    between which robots drive straight on, come out in a straight row again.
    """
    places_m = np.column_stack(projection.to_metres(degrees[:, 0], degrees[:, 1]))
    return np.asarray(np.round(places_m, METRE_DIGITS), dtype=np.float64)


def _seconds(instants: list[str]) -> Floats:
    """(n,) seconds after the start of instants such as 2000-01-01T00:00:59.123456789Z."""
    parts = [instant.removesuffix("Z").split(".") for instant in instants]
    return np.array(
        [
            (datetime.fromisoformat(f"{whole}Z") - START).total_seconds() + float(f"0.{decimals}")
            for whole, decimals in parts
        ]
    )


def _on_ground(
    plan: Plan, trajectory: Trajectory, times_s: Floats, degrees: Floats, projection: Projection
) -> Trajectory:
    places_m = np.column_stack([metres_read(degrees, projection), degrees[:, 2]])
    return drive_at(plan, trajectory, times_s, places_m, trajectory.loop_index)


def drive_at(plan: Plan, trajectory: Trajectory, times_s: Floats, places_m: Floats, first: int) -> Trajectory:
    """The robot's trajectory of other numbers, with as many coordinates; the loop begins at number ``first``.

    Of points that come at one time the last one counts. The robot is late where it had to be faster than it can.
    """
    places_m = places_m[:, : trajectory.positions_m.shape[1]]
    legs_m = np.linalg.norm(np.diff(places_m, axis=0), axis=1)
    needed_s = legs_m / plan.mission.fleet.robot(trajectory.robot).speed_m_s
    times_s = times_s - times_s[0]
    if (np.diff(times_s) < needed_s * (1 - SAME_SPEED)).any():
        # arrival k = max of told k and arrival k - 1 + needed k, all at once
        total_s = np.concatenate([[0.0], np.cumsum(needed_s)])
        times_s = total_s + np.maximum.accumulate(times_s - total_s)
    kept = np.append(np.diff(times_s) > 0, True)
    return Trajectory(
        robot=trajectory.robot,
        times_s=times_s[kept],
        positions_m=places_m[kept],
        loop_start_s=float(times_s[first]),
    )
