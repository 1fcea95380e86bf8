"""The robots that take turns at some slots: from which chargers, in which cycles, and when."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from rota.errors import NoPlanFound
from rota.model.arrays import Floats
from rota.model.mission import Charger, Mission
from rota.model.plan import Trajectory
from rota.planners.patrol.relief.flights import flight, on_shortest_ways, robot_of_jobs, trajectories_of
from rota.planners.patrol.relief.landings import as_from_one, landings_of
from rota.planners.patrol.relief.roomy import cycles_with_room
from rota.planners.patrol.relief.shifts import Clearance, Cycle, best_cycle
from rota.planners.patrol.relief.slots import (
    MOMENT,
    Handovers,
    Slot,
    chargers_by_way,
    for_wings,
    handovers_of,
    nearest_s,
)
from rota.planners.patrol.relief.turns import Rotation, rotations_of
from rota.planners.patrol.relief.ways import Ways
from rota.planners.patrol.relief.ways_apart import lead_apart
from rota.planners.patrol.tolerances import SAME_TIME_S
from rota.planners.patrol.verdict import robots_in_words

MORE = 4  # robots than a cycle takes at least are too many for it


def _robots(cycles: Sequence[Cycle]) -> int:
    """How many robots some cycles take."""
    return sum(cycle.robots for cycle in cycles)


class Team:
    """The slots of a mission, and from where chargers are near."""

    def __init__(
        self,
        mission: Mission,
        slots: Sequence[Slot],
        ways: Ways,
        turns_s: Floats | None,
        clearance: Clearance,
        sharing: int,
    ) -> None:
        self._mission, self._slots, self._turns_s = mission, slots, turns_s
        self._robot = mission.fleet.equal_robot("robot-1")
        self._ways, self._clearance = ways, clearance
        self._at_each = handovers_of(slots, mission.chargers, ways, self._clearance.seconds)
        battery = self._robot.battery
        self._handovers = [[as_from_one(own, sharing, battery)] if sharing else own for own in self._at_each]
        self._known: dict[tuple[int, ...], Cycle | None] = {}
        slots = slots if self._robot.battery.can_stand else [for_wings(slot) for slot in slots]
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
        """The handovers of each slot with the charger of a cycle, or with all that are shared."""
        return [next((each for each in every if each.charger is cycle.charger), every[0]) for every in self._handovers]

    def _crew(self, rotations: Sequence[Rotation]) -> tuple[list[Rotation], Iterator[str]]:
        """The rotations with all robots of a named fleet, and their names; NoPlanFound where these are too few."""
        named, rotations = self._mission.fleet.robots, list(rotations)
        total = sum(rotation.robots for rotation in rotations)
        if named is not None and len(named) > total:  # the first rotation has the robots that are to spare
            rotations[0] = replace(rotations[0], robots=rotations[0].robots + len(named) - total)
            total = len(named)
        if named is not None and len(named) < total:
            raise NoPlanFound(
                f"{robots_in_words(total)} are needed, those that charge included; the fleet has {len(named)}"
            )
        return rotations, iter([robot.name for robot in named] if named else [f"robot-{k + 1}" for k in range(total)])

    def on_free_places(self, rotations: Sequence[Rotation]) -> list[Trajectory]:
        """The trajectories of robots that land on any charger with a free place; NoPlanFound where one finds none."""
        rotations, names = self._crew(rotations)
        planned = [every[0] for every in self._handovers]
        landings = landings_of(rotations, self._slots, planned, self._at_each, self._robot.battery)
        if landings is None:
            raise NoPlanFound("a robot that lands finds no charger with a free place")
        found = []
        for name, served in zip(names, landings.served.values(), strict=True):
            jobs = []
            for service, comes_from, goes_to in served:
                slot, own = self._slots[service.job.shift.slot], self._at_each[service.job.shift.slot]
                flown = flight(service.job, slot, own[comes_from], own[goes_to], self._ways)
                jobs.append((service.meets_s - flown.into.duration_s, flown.line))
            found.append(robot_of_jobs(name, self._mission.chargers, jobs, landings.lasts_s))
        return found

    def trajectories(self, rotations: Sequence[Rotation], seed: int) -> tuple[list[Trajectory], bool]:
        """The trajectories of all robots, and whether no two touch on their ways as far as that was looked for."""
        rotations, names = self._crew(rotations)
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
