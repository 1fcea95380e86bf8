"""Recorded flights of an ArduCopter beside what the motion model makes of their missions: ``--flights FOLDER``.

A folder of records has a manifest.csv (file, kind, wind_m_s, wind_from_deg and more) and a file for each flight:
comment lines with parameters, mission points and the times at which points were reached, then the track.
"""

from __future__ import annotations

import csv
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.row import Options, Row
from rota.model.plan import Floats
from rota.routes.route import RouteStop
from rota.vehicles.ardupilot_auto import ArduPilotAuto
from rota.vehicles.facts import Fact
from rota.vehicles.motion import Way, Wind
from rota.vehicles.presets import ARDUCOPTER

HEIGHT_M = 25.0
MEDIAN, WORST = 0.005, 0.03
ASKED = f"median {100 * MEDIAN:g} %, worst {100 * WORST:g} %"


class Record(NamedTuple):
    """One recorded loop: parameters, waypoints (n, 2), the times of its rounds, and the track of the last (m, 3)."""

    values: dict[str, float]
    points_m: Floats
    rounds_s: list[float]
    track: Floats


def flights(options: Options) -> Iterator[Row]:
    """Times of rounds in mode AUTO and how far tracks are off recorded ones; needs ``--flights FOLDER``."""
    if options.flights is None:
        yield Row("recorded loops, rounds predicted", ASKED, "needs --flights FOLDER", None)
        return
    errors: dict[str, list[float]] = defaultdict(list)
    off_m: dict[str, list[float]] = defaultdict(list)
    with (options.flights / "manifest.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if "loop" in row["kind"] and row["kind"].endswith("AUTO")]
    for row in rows:
        record = read_record(options.flights / row["file"])
        if len(record.rounds_s) < 2 or row["file"].startswith("d"):  # those change their speed in flight, or stop
            continue
        error, far_m = compared(record)
        wind = "wind" if record.values["wind_m_s"] else "no wind"
        name = f"{record.values['accel_m_s2']:g} m/s2, {record.values['angle_max_deg']:g} degrees, {wind}"
        for key in (name, f"all, {wind}"):
            errors[key].append(error)
            off_m[key].append(far_m)
    for name, group in errors.items():
        sizes = np.abs(group)
        worst = max(group, key=abs)
        measured = (
            f"{len(group)} loops: median {100 * np.median(sizes):.2f} %, worst {100 * worst:+.2f} %; tracks at most"
            f" {max(off_m[name]):.2f} m beside recorded ones"
        )
        reached = bool(np.median(sizes) <= MEDIAN and abs(worst) <= WORST)
        asked, reached_or_none = (ASKED, reached) if name == "all, no wind" else ("", None)
        yield Row(f"recorded loops, rounds predicted: {name}", asked, measured, reached_or_none)


def compared(record: Record) -> tuple[float, float]:
    """By what share the predicted round is off the last recorded one, and how far the recorded track is off it in m."""
    values = record.values
    facts = {
        "acceleration_m_s2": "accel_m_s2",
        "jerk_m_s3": "jerk_m_s3",
        "corner_m": "radius_m",
        "lean_deg": "angle_max_deg",
    }
    set_here = {
        ours: Fact(value=values[theirs], parameter=theirs, source="the record") for ours, theirs in facts.items()
    }
    stops = [RouteStop(place_m=(x, y, HEIGHT_M), speed_m_s=values["speed_m_s"]) for x, y in record.points_m.tolist()]
    way = Way(robot="copter", once=(replace(stops[0], speed_m_s=None),), every_round=(*stops[1:], stops[0]))
    wind = Wind(speed_m_s=values["wind_m_s"], from_deg=values["wind_from_deg"])
    motion = ArduPilotAuto(replace(ARDUCOPTER, **set_here)).drive(way, wind)
    line = motion.positions_m[motion.times_s >= motion.loop_start_s, :2]
    apart = [np.hypot(*(line - place).T).min() for place in record.track[:, 1:]]
    return motion.round_s / record.rounds_s[-1] - 1, float(max(apart))


def read_record(path: Path) -> Record:
    """A record with its rounds: the times between two passings of the first waypoint."""
    values: dict[str, float] = {}
    points_m, passed_s, track = np.empty((0, 2)), [], []
    for line in path.read_text().splitlines():
        _, _, told = line.partition(": ")
        if line.startswith("# points_m"):
            points_m = np.array([pair.split() for pair in told.split(";")], dtype=np.float64)
        elif line.startswith("# reached"):
            reached = [entry.split() for entry in told.split(";")]
            passed_s = [float(time) for index, time in reached if int(index) == 0]
        elif line.startswith("# accel"):
            pairs = [pair.strip().split("=") for pair in line[2:].split(";")]
            values = {name: float(value) if value else 0.0 for name, value in pairs}
        elif line[:1].isdigit():
            track.append([float(cell) for cell in line.split(",")[:3]])
    rows = np.array(track)
    last = (rows[:, 0] >= passed_s[-2]) & (rows[:, 0] <= passed_s[-1]) if len(passed_s) > 1 else []
    return Record(values, points_m, np.diff(passed_s).tolist(), rows[last])
