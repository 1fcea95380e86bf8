"""Robots that change speed at once: turns on the spot take their time, turns on arcs their way."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from rota.model.arrays import Floats
from rota.model.mission import Robot
from rota.planners.patrol.driving.corner_costs import CornerCosts, Slopes, no_table
from rota.planners.patrol.driving.polylines import STRAIGHT_RAD, keeps_radius, turns_rad, without_straight_vertices
from rota.planners.patrol.driving.timed_line import TimedLine, steady
from rota.planners.patrol.tolerances import SAME_TIME_S, SLOWER

KINK_RAD = 1e-3  # a straighter vertex turns more whichever way it goes
SLOW_LEG_M = 1e-5  # shorter legs take the time of this one: they would be timed to fewer digits than the check asks


class AtOnce:
    """What a robot without mass can do; see ``Driving``."""

    has_mass = False
    off_m = 0.0
    blind_m = 0.0

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.pace_m_s = robot.ground_speed_m_s
        rate, radius_m = robot.turn_rate_rad_s, robot.turn_radius_m
        # a turn back past the end of a long leg, in a half circle, takes (pi - 2) times its radius more than the leg
        turn_m = (1 - 2 / math.pi) * radius_m if rate is None else robot.ground_speed_m_s / rate
        self.corner_costs = CornerCosts(
            turn_m=turn_m, arc_m=radius_m, table=no_table(), longest_m=1.0, quarter_turn_m=math.pi / 2 * turn_m
        )

    def round_m(self, vertices_m: Floats) -> float:
        """Metres of a round; see ``Driving``."""
        legs = np.diff(np.vstack([vertices_m, vertices_m[:1]]), axis=0)
        lengths = np.hypot(legs[:, 0], legs[:, 1])
        if self.corner_costs.arc_m > 0 and keeps_radius(vertices_m, self.corner_costs.arc_m):
            return float(lengths.sum())  # its turns are in its legs
        turns = turns_rad(vertices_m)
        turning_m = self.corner_costs.turn_m * float(turns.sum())
        return float(lengths.sum()) + turning_m + spool_m(lengths, turns, self.robot.turn_radius_m)

    def driven(self, vertices_m: Floats) -> tuple[Floats, Floats]:
        """The polyline itself; see ``Driving``."""
        legs = np.arange(len(vertices_m))
        return np.vstack([vertices_m, vertices_m[:1]]), np.column_stack([legs, legs + 1]).astype(np.float64)

    @property
    def slopes(self) -> Slopes | None:
        """Of robots that turn on the spot; see ``Driving``. Others need none: their ways are as long as their legs."""
        if self.robot.turn_rate_rad_s is None:
            return None
        return partial(turning_slopes, turn_m=self.corner_costs.turn_m)

    def timed(self, vertices_m: Floats) -> TimedLine:
        """One round at full speed, turning at each corner included; it begins and ends on the first vertex."""
        vertices_m = without_straight_vertices(vertices_m)
        if len(vertices_m) == 1:
            return steady(np.zeros(1), vertices_m)
        line_m, turns = np.vstack([vertices_m, vertices_m[:1]]), np.roll(turns_rad(vertices_m), -1)
        return timed_line(line_m, turns, self.robot, least_s=SLOW_LEG_M / self.robot.ground_speed_m_s)


def timed_line(line_m: Floats, turns: Floats, robot: Robot, *, least_s: float = 0.0) -> TimedLine:
    """An open polyline (n, 2) without legs of no length as it is driven at full speed.

    turns (n - 1,): the angles in radians by which the robot turns at each point but the first. least_s: no leg is
    driven in less time.
    """
    travel_s = np.maximum(np.hypot(*np.diff(line_m, axis=0).T) / (robot.ground_speed_m_s * SLOWER), least_s)
    turn_s = np.zeros(len(travel_s))
    if robot.turn_rate_rad_s is not None:
        # what rounding leaves of going straight on is no turn, and any other lasts until a later moment
        turn_s = np.maximum(turns / (robot.turn_rate_rad_s * SLOWER), SAME_TIME_S) * (turns > STRAIGHT_RAD)
    # one row on arrival at each point, one more when turning there takes time
    steps = np.column_stack([travel_s, turn_s]).ravel()
    keep = steps > 0
    return steady(
        np.concatenate([[0.0], np.cumsum(steps[keep])]), np.vstack([line_m[:1], np.repeat(line_m[1:], 2, 0)[keep]])
    )


def spool_m(lengths_m: Floats, turns: Floats, radius_m: float) -> float:
    """Metres that arcs add beyond their turns: where legs are too short for a turn, a robot goes round up to once more.

    lengths_m (n,): of the legs from each vertex on. turns (n,): in rad, at the vertices. An arc through a turn takes
    radius * tan(turn / 2) of each leg; where half of the shorter leg is less, a share of a full circle is counted.
    """
    if radius_m == 0 or len(turns) < 2:
        return 0.0
    need_m = 2 * radius_m * np.tan(np.minimum(turns, math.pi / 2) / 2)
    short_m = np.minimum(lengths_m, np.roll(lengths_m, 1))
    tight = short_m < need_m
    return float(2 * math.pi * radius_m * (1 - short_m[tight] / need_m[tight]).sum())


def turning_slopes(vertices_m: Floats, *, turn_m: float) -> tuple[Floats, Floats]:
    """What moves of vertices (n, 2) cost a robot that turns on the spot, each radian as much as ``turn_m``.

    Twice (n, 2), see ``Driving.slopes``. A leg that swings adds its angle to one turn and takes it from the other: a
    round changes by what it adds where the two bend opposite ways, and not at all where they bend the same way.
    """
    along = np.roll(vertices_m, -1, axis=0) - vertices_m
    lengths_m = np.maximum(np.hypot(*along.T), 1e-12)[:, None]
    along /= lengths_m
    before = np.roll(along, 1, axis=0)
    turns = np.arctan2(before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0], (before * along).sum(axis=1))
    bent = np.where(np.abs(turns) > KINK_RAD, np.sign(turns), 0.0)
    swing = np.column_stack([-along[:, 1], along[:, 0]]) / lengths_m  # of a leg in rad, for a metre of its end
    turning = turn_m * (bent - np.roll(bent, -1))[:, None] * swing
    growth = before - along + np.roll(turning, 1, axis=0) - turning
    straight, after = (bent == 0)[:, None], np.abs(swing)
    own = after + np.roll(after, 1, axis=0)
    beside = after * np.roll(straight, -1, axis=0) + np.roll(after, 1, axis=0) * np.roll(straight, 1, axis=0)
    return growth, turn_m * straight * (own + beside)
