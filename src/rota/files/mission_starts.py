"""Where robots start, come in, and moving obstacles go: to local metres, with starts dealt to the robots."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from shapely import MultiPolygon

from rota.errors import MissionError
from rota.files.geodesy import Projection
from rota.files.map_entrances import entrances_on_map
from rota.files.mission_ground import Ground
from rota.files.mission_schema import FleetBlock, MissionFile, RobotBlock
from rota.files.schema_faults import Fault
from rota.files.shape_schema import AreaBlock
from rota.files.yaml_text import Place
from rota.model.mission import Fleet, Mission, MovingObstacle, StartBox, StartPoints, corner_faults, start_faults
from rota.model.refusals import path_of
from rota.planning.planner import planner_named

START: Place = ("fleet", "start")
ENTRANCES: Place = ("fleet", "entrances")
RALLY_POINTS: Place = ("fleet", "rally_points")


class _Written(NamedTuple):
    """A start as the file has it, and where it stands there."""

    place: Place
    point: tuple[float, float]


def fleet_at_its_starts(fleet: Fleet, file: MissionFile, ground: Ground) -> tuple[Fleet, list[Fault]]:
    """The fleet with its starts and entrances in local metres, and what is wrong with them.

    Named robots without a start of their own take the points in their order, one each. A fleet with faults is returned
    without starts and entrances.
    """
    block = file.fleet
    to_metres = _Metres(ground, in_degrees=file.coordinates == "wgs84")
    try:
        if fleet.robots is None:
            placed, where = _placed_fewest(fleet, block, to_metres)
        else:
            placed, where = _placed_robots(fleet, block, to_metres)
        placed = replace(placed, entrances=_entrances(block, to_metres), rally_points=_rally_points(block, to_metres))
        if (inside := _inside(file)) is not None:
            placed = replace(placed, entrances=entrances_on_map(inside, placed, ground.area, _blocking(ground)))
    except _Misplaced as error:
        return fleet, error.faults
    faults = start_faults(ground.area, _blocking(ground), placed) + corner_faults(
        ground.area, _blocking(ground), placed
    )
    if faults:
        where |= {f"fleet.entrances[{k}]": (*ENTRANCES, k) for k in range(len(placed.entrances or ()))}
        where |= {f"fleet.rally_points[{k}]": (*RALLY_POINTS, k) for k in range(len(placed.rally_points))}
        where |= _corner_places(block)
        return fleet, [
            Fault(where[field], f"its corner_m of {message}" if where[field][-1] == "vehicle" else message)
            for field, message in faults
        ]
    return placed, []


def moved_in(mission: Mission, file: MissionFile) -> list[Fault]:
    """A warning where no body fits at the point inside a map, so that robots come in elsewhere."""
    inside, entrances = _inside(file), mission.fleet.entrances
    if inside is None or entrances is None or entrances[0] == inside:
        return []
    (x, y), away_m = entrances[0], math.dist(inside, entrances[0])
    return [Fault(("area", "inside"), f"no body fits there; robots come in at [{x:.6g}, {y:.6g}], {away_m:.3g} m away")]


def moving_obstacles(file: MissionFile, ground: Ground) -> tuple[MovingObstacle, ...]:
    """The mission's moving obstacles in local metres. Raises MissionError for a place that no projection holds."""
    to_metres = _Metres(ground, in_degrees=file.coordinates == "wgs84")
    moving = []
    for k, block in enumerate(file.moving_obstacles):
        written = [_Written(("moving_obstacles", k, "positions_m", j), at) for j, at in enumerate(block.positions_m)]
        try:
            positions = tuple(map(to_metres, written))
        except _Misplaced as error:
            raise MissionError(*(f"moving_obstacles[{k}]: {fault.message}" for fault in error.faults)) from None
        moving.append(MovingObstacle(radius_m=block.radius_m, times_s=tuple(block.times_s), positions_m=positions))
    return tuple(moving)


def _inside(file: MissionFile) -> tuple[float, float] | None:
    """The point in a map at which robots come in; None where there is no map, or the fleet says where they may be."""
    is_told = "entrances" in file.fleet.model_fields_set
    heeded = planner_named(file.planner).settings.heeds_entrances
    return file.area.inside if isinstance(file.area, AreaBlock) and heeded and not is_told else None


def _blocking(ground: Ground) -> list[MultiPolygon]:
    """The shapes of what blocks motion."""
    return [obstacle.shape for obstacle in ground.obstacles if obstacle.blocks_motion]


class _Misplaced(Exception):  # noqa: N818 (the reader of the starts catches it)
    def __init__(self, *faults: Fault) -> None:
        self.faults = list(faults)


class _Metres:
    """From coordinates as written to local metres."""

    def __init__(self, ground: Ground, *, in_degrees: bool) -> None:
        self._projection = Projection(ground.origin) if in_degrees and ground.origin is not None else None

    def __call__(self, written: _Written) -> tuple[float, float]:
        x, y = written.point
        if self._projection is None:
            return x, y
        try:
            east, north = self._projection.to_metres([x], [y])
        except MissionError as error:
            raise _Misplaced(*(Fault(written.place, fault) for fault in error.faults)) from None
        return float(east[0]), float(north[0])


def _corner_places(block: FleetBlock) -> dict[str, Place]:
    """Where corners that are cut stand: where they are given, else with the vehicle that presets them."""
    blocks: list[tuple[Place, FleetBlock | RobotBlock]] = [(("fleet",), block)]
    if isinstance(block.robots, list):
        blocks += [(("fleet", "robots", k), robot) for k, robot in enumerate(block.robots)]
    return {
        f"{path_of(place)}.corner_m": (*place, "corner_m" if each.corner_m is not None else "vehicle")
        for place, each in blocks
    }


def _box(block: FleetBlock, to_metres: _Metres) -> StartBox | None:
    if block.start is None or block.start.box is None:
        return None
    low, high = (to_metres(_Written((*START, "box"), point)) for point in block.start.box)
    return StartBox(low_m=low, high_m=high)


def _entrances(block: FleetBlock, to_metres: _Metres) -> tuple[tuple[float, float], ...] | None:
    if block.entrances is None:
        return None
    return tuple(to_metres(_Written((*ENTRANCES, k), point)) for k, point in enumerate(block.entrances))


def _rally_points(block: FleetBlock, to_metres: _Metres) -> tuple[tuple[float, float], ...]:
    return tuple(to_metres(_Written((*RALLY_POINTS, k), point)) for k, point in enumerate(block.rally_points))


def _points(block: FleetBlock) -> list[_Written]:
    points = block.start.points if block.start is not None else None
    return [_Written((*START, "points", k), point) for k, point in enumerate(points or [])]


def _placed_fewest(fleet: Fleet, block: FleetBlock, to_metres: _Metres) -> tuple[Fleet, dict[str, Place]]:
    where: dict[str, Place] = {"fleet.start.box": (*START, "box")}
    points = _points(block)
    if not points:
        return replace(fleet, start=_box(block, to_metres)), where
    where |= {f"fleet.start.points[{k}]": written.place for k, written in enumerate(points)}
    return replace(fleet, start=StartPoints(points_m=tuple(map(to_metres, points)))), where


def _placed_robots(fleet: Fleet, block: FleetBlock, to_metres: _Metres) -> tuple[Fleet, dict[str, Place]]:
    assert fleet.robots is not None
    listed = block.robots if isinstance(block.robots, list) else []
    written: list[_Written | None] = [None] * len(fleet.robots)
    for k, robot in enumerate(listed):
        if robot.start is not None:
            written[k] = _Written(("fleet", "robots", k, "start"), robot.start)
    points = _points(block)
    waiting = [k for k, start in enumerate(written) if start is None]
    if points and len(points) != len(waiting):
        message = (
            f"{len(points)} points for {len(waiting)} robots without a start of their own; as many points as robots"
            " are needed"
        )
        raise _Misplaced(Fault((*START, "points"), message))
    for k, point in zip(waiting, points, strict=False):
        written[k] = point
    box = _box(block, to_metres)
    if box is not None and not waiting:
        raise _Misplaced(Fault(START, "every robot has a start of its own: remove it"))
    robots = [
        robot if start is None else replace(robot, start=to_metres(start))
        for robot, start in zip(fleet.robots, written, strict=True)
    ]
    where: dict[str, Place] = {"fleet.start.box": (*START, "box")}
    where |= {f"fleet.robots[{k}].start": start.place for k, start in enumerate(written) if start is not None}
    return replace(fleet, robots=tuple(robots), start=box), where
