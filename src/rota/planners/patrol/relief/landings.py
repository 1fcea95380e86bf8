"""Robots that land wherever a place is free: chargers of few places each, as docks for one drone, serve loops together.

The robots of a rotation have the same jobs at the same times, whichever charger they come from and go to. Who leaves a
loop lands on the charger with a free place that is nearest, there and on its next way out. When all robots are on the
chargers on which they were some repetitions before, what they did since then repeats.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from rota.model.battery_limits import BatteryLimits
from rota.planners.patrol.relief.flights import leaves_at
from rota.planners.patrol.relief.shifts import stays_s
from rota.planners.patrol.relief.slots import Handovers, Slot, chargers_by_way
from rota.planners.patrol.relief.turns import Job, Rotation
from rota.planners.patrol.tolerances import SAME_ROUND, SAME_TIME_S

MOST_REPETITIONS = 12  # of all rotations, within which robots must come to be where they were before

Who = tuple[int, int]  # a rotation, and a robot of it


class Service(NamedTuple):
    """A job of a robot as the slot knows it: when it takes over and leaves, and at which handover it leaves."""

    who: Who
    job: Job
    meets_s: float
    leaves_s: float
    ends: int


class Stay(NamedTuple):
    """A robot on a charger, by its number, from landing to take-off."""

    charger: int
    from_s: float
    until_s: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Landings:
    """What robots do in ``lasts_s``: of each its services, each with the chargers it comes from and goes to."""

    lasts_s: float
    served: dict[Who, list[tuple[Service, int, int]]]


def as_from_one(handovers: Sequence[Handovers], count: int, battery: BatteryLimits) -> Handovers:
    """Handovers of a slot with any of so many chargers, the nearest ones: ways and stays as long as from the worst."""
    near = [handovers[k] for k in chargers_by_way(handovers)[:count]]
    full_s = np.array([battery.usable_s])
    slowest = max(near, key=lambda own: float(stays_s(battery, own.charger, full_s)[0]))
    return replace(slowest, ways_s=np.max([own.ways_s for own in near], axis=0), passing=None)


def landings_of(
    rotations: Sequence[Rotation], slots: Sequence[Slot], planned: Sequence[Handovers],
    handovers: Sequence[Sequence[Handovers]], battery: BatteryLimits,
) -> Landings | None:  # fmt: skip
    """Where the robots of all rotations land; None: somebody finds no free place, or nothing repeats soon.

    planned: of each slot, with which the rotations were made. handovers: of each slot, for each charger. Rotations must
    take equally long, or whole parts of the longest.
    """
    lasts_s = max(rotation.lasts_s for rotation in rotations)
    parts = [lasts_s / rotation.lasts_s for rotation in rotations]
    if any(abs(part - round(part)) > SAME_ROUND for part in parts):
        return None
    at = {(q, k): 0 for q, rotation in enumerate(rotations) for k in range(rotation.robots)}
    places = _Places(slots, handovers, battery)
    # just after somebody has left a slot: by rounding nobody leaves one before and after it
    begins_s = max(service.leaves_s for service in _services(rotations, slots, planned, range(1)))
    begins_s += SAME_ROUND * lasts_s
    known, done = dict[tuple[int, ...], int](), list[list[tuple[Service, int, int]]]([[]])
    # two repetitions more: a robot's first one may be a repetition later than another's
    every = _services(rotations, slots, planned, range(MOST_REPETITIONS + 2))
    coming = sorted(every, key=lambda service: service.leaves_s)
    nexts = _nexts(coming)
    for service in coming:
        while service.leaves_s >= begins_s + len(known) * lasts_s:
            if (state := tuple(at.values())) in known:
                served = list(itertools.chain(*done[known[state] + 1 :]))
                count = len(known) - known[state]
                return Landings(
                    lasts_s=count * lasts_s, served={who: [s for s in served if s[0].who == who] for who in at}
                )
            known[state] = len(known)
            done.append([])
        if (after := nexts.get(id(service))) is None:
            return None
        comes_from = at[service.who]
        goes_to = places.charger(service, after, comes_from)
        if goes_to is None:
            return None
        at[service.who] = goes_to
        done[-1].append((service, comes_from, goes_to))
    return None


def _services(
    rotations: Sequence[Rotation], slots: Sequence[Slot], planned: Sequence[Handovers], turns: range
) -> Iterator[Service]:
    """The services of all robots in these repetitions of the longest rotation."""
    longest_s = max(rotation.lasts_s for rotation in rotations)
    for q, rotation in enumerate(rotations):
        parts = round(longest_s / rotation.lasts_s)
        for job in rotation.jobs:
            own = planned[job.shift.slot]
            ends, serves_s = leaves_at(job, slots[job.shift.slot], own)
            meets_s = job.begins_s + float(own.ways_s[job.handover])
            for k, n in itertools.product(range(rotation.robots), range(turns.start * parts, turns.stop * parts)):
                later_s = k * rotation.cycle.turn_s + n * rotation.lasts_s
                yield Service((q, k), job, meets_s + later_s, meets_s + serves_s + later_s, ends)


def _nexts(services: Sequence[Service]) -> dict[int, Service]:
    """What each robot does after each service, by the identity of that; the last ones are left out."""
    last, found = dict[Who, Service](), dict[int, Service]()
    for service in services:
        if service.who in last:
            found[id(last[service.who])] = service
        last[service.who] = service
    return found


class _Places:
    """Who is on which charger, and when."""

    def __init__(self, slots: Sequence[Slot], handovers: Sequence[Sequence[Handovers]], battery: BatteryLimits) -> None:
        self._slots, self._handovers, self._battery = slots, handovers, battery
        self._stays: list[Stay] = []

    def charger(self, service: Service, after: Service, comes_from: int) -> int | None:
        """The charger with a free place until its next job on which a robot lands, noted as such; None: there is none.

        It is the nearest one, there and on the way out again, of those for which its battery lasts.
        """
        self._stays = [stay for stay in self._stays if stay.until_s > service.meets_s]
        free = []
        for charger, (back, out) in enumerate(
            zip(self._handovers[service.job.shift.slot], self._handovers[after.job.shift.slot], strict=True)
        ):
            back_s, out_s = float(back.ways_s[service.ends]), float(out.ways_s[after.job.handover])
            stay = Stay(charger, service.leaves_s + back_s, after.meets_s - out_s)
            if self._is_charged(service, comes_from, stay) and self._has_place(stay):
                free.append((back_s + out_s, stay))
        if not free:
            return None
        stay = min(free)[1]
        self._stays.append(stay)
        return stay.charger

    def _is_charged(self, service: Service, comes_from: int, stay: Stay) -> bool:
        """Whether a battery lasts for a service between two chargers, and is full again when a stay is over."""
        slot, own = self._slots[service.job.shift.slot], self._handovers[service.job.shift.slot]
        out_s, back_s = float(own[comes_from].ways_s[service.job.handover]), stay.from_s - service.leaves_s
        used_s = out_s + (service.leaves_s - service.meets_s) * slot.uses(self._battery) + back_s
        if not used_s <= self._battery.usable_s * (1 + SAME_ROUND):
            return False
        charger = own[stay.charger].charger
        needed_s = max(float(stays_s(self._battery, charger, np.array([used_s]))[0]), own[stay.charger].turns_s)
        return stay.until_s - stay.from_s >= needed_s * (1 - SAME_ROUND)

    def _has_place(self, stay: Stay) -> bool:
        """Whether a charger has a free place all the time."""
        others = [
            each
            for each in self._stays
            if each.charger == stay.charger
            and each.from_s < stay.until_s - SAME_TIME_S
            and each.until_s > stay.from_s + SAME_TIME_S
        ]
        moments_s = [stay.from_s, *(each.from_s for each in others if each.from_s > stay.from_s)]
        at_once = [sum(each.from_s <= t + SAME_TIME_S < each.until_s for each in others) for t in moments_s]
        return max(at_once) < self._handovers[0][stay.charger].charger.places
