"""The stops of a trajectory whose legs have accelerations: where it rests, and the corners that it cuts.

A corner that is cut is a parabola: one acceleration, not along the way, turns the velocity from one straight way to the
next and leaves the speed as it was. Its chords are the trajectory's legs; the corner is where the straight ways meet.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rota.plan import Floats, Trajectory

ROUNDS = 3  # unrolled: in the second all is as in all later ones, and the third tells how the second ends
AT_REST_M_S = 1e-6
SAME_PLACE_M = 1e-6  # by which chords may be off a parabola
SAME_DIRECTION = 1e-7  # radians by which legs of one straight way may differ, as rounding makes them
SAME_TIME = 1e-9  # share of a round by which times may differ, likewise
SAME_SPEED = 1e-6  # share by which speeds before and after a corner may differ, as rounding makes them


@dataclass(frozen=True, kw_only=True, eq=False)
class PassedStop:
    """A place (d,) in metres that the robot comes to, or the corner that it cuts, and when.

    reached_s and left_s are equal where it does not wait. top_speed_m_s: the greatest speed on the way there; 0 at the
    beginning.
    """

    place_m: Floats
    reached_s: float
    left_s: float
    top_speed_m_s: float


@dataclass(frozen=True, kw_only=True, eq=False)
class _Leg:
    """A straight leg from one place to another, at one acceleration; a wait has no length."""

    begin_m: Floats
    end_m: Floats
    begin_s: float
    duration_s: float
    acceleration_m_s2: float

    @property
    def end_s(self) -> float:
        return self.begin_s + self.duration_s

    @cached_property
    def length_m(self) -> float:
        return float(np.linalg.norm(self.end_m - self.begin_m))

    @cached_property
    def direction(self) -> Floats:
        return np.asarray((self.end_m - self.begin_m) / self.length_m)

    @cached_property
    def speeds_m_s(self) -> tuple[float, float]:
        """At its beginning and at its end."""
        mean, change = self.length_m / self.duration_s, self.acceleration_m_s2 * self.duration_s
        return max(mean - change / 2, 0.0), max(mean + change / 2, 0.0)


def passed_stops(trajectory: Trajectory) -> tuple[list[PassedStop], list[PassedStop]]:
    """The stops until the loop's first one, and those of one later round, from that first one to its return.

    The first list begins where the robot begins and ends with the loop's first stop in the first round. The second one
    begins with that stop a round later; it is empty where the robot stays. Times go on through both.
    """
    k, n = trajectory.loop_index, len(trajectory.times_s)
    duration_s = trajectory.loop_duration_s
    order = np.concatenate([np.arange(k), *[np.arange(k, n - 1)] * ROUNDS, [n - 1]])
    rounds = np.concatenate([np.zeros(k), *(np.full(n - 1 - k, each) for each in range(ROUNDS)), [ROUNDS - 1]])
    if duration_s == 0:
        order, rounds = np.arange(n), np.zeros(n)
    legs = list(_legs(trajectory, order.astype(np.int64), rounds * duration_s))
    stops = list(_stops(legs, trajectory.positions_m[0]))
    if duration_s == 0:
        return stops, []
    late_s = SAME_TIME * duration_s

    def rounds_before(stop: PassedStop) -> float:
        """How many rounds have ended when it leaves a stop; one at which the loop begins is the next round's."""
        at_begin = np.array_equal(stop.place_m, trajectory.positions_m[k])
        return (stop.left_s + (late_s if at_begin else -late_s) - trajectory.loop_start_s) // duration_s

    a_round = [stop for stop in stops if rounds_before(stop) == 1]
    if not a_round:
        return stops[:1], []
    returned = next(stop for stop in stops if rounds_before(stop) == 2)
    there = a_round[0]
    if k == 0:  # it begins on the loop, perhaps amidst a corner, of which it passes but a part
        before = [] if np.array_equal(stops[0].place_m, there.place_m) else stops[:1]
        reached_s = max(0.0, there.reached_s - duration_s)
        before.append(replace(there, reached_s=reached_s, left_s=max(reached_s, there.left_s - duration_s)))
    else:
        first_s = there.left_s - duration_s * (1 + SAME_TIME)
        before = stops[: 2 + next(j for j, stop in enumerate(stops[1:]) if stop.left_s > first_s)]
    return before, [*a_round, returned]


def _legs(trajectory: Trajectory, order: np.ndarray, later_s: Floats) -> Iterator[_Leg]:
    """The legs between the points of these numbers; what goes straight on at one acceleration is one leg."""
    times_s = trajectory.times_s[order] + later_s
    last: _Leg | None = None
    given = trajectory.accelerations_m_s2
    for i in range(len(order) - 1):
        leg = _Leg(
            begin_m=trajectory.positions_m[order[i]],
            end_m=trajectory.positions_m[order[i] + 1],
            begin_s=float(times_s[i]),
            duration_s=float(trajectory.times_s[order[i] + 1] - trajectory.times_s[order[i]]),
            acceleration_m_s2=0.0 if given is None else float(given[order[i]]),
        )
        if last is None:
            last = leg
        elif _goes_on(last, leg):
            last = _Leg(
                begin_m=last.begin_m,
                end_m=leg.end_m,
                begin_s=last.begin_s,
                duration_s=last.duration_s + leg.duration_s,
                acceleration_m_s2=last.acceleration_m_s2,
            )
        else:
            yield last
            last = leg
    if last is not None:
        yield last


def _goes_on(leg: _Leg, after: _Leg) -> bool:
    """Whether two legs are one: both wait, or one is the other's way on at the same acceleration."""
    if leg.length_m == 0 or after.length_m == 0:
        return leg.length_m == after.length_m
    same = abs(leg.acceleration_m_s2 - after.acceleration_m_s2) <= SAME_SPEED * abs(leg.acceleration_m_s2)
    speed = leg.speeds_m_s[1]
    moving = speed > AT_REST_M_S and abs(after.speeds_m_s[0] - speed) <= SAME_SPEED * speed
    return same and moving and _straight_on(leg.direction, after)


def _straight_on(direction: Floats, after: _Leg) -> bool:
    off = float(np.linalg.norm(after.direction - direction))
    return off <= SAME_DIRECTION or off * after.length_m <= SAME_PLACE_M / 100


def _stops(legs: list[_Leg], begin_m: Floats) -> Iterator[PassedStop]:
    """All stops from the beginning to the last place."""
    begun_s = legs[0].end_s if legs and legs[0].length_m == 0 else 0.0
    yield PassedStop(place_m=begin_m, reached_s=0.0, left_s=begun_s, top_speed_m_s=0.0)
    i, top = (1 if begun_s else 0), 0.0
    velocity = np.zeros(len(begin_m))
    while i < len(legs):
        leg = legs[i]
        top = max(top, *leg.speeds_m_s)
        velocity, i = leg.direction * leg.speeds_m_s[1], i + 1
        while i < len(legs):
            after, speed = legs[i], float(np.linalg.norm(velocity))
            if after.length_m == 0 or speed <= AT_REST_M_S:
                waits = after.length_m == 0
                left_s = after.end_s if waits else after.begin_s
                yield PassedStop(place_m=after.begin_m, reached_s=after.begin_s, left_s=left_s, top_speed_m_s=top)
                i, top = i + waits, 0.0
                break
            if _straight_on(velocity / speed, after):
                break
            chords = _chords(legs, i, velocity)
            if chords == 0:
                yield PassedStop(
                    place_m=after.begin_m, reached_s=after.begin_s, left_s=after.begin_s, top_speed_m_s=top
                )
                top = 0.0
                break
            half_s = (legs[i + chords - 1].end_s - after.begin_s) / 2
            corner_m, passed_s = after.begin_m + velocity * half_s, after.begin_s + half_s
            yield PassedStop(place_m=corner_m, reached_s=passed_s, left_s=passed_s, top_speed_m_s=max(top, speed))
            velocity, top = _turned(legs[i], velocity, 2 * half_s), speed
            i += chords
    if legs and legs[-1].length_m > 0:
        yield PassedStop(place_m=legs[-1].end_m, reached_s=legs[-1].end_s, left_s=legs[-1].end_s, top_speed_m_s=top)


def _turned(chord: _Leg, velocity: Floats, after_s: float) -> Floats:
    """The velocity (d,) so long after the beginning of a parabola, which begins at ``velocity`` and has this chord."""
    first_s = chord.duration_s
    return np.asarray(velocity + 2 * (chord.end_m - chord.begin_m - velocity * first_s) / first_s**2 * after_s)


def _chords(legs: list[_Leg], first: int, velocity: Floats) -> int:
    """How many legs from number ``first`` on are chords of one parabola; 0: none.

    It begins at this velocity and ends at the same speed.
    """
    chord, speed = legs[first], float(np.linalg.norm(velocity))
    first_s = chord.duration_s
    bend = 2 * (chord.end_m - chord.begin_m - velocity * first_s) / first_s**2
    found = 0
    for count, leg in enumerate(itertools.islice(legs, first, None), 1):
        after_s = leg.end_s - chord.begin_s
        there_m = chord.begin_m + velocity * after_s + bend * after_s**2 / 2
        if np.linalg.norm(leg.end_m - there_m) > SAME_PLACE_M:
            break
        if abs(np.linalg.norm(velocity + bend * after_s) - speed) <= SAME_SPEED * speed:
            found = count
    return found
