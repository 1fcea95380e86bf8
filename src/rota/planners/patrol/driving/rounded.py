"""Robots with limited accelerations: corners rounded or stopped at, legs with ramps."""

from __future__ import annotations

import functools
import math

import numpy as np

from rota.model.arrays import Floats
from rota.model.mission import Robot
from rota.planners.patrol.driving import rounded_kernels as kernels
from rota.planners.patrol.driving.corner_costs import (
    LONGEST_REACHES,
    CornerCosts,
    blind_m,
    no_table,
    pace_on_lanes,
    quarter_turn_m,
)
from rota.planners.patrol.driving.polylines import way_beside, without_straight_vertices
from rota.planners.patrol.driving.speed_kernels import BESIDE, Row, slopes
from rota.planners.patrol.driving.timed_line import TimedLine, steady
from rota.planners.patrol.tolerances import OFF_M, SLOWER, TO_SPARE

STRAIGHT_RAD = 1e-5  # who turns less would turn in less time than a plan tells; that is off by less than a millimetre


class Rounded:
    """What a robot with mass can do; see ``Driving``."""

    has_mass = True

    def __init__(self, robot: Robot) -> None:
        motion = robot.motion
        assert motion.acceleration_m_s2 is not None, f"{robot.name} has no mass"
        self.robot = robot
        corner = motion.corner_acceleration_m_s2 or motion.acceleration_m_s2
        rate = robot.turn_rate_rad_s
        self.limits = kernels.Limits(
            speed_m_s=robot.ground_speed_m_s * SLOWER,
            along_m_s2=motion.acceleration_m_s2 * (1 - TO_SPARE),
            corner_m_s2=corner * (1 - TO_SPARE),
            jerk_m_s3=math.inf if motion.jerk_m_s3 is None else motion.jerk_m_s3 * (1 - TO_SPARE),
            cut_m=float(motion.corner_m),
            turn_s=0.0 if rate is None else 1 / (rate * SLOWER),
        )
        self.step_s = 2 * math.sqrt(2 * OFF_M / self.limits.corner_m_s2)
        self.off_m = min(self.limits.cut_m, self.limits.speed_m_s**2 / (2 * self.limits.corner_m_s2))
        self.blind_m = blind_m(self.off_m)
        self.pace_m_s = robot.ground_speed_m_s
        self.pace_m_s = pace_on_lanes(self)
        longest_m = LONGEST_REACHES * robot.sensor.reach_m
        top_m_s, along_m_s2, across_m_s2, jerk_m_s3, cut_m, turn_s = self.limits
        limits = [top_m_s**2, along_m_s2, across_m_s2, cut_m, along_m_s2 / jerk_m_s3, turn_s, self.pace_m_s]
        self.corner_costs = CornerCosts(
            turn_m=0.0, arc_m=0.0, table=no_table(), longest_m=longest_m,
            quarter_turn_m=quarter_turn_m(self, longest_m), limits=np.array(limits),
        )  # fmt: skip

    def round_m(self, vertices_m: Floats) -> float:
        """Metres of a round; see ``Driving``."""
        vertices_m = without_straight_vertices(vertices_m, STRAIGHT_RAD)
        if len(vertices_m) == 1:
            return 0.0
        return float(kernels.round_s(vertices_m, self.limits)) * self.pace_m_s

    def driven(self, vertices_m: Floats) -> tuple[Floats, Floats]:
        """Its way, and beside what of the polyline it is; see ``Driving``."""
        return way_beside(vertices_m, self._rows, STRAIGHT_RAD)

    def timed(self, vertices_m: Floats) -> TimedLine:
        """One round as fast as it can be driven; it begins and ends where the rounding of the first corner ends."""
        vertices_m = without_straight_vertices(vertices_m, STRAIGHT_RAD)
        if len(vertices_m) == 1:
            return steady(np.zeros(1), vertices_m)
        return _line(self._rows(vertices_m))

    def slopes(self, vertices_m: Floats) -> tuple[Floats, Floats]:
        """What moves of vertices cost; see ``Driving``."""
        ring = np.zeros((len(Row), len(vertices_m)))
        ring[:2] = vertices_m.T
        growth, bends = np.zeros_like(vertices_m), np.zeros_like(vertices_m)
        if len(vertices_m) > 2:
            moved_m = 0.02
            slopes(ring, np.zeros((len(Row), 2 * BESIDE + 1)), self.corner_costs.limits, moved_m, growth, bends)
        return growth, bends

    def _rows(self, corners_m: Floats) -> Floats:
        return np.asarray(kernels.timed_rows(corners_m, True, self.step_s, self.limits))

    def way(self, line_m: Floats, *, cuts: bool = False) -> TimedLine:
        """A way along an open polyline (n, 2) without legs of no length, from rest to rest; it stops at its corners.

        cuts: or cuts them, as on rounds.
        """
        limits = self.limits if cuts else self.limits._replace(cut_m=0.0)
        return _line(kernels.timed_rows(line_m, False, self.step_s, limits))

    def run_up(self, place_m: Floats, direction: Floats, speed_m_s: float) -> TimedLine:
        """A start from rest that gets to a place (2,), in a direction (2,) of length 1, at a speed; one row for 0."""
        if speed_m_s < 1e-3:  # at rest
            return steady(np.zeros(1), place_m[None])
        return _line(kernels.run_up(*place_m, *direction, min(speed_m_s, self.limits.speed_m_s), self.limits))


@functools.lru_cache(maxsize=64)
def driving_with_mass(robot: Robot) -> Rounded:
    """What a robot with mass can do: made once for all its ways."""
    return Rounded(robot)


def _line(rows: Floats) -> TimedLine:
    return TimedLine(rows[:, 0].copy(), rows[:, 1:3].copy(), rows[1:, 3].copy())
