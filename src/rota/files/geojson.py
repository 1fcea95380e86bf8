"""Plan -> GeoJSON (RFC 7946): area, obstacles, zones, and each robot's approach and loop as features."""

from __future__ import annotations

import json
import os
from collections.abc import Callable

import numpy as np
from shapely import MultiPolygon, transform
from shapely.geometry import mapping
from shapely.geometry.polygon import orient

from rota.files.atomic_write import write_atomically
from rota.files.geodesy import Projection
from rota.model.field_values import Json
from rota.model.mission import Mission
from rota.model.plan import Floats, Plan, Trajectory
from rota.routes.constant_speeds import plan_at_constant_speeds

ToMap = Callable[[Floats], Floats]

SHAPE_DIGITS = 9  # of degrees 0.1 mm on the ground; routes keep all digits


def write_geojson(plan: Plan, path: str | os.PathLike[str]) -> None:
    """Write ``plan_to_geojson(plan)`` to ``path``, whole or not at all. Raises RotaError when it cannot be written."""
    write_atomically(path, geojson_text(plan))


def geojson_text(plan: Plan) -> str:
    """The GeoJSON file's text, one feature per line."""
    document = plan_to_geojson(plan)
    head = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in document.items() if key != "features"]
    features = ",\n  ".join(json.dumps(feature, allow_nan=False) for feature in document["features"])
    return "{" + ",\n ".join([*head, '"features": [\n  ' + features + "]"]) + "}\n"


def plan_to_geojson(plan: Plan) -> Json:
    """A FeatureCollection of the plan, in WGS84 [longitude, latitude] when the mission has an origin.

    A mission without an origin has no place on the globe, and RFC 7946 knows no other coordinates: its collection is
    in the mission's local metres and says so in a member "coordinates_in": "metres". Legs are straight in local metres;
    drawn straight in degrees a leg of length L strays by L^2 tan(latitude) / (8 earth radii), 2 cm for 1 km at 48
    degrees. Rings run counter-clockwise outside and clockwise round holes.

    Properties: "kind" is area, obstacle, zone, approach or loop. A loop has robot, loop_duration_s, loop_length_m and
    times_s, the time at each of its coordinates in the plan's first round; a robot that stays has a Point as its loop.
    Legs with accelerations are shorter ones at constant speeds, never off by more than 5 cm.
    """
    mission, plan = plan.mission, plan_at_constant_speeds(plan)
    to_map = _to_map(mission)
    features = [_feature(_shape(mission.area, to_map), kind="area", name=mission.name, period_s=mission.period_s)]
    for obstacle in mission.obstacles:
        asks = {} if obstacle.asks == "all" else {"asks": obstacle.asks}
        features.append(_feature(_shape(obstacle.shape, to_map), kind="obstacle", blocks=obstacle.blocks, **asks))
    for zone in mission.zones:
        shape = _shape(zone.shape, to_map)
        worth = {} if zone.importance is None else {"importance": zone.importance}
        told = {"name": zone.name, "period_s": zone.period_s, "demand": zone.demand, **worth}
        features.append(_feature(shape, kind="zone", **told))
    for trajectory in plan.trajectories:
        features.extend(_routes(trajectory, to_map))
    frame = {} if mission.origin is not None else {"coordinates_in": "metres"}
    return {"type": "FeatureCollection", "name": mission.name, **frame, "features": features}


def _to_map(mission: Mission) -> ToMap:
    if mission.origin is None:
        return lambda points_m: points_m
    projection = Projection(mission.origin)

    def to_degrees(points_m: Floats) -> Floats:
        return np.column_stack(projection.to_degrees(points_m[:, 0], points_m[:, 1]))

    return to_degrees


def _feature(geometry: Json, **properties: object) -> Json:
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def _shape(shape: MultiPolygon, to_map: ToMap) -> Json:
    turned = MultiPolygon([orient(polygon) for polygon in shape.geoms])
    placed = transform(turned, lambda points_m: np.round(to_map(points_m), SHAPE_DIGITS))
    return dict(mapping(placed.geoms[0] if len(placed.geoms) == 1 else placed))


def _routes(trajectory: Trajectory, to_map: ToMap) -> list[Json]:
    """The approach, if there is one, and the loop of a robot as features."""
    k = trajectory.loop_index
    routes = []
    if k > 0:
        approach = _line(trajectory, 0, k + 1, to_map)
        routes.append(_feature(approach, kind="approach", robot=trajectory.robot, times_s=_times(trajectory, 0, k + 1)))
    n = len(trajectory.times_s)
    loop = _feature(
        _line(trajectory, k, n, to_map),
        kind="loop",
        robot=trajectory.robot,
        loop_duration_s=trajectory.loop_duration_s,
        loop_length_m=trajectory.loop_length_m,
        times_s=_times(trajectory, k, n),
    )
    return [*routes, loop]


def _line(trajectory: Trajectory, first: int, end: int, to_map: ToMap) -> Json:
    positions_m = trajectory.positions_m[first:end]
    points = to_map(positions_m[:, :2])
    if positions_m.shape[1] == 3:
        points = np.column_stack([points, positions_m[:, 2]])
    if len(points) == 1:
        return {"type": "Point", "coordinates": points[0].tolist()}
    return {"type": "LineString", "coordinates": points.tolist()}


def _times(trajectory: Trajectory, first: int, end: int) -> list[float]:
    return list(trajectory.times_s[first:end].tolist())
