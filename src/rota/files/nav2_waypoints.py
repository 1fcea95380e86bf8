"""Plan -> files for Nav2, the navigation of ROS 2: waypoints as its panel in RViz loads them, and a nav_msgs/Path.

Waypoints: nav2_rviz_plugins, Nav2Panel::handleGoalLoader, which takes ``pose`` (x, y, z) and ``orientation``
(w, x, y, z) of each entry and leaves others alone. Path: nav_msgs/msg/Path in YAML, as ``ros2 topic pub`` takes it.
Places are in the mission's own metres, in the frame ``map``.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rota.errors import PlanError
from rota.files.robot_files import write_contents
from rota.model.fleet import Robot
from rota.model.plan import Floats, Plan, Trajectory
from rota.routes.constant_speeds import at_constant_speeds
from rota.routes.driven_route import from_start
from rota.routes.route import RouteStop, route_of, start_height_m
from rota.routes.turning import with_turning

FRAME = "map"
APPROACH, LOOP, PATH = ".approach.yaml", ".loop.yaml", ".path.yaml"
MOST_SECONDS = 2**31 - 1  # builtin_interfaces/Time counts seconds in 32 bits with a sign


def write_nav2_waypoints(plan: Plan, folder: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Write each robot's files into ``folder`` (made if missing); returns their paths.

    ``ROBOT.approach.yaml``: the waypoints from the start until the loop begins; ``ROBOT.loop.yaml``: those of one
    round, to be driven again and again, or the place where the robot stays; ``ROBOT.path.yaml``: both as a Path.
    Each waypoint has, beside its pose, ``speed_m_s`` to reach it with and ``wait_s`` to stand there before the robot
    turns, for clients that drive at given speeds: Nav2 itself knows neither, and turns by itself. Poses of the path
    have the seconds since the start as stamps.

    Raises PlanError for times beyond 2^31 s and for robots whose names give the same file name, RotaError when the
    folder cannot be written to. Nothing is written on errors of the plan.
    """

    def contents(trajectory: Trajectory) -> dict[str, bytes]:
        texts = nav2_texts(trajectory, plan.mission.fleet.robot(trajectory.robot))
        return {name: text.encode() for name, text in texts.items()}

    return write_contents(plan, folder, contents)


def nav2_texts(trajectory: Trajectory, robot: Robot) -> dict[str, str]:
    """One robot's texts by the suffixes of their files. Raises PlanError as ``write_nav2_waypoints``."""
    if trajectory.times_s[-1] > MOST_SECONDS:
        raise PlanError(
            f"robot {trajectory.robot}: its route takes {trajectory.times_s[-1]:.6g} s; ROS 2 counts at most"
            f" {MOST_SECONDS} s"
        )
    # nothing is said of heights on the ground
    route = route_of(trajectory, start_height_m(trajectory, 0.0))
    once, every_round = with_turning(from_start(route), route.every_round, robot.turn_rate_rad_s)
    return {
        APPROACH: _waypoints_text(once, before=[], after=every_round[:1]),
        LOOP: _waypoints_text(every_round or once[-1:], before=once, after=every_round[:1]),
        PATH: _path_text(at_constant_speeds(trajectory)),
    }


def _waypoints_text(stops: Sequence[RouteStop], before: Sequence[RouteStop], after: Sequence[RouteStop]) -> str:
    """The panel's YAML of ``stops``; the others are those driven to before and after, which headings depend on."""
    places_m = np.array([stop.place_m for stop in (*before, *stops, *after)])
    headings_rad = headings(places_m)[len(before) :].tolist()
    lines = ["waypoints:\n"]
    for number, (stop, heading_rad) in enumerate(zip(stops, headings_rad, strict=False)):
        x, y, z = map(yaml_number, stop.place_m)
        w, turned = yaml_number(math.cos(heading_rad / 2)), yaml_number(math.sin(heading_rad / 2))
        lines.append(f"  waypoint{number}:\n    pose: [{x}, {y}, {z}]\n    orientation: [{w}, 0.0, 0.0, {turned}]\n")
        if stop.speed_m_s is not None:
            lines.append(f"    speed_m_s: {yaml_number(stop.speed_m_s)}\n")
        lines.append(f"    wait_s: {yaml_number(stop.wait_s)}\n")
    return "".join(lines)


def _path_text(trajectory: Trajectory) -> str:
    """A nav_msgs/Path of the approach and one round."""
    places_m = trajectory.positions_m
    k = trajectory.loop_index
    # the last place of a round is where the next one begins
    headings_rad = headings(np.concatenate([places_m, places_m[k + 1 :]]))[: len(places_m)]
    if trajectory.headings_rad is not None:
        headings_rad = trajectory.headings_rad
    heights_m = places_m[:, 2] if places_m.shape[1] == 3 else np.zeros(len(places_m))
    nanoseconds = np.round(trajectory.times_s * 1e9).astype(np.int64).tolist()
    lines = [f"header: {{stamp: {{sec: 0, nanosec: 0}}, frame_id: {FRAME}}}\nposes:\n"]
    columns = (places_m[:, 0].tolist(), places_m[:, 1].tolist(), heights_m.tolist(), headings_rad.tolist(), nanoseconds)
    for *place, heading_rad, instant in zip(*columns, strict=True):
        x, y, z = map(yaml_number, place)
        w, turned = yaml_number(math.cos(heading_rad / 2)), yaml_number(math.sin(heading_rad / 2))
        sec, nanosec = divmod(instant, 10**9)
        lines.append(
            f"- header: {{stamp: {{sec: {sec}, nanosec: {nanosec}}}, frame_id: {FRAME}}}\n"
            f"  pose: {{position: {{x: {x}, y: {y}, z: {z}}}, orientation: {{x: 0.0, y: 0.0, z: {turned}, w: {w}}}}}\n"
        )
    return "".join(lines)


def headings(places_m: Floats) -> Floats:
    """(n,) radians: the direction in which each place (n, 2 or 3) is left, of arrival at the end; 0 for none."""
    steps_m = np.diff(places_m[:, :2], axis=0)
    directions = np.arctan2(steps_m[:, 1], steps_m[:, 0])
    moves = np.flatnonzero((steps_m != 0).any(axis=1))
    if not len(moves):
        return np.zeros(len(places_m))
    leaving = np.searchsorted(moves, np.arange(len(places_m)))
    return np.asarray(directions[moves[np.minimum(leaving, len(moves) - 1)]], dtype=np.float64)


def yaml_number(value: float) -> str:
    """A float with all its digits, as YAML 1.1 takes it, which asks for a point before an exponent."""
    text = repr(value)
    return text if "." in text or "e" not in text else text.replace("e", ".0e")
