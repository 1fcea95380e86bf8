"""An ArduCopter in mode AUTO: what it makes of a mission's waypoints, speeds and waits."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from rota.errors import RotaError
from rota.model.plan import Floats
from rota.routes.route import RouteStop
from rota.vehicles.blend_kernels import round_of
from rota.vehicles.facts import Vehicle
from rota.vehicles.kernels import GRAVITY_M_S2, Air, Control, Course, fly
from rota.vehicles.motion import Motion, Way, Wind
from rota.vehicles.scurve_kernels import LENGTH, WHOLE, Shape, legs_of, round_times
from rota.vehicles.track_kernels import nearest_m

STEP_S = 0.005  # of the control loop that flew the recorded flights
SAMPLE_STEPS = 10
SETTLE_S = 60.0  # before the round that stands for all
LONGEST_WAIT_S = 60.0  # that is flown: a copter hovers by then
MOST_FLOWN_S = 30_000.0  # 150 MB
SLACK_S, SLACK_SHARE = 60.0, 1.5  # of the time that legs take, until a copter counts as stuck
INPUT_TC_S = 0.15  # ATC_INPUT_TC
# PSC_POSXY_P, PSC_VELXY_P, _I, _D, _FLTE, ATC_INPUT_TC, ATC_ACCEL_R_MAX, ATC_SLEW_YAW: defaults of ArduCopter 4.6. The
# delay of the attitude itself is fitted to recorded flights, by which of 0, 0.02, 0.03 and 0.05 s comes nearest.
CONTROL = Control(
    position=1.0,
    velocity=2.0,
    integral=1.0,
    slope=0.5,
    filter_hz=5.0,
    lean_rise_s=INPUT_TC_S,
    lean_rad_s2=math.radians(1100),
    yaw_rad_s=math.radians(60),
    attitude_lag_s=0.02,
    lean_rad=math.radians(30),
    accel_m_s2=2.5,
    pace_s=2.5,
)
# ArduPilot's simulated quadcopter (SIM_Frame.h, default_model: 3 kg, momentum drag 0.2, disc of 0.385 m2, 15.08 m/s at
# 45 degrees and 593 m): 0.2 sqrt(rho disc thrust) / mass, and rho drag area / (2 mass), with rho 1.225 kg/m3
LINEAR_PER_S, SQUARE_PER_M = 0.2483, 0.0356
# the closed form's following lag, by the lean limit in degrees: fitted to recorded flights
LAG_AT_DEG, LAG_S3_M2 = [30.0, 45.0], [0.035, 0.016]


class ArduPilotAuto:
    """The motion model of a copter that flies missions with ArduPilot: S-curves, followed against the air.

    Waypoints without a wait are passed on a curve where two legs blend. Not modelled: gusts, batteries, the climb
    after take-off, and the first half of a corner after which another speed is set, which is flown at the new one.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        self.vehicle = vehicle
        accel, jerk = _value(vehicle, "acceleration_m_s2"), _value(vehicle, "jerk_m_s3")
        self.lean_deg = _value(vehicle, "lean_deg")
        self._control = CONTROL._replace(lean_rad=math.radians(self.lean_deg), accel_m_s2=accel, pace_s=accel / jerk)
        # WPNAV_ACCEL_C is 0 by default, which means twice the acceleration
        self._shape = Shape(jerk, 2 * INPUT_TC_S, _value(vehicle, "corner_m"), 2 * accel)
        self._climbing = np.array([_value(vehicle, "climb_m_s"), _value(vehicle, "descend_m_s")])
        self._limits = np.array([accel, _value(vehicle, "climb_m_s2")])

    def drive(self, way: Way, wind: Wind) -> Motion:
        """The copter's motion, see ``MotionModel``. Raises RotaError for a leg that the wind does not let it fly."""
        around_s = self.round_s(way)
        rounds = 1 + max(1, math.ceil(SETTLE_S / around_s)) if around_s else 0
        course, begins = self._course(way, rounds)
        if len(course.points_m) == 1:
            none = np.empty(0)
            still = {"times_s": np.zeros(1), "positions_m": course.points_m, "legs_s": none, "cut_m": none}
            return Motion(robot=way.robot, loop_start_s=0.0, **still)
        return _motion(way.robot, course, begins, *self._flown(way.robot, course, begins[-1], wind))

    def round_s(self, way: Way) -> float:
        """A round's seconds in closed form, see ``MotionModel``."""
        return float(self.legs_s(way).sum())

    def legs_s(self, way: Way) -> Floats:
        """Seconds of each leg of a round in closed form, without wind, waits before the leg included; (0,) without."""
        if not way.every_round:
            return np.empty(0)
        last = replace(way.every_round[-1], speed_m_s=None, hold_s=0.0)
        course, (_, n) = self._course(replace(way, once=(last,)), 1)
        if n < 2:
            return np.empty(0)
        waits_s = np.append(course.waits_s[n], course.waits_s[1:n])
        return np.asarray(round_times(course.points_m[: n + 1], waits_s, course.legs[:n], *self.closed_form[1:]))

    def round_times_s(self, vertices_m: Floats, speed_m_s: float) -> Floats:
        """Seconds (n,) of each leg of a round of a closed polyline (n, 2), n > 1, at one height and without waits."""
        return np.asarray(round_of(vertices_m, speed_m_s, *self.closed_form))

    @property
    def closed_form(self) -> tuple[Floats, float, Shape]:
        """What kernels are told of it: the most acceleration over the ground and of the height, lag, and shape."""
        return self._limits, float(np.interp(self.lean_deg, LAG_AT_DEG, LAG_S3_M2)), self._shape

    @property
    def most_m_s2(self) -> float:
        """The most acceleration along a leg; at corners it is twice as much."""
        return float(self._limits[0])

    @property
    def jerk_m_s3(self) -> float:
        """The jerk with which acceleration builds up, in the mean."""
        return self._shape.jerk_m_s3

    def _course(self, way: Way, rounds: int) -> tuple[Course, list[int]]:
        """So many rounds of the way, one after the other, and the numbers of the points where rounds begin and end.

        No point is like the one before. Two legs more come last, so that the last corner is like others.
        """
        usual_m_s = _value(self.vehicle, "speed_m_s")
        points: list[tuple[float, float, float]] = [way.once[0].place_m]
        speeds, waits = [], [way.once[0].hold_s]
        begins: list[int] = []

        def add(stops: tuple[RouteStop, ...]) -> None:
            for stop in stops:
                if stop.place_m == points[-1]:
                    waits[-1] += stop.hold_s
                    continue
                points.append(stop.place_m)
                speeds.append(stop.speed_m_s or usual_m_s)
                waits.append(stop.hold_s)

        add(way.once[1:])
        for _ in range(rounds):
            begins.append(len(points) - 1)
            add(way.every_round)
        begins.append(len(points) - 1)
        if rounds:
            add(way.every_round[:2])
        points_m, speeds_m_s, waits_s = (np.array(values, dtype=np.float64) for values in (points, speeds, waits))
        legs = np.asarray(legs_of(points_m, speeds_m_s, self._climbing, self._limits, self._shape))
        return Course(points_m, speeds_m_s, waits_s, legs), begins

    def _flown(self, robot: str, course: Course, end: int, wind: Wind) -> tuple[Floats, Floats, Floats]:
        """The course as it is flown: times (steps,), positions (steps, 3) then, and when points were reached, (n,).

        Of long waits the beginning is flown, and nothing changes in the rest. Raises RotaError for courses that a
        copter does not get along, and for those that take longer than any flight.
        """
        rest_s = np.maximum(course.waits_s - LONGEST_WAIT_S, 0.0)
        course = course._replace(waits_s=course.waits_s - rest_s)
        most_s = SLACK_SHARE * (self._against_wind_s(robot, course, wind) + float(course.waits_s.sum())) + SLACK_S
        if most_s > MOST_FLOWN_S:
            raise RotaError(
                f"robot {robot}: its approach and two rounds or more take some {most_s / SLACK_SHARE:.0f} s;"
                f" motion is worked out for {MOST_FLOWN_S / SLACK_SHARE:.0f} s at most"
            )
        track, reached_s = np.empty((math.ceil(most_s / STEP_S), 3)), np.zeros(len(course.points_m))
        air = Air(LINEAR_PER_S, SQUARE_PER_M, *wind.toward_m_s)
        steps = fly(course, end, self._shape, self._control, air, STEP_S, track, reached_s)
        if reached_s[end] == 0:
            late = int(np.flatnonzero(reached_s[1 : end + 1] == 0)[0]) + 1
            raise RotaError(f"robot {robot}: {self.vehicle.told} does not get to {_place(course, late)}")
        at_s = np.arange(steps + 2) * STEP_S
        waiting = np.flatnonzero(rest_s[: end + 1])
        rested_s = np.append(0.0, np.cumsum(rest_s[waiting]))
        goes_on_s = reached_s[waiting] + LONGEST_WAIT_S
        at_s += rested_s[np.searchsorted(goes_on_s, at_s)]
        reached_s += rested_s[np.searchsorted(goes_on_s, reached_s)]
        return at_s, np.vstack([course.points_m[:1], track[: steps + 1]]), reached_s

    def _against_wind_s(self, robot: str, course: Course, wind: Wind) -> float:
        """About how long the legs take in this wind. Raises RotaError for one along which it blows the copter back."""
        top_m_s, toward = self.top_airspeed_m_s, np.array(wind.toward_m_s)
        units = np.diff(course.points_m[:, :2], axis=0)
        flat_m = np.hypot(*units.T)
        units /= np.maximum(flat_m, 1e-9)[:, None]
        helps, across = units @ toward, units[:, 0] * toward[1] - units[:, 1] * toward[0]
        ground_m_s = helps + np.sqrt(np.maximum(top_m_s**2 - across**2, 0.0))
        bad = np.flatnonzero((flat_m > 0) & ((ground_m_s <= 0) | (np.abs(across) >= top_m_s)))
        if len(bad):
            k = int(bad[0])
            raise RotaError(
                f"robot {robot}: wind of {wind.speed_m_s:g} m/s from {wind.from_deg:g} degrees: {self.vehicle.told},"
                f" which makes {top_m_s:.1f} m/s through the air, cannot fly the leg to {_place(course, k + 1)}"
            )
        blown_s = course.legs[:, LENGTH] / np.maximum(ground_m_s, 0.05)
        return float(np.maximum(course.legs[:, WHOLE], blown_s).sum())

    @property
    def top_airspeed_m_s(self) -> float:
        """The speed at which drag takes all that the greatest lean gives: the root of a quadratic equation."""
        lean = math.radians(self.lean_deg)
        square, linear = SQUARE_PER_M * math.cos(lean), LINEAR_PER_S / math.sqrt(math.cos(lean))
        return (math.sqrt(linear**2 + 4 * square * GRAVITY_M_S2 * math.tan(lean)) - linear) / (2 * square)


def _value(vehicle: Vehicle, name: str) -> float:
    """A fact's value, of a vehicle that has it."""
    fact = getattr(vehicle, name)
    assert fact is not None, f"{vehicle.name} has no {name}"
    return float(fact.value)


def _place(course: Course, k: int) -> str:
    x, y, height = course.points_m[k]
    return f"({x:.1f}, {y:.1f}) m at a height of {height:.4g} m"


def _motion(robot: str, course: Course, begins: list[int], at_s: Floats, track: Floats, reached_s: Floats) -> Motion:
    """The motion of a track, which repeats its last round; what misses between its ends is spread over the round."""
    end, stays = begins[-1], len(begins) == 1
    begin = 0 if stays else begins[-2]
    begin_s, end_s = float(reached_s[begin]), float(reached_s[end])
    sampled_s = at_s[::SAMPLE_STEPS]
    times_s = np.unique(np.concatenate([sampled_s[sampled_s < end_s], [begin_s, end_s]]))
    positions_m = np.column_stack([np.interp(times_s, at_s, axis) for axis in track.T])
    if not stays:
        first = int(np.searchsorted(times_s, begin_s))
        gap_m = positions_m[first] - positions_m[-1]
        positions_m[first:] += np.outer((times_s[first:] - begin_s) / (end_s - begin_s), gap_m)
        positions_m[-1] = positions_m[first]
    passed_s = reached_s[begin : end + 1]
    # a point is nearest between the middles of the legs before it and after it
    middles_s = np.append((passed_s[1:] + passed_s[:-1]) / 2, end_s)
    return Motion(
        robot=robot,
        times_s=times_s,
        positions_m=positions_m,
        loop_start_s=end_s if stays else begin_s,
        legs_s=np.diff(passed_s),
        cut_m=np.asarray(nearest_m(track, np.searchsorted(at_s, middles_s), course.points_m[begin + 1 : end + 1])),
    )
