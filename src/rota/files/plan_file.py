"""Plan <-> JSON, bit for bit. A plan file stands alone: anybody can check it without the mission's other files."""

from __future__ import annotations

import json
import os
import reprlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from pydantic import BaseModel, ValidationError
from shapely import MultiPolygon, Polygon

from rota.errors import MissionError, PlanError, RotaError
from rota.files.atomic_write import write_atomically
from rota.files.local_file import read_bytes
from rota.files.plan_schema import (
    PLAN_VERSION,
    DiscSensorFields,
    FleetFields,
    MissionFields,
    MovingObstacleFields,
    PlanFields,
    SquareSensorFields,
    StartFields,
    TrajectoryFields,
)
from rota.mission import (
    BounceSettings,
    DiscSensor,
    Fleet,
    GeoPoint,
    Mission,
    MovingObstacle,
    Obstacle,
    PatrolSettings,
    Robot,
    Sensor,
    SquareSensor,
    StartBox,
    StartPoints,
    Sun2019,
    SwarmSettings,
    Zone,
)
from rota.plan import Plan, Trajectory

Json = dict[str, Any]
MOST_FAULTS = 20
MADE_BY = "'rota plan' writes one"


# ---------------------------------------------------------------- writing


def write_plan(plan: Plan, path: str | os.PathLike[str], *, meets_demand: bool = True) -> None:
    """Write ``plan`` to ``path``: whole or not at all. ``meets_demand`` False marks it as the best that was found.

    Raises PlanError for a heading that is not finite, RotaError when the path cannot be written.
    """
    write_atomically(path, plan_text(plan, meets_demand=meets_demand))


def plan_text(plan: Plan, *, meets_demand: bool = True) -> str:
    """The plan file's text: JSON, one line per field of the mission and per trajectory."""
    document = plan_to_json(plan, meets_demand=meets_demand)
    lines = [f"{json.dumps(key)}: {_line(document[key])}" for key in document if key not in ("mission", "robots")]
    fields = ",\n  ".join(f"{json.dumps(key)}: {_line(value)}" for key, value in document["mission"].items())
    lines.append('"mission": {\n  ' + fields + "}")
    lines.append('"robots": [\n  ' + ",\n  ".join(_line(robot) for robot in document["robots"]) + "]")
    return "{" + ",\n ".join(lines) + "}\n"


def _line(value: object) -> str:
    return json.dumps(value, allow_nan=False)


def plan_to_json(plan: Plan, *, meets_demand: bool = True) -> Json:
    """The plan as plain dicts, lists, strings and numbers, as the plan file holds it."""
    mark: Json = {} if meets_demand else {"meets_demand": False}
    reason = {} if plan.lower_bound_reason is None else {"lower_bound_reason": plan.lower_bound_reason}
    return {
        "rota_plan": PLAN_VERSION,
        "seed": int(plan.seed),
        "lower_bound_robots": None if plan.lower_bound_robots is None else int(plan.lower_bound_robots),
        **reason,
        **mark,
        "mission": _mission_to_json(plan.mission),
        "robots": [_trajectory_to_json(trajectory) for trajectory in plan.trajectories],
    }


def _mission_to_json(mission: Mission) -> Json:
    origin = mission.origin
    return {
        "name": mission.name,
        "area": _polygons_to_json(mission.area),
        "obstacles": [{"shape": _polygons_to_json(o.shape), "blocks": o.blocks} for o in mission.obstacles],
        "zones": [
            {
                "name": zone.name,
                "period_s": _number(zone.period_s),
                "demand": zone.demand,
                "shape": _polygons_to_json(zone.shape),
            }
            for zone in mission.zones
        ],
        "period_s": _number(mission.period_s),
        "unseeable": mission.unseeable,
        "origin": None if origin is None else {"lat": float(origin.lat), "lon": float(origin.lon)},
        "fleet": _fleet_to_json(mission.fleet),
        **_planner_to_json(mission),
    }


def _planner_to_json(mission: Mission) -> Json:
    # lists in place of tuples, as reading gives them
    values = {
        key: list(value) if isinstance(value, tuple) else value for key, value in asdict(mission.planning).items()
    }
    settings = {"planner": mission.planning.planner, mission.planning.planner: values}
    if not isinstance(mission.planning, SwarmSettings):
        return settings
    moving = [
        {"radius_m": float(m.radius_m), "times_s": list(m.times_s), "positions_m": [list(at) for at in m.positions_m]}
        for m in mission.moving_obstacles
    ]
    return {"moving_obstacles": moving, **settings}


def _fleet_to_json(fleet: Fleet) -> Json:
    def robot_to_json(robot: Robot) -> Json:
        return {
            "name": robot.name,
            "speed_m_s": float(robot.speed_m_s),
            "sensor": _sensor_to_json(robot.sensor),
            "body_radius_m": float(robot.body_radius_m),
            "turn_rate_rad_s": _number(robot.turn_rate_rad_s),
            "start": None if robot.start is None else [float(robot.start[0]), float(robot.start[1])],
            **({} if robot.stays else {"joins_s": float(robot.joins_s), "leaves_s": _number(robot.leaves_s)}),
        }

    return {
        "robots": "fewest" if fleet.robots is None else [robot_to_json(robot) for robot in fleet.robots],
        "speed_m_s": float(fleet.speed_m_s),
        "sensor": _sensor_to_json(fleet.sensor),
        "body_radius_m": float(fleet.body_radius_m),
        "turn_rate_rad_s": _number(fleet.turn_rate_rad_s),
        "altitude_m": float(fleet.altitude_m),
        "start": _start_to_json(fleet.start),
    }


def _start_to_json(start: StartBox | StartPoints | None) -> Json | None:
    if isinstance(start, StartBox):
        return {"box": [list(start.low_m), list(start.high_m)]}
    return None if start is None else {"points": [list(point) for point in start.points_m]}


def _sensor_to_json(sensor: Sensor) -> Json:
    if isinstance(sensor, DiscSensor):
        angle = {} if sensor.half_angle_deg is None else {"half_angle_deg": float(sensor.half_angle_deg)}
        return {"shape": "disc", "radius_m": float(sensor.radius_m), **angle}
    return {"shape": "square", "side_m": float(sensor.side_m)}


def _trajectory_to_json(trajectory: Trajectory) -> Json:
    headings = trajectory.headings_rad
    if headings is not None and not np.isfinite(headings).all():
        k = int(np.flatnonzero(~np.isfinite(headings))[0])
        raise PlanError(f"robot {trajectory.robot}: headings_rad[{k}] = {headings[k]}; headings must be finite")
    return {
        "name": trajectory.robot,
        "loop_start_s": trajectory.loop_start_s,
        "times_s": trajectory.times_s.tolist(),
        "positions_m": trajectory.positions_m.tolist(),
        "headings_rad": None if headings is None else headings.tolist(),
    }


def _polygons_to_json(shape: MultiPolygon) -> list[list[list[list[float]]]]:
    def ring_to_json(ring: Any) -> list[list[float]]:
        return [[float(x), float(y)] for x, y, *_ in ring.coords[:-1]]

    return [[ring_to_json(ring) for ring in (polygon.exterior, *polygon.interiors)] for polygon in shape.geoms]


def _number(value: float | None) -> float | None:
    return None if value is None else float(value)


# ---------------------------------------------------------------- reading


def read_plan(path: str | os.PathLike[str]) -> Plan:
    """Read a plan file. Raises PlanError naming the file, the field and what is allowed there."""
    try:
        text = read_bytes(Path(path), f"a plan file ({MADE_BY})")
    except MissionError as error:
        raise PlanError(str(error)) from None
    return plan_from_text(text, os.fspath(path))


def plan_from_text(text: str | bytes, source: str) -> Plan:
    """Read the text of a plan file; ``source`` names it in errors. Raises PlanError."""
    try:
        decoded = text.decode("utf-8-sig") if isinstance(text, bytes) else text
        document = json.loads(decoded, parse_constant=_refuse_constant)
    except UnicodeDecodeError as error:
        raise PlanError(f"{source}: byte {error.start} is not UTF-8; a plan file is needed ({MADE_BY})") from error
    except json.JSONDecodeError as error:
        raise PlanError(
            f"{source}:{error.lineno}:{error.colno}: not JSON: {error.msg}; a plan file is needed ({MADE_BY})"
        ) from error
    except RecursionError as error:
        raise PlanError(f"{source}: brackets nested too deeply for a plan file") from error
    except (ValueError, PlanError) as error:  # also a number of more digits than Python converts
        raise PlanError(f"{source}: {error}") from error
    try:
        return plan_from_json(document)
    except PlanError as error:
        raise PlanError("\n".join(f"{source}: {line}" for line in str(error).splitlines())) from error


def _refuse_constant(constant: str) -> NoReturn:
    raise PlanError(f"{constant} is no number that a plan may hold; numbers must be finite")


def plan_from_json(document: object) -> Plan:
    """The plan that ``plan_to_json`` made; ``meets_demand`` is not believed but left to the check.

    Raises PlanError: one line per fault, each with the field's path, its value and what is allowed.
    """
    if not isinstance(document, dict) or "rota_plan" not in document:
        raise PlanError('not a plan file: there is no "rota_plan" at the top; a plan file is needed (' + MADE_BY + ")")
    version = document["rota_plan"]
    if version != PLAN_VERSION or isinstance(version, bool):
        raise PlanError(f"rota_plan: version {version!r} is not known; this Rota reads version {PLAN_VERSION}")
    try:
        fields = PlanFields.model_validate(document)
    except ValidationError as error:
        raise PlanError("\n".join(_faults(error))) from error
    mission = _mission(fields.mission)
    trajectories = tuple(_trajectory(robot, f"robots[{k}]") for k, robot in enumerate(fields.robots))
    with _at("robots"):
        return Plan(
            mission=mission,
            trajectories=trajectories,
            seed=fields.seed,
            lower_bound_robots=fields.lower_bound_robots,
            lower_bound_reason=fields.lower_bound_reason,
        )


def _faults(error: ValidationError) -> Iterator[str]:
    found = error.errors(include_url=False)
    for fault in found[:MOST_FAULTS]:
        message = f"{_path(fault['loc'])}: {fault['msg']}"
        if fault["type"] == "extra_forbidden":
            known = get_close_matches(str(fault["loc"][-1]), _all_keys(), n=1)
            message = f"{_path(fault['loc'])}: unknown key" + (f"; did you mean {known[0]}?" if known else "")
        elif isinstance(fault["input"], str | int | float) and fault["type"] != "missing":
            message += f", not {reprlib.repr(fault['input'])}"
        yield message
    if len(found) > MOST_FAULTS:
        yield f"and {len(found) - MOST_FAULTS} more faults"


def _path(location: tuple[int | str, ...]) -> str:
    # pydantic names the member of a union it tried; that is no part of the file
    parts = [part for part in location if part not in ("disc", "square", "fewest", "list")]
    return "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in parts).lstrip(".") or "plan"


def _all_keys() -> list[str]:
    models: list[type[BaseModel]] = [
        PlanFields,
        MissionFields,
        FleetFields,
        StartFields,
        TrajectoryFields,
        DiscSensorFields,
        SquareSensorFields,
    ]
    return [key for model in models for key in model.model_fields]


@contextmanager
def _at(field: str) -> Iterator[None]:
    try:
        yield
    except RotaError as error:
        raise PlanError(f"{field}: {error}") from error


def _mission(fields: MissionFields) -> Mission:
    area = _polygons(fields.area, "mission.area")
    obstacles = []
    for k, obstacle in enumerate(fields.obstacles):
        shape = _polygons(obstacle.shape, f"mission.obstacles[{k}].shape")
        obstacles.append(Obstacle(shape=shape, blocks=obstacle.blocks))
    zones = []
    for k, zone in enumerate(fields.zones):
        shape = _polygons(zone.shape, f"mission.zones[{k}].shape")
        zones.append(Zone(name=zone.name, shape=shape, period_s=zone.period_s, demand=zone.demand))
    fleet = _fleet(fields.fleet)
    with _at("mission"):
        return Mission(
            name=fields.name,
            area=area,
            obstacles=tuple(obstacles),
            zones=tuple(zones),
            period_s=fields.period_s,
            fleet=fleet,
            origin=None if fields.origin is None else GeoPoint(lat=fields.origin.lat, lon=fields.origin.lon),
            unseeable=fields.unseeable,
            planning=_planning(fields),
            moving_obstacles=tuple(_moving_obstacle(moving) for moving in fields.moving_obstacles),
        )


def _planning(fields: MissionFields) -> PatrolSettings | SwarmSettings | BounceSettings:
    if fields.bounce is not None:
        with _at("mission"):
            return BounceSettings(**fields.bounce.model_dump())
    if fields.swarm is not None:
        with _at("mission"):
            return SwarmSettings(**fields.swarm.model_dump())
    if fields.patrol is None:
        return PatrolSettings()
    values = fields.patrol.model_dump(exclude={"sun2019"})
    return PatrolSettings(**values, sun2019=Sun2019(**fields.patrol.sun2019.model_dump()))


def _moving_obstacle(fields: MovingObstacleFields) -> MovingObstacle:
    positions = tuple((at[0], at[1]) for at in fields.positions_m)
    return MovingObstacle(radius_m=fields.radius_m, times_s=tuple(fields.times_s), positions_m=positions)


def _fleet(fields: FleetFields) -> Fleet:
    robots = None
    if not isinstance(fields.robots, str):
        robots = tuple(
            Robot(
                name=robot.name,
                speed_m_s=robot.speed_m_s,
                sensor=_sensor(robot.sensor),
                body_radius_m=robot.body_radius_m,
                turn_rate_rad_s=robot.turn_rate_rad_s,
                start=None if robot.start is None else (robot.start[0], robot.start[1]),
                joins_s=robot.joins_s,
                leaves_s=robot.leaves_s,
            )
            for robot in fields.robots
        )
    with _at("mission.fleet"):
        return Fleet(
            robots=robots,
            speed_m_s=fields.speed_m_s,
            sensor=_sensor(fields.sensor),
            body_radius_m=fields.body_radius_m,
            turn_rate_rad_s=fields.turn_rate_rad_s,
            altitude_m=fields.altitude_m,
            start=_start(fields.start),
        )


def _start(fields: StartFields | None) -> StartBox | StartPoints | None:
    if fields is None:
        return None
    if fields.box is not None:
        low, high = fields.box
        return StartBox(low_m=(low[0], low[1]), high_m=(high[0], high[1]))
    assert fields.points is not None
    return StartPoints(points_m=tuple((point[0], point[1]) for point in fields.points))


def _sensor(fields: DiscSensorFields | SquareSensorFields) -> Sensor:
    if isinstance(fields, DiscSensorFields):
        return DiscSensor(radius_m=fields.radius_m, half_angle_deg=fields.half_angle_deg)
    return SquareSensor(side_m=fields.side_m)


def _polygons(polygons: list[list[list[list[float]]]], field: str) -> MultiPolygon:
    # the first point is repeated here and not by shapely, which leaves rings alone that look closed already
    closed = [[[*ring, ring[0]] for ring in polygon] for polygon in polygons]
    shape = MultiPolygon([Polygon(rings[0], rings[1:]) for rings in closed])
    if not shape.is_valid:
        raise PlanError(f"{field}: an invalid shape; rings may not cross themselves or each other")
    return shape


def _trajectory(fields: TrajectoryFields, field: str) -> Trajectory:
    n, widths = len(fields.times_s), {len(position) for position in fields.positions_m}
    if len(widths) > 1:
        raise PlanError(f"{field}.positions_m: [x, y] and [x, y, z] mixed; all must have as many numbers")
    for name, values in (("positions_m", fields.positions_m), ("headings_rad", fields.headings_rad)):
        if values is not None and len(values) != n:
            raise PlanError(f"{field}.{name}: {len(values)} entries; {n} are needed, one per time in times_s")
    with _at(field):
        return Trajectory(
            robot=fields.name,
            times_s=np.array(fields.times_s, dtype=np.float64),
            positions_m=np.array(fields.positions_m, dtype=np.float64),
            headings_rad=None if fields.headings_rad is None else np.array(fields.headings_rad, dtype=np.float64),
            loop_start_s=fields.loop_start_s,
        )
