"""When circuits are launched, and which robot flies which: robots queue at their charger, and the first one goes.

In each turn every circuit is launched several times, evenly. A robot that lands goes to the end of the queue. Who lands
for which launch in a turn goes next for another one, always the same: so launches follow each other in rings, and the
robots of a ring fly its launches one after the other, each a turn after the robot before it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rota.errors import NoPlanFound
from rota.model.arrays import Floats, Ints
from rota.model.battery_limits import BatteryLimits
from rota.planners.patrol.circuits.ground import Circuit, visits_s
from rota.planners.patrol.relief.shifts import MOST_JOBS, stays_s
from rota.planners.patrol.tolerances import ROUNDING, SAME_ROUND, SAME_TIME_S, SHORTEST_S

MOST_LAUNCHES = 60  # in a turn


@dataclass(frozen=True, kw_only=True, eq=False)
class Turn:
    """A turn of so many seconds, in which each circuit is launched so often (circuits,); what that takes of robots."""

    lasts_s: float
    counts: Ints
    robots: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Timetable:
    """Which circuits are launched in a turn (n,), by their numbers, and when, ascending from 0 on."""

    lasts_s: float
    circuits: Ints
    begins_s: Floats


@dataclass(frozen=True, kw_only=True)
class Launch:
    """A robot begins a circuit, by its number, at a time."""

    circuit: int
    begins_s: float


@dataclass(frozen=True, kw_only=True)
class Ring:
    """Launches that the same robots fly one after the other, a turn apart; they begin anew after ``robots`` turns."""

    launches: tuple[Launch, ...]
    robots: int
    turn_s: float

    @property
    def lasts_s(self) -> float:
        """After how long each robot begins anew."""
        return self.robots * self.turn_s


def turns_of(circuits: Sequence[Circuit], battery: BatteryLimits) -> list[Turn]:
    """The lengths of turns that take the fewest robots, and then the fewest launches."""
    most_s = np.array([circuit.most_s for circuit in circuits])
    used_s = np.array([circuit.used_s for circuit in circuits])
    lasts_s = np.array([circuit.line.duration_s for circuit in circuits])
    charges = battery.recharge_s is not None
    busy_s = lasts_s + (stays_s(battery, circuits[0].charger, used_s) if charges else battery.grounding_s)
    found = {}
    for turn_s in np.unique([k * period_s for period_s in most_s for k in range(1, MOST_JOBS + 1)]):
        counts = np.maximum(1, np.ceil(turn_s / most_s * (1 - SAME_ROUND))).astype(np.int64)
        if counts.sum() <= max(MOST_LAUNCHES, len(circuits)):
            robots = float((counts * busy_s).sum() / turn_s)
            found[float(turn_s)] = Turn(lasts_s=float(turn_s), counts=counts, robots=robots)
    by_robots = sorted(found.values(), key=lambda turn: (math.ceil(turn.robots - ROUNDING), turn.counts.sum()))
    return by_robots[:6]  # for each of them phases are tried


def even_launches(turn: Turn, phases: Floats) -> Timetable:
    """The launches of a turn, evenly; phases (circuits,): of each circuit the first, in shares of the time between."""
    number = np.repeat(np.arange(len(turn.counts)), turn.counts)
    each = np.concatenate([np.arange(count) for count in turn.counts])
    begins_s = np.mod((each + phases[number]) * (turn.lasts_s / turn.counts[number]), turn.lasts_s)
    return _in_order(turn.lasts_s, number, begins_s)


def launches_between(circuits: Sequence[Circuit], lasts_s: float) -> Timetable:
    """The launches of a turn where circuits of longer periods come past places that others are for.

    Those of the longest period come evenly, from 0 on; those of shorter and shorter ones fill the gaps that are left.
    """
    number, begins_s = list[int](), list[float]()
    for k in sorted(range(len(circuits)), key=lambda k: -circuits[k].most_s):
        own = circuits[k]
        seen_s = [
            begin_s + visit_s
            for other, begin_s in zip(number, begins_s, strict=True)
            for visit_s in (visits_s(circuits[other].line, own.place) if own.place else ())
        ]
        starts_s, ends_s = np.array(seen_s).reshape(-1, 2).T
        order = np.argsort(np.mod(ends_s, lasts_s))
        starts_s, ends_s = starts_s[order], ends_s[order]
        if len(order):
            gaps_s = np.mod(np.roll(starts_s, -1) - ends_s, lasts_s) if len(order) > 1 else starts_s + lasts_s - ends_s
            first_s = float(visits_s(own.line, own.place)[0].mean())
        else:  # a whole turn from one launch to itself
            ends_s, gaps_s, first_s = np.zeros(1), np.array([lasts_s]), 0.0
            number.append(k)
            begins_s.append(0.0)
        for end_s, gap_s in zip(ends_s, gaps_s, strict=True):
            more = max(0, math.ceil(gap_s / own.most_s * (1 - SAME_ROUND)) - 1)
            number += [k] * more
            begins_s += (end_s - first_s + gap_s * np.arange(1, more + 1) / (more + 1)).tolist()
    return _in_order(lasts_s, np.array(number), np.mod(begins_s, lasts_s))


def _in_order(lasts_s: float, number: Ints, begins_s: Floats) -> Timetable:
    """The timetable of launches of circuits (n,), by their numbers, at times (n,) of a turn; the first one is at 0."""
    order = np.argsort(begins_s, kind="stable")
    return Timetable(lasts_s=lasts_s, circuits=number[order], begins_s=begins_s[order] - begins_s[order][0])


def fewest_rings(
    circuits: Sequence[Circuit], battery: BatteryLimits, *, least: int, most: int, seed: int
) -> list[Ring]:
    """The rings of the circuits of one charger with the fewest robots from ``least`` to ``most``; NoPlanFound: none."""
    chance = np.random.default_rng(seed)
    turns, filled = turns_of(circuits, battery), list[Timetable]()
    if any(circuit.place for circuit in circuits):
        periods_s = {circuit.most_s for circuit in circuits}
        filled = [launches_between(circuits, k * s) for s in sorted(periods_s) for k in range(1, MOST_JOBS + 1)]
        filled = [each for each in filled if len(each.circuits) <= MOST_LAUNCHES]
    for robots in range(max(least, 1), min(most, max(least, _surely_enough(circuits, battery))) + 1):
        for turn in turns:
            if turn.robots > robots + ROUNDING:
                continue
            for number in range(24):  # phases that are tried for these robots and this turn
                spread = np.arange(len(circuits)) / len(circuits)
                phases = chance.random(len(circuits)) if number or seed else spread
                rings = _Queue(circuits, even_launches(turn, phases), robots, battery).rings()
                if rings is not None:
                    return rings
        for timetable in filled:
            rings = _Queue(circuits, timetable, robots, battery).rings()
            if rings is not None:
                return rings
    charger = circuits[0].charger
    raise NoPlanFound(f"circuits from charger {charger.name!r} are flown by no team of {least} to {most} robots")


def _surely_enough(circuits: Sequence[Circuit], battery: BatteryLimits) -> int:
    """Robots that do where those of each circuit charge in full after each flight, and a phase to spare for each."""
    charger, robots = circuits[0].charger, 0
    for circuit in circuits:
        stay_s = float(stays_s(battery, charger, np.array([circuit.used_s]))[0])
        robots += math.ceil((circuit.line.duration_s + stay_s) / circuit.most_s) + 1
    return robots


class _Queue:
    """The launches of a turn at their times, and who goes next for which; who has landed may climb again at once."""

    def __init__(self, circuits: Sequence[Circuit], timetable: Timetable, robots: int, battery: BatteryLimits) -> None:
        self._circuits, self._turn_s, self._robots, self._battery = circuits, timetable.lasts_s, robots, battery
        self._number, self._begins_s = timetable.circuits, timetable.begins_s
        lasts_s = np.array([circuit.line.duration_s for circuit in circuits])[self._number]
        self._ends_s = self._begins_s + lasts_s + battery.grounding_s

    def rings(self) -> list[Ring] | None:
        """The rings; None where somebody lands too late, or would be driven below the reserve."""
        after = self._with_fewer_rings(self._first_come())
        if after is None:
            return None
        found = [self._ring(own, after) for own in _rings_of(np.mod(after, len(after)))]
        return found if all(self._keeps_reserve(ring) for ring in found) else None

    def _first_come(self) -> Ints | None:
        """Of each launch, the number of the launch that its robot flies next, counted on over turns; None: too late."""
        count, turn_s = len(self._begins_s), self._turn_s
        turns_later = (
            np.ceil((self._ends_s - SAME_TIME_S) / turn_s).astype(np.int64) - 1
        )  # landed in this turn or later
        lands_s = self._ends_s - turns_later * turn_s  # above 0, at most a turn
        waiting = self._robots - int(turns_later.sum())
        if waiting < 0:
            return None
        rank = np.empty(count, np.int64)
        rank[np.argsort(lands_s, kind="stable")] = np.arange(count)
        after: Ints = waiting + rank + turns_later * count
        return after if (self._at_s(after) >= self._ends_s + SHORTEST_S).all() else None

    def _at_s(self, numbers: Ints) -> Floats:
        """When the launches of these numbers, counted on over turns, begin."""
        count = len(self._begins_s)
        found: Floats = self._begins_s[numbers % count] + numbers // count * self._turn_s
        return found

    def _with_fewer_rings(self, after: Ints | None) -> Ints | None:
        """The same with as few rings as can be: of two robots that wait at one time, either may go first."""
        if after is None:
            return None
        after, count = after.copy(), len(after)
        for number in range(count):
            one, other = (int(np.flatnonzero(after % count == k % count)[0]) for k in (number, number + 1))
            ring = next(ring for ring in _rings_of(after % count) if one in ring)
            if other not in ring and self._at_s(after[[other]] - 1)[0] >= self._ends_s[other] + SHORTEST_S:
                after[one] += 1
                after[other] -= 1
        return after

    def _ring(self, own: Sequence[int], after: Ints) -> Ring:
        """The ring of these launches, in their order."""
        count, at = len(after), own[0]
        launches = []
        for k in own:
            begins_s = float(self._at_s(np.array([at]))[0])
            launches.append(Launch(circuit=int(self._number[k]), begins_s=begins_s))
            at += int(after[k]) - k
        return Ring(launches=tuple(launches), robots=(at - own[0]) // count, turn_s=self._turn_s)

    def _keeps_reserve(self, ring: Ring) -> bool:
        """Whether batteries that are full at first never fall below the reserve."""
        battery = self._battery
        full_s = battery.endurance_s or math.inf
        level_s, begun_s = full_s, []
        charger = self._circuits[0].charger
        charges_s = [stay_s - battery.grounding_s for stay_s in _stays_s(ring, self._circuits)]
        for _ in range(3):
            begun_s.append(level_s)
            for launch, charge_s in zip(ring.launches, charges_s, strict=True):
                level_s -= battery.departure_s + self._circuits[launch.circuit].used_s
                if level_s < battery.reserve_s:
                    return False
                if charger.swap_s is not None:
                    level_s = full_s if charge_s >= charger.swap_s * (1 - SAME_ROUND) else level_s
                else:
                    level_s = min(full_s, level_s + charge_s * full_s / (battery.recharge_s or math.inf))
        return begun_s[2] >= begun_s[1] - ROUNDING


def _stays_s(ring: Ring, circuits: Sequence[Circuit]) -> list[float]:
    """How long robots stay on the charger after each launch of a ring."""
    ends_s = [launch.begins_s + circuits[launch.circuit].line.duration_s for launch in ring.launches]
    nexts_s = [*(launch.begins_s for launch in ring.launches[1:]), ring.launches[0].begins_s + ring.lasts_s]
    return [next_s - end_s for next_s, end_s in zip(nexts_s, ends_s, strict=True)]


def _rings_of(after: Ints) -> Iterator[list[int]]:
    """The rings of a permutation, each from its least number on."""
    left = np.ones(len(after), np.bool_)
    for first in range(len(after)):
        ring, at = [], first
        while left[at]:
            left[at] = False
            ring.append(at)
            at = int(after[at])
        if ring:
            yield ring
