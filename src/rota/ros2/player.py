"""What is published of a plan as its time goes on: once, at every step, and of the ground less often."""

from __future__ import annotations

from typing import Any

import numpy as np
from shapely import get_coordinates, get_rings
from shapely.geometry.base import BaseGeometry

from rota.cells.cell_map import cell_map_of
from rota.draw.route_lines import robot_colours
from rota.draw.sightings import Sightings
from rota.errors import PlanError
from rota.files.ros.grids import GroundGrid, free_space, percent_of_period, usual_cells
from rota.files.ros.library import grid_message, header_of, types_of
from rota.files.ros.names import namespaces
from rota.files.ros.poses import Motion, own_tracks
from rota.files.ros.wire import (
    MOST_SECONDS,
    NS_PER_S,
    Messages,
    Stamps,
    path_message,
    pose_messages,
    transform_messages,
)
from rota.model.plan import Floats, Plan
from rota.routes.constant_speeds import plan_at_constant_speeds

AGE_CELLS = 16_000
LINE_LIST, ADD, DELETE = 5, 0, 2  # visualization_msgs/Marker
CLOCK_KIND = "rosgraph_msgs/msg/Clock"
MARKERS_KIND = "visualization_msgs/msg/MarkerArray"
AGES, FOOTPRINTS = "/time_since_seen", "/footprints"


class Player:
    """A plan's messages for ROS 2, of whose seconds ``speed`` go by in one. ``begin`` comes first.

    Stamps are the instants at which robots are there; with ``own_clock`` those of a clock that goes as fast as the plan
    does, which ``clock`` tells. Time goes on, never back.
    """

    def __init__(self, plan: Plan, speed: float, *, own_clock: bool = False) -> None:
        self._plan = plan
        self._begin_ns, self._speed = 0, 1.0 if own_clock else speed
        self._motions = [
            (namespace, Motion(trajectory)) for namespace, trajectory in zip(namespaces(plan), plan, strict=True)
        ]
        self._colours = [_rgb(colour) for colour in robot_colours(plan)]
        self._types = types_of(2)
        self._cells = cell_map_of(plan.mission, AGE_CELLS)
        self._sightings = Sightings(plan_at_constant_speeds(plan), self._cells)
        self._seen_until_s = 0.0
        self._ground = free_space(plan.mission, *usual_cells(plan.mission))

    def begin(self, begin_ns: int) -> list[Messages]:
        """Let the plan's 0 be ``begin_ns`` since 1970: free space, the paths, and transforms of who never moves.

        Raises PlanError for paths that end after the year 2038, where ROS 2 ends counting.
        """
        self._begin_ns = begin_ns
        told = [grid_message("/map", self._ground, self._stamps(np.zeros(1)), 2, self._types)]
        for track in own_tracks(self._plan):
            if begin_ns / NS_PER_S + track.times_s[-1] / self._speed > MOST_SECONDS[2]:
                raise PlanError(f"robot {track.namespace}: its path ends after the year 2038; play it faster")
            told.append(path_message(track, self._stamps(track.times_s), 2))
        return told + self._transforms(0.0, still=True)

    def poses(self, time_s: float) -> list[Messages]:
        """Where each robot is, and its transform if it ever moves."""
        times_s = np.array([time_s])
        stamps = self._stamps(times_s)
        told = [pose_messages(motion.track(name, times_s), stamps, 2) for name, motion in self._motions]
        return told + self._transforms(time_s, still=False)

    def clock(self, time_s: float) -> list[Messages]:
        """The time, for nodes with ``use_sim_time``."""
        kinds, stamps = self._types.types, self._stamps(np.array([time_s]))
        time = kinds["builtin_interfaces/msg/Time"](sec=int(stamps[0]) // NS_PER_S, nanosec=int(stamps[0]) % NS_PER_S)
        data = bytes(self._types.serialize_cdr(kinds[CLOCK_KIND](clock=time), CLOCK_KIND))
        return [Messages(topic="/clock", kind=CLOCK_KIND, stamps_ns=stamps, data=data, size=len(data))]

    def ages(self, time_s: float) -> list[Messages]:
        """How long ago each place was seen, in percent of its period; 100: that long ago or more, or not yet.

        Where the mission asks for no period anywhere: 0 for what is in range now, else 100.
        """
        self._sightings.advance(self._seen_until_s, time_s)
        self._seen_until_s = time_s
        cells = self._cells
        if cells.asked.any():
            periods = self._sightings.age_in_periods(time_s)
        else:
            unseen = self._sightings.last_seen_s < time_s
            periods = np.where(cells.inside, np.where(unseen, np.inf, 0.0), np.nan)
        grid = GroundGrid(x_m=cells.x_m, y_m=cells.y_m, cell_m=cells.cell_m, values=percent_of_period(periods))
        return [grid_message(AGES, grid, self._stamps(np.array([time_s])), 2, self._types)]

    def footprints(self, time_s: float) -> list[Messages]:
        """The outline of what each robot sees, cut by what hides it, in the colour of `rota draw`."""
        kinds, stamps = self._types.types, self._stamps(np.array([time_s]))
        markers = [
            self._marker(int(stamps[0]), name, colour, shape)
            for (name, _), colour, shape in zip(
                self._motions, self._colours, self._sightings.footprints(time_s), strict=True
            )
        ]
        data = bytes(self._types.serialize_cdr(kinds[MARKERS_KIND](markers=markers), MARKERS_KIND))
        return [Messages(topic=FOOTPRINTS, kind=MARKERS_KIND, stamps_ns=stamps, data=data, size=len(data))]

    def _transforms(self, time_s: float, *, still: bool) -> list[Messages]:
        times_s = np.array([time_s])
        stamps = self._stamps(times_s)
        return [
            transform_messages(motion.track(name, times_s), stamps, 2)
            for name, motion in self._motions
            if motion.still == still
        ]

    def _stamps(self, times_s: Floats) -> Stamps:
        return self._begin_ns + np.round(times_s / self._speed * NS_PER_S).astype(np.int64)

    def _marker(self, stamp: int, name: str, colour: tuple[float, float, float], shape: BaseGeometry) -> Any:
        """The message that shows a shape by its outline, or deletes it when it is empty."""
        kinds, header = self._types.types, header_of(stamp, 2, self._types)
        point, empty = kinds["geometry_msgs/msg/Point"], np.empty(0, np.uint8)
        red, green, blue = colour
        return kinds["visualization_msgs/msg/Marker"](
            header=header,
            ns=name,
            id=0,
            type=LINE_LIST,
            action=DELETE if shape.is_empty else ADD,
            pose=kinds["geometry_msgs/msg/Pose"](
                position=point(x=0.0, y=0.0, z=0.0),
                orientation=kinds["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
            ),
            scale=kinds["geometry_msgs/msg/Vector3"](x=self._cells.cell_m / 2, y=0.0, z=0.0),
            color=kinds["std_msgs/msg/ColorRGBA"](r=red, g=green, b=blue, a=1.0),
            lifetime=kinds["builtin_interfaces/msg/Duration"](sec=0, nanosec=0),
            frame_locked=False,
            points=[point(x=x, y=y, z=0.0) for x, y in outline_m(shape).tolist()],
            colors=[],
            texture_resource="",
            texture=kinds["sensor_msgs/msg/CompressedImage"](header=header, format="", data=empty),
            uv_coordinates=[],
            text="",
            mesh_resource="",
            mesh_file=kinds["visualization_msgs/msg/MeshFile"](filename="", data=empty),
            mesh_use_embedded_materials=False,
        )


def outline_m(shape: BaseGeometry) -> Floats:
    """The edges of a shape, two points (2 n, 2) in metres for each."""
    edges = [np.empty((0, 2))]
    for ring in get_rings(shape):
        corners_m = get_coordinates(ring)
        edges.append(np.stack([corners_m[:-1], corners_m[1:]], axis=1).reshape(-1, 2))
    return np.concatenate(edges)


def _rgb(colour: str) -> tuple[float, float, float]:
    """Parts 0 to 1 of a colour #RRGGBB."""
    red, green, blue = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
    return red, green, blue
