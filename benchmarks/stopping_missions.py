"""Eight missions that take long at different work: what a stop must be heeded in."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from benchmarks.bounce_maps import OPEN
from benchmarks.city import City, write_city
from benchmarks.scanned_floors import FLOORS, Floor, write_floor

# a stand-in of the size of Nav2's depot map as it is shipped: 436 m2 and 1,399 corners
DEPOT = Floor(
    columns=640, rows=440, turned_deg=2.0, ragged=0.1, speckle=0.03, furniture=5.0, rooms=4, sensor_m=3.0
)  # fmt: skip
Pair = tuple[float, float]


def write_building(folder: Path, seed: int = 0) -> Path:
    """A ragged hall with rooms: slow robots with a body, 1,400 corners, much of it seen through gaps only."""
    mission = write_floor("building-1400", DEPOT, seed, folder)
    text = mission.read_text().replace("speed_m_s: 0.8", "speed_m_s: 0.3")
    mission.write_text(text.replace("body_radius_m: 0.2\n", "body_radius_m: 0.22\n"))
    return mission


def write_entered_building(folder: Path) -> Path:
    """The same for robots that come to all from where the map says that inside is, as Nav2's depot as it is shipped."""
    mission = write_building(folder)
    mission.write_text(mission.read_text().replace("  entrances: null\n", ""))
    return mission


def write_corridor(folder: Path) -> Path:
    """22 km by 60 m, as wide as a disc."""
    return write_rectangle(folder, "corridor-22-km", (22_000.0, 60.0), 1000.0, speed_m_s=10.0, radius_m=30.0)


def write_drones(folder: Path) -> Path:
    """Three drones over 34 ha, so many and no more, that start side by side."""
    start = {"points": [[10, 10], [20, 10], [30, 10]]}
    more = {"robots": 3, "start": start, "body_radius_m": 1.0}
    return write_rectangle(folder, "three-drones", (680.0, 500.0), 900.0, speed_m_s=8.0, radius_m=20.0, **more)


def write_wide_turns(folder: Path) -> Path:
    """Lanes 50 m apart for aircraft that turn with 75 m: a turn takes them to a lane farther off.

    The corners, which no loop would come near, are cut off.
    """
    (x, y), cut = (800, 600), 20
    low, high = [[cut, 0], [x - cut, 0], [x, cut]], [[x, y - cut], [x - cut, y], [cut, y]]
    fleet = {"speed_m_s": 18.0, "turn_radius_m": 75.0, "sensor": {"shape": "disc", "radius_m": 25.0}}
    area = [*low, *high, [0, y - cut], [0, cut]]
    return _dumped(folder, {"rota": 1, "name": "wide-turns", "area": area, "period_s": 600.0, "fleet": fleet})


def write_open_field(folder: Path) -> Path:
    """300 m by 200 m with bodies of 0.5 m: the fewest robots are found soon, and shortening goes on."""
    return write_rectangle(folder, "open-field", (300.0, 200.0), 600.0, speed_m_s=2.0, radius_m=5.0, body_radius_m=0.5)


def write_whole_city(folder: Path) -> Path:
    """10 km2 with 400 buildings."""
    return write_city(City(area_km2=10.0, buildings=400), 0, folder)


def write_scanned_floor(folder: Path) -> Path:
    """A ragged floor of 35,600 corners."""
    return write_floor("ragged", FLOORS["ragged"], 0, folder)


def write_joint_map(folder: Path) -> Path:
    """Three robots that bounce, whose joint map of 512 million states Algorithm 2 as printed lays out."""
    zones = [_visited("west", (0.0, 4.0)), _visited("east", (9.0, 5.0))]
    fleet = {"robots": 3, "speed_m_s": 0.2, "sensor": {"shape": "disc", "radius_m": 0.5}, "body_radius_m": 0.3}
    bounce = {"task": "monitor", "method": "as_printed", "bouncing_angles_deg": [135]}
    mission = {
        "rota": 1, "name": "joint-map", "area": {"text": OPEN, "cell_m": 1.0}, "zones": zones,
        "fleet": {**fleet, "turn_rate_rad_s": 1.5}, "planner": "bounce", "bounce": bounce,
    }  # fmt: skip
    return _dumped(folder, mission)


MISSIONS: Mapping[str, Callable[[Path], Path]] = {
    "a ragged building of 1,400 corners": write_building,
    "a corridor of 22 km x 60 m, r = 30 m": write_corridor,
    "three drones with starts over 34 ha": write_drones,
    "turn radius 75 m, lanes 50 m apart, 800 m x 600 m": write_wide_turns,
    "open field of 300 m x 200 m, bodies of 0.5 m": write_open_field,
    "city of 10 km2 with 400 buildings": write_whole_city,
    "scanned floor of 35,600 corners": write_scanned_floor,
    "bounce, joint map of 3 robots": write_joint_map,
}


def write_rectangle(
    folder: Path, name: str, size_m: Pair, period_s: float, *, speed_m_s: float, radius_m: float, **more: Any
) -> Path:
    """The mission over an empty rectangle; ``more``: of the fleet."""
    x, y = size_m
    fleet = {"speed_m_s": speed_m_s, "sensor": {"shape": "disc", "radius_m": radius_m}, **more}
    area = [[0, 0], [x, 0], [x, y], [0, y]]
    return _dumped(folder, {"rota": 1, "name": name, "area": area, "period_s": period_s, "fleet": fleet})


def _visited(name: str, corner: Pair) -> dict[str, Any]:
    """A zone of one cell of 1 m."""
    x, y = corner
    ring = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]]
    return {"name": name, "period_s": 2400, "demand": "visit", "ring": ring}


def _dumped(folder: Path, mission: Mapping[str, Any]) -> Path:
    path = folder / f"{mission['name']}.json"
    path.write_text(json.dumps(mission))
    return path
