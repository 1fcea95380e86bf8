"""Loops that robots take turns at: how long a round may take, and from where a charger is near."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, Mission
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.driving.round_starts import begins_amid_a_leg
from rota.planners.patrol.driving.timed_line import TimedLine, round_of, start_at, steady, stretch
from rota.planners.patrol.relief.ways import Passing, Ways
from rota.planners.patrol.tolerances import ROUNDING, SAME_ROUND, SAME_TIME_S, SLOWER
from rota.planners.patrol.verdict import Judge

MOMENT = 1e-3  # of the period, that a robot is at least where another one would stay for ever
WINGS = 0.85  # of their speed is the least at which robots that cannot stand are planned on loops
SPOTS = 120  # of a loop, beside its corners, at which robots may change; many numbers divide it


@dataclass(frozen=True, kw_only=True, eq=False)
class Slot:
    """A loop that robots take turns at.

    line: its round as fast as it can be driven, from where it is at time 0 of the timetable of all loops. least_s: what
    that takes; a robot that stays need be there for a moment only. most_s: how long a round may take, from one time to
    the next. keeps_step: other loops go round as fast. passes: how often in a round a place may be seen that must be:
    by so much less than the rest of most_s may one robot come after another. slowest_s: how long a round may be driven
    at most, where its robots cannot wait on it. has_mass: whether robots take time to change speed on it.
    begins_amid_a_leg: its line, with a row that tells nothing.
    """

    line: TimedLine
    least_s: float
    most_s: float
    keeps_step: bool
    passes: float
    slowest_s: float = math.inf
    has_mass: bool = False
    begins_amid_a_leg: bool = False

    def slower(self, round_s: float) -> float:
        """By how much longer a round takes than as fast as it can be driven; 1 where its robot stays."""
        return 1.0 if self.line.stays else round_s / self.line.duration_s

    def uses(self, battery: BatteryLimits) -> float:
        """Seconds of driving that a second there takes: as much as of standing, as far as that takes more."""
        return 1 + self._standing * max(0.0, battery.standing_uses - 1)

    @cached_property
    def _standing(self) -> float:
        """The share of its round in which a robot stands."""
        if self.line.stays:
            return 1.0
        steps_s, steps_m = np.diff(self.line.times_s), np.hypot(*np.diff(self.line.places_m, axis=0).T)
        return float(steps_s[steps_m == 0].sum() / self.line.duration_s)


@dataclass(frozen=True, kw_only=True, eq=False)
class Handovers:
    """Where robots may change at a slot: phases_s (k,) of the round, places_m (k, 2), and ways_s (k,) to a charger.

    turns_s: what turning back takes. passing: the ways to a post and back, at right angles, on which robots with bodies
    pass each other; None: they do not.
    """

    charger: Charger
    phases_s: Floats
    places_m: Floats
    ways_s: Floats
    turns_s: float
    passing: Passing | None = None

    @property
    def nearest(self) -> int:
        """The one from which the charger is nearest."""
        return int(np.argmin(self.ways_s))

    def at_phase(self, phase_s: float, lasts_s: float) -> int:
        """The one at a phase, or nearest to it, of a round of so many seconds."""
        apart_s = np.abs(self.phases_s - phase_s) % lasts_s if lasts_s else self.phases_s
        return int(np.argmin(np.minimum(apart_s, lasts_s - apart_s)))

    def nearest_parts(self, lasts_s: float, parts: int) -> tuple[list[int], float]:
        """Those that cut the round, of so many seconds, in equal parts with the shortest longest way, and that way."""
        cuts = even_spots(self.phases_s, lasts_s).reshape(parts, SPOTS // parts).T
        longest_s = self.ways_s[cuts].max(axis=1)
        k = int(np.argmin(longest_s))
        return [int(each) for each in cuts[k]], float(longest_s[k])


def chargers_by_way(handovers: Sequence[Handovers]) -> list[int]:
    """The chargers of these handovers of one slot, by their numbers: those with the shortest ways first."""
    return sorted(range(len(handovers)), key=lambda k: float(handovers[k].ways_s.min()))


def nearest_s(handovers: Sequence[Handovers]) -> float:
    """The shortest way between a slot and a charger."""
    return min(float(own.ways_s.min()) for own in handovers)


def for_wings(slot: Slot) -> Slot:
    """The slot of robots that go round it hardly more slowly than they can."""
    return slot if slot.line.stays else replace(slot, slowest_s=slot.line.duration_s / WINGS)


def slots_of(plan: Plan, worst_ratio: float) -> list[Slot]:
    """The loops of a plan whose worst gap is ``worst_ratio`` times its period: rounds may take as much longer."""
    durations_s, robot = np.array([one.loop_duration_s for one in plan]), plan.mission.fleet.equal_robot("robot-1")
    slots = []
    for one, lasts_s in zip(plan, durations_s, strict=True):
        line = round_of(one)
        if lasts_s == 0:  # a robot that stays sees all that it sees whenever one comes there
            most_s = asked_periods_s(plan.mission)[0]
            least_s = 0.0 if only_visits(plan.mission) else MOMENT * most_s
            slots.append(Slot(line=line, least_s=least_s, most_s=most_s, keeps_step=False, passes=1.0))
            continue
        alike = int((np.abs(durations_s - lasts_s) <= SAME_ROUND * lasts_s).sum())
        most_s = float(lasts_s / max(worst_ratio, SAME_ROUND))
        periods_s = asked_periods_s(plan.mission)
        # who comes into a zone is in it a moment longer than at a place
        # a round that is hardly longer than a period takes that period
        near_s = (period_s for period_s in periods_s if lasts_s <= period_s <= most_s <= period_s * 1.01)
        most_s = next(near_s, most_s)
        passes = max(1.0, most_s / periods_s[0])
        line, has_mass = start_at(line, -one.loop_start_s), robot.motion.has_mass
        slots.append(
            Slot(
                line=line, least_s=line.duration_s, most_s=most_s, keeps_step=alike > 1, passes=passes,
                has_mass=has_mass, begins_amid_a_leg=has_mass and begins_amid_a_leg(line),
            )
        )  # fmt: skip
    return slots


def slower_slots(plan: Plan, slots: Sequence[Slot], judge: Judge) -> list[Slot]:
    """The slots, with rounds as long as the longest period for which the plan passes so.

    Each loop that keeps no step with others is slowed down in turn, all others being as they were. A robot that stays
    serves what is seen too seldom without it.
    """
    periods_s = np.array(asked_periods_s(plan.mission))
    slower = []
    for k, slot in enumerate(slots):
        enough_s = periods_s[periods_s > slot.most_s * (1 + SAME_ROUND)]
        others = (*plan.trajectories[:k], *plan.trajectories[k + 1 :])
        if slot.line.stays and len(enough_s):
            demands = judge(replace(plan, trajectories=others)).demands
            served_s = [demand.period_s for demand in demands if demand.worst_gap_s > demand.period_s]
            slot = replace(slot, most_s=min(served_s, default=float(periods_s[-1])))
        for period_s in () if slot.line.stays or slot.keeps_step else enough_s:
            slow = replace(slot, most_s=float(period_s), passes=1.0)
            if judge(replace(plan, trajectories=(*others, slowest(plan.trajectories[k], slow)))).verdict != "met":
                break
            slot = slow
        slower.append(slot)
    return slower


def slowest(one: Trajectory, slot: Slot) -> Trajectory:
    """The trajectory of a slot's robot when a round takes as long as it may."""
    line = stretch(slot.line, slot.slower(slot.most_s))
    line.times_s[-1] = slot.most_s
    changes = line.accelerations_m_s2 if line.accelerations_m_s2.any() else None
    return replace(
        one, times_s=line.times_s, positions_m=line.places_m, accelerations_m_s2=changes, loop_start_s=0.0,
        waypoints=None,
    )  # fmt: skip


def without_waits(slots: Sequence[Slot], speed_m_s: float) -> list[Slot]:
    """The slots, with rounds that are driven at full speed from corner to corner where no other loop keeps step."""
    hasty = []
    for slot in slots:
        steps_s = np.hypot(*np.diff(slot.line.places_m, axis=0).T) / (speed_m_s * SLOWER)
        if not slot.keeps_step and steps_s.sum() < slot.least_s * (1 - ROUNDING):
            kept = np.concatenate([[True], steps_s > 0])
            times_s = np.concatenate([[0.0], np.cumsum(steps_s)])[kept]
            line = steady(times_s, slot.line.places_m[kept])
            slot = replace(slot, line=line, least_s=line.duration_s)
        hasty.append(slot)
    return hasty


def only_visits(mission: Mission) -> bool:
    """Whether robots only have to come to places: a moment there is enough."""
    return mission.period_s is None and all(z.demand == "visit" for z in mission.zones if z.period_s is not None)


def asked_periods_s(mission: Mission) -> list[float]:
    """All periods that a mission asks for, ascending."""
    return sorted({p for p in (mission.period_s, *(zone.period_s for zone in mission.zones)) if p is not None})


def handovers_of(
    slots: Sequence[Slot], chargers: Sequence[Charger], ways: Ways, clearance_s: float
) -> list[list[Handovers]]:
    """Of each slot, for each charger, where robots may change; inf where no path leads, or walls leave no room.

    clearance_s: how long after each other robots with bodies are at a post of which one relieves the other.
    """
    spots = [spots_s(slot.line) for slot in slots]
    places = [slot.line.at(phases_s) for slot, phases_s in zip(slots, spots, strict=True)]
    chargers_m = np.array([charger.at for charger in chargers])
    lasts_s = [
        ways.last_s(
            slot.line, phases_s, chargers_m, slot.slower(slot.most_s), even_spots(phases_s, slot.line.duration_s)
        )
        for slot, phases_s in zip(slots, spots, strict=True)
    ]
    found = [
        [
            Handovers(
                charger=charger, phases_s=phases_s, places_m=places_m, ways_s=ways_s[k], turns_s=ways.turns_back_s
            )
            for k, charger in enumerate(chargers)
        ]
        for phases_s, places_m, ways_s in zip(spots, places, lasts_s, strict=True)
    ]
    return [
        [_with_passing(slot, each, ways, clearance_s) for each in own] for slot, own in zip(slots, found, strict=True)
    ]


def _with_passing(slot: Slot, own: Handovers, ways: Ways, clearance_s: float) -> Handovers:
    """The handovers of a post with ways on which robots pass each other, where its period is too short for others."""
    longest_s = slot.most_s - clearance_s
    if not slot.line.stays or clearance_s == 0 or longest_s < 0 or 2 * float(own.ways_s[0]) <= longest_s:
        return own
    passing = ways.passing(np.array(own.charger.at), own.places_m[0], clearance_s)
    if passing is None or passing.pause_s > slot.most_s:
        return own
    longer_s = max(passing.there.duration_s, passing.back.duration_s)
    return replace(own, ways_s=np.array([longer_s]), passing=passing)


def spots_s(line: TimedLine) -> Floats:
    """The phases (k,) of a round at which robots may change: its corners, and spots evenly between."""
    if line.stays:
        return np.zeros(1)
    even_s = np.arange(SPOTS) * (line.duration_s / SPOTS)
    return np.unique(np.concatenate([line.times_s[:-1], even_s]))


def even_spots(phases_s: Floats, lasts_s: float) -> Ints:
    """Which of the phases of a round of so many seconds, ascending, are the spots evenly between (SPOTS,)."""
    found: Ints = np.searchsorted(phases_s, np.arange(SPOTS) * (lasts_s / SPOTS) - SAME_TIME_S)
    return found
