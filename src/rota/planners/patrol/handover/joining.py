"""When each robot comes to its place in a round that is under way, and by which way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rota.errors import PlanError
from rota.model.arrays import Floats
from rota.model.mission import Robot
from rota.model.plan import Driven, Trajectory
from rota.planners.patrol.driving.timed_line import TimedLine, start_at, steady
from rota.planners.patrol.handover.rounds import ENTRIES
from rota.planners.patrol.tolerances import SHORTEST_S, SLOWER
from rota.planners.patrol.traffic.starts.approaches import Approach, first_step_m, joined_trajectory, timed_approach
from rota.planners.patrol.traffic.starts.assignment import earliest_assignment
from rota.planners.patrol.traffic.starts.paths_by_body import PathsByBody


@dataclass(frozen=True, kw_only=True, eq=False)
class Standing:
    """A robot and where it is when the plan takes over, (2,) metres, and in which direction it drove last, if any."""

    robot: Robot
    place_m: Floats
    heading_rad: float | None = None

    def turning_s(self, onward_m: Floats | None) -> float:
        """How long it takes to turn on the spot towards a place (2,)."""
        rate = self.robot.turn_rate_rad_s
        if rate is None or self.heading_rad is None or onward_m is None:
            return 0.0
        ahead = onward_m - self.place_m
        turn = abs((math.atan2(ahead[1], ahead[0]) - self.heading_rad + math.pi) % (2 * math.pi) - math.pi)
        return turn / (rate * SLOWER)


class Entries:
    """How far robots are from the places of one round at which they may come into it."""

    def __init__(self, line: TimedLine, standing: Sequence[Standing], paths_by_body: PathsByBody) -> None:
        self.line, self.standing, self._paths_by_body = line, standing, paths_by_body
        self.phases_s = np.zeros(1) if line.stays else np.linspace(0, line.duration_s, ENTRIES, endpoint=False)
        self.places_m = line.places_m[:1] if line.stays else line.at(self.phases_s)
        ways_m = [
            paths_by_body.paths(one.robot.body_radius_m).distances(
                paths_by_body.standing(one.robot, one.place_m)[None], self.places_m
            )[0]
            for one in standing
        ]
        speeds = np.array([one.robot.ground_speed_m_s for one in standing])
        self.travel_s = np.array(ways_m).reshape(len(standing), -1) / speeds[:, None]

    def moments_s(self, k: int, phase_s: float) -> Floats:
        """When the k-th robot can be at each of the places (e,) in time for one who is that far round at the time 0."""
        if self.line.stays:
            return np.asarray(self.travel_s[k])
        first_s = (self.phases_s - phase_s) % self.line.duration_s
        late = np.ceil(np.maximum(0.0, self.travel_s[k] - first_s) / self.line.duration_s)
        with np.errstate(invalid="ignore"):
            return np.asarray(np.where(np.isfinite(late), first_s + late * self.line.duration_s, np.inf))

    def earliest_s(self, phases_s: Sequence[float]) -> Floats:
        """When each robot can be in each of the places in the round, (robots, phases)."""
        return np.array([[self.moments_s(k, phase).min() for phase in phases_s] for k in range(len(self.standing))])

    def join(self, k: int, phase_s: float) -> Trajectory | None:
        """The trajectory of the k-th robot into the round, as far round as one who is that far at the time 0."""
        moments_s, one = self.moments_s(k, phase_s), self.standing[k]
        best, best_s = None, math.inf
        tried, from_s = 0, 0.0
        for entry in np.argsort(moments_s, kind="stable"):
            joins_s = float(moments_s[entry])
            if not math.isfinite(joins_s) or tried == 6:  # a robot that turns slowly came too late at six places
                break
            if joins_s < from_s:
                continue
            tried += 1
            round_ = self.line if self.line.stays else start_at(self.line, float(self.phases_s[entry]))
            approach = self._approach(one, round_)
            turning_s = one.turning_s(
                first_step_m(approach.places_m if len(approach.places_m) > 1 else round_.places_m)
            )
            least_s = turning_s + approach.duration_s
            if least_s > joins_s + SHORTEST_S and not self.line.stays:
                from_s = (joins_s + least_s) / 2  # what comes by sooner is missed as well, but for other turns
                joins_s += math.ceil((least_s - joins_s) / self.line.duration_s) * self.line.duration_s
                if joins_s < best_s:
                    best_s, best = joins_s, (approach, turning_s, round_)
                continue
            joins_s = max(joins_s, least_s)
            if joins_s < best_s:
                best_s, best = joins_s, (approach, turning_s, round_)
            break
        if best is None:
            return None
        approach, turning_s, round_ = best
        best_s = best_s if best_s > SHORTEST_S else 0.0
        leaves_s = turning_s if one.robot.body_radius_m == 0 else best_s - approach.duration_s
        try:
            return joined_trajectory(one.robot.name, approach, leaves_s, best_s, round_)
        except PlanError:  # a way so short that its times are one but for rounding
            return None

    def _approach(self, one: Standing, round_: TimedLine) -> Approach:
        """The way from where a robot is to where a round begins."""
        onward_m = first_step_m(round_.places_m)
        if math.dist(one.place_m, round_.places_m[0]) <= 5e-7:  # it is there already
            return Approach(line=steady(np.zeros(1), round_.places_m[:1]))
        line_m = self._paths_by_body.line(one.robot, one.place_m, round_.places_m[0], onward_m, one.heading_rad)
        return timed_approach(line_m, one.robot, onward_m)


def join_evenly(entries: Entries, phase_s: float) -> tuple[Trajectory, ...] | None:
    """All robots into one round, evenly spaced, the first that far round at the time 0; None where one cannot come."""
    robots, duration_s = len(entries.standing), entries.line.duration_s
    return join_at(entries, [phase_s + k * duration_s / robots for k in range(robots)])


def join_at(entries: Entries, phases_s: Sequence[float]) -> tuple[Trajectory, ...] | None:
    """All robots into one round, each as far round as one of these at the time 0, of which there may be more.

    Who takes which: so that the last is there as early as it can be. None where one cannot come.
    """
    who = earliest_assignment(entries.earliest_s(phases_s).T)
    if who is None:
        return None
    joined = [entries.join(k, phases_s[int(which)]) for k, which in enumerate(who)]
    return None if any(one is None for one in joined) else tuple(one for one in joined if one is not None)


def heading_of(driven: Driven) -> float | None:
    """The direction of what was driven last, in rad; None where nothing was."""
    steps = np.diff(driven.positions_m, axis=0)
    moved = np.flatnonzero((steps != 0).any(axis=1))
    return float(np.arctan2(steps[moved[-1], 1], steps[moved[-1], 0])) if len(moved) else None


def stand_by(one: Standing) -> Trajectory:
    """A robot that stays where it is."""
    return Trajectory(robot=one.robot.name, times_s=np.zeros(1), positions_m=one.place_m[None])
