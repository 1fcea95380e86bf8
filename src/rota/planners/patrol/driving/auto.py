"""Copters that fly missions with ArduPilot: S-curves that blend at corners, by the vehicle's own closed form."""

from __future__ import annotations

import math

import numpy as np

from rota.model.arrays import Floats
from rota.model.mission import Robot
from rota.model.plan import Trajectory, Waypoints
from rota.model.trajectory import forward_accelerations
from rota.planners.patrol.driving.corner_costs import (
    LONGEST_REACHES,
    CornerCosts,
    blind_m,
    pace_on_lanes,
    quarter_turn_m,
)
from rota.planners.patrol.driving.polylines import way_beside, without_straight_vertices
from rota.planners.patrol.driving.timed_line import TimedLine, start_at, steady
from rota.planners.patrol.tolerances import OFF_M, SAME_TIME_S
from rota.vehicles.ardupilot_auto import ArduPilotAuto
from rota.vehicles.blend_kernels import SLIVER, blends_of, corner_table, from_rest, sampled_round


class Auto:
    """What such a copter can do; see ``Driving``."""

    has_mass, slopes = True, None

    def __init__(self, robot: Robot, model: ArduPilotAuto) -> None:
        self.robot, self.model = robot, model
        corner_m = robot.motion.corner_m
        self.off_m = min(corner_m, robot.ground_speed_m_s**2 / (2 * model.most_m_s2))
        self.blind_m = blind_m(self.off_m)
        self._chord_s = 2 * math.sqrt(2 * OFF_M / (2 * model.most_m_s2))
        self.pace_m_s = robot.ground_speed_m_s
        self.pace_m_s = pace_on_lanes(self)
        longest_m = LONGEST_REACHES * robot.sensor.reach_m
        table = corner_table(longest_m, robot.ground_speed_m_s, self.pace_m_s, *self.model.closed_form)
        straight = self.pace_m_s / robot.ground_speed_m_s - 1
        self.corner_costs = CornerCosts(
            turn_m=0.0, arc_m=0.0, table=table, longest_m=longest_m, straight=straight,
            quarter_turn_m=quarter_turn_m(self, longest_m),
        )  # fmt: skip

    def round_m(self, vertices_m: Floats) -> float:
        """Metres of a round; see ``Driving``."""
        vertices_m = without_straight_vertices(vertices_m)
        if len(vertices_m) == 1:
            return 0.0
        return float(self.model.round_times_s(vertices_m, self.robot.ground_speed_m_s).sum()) * self.pace_m_s

    def driven(self, vertices_m: Floats) -> tuple[Floats, Floats]:
        """Its way, and beside what of the polyline it is; see ``Driving``."""
        return way_beside(vertices_m, self._rows)

    def timed(self, vertices_m: Floats) -> TimedLine:
        """One round, which begins and ends as the leg from the first corner begins."""
        vertices_m = without_straight_vertices(vertices_m)
        if len(vertices_m) == 1:
            return steady(np.zeros(1), vertices_m)
        rows = self._rows(vertices_m)
        times_s, places_m = rows[:, 0].copy(), rows[:, 1:3].copy()
        return TimedLine(times_s, places_m, forward_accelerations(times_s, places_m, rows[1:, 3]))

    def begin_at_a_corner(self, robot: str, vertices_m: Floats, phase_s: float) -> Trajectory | None:
        """A robot that goes round for ever, ``phase_s`` into its round at time 0, as its autopilot can begin it.

        It stands at the next corner until the leg from there is to begin, and is in phase from the end of that corner
        on. None: it has no way to go.
        """
        corners_m, speed = without_straight_vertices(vertices_m), self.robot.ground_speed_m_s
        if len(corners_m) == 1:
            return None
        line = self.timed(corners_m)
        times = np.asarray(blends_of(corners_m, speed, *self.model.closed_form)) * (1.0, 1.0)
        slower = line.duration_s / float(times[-1, 0])
        times *= slower
        phase_s %= line.duration_s
        k = int(np.searchsorted(times[:, 0], phase_s - SAME_TIME_S)) % len(corners_m)
        leaves_s = max(float(times[k, 0]) - phase_s, 0.0) if k else line.duration_s - phase_s
        leaves_s = 0.0 if leaves_s > line.duration_s - SAME_TIME_S else leaves_s
        blend_s = max(float(times[k, 1]), 0.05)
        nearest_s = line.times_s[np.argmin(np.abs(line.times_s - times[k, 0] - blend_s))]
        if abs(nearest_s - times[k, 0] - blend_s) < SLIVER * self._chord_s:
            blend_s = float(nearest_s - times[k, 0])  # no leg of hardly any length after it
        limits, _, shape = self.model.closed_form
        # speeds are then so near to the S-curve that no acceleration is too great
        pieces = 4 * max(1, math.ceil(blend_s / self._chord_s))
        starts = np.asarray(from_rest(corners_m, k, blend_s / slower, pieces, speed, limits, shape))
        along_m = np.roll(corners_m, -1, axis=0)[k] - corners_m[k]
        along_m /= np.hypot(*along_m)
        goes_on = start_at(line, float(times[k, 0]) + blend_s)
        unhurried = 1 + 3e-3  # times as long: what samples of a start are off then exceeds no limit
        lasts_s = blend_s / pieces * unhurried
        begun_s = leaves_s + lasts_s * np.arange(1, pieces + 1)
        begun_m = corners_m[k] + starts[1:, :1] * along_m
        begun_m[-1] = goes_on.places_m[0]
        lengths_m = np.hypot(*np.diff(np.vstack([corners_m[k], begun_m]), axis=0).T)
        most = 2 * lengths_m / lasts_s**2
        changes = np.clip(np.diff(starts[:, 1]) / slower / unhurried / lasts_s, -most, most)
        waits = [leaves_s] if leaves_s > 0 else []
        passed_s = times[:-1, 0] + times[:-1, 1] / 2 - times[k, 0]
        passed_s = leaves_s + np.roll(passed_s % line.duration_s, -k)
        return Trajectory(
            robot=robot,
            times_s=np.concatenate([[0.0], waits, begun_s, begun_s[-1] + goes_on.times_s[1:]]),
            positions_m=np.vstack([corners_m[[k] * (1 + len(waits))], begun_m, goes_on.places_m[1:]]),
            accelerations_m_s2=np.concatenate([0.0 * np.array(waits), changes, goes_on.accelerations_m_s2]),
            waypoints=Waypoints(
                places_m=np.roll(corners_m, -k, axis=0),
                times_s=np.concatenate([[leaves_s], passed_s[1:], [passed_s[0] + line.duration_s]]),
                speed_m_s=speed,
            ),
            loop_start_s=float(begun_s[-1]),
        )

    def _rows(self, corners_m: Floats) -> Floats:
        # a leg of constant acceleration is off a motion with jerk j by up to j t^3 / 31; along straight ways by a tenth
        # of what is allowed, since an acceleration near the limit leaves jumps no room
        straight_s = (31 * (OFF_M / 10) / (math.pi / 2 * self.model.jerk_m_s3)) ** (1 / 3)
        round_s = self.round_m(corners_m) / self.pace_m_s
        speed = self.robot.ground_speed_m_s
        return np.asarray(sampled_round(corners_m, speed, round_s, self._chord_s, straight_s, *self.model.closed_form))
