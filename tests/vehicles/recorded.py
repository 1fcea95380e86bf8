"""Recorded flights of a simulated copter, as facts: loops of waypoints, and what the autopilot made of them.

ArduCopter 4.6.0-dev (commit fbb785859a) in software in the loop, its built-in quadcopter, mode AUTO at a set speed of 8
m/s and 25 m, by the parameters named and else its defaults. loops.csv: waypoints, x east and y north in metres.
flights.csv: parameters, steady wind, and the time of the last whole round between two passings of the first waypoint,
as the autopilot reported them (to 0.05 s). tracks.csv: where it was in that round, about once a second.
corners.csv: equal legs with corners of ``TURNS_DEG``, from rest to rest: their length, the speed set, parameters, where
the copter stood before it flew to the first point, and the time from that point to the last.
"""

from __future__ import annotations

import csv
from collections import defaultdict
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from rota.model.plan import Floats
from rota.routes.route import RouteStop
from rota.vehicles.ardupilot_auto import ArduPilotAuto
from rota.vehicles.facts import Fact, Vehicle
from rota.vehicles.motion import Motion, Way, Wind
from rota.vehicles.presets import ARDUCOPTER

HERE = Path(__file__).parent
SPEED_M_S, HEIGHT_M = 8.0, 25.0
TURNS_DEG = (15, -15, 30, -30, 60, -60, 90, 90, -120, 120, -150, 150, 180)


@dataclass(frozen=True)
class Flight:
    """One flight: its way, its copter, its wind and the time of a round."""

    name: str
    way: Way
    vehicle: Vehicle
    wind: Wind
    round_s: float

    def driven(self) -> Motion:
        return ArduPilotAuto(self.vehicle).drive(self.way, self.wind)


def loop_way(points_m: list[tuple[float, float]], speed_m_s: float = SPEED_M_S) -> Way:
    """A loop from its first point, at one height and speed."""
    first, *others = [RouteStop(place_m=(x, y, HEIGHT_M), speed_m_s=speed_m_s) for x, y in points_m]
    return Way(robot="copter", once=(replace(first, speed_m_s=None),), every_round=(*others, first))


def copter(accel_m_s2: float = 2.5, jerk_m_s3: float = 1.0, lean_deg: float = 30.0) -> Vehicle:
    values = {"acceleration_m_s2": accel_m_s2, "jerk_m_s3": jerk_m_s3, "lean_deg": lean_deg}
    return replace(ARDUCOPTER, **{name: Fact(value=v, parameter="set", source="here") for name, v in values.items()})


def recorded_flights() -> list[Flight]:
    loops = defaultdict(list)
    for row in _rows("loops.csv"):
        loops[row["loop"]].append((float(row["x_m"]), float(row["y_m"])))
    return [
        Flight(
            name=row["flight"],
            way=loop_way(loops[row["loop"]]),
            vehicle=copter(float(row["accel_m_s2"]), float(row["jerk_m_s3"]), float(row["lean_deg"])),
            wind=Wind(speed_m_s=float(row["wind_m_s"]), from_deg=float(row["wind_from_deg"])),
            round_s=float(row["round_s"]),
        )
        for row in _rows("flights.csv")
    ]


def recorded_corners() -> list[tuple[dict[str, float], Way, Vehicle]]:
    """What was set and recorded, by its column, the way and the copter of each flight of corners."""
    flights = []
    for row in _rows("corners.csv"):
        told = {name: float(text) for name, text in row.items() if name != "flight"}
        headings = np.radians(np.cumsum([0, *TURNS_DEG]))
        legs_m = told["leg_m"] * np.column_stack([np.sin(headings), np.cos(headings)])
        points_m = np.vstack([[told["start_x_m"], told["start_y_m"]], [0, 0], np.cumsum(legs_m, axis=0)])
        stops = [RouteStop(place_m=(x, y, HEIGHT_M), speed_m_s=told["speed_m_s"]) for x, y in points_m.tolist()]
        vehicle = replace(
            copter(told["accel_m_s2"], told["jerk_m_s3"]),
            corner_m=Fact(value=told["radius_m"], parameter="set", source="here"),
        )
        flights.append((told, Way(robot="copter", once=tuple(stops), every_round=()), vehicle))
    return flights


def recorded_tracks() -> dict[str, Floats]:
    """Rows of seconds since the round began, x and y, by flights' names."""
    tracks = defaultdict(list)
    for row in _rows("tracks.csv"):
        tracks[row["flight"]].append([float(row[name]) for name in ("t_s", "x_m", "y_m")])
    return {name: np.array(rows) for name, rows in tracks.items()}


def _rows(name: str) -> list[dict[str, str]]:
    with (HERE / name).open(newline="") as file:
        return list(csv.DictReader(file))
