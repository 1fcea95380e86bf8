"""Whether a body touches a moving obstacle: the closest approach of two timed polylines, exactly."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import shapely

from rota.check.approach import gaps_at, nearest_shares
from rota.check.arrays import Floats
from rota.check.report import APART, Violation, violation
from rota.check.routes import lines_of
from rota.check.tolerances import TOUCH_M
from rota.model.mission import MovingObstacle
from rota.model.plan import Plan, Trajectory

MOST_POINTS = 1_000_000  # to which a loop is followed; of a longer way every phase is taken to occur, on the safe side


def moving_violations(plan: Plan) -> list[Violation]:
    """Robots whose bodies overlap a moving obstacle by more than 1e-6 m at some time, each at its closest approach.

    Both are judged for ever: a loop is followed until the obstacle has come to a stand, and once round after that.
    Where these are very many turns, the robot is held against the obstacle's whole way, whenever it may be where.
    """
    violations = []
    for trajectory in plan:
        body_m = plan.mission.fleet.robot(trajectory.robot).body_radius_m
        for k, obstacle in enumerate(plan.mission.moving_obstacles):
            followed = _follow(trajectory, obstacle.times_s[-1])
            closest = _closest_ever(trajectory, obstacle) if followed is None else _closest(followed, obstacle)
            distance, time_s, place = closest
            if distance < body_m + obstacle.radius_m - TOUCH_M:
                who, limit_m = f"{trajectory.robot}, moving obstacle {k + 1}", body_m + obstacle.radius_m
                violations.append(violation("moving obstacle", who, place, time_s, distance, limit_m, APART))
    return violations


def _closest_ever(trajectory: Trajectory, obstacle: MovingObstacle) -> tuple[float, None, tuple[float, float]]:
    """Least distance of any place on the robot's way and any on the obstacle's, and where on the robot's."""
    way, theirs = (lines_of(_legs(places)) for places in (trajectory.positions_m[:, :2], obstacle.positions_m))
    nearest, _ = shapely.STRtree(way).query_nearest(theirs, all_matches=False)[::-1]
    distance = shapely.distance(way[nearest], theirs)
    k = int(np.argmin(distance))
    place = shapely.get_point(shapely.shortest_line(way[nearest[k]], theirs[k]), 0)
    return float(distance[k]), None, (float(place.x), float(place.y))


def _legs(places_m: object) -> Floats:
    """Legs (n, 4) of a way through places; one of no length where there is one place."""
    places = np.asarray(places_m, np.float64)
    return np.hstack([places[:-1], places[1:]]) if len(places) > 1 else np.hstack([places, places])


def _closest(way: _Followed, obstacle: MovingObstacle) -> tuple[float, float, tuple[float, float]]:
    """Least distance of the centres, when it is, and where the robot is then."""
    times, places, _ = way
    knots = np.union1d(times, [time for time in obstacle.times_s if time > 0])
    even_s, bow = _even_out(way, knots)
    robot = np.stack([np.interp(even_s, times, places[:, axis]) for axis in (0, 1)], axis=1)
    theirs = np.array(obstacle.positions_m)
    other = np.stack([np.interp(knots, obstacle.times_s, theirs[:, axis]) for axis in (0, 1)], axis=1)
    gap = np.vstack([other - robot, other[-1:] - robot[-1:]])
    drift = np.diff(gap, axis=0)
    share = nearest_shares(gap[:-1], drift, -bow)
    distance = np.hypot(*gaps_at(gap[:-1], drift, -bow, share).T)
    m = int(np.argmin(distance))
    last = min(m + 1, len(knots) - 1)
    x, y = robot[m] + share[m] * (robot[last] - robot[m]) + share[m] * (share[m] - 1) * bow[m]
    return float(distance[m]), float(knots[m] + share[m] * (knots[last] - knots[m])), (float(x), float(y))


def _even_out(way: _Followed, knots_s: Floats) -> tuple[Floats, Floats]:
    """For a robot followed through knots (k,) in time: the times at which it would be there if it drove legs evenly.

    And how far its way from each knot to the next bends in time, (k, 2), none after the last; see ``nearest_shares``.
    """
    times, places, bends = way
    bow = np.zeros((len(knots_s), 2))
    if not bends.any():
        return knots_s, bow
    leg = np.clip(np.searchsorted(times, knots_s, side="right") - 1, 0, len(bends) - 1)
    begin, length, bend = times[leg], np.diff(times)[leg], bends[leg]
    share = np.clip((knots_s - begin) / length, 0.0, 1.0)
    even_s = np.where(bend != 0, begin + (share + bend * share * (share - 1)) * length, knots_s)
    till = np.clip((knots_s[1:] - begin[:-1]) / length[:-1], 0.0, 1.0)
    bow[:-1] = (bend[:-1] * (till - share[:-1]) ** 2)[:, None] * np.diff(places, axis=0)[leg[:-1]]
    return even_s, bow


class _Followed(NamedTuple):
    """Times (n,) and places (n, 2) of a robot, and the bends (n - 1,) of its legs."""

    times_s: Floats
    places_m: Floats
    bends: Floats


def _follow(trajectory: Trajectory, until_s: float) -> _Followed | None:
    """A robot, its loop repeated until a time and once more; None: these are too many turns."""
    times, places, loop_s = trajectory.times_s, trajectory.positions_m[:, :2], trajectory.loop_duration_s
    if loop_s == 0:
        return _Followed(times, places, trajectory.bends)
    turns = max(0, math.ceil((until_s - times[-1]) / loop_s)) + 1
    if turns * len(times) > MOST_POINTS:
        return None
    first = trajectory.loop_index + 1
    more = times[first:] + loop_s * np.arange(1, turns + 1)[:, None]
    bends = np.concatenate([trajectory.bends, np.tile(trajectory.bends[first - 1 :], turns)])
    all_places = np.vstack([places, np.tile(places[first:], (turns, 1))])
    return _Followed(np.concatenate([times, more.ravel()]), all_places, bends)
