"""A trajectory with its corners rounded in time: place, velocity and acceleration at any moment, in closed form.

Round each corner, from h before it to h after it, the way is the cubic that agrees with the trajectory in place and
velocity at both ends; between legs of constant speed that is a parabola. With dv the change of velocity it passes the
corner at |dv| h / 4, and takes an acceleration of |dv| / (2 h): with h = |dv| / (2 A) at v^2 sin^2(theta / 2) / (2 A).
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from rota.model.plan import Floats, Trajectory

LEAST_S = 1e-3  # of a rounding: shorter ones are none
TINY_M_S = 1e-6  # a change of velocity that is none
SAME = 1e-6  # share by which accelerations of one leg may differ, and m/s2


class Moment(NamedTuple):
    """Metres, m/s and m/s2, (x, y) or (x, y, z) each."""

    place_m: Floats
    velocity_m_s: Floats
    acceleration_m_s2: Floats


class Hardest(NamedTuple):
    """The corner that takes the greatest acceleration: how great, and where."""

    acceleration_m_s2: float
    place_m: tuple[float, float]


def _share(one: float, other: float) -> float:
    return one / (one + other) if one + other > 0 else 0.5


def _begun_at_a_corner(way: Trajectory) -> tuple[Trajectory, float]:
    """The same rounds from the next point on, and how much later they are then told, for one that goes on for ever.

    A loop that begins in the midst of a straight leg has a point there that is no corner, and corners beside it would
    have only a part of the leg for their rounding. Others are returned as they are.
    """
    n, given = len(way.times_s), way.accelerations_m_s2
    if way.loop_duration_s == 0 or way.loop_index > 0 or n < 4:
        return way, 0.0
    first, last = np.diff(way.positions_m[:2], axis=0)[0], np.diff(way.positions_m[-2:], axis=0)[0]
    lasting, bends = np.diff(way.times_s), way.bends
    after, before = first / lasting[0] * (1 - bends[0]), last / lasting[-1] * (1 + bends[-1])
    changes = given is not None and not math.isclose(given[0], given[-1], rel_tol=SAME, abs_tol=SAME)
    if changes or np.abs(after - before).max() >= TINY_M_S:
        return way, 0.0
    times_s = np.append(way.times_s[1:-1] - way.times_s[1], way.loop_duration_s)
    begun = Trajectory(
        robot=way.robot,
        times_s=times_s,
        positions_m=np.vstack([way.positions_m[1:-1], way.positions_m[1]]),
        accelerations_m_s2=None if given is None else given[1:],
    )
    return begun, way.loop_duration_s - float(way.times_s[1])


class RoundedTrack:
    """A robot's trajectory, corners rounded by up to ``corner_m``, with ``acceleration_m_s2`` where that is enough.

    What a corner takes beyond that ``hardest`` tells. Where the robot stays it is at rest in its last place.
    """

    def __init__(self, trajectory: Trajectory, acceleration_m_s2: float, corner_m: float) -> None:
        self._starts_m = trajectory.positions_m[0]
        trajectory, self._earlier_s = _begun_at_a_corner(trajectory)
        self._way = trajectory
        self._loop_from = trajectory.loop_index
        times, places = trajectory.times_s, trajectory.positions_m
        self._lasting = np.diff(times)
        steps = np.diff(places, axis=0)
        mean = steps / self._lasting[:, None] if len(steps) else np.zeros((0, places.shape[1]))
        bends = trajectory.bends[:, None]
        # of the share u of a leg's time it is the share u + b u (u - 1) of the leg
        self._begin, self._end = mean * (1 - bends), mean * (1 + bends)
        self._accelerations = 2 * bends * mean / self._lasting[:, None] if len(steps) else mean
        before, after = self._around()
        self._halves = self._roundings(before, after, acceleration_m_s2, corner_m)
        self.hardest = self._hardest(before, after)
        speeds = np.hypot(*np.vstack([self._begin, self._end])[:, :2].T) if len(steps) else np.zeros(1)
        self.top_m_s = float(speeds.max())

    def _around(self) -> tuple[Floats, Floats]:
        """The velocities (n, d) before and after each point: at rest before the first, and where it stays."""
        rest = np.zeros((1, self._way.positions_m.shape[1]))
        before, after = np.vstack([rest, self._end]), np.vstack([self._begin, rest])
        if self._way.loop_duration_s > 0:
            after[-1] = after[self._loop_from]
            if self._loop_from == 0:
                before[0] = before[-1]
        return before, after

    def _roundings(self, before: Floats, after: Floats, acceleration_m_s2: float, corner_m: float) -> Floats:
        """The half h (n,) of each point's rounding in seconds."""
        changes = np.sqrt(((after - before) ** 2).sum(axis=1))
        # two points share the leg between them as they need it: where the way goes straight on, none of it
        shares = np.array([_share(one, other) for one, other in itertools.pairwise(changes.tolist())])
        sides = np.full((2, len(changes)), math.inf)
        sides[0, 1:], sides[1, :-1] = self._lasting * (1 - shares), self._lasting * shares
        if self._way.loop_duration_s > 0:
            first = self._loop_from
            sides[1, -1] = sides[1, first] = min(
                sides[1, first], self._lasting[first] * _share(changes[-1], changes[first + 1])
            )
        else:
            sides[1, -1] = LEAST_S
        room = sides.min(axis=0)
        with np.errstate(divide="ignore"):
            wanted, widest = changes / (2 * acceleration_m_s2), 4 * corner_m / changes
        return np.where(changes < TINY_M_S, 0.0, np.minimum(np.minimum(wanted, widest), room))

    def _hardest(self, before: Floats, after: Floats) -> Hardest:
        """The greatest acceleration that the track asks for, and where."""
        changes = np.sqrt(((after - before) ** 2).sum(axis=1))
        halves = np.maximum(self._halves, LEAST_S)
        takes = np.where(changes < TINY_M_S, 0.0, changes / (2 * halves))
        if self._way.loop_duration_s == 0:
            takes[-1] = 0.0  # it comes to rest there once, and is slowed down on the way
        if self._loop_from > 0 or self._way.loop_duration_s == 0:
            takes[0] = 0.0  # it begins at rest, and speeds up on the way
        k = int(np.argmax(takes))
        x, y = self._way.positions_m[k, :2].tolist()
        along = float(np.sqrt((self._accelerations**2).sum(axis=1)).max(initial=0.0))
        return Hardest(max(float(takes[k]), along), (x, y))

    def at(self, time_s: float) -> Moment:
        """Where it is at a moment since the start, in any round, and how it moves; at rest before 0."""
        times, rest = self._way.times_s, np.zeros(self._way.positions_m.shape[1])
        if time_s <= 0 or len(times) == 1:
            return Moment(self._starts_m, rest, rest)
        time_s += self._earlier_s
        last_s, loop_s = float(times[-1]), self._way.loop_duration_s
        again = loop_s > 0 and time_s > last_s
        if again:
            time_s = self._way.loop_start_s + (time_s - self._way.loop_start_s) % loop_s
        elif time_s >= last_s:
            return Moment(self._way.positions_m[-1], rest, rest)
        leg = int(np.clip(np.searchsorted(times, time_s, side="right") - 1, 0, len(times) - 2))
        for k in (leg, leg + 1):
            # in later rounds the loop's first point is passed as its last one
            passed = len(times) - 1 if again and k == self._loop_from else k
            half_s, off_s = float(self._halves[passed]), time_s - float(times[k])
            if half_s > LEAST_S and abs(off_s) < half_s and passed > 0:
                return self._rounded(passed, off_s, half_s)
        return self._on_leg(leg, time_s - float(times[leg]))

    def _on_leg(self, leg: int, off_s: float) -> Moment:
        acceleration = self._accelerations[leg]
        velocity = self._begin[leg] + acceleration * off_s
        place = self._way.positions_m[leg] + self._begin[leg] * off_s + acceleration * off_s**2 / 2
        return Moment(place, velocity, acceleration)

    def _rounded(self, k: int, off_s: float, half_s: float) -> Moment:
        """Within the rounding of point k, off_s after it; the last point is followed by the loop's first leg."""
        a = self._on_leg(k - 1, float(self._lasting[k - 1]) - half_s)
        b = self._on_leg(self._loop_from if k == len(self._lasting) else k, half_s)
        span_s, u = 2 * half_s, (off_s + half_s) / (2 * half_s)
        va, vb = a.velocity_m_s * span_s, b.velocity_m_s * span_s
        gap = b.place_m - a.place_m
        c2, c3 = 3 * gap - 2 * va - vb, -2 * gap + va + vb
        return Moment(
            a.place_m + u * (va + u * (c2 + u * c3)),
            (va + u * (2 * c2 + 3 * u * c3)) / span_s,
            (2 * c2 + 6 * u * c3) / span_s**2,
        )

    def nearest_s(self, place_m: Floats, from_s: float, to_s: float, step_s: float = 0.05) -> float:
        """The moment from ``from_s`` to ``to_s``, on a grid of steps, at which it is nearest to a place (d,)."""
        moments = np.arange(max(from_s, 0.0), to_s + step_s, step_s)
        off_m = [float(((self.at(float(moment)).place_m - place_m) ** 2).sum()) for moment in moments]
        return float(moments[int(np.argmin(off_m))])
