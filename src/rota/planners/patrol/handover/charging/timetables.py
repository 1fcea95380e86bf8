"""Timetables of flights, read from a plan, and the fewest robots that fly one.

Robots that take turns at loops fly the same flights, a turn apart from each other: each flight begins again and again
after a turn, whoever flies it. Who flies what next is free. With each robot charged between two flights as much as the
first one takes, the fewest robots follow from an assignment of flights to the flights after them that wait least: the
cycles of that permutation are rounds, each of a whole number of turns, and takes as many robots.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rota.model.arrays import Floats
from rota.model.mission import Charger, Robot
from rota.model.plan import Charge, Trajectory
from rota.model.trajectory import forward_accelerations
from rota.planners.patrol.driving.timed_line import TimedLine, steady
from rota.planners.patrol.handover.rounds import COMPARED, SAME_M
from rota.planners.patrol.tolerances import SAME_ROUND
from rota.planners.patrol.traffic.starts.assignment import least_sum
from rota.routes.charging_legs import charging_legs
from rota.routes.flights import flights_of, has_flights
from rota.routes.moments import go_on

MISSED_S = 1e-7  # by which a robot may be charged too late for a flight: rounding
FAR = 1e9  # seconds: what a flight from another charger, or a round that a robot never comes into, counts as


@dataclass(frozen=True, kw_only=True, eq=False)
class RegularFlight:
    """A flight that begins again after every turn, at ``begins_s`` of it.

    line: from time 0 on, from ``from_charger`` to ``charger``. stays_s: how long its robot then lands, charges for what
    it took, and climbs.
    """

    line: TimedLine
    from_charger: str
    charger: str
    begins_s: float
    stays_s: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Timetable:
    """Flights that each begin again and again after ``turn_s``."""

    turn_s: float
    flights: tuple[RegularFlight, ...]

    def with_turn(self, turn_s: float) -> Timetable:
        """The same flights in turns of another length, each as far into it."""
        times = turn_s / self.turn_s
        flights = tuple(replace(flight, begins_s=flight.begins_s * times) for flight in self.flights)
        return Timetable(turn_s=turn_s, flights=flights)

    @property
    def busy_s(self) -> float:
        """How long all its flights of a turn keep robots busy, which charge between them."""
        return sum(flight.line.duration_s + flight.stays_s for flight in self.flights)


@dataclass(frozen=True, kw_only=True, eq=False)
class Round:
    """What ``robots`` robots fly, a turn apart from each other, and begin anew after it: ``way``, whose time 0 is that
    of the timetable. One that stays at a charger has one robot and no loop.
    """

    way: Trajectory
    robots: int
    turn_s: float


def timetables_of(loops: Sequence[Trajectory], robot: Robot, chargers: Sequence[Charger]) -> list[Timetable] | None:
    """The timetables that robots fly by in their loops; None where some loop is no round of flights.

    robot: whose battery all have.
    """
    flown = [line for line in loops if line.loop_duration_s > 0]
    if not flown or not all(has_flights(line) for line in flown):
        return None
    found: list[tuple[float, list[RegularFlight], int]] = []  # seconds of a round, the flights in it, robots
    for line in flown:
        flights = _regular_flights(line, robot, chargers)
        for k, (round_s, others, count) in enumerate(found):
            if abs(round_s - line.loop_duration_s) <= SAME_ROUND * round_s:
                found[k] = round_s, others + flights, count + 1
                break
        else:
            found.append((line.loop_duration_s, flights, 1))
    return [_shortest(Timetable(turn_s=round_s, flights=tuple(flights)), count) for round_s, flights, count in found]


def _shortest(timetable: Timetable, robots: int) -> Timetable:
    """The same flights with the shortest turn after which they come again: a part of the one that robots share."""
    kinds: list[list[RegularFlight]] = []
    for flight in timetable.flights:
        alike = next((own for own in kinds if _is_alike(own[0], flight)), None)
        if alike is None:
            kinds.append([flight])
        else:
            alike.append(flight)
    for parts in range(robots, 1, -1):
        turn_s, once = timetable.turn_s / parts, list[RegularFlight]()
        for own in kinds:
            begins_s = np.mod([flight.begins_s + MISSED_S for flight in own], turn_s) - MISSED_S
            order = np.argsort(begins_s, kind="stable")
            apart = np.split(order, np.flatnonzero(np.diff(begins_s[order]) > 2 * MISSED_S) + 1)
            if any(len(each) != parts for each in apart):
                break
            once += [replace(own[each[0]], begins_s=float(begins_s[each[0]])) for each in apart]
        else:
            return Timetable(turn_s=turn_s, flights=tuple(once))
    return timetable


def _is_alike(one: RegularFlight, other: RegularFlight) -> bool:
    """Whether two flights differ in nothing but when they begin."""
    lasts_s = one.line.duration_s
    chargers = [(flight.from_charger, flight.charger) for flight in (one, other)]
    if chargers[0] != chargers[1] or abs(lasts_s - other.line.duration_s) > MISSED_S:
        return False
    moments_s = np.linspace(0, lasts_s, COMPARED)
    return bool(np.abs(one.line.at(moments_s) - other.line.at(moments_s)).max() <= SAME_M)


def _regular_flights(line: Trajectory, robot: Robot, chargers: Sequence[Charger]) -> list[RegularFlight]:
    """The flights of a robot's loop."""
    flights = []
    for flight in flights_of(line, accelerated=True):
        if flight.every_s == 0:
            continue
        assert flight.from_charger is not None, "one that comes again begins on a charger"
        charger = next(one for one in chargers if one.name == flight.charger)
        own = steady(flight.times_s, flight.positions_m[:, :2])
        if (changes := flight.accelerations_m_s2) is not None:
            own = own._replace(accelerations_m_s2=changes)
        begins_s = flight.starts_s % line.loop_duration_s
        stays_s = stay_s(own, robot, charger)
        flights.append(
            RegularFlight(
                line=own, from_charger=flight.from_charger, charger=flight.charger, begins_s=begins_s, stays_s=stays_s
            )
        )
    return flights


def stay_s(line: TimedLine, robot: Robot, charger: Charger) -> float:
    """How long a robot lands, charges for what a flight took of its battery, and climbs."""
    if charger.swap_s is not None:
        return charger.swap_s + robot.battery.grounding_s
    way = Trajectory(robot=robot.name, times_s=line.times_s, positions_m=line.places_m, loop_start_s=line.duration_s)
    used = charging_legs(way, robot, (charger,)).uses[: len(line.times_s) - 1]
    took_s = robot.battery.departure_s + float((used * np.diff(line.times_s)).sum())
    charges_s = took_s * (robot.battery.recharge_s or 0.0) / (robot.battery.endurance_s or math.inf)
    return charges_s + robot.battery.grounding_s


def circulations(timetable: Timetable) -> list[list[tuple[RegularFlight, float]]]:
    """Rounds of flights, each with how long its robot is on the charger after it, that the fewest robots fly."""
    flights, turn_s = timetable.flights, timetable.turn_s
    begins_s = np.array([flight.begins_s for flight in flights])
    ready_s = np.array([flight.begins_s + flight.line.duration_s + flight.stays_s for flight in flights])
    waits_s = np.mod(begins_s[None] - ready_s[:, None], turn_s)
    waits_s[waits_s > turn_s - MISSED_S] = 0.0
    same = np.array([[one.charger == other.from_charger for other in flights] for one in flights])
    _, after = least_sum(np.where(same, waits_s, FAR))
    rounds, left = [], set(range(len(flights)))
    while left:
        k = min(left)
        own = []
        while k in left:
            left.remove(k)
            own.append((flights[k], flights[k].stays_s + float(waits_s[k, after[k]])))
            k = int(after[k])
        rounds.append(own)
    return rounds


def round_of(flown: Sequence[tuple[RegularFlight, float]], turn_s: float, charger_m: Floats) -> Round:
    """One of these rounds as what its robots fly. charger_m: where the first of its flights begins."""
    times, places, charges, now_s = [], [], [], 0.0
    changes = np.concatenate([np.append(flight.line.accelerations_m_s2, 0.0) for flight, _ in flown])  # 0: charging
    for flight, stays_s in flown:
        times.append(flight.line.times_s + now_s)
        places.append(flight.line.places_m)
        ends_s = float(times[-1][-1])
        now_s = ends_s + stays_s
        charges.append((flight.charger, ends_s, now_s))
    lasts_s = round(now_s / turn_s) * turn_s
    times_s, places_m = np.append(np.concatenate(times), lasts_s), np.vstack([*places, charger_m])
    places_m[0] = charger_m
    changes = forward_accelerations(times_s, places_m, changes)
    stays = [Charge(charger=name, from_s=a, until_s=b) for name, a, b in charges[:-1]]
    stays.append(Charge(charger=charges[-1][0], from_s=charges[-1][1], until_s=lasts_s))
    way = Trajectory(
        robot="round", times_s=times_s, positions_m=places_m, charges=tuple(stays),
        accelerations_m_s2=changes if changes.any() else None,
    )  # fmt: skip
    return Round(way=begin_at(way, -flown[0][0].begins_s), robots=round(lasts_s / turn_s), turn_s=turn_s)


def begin_at(way: Trajectory, phase_s: float) -> Trajectory:
    """A round that is so far on at time 0."""
    return go_on(way, phase_s % way.loop_duration_s) if way.loop_duration_s > 0 else way


def stay_at(charger: Charger) -> Round:
    """Nothing to do but to stay at a charger."""
    way = Trajectory(
        robot="round", times_s=np.array([0.0, 1.0]), positions_m=np.array([charger.at] * 2), loop_start_s=1.0,
        charges=(Charge(charger=charger.name, from_s=0.0, until_s=1.0),),
    )  # fmt: skip
    return Round(way=way, robots=1, turn_s=0.0)
