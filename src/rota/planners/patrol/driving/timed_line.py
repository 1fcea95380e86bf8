"""Timed polylines: where a robot is and when, with its acceleration along each leg."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.model.arrays import Floats
from rota.model.plan import Trajectory


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


def round_of(trajectory: Trajectory) -> TimedLine:
    """A trajectory's round, from where it begins."""
    first, changes = trajectory.loop_index, trajectory.accelerations_m_s2
    line = steady(trajectory.times_s[first:] - trajectory.times_s[first], trajectory.positions_m[first:, :2])
    return line if changes is None else line._replace(accelerations_m_s2=changes[first:])


def stretch(line: TimedLine, slower: float) -> TimedLine:
    """The same way in ``slower`` times the time."""
    return TimedLine(line.times_s * slower, line.places_m, line.accelerations_m_s2 / slower**2)


def chain(*lines: TimedLine) -> TimedLine:
    """Lines one after the other; each begins where the one before ends."""
    begins_s = np.cumsum([0.0, *(line.duration_s for line in lines)])
    times_s = [begins + line.times_s[1:] for begins, line in zip(begins_s, lines, strict=False)]
    places_m = [line.places_m[1:] for line in lines]
    return TimedLine(
        np.concatenate([[0.0], *times_s]),
        np.vstack([lines[0].places_m[:1], *places_m]),
        np.concatenate([line.accelerations_m_s2 for line in lines]),
    )


def start_at(line: TimedLine, phase_s: float) -> TimedLine:
    """The round begun ``phase_s`` after its start; its duration stays exactly the same."""
    times_s, places_m, accelerations = line
    duration_s = line.duration_s
    phase_s = phase_s % duration_s
    near = int(np.argmin(np.abs(times_s - phase_s)))
    if abs(times_s[near] - phase_s) < 1e-6 * duration_s / len(times_s):
        phase_s = float(times_s[near])  # on a vertex: no leg of hardly any length
    if phase_s in (0.0, duration_s):
        return line
    begins_m = line.at(np.array([phase_s]))
    after, before = times_s > phase_s, times_s < phase_s
    on_vertex = bool((times_s == phase_s).any())
    if on_vertex:
        begins_m = places_m[[int(np.searchsorted(times_s, phase_s))]]
    # the seam's two rows are one: the end of the old round is the start of the new
    times = np.concatenate(
        [[0.0], times_s[after] - phase_s, times_s[before][1:] + (duration_s - phase_s), [duration_s]]
    )
    places = np.vstack([begins_m, places_m[after], places_m[before][1:], begins_m])
    first = int(np.searchsorted(times_s, phase_s, side="right")) - 1
    cut = accelerations[first : first + 1] if not on_vertex else np.zeros(0)
    return TimedLine(times, places, np.concatenate([accelerations[first:], accelerations[:first], cut]))
