"""Where on its round a copter is late for its plan, by its firmware and by nothing else.

A copter falls behind what it is to follow at sharp corners, by up to a second and a half, and makes it up on the rest
of its round: a plan spreads over the round what all of its corners cost. A copter that is late by as much as that is
in phase; it is where every other robot on that loop is, as late as it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from rota.errors import RotaError
from rota.model.fleet import Robot
from rota.model.plan import Floats, Plan, Trajectory, Waypoints
from rota.routes.driven_route import from_start
from rota.routes.route import route_of
from rota.vehicles.models import MODELS
from rota.vehicles.motion import Motion, Way, Wind
from rota.vehicles.presets import vehicle_within

APART_S, STEP_S = 0.5, 0.05  # of places whose lags are kept, and of the motion that is searched for them
RISES_M = 1e-9  # each step, of what is got along a leg, where it stands still or goes back


@dataclass(frozen=True, kw_only=True, eq=False)
class ExpectedLags:
    """Where on its round a copter is late while all goes well: ``lags_s`` (n,) at ``at_s`` (n,), rising, of its plan.

    slowest_m_s (n,): how slow it becomes until the next. starts_s: how long after its plan it is to leave its first
    waypoint, to be as late as others that come past it. pace: the share of its plan's pace at which it flies a round.
    """

    at_s: Floats
    lags_s: Floats
    slowest_m_s: Floats
    round_s: float
    starts_s: float
    pace: float

    def at(self, plan_s: float) -> float:
        """Seconds by which it is behind where the plan has it at this time, in any round."""
        return float(np.interp(plan_s, self.at_s, self.lags_s, period=self.round_s))

    def least_m_s(self, from_s: float, until_s: float) -> float:
        """How slow it becomes from one time of its plan to another, in m/s."""
        looked_s = np.append(np.arange(from_s, until_s, APART_S / 2), until_s)
        begun_s = self.at_s[0] + np.mod(looked_s - self.at_s[0], self.round_s)
        return float(self.slowest_m_s[np.searchsorted(self.at_s, begun_s, side="right") - 1].min())


def expected_lags(plan: Plan) -> dict[str, ExpectedLags]:
    """Of each robot of which it is known. All are shifted by as much, so that the first starts when its plan does."""
    fleet = plan.mission.fleet
    found = {way.robot: lags_on_round(way, fleet.robot(way.robot), fleet.altitude_m) for way in plan}
    known = {name: lags for name, lags in found.items() if lags is not None}
    first_s = min((lags.starts_s for lags in known.values()), default=0.0)
    return {
        name: replace(lags, lags_s=lags.lags_s - first_s, starts_s=lags.starts_s - first_s)
        for name, lags in known.items()
    }


def lags_on_round(trajectory: Trajectory, robot: Robot, altitude_m: float) -> ExpectedLags | None:
    """Where it is later than the plan has it; None: it has no waypoints, or nobody knows what it makes of them.

    Lags are 0 in the mean over a round, so that robots on one loop agree on them wherever each begins.
    """
    told, motion = trajectory.waypoints, robot.motion
    if told is None or motion.vehicle not in MODELS or len(told.places_m) < 2:
        return None
    route, round_s = route_of(trajectory, altitude_m), trajectory.loop_duration_s
    way = Way(robot=robot.name, once=from_start(route), every_round=route.every_round)
    try:
        flown = MODELS[motion.vehicle](vehicle_within(motion)).drive(way, Wind())
    except RotaError:
        return None  # a round that is longer than motion is worked out for
    # what a whole round is longer by is no lag, but a slower pace
    pace = round_s / flown.round_s
    at_s, lags_s, slowest_m_s = (
        np.concatenate(part) for part in zip(*_legs(trajectory, told, flown, pace), strict=True)
    )
    mean_s = float(np.trapezoid(np.append(lags_s, lags_s[0]), np.append(at_s, at_s[0] + round_s))) / round_s
    lags_s -= mean_s
    # the first leg begins at rest: only its end is where others come past as late as on any round
    starts_s = float(np.interp(told.times_s[1], at_s, lags_s, period=round_s))
    return ExpectedLags(
        at_s=at_s, lags_s=lags_s, slowest_m_s=slowest_m_s, round_s=round_s, starts_s=starts_s, pace=pace
    )


def _legs(
    trajectory: Trajectory, told: Waypoints, flown: Motion, pace: float
) -> Iterator[tuple[Floats, Floats, Floats]]:
    """Of each leg of a round, from the first waypoint on: times of the plan, seconds later at these places, and m/s.

    Plan and motion are as far as they have got along the straight leg. Lags count from the first waypoint.
    """
    round_s = trajectory.loop_duration_s
    # it leaves its first waypoint from rest; on its rounds it passes it when it is back there
    passed_s = np.append(told.times_s[-1] - round_s, told.times_s[1:])
    # the rounds of its motion begin at the second waypoint
    reached_s = np.append(0.0, np.cumsum(np.roll(flown.legs_s, 1))) + flown.loop_start_s + flown.round_s
    reached_s -= float(flown.legs_s[-1])
    places_m = np.vstack([told.places_m, told.places_m[:1]])
    for k in range(len(places_m) - 1):
        along = places_m[k + 1] - places_m[k]
        along /= math.hypot(*along)
        at_s = np.arange(passed_s[k], passed_s[k + 1] - APART_S / 2, APART_S)
        on_loop_s = np.where(at_s < trajectory.loop_start_s, at_s + round_s, at_s)
        planned_m = (trajectory.at(on_loop_s)[:, :2] - places_m[k]) @ along
        moves_s = np.arange(reached_s[k], reached_s[k + 1] + STEP_S, STEP_S)
        moves_m = flown.at(moves_s)[:, :2]
        got_m = np.maximum.accumulate((moves_m - places_m[k]) @ along) + RISES_M * np.arange(len(moves_s))
        there_s = np.interp(planned_m, got_m, moves_s)
        speeds_m_s = np.hypot(*np.gradient(moves_m, STEP_S, axis=0).T)
        first = np.minimum(np.searchsorted(moves_s, there_s), len(moves_s) - 1)
        later_s = (there_s - reached_s[0]) * pace - (at_s - passed_s[0])
        yield at_s, later_s, np.minimum.reduceat(speeds_m_s, first)
