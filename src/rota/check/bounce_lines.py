"""Whether a robot without a grid bounces: straight lines, and turns by its angle where its body touches a wall."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import shapely

from rota.check.arrays import Floats
from rota.check.report import Violation, violation
from rota.check.routes import lines_of, segments_of
from rota.check.tolerances import AHEAD_M, ALONG_WALL, BOUNCE_TOLERANCE_RAD, STILL_M, TOUCH_M
from rota.model.mission import Mission
from rota.model.plan import Trajectory
from rota.model.violation_kinds import ViolationKind


class Walls:
    """The borders and obstacles of a mission, for its widest body."""

    def __init__(self, mission: Mission) -> None:
        blocked = shapely.union_all([o.shape for o in mission.obstacles if o.blocks_motion])
        self._ground: Any = shapely.difference(mission.area, blocked)
        shapely.prepare(self._ground)
        self._tree = shapely.STRtree(lines_of(np.vstack([segments_of(mission.area), segments_of(blocked)])))
        robots = mission.fleet.unlike_robots
        self._body_m = max(robot.body_radius_m for robot in robots)

    def clear_m(self, place_m: Floats) -> float:
        """How far the body at a place is from the nearest wall; below 0: in it."""
        point = shapely.Point(place_m)
        away = float(self._tree.query_nearest(point, return_distance=True, all_matches=False)[1][0])
        return (away if shapely.covers(self._ground, point) else -away) - self._body_m

    def stop(self, place_m: Floats, heading_rad: float) -> bool:
        """Whether the body touches a wall within 1e-6 m and would go into it."""
        here_m = self.clear_m(place_m)
        ahead = np.array([math.cos(heading_rad), math.sin(heading_rad)]) * AHEAD_M
        return here_m <= 2 * TOUCH_M and self.clear_m(place_m + ahead) < here_m - ALONG_WALL * AHEAD_M


def line_violations(trajectory: Trajectory, walls: Walls, angle_rad: float) -> list[Violation]:
    """Turns that are no bounces: by another angle, or where no wall stops the robot; waiting, and resting."""
    places, times = trajectory.positions_m[:, :2], trajectory.times_s
    ways = np.diff(places, axis=0)
    lengths = np.hypot(*ways.T)
    moving = [int(k) for k in np.flatnonzero(lengths > STILL_M)]
    looping = [k for k in moving if k >= trajectory.loop_index]

    def wrong(kind: ViolationKind, k: int, value: float, limit: float, unit: str) -> Violation:
        """A violation at the robot's position k."""
        return violation(kind, trajectory.robot, places[k], times[k], value, limit, unit)

    if not looping:
        return [wrong("rests where nothing is in the way", len(places) - 1, 0.0, math.degrees(angle_rad), "degrees")]
    directions = np.arctan2(ways[:, 1], ways[:, 0])
    violations = _facing_violations(trajectory, moving, directions, lengths)
    for before, after in [*itertools.pairwise(moving), (looping[-1], looping[0])]:
        noise = BOUNCE_TOLERANCE_RAD + 8 * STILL_M * (1 / lengths[before] + 1 / lengths[after])
        turned = float((directions[after] - directions[before]) % math.tau)
        seam_s = times[-1] - times[before + 1] + times[after] - trajectory.loop_start_s
        pause_s = seam_s if after <= before else times[after] - times[before + 1]
        straight = min(turned, math.tau - turned) <= noise
        if straight and pause_s <= 0:
            continue
        count = 1 if straight else _bounces(turned, angle_rad, noise)
        degrees = math.degrees(turned)
        if count is None:
            violations.append(wrong("turns by another angle", after, degrees, math.degrees(angle_rad), "degrees"))
        elif not all(walls.stop(places[after], directions[before] + j * angle_rad) for j in range(count)):
            violations.append(
                wrong("turns where nothing is in the way", after, degrees, math.degrees(angle_rad), "degrees")
            )
        elif (swept := _swept_rad(trajectory, before, after)) > count * angle_rad + noise:
            swept_deg = math.degrees(swept)
            violations.append(
                wrong("turns by another angle", after, swept_deg, math.degrees(count * angle_rad), "degrees")
            )
    return violations


def _facing_violations(
    trajectory: Trajectory, moving: list[int], directions: Floats, lengths: Floats
) -> list[Violation]:
    """Ways on which the file's headings are not the way's direction, as they begin or as they end.

    A turn that takes no time may be given with the point at which a way ends, where the next one begins at once.
    """
    faced, places, times = trajectory.headings_rad, trajectory.positions_m[:, :2], trajectory.times_s
    if faced is None:
        return []
    violations, goes = [], set(moving)
    for k in moving:
        noise = BOUNCE_TOLERANCE_RAD + 4 * STILL_M / lengths[k]
        following = trajectory.loop_index if k + 1 == len(directions) else k + 1
        allowed = [directions[k], *([directions[following]] if following in goes else [])]
        for at, ways in ((k, allowed[:1]), (k + 1, allowed)):
            off = min(abs(float((faced[at] - way + math.pi) % math.tau - math.pi)) for way in ways)
            if off > noise:
                violations.append(
                    violation(
                        "faces another way than it drives", trajectory.robot, places[at], times[at], off, noise, "rad"
                    )
                )
                break
    return violations


def _swept_rad(trajectory: Trajectory, before: int, after: int) -> float:
    """By how much the file's headings turn counterclockwise while the robot stands between two ways; 0: it has none."""
    faced = trajectory.headings_rad
    if faced is None:
        return 0.0
    across = after <= before  # the seam of the loop
    stand = (
        [*range(before + 1, len(faced)), *range(trajectory.loop_index, after + 1)]
        if across
        else [*range(before + 1, after + 1)]
    )
    turns = np.diff(faced[stand]) % math.tau
    return float(turns[turns < math.tau - BOUNCE_TOLERANCE_RAD].sum())


def _bounces(turned_rad: float, angle_rad: float, noise_rad: float) -> int | None:
    """How many bounces turn so far; None: no number up to a whole round of them does."""
    for count in range(1, 361):
        off = (count * angle_rad - turned_rad + math.pi) % math.tau - math.pi
        if abs(off) <= noise_rad:
            return count
        if count * angle_rad % math.tau < BOUNCE_TOLERANCE_RAD:
            return None  # round and round again from here on
    return None
