"""Single flights of robots that charge: from leaving a charger, or the start, to being at a charger again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from rota.errors import PlanError
from rota.model.arrays import Flags, Ints
from rota.model.fleet import Robot
from rota.model.plan import Charge, Floats, Plan, Trajectory
from rota.routes.constant_speeds import at_constant_speeds

STRAIGHT_M = 1e-6  # by which a place may be off the straight way that goes on past it


@dataclass(frozen=True, kw_only=True, eq=False)
class Flight:
    """One flight of a robot: ``number`` counts its flights from 1 on, in the order in which they begin.

    starts_s: when it first takes off; below 0 where the plan's time 0 finds it under way already. every_s: after how
    long it does again and again; 0: it flies once. times_s: (n,) from 0; positions_m: (n, 2) or (n, 3). charger: where
    it lands. from_charger: where it takes off; None: where the plan begins. charges_s: how long it then charges.
    accelerations_m_s2: (n - 1,) along its legs; None: none has one.
    """

    robot: str
    number: int
    starts_s: float
    every_s: float
    times_s: Floats
    positions_m: Floats
    charger: str
    from_charger: str | None
    charges_s: float
    accelerations_m_s2: Floats | None = None

    @property
    def lasts_s(self) -> float:
        """Seconds from take-off to landing."""
        return float(self.times_s[-1])


def recharges(plan: Plan) -> bool:
    """Whether any robot charges: what it does then is flights, and no loop that it could be sent to fly for ever."""
    return any(trajectory.charges for trajectory in plan)


def has_flights(trajectory: Trajectory) -> bool:
    """Whether a robot charges and does so again and again, or to its end: then ``flights_of`` has its flights."""
    later = any(charge.until_s > trajectory.loop_start_s for charge in trajectory.charges)
    return ends_on_charger(trajectory) or (trajectory.loop_duration_s > 0 and later)


def takes_turns(plan: Plan) -> bool:
    """Whether what any robot does is flights, from charger to charger."""
    return any(has_flights(trajectory) for trajectory in plan)


def ends_on_charger(trajectory: Trajectory) -> bool:
    """Whether a robot ends on a charger for ever."""
    charges = trajectory.charges
    return trajectory.loop_duration_s == 0 and bool(charges) and charges[-1].until_s == trajectory.times_s[-1]


def on_charger(trajectory: Trajectory, times_s: Floats) -> Flags:
    """Whether the robot is on a charger at each of the times (n,), in any round."""
    if not trajectory.charges:
        return np.zeros(len(times_s), np.bool_)
    asked_s, first_s, round_s = np.asarray(times_s), trajectory.loop_start_s, trajectory.loop_duration_s
    if round_s > 0:
        asked_s = np.where(asked_s > first_s, first_s + np.mod(asked_s - first_s, round_s), asked_s)
    docked = _legs_on_charger(trajectory)
    return docked[np.clip(np.searchsorted(trajectory.times_s, asked_s, side="right") - 1, 0, len(docked) - 1)]


def flights_of(trajectory: Trajectory, *, accelerated: bool = False) -> tuple[Flight, ...]:
    """The flights of a robot that charges, in the order in which they begin; none of one that stays on its charger.

    accelerated: with the accelerations along their legs; else these are cut into legs at constant speeds. Raises
    PlanError for a robot that flies on for ever after it has charged, or that never charges.
    """
    one = trajectory if accelerated else at_constant_speeds(trajectory)
    docked = _legs_on_charger(one)
    first, legs = one.loop_index, len(docked)
    found = [_flight(one, docked, run) for run in _runs(np.flatnonzero(~docked)) if run[0] < first]
    turning = np.arange(first, legs)
    if docked[first:].any():
        begins = first + int(np.flatnonzero(docked[first:])[0])
        turned = np.roll(turning, first - begins)
        found += [_flight(one, docked, run) for run in _runs(turned[~docked[turned]], seam=(first, legs))]
    elif legs > first or not ends_on_charger(one):
        raise PlanError(
            f"robot {one.robot}: from {one.loop_start_s:.6g} s on it comes to no charger; it has no single flights"
        )
    found.sort(key=lambda flight: flight.starts_s)
    return tuple(replace(flight, number=number) for number, flight in enumerate(found, start=1))


def _legs_on_charger(one: Trajectory) -> Flags:
    """Which legs (n - 1,) the robot spends at a charger."""
    docked = np.zeros(len(one.times_s) - 1, np.bool_)
    for charge in one.charges:
        begin, end = np.searchsorted(one.times_s, (charge.from_s, charge.until_s))
        docked[begin:end] = True
    return docked


def _runs(legs: Ints, seam: tuple[int, int] | None = None) -> Iterator[Ints]:
    """Legs that follow each other; over the seam of a loop, which goes from one leg to before another, too."""
    if len(legs):
        follows = np.diff(legs) == 1
        if seam is not None:
            follows |= (legs[:-1] == seam[1] - 1) & (legs[1:] == seam[0])
        yield from np.split(legs, np.flatnonzero(~follows) + 1)


def _flight(one: Trajectory, docked: Flags, run: Ints) -> Flight:
    """The flight over the legs of a run, which may go on across the seam of the loop."""
    times_s, places_m, round_s = one.times_s, one.positions_m, one.loop_duration_s
    late_s = np.where(run < run[0], round_s, 0.0)
    told_s = np.append(times_s[run] + late_s, times_s[run[-1] + 1] + late_s[-1])
    told_m = np.vstack([places_m[run], places_m[run[-1] + 1 : run[-1] + 2]])
    starts_s, wraps = float(told_s[0]), bool(late_s[-1])
    told_m_s2 = None if one.accelerations_m_s2 is None else one.accelerations_m_s2[run]
    if wraps:
        told_s, told_m, told_m_s2 = _without_seam(told_s, told_m, told_m_s2, int(np.argmax(late_s > 0)))
    if wraps:
        starts_s -= round_s if one.loop_start_s == 0 else 0.0
    first, legs = one.loop_index, len(docked)
    again = wraps or run[0] >= first
    after = int(run[-1]) + 1
    after = first if after == legs and legs > first else after
    before = int(run[0]) - 1
    before = legs - 1 if again and before < first else before
    return Flight(
        robot=one.robot,
        number=0,
        starts_s=starts_s,
        every_s=round_s if again else 0.0,
        times_s=told_s - told_s[0],
        positions_m=told_m,
        charger=_charger(one, after),
        from_charger=_charger(one, before) if before >= 0 else None,
        charges_s=_stay_s(one, docked, after),
        accelerations_m_s2=told_m_s2,
    )


def _without_seam(
    times_s: Floats, places_m: Floats, changes_m_s2: Floats | None, k: int
) -> tuple[Floats, Floats, Floats | None]:
    """The points of a flight without the k-th, where the loop's seam is, if it is flown the same without it."""
    before_s, lasts_s = times_s[k] - times_s[k - 1], times_s[k + 1] - times_s[k - 1]
    one_m_s2, other_m_s2 = (0.0, 0.0) if changes_m_s2 is None else changes_m_s2[k - 1 : k + 1]
    step_m = places_m[k + 1] - places_m[k - 1]
    length_m = float(np.sqrt((step_m**2).sum()))
    along_m = length_m * before_s / lasts_s - one_m_s2 / 2 * before_s * (lasts_s - before_s)
    between_m = places_m[k - 1] + step_m * (along_m / length_m if length_m else 0.0)
    off_m = max(np.abs(between_m - places_m[k]).max(), abs(other_m_s2 - one_m_s2) * lasts_s**2 / 8)
    if off_m > STRAIGHT_M:
        return times_s, places_m, changes_m_s2
    without_m_s2 = None if changes_m_s2 is None else np.delete(changes_m_s2, k)
    return np.delete(times_s, k), np.delete(places_m, k, axis=0), without_m_s2


def _charger(one: Trajectory, leg: int) -> str:
    """The charger at which a robot spends a leg."""
    begin_s = one.times_s[leg]
    return next(charge.charger for charge in one.charges if charge.from_s <= begin_s < charge.until_s)


def _stay_s(one: Trajectory, docked: Flags, leg: int) -> float:
    """How long a robot stays on a charger from the beginning of a leg on, over the loop's seam as well."""
    lasts_s, first, legs = np.diff(one.times_s), one.loop_index, len(docked)
    stay_s = 0.0
    for _ in range(legs):
        if not docked[leg]:
            break
        stay_s += float(lasts_s[leg])
        leg += 1
        if leg == legs:
            if legs == first:
                break
            leg = first
    return stay_s


def plan_of_flights(plan: Plan) -> tuple[Plan, tuple[Flight, ...]]:
    """The plan whose robots, ROBOT.NUMBER, are the single flights of those that charge; and the flights, in its order.

    Each begins at time 0, lands on its charger and stays there. Robots without charges are as they were, and not among
    the flights.
    """
    flights: list[Flight] = []
    made: list[Trajectory] = []
    robots: list[Robot] = []
    for trajectory in plan:
        robot = plan.mission.fleet.robot(trajectory.robot)
        own = flights_of(trajectory) if trajectory.charges else ()
        flights += own
        made += [_as_trajectory(flight, len(own)) for flight in own] if trajectory.charges else [trajectory]
        robots += [replace(robot, name=each.robot, start=None) for each in made[len(robots) :]]
    fleet = plan.mission.fleet
    mission = replace(plan.mission, fleet=replace(fleet, robots=tuple(robots) if fleet.robots else None))
    return replace(plan, mission=mission, trajectories=tuple(made)), tuple(flights)


def flight_name(flight: Flight, count: int) -> str:
    """What a flight of so many of its robot is called; names sort as the flights do."""
    return f"{flight.robot}.{flight.number:0{len(str(count))}d}"


def _as_trajectory(flight: Flight, count: int) -> Trajectory:
    """The flight as the trajectory of a robot that lands and stays."""
    ends_s = flight.lasts_s + max(flight.charges_s, 1.0)
    return Trajectory(
        robot=flight_name(flight, count),
        times_s=np.append(flight.times_s, ends_s),
        positions_m=np.vstack([flight.positions_m, flight.positions_m[-1:]]),
        loop_start_s=ends_s,
        charges=(Charge(charger=flight.charger, from_s=flight.lasts_s, until_s=ends_s),),
    )
