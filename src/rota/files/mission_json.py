"""A plan file's mission <-> JSON, bit for bit: its shapes in local metres, its defaults filled in."""

from __future__ import annotations

from typing import Any

import numpy as np
from shapely import MultiPolygon, Polygon

from rota.errors import PlanError
from rota.files.plan_faults import named_field
from rota.files.plan_schema import (
    DiscSensorFields,
    FleetFields,
    ImportanceMapFields,
    MissionFields,
    MotionFields,
    MovingObstacleFields,
    RobotFields,
    SquareSensorFields,
    StartFields,
)
from rota.model.mission import (
    DiscSensor,
    Fleet,
    GeoPoint,
    ImportanceMap,
    Mission,
    MovingObstacle,
    Obstacle,
    PlannerSettings,
    Robot,
    Sensor,
    SquareSensor,
    StartBox,
    StartPoints,
    Zone,
)
from rota.model.motion_limits import MOTION_FIELDS, MotionLimits
from rota.model.planner_settings import Settings, settings_of
from rota.planning.planner import planner_named

Json = dict[str, Any]

# ---------------------------------------------------------------- writing


def mission_to_json(mission: Mission) -> Json:
    """The mission as plain dicts, lists, strings and numbers, with its shapes resolved to rings."""
    origin = mission.origin
    return {
        "name": mission.name,
        "area": polygons_to_json(mission.area),
        "obstacles": [obstacle_to_json(obstacle) for obstacle in mission.obstacles],
        "zones": [
            {
                "name": zone.name,
                "period_s": _number(zone.period_s),
                "demand": zone.demand,
                "shape": polygons_to_json(zone.shape),
                **({} if zone.importance is None else {"importance": float(zone.importance)}),
            }
            for zone in mission.zones
        ],
        **({} if mission.importance is None else {"importance": _importance_to_json(mission.importance)}),
        "period_s": _number(mission.period_s),
        "unseeable": mission.unseeable,
        **({} if mission.holds_within_s is None else {"holds_within_s": float(mission.holds_within_s)}),
        "origin": None if origin is None else {"lat": float(origin.lat), "lon": float(origin.lon)},
        "fleet": _fleet_to_json(mission.fleet),
        **_planner_to_json(mission),
    }


def obstacle_to_json(obstacle: Obstacle) -> Json:
    """An obstacle, with what it asks only where that is nothing."""
    asks = {} if obstacle.asks == "all" else {"asks": obstacle.asks}
    return {"shape": polygons_to_json(obstacle.shape), "blocks": obstacle.blocks, **asks}


def _importance_to_json(importance: float | ImportanceMap) -> Json | float:
    """What the ground is worth outside zones: a number, or rows of numbers and where they lie."""
    if not isinstance(importance, ImportanceMap):
        return float(importance)
    return {
        "low_m": list(importance.low_m),
        "step_m": list(importance.step_m),
        "values": importance.values.tolist(),
    }


def _planner_to_json(mission: Mission) -> Json:
    """The planner's name and settings, and what moves in the way of a swarm."""
    settings = {"planner": mission.planning.planner, mission.planning.planner: _settings_to_json(mission.planning)}
    if not mission.planning.heeds_moving_obstacles:
        return settings
    moving = [
        {"radius_m": float(m.radius_m), "times_s": list(m.times_s), "positions_m": [list(at) for at in m.positions_m]}
        for m in mission.moving_obstacles
    ]
    return {"moving_obstacles": moving, **settings}


def _settings_to_json(block: Settings) -> Json:
    """A block of settings, without what is spared; lists in place of tuples, as reading gives them."""
    told: Json = {}
    for item in settings_of(type(block)):
        value = block.value_of(item.name)
        if item.block is None:
            told[item.name] = (list(value) or item.word) if isinstance(value, tuple) else value
        elif not item.spared or value != item.block():
            told[item.name] = _settings_to_json(value)
    return told


def _fleet_to_json(fleet: Fleet) -> Json:
    """The fleet's common values and its robots, each with values of its own; "fewest" where none are listed."""

    def robot_to_json(robot: Robot) -> Json:
        """One robot, with when it joins and leaves only if it does not stay all the time."""
        return {
            "name": robot.name,
            "speed_m_s": float(robot.speed_m_s),
            "sensor": _sensor_to_json(robot.sensor),
            "body_radius_m": float(robot.body_radius_m),
            **_turning_to_json(robot),
            **_motion_to_json(robot.motion),
            "start": None if robot.start is None else [float(robot.start[0]), float(robot.start[1])],
            **({} if robot.stays else {"joins_s": float(robot.joins_s), "leaves_s": _number(robot.leaves_s)}),
        }

    return {
        "robots": "fewest" if fleet.robots is None else [robot_to_json(robot) for robot in fleet.robots],
        "speed_m_s": float(fleet.speed_m_s),
        "sensor": _sensor_to_json(fleet.sensor),
        "body_radius_m": float(fleet.body_radius_m),
        **_turning_to_json(fleet),
        **_motion_to_json(fleet.motion),
        "altitude_m": float(fleet.altitude_m),
        "start": _start_to_json(fleet.start),
        **({} if fleet.entrances is None else {"entrances": [list(place) for place in fleet.entrances]}),
        **({"rally_points": [list(place) for place in fleet.rally_points]} if fleet.rally_points else {}),
    }


def _turning_to_json(turning: Fleet | Robot) -> Json:
    """How fast robots turn on the spot, and their turn radius only where they have one."""
    radius = {"turn_radius_m": float(turning.turn_radius_m)} if turning.turn_radius_m else {}
    return {"turn_rate_rad_s": _number(turning.turn_rate_rad_s), **radius}


def _motion_to_json(motion: MotionLimits) -> Json:
    """The limits of motion that there are."""
    return {name: value if isinstance(value, str) else _number(value) for name, value in motion.told.items()}


def _start_to_json(start: StartBox | StartPoints | None) -> Json | None:
    """Where the fleet begins; None: wherever the planner likes."""
    if isinstance(start, StartBox):
        return {"box": [list(start.low_m), list(start.high_m)]}
    return None if start is None else {"points": [list(point) for point in start.points_m]}


def _sensor_to_json(sensor: Sensor) -> Json:
    """A sensor's shape and size, with the half angle only where the footprint grows with height."""
    if isinstance(sensor, DiscSensor):
        angle = {} if sensor.half_angle_deg is None else {"half_angle_deg": float(sensor.half_angle_deg)}
        return {"shape": "disc", "radius_m": float(sensor.radius_m), **angle}
    return {"shape": "square", "side_m": float(sensor.side_m)}


def polygons_to_json(shape: MultiPolygon) -> list[list[list[list[float]]]]:
    """A list of polygons, each a list of rings, the outer one first, whose first point is not repeated."""

    def ring_to_json(ring: Any) -> list[list[float]]:
        """One ring's corners in the plane."""
        return [[float(x), float(y)] for x, y, *_ in ring.coords[:-1]]

    return [[ring_to_json(ring) for ring in (polygon.exterior, *polygon.interiors)] for polygon in shape.geoms]


def _number(value: float | None) -> float | None:
    """A plain float of any kind of number, where there is one."""
    return None if value is None else float(value)


# ---------------------------------------------------------------- reading


def mission_from_fields(fields: MissionFields) -> Mission:
    """The mission that ``mission_to_json`` wrote. Raises PlanError naming the field that makes none."""
    area = _polygons(fields.area, "mission.area")
    obstacles = []
    for k, obstacle in enumerate(fields.obstacles):
        shape = _polygons(obstacle.shape, f"mission.obstacles[{k}].shape")
        with named_field(f"mission.obstacles[{k}]"):
            obstacles.append(Obstacle(shape=shape, blocks=obstacle.blocks, asks=obstacle.asks))
    zones = []
    for k, zone in enumerate(fields.zones):
        shape = _polygons(zone.shape, f"mission.zones[{k}].shape")
        with named_field(f"mission.zones[{k}]"):
            zones.append(
                Zone(
                    name=zone.name,
                    shape=shape,
                    period_s=zone.period_s,
                    demand=zone.demand,
                    importance=zone.importance,
                )
            )
    fleet = _fleet(fields.fleet)
    with named_field("mission"):
        return Mission(
            name=fields.name,
            area=area,
            obstacles=tuple(obstacles),
            zones=tuple(zones),
            importance=_importance(fields.importance),
            period_s=fields.period_s,
            fleet=fleet,
            origin=None if fields.origin is None else GeoPoint(lat=fields.origin.lat, lon=fields.origin.lon),
            unseeable=fields.unseeable,
            holds_within_s=fields.holds_within_s,
            planning=_planning(fields),
            moving_obstacles=tuple(_moving_obstacle(moving) for moving in fields.moving_obstacles),
        )


def _importance(fields: ImportanceMapFields | float | None) -> ImportanceMap | float | None:
    """What the ground is worth outside zones. Raises PlanError for rows of different lengths."""
    if not isinstance(fields, ImportanceMapFields):
        return fields
    if len({len(row) for row in fields.values}) > 1:
        raise PlanError("mission.importance.values: rows of different lengths; all must have as many numbers")
    (x, y), (across, up) = fields.low_m, fields.step_m
    return ImportanceMap(values=np.array(fields.values), low_m=(x, y), step_m=(across, up))


def _planning(fields: MissionFields) -> PlannerSettings:
    """The chosen planner's settings."""
    with named_field("mission"):
        return planner_named(fields.planner).settings.written(fields.settings, None)


def _moving_obstacle(fields: MovingObstacleFields) -> MovingObstacle:
    """One moving obstacle with its course."""
    positions = tuple((at[0], at[1]) for at in fields.positions_m)
    return MovingObstacle(radius_m=fields.radius_m, times_s=tuple(fields.times_s), positions_m=positions)


def _fleet(fields: FleetFields) -> Fleet:
    """The fleet; robots None where the file says "fewest"."""
    robots = None
    if not isinstance(fields.robots, str):
        robots = tuple(_robot(robot, f"mission.fleet.robots[{k}]") for k, robot in enumerate(fields.robots))
    with named_field("mission.fleet"):
        return Fleet(
            robots=robots,
            speed_m_s=fields.speed_m_s,
            sensor=_sensor(fields.sensor),
            body_radius_m=fields.body_radius_m,
            turn_rate_rad_s=fields.turn_rate_rad_s,
            turn_radius_m=fields.turn_radius_m,
            motion=_motion(fields),
            altitude_m=fields.altitude_m,
            start=_start(fields.start),
            entrances=None if fields.entrances is None else tuple((place[0], place[1]) for place in fields.entrances),
            rally_points=tuple((place[0], place[1]) for place in fields.rally_points),
        )


def _robot(fields: RobotFields, field: str) -> Robot:
    """One robot of the fleet. Raises PlanError naming the field that makes none."""
    with named_field(field):
        return Robot(
            name=fields.name,
            speed_m_s=fields.speed_m_s,
            sensor=_sensor(fields.sensor),
            body_radius_m=fields.body_radius_m,
            turn_rate_rad_s=fields.turn_rate_rad_s,
            turn_radius_m=fields.turn_radius_m,
            motion=_motion(fields),
            start=None if fields.start is None else (fields.start[0], fields.start[1]),
            joins_s=fields.joins_s,
            leaves_s=fields.leaves_s,
        )


def _motion(fields: MotionFields) -> MotionLimits:
    """The limits of motion of a fleet or a robot."""
    return MotionLimits(**{name: getattr(fields, name) for name in MOTION_FIELDS})


def _start(fields: StartFields | None) -> StartBox | StartPoints | None:
    """Where the fleet begins: in a box, or at points."""
    if fields is None:
        return None
    if fields.box is not None:
        low, high = fields.box
        return StartBox(low_m=(low[0], low[1]), high_m=(high[0], high[1]))
    assert fields.points is not None
    return StartPoints(points_m=tuple((point[0], point[1]) for point in fields.points))


def _sensor(fields: DiscSensorFields | SquareSensorFields) -> Sensor:
    """A disc or a square."""
    if isinstance(fields, DiscSensorFields):
        return DiscSensor(radius_m=fields.radius_m, half_angle_deg=fields.half_angle_deg)
    return SquareSensor(side_m=fields.side_m)


def _polygons(polygons: list[list[list[list[float]]]], field: str) -> MultiPolygon:
    """The shape of a field. Raises PlanError naming it where rings cross."""
    # the first point is repeated here and not by shapely, which leaves rings alone that look closed already
    closed = [[[*ring, ring[0]] for ring in polygon] for polygon in polygons]
    shape = MultiPolygon([Polygon(rings[0], rings[1:]) for rings in closed])
    if not shape.is_valid:
        raise PlanError(f"{field}: an invalid shape; rings may not cross themselves or each other")
    return shape
