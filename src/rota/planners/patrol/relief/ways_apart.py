"""Ways between chargers and rounds led past other places, or with waits, so that bodies do not touch.

Rounds are driven as they were timed: whoever comes to one late or leaves it early would leave places unseen. Between a
charger and a round a robot is free. Ways are led anew one after the other, each clear of all other robots as they fly
then, until none touches another one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Robot
from rota.planners.patrol.driving.timed_line import TimedLine, chain, steady
from rota.planners.patrol.relief.flights import Flight, leaves_at, without_moments
from rota.planners.patrol.relief.shifts import stays_s
from rota.planners.patrol.relief.slots import Handovers, Slot
from rota.planners.patrol.relief.turns import Rotation
from rota.planners.patrol.relief.ways import Motion, Ways, motions_of
from rota.planners.patrol.tolerances import SAME_PLACE_M, SAME_ROUND, SAME_TIME_S

STEP = 0.25  # of a body's radius that robots move from one moment to the next at which they are compared
MOST_MOMENTS = 2_000  # of a way
PASSES = 4  # through all ways, each led anew where it touches
NEAR = (3.0, 5.0)  # radii from a round, and from a charger, at which places of detours lie in eight directions
BESIDE = 12  # places beside the shortest way, left to chance
WAITS = (0.0, 3.0, 12.0)  # at such a place, in the time that it takes to move by a radius
CHANGES = 12.0  # times that it takes to move by a radius, after which who takes over is past whoever it relieves
MOST_TURNS = 30  # of a rotation after which it may meet another one anew


class _Detour(NamedTuple):
    """A way into a round, from a charger, by a place: the lines to there and on. Backwards it is one out of it."""

    there: TimedLine
    on: TimedLine

    def line(self, wait_s: float) -> TimedLine:
        """The way with a wait at the place."""
        waits = [steady(np.array([0.0, wait_s]), self.on.places_m[[0, 0]])] if wait_s > 0 else []
        return chain(self.there, *waits, self.on)


class _Others(NamedTuple):
    """Where others are in the air: (p,) of the n moments that are looked at, and their places_m (p, 2) then."""

    moments: Ints
    places_m: Floats

    def touches(self, line: TimedLine, since_s: Floats, least_m: float) -> Ints:
        """The moments at which a robot on a line, for so many seconds (n,), is within ``least_m`` of others."""
        on_way = ((since_s >= 0) & (since_s <= line.duration_s))[self.moments]
        moments = self.moments[on_way]
        steps_m = self.places_m[on_way] - line.at(since_s)[moments]
        return np.unique(moments[(steps_m**2).sum(axis=1) < least_m**2])


@dataclass(frozen=True, kw_only=True, eq=False)
class _End:
    """One of the two ways of a flight: which rotation, which of its flights, and whether it is the way back."""

    rotation: int
    flight: int
    is_back: bool


def lead_apart(
    rotations: Sequence[Rotation], flown: Sequence[Sequence[Flight]], slots: Sequence[Slot],
    handovers: Sequence[Sequence[Handovers]], ways: Ways, robot: Robot, seed: int,
) -> tuple[list[list[Flight]], bool]:  # fmt: skip
    """The flights of some rotations, with ways led apart where robots would touch on them, and whether none do then.

    handovers: for each rotation, of each slot with its charger. Where nothing touches flights are as they were.
    """
    air = _Air(rotations, flown, slots, handovers, ways, robot, seed)
    is_clear = air.clear()
    return air.flown, is_clear


class _Air:
    """All flights of a plan, and which robots meet on them."""

    def __init__(
        self, rotations: Sequence[Rotation], flown: Sequence[Sequence[Flight]], slots: Sequence[Slot],
        handovers: Sequence[Sequence[Handovers]], ways: Ways, robot: Robot, seed: int,
    ) -> None:  # fmt: skip
        self.flown = [list(flights) for flights in flown]
        self._rotations, self._slots, self._handovers, self._ways = rotations, slots, handovers, ways
        self._robot, self._chance = robot, np.random.default_rng(seed)
        self._radius_s = robot.body_radius_m / robot.ground_speed_m_s
        self._least_m = 2 * robot.body_radius_m - SAME_PLACE_M
        motion = robot.motion
        self._rests_s = (motion.acceleration_m_s2 or 0.0) / (motion.jerk_m_s3 or math.inf)  # between stop and start
        self._lines = [[without_moments(flight.line) for flight in flights] for flights in self.flown]
        self._detours: dict[tuple[int, int, bool], list[_Detour]] = {}

    def clear(self) -> bool:
        """Lead all ways anew that touch; whether none does any more."""
        ends = [
            _End(rotation=r, flight=k, is_back=is_back)
            for r, flights in enumerate(self.flown)
            for k in range(len(flights))
            for is_back in (False, True)
        ]
        if any(self._meets_on_round(end) for end in ends if not end.is_back):
            return False
        before: float = math.inf
        for _ in range(PASSES):
            touched = sum(self._lead_anew(end) for end in ends)
            if touched == 0 or touched >= before:
                return touched == 0
            before = touched
        return False

    def _meets_on_round(self, end: _End) -> bool:
        """Whether who takes over touches somebody who is still on a round, whatever the ways are."""
        flight = self.flown[end.rotation][end.flight]
        served = without_moments(flight.served)
        since_s = np.arange(0.0, min(CHANGES * self._radius_s, served.duration_s), STEP * self._radius_s)
        moments_s = self._joins_s(end) + since_s
        others = self._others_in_the_air(end, moments_s, on_rounds=True)
        return len(others.touches(served, since_s, self._least_m)) > 0

    def _lead_anew(self, end: _End) -> int:
        """Lead a way anew if it touches another robot; at how many moments it did."""
        flight = self.flown[end.rotation][end.flight]
        line = without_moments(flight.back if end.is_back else flight.into)
        if line.stays:
            return 0
        most_s = line.duration_s + self._spare_s(end)
        moments_s = self._moments_s(end, most_s)
        others = self._others_in_the_air(end, moments_s)
        step_m = self._robot.ground_speed_m_s * float(moments_s[1] - moments_s[0])
        touched = self._count_touches(end, line, moments_s, others, self._least_m)
        if touched == 0:
            return 0
        best: tuple[int, TimedLine] = touched, line
        for other in self._others(end, most_s):
            count = self._count_touches(end, other, moments_s, others, self._least_m + step_m)
            if count < best[0] and self._is_charged(end, self._with(end, other)):
                best = count, other
                if count == 0:
                    break
        if best[1] is not line:
            anew = self._with(end, best[1])
            self.flown[end.rotation][end.flight] = anew
            self._lines[end.rotation][end.flight] = without_moments(anew.line)
        return touched

    def _with(self, end: _End, line: TimedLine) -> Flight:
        """The flight with another way: it takes over, and leaves the round, when it did."""
        flight = self.flown[end.rotation][end.flight]
        if end.is_back:
            return replace(flight, back=line)
        return replace(flight, into=line, begins_s=flight.begins_s + flight.into.duration_s - line.duration_s)

    def _joins_s(self, end: _End) -> float:
        """When a way ends at its round, or begins there."""
        flight = self.flown[end.rotation][end.flight]
        return flight.begins_s + flight.into.duration_s + (flight.serves_s if end.is_back else 0.0)

    def _moments_s(self, end: _End, most_s: float) -> Floats:
        """The moments (n,) at which a way of at most so many seconds is compared with others."""
        count = int(np.clip(math.ceil(most_s / (STEP * self._radius_s)), 2, MOST_MOMENTS))
        away_s = np.linspace(0.0, most_s, count + 1)
        return self._joins_s(end) + (away_s if end.is_back else away_s - most_s)

    def _count_touches(self, end: _End, line: TimedLine, moments_s: Floats, others: _Others, least_m: float) -> int:
        """At how many of the moments (n,) a robot on this way is within ``least_m`` of others."""
        since_s = moments_s - self._joins_s(end) + (0.0 if end.is_back else line.duration_s)
        return len(others.touches(line, since_s, least_m))

    def _others_in_the_air(self, end: _End, moments_s: Floats, *, on_rounds: bool = False) -> _Others:
        """Where others are at moments (n,) of a way, whenever they may be there then.

        on_rounds: those on rounds alone, not on their ways.
        """
        turn_s = self._rotations[end.rotation].cycle.turn_s
        found = [_Others(np.empty(0, np.int64), np.empty((0, 2)))]
        for r, rotation in enumerate(self._rotations):
            own_turn_s = rotation.cycle.turn_s
            for later in range(_meetings(turn_s, own_turn_s)):
                for k, (flight, line) in enumerate(zip(self.flown[r], self._lines[r], strict=True)):
                    since_s = moments_s + later * turn_s - flight.begins_s
                    begins_s, ends_s = 0.0, line.duration_s
                    if on_rounds:
                        begins_s, ends_s = flight.into.duration_s, flight.into.duration_s + flight.serves_s
                    first = math.floor(-float(since_s.max()) / own_turn_s)
                    last = math.ceil((line.duration_s - float(since_s.min())) / own_turn_s)
                    for turn in range(first, last + 1):
                        if r == end.rotation and k == end.flight and turn == 0:
                            continue  # the robot itself
                        at_s = since_s + turn * own_turn_s
                        # at its ends it is on a charger
                        flies = np.flatnonzero((at_s > begins_s - SAME_TIME_S) & (at_s < ends_s + SAME_TIME_S))
                        if len(flies):
                            found.append(_Others(flies, line.at(at_s[flies])))
        return _Others(*(np.concatenate(each) for each in zip(*found, strict=True)))

    def _others(self, end: _End, most_s: float) -> Iterator[TimedLine]:
        """Other ways of at most so many seconds, the shortest first."""
        key = end.rotation, end.flight, end.is_back
        if key not in self._detours:
            self._detours[key] = list(self._new_detours(end))
        waits_s = [self._rests_s + self._radius_s * wait for wait in WAITS]
        lines = [detour.line(wait_s) for detour in self._detours[key] for wait_s in waits_s]
        for line in sorted(lines, key=lambda line: line.duration_s):
            if line.duration_s > most_s:
                break
            yield line.backwards() if end.is_back else line

    def _new_detours(self, end: _End) -> Iterator[_Detour]:
        """Ways by places near the round, near the charger, and beside the shortest way."""
        job, own = self.flown[end.rotation][end.flight].job, self._handovers[end.rotation]
        slot, handovers = self._slots[job.shift.slot], own[job.shift.slot]
        phase_s = float(handovers.phases_s[leaves_at(job, slot, handovers)[0] if end.is_back else job.handover])
        [at] = motions_of(slot.line, np.array([phase_s]), before=end.is_back)
        charger_m = np.array(handovers.charger.at)
        places_m = self._places_m(charger_m, at)
        for place_m in places_m[self._ways.paths.part_of(places_m) >= 0]:
            lines = self._ways.past(charger_m, at, place_m, slot.slower(job.shift.round_s))
            if lines is not None:
                yield _Detour(*lines)

    def _places_m(self, charger_m: Floats, at: Motion) -> Floats:
        """Places (k, 2) of detours, some of them maybe within walls."""
        angles = np.arange(8) * (math.pi / 4)
        ring_m = self._robot.body_radius_m * np.column_stack([np.cos(angles), np.sin(angles)])
        near_m = [centre_m + radii * ring_m for centre_m in (at.place_m, charger_m) for radii in NEAR]
        step_m = at.place_m - charger_m
        length_m = max(float(np.hypot(*step_m)), self._robot.body_radius_m)
        aside_m = np.array([-step_m[1], step_m[0]]) / length_m
        shares = self._chance.uniform(0.1, 0.9, BESIDE)
        widths_m = self._chance.uniform(2.5, 2.5 + 8.0, BESIDE) * self._robot.body_radius_m
        widths_m[: BESIDE // 2] += self._chance.uniform(0.0, 0.5, BESIDE // 2) * length_m
        widths_m *= self._chance.choice([-1.0, 1.0], BESIDE)
        return np.vstack([*near_m, charger_m + shares[:, None] * step_m + widths_m[:, None] * aside_m])

    def _spare_s(self, end: _End) -> float:
        """By how much a way may take longer at most, as long as its robot is charged in time."""
        flight = self.flown[end.rotation][end.flight]
        battery, before, after = self._robot.battery, *self._gaps_s(end)
        spare_s = battery.usable_s - _used_s(flight.line, battery)
        return max(0.0, min(spare_s, after if end.is_back else before))

    def _is_charged(self, end: _End, flight: Flight) -> bool:
        """Whether this flight in place of its own leaves time to charge before and after it, and does not last longer
        than its battery."""
        kept = self.flown[end.rotation][end.flight]
        self.flown[end.rotation][end.flight] = flight
        battery, gaps_s = self._robot.battery, self._gaps_s(end)
        self.flown[end.rotation][end.flight] = kept
        lasts = _used_s(flight.line, battery) <= battery.usable_s * (1 + SAME_ROUND)
        return lasts and min(gaps_s) >= -SAME_TIME_S

    def _gaps_s(self, end: _End) -> tuple[float, float]:
        """Seconds to spare at the charger before a flight and after it."""
        rotation, flights = self._rotations[end.rotation], self.flown[end.rotation]
        k, count, lasts_s = end.flight, len(flights), rotation.lasts_s
        gaps_s = []
        for first in (k - 1, k):
            flight, following = flights[first % count], flights[(first + 1) % count]
            begins_s = following.begins_s + (lasts_s if (first % count) + 1 == count else 0.0)
            stay_s = begins_s - flight.begins_s - flight.line.duration_s
            used_s = _used_s(flight.line, self._robot.battery)
            needed_s = float(stays_s(self._robot.battery, rotation.cycle.charger, np.array([used_s]))[0])
            turns_s = self._handovers[end.rotation][flight.job.shift.slot].turns_s
            gaps_s.append(stay_s - max(needed_s, turns_s))
        return gaps_s[0], gaps_s[1]


def _used_s(line: TimedLine, battery: BatteryLimits) -> float:
    """Seconds of driving that a flight uses, its standing included."""
    steps_s, steps_m = np.diff(line.times_s), np.hypot(*np.diff(line.places_m, axis=0).T)
    return line.duration_s + float(steps_s[steps_m == 0].sum()) * max(0.0, battery.standing_uses - 1)


def _meetings(turn_s: float, other_s: float) -> int:
    """After how many turns of a rotation all meetings with another one, with turns of ``other_s``, come again."""
    for turns in range(1, MOST_TURNS):
        share = turns * turn_s / other_s
        if abs(share - round(share)) <= SAME_ROUND * share and round(share) > 0:
            return turns
    return MOST_TURNS
