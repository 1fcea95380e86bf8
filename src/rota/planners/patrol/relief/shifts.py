"""How long robots stay at each loop before they are relieved, so that the fewest robots do.

The robots of a cycle take turns at its slots, and each turn of the cycle lasts ``turn_s``. In a turn a slot is handed
over once or several times. Its robot drives some rounds, or a part of one, goes to the charger, and leaves the slot
alone for a while where periods allow that. A robot is busy with a job from leaving the charger until it has landed
there, is charged and has climbed. M robots go through all jobs of a cycle one after the other, turn_s apart, if all
jobs together take M times turn_s at most.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rota.model.arrays import Flags, Floats
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, Robot
from rota.planners.patrol.relief.slots import SPOTS, Handovers, Slot
from rota.planners.patrol.tolerances import SAME_ROUND

MOST_JOBS = 12  # of a slot, or periods of a circuit, in a turn


@dataclass(frozen=True, kw_only=True, eq=False)
class Shift:
    """How a slot is served in each turn of its cycle: by ``jobs`` one after the other, of ``rounds`` each.

    rounds: 1 / m for the m-th part of one. round_s: what a round takes without pauses. way_s: to the charger from where
    robots change. busy_s: a job, until the robot may begin another. most_way_s: as long as its battery allows.
    gives_way_s: it leaves so much before its rounds are over, to whoever comes.
    """

    slot: int
    jobs: int
    rounds: float
    round_s: float
    way_s: float
    busy_s: float
    most_way_s: float
    gives_way_s: float = 0.0

    @property
    def serves_s(self) -> float:
        """Seconds of a job at the slot."""
        return self.rounds * self.round_s - self.gives_way_s

    @property
    def flies_s(self) -> float:
        """Seconds between leaving the charger and coming back."""
        return self.serves_s + 2 * self.way_s

    @property
    def parts(self) -> int:
        """How many jobs make up a round; 1 where each drives whole rounds."""
        return max(1, round(1 / self.rounds))


@dataclass(frozen=True, kw_only=True, eq=False)
class Cycle:
    """Slots that the same robots take turns at, again and again after ``turn_s``."""

    charger: Charger
    turn_s: float
    shifts: tuple[Shift, ...]

    @property
    def robots(self) -> int:
        """How many robots it takes."""
        busy_s = sum(shift.jobs * shift.busy_s for shift in self.shifts)
        return max(1, math.ceil(busy_s / self.turn_s * (1 - SAME_ROUND)))


class Clearance(NamedTuple):
    """By how many seconds robots that change at a slot pass one place after each other; 0 without bodies.

    gives_way: who is relieved leaves so much sooner, and the other comes in ahead of it on the same timetable: so loops
    keep step. Else both are at the slot for so long, or it is left alone until one is back. lands: who gives way has
    landed before the other takes off, where that takes hardly longer.
    """

    seconds: float
    gives_way: bool = False
    lands: bool = False

    def post_pauses_s(self, pauses_s: Floats, way_s: float) -> Floats:
        """Pauses (n,) between two robots as they can be, with ways of so many seconds; below 0: both are there."""
        if self.seconds == 0:
            return pauses_s
        return np.where(pauses_s < self.seconds + (0.0 if self.gives_way else 2 * way_s), -self.seconds, pauses_s)

    def loop_pauses_s(self, pauses_s: Floats, way_s: float, *, keeps_step: bool) -> Floats:
        """The same on a loop; 0 where who is relieved gives way."""
        if not self.gives_way:
            return self.post_pauses_s(pauses_s, way_s)
        return np.where((pauses_s < self.seconds) | keeps_step, 0.0, pauses_s)


def time_to_stop_s(robot: Robot) -> float:
    """What a robot takes to stop, or to get up its speed: in that time another one that leaves a loop is off it."""
    motion = robot.motion
    if not motion.acceleration_m_s2:
        return 0.0
    return robot.ground_speed_m_s / motion.acceleration_m_s2 + motion.acceleration_m_s2 / (motion.jerk_m_s3 or math.inf)


class _Way(NamedTuple):
    """A way to serve a slot in turns of n lengths (n,); busy_s counts all jobs of a turn, inf: impossible."""

    jobs: int
    rounds: Floats
    round_s: Floats
    way_s: float
    busy_s: Floats

    @property
    def flown_s(self) -> Floats:
        """Seconds of all flights of a turn."""
        return self.jobs * (self.rounds * self.round_s + 2 * self.way_s)

    def at(self, turns: Flags) -> _Way:
        """The same for some of the turns (n,)."""
        return self._replace(rounds=self.rounds[turns], round_s=self.round_s[turns], busy_s=self.busy_s[turns])


def stays_s(battery: BatteryLimits, charger: Charger, flown_s: Floats) -> Floats:
    """How long robots stay at a charger after flights (n,) of so many seconds of driving: they land, charge and climb.

    They charge for what taking off took as well.
    """
    if charger.swap_s is not None:
        return np.full(len(flown_s), charger.swap_s + battery.grounding_s)
    charges_s = (flown_s + battery.departure_s) * ((battery.recharge_s or 0.0) / (battery.endurance_s or math.inf))
    return charges_s + battery.grounding_s


def best_cycle(
    slots: Sequence[Slot], handovers: Sequence[Handovers], members: Sequence[int], battery: BatteryLimits,
    clearance: Clearance, *, places: float = math.inf, most_pause_ways: float = math.inf,
    turns_s: Floats | None = None,
) -> Cycle | None:  # fmt: skip
    """The cycle of some slots, by their numbers, with the fewest robots, or busy for the least time; None: none does.

    handovers: of each slot with the charger that serves them all. places: no more robots than so many are at the
    charger on average. most_pause_ways: how many ways to the charger a pause between two robots lasts at most. turns_s:
    how long a turn may be; None: anything.
    """
    charger = handovers[members[0]].charger
    if turns_s is None:
        turns_s = turns_to_try([slots[k] for k in members], [handovers[k] for k in members], battery)
    tried = [ways_to_serve(slots[k], handovers[k], turns_s, battery, clearance, most_pause_ways) for k in members]
    busy_s = sum(np.min([way.busy_s for way in ways], axis=0) for ways in tried)
    if not (possible := np.isfinite(busy_s)).any():
        return None
    tried = [[way.at(possible) for way in ways] for ways in tried]
    turns_s, busy_s = turns_s[possible], busy_s[possible]
    robots = np.ceil(busy_s / turns_s * (1 - SAME_ROUND))
    chosen = [np.zeros(len(turns_s), np.int64) for _ in members]
    for own, ways in zip(chosen, tried, strict=True):  # as few jobs as these robots have time for
        least_s = np.min([way.busy_s for way in ways], axis=0)
        for k in reversed(np.argsort([way.jobs for way in ways], kind="stable")):
            enough = busy_s - least_s + ways[k].busy_s <= robots * turns_s * (1 - SAME_ROUND)
            own[enough | (ways[k].busy_s == least_s)] = k
        every = np.array([way.busy_s for way in ways])
        busy_s = busy_s - least_s + np.take_along_axis(every, own[None], axis=0)[0]
    jobs = sum(np.array([way.jobs for way in ways])[own] for own, ways in zip(chosen, tried, strict=True))
    flown_s = sum(
        np.take_along_axis(np.array([way.flown_s for way in ways]), own[None], axis=0)[0]
        for own, ways in zip(chosen, tried, strict=True)
    )
    robots[robots - flown_s / turns_s > places * (1 + SAME_ROUND)] = np.inf
    best = int(np.lexsort((busy_s / turns_s, np.round(jobs / turns_s, 9), robots))[0])
    if not np.isfinite(robots[best]):
        return None
    shifts = tuple(
        _shift(number, ways[own[best]], best, battery, slots[number], float(turns_s[best]), clearance)
        for number, own, ways in zip(members, chosen, tried, strict=True)
    )
    return Cycle(charger=charger, turn_s=float(turns_s[best]), shifts=shifts)


def _shift(
    number: int, way: _Way, k: int, battery: BatteryLimits, slot: Slot, turn_s: float, clearance: Clearance
) -> Shift:
    """The shift of a slot, by its number, that is served this way in turns of the k-th length, ``turn_s``."""
    rounds, round_s = float(way.rounds[k]), float(way.round_s[k])
    has_pause = turn_s - way.jobs * rounds * round_s > SAME_ROUND * turn_s
    gives_way = clearance.gives_way and not slot.line.stays and not has_pause
    ways_s = 2 * way.way_s if clearance.lands and way.way_s < 2 * clearance.seconds else 0.0
    return Shift(
        slot=number,
        jobs=way.jobs,
        rounds=rounds,
        round_s=round_s,
        way_s=way.way_s,
        busy_s=float(way.busy_s[k]) / way.jobs,
        most_way_s=(battery.usable_s - rounds * round_s * slot.uses(battery)) / 2,
        gives_way_s=clearance.seconds + ways_s if gives_way else 0.0,
    )


def turns_to_try(slots: Sequence[Slot], handovers: Sequence[Handovers], battery: BatteryLimits) -> Floats:
    """Lengths of turns (n,): whole rounds of some slot that is driven as fast or as slowly as it may be."""
    usable_s, most = battery.usable_s, 4_000
    most_s = max(usable_s, *(slot.most_s for slot in slots))
    ways_s = [2 * float(own.ways_s.min()) for own in handovers]
    found = [(usable_s - way_s) / slot.uses(battery) for slot, way_s in zip(slots, ways_s, strict=True)]
    for slot in slots:
        if slot.line.stays:  # and a pause
            found += [seconds + slot.most_s for seconds in found[: len(slots)]]
        for round_s in {slot.least_s, slot.most_s} if not slot.line.stays else {slot.most_s}:
            found += (round_s * np.arange(1, min(most_s / round_s, most) + SAME_ROUND)).tolist()
    turns_s: Floats = np.unique([turn_s for turn_s in found if 0 < turn_s <= most_s])
    chosen: Floats = turns_s[np.linspace(0, len(turns_s) - 1, min(len(turns_s), most)).astype(int)]
    return chosen


def ways_to_serve(
    slot: Slot, own: Handovers, turns_s: Floats, battery: BatteryLimits, clearance: Clearance,
    most_pause_ways: float = math.inf,
) -> list[_Way]:  # fmt: skip
    """The best way to serve a slot with each number of jobs: whole rounds, or parts where these are too long.

    most_pause_ways: how many ways to the charger a pause between two robots lasts at most.
    """
    whole, uses = _posts if slot.line.stays else _whole_rounds, slot.uses(battery)
    nearest_s = float(own.ways_s.min())
    # bodies: who takes off is a little away when the other one lands
    most_pause_s = math.inf
    if math.isfinite(most_pause_ways):
        most_pause_s = max(0.0, most_pause_ways * nearest_s - clearance.seconds)
    tried = list(whole(slot, own, turns_s, clearance, most_pause_s))
    if slot.least_s * uses + 2 * nearest_s > battery.usable_s:
        tried += _parts_of_rounds(slot, own, turns_s, clearance)
    best: dict[tuple[int, float], _Way] = {}
    for jobs, rounds, round_s, way_s, possible in tried:
        flown_s, used_s = rounds * round_s + 2 * way_s, rounds * round_s * uses + 2 * way_s
        possible = possible & (used_s <= battery.usable_s * (1 + SAME_ROUND))
        charging_s = np.maximum(stays_s(battery, own.charger, used_s), own.turns_s)
        busy_s = np.where(possible, jobs * (flown_s + charging_s), np.inf)
        way = _Way(jobs, np.broadcast_to(rounds, turns_s.shape).astype(float), round_s, way_s, busy_s)
        known = best.setdefault((jobs, way_s), way)
        better = busy_s < known.busy_s * (1 - SAME_ROUND)
        for kept, new in zip(known[1:3] + known[4:], way[1:3] + way[4:], strict=True):
            kept[better] = new[better]
    return list(best.values())


Tried = tuple[int, Floats | float, Floats, float, Flags]  # jobs, rounds, round_s, way_s, possible


def _posts(slot: Slot, own: Handovers, turns_s: Floats, clearance: Clearance, most_pause_s: float) -> Iterator[Tried]:
    """Jobs of robots that stay, each after a pause of a whole period where it need not be there sooner."""
    way_s, stays_s = float(own.ways_s.min()), max(slot.least_s, own.turns_s / (1 if own.passing is None else 2))
    for jobs in range(1, MOST_JOBS + 1):
        each_s = turns_s / jobs
        pause_s = np.minimum(min(slot.most_s, most_pause_s), each_s - stays_s)
        possible = pause_s >= 0
        if own.passing is not None:
            possible = pause_s >= own.passing.pause_s
            pause_s = np.full(len(turns_s), own.passing.pause_s)
        else:
            pause_s = np.where(possible, clearance.post_pauses_s(pause_s, way_s), pause_s)
        yield jobs, 1.0, each_s - pause_s, way_s, possible


def _whole_rounds(
    slot: Slot, own: Handovers, turns_s: Floats, clearance: Clearance, most_pause_s: float
) -> Iterator[Tried]:
    """Jobs of whole rounds, with pauses between robots that are as long as periods allow."""
    least_s, most_s, way_s = slot.least_s, slot.most_s, float(own.ways_s.min())
    for jobs in range(1, MOST_JOBS + 1):
        each_s = turns_s / jobs
        fewest = np.maximum(1, np.ceil(each_s / most_s * (1 - SAME_ROUND)))
        counts = [fewest + more for more in range(8)]  # rounds more than a job has at least
        if slot.slowest_s < most_s:  # as many as there is time for, too
            counts.append(np.clip(np.floor(each_s / least_s * (1 + SAME_ROUND)), fewest, 60))
        for rounds in counts:
            # rounds are as much shorter as the pause between two robots makes the last one longer
            with np.errstate(divide="ignore", invalid="ignore"):
                longest_s = (most_s - each_s / rounds) / (slot.passes - 1 / rounds)
            longest_s[rounds * slot.passes == 1] = np.inf  # each place is seen once between two pauses
            pause_s = np.minimum(each_s - rounds * least_s, np.minimum(longest_s, most_pause_s))
            pause_s[np.abs(pause_s) <= SAME_ROUND * each_s] = 0.0
            possible = (pause_s >= 0) & (each_s / rounds <= most_s * (1 + SAME_ROUND))
            pause_s = np.where(possible, clearance.loop_pauses_s(pause_s, way_s, keeps_step=slot.keeps_step), pause_s)
            round_s = (each_s - pause_s) / rounds
            yield jobs, rounds, round_s, way_s, possible & (round_s <= slot.slowest_s)


def _parts_of_rounds(slot: Slot, own: Handovers, turns_s: Floats, clearance: Clearance) -> Iterator[Tried]:
    """Jobs of equal parts of one round a turn, driven as fast as can be where no other loop keeps step."""
    least_s, most_s = slot.least_s, slot.most_s
    for parts in (each for each in range(2, SPOTS) if SPOTS % each == 0):
        _, way_s = own.nearest_parts(least_s, parts)
        pause_s = turns_s / parts - least_s / parts if not slot.keeps_step else np.zeros(len(turns_s))
        possible = (turns_s >= least_s * (1 - SAME_ROUND)) & (turns_s <= most_s * (1 + SAME_ROUND))
        pause_s = clearance.loop_pauses_s(pause_s, way_s, keeps_step=slot.keeps_step)
        round_s = turns_s - parts * pause_s
        yield parts, 1 / parts, round_s, way_s, possible & (round_s <= slot.slowest_s)
