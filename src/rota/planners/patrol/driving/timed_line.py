"""Timed polylines: where a robot is and when, with its acceleration along each leg."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class TimedLine(NamedTuple):
    """Times (k,) in seconds ascend from 0, places (k, 2) in metres; one row is a robot that stays.

    Between two rows a robot goes straight, at a constant acceleration (k - 1,) along its way.
    """

    times_s: Floats
    places_m: Floats
    accelerations_m_s2: Floats

    @property
    def stays(self) -> bool:
        """Whether its robot never moves."""
        return len(self.times_s) == 1

    @property
    def duration_s(self) -> float:
        """From the first row to the last, in seconds."""
        return float(self.times_s[-1])

    def at(self, moments_s: NDArray[np.floating[Any]]) -> Floats:
        """Where the robot is (m, 2) at the moments (m,); before the first row and after the last at these rows."""
        if not self.accelerations_m_s2.any():
            return np.column_stack([np.interp(moments_s, self.times_s, self.places_m[:, axis]) for axis in (0, 1)])
        leg = np.clip(np.searchsorted(self.times_s, moments_s, side="right") - 1, 0, len(self.times_s) - 2)
        steps_m, whole_s = np.diff(self.places_m, axis=0)[leg], np.diff(self.times_s)[leg]
        done_s = np.clip(moments_s - self.times_s[leg], 0.0, whole_s)
        length_m = np.hypot(*steps_m.T)
        more = self.accelerations_m_s2[leg] / 2 * done_s * (done_s - whole_s)
        share = done_s / whole_s + np.divide(more, length_m, out=np.zeros(len(leg)), where=length_m > 0)
        return np.asarray(self.places_m[leg] + share[:, None] * steps_m)

    def backwards(self) -> TimedLine:
        """The same way driven from its end to its beginning."""
        return TimedLine(self.times_s[-1] - self.times_s[::-1], self.places_m[::-1], -self.accelerations_m_s2[::-1])


def steady(times_s: Floats, places_m: Floats) -> TimedLine:
    """A timed line whose legs are driven at constant speeds."""
    return TimedLine(times_s, places_m, np.zeros(len(times_s) - 1))
