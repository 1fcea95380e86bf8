"""Where rounds begin: rows amid a leg, which tell nothing of what robots with mass drive.

Curves are told by rows past which velocity and acceleration may go on as before: there a change of the acceleration
ends. A row that only cuts a leg in two looks the same, but of two shorter legs each tells another jerk.
"""

from __future__ import annotations

import numpy as np

from rota.model.arrays import Flags, Floats
from rota.planners.patrol.driving.timed_line import TimedLine, start_at
from rota.planners.patrol.tolerances import ROUNDING, SAME_TIME_S

SAME_SPEED_M_S = 1e-9  # speeds, and accelerations in m/s2, so near to each other are one, but for rounding
BESIDE = 6  # legs on either side that tell how accelerations change at a row


def begins_amid_a_leg(line: TimedLine) -> bool:
    """Whether a round (closed, of a robot with mass) begins at a row that cuts a leg of a curve in two.

    It does where all goes on past this row as before, and jerks are less without it.
    """
    if line.stays or len(line.times_s) < 3:
        return False
    middle_s = float(line.times_s[len(line.times_s) // 2])
    whole = start_at(line, middle_s)
    without = without_cuts(whole, np.array([line.duration_s - middle_s]))
    if len(without.times_s) == len(whole.times_s):
        return False
    at = int(np.argmin(np.abs(whole.times_s - (line.duration_s - middle_s))))
    return _most_jerk(without, at) < _most_jerk(whole, at) * (1 - ROUNDING)


def start_without_cut(line: TimedLine, phase_s: float) -> TimedLine:
    """The round begun ``phase_s`` after its start, without the row of the start if that cuts a leg of a curve."""
    begun = start_at(line, phase_s)
    if begun is line or not begins_amid_a_leg(line):
        return begun
    return without_cuts(begun, np.array([line.duration_s - phase_s % line.duration_s]))


def without_cuts(line: TimedLine, moments_s: Floats) -> TimedLine:
    """The line without its rows at some moments (m,) past which all goes on as before."""
    steps_s, changes = np.diff(line.times_s), line.accelerations_m_s2
    begin_m_s, end_m_s = _velocities(line)
    on = (np.hypot(*(begin_m_s[1:] - end_m_s[:-1]).T) < SAME_SPEED_M_S) & (np.abs(np.diff(changes)) < SAME_SPEED_M_S)
    on &= (np.diff(line.places_m, axis=0) != 0).any(axis=1)[1:] & (steps_s[1:] > 0)
    row = np.clip(np.searchsorted(line.times_s, moments_s - SAME_TIME_S), 0, len(line.times_s) - 1)
    asked = np.zeros(len(line.times_s), np.bool_)
    asked[row[np.abs(line.times_s[row] - moments_s) <= SAME_TIME_S]] = True
    kept = np.concatenate([[True], ~(on & asked[1:-1]), [True]])
    return TimedLine(line.times_s[kept], line.places_m[kept], changes[kept[:-1]])


def steady_legs(line: TimedLine) -> Flags:
    """The legs (n,) of a round at a constant speed, before, on and after which its velocity does not jump."""
    begin_m_s, end_m_s = _velocities(line)
    goes_on = np.hypot(*(begin_m_s - np.roll(end_m_s, 1, axis=0)).T) < SAME_SPEED_M_S
    return np.asarray(goes_on & np.roll(goes_on, -1) & (line.accelerations_m_s2 == 0))


def _velocities(line: TimedLine) -> tuple[Floats, Floats]:
    """The velocity (n, 2) at the beginning and at the end of each leg."""
    steps_s, steps_m = np.diff(line.times_s)[:, None], np.diff(line.places_m, axis=0)
    lengths_m = np.hypot(*steps_m.T)[:, None]
    mean_m_s = np.divide(steps_m, steps_s, out=np.zeros(steps_m.shape), where=steps_s > 0)
    headings = np.divide(steps_m, lengths_m, out=np.zeros(steps_m.shape), where=lengths_m > 0)
    half_m_s = headings * line.accelerations_m_s2[:, None] * steps_s / 2
    return mean_m_s - half_m_s, mean_m_s + half_m_s


def _most_jerk(line: TimedLine, at: int) -> float:
    """The greatest change of the acceleration about a row, in m/s3: from the middle of a phase to that of the next.

    The velocity at a row is the mean of what it is just before and just after; legs of one acceleration are one phase.
    """
    first, last = max(0, at - BESIDE), min(len(line.times_s), at + BESIDE + 1)
    piece = TimedLine(line.times_s[first:last], line.places_m[first:last], line.accelerations_m_s2[first : last - 1])
    begin_m_s, end_m_s = _velocities(piece)
    change_m_s = np.diff((begin_m_s[1:] + end_m_s[:-1]) / 2, axis=0)
    lasts_s = np.diff(piece.times_s)[1:-1]
    acceleration_m_s2 = change_m_s / lasts_s[:, None]
    other = np.hypot(*np.diff(acceleration_m_s2, axis=0).T) > SAME_SPEED_M_S
    begins = np.append(0, np.flatnonzero(other) + 1)
    phases_s = np.add.reduceat(lasts_s, begins)
    phases_m_s2 = np.add.reduceat(change_m_s, begins) / phases_s[:, None]
    jerks = np.hypot(*np.diff(phases_m_s2, axis=0).T) / ((phases_s[1:] + phases_s[:-1]) / 2)
    return float(jerks.max(initial=0.0))
