"""What a robot sees from where it stands: its sensor's footprint, cut by the obstacles that hide what lies behind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from shapely import GeometryCollection
from shapely.geometry.base import BaseGeometry

from rota.model.arrays import Floats
from rota.model.mission import DiscSensor, Mission, Sensor

EDGE_ON_M = 1e-9
LEAST_M = 1e-9  # radius of what a sensor on the ground sees


@dataclass(frozen=True, kw_only=True)
class Walls:
    """What cuts sight. ``solid``: the obstacles as one shape; on its edges' left: starts_m, ends_m, (n, 2) metres."""

    solid: BaseGeometry
    starts_m: Floats
    ends_m: Floats


def walls_of(mission: Mission) -> Walls:
    """The obstacles of a mission that block sight, those that touch or overlap made one."""
    solid = shapely.union_all([obstacle.shape for obstacle in mission.obstacles if obstacle.blocks_sight])
    rings = [np.empty((0, 2, 2))]
    for ring in shapely.get_rings(shapely.orient_polygons(shapely.get_parts(solid))):
        corners_m = shapely.get_coordinates(ring)
        rings.append(np.stack([corners_m[:-1], corners_m[1:]], axis=1))
    edges = np.concatenate(rings)
    shapely.prepare(solid)
    return Walls(solid=solid, starts_m=edges[:, 0], ends_m=edges[:, 1])


def _distances_m(walls: Walls, place_m: Floats) -> Floats:
    """Distance (n,) in metres from a place to each edge."""
    along, to_start = walls.ends_m - walls.starts_m, place_m - walls.starts_m
    length2 = np.maximum((along**2).sum(axis=1), 1e-300)
    part = np.clip((to_start * along).sum(axis=1) / length2, 0, 1)
    offset = to_start - part[:, None] * along
    distances_m: Floats = np.hypot(offset[:, 0], offset[:, 1])
    return distances_m


def sensor_from(sensor: Sensor, places_m: Floats) -> Sensor:
    """The sensor as it is from places (n, 2) or (n, 3): a disc that grows with height as from the lowest of them."""
    if not isinstance(sensor, DiscSensor) or sensor.half_angle_deg is None:
        return sensor
    height_m = float(places_m[:, 2].min()) if places_m.shape[1] == 3 else 0.0
    return DiscSensor(radius_m=max(sensor.radius_at_m(height_m), LEAST_M))


def open_footprint(sensor: Sensor, place_m: Floats) -> BaseGeometry:
    """The footprint where nothing stands in the way; a disc as a 64-gon."""
    x_m, y_m = float(place_m[0]), float(place_m[1])
    if isinstance(sensor, DiscSensor):
        return shapely.Point(x_m, y_m).buffer(sensor.radius_m, quad_segs=16)
    half_m = sensor.side_m / 2
    return shapely.box(x_m - half_m, y_m - half_m, x_m + half_m, y_m + half_m)


def _shadows(starts_m: Floats, ends_m: Floats, far_m: float, touching: bool) -> Floats:
    """What edges (n, 2) hide from the origin, out to 0.7 ``far_m`` at least, as pentagons (m, 5, 2).

    Three of the corners lie on the outmost rays and between them, so that even half a turn of shadow reaches far enough
    with numbers of the size of the scene. Edges seen from their solid side are left out, since those in front of them
    hide as much, unless the robot is ``touching`` one: seen edge-on, that one hides nothing.
    """
    along_m = ends_m - starts_m
    off_line_m = (starts_m[:, 1] * ends_m[:, 0] - starts_m[:, 0] * ends_m[:, 1]) / np.hypot(*along_m.T)
    facing = (np.abs(off_line_m) if touching else off_line_m) > EDGE_ON_M
    starts_m, ends_m = starts_m[facing], ends_m[facing]
    to_start, to_end = (np.hypot(corner[:, 0], corner[:, 1])[:, None] for corner in (starts_m, ends_m))
    outer_m = np.maximum(1.01 * np.maximum(to_start, to_end), far_m)
    between = starts_m / to_start + ends_m / to_end
    middle = between / np.hypot(between[:, 0], between[:, 1])[:, None]
    corners = [starts_m, ends_m, ends_m / to_end * outer_m, middle * outer_m, starts_m / to_start * outer_m]
    return np.stack(corners, axis=1)


def cut_footprint(walls: Walls, sensor: Sensor, place_m: Floats) -> BaseGeometry | None:
    """The part of the sensor's footprint at ``place_m`` (2,) that is in sight; None: all of it, nothing is in the way.

    A robot inside an obstacle that blocks sight sees nothing.
    """
    if shapely.contains_xy(walls.solid, *place_m):
        return GeometryCollection()
    distances_m = _distances_m(walls, place_m)
    near = distances_m < sensor.reach_m
    if not near.any():
        return None
    starts_m, ends_m = walls.starts_m[near] - place_m, walls.ends_m[near] - place_m
    touching = bool(distances_m.min() <= EDGE_ON_M)
    shadows = _shadows(starts_m, ends_m, 1.5 * sensor.reach_m, touching) + place_m
    whole = open_footprint(sensor, place_m)
    hidden = shapely.union_all([*shapely.polygons(shadows), shapely.clip_by_rect(walls.solid, *whole.bounds)])
    return shapely.difference(whole, hidden)
