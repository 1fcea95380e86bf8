"""When each slot of a cycle is handed over, so that every robot is charged when its next job comes.

The robots of a cycle do its jobs one after the other: job k takes off at begins_s[k], and the same robot takes off for
job k + 1 at begins_s[k + 1]. M robots follow each other, ``turn_s`` apart, and begin anew after M times turn_s.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.planners.patrol.relief.shifts import Cycle, Shift
from rota.planners.patrol.relief.slots import Handovers, Slot
from rota.planners.patrol.tolerances import SAME_ROUND, SAME_TIME_S

Anchors = dict[int, tuple[float, int]]  # when and at which handover the first job of a slot is taken over


@dataclass(frozen=True, kw_only=True, eq=False)
class Job:
    """A robot's turn at a slot: it takes off at ``begins_s`` and takes over at the slot's handover of this index."""

    shift: Shift
    handover: int
    begins_s: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Rotation:
    """The jobs of a cycle in the order in which each of its robots does them, and how many robots do."""

    cycle: Cycle
    robots: int
    jobs: tuple[Job, ...]

    @property
    def lasts_s(self) -> float:
        """After how long each robot begins anew."""
        return self.robots * self.cycle.turn_s


class _Takeoffs(NamedTuple):
    """Handovers (n,) of a job, when a robot may take off for each, and after how long it may again; 0: at any time."""

    handovers: Ints
    begins_s: Floats
    every_s: float


def rotations_of(
    cycle: Cycle, slots: Sequence[Slot], handovers: Sequence[Handovers], robots: int, seed: int, *, varied: bool
) -> list[Rotation] | None:
    """The rotations of a cycle with so many robots: several short ones where they do with no more; None: none does.

    Orders of the jobs are tried until the robots of one are always charged in time. varied: the first one that is
    tried, and where robots change, are left to chance as well.
    """
    shared = math.gcd(robots, len(cycle.shifts))
    for parts in (each for each in range(shared, 0, -1) if shared % each == 0):
        dealt = dealt_shifts(cycle, parts, robots // parts)
        found = [_Dispatch(cycle, each, slots, handovers, robots // parts).rotation(seed, varied) for each in dealt]
        if dealt and all(found):
            return [each for each in found if each is not None]
    return None


def dealt_shifts(cycle: Cycle, parts: int, robots: int) -> list[list[Shift]]:
    """The shifts dealt to equal parts, longest first to the least busy; none where one has more than robots can do."""
    dealt: list[list[Shift]] = [[] for _ in range(parts)]
    size = len(cycle.shifts) // parts
    for shift in sorted(cycle.shifts, key=lambda each: -each.jobs * each.busy_s):
        open_parts = [part for part in dealt if len(part) < size]
        min(open_parts, key=lambda part: sum(each.jobs * each.busy_s for each in part)).append(shift)
    most_s = max(sum(shift.jobs * shift.busy_s for shift in part) for part in dealt)
    return dealt if most_s <= robots * cycle.turn_s * (1 + SAME_ROUND) else []


class _Dispatch:
    """Jobs of some shifts, to be timed so that so many robots of a cycle do them."""

    def __init__(
        self, cycle: Cycle, shifts: Sequence[Shift], slots: Sequence[Slot], handovers: Sequence[Handovers], robots: int
    ) -> None:
        self._cycle, self._slots, self._handovers, self._robots = cycle, slots, handovers, robots
        self._spots: dict[int, int] = {}
        self._cuts: dict[int, list[int]] = {}
        self._in_step: dict[tuple[int, int], _Takeoffs] = {}
        self._jobs = [(shift, number) for shift in shifts for number in range(shift.jobs)]
        busy_s = sum(shift.jobs * shift.busy_s for shift in shifts)
        self._between_s = max(robots * cycle.turn_s - busy_s, 0.0) / len(self._jobs)

    def rotation(self, seed: int, varied: bool) -> Rotation | None:
        """The first rotation that fits: jobs as soon as they can be, then with more and more left to chance."""
        chance = np.random.default_rng(seed)
        self._spots = {shift.slot: self._spot(shift, chance if varied else None) for shift, _ in self._jobs}
        orders = 300
        for turn in range(orders):
            jobs = self._timed_jobs(chance, (turn + varied) / orders)
            if jobs is not None:
                return Rotation(cycle=self._cycle, robots=self._robots, jobs=tuple(jobs))
        return None

    def _spot(self, shift: Shift, chance: np.random.Generator | None) -> int:
        """Where robots change at a slot: as near to the charger as can be, or, by chance, not much farther away."""
        own = self._handovers[shift.slot]
        farthest_s = min(shift.most_way_s, shift.way_s + self._between_s * shift.flies_s / (2 * shift.busy_s))
        near = np.flatnonzero(own.ways_s <= farthest_s)
        return own.nearest if chance is None or not len(near) else int(chance.choice(near))

    def _timed_jobs(self, chance: np.random.Generator, at_random: float) -> list[Job] | None:
        """All jobs, each time one that can begin soonest, or any with the probability ``at_random``; None: too late."""
        anchors: Anchors = {}
        left = list(self._jobs)
        first = left.pop(0 if at_random == 0 else int(chance.integers(len(left))))
        takeoffs = self._takeoffs(*first, anchors)
        k = 0 if at_random == 0 else int(chance.integers(len(takeoffs.handovers)))
        jobs = [Job(shift=first[0], handover=int(takeoffs.handovers[k]), begins_s=float(takeoffs.begins_s[k]))]
        self._anchor(jobs[0], first[1], anchors)
        while left:
            ready_s = jobs[-1].begins_s + self._busy_s(jobs[-1])
            soonest = [self._soonest(*each, anchors, ready_s) for each in left]
            order = np.argsort([begins_s for _, begins_s in soonest], kind="stable")
            k = int(order[0] if chance.random() >= at_random else chance.choice(order))
            (shift, number), (at, begins_s) = left.pop(k), soonest[k]
            jobs.append(Job(shift=shift, handover=at, begins_s=begins_s))
            self._anchor(jobs[-1], number, anchors)
        over_s = jobs[-1].begins_s + self._busy_s(jobs[-1]) - (jobs[0].begins_s + self._robots * self._cycle.turn_s)
        return jobs if over_s <= SAME_TIME_S * max(1.0, self._robots * self._cycle.turn_s) else None

    def _soonest(self, shift: Shift, number: int, anchors: Anchors, ready_s: float) -> tuple[int, float]:
        """Where a robot that is ready then may take over a job soonest, and when it takes off for that."""
        takeoffs = self._takeoffs(shift, number, anchors)
        if takeoffs.every_s == 0:  # spread what is free, so that charges do not all begin together
            return int(takeoffs.handovers[0]), ready_s + self._between_s
        later = np.ceil((ready_s - takeoffs.begins_s) / takeoffs.every_s - SAME_ROUND)
        begins_s = takeoffs.begins_s + later * takeoffs.every_s
        k = int(np.argmin(begins_s))
        return int(takeoffs.handovers[k]), float(begins_s[k])

    def _takeoffs(self, shift: Shift, number: int, anchors: Anchors) -> _Takeoffs:
        """Where and when a job may be taken over; a slot's other jobs follow its first one."""
        slot, own, turn_s = self._slots[shift.slot], self._handovers[shift.slot], self._cycle.turn_s
        if slot.keeps_step and (shift.parts > 1 or shift.slot not in anchors):
            if (shift.slot, number) not in self._in_step:
                self._in_step[shift.slot, number] = self._takeoffs_in_step(shift, number)
            return self._in_step[shift.slot, number]
        if slot.keeps_step:
            at = anchors[shift.slot][1]
        else:
            at = self._parts(shift)[number % shift.parts] if shift.parts > 1 else self._spots[shift.slot]
        first_s = anchors[shift.slot][0] + number * (turn_s / shift.jobs) if shift.slot in anchors else 0.0
        every_s = turn_s if shift.slot in anchors else 0.0
        return _Takeoffs(np.array([at]), np.array([first_s]) - own.ways_s[at], every_s)

    def _takeoffs_in_step(self, shift: Shift, number: int) -> _Takeoffs:
        """Those of a loop that keeps step with others, before any of its jobs has a time, or of part of a round."""
        slot, own, turn_s = self._slots[shift.slot], self._handovers[shift.slot], self._cycle.turn_s
        if shift.parts > 1:
            near, every_s = np.array(self._parts(shift))[[number]], turn_s
        else:  # a round on average, with the pauses: so loops keep in step from turn to turn
            near, every_s = np.flatnonzero(own.ways_s <= shift.most_way_s + SAME_TIME_S), turn_s / shift.jobs
            near, every_s = near[np.argsort(own.ways_s[near], kind="stable")], every_s / shift.rounds
        return _Takeoffs(near, own.phases_s[near] * (every_s / slot.line.duration_s) - own.ways_s[near], every_s)

    def _parts(self, shift: Shift) -> list[int]:
        """Where a round is cut in the parts that its jobs drive, each the handover at which one begins."""
        if shift.slot not in self._cuts:
            own, lasts_s = self._handovers[shift.slot], self._slots[shift.slot].line.duration_s
            self._cuts[shift.slot] = own.nearest_parts(lasts_s, shift.parts)[0]
        return self._cuts[shift.slot]

    def _anchor(self, job: Job, number: int, anchors: Anchors) -> None:
        """Note when the first job of a slot is taken over by this one, its job of that number."""
        way_s = float(self._handovers[job.shift.slot].ways_s[job.handover])
        first_s = job.begins_s + way_s - number * self._cycle.turn_s / job.shift.jobs
        anchors.setdefault(job.shift.slot, (first_s, job.handover))

    def _busy_s(self, job: Job) -> float:
        """How long a job keeps its robot busy, which may change farther from the charger than it need, or nearer."""
        more_s = 2 * (float(self._handovers[job.shift.slot].ways_s[job.handover]) - job.shift.way_s)
        return job.shift.busy_s + max(more_s, 0.0) * job.shift.busy_s / job.shift.flies_s
