"""How long a vehicle takes for its legs, learned while it drives them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# what is expected before anything is known, each with its standard deviation: seconds lost at a stop, the share of the
# planned time in which it turns, that of the told time in which it drives, and seconds lost by waiting as it is told
EXPECTED = np.array([0.0, 1.0, 1.0, 0.0])
UNSURE = np.array([0.3, 0.5, 0.05, 0.3])
# by how much these may change from leg to leg, and what a leg takes more or less without a reason
CHANGES = np.array([0.02, 0.03, 0.003, 0.02])
NOISE_S = 0.3
BLOCKED_S = 3.0  # a leg that takes so much longer is no sign of how the vehicle drives: somebody stood in its way


@dataclass(frozen=True, kw_only=True)
class Leg:
    """A leg as it is told: how long the robot turns by plan, how long it drives at the told speed, and waits before."""

    turn_s: float
    drive_s: float
    waits: bool

    @property
    def parts(self) -> np.ndarray:
        """(4,) what the four learned numbers are multiplied by."""
        return np.array([1.0, self.turn_s, self.drive_s, float(self.waits)])


class LegTimes:
    """A linear model of a vehicle's legs, fitted to each by a Kalman filter (Kalman 1960) whose weights may move.

    learned: how many legs it has learned from.
    """

    def __init__(self) -> None:
        self.learned = 0
        self._weights = EXPECTED.copy()
        self._covariance = np.diag(UNSURE**2)

    def expected_s(self, leg: Leg) -> float:
        """How long a leg is expected to take, without its wait; no less than nothing."""
        return max(float(self._weights @ leg.parts), 0.0)

    @property
    def stop_s(self) -> float:
        """How long a stop costs by itself."""
        return float(self._weights[0])

    @property
    def turn_share(self) -> float:
        """In which share of the planned time it turns."""
        return float(self._weights[1])

    def drive_s(self, left_s: float, turn_s: float, waits: bool) -> float:
        """The told driving time with which a leg takes ``left_s`` in all; below 0 where there is none."""
        rest_s = left_s - float(self._weights @ Leg(turn_s=turn_s, drive_s=0.0, waits=waits).parts)
        return rest_s / float(self._weights[2])

    def learn(self, legs: list[Leg], took_s: float) -> None:
        """Legs, one at least, took so long together, without their waits."""
        parts = np.sum([leg.parts for leg in legs], axis=0)
        off_s = took_s - float(self._weights @ parts)
        if abs(off_s) > BLOCKED_S * len(legs):
            return
        self.learned += len(legs)
        self._covariance = self._covariance + len(legs) * np.diag(CHANGES**2)
        spread = self._covariance @ parts
        gain = spread / (parts @ spread + len(legs) * NOISE_S**2)
        self._weights = self._weights + gain * off_s
        self._covariance = self._covariance - np.outer(gain, spread)
