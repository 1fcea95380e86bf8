"""How far behind its plan's clock a copter is at each corner of its mission, by its firmware and by nothing else.

A copter falls behind what it is to follow at sharp corners, by up to a second and a half, and makes it up on the rest
of its round: a plan spreads over the round what all of its corners cost. A copter that is late by as much as that is
in phase; it is where every other robot on that loop is, as late as it is.
"""

from __future__ import annotations

import numpy as np

from rota.model.fleet import Robot
from rota.model.plan import Floats, Trajectory
from rota.routes.driven_route import from_start
from rota.routes.route import route_of
from rota.vehicles.models import MODELS
from rota.vehicles.motion import Way, Wind
from rota.vehicles.presets import vehicle_within


def expected_lags_s(trajectory: Trajectory, robot: Robot, altitude_m: float) -> Floats | None:
    """Seconds (n + 1,) by which it passes its waypoints, and the first again, after the plan's time.

    They are 0 in the mean over a round, so that robots on one loop agree on them wherever each begins. None: it has no
    waypoints, or its firmware is not modelled.
    """
    told, motion = trajectory.waypoints, robot.motion
    if told is None or motion.vehicle not in MODELS or len(told.places_m) < 2:
        return None
    route = route_of(trajectory, altitude_m)
    way = Way(robot=robot.name, once=from_start(route), every_round=route.every_round)
    # its rounds begin at the second waypoint
    flown_s = np.roll(MODELS[motion.vehicle](vehicle_within(motion)).drive(way, Wind()).legs_s, 1)
    flown_s *= (
        trajectory.loop_duration_s / flown_s.sum()
    )  # what a whole round is longer by is no lag, but a slower pace
    planned_s = np.diff(told.times_s)
    # in its first round it begins at rest; a round takes what is left of the loop's time for that leg
    planned_s[0] = trajectory.loop_duration_s - planned_s[1:].sum()
    lags_s = np.concatenate([[0.0], np.cumsum(flown_s - planned_s)])
    return np.asarray(lags_s - lags_s[1:] @ flown_s / flown_s.sum())
