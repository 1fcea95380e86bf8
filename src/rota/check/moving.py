"""Whether a body touches a moving obstacle: the closest approach of two timed polylines, in closed form."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rota.check.report import Violation
from rota.mission import MovingObstacle
from rota.plan import Plan, Trajectory

Floats = NDArray[np.float64]

TOUCH_M = 1e-6


def moving_violations(plan: Plan) -> list[Violation]:
    """Robots whose bodies overlap a moving obstacle by more than 1e-6 m at some time, each at its closest approach.

    Both are judged for ever: a loop is followed until the obstacle has come to a stand, and once round after that.
    """
    found = []
    for trajectory in plan:
        body_m = plan.mission.fleet.robot(trajectory.robot).body_radius_m
        for k, obstacle in enumerate(plan.mission.moving_obstacles):
            distance, time_s, place = _closest(trajectory, obstacle)
            if distance < body_m + obstacle.radius_m - TOUCH_M:
                found.append(
                    Violation(
                        kind=f"moving obstacle {k + 1}",
                        who=trajectory.robot,
                        place_m=place,
                        time_s=time_s,
                        value=distance,
                        limit=body_m + obstacle.radius_m,
                        unit="m between centres",
                    )
                )
    return found


def _closest(trajectory: Trajectory, obstacle: MovingObstacle) -> tuple[float, float, tuple[float, float]]:
    """Least distance of the centres, when it is, and where the robot is then."""
    times, places = _followed(trajectory, obstacle.times_s[-1])
    knots = np.union1d(times, [time for time in obstacle.times_s if time > 0])
    robot = np.stack([np.interp(knots, times, places[:, axis]) for axis in (0, 1)], axis=1)
    theirs = np.array(obstacle.positions_m)
    other = np.stack([np.interp(knots, obstacle.times_s, theirs[:, axis]) for axis in (0, 1)], axis=1)
    gap = np.vstack([other - robot, other[-1:] - robot[-1:]])
    drift = np.diff(gap, axis=0)
    drift2 = (drift**2).sum(axis=1)
    share = np.clip(-(gap[:-1] * drift).sum(axis=1) / np.where(drift2 > 0, drift2, 1.0), 0.0, 1.0)
    distance = np.hypot(*(gap[:-1] + share[:, None] * drift).T)
    m = int(np.argmin(distance))
    last = min(m + 1, len(knots) - 1)
    x, y = robot[m] + share[m] * (robot[last] - robot[m])
    return float(distance[m]), float(knots[m] + share[m] * (knots[last] - knots[m])), (float(x), float(y))


def _followed(trajectory: Trajectory, until_s: float) -> tuple[Floats, Floats]:
    """Times and places of a robot, its loop repeated until a time and once more."""
    times, places, loop_s = trajectory.times_s, trajectory.positions_m[:, :2], trajectory.loop_duration_s
    if loop_s == 0:
        return times, places
    turns = max(0, math.ceil((until_s - times[-1]) / loop_s)) + 1
    first = trajectory.loop_index + 1
    more = times[first:] + loop_s * np.arange(1, turns + 1)[:, None]
    return np.concatenate([times, more.ravel()]), np.vstack([places, np.tile(places[first:], (turns, 1))])
