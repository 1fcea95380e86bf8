"""Robots that charge as files have them fly: single flights, each started when the table says, or by a clock.

A vehicle that has landed stands on its charger until its next flight begins: by what a flight takes longer than planned
it charges less.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rota.errors import PlanError
from rota.files.flight_files import TABLE, time_in_table
from rota.model.plan import Charge, Floats, Plan, Trajectory
from rota.routes.flights import Flight, flight_name, plan_of_flights
from rota.routes.moments import STAY_S, go_on

LATE_S = 1e-3  # by which the table's digits may have a flight begin before the one before has landed


@dataclass(frozen=True, kw_only=True, eq=False)
class Flown:
    """A flight by its name, and how it is driven: from its charger, or where the plan begins, until it has landed."""

    name: str
    flight: Flight
    driven: Trajectory

    @property
    def longer_s(self) -> float:
        """By how much it lasts longer than planned."""
        return float(self.driven.times_s[-1]) - self.flight.lasts_s


def fly_single_flights(plan: Plan, drives: Callable[[Plan], tuple[Trajectory, ...]]) -> tuple[Plan, tuple[Flown, ...]]:
    """The plan as robots drive that are given its single flights, and these; robots that do not charge drive as ever.

    drives: what a format's files make of the trajectories of a plan. Raises PlanError as that does, and for a flight
    that has not landed when the next one of its robot is to begin.
    """
    single, flights = plan_of_flights(plan)
    driven = {way.robot: way for way in drives(single)}
    pads_m = {charger.name: np.array(charger.at) for charger in plan.mission.chargers}
    flown = []
    for flight in flights:
        name = flight_name(flight, sum(other.robot == flight.robot for other in flights))
        flown.append(Flown(name=name, flight=flight, driven=_between_pads(driven[name], flight, pads_m)))
    ways = []
    for way in plan:
        own = [one for one in flown if one.flight.robot == way.robot]
        ways.append(_way_of(way, own) if own else way if way.charges else driven[way.robot])
    return replace(plan, trajectories=tuple(ways)), tuple(flown)


def with_stays(planned: Trajectory, driven: Trajectory) -> Trajectory:
    """What is driven by a clock, with the stays on chargers at the times that are nearest to the plan's."""

    def near_s(time_s: float) -> float:
        """The nearest time of what is driven."""
        return float(driven.times_s[np.argmin(np.abs(driven.times_s - time_s))])

    charges = tuple(replace(one, from_s=near_s(one.from_s), until_s=near_s(one.until_s)) for one in planned.charges)
    return replace(driven, charges=charges, battery=planned.battery)


def _between_pads(driven: Trajectory, flight: Flight, pads_m: Mapping[str, Floats]) -> Trajectory:
    """A flight until it has landed, from and to the very places of its chargers, whatever the digits of a file."""
    moves = np.flatnonzero((np.diff(driven.positions_m, axis=0) != 0).any(axis=1))
    rows = int(moves[-1]) + 2 if len(moves) else 1
    places_m, legs_s = np.array(driven.positions_m[:rows]), np.diff(driven.times_s[:rows])
    lengths_m = np.linalg.norm(np.diff(places_m, axis=0), axis=1)
    for row, pad in ((0, flight.from_charger), (-1, flight.charger)):
        if pad is not None:
            places_m[row, :2] = pads_m[pad]
    longer = np.divide(
        np.linalg.norm(np.diff(places_m, axis=0), axis=1), lengths_m, out=np.ones(len(lengths_m)), where=lengths_m > 0
    )
    times_s = np.append(0.0, np.cumsum(legs_s * longer))  # no leg is faster than told
    return Trajectory(robot=driven.robot, times_s=times_s, positions_m=places_m, loop_start_s=float(times_s[-1]))


def _way_of(way: Trajectory, flown: Sequence[Flown]) -> Trajectory:
    """The trajectory of a robot that flies these, told in the order in which they begin."""
    again = [one for one in flown if one.flight.every_s > 0]
    begin_s = time_in_table(again[0].flight.starts_s) if again and way.loop_start_s == 0 else 0.0
    rows = _Rows(way)
    for one in flown:
        rows.fly(one, time_in_table(one.flight.starts_s) - begin_s)
    if not again:
        return rows.trajectory(rows.stand(STAY_S))
    first_s = time_in_table(again[0].flight.starts_s) - begin_s
    round_s = time_in_table(again[0].flight.every_s)
    rows.stand_until(first_s + round_s, flown[-1], again[0])
    line = rows.trajectory(first_s)
    # a plan that begins with its loop finds flights of the round before under way
    return go_on(line, -begin_s % round_s, way.battery) if begin_s else line


class _Rows:
    """The rows of a robot's trajectory, flight by flight."""

    def __init__(self, way: Trajectory) -> None:
        self._way = way
        self._times_s: list[float] = []
        self._places_m: list[Floats] = []
        self._charges: list[Charge] = []
        self._pad: str | None = None

    def fly(self, one: Flown, starts_s: float) -> None:
        """Stand until a flight begins, and fly it; it begins and ends where its chargers are."""
        times_s, places_m = one.driven.times_s, one.driven.positions_m
        if not self._times_s and starts_s > 0:
            self._pad = one.flight.from_charger
            self._times_s, self._places_m = [0.0], [places_m[0]]
        if self._times_s:
            self.stand_until(starts_s, one)
            times_s, places_m, starts_s = times_s[1:], places_m[1:], self._times_s[-1]
        self._times_s += (times_s + starts_s).tolist()
        self._places_m += list(places_m)
        self._pad = one.flight.charger

    def stand_until(self, time_s: float, one: Flown, following: Flown | None = None) -> None:
        """Stand on the charger until a flight, or the first of a round, begins. PlanError where that is too soon."""
        late_s = self._times_s[-1] - time_s
        if late_s > LATE_S:
            begins = (following or one).name
            raise PlanError(
                f"robot {self._way.robot}: it has not landed when flight {begins} is to start, by {TABLE}: it is"
                f" {late_s:.3f} s late by then"
            )
        if late_s < 0:
            self.stand(-late_s)

    def stand(self, lasts_s: float) -> float:
        """Stand on the charger for so long; returns until when."""
        from_s, until_s = self._times_s[-1], self._times_s[-1] + lasts_s
        if self._pad is not None:
            self._charges.append(Charge(charger=self._pad, from_s=from_s, until_s=until_s))
        self._times_s.append(until_s)
        self._places_m.append(self._places_m[-1])
        return until_s

    def trajectory(self, loop_start_s: float) -> Trajectory:
        """These rows, of which the loop begins then."""
        times_s = np.array(self._times_s)
        first = int(np.argmin(np.abs(times_s - loop_start_s)))
        return Trajectory(
            robot=self._way.robot, times_s=times_s, positions_m=np.array(self._places_m),
            loop_start_s=float(times_s[first]), charges=tuple(self._charges), battery=self._way.battery,
        )  # fmt: skip
