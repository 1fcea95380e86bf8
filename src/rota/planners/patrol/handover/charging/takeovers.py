"""Plans in which robots that charge take over: those that remain fly the flights as before, or in longer turns."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import islice
from typing import NamedTuple

import numpy as np

from rota.errors import PlanError
from rota.geometry.free_space import free_ground
from rota.model.mission import TOUCH_M, Charger, Robot
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.driving.timed_line import TimedLine, steady
from rota.planners.patrol.handover.charging.arrivals import Arrivals
from rota.planners.patrol.handover.charging.flyers import Arrival, Flyer, Transfer, fills_s, flight_left
from rota.planners.patrol.handover.charging.timetables import (
    FAR,
    Round,
    Timetable,
    circulations,
    round_of,
    stay_at,
    timetables_of,
)
from rota.planners.patrol.handover.rounds import HALVINGS, PHASES, is_clear
from rota.planners.patrol.relief.ways import Motion, Ways
from rota.planners.patrol.tolerances import SHORTEST_S
from rota.planners.patrol.traffic.starts.assignment import least_sum
from rota.planners.patrol.traffic.starts.paths_by_body import PathsByBody
from rota.planning.planner import Handover


def takeovers_with_chargers(asked: Handover) -> Iterator[Plan]:
    """Plans for robots that charge; see ``Planner.takeovers``."""
    if asked.going_on.keys() == asked.places.keys():
        lines = tuple(asked.going_on[robot.name] for robot in asked.mission.fleet.robots or ())
        yield Plan(mission=asked.mission, seed=asked.seed, seam=asked.seam, trajectories=lines)
    takeover = _Takeover(asked)
    if not takeover.is_possible():
        return
    for spare in (True, False):
        found = False
        for rounds in takeover.rounds():
            for plan in takeover.plans(rounds, spare=spare):
                found = True
                yield plan
        if found:
            return


class _Taken(NamedTuple):
    """The k-th robot comes into a round that is so far on now."""

    k: int
    own: Arrivals
    now_s: float
    arrival: Arrival


class _Takeover:
    """The robots that remain, and what they are to fly."""

    def __init__(self, asked: Handover) -> None:
        self._asked, self._mission = asked, asked.mission
        robots = asked.mission.fleet.robots or ()
        self._robot = max(robots, key=lambda robot: robot.body_radius_m)
        self._ways = Ways(self._robot, PathsByBody(asked.mission))
        self._flyers = [self._flyer(robot) for robot in robots]

    def _flyer(self, robot: Robot) -> Flyer:
        """A robot as it is now, or where its flight ends if it cannot leave that at once."""
        lands_s, climbs_s = self._still_s(robot)
        now = Flyer(
            robot=robot, place_m=np.array(self._asked.places[robot.name]), level_s=self._level_s(robot),
            charger=self._charger_of(robot.name), lands_s=lands_s, climbs_s=climbs_s,
        )  # fmt: skip
        if robot.turns_at_once:
            return now
        if now.charger is not None:
            return self._with_transfers(replace(now, lands=steady(np.zeros(1), now.place_m[None])))
        line = self._asked.going_on.get(robot.name)
        if line is None:
            return self._comes_to_a_charger(now)
        if not line.charges:
            return now
        lands, used_s, charger = flight_left(line, robot, self._mission.chargers)
        return self._with_transfers(
            replace(now, place_m=lands.places_m[-1], level_s=now.level_s - used_s, charger=charger, lands=lands)
        )

    def _with_transfers(self, one: Flyer) -> Flyer:
        """A robot that is on a charger in the end, with its ways to others: it leaves as soon as it has climbed.

        Who has too little left for a way charges first.
        """
        assert one.lands is not None, f"{one.robot.name} lands nowhere"
        assert one.charger is not None, f"{one.robot.name} lands nowhere"
        battery, found, begins_s = one.robot.battery, list[Transfer](), one.lands.duration_s
        grounding_s = one.lands_s + one.climbs_s if begins_s == 0 else max(battery.grounding_s, self._ways.pause_s)
        for other in self._mission.chargers:
            way = None if other is one.charger else self._way_between(one.charger, other)
            if way is None:
                continue
            used_s = battery.departure_s + way.duration_s * max(1.0, battery.standing_uses)
            lacks_s = max(battery.reserve_s + used_s - one.level_s, 0.0)
            charges_s = fills_s(one.robot, one.charger, lacks_s)
            if used_s > battery.usable_s or not math.isfinite(charges_s):
                continue
            found.append(
                Transfer(
                    charger=other, way=way, leaves_s=begins_s + grounding_s + charges_s,
                    level_s=one.level_s + lacks_s - used_s, fills_s=fills_s(one.robot, other, used_s),
                )
            )  # fmt: skip
        return replace(one, transfers=tuple(found))

    def _way_between(self, charger: Charger, other: Charger) -> TimedLine | None:
        """The way from rest on a charger to rest on another one; None: there is none."""
        way = self._ways.way(np.array(other.at), Motion(np.array(charger.at), None, 0.0, math.inf))
        return None if way is None else way.line_to(1.0).backwards()

    def _comes_to_a_charger(self, new: Flyer) -> Flyer:
        """One that is new, and stands away from chargers, on its way to the one that it comes to soonest."""
        stands = Motion(new.place_m, None, 0.0, math.inf)
        ways = [(one, self._ways.way(np.array(one.at), stands)) for one in self._mission.chargers]
        lines = [(one, way.line_to(1.0).backwards()) for one, way in ways if way is not None]
        if not lines:
            return new
        charger, lands = min(lines, key=lambda each: each[1].duration_s)
        return replace(
            new, place_m=lands.places_m[-1], level_s=new.level_s - lands.duration_s, charger=charger, lands=lands
        )

    def _level_s(self, robot: Robot) -> float:
        """What a robot has left; one that is new and on no charger has taken off."""
        level_s = self._asked.batteries[robot.name] * (robot.battery.endurance_s or np.inf)
        takes_off = robot.name not in self._asked.going_on and self._charger_of(robot.name) is None
        return level_s - robot.battery.departure_s * takes_off

    def _still_s(self, robot: Robot) -> tuple[float, float]:
        """How long a robot on a charger has still to land there, and to climb before it can leave."""
        battery = robot.battery
        for driven in self._asked.seam.driven if self._asked.seam is not None else ():
            if driven.robot == robot.name and driven.charges and driven.charges[-1].until_s == 0:
                came_s = driven.charges[-1].from_s
                lands_s = battery.landing_s + came_s if came_s > driven.times_s[0] else 0.0
                return max(lands_s, 0.0), battery.climbing_s - driven.climbed_s
        return 0.0, battery.climbing_s

    def _charger_of(self, name: str) -> Charger | None:
        """The charger that a robot is on; of a new one that at which it stands."""
        chargers = {charger.name: charger for charger in self._mission.chargers}
        line = self._asked.going_on.get(name)
        if line is not None:
            return next((chargers[one.charger] for one in line.charges if one.from_s == 0), None)
        here = np.array(self._asked.places[name])
        return next((one for one in chargers.values() if np.hypot(*(here - one.at)) <= TOUCH_M), None)

    def is_possible(self) -> bool:
        """Whether every robot that remains can fly the flights of the plan before now."""
        if len({(one.robot.battery, one.robot.ground_speed_m_s, one.robot.sensor) for one in self._flyers}) > 1:
            return False
        if any(one.lands is None and not one.robot.turns_at_once for one in self._flyers):
            return False  # one that never charges, or has no way to a charger
        ground, body_m = free_ground(self._mission), self._robot.body_radius_m
        return all(is_clear(line.positions_m[line.loop_index :, :2], ground, body_m) for line in self._asked.loops)

    def rounds(self) -> Iterator[list[Round]]:
        """Rounds for so many robots as remain: as they were, those of the timetables, or of some with longer turns."""
        robots, loops = len(self._flyers), self._asked.loops
        if robots >= len(loops) and all(line.charges for line in loops):
            each = [Round(way=line, robots=1, turn_s=line.loop_duration_s) for line in loops]
            yield each + self._stays(robots - len(loops), [each])
        timetables = timetables_of(loops, self._robot, self._mission.chargers)
        if timetables is None:
            return
        flown = [self._rounds_of(one) for one in timetables]
        counts = [sum(round_.robots for round_ in own) for own in flown]
        spare = robots - sum(counts)
        if spare >= 0:
            yield [round_ for own in flown for round_ in own] + self._stays(spare, flown)
            return
        for fewer in _divisions(counts, robots):
            longer = [
                own if count == most else self._fit(one, count)
                for own, one, count, most in zip(flown, timetables, fewer, counts, strict=True)
            ]
            if all(own is not None for own in longer):
                yield [round_ for own in longer for round_ in own or ()]

    def _rounds_of(self, timetable: Timetable) -> list[Round]:
        """The rounds that the fewest robots fly by a timetable."""
        places = {charger.name: np.array(charger.at) for charger in self._mission.chargers}
        return [round_of(own, timetable.turn_s, places[own[0][0].from_charger]) for own in circulations(timetable)]

    def _fit(self, timetable: Timetable, robots: int) -> list[Round] | None:
        """The rounds of the same flights in the shortest turns in which so many robots fly them."""
        if robots == 0:
            return []
        shortest_s = max(timetable.busy_s / robots, timetable.turn_s)
        for step in range(200):  # by so many hundredths turns are longer than if no robot waited
            longer = timetable.with_turn(shortest_s * (1 + step / 100))
            found = self._rounds_of(longer)
            if sum(round_.robots for round_ in found) <= robots:
                to_spare = robots - sum(round_.robots for round_ in found)
                return found + self._stays(to_spare, [found])
        return None

    def _stays(self, robots: int, flown: Sequence[Sequence[Round]]) -> list[Round]:
        """Robots with nothing to do stay at the chargers with most room."""
        room = {charger.name: float(charger.places) for charger in self._mission.chargers}
        for round_ in (each for own in flown for each in own):
            for charge in round_.way.charges:
                stays_s = charge.until_s - charge.from_s
                room[charge.charger] -= stays_s / (round_.turn_s or stays_s)
        found = []
        for _ in range(robots):
            charger = max(self._mission.chargers, key=lambda one: room[one.name])
            room[charger.name] -= 1
            found.append(stay_at(charger))
        return found

    def plans(self, rounds: Sequence[Round], *, spare: bool) -> Iterator[Plan]:
        """Plans in which robots fly these rounds: better and better ones. spare: with more left than that takes."""
        lands = not all(one.robot.turns_at_once for one in self._flyers)
        for moving in (True, False) if lands else (True,):
            chargers = self._mission.chargers
            arrivals = [Arrivals(one, self._flyers, chargers, self._ways, moving=moving, spare=spare) for one in rounds]
            taken = self._assign(arrivals, 0.0)
            found = self._ranks(taken)
            yield from (plan for _, plan in found)
            empty_s = max((each.arrival.unserved_s for each in taken), default=0.0)
            if found and empty_s <= 0:
                return
            if not any(each.arrival.enters is not None for each in taken):
                break
        if not found:
            empty_s = max((round_.turn_s for round_ in rounds), default=0.0)
        if empty_s > 0:
            yield from self._shift(arrivals, empty_s, [(rank, 0.0, plan) for rank, plan in found])

    def _shift(
        self, arrivals: Sequence[Arrivals], empty_s: float, found: list[tuple[tuple[float, ...], float, Plan]]
    ) -> Iterator[Plan]:
        """Plans with the clock of all rounds shifted by so much at most, better and better ones.

        Who is on a flight has to end it, and nobody need be missed meanwhile. found: how late plans are that there are
        already, with shifts, and they themselves.
        """

        def look(late_s: float) -> None:
            """Note the plan with all rounds so much later."""
            found.extend((rank, late_s, plan) for rank, plan in self._ranks(self._assign(arrivals, late_s)))
            found.sort(key=lambda one: one[:2])

        step_s = empty_s / PHASES
        for late_s in step_s * np.arange(1, PHASES + 1):
            look(float(late_s))
        for _ in range(HALVINGS):
            if not found:
                return
            best_s, step_s = found[0][1], step_s / 2
            yield found[0][2]
            for late_s in (best_s - step_s, best_s + step_s):
                if late_s >= 0:
                    look(late_s)
        yield from (plan for _, _, plan in islice(found, 3))

    def _ranks(self, taken: Sequence[_Taken]) -> list[tuple[tuple[float, ...], Plan]]:
        """Plans of robots that take roles, the least late first, with how late they are."""
        return sorted(((self._asked.lateness(plan), plan) for plan in self._plans_of(taken)), key=lambda one: one[0])

    def _assign(self, arrivals: Sequence[Arrivals], late_s: float) -> list[_Taken]:
        """Who takes which role in rounds, so much later, so that they are empty for least time; nothing: nobody can."""
        roles = [
            (own, (number * own.round.turn_s - late_s) % (own.round.way.loop_duration_s or 1.0))
            for own in arrivals
            for number in range(own.round.robots)
        ]
        every = [[own.arrival(k, now_s) for own, now_s in roles] for k in range(len(self._flyers))]
        # how soon a robot is in its round counts only where nobody is missed
        costs = [[min(one.unserved_s + 1e-3 * min(one.joins_s, FAR), FAR) for one in row] for row in every]
        pairs = list(zip(*least_sum(np.array(costs)), strict=True))
        if any(costs[k][role] >= FAR for k, role in pairs):
            return []
        return [
            _Taken(int(k), own, now_s, own.finer(k, now_s, every[k][role]))
            for k, role in pairs
            for own, now_s in [roles[role]]
        ]

    def _plans_of(self, taken: Sequence[_Taken]) -> Iterator[Plan]:
        """The plan in which robots catch up with rounds that move, and one in which they are behind for a flight."""
        if not taken:
            return
        behind = [self._behind(each) for each in taken]
        for each in (taken, behind) if any(a is not b for a, b in zip(taken, behind, strict=True)) else (taken,):
            with suppress(PlanError):  # ways so short that their times are one but for rounding
                lines = {self._flyers[one.k].robot.name: self._line(one) for one in each}
                yield Plan(
                    mission=self._mission, seed=self._asked.seed, seam=self._asked.seam,
                    trajectories=tuple(lines[robot.name] for robot in self._mission.fleet.robots or ()),
                )  # fmt: skip

    def _behind(self, one: _Taken) -> _Taken:
        """The same of a robot that comes into a flight that is under way, and is behind to its end, if it can be."""
        arrival = None if one.arrival.enters is None else one.own.behind(one.k, one.now_s)
        return one if arrival is None else one._replace(arrival=arrival)

    def _line(self, one: _Taken) -> Trajectory:
        """What a robot flies; where that is what it would have flown before, exactly that."""
        name = self._flyers[one.k].robot.name
        line = one.own.trajectory(one.k, one.arrival, self._asked.batteries[name])
        before = self._asked.going_on.get(name)
        return line if before is None or not _is_same(before, line) else before


def _divisions(counts: Sequence[int], robots: int) -> list[list[int]]:
    """Ways to have fewer robots at timetables that take so many: from one of them, or from all alike."""
    lacking, found = sum(counts) - robots, list[list[int]]()
    for k, count in enumerate(counts):
        if count > lacking:
            found.append([*counts[:k], count - lacking, *counts[k + 1 :]])
    alike = list(counts)
    for _ in range(lacking):
        k = max(range(len(alike)), key=lambda k: (alike[k] / counts[k], alike[k]))
        alike[k] -= 1
    if min(alike) > 0 and alike not in found:
        found.append(alike)
    return found


def _is_same(before: Trajectory, line: Trajectory) -> bool:
    """Whether a robot flies as it would have before."""
    if abs(before.loop_duration_s - line.loop_duration_s) > SHORTEST_S:
        return False
    moments_s = np.union1d(before.times_s, line.times_s)
    same = np.abs(before.at(moments_s)[:, :2] - line.at(moments_s)[:, :2]).max() <= TOUCH_M
    stays = [round(sum(one.until_s - one.from_s for one in way.charges if one.from_s >= way.loop_start_s), 3)
             for way in (before, line)]  # fmt: skip
    return bool(same) and stays[0] == stays[1]
