"""Loops that were planned as if batteries lasted for ever, and robots that charge and take turns at them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np

from rota.errors import NoPlanFound
from rota.model.arrays import Floats
from rota.model.battery_limits import ENDLESS
from rota.model.mission import Charger, Mission, Robot
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.bounds.charging_bound import charging_of
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.relief.flights import on_shortest_ways, trajectories_of
from rota.planners.patrol.relief.posts import with_fewer_posts
from rota.planners.patrol.relief.roomy import cycles_with_room
from rota.planners.patrol.relief.shifts import Clearance, Cycle, best_cycle, time_to_stop_s
from rota.planners.patrol.relief.slots import (
    MOMENT,
    WINGS,
    Handovers,
    Slot,
    chargers_by_way,
    handovers_of,
    slots_of,
    slower_slots,
    without_waits,
)
from rota.planners.patrol.relief.turns import Rotation, rotations_of
from rota.planners.patrol.relief.ways import Ways
from rota.planners.patrol.relief.ways_apart import lead_apart
from rota.planners.patrol.tolerances import SAME_TIME_S
from rota.planners.patrol.traffic.starts.paths_by_body import PathsByBody
from rota.planners.patrol.verdict import Judge, crowding, robots_in_words, worst_reached

MORE = 4  # robots than a cycle takes at least are too many for it
MOST_TRIES = 12  # of robots with bodies, which may touch on their ways: with turns at the same loops, and on circuits


def endless(mission: Mission) -> Mission:
    """The mission as if batteries lasted for ever, with as few robots as possible.

    Periods are shorter by what it takes to pass on a loop from body to body.
    """
    clearance_s = clearance_of(mission) / (1 - PatrolSettings.of(mission).period_margin)  # the reserve takes its share

    def shorter_s(period_s: float | None) -> float | None:
        return None if period_s is None else max(period_s - clearance_s, period_s / 2)

    zones = tuple(replace(zone, period_s=shorter_s(zone.period_s)) for zone in mission.zones)
    return replace(without_batteries(mission), period_s=shorter_s(mission.period_s), zones=zones)


def without_batteries(mission: Mission) -> Mission:
    """The mission as it is asked, but for batteries and the number of robots: what bounds are proved for."""
    return replace(mission, fleet=replace(mission.fleet, robots=None, battery=ENDLESS), chargers=())


def clearance_of(mission: Mission) -> float:
    """By how many seconds robots pass one place after each other when one relieves the other; 0 without bodies."""
    robot = mission.fleet.equal_robot("robot-1")
    return 3.0 * robot.body_radius_m / robot.ground_speed_m_s  # radii: at right angles their centres keep 2.1 apart


def require_reach(mission: Mission) -> None:
    """NoPlanFound where no flight lasts from a charger to ground that is asked for and back."""
    if (charging := charging_of(mission)).ways >= 1:
        battery = mission.fleet.battery
        taken = f" and {battery.departure_s:.6g} to take off" if battery.departure_s else ""
        raise NoPlanFound(
            f"fleet.endurance_s: {battery.endurance_s:.6g} less a reserve of {battery.reserve_s:.6g}{taken} is too"
            " short: from a charger to ground that is asked for and back takes at least"
            f" {charging.ways * battery.usable_s:.6g} s; give more, or a charger nearer by"
        )


def relieve(
    loops: Plan, mission: Mission, *, seed: int, judge: Judge, briefly: bool = False, steadily: bool = False,
    turns_s: Floats | None = None,
) -> Plan:  # fmt: skip
    """A plan for the mission whose robots take turns at the loops of a plan for ``endless(mission)``.

    briefly: the first try alone. steadily: robots change where loops are driven at a constant velocity. turns_s: how
    long turns at loops may be; None: anything. Raises NoPlanFound where a loop is too far from all chargers for the
    battery, where chargers have too little room, and where the judge passes no plan.
    """
    verdict = judge(loops)
    ratio = max((demand.worst_gap_s / demand.period_s for demand in verdict.demands), default=1.0)
    slots = slots_of(loops, ratio)
    robot = mission.fleet.equal_robot("robot-1")
    ways, found, full = Ways(robot, PathsByBody(mission), steadily=steadily), None, None

    def plan_of(
        served: Sequence[Slot], below: float = math.inf, *, number: int, heeds_places: bool, gives_way: bool
    ) -> Plan:
        """The plan whose robots take turns at these slots, if less than ``below`` can; number: of the try."""
        lands = gives_way and number % 2 == 1  # or has time to stop, by turns
        stops_s = time_to_stop_s(robot) if gives_way and not lands else 0.0
        clearance = Clearance(clearance_of(mission) + stops_s, gives_way, lands)
        team = _Team(mission, served, ways, turns_s, clearance)
        rotations = team.rotations(seed + number, varied=number > 0, below=below, heeds_places=heeds_places)
        robots, is_clear = team.trajectories(rotations, seed + number)
        plan = replace(loops, mission=mission, trajectories=tuple(robots))
        if not is_clear:
            raise NoPlanFound("bodies touch where robots relieve each other", best=plan)
        return plan

    has_bodies = clearance_of(mission) > 0
    numbers, modes = range(MOST_TRIES // 2 if has_bodies else 1), (False, True) if has_bodies else (False,)
    tries, crowded = list(itertools.product(_paces(slots, loops, robot, judge), numbers, modes)), False
    barren: Sequence[Slot] = ()
    for heeds_places, (tried, number, gives_way) in itertools.product((False, True), tries[: 1 if briefly else None]):
        if heeds_places and (not crowded or tried is barren):
            continue
        own_plan = partial(plan_of, number=number, heeds_places=heeds_places, gives_way=gives_way)
        try:
            found = own_plan(tried)
        except NoPlanFound as failure:
            if isinstance(failure.best, Plan):
                found, crowded = failure.best, True
            elif heeds_places:
                barren = tried
            elif not gives_way:
                raise
            continue
        if (verdict := judge(found)).verdict == "met":
            if mission.fleet.robots is not None:
                return found
            return with_fewer_posts(found, tried, own_plan, judge)
        crowded |= (lacks_places := crowding(verdict)) is not None
        if full is None and worst_reached(verdict) == lacks_places:
            full = found  # what would help is places, whatever else later plans come to
    best = full or found
    assert best is not None
    raise NoPlanFound(f"with relief the plan does not pass the check: {worst_reached(judge(best))}", best=best)


def _paces(slots: Sequence[Slot], loops: Plan, robot: Robot, judge: Judge) -> list[Sequence[Slot]]:
    """The slots of loops without waits and as slowly as may be, so slowly, as they are, and as fast as can be."""
    slower = slower_slots(loops, slots, judge)
    hasty = without_waits(slower, robot.ground_speed_m_s) if robot.turns_at_once else slower
    tight = [replace(slot, most_s=slot.most_s if slot.line.stays else slot.least_s) for slot in slots]
    return list({tuple(map(id, each)): each for each in (hasty, slower, slots, tight)}.values())  # some are the same


def _robots(cycles: Sequence[Cycle]) -> int:
    """How many robots some cycles take."""
    return sum(cycle.robots for cycle in cycles)


def nearest_s(handovers: Sequence[Handovers]) -> float:
    """The shortest way between a slot and a charger."""
    return min(float(own.ways_s.min()) for own in handovers)


def _for_wings(slot: Slot) -> Slot:
    """The slot of robots that go round it hardly more slowly than they can."""
    return slot if slot.line.stays else replace(slot, slowest_s=slot.line.duration_s / WINGS)


class _Team:
    """The slots of a mission, and from where chargers are near."""

    def __init__(
        self,
        mission: Mission,
        slots: Sequence[Slot],
        ways: Ways,
        turns_s: Floats | None,
        clearance: Clearance,
    ) -> None:
        self._mission, self._slots, self._turns_s = mission, slots, turns_s
        self._robot = mission.fleet.equal_robot("robot-1")
        self._ways, self._clearance = ways, clearance
        self._handovers = handovers_of(slots, mission.chargers, ways, self._clearance.seconds)
        self._known: dict[tuple[int, ...], Cycle | None] = {}
        slots = slots if self._robot.battery.can_stand else [_for_wings(slot) for slot in slots]
        # who comes from a charger to a place beside it has not been there unless it stays for a moment
        self._slots = [
            replace(slot, least_s=max(slot.least_s, MOMENT * slot.most_s * (nearest_s(own) <= SAME_TIME_S)))
            for slot, own in zip(slots, self._handovers, strict=True)
        ]

    def cycles(self) -> list[Cycle]:
        """The slots in cycles that take the fewest robots: each slot at the charger nearest to it, or all at one."""
        nearest = [
            next((k for k in by_way if self._cycle_of([slot], k)), by_way[0])
            for slot, by_way in enumerate(map(chargers_by_way, self._handovers))
        ]
        tried = [self._cycles_at(nearest)]
        for charger in range(len(self._mission.chargers) if len(set(nearest)) > 1 else 0):
            with suppress(NoPlanFound):
                tried.append(self._cycles_at([charger] * len(nearest)))
        roomy = [cycles for cycles in tried if all(self._has_room(cycle.charger, cycles) for cycle in cycles)]
        return min(roomy or tried, key=_robots)

    def _has_room(self, charger: Charger, cycles: Sequence[Cycle]) -> bool:
        """Whether a charger has places for the robots that are not at slots, when one is at each."""
        return sum(c.robots - len(c.shifts) for c in cycles if c.charger is charger) <= charger.places

    def _cycles_at(self, chargers: Sequence[int]) -> list[Cycle]:
        """The cycles of slots that are served from these chargers, by their numbers."""
        return [
            cycle
            for charger in sorted(set(chargers))
            for cycle in self._cycles_of([k for k, own in enumerate(chargers) if own == charger], charger)
        ]

    def _cycles_of(self, members: Sequence[int], charger: int) -> list[Cycle]:
        """The slots of a charger in cycles: all in one, or two by two as long as that spares a robot."""
        alone = [self._cycle_of([k], charger) for k in members]
        for k, each in zip(members, alone, strict=True):
            if each is None:
                raise NoPlanFound(self._too_far(k, charger))
        cycles = [each for each in alone if each is not None]
        together = self._cycle_of(members, charger)
        if together is not None and together.robots <= _robots(cycles):
            return [together]
        while True:
            pairs = itertools.combinations(cycles, 2)
            merged = [(a, b, self._cycle_of([s.slot for s in (*a.shifts, *b.shifts)], charger)) for a, b in pairs]
            better = [(a, b, c) for a, b, c in merged if c is not None and c.robots < a.robots + b.robots]
            if not better:
                return cycles
            a, b, c = min(better, key=lambda each: each[2].robots - each[0].robots - each[1].robots)
            cycles = [each for each in cycles if each is not a and each is not b] + [c]

    def _cycle_of(self, slots: Sequence[int], charger: int) -> Cycle | None:
        """The cycle of some slots at a charger, by their numbers, kept for the next time; None: none does."""
        key = (*slots, charger)
        if key not in self._known:
            own, battery = [each[charger] for each in self._handovers], self._robot.battery
            self._known[key] = best_cycle(self._slots, own, slots, battery, self._clearance, turns_s=self._turns_s)
        return self._known[key]

    def _too_far(self, slot: int, charger: int) -> str:
        """That no robot can serve a slot from a charger within a battery."""
        own, line = self._handovers[slot][charger], self._slots[slot].line
        farthest = int(np.argmax(np.where(np.isfinite(own.ways_s), own.ways_s, 0.0)))  # from others none was found
        at = farthest if 2 * own.ways_s[farthest] > self._robot.battery.usable_s else own.nearest
        way_s, (x, y) = float(own.ways_s[at]), own.places_m[at]
        battery = self._robot.battery
        if not np.isfinite(way_s):
            return f"no charger can be reached from ({x:.6g}, {y:.6g}), where a robot is needed: give one there"
        return (
            f"fleet.endurance_s: a robot has {battery.usable_s:.6g} s to use; from charger {own.charger.name!r} to"
            f" ({x:.6g}, {y:.6g}) and back it takes {2 * way_s:.6g} s, and a round there {line.duration_s:.6g} s:"
            " give more, or a charger nearer by"
        )

    def rotations(self, seed: int, *, varied: bool, below: float, heeds_places: bool) -> list[Rotation]:
        """The rotations of all slots, with less than ``below`` robots. Raises NoPlanFound where there are none."""
        if heeds_places:
            tried = cycles_with_room(self._slots, self._handovers, self._robot.battery, self._clearance, self._turns_s)
            found = (self._rotations_of(cycles, seed, varied, 1) for cycles in tried if _robots(cycles) < below)
        else:
            cycles = self.cycles()
            if (more := below - _robots(cycles)) <= 0:
                raise NoPlanFound(f"{robots_in_words(int(below))} or more are needed")
            found = (self._rotations_of(each, seed, varied, int(min(more, MORE))) for each in [cycles])
        if (rotations := next((each for each in found if each), None)) is None:
            raise NoPlanFound("robots that keep step with each other cannot be relieved in time")
        return rotations

    def _rotations_of(self, cycles: Sequence[Cycle], seed: int, varied: bool, more: int) -> list[Rotation]:
        """The rotations of these cycles, of each with less than ``more`` robots to spare; none where one has none."""
        rotations: list[Rotation] = []
        for cycle in cycles:
            own = self._own(cycle)
            tried = (
                rotations_of(cycle, self._slots, own, cycle.robots + spare, seed, varied=varied)
                for spare in range(more)
            )
            found = next((each for each in tried if each is not None), None)
            if found is None:
                return []
            rotations += found
        return rotations

    def _own(self, cycle: Cycle) -> list[Handovers]:
        """The handovers of each slot with the charger of a cycle."""
        return [next(each for each in every if each.charger is cycle.charger) for every in self._handovers]

    def trajectories(self, rotations: Sequence[Rotation], seed: int) -> tuple[list[Trajectory], bool]:
        """The trajectories of all robots, and whether no two touch on their ways as far as that was looked for."""
        named, rotations = self._mission.fleet.robots, list(rotations)
        total = sum(rotation.robots for rotation in rotations)
        if named is not None and len(named) > total:  # the first rotation has the robots that are to spare
            rotations[0] = replace(rotations[0], robots=rotations[0].robots + len(named) - total)
            total = len(named)
        if named is not None and len(named) < total:
            raise NoPlanFound(
                f"{robots_in_words(total)} are needed, those that charge included; the fleet has {len(named)}"
            )
        names = iter([robot.name for robot in named] if named else [f"robot-{k + 1}" for k in range(total)])
        flown, is_clear = (
            [on_shortest_ways(each, self._slots, self._own(each.cycle), self._ways) for each in rotations],
            True,
        )
        if self._clearance.seconds > 0:
            own = [self._own(rotation.cycle) for rotation in rotations]
            flown, is_clear = lead_apart(rotations, flown, self._slots, own, self._ways, self._robot, seed)
        return [
            trajectory
            for rotation, flights in zip(rotations, flown, strict=True)
            for trajectory in trajectories_of(rotation, flights, list(itertools.islice(names, rotation.robots)))
        ], is_clear
