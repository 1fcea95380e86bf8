"""The stops of a trajectory whose legs have accelerations: where it rests, and the corners that it cuts.

A corner that is cut is a parabola: one acceleration, not along the way, turns the velocity from one straight way to the
next and leaves the speed as it was. A trajectory gives it as tangents: the velocity turns by equal steps, equally long
apart, first half of such a time after the parabola's beginning. The corner is where the straight ways meet. With a jerk
the acceleration grows and falls again in phases, in the one direction: the steps of each are equal.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rota.model.plan import Floats, Trajectory

ROUNDS = 3  # unrolled: in the second all is as in all later ones, and the third tells how the second ends
AT_REST_M_S = 1e-6
SAME_DIRECTION = 1e-7  # radians by which legs of one straight way may differ, as rounding makes them
SAME_PLACE_M = 1e-8  # by which the end of the second of them may be off it
SAME_TIME = 1e-9  # share of a round by which times may differ, likewise
SAME_SPEED = 1e-6  # share by which speeds and steps may differ, likewise
SAME_TURNED_SPEED = 1e-8  # and those before and after a corner, which the fewest turns leave nearly the same


@dataclass(frozen=True, kw_only=True, eq=False)
class PassedStop:
    """A place (d,) in metres that the robot comes to, or the corner that it cuts, and when.

    reached_s and left_s are equal where it does not wait. rests: whether it comes to rest there. top_speed_m_s: the
    greatest speed on the way there; 0 at the beginning. curve_m: how far before the corner the curve past it begins,
    and after it ends; 0: it is given as a mere point.
    """

    place_m: Floats
    reached_s: float
    left_s: float
    top_speed_m_s: float
    rests: bool = True
    curve_m: float = 0.0


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
    def velocity_m_s(self) -> Floats:
        """At its beginning."""
        return self.direction * self.speeds_m_s[0]

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


def without_slight(stops: list[PassedStop], within_m: float) -> list[PassedStop]:
    """The stops without corners that are cut and hardly bend: none is farther than so from the way without them.

    The first and the last stay. Autopilots slow down at every point, wherever the way goes from there.
    """
    kept = stops[:1]
    first = 0
    for j in range(2, len(stops) + 1):
        between = stops[first + 1 : j]
        if j < len(stops) and _nearly_straight(stops[first].place_m, between, stops[j].place_m, within_m):
            continue
        top_m_s = max(stop.top_speed_m_s for stop in between)
        kept.append(replace(stops[j - 1], top_speed_m_s=top_m_s))
        first = j - 1
    return kept


def _nearly_straight(begin_m: Floats, between: list[PassedStop], end_m: Floats, within_m: float) -> bool:
    """Whether all of these are corners that are cut, so near to the straight way, and one after the other along it."""
    way_m = end_m - begin_m
    length_m = float(np.linalg.norm(way_m))
    if length_m == 0 or any(stop.rests for stop in between):
        return False
    steps_m = np.array([stop.place_m for stop in between]) - begin_m
    along_m = steps_m @ way_m / length_m
    off_m = np.linalg.norm(steps_m - along_m[:, None] * way_m / length_m, axis=1)
    rising = (np.diff(np.concatenate([[0.0], along_m, [length_m]])) > 0).all()
    return bool(rising and (off_m <= within_m).all())


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
    return off <= SAME_DIRECTION or off * after.length_m <= SAME_PLACE_M


def _stops(legs: list[_Leg], begin_m: Floats) -> Iterator[PassedStop]:
    """All stops from the beginning to the last place."""
    begun_s = legs[0].end_s if legs and legs[0].length_m == 0 else 0.0
    yield PassedStop(place_m=begin_m, reached_s=0.0, left_s=begun_s, top_speed_m_s=0.0)
    i, top = (1 if begun_s else 0), 0.0
    while i < len(legs):
        leg, i = legs[i], i + 1
        top, speed = max(top, *leg.speeds_m_s), leg.speeds_m_s[1]
        if i == len(legs):
            break
        after = legs[i]
        if after.length_m == 0 or speed <= AT_REST_M_S:
            waits = after.length_m == 0
            left_s = after.end_s if waits else after.begin_s
            yield PassedStop(place_m=after.begin_m, reached_s=after.begin_s, left_s=left_s, top_speed_m_s=top)
            i, top = i + waits, 0.0
        elif not _straight_on(leg.direction, after):
            velocity = speed * leg.direction
            turns = _turns(legs, i, velocity) or _turns_in_phases(legs, i, velocity)
            apart_s = after.duration_s if turns > 1 else 0.0
            # from the first turn to the corner
            half_s = sum(each.duration_s for each in legs[i : i + turns - 1]) / 2 if turns > 1 else 0.0
            corner_m, passed_s = after.begin_m + velocity * half_s, after.begin_s + half_s
            curve_m = speed * (half_s + apart_s / 2)
            yield PassedStop(
                place_m=corner_m, reached_s=passed_s, left_s=passed_s, top_speed_m_s=top, rests=False, curve_m=curve_m
            )
            i, top = i + max(turns - 1, 0), 0.0
    if legs and legs[-1].length_m > 0:
        yield PassedStop(place_m=legs[-1].end_m, reached_s=legs[-1].end_s, left_s=legs[-1].end_s, top_speed_m_s=top)


def _turns(legs: list[_Leg], first: int, velocity: Floats) -> int:
    """How many equal turns bring the velocity to another direction at the same speed; 0: these legs are no curve.

    velocity: before leg number ``first``, which is the first of another direction. All turns are equally long apart.
    """
    speed, apart_s, found = float(np.linalg.norm(velocity)), legs[first].duration_s, 0
    change = legs[first].velocity_m_s - velocity
    for turns, leg in enumerate(itertools.islice(legs, first, None), 1):
        if leg.length_m == 0 or np.linalg.norm(leg.velocity_m_s - velocity - turns * change) > SAME_SPEED * speed:
            break
        if abs(leg.speeds_m_s[0] - speed) <= SAME_TURNED_SPEED * speed:
            found = turns  # of the slightest turns, which all leave the speed as it is, the last counts
        if abs(leg.duration_s - apart_s) > SAME_SPEED * apart_s:
            break
    return found


def _turns_in_phases(legs: list[_Leg], first: int, velocity: Floats) -> int:
    """Likewise of turns in one direction, first growing and then falling as they grew; 0: these legs are no curve."""
    speed, before, turned_s = float(np.linalg.norm(velocity)), velocity, 0.0
    direction = legs[first].velocity_m_s - velocity
    direction = direction / np.linalg.norm(direction)
    begin_m = legs[first].begin_m
    for turns, leg in enumerate(itertools.islice(legs, first, None), 1):
        if leg.length_m == 0:
            return 0
        change = leg.velocity_m_s - before
        along = float(change @ direction)
        if along <= 0 or np.linalg.norm(change - along * direction) > SAME_SPEED * speed:
            return 0
        if abs(leg.speeds_m_s[0] - speed) <= SAME_SPEED * speed:
            # both straight ways meet in the middle of the time between the first turn and the last
            meet_m = begin_m + (velocity + leg.velocity_m_s) * turned_s / 2
            return turns if np.linalg.norm(leg.begin_m - meet_m) <= SAME_SPEED * speed * turned_s else 0
        if abs(leg.speeds_m_s[1] - leg.speeds_m_s[0]) > SAME_SPEED * speed:
            return 0
        before, turned_s = leg.velocity_m_s, turned_s + leg.duration_s
    return 0
