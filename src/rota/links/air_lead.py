"""Targets that a copter follows against the air: beside the way, by as much as it would else be off on the other side.

An ArduCopter's controllers know nothing of drag. At 8 m/s it takes 4 m/s2 to hold the speed, and at a corner that
turns with the way; until the integral of the velocity controller has learned the new one, the copter is off by up to a
metre. And what is asked for comes a little later, by which curves are begun too late. Both are known beforehand. With u
the acceleration that is needed beside the one of the way, and d by how much the target is put off its place,

    d'' + D (d'' + X d') + P (d' + X d) + I (integral of d' + X d) = u

with the gains of the position controller, X, and of the velocity controller, P, I and D: the controllers then ask for u
by themselves, and the copter stays on its way (the inverse of the disturbance response, as in feed-forward by a model
of the plant: Franklin, Powell, Emami-Naeini, "Feedback Control of Dynamic Systems"). Where u stays, d comes to 0: the
copter's own integral holds the drag by then.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from rota.model.plan import Floats
from rota.vehicles.ardupilot_auto import CONTROL, LINEAR_PER_S, SQUARE_PER_M
from rota.vehicles.kernels import GRAVITY_M_S2

LATER_S = 0.2  # by which an ArduCopter accelerates after it is asked to: ATC_INPUT_TC, motors, and the target's own age
STEP_S = 0.02
GAINS = ("PSC_POSXY_P", "PSC_VELXY_P", "PSC_VELXY_I", "PSC_VELXY_D")


class Gains(NamedTuple):
    """Those of an ArduCopter's horizontal controllers: of the position in 1/s, and of the velocity."""

    position: float = CONTROL.position
    velocity: float = CONTROL.velocity
    integral: float = CONTROL.integral
    slope: float = CONTROL.slope


class Drag(NamedTuple):
    """Of the air, as a deceleration: ``linear`` v + ``square`` v^2."""

    linear_per_s: float = LINEAR_PER_S
    square_per_m: float = SQUARE_PER_M

    def at(self, velocity_m_s: Floats) -> Floats:
        """What holds a velocity (2,), in m/s2."""
        speed = math.hypot(*velocity_m_s)
        return velocity_m_s * (self.linear_per_s + self.square_per_m * speed)


def drag_of(top_airspeed_m_s: float, lean_deg: float) -> Drag:
    """As much as a lean of so many degrees holds at the top airspeed, with the parts of ArduPilot's quadcopter."""
    usual = Drag()
    most = GRAVITY_M_S2 * math.tan(math.radians(lean_deg))
    share = most / (usual.linear_per_s * top_airspeed_m_s + usual.square_per_m * top_airspeed_m_s**2)
    return Drag(usual.linear_per_s * share, usual.square_per_m * share)


def gains_of(parameters: Mapping[str, float]) -> Gains:
    """Those that a vehicle's parameters tell; the usual ones for those that it does not have, or without which it
    would not come to its place: all but the last must be more than 0."""
    told = {name: value for name in GAINS if (value := parameters.get(name, 0.0)) > 0 or name == GAINS[-1]}
    usual = zip(GAINS, Gains(), strict=True)
    return Gains(*(told[name] if name in parameters and name in told else value for name, value in usual))


class AirLead:
    """By how much one copter's target is off its way, (2,) each: ``off_m``, ``velocity_m_s``, ``acceleration_m_s2``."""

    def __init__(self, gains: Gains, drag: Drag) -> None:
        self._gains, self._drag = gains, drag
        self.begin()

    def begin(self) -> None:
        """From rest, on the way."""
        self.off_m, self.velocity_m_s, self.acceleration_m_s2 = np.zeros(2), np.zeros(2), np.zeros(2)
        self._integral, self._needed = np.zeros(2), np.zeros(2)

    def step(self, passed_s: float, velocity_m_s: Floats, turned_m_s2: Floats) -> None:
        """Go on by so long. velocity_m_s (2,): of the way ``LATER_S`` from now; turned_m_s2: by how much its
        acceleration is another one then."""
        parts = max(1, math.ceil(passed_s / STEP_S))
        for _ in range(parts):
            self._go_on(passed_s / parts)
        self._needed = self._drag.at(velocity_m_s) + turned_m_s2
        self.acceleration_m_s2 = self._asked()

    def _asked(self) -> Floats:
        gains = self._gains
        slow = gains.velocity * self._error() + gains.integral * self._integral
        return np.asarray((self._needed - gains.slope * gains.position * self.velocity_m_s - slow) / (1 + gains.slope))

    def _error(self) -> Floats:
        return np.asarray(self.velocity_m_s + self._gains.position * self.off_m)

    def _go_on(self, step_s: float) -> None:
        change = self._asked()
        self._integral = self._integral + self._error() * step_s
        self.off_m = self.off_m + (self.velocity_m_s + change * step_s / 2) * step_s
        self.velocity_m_s = self.velocity_m_s + change * step_s
