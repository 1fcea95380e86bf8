"""Who leaves for which charger when, in a super-period that repeats for ever: in closed form.

Robots leave one after the other, every s seconds, and take the places at chargers in turn. With n robots a round takes
T = n s, after which the first one leaves again. A robot charges for r T of it where its battery fills as it drives:
r = R / (E + R), with the endurance E and R from empty to full, and for w = R t / (E + R) more where taking off takes t
of E. Where it lands and climbs for g of its stay, w is g E / (E + R) more. Where batteries are swapped it stays for a
time w. A battery that may use U in a flight lasts from one charge to
the next where T - (r T + w) <= U, so T <= (U + w) / (1 - r). A place is
taken again after p s where p places are in use: they suffice where p s is no less than the charge and what lies between
two robots at one place. All repeats after the least common multiple of n and p turns.

All are at their places where that ends: the last turn lasts so long that robots come to them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from rota.errors import NoPlanFound
from rota.model.arrays import Flags, Floats, Ints
from rota.model.mission import Charger, Robot

SHORTER = 0.01  # of a round, by which a shorter one is tried at least


@dataclass(frozen=True, kw_only=True, eq=False)
class Needs:
    """What the batteries of n robots ask, (n,) each.

    usable_s: how long one lasts from leaving a charger full to its reserve, however it moves. share, stays_s: it is
    at a charger for ``share`` of a round and for ``stays_s``.
    """

    usable_s: Floats
    share: Floats
    stays_s: Floats

    def longest_round_s(self) -> float:
        """The longest round that batteries last for."""
        return float(((self.usable_s + self.stays_s) / (1 - self.share)).min())

    def fills_s(self, used_s: float) -> float:
        """How long it takes to fill any of them again after so long, at most."""
        return float(((used_s * self.share + self.stays_s) / (1 - self.share)).max())

    def charge_s(self, round_s: float) -> float:
        """How long any of them charges in a round, at most."""
        return float((self.share * round_s + self.stays_s).max())


def needs_of(robots: tuple[Robot, ...], chargers: tuple[Charger, ...]) -> Needs:
    """What robots with an endurance ask of these chargers, any of which each may come to.

    Standing counts as driving, or as more where it takes more. Where some chargers swap batteries and others do not,
    robots stay at all of them as long as at the slowest one, from empty.
    """
    usable, share, stays = [], [], []
    for robot in robots:
        battery = robot.battery
        endurance_s = battery.endurance_s or math.inf
        uses = max(1.0, battery.standing_uses)
        fills_s = uses * (battery.recharge_s or 0.0)
        swaps = [
            charger.swap_s or fills_s * (battery.usable_s + battery.departure_s) / endurance_s for charger in chargers
        ]
        takes_off_s = (battery.recharge_s or 0.0) * battery.departure_s + battery.grounding_s * endurance_s
        alike = all(charger.swap_s is None for charger in chargers)
        usable.append(battery.usable_s / uses)
        share.append(fills_s / (endurance_s + fills_s) if alike else 0.0)
        stays.append(takes_off_s / (endurance_s + fills_s) if alike else max(swaps) + battery.grounding_s)
    return Needs(usable_s=np.array(usable), share=np.array(share), stays_s=np.array(stays))


@dataclass(frozen=True, kw_only=True)
class Allowed:
    """Times that are allowed for, in seconds: to come to a charger, to come home, and between two at one place.

    spread_s: until robots have spread.
    """

    in_s: float
    out_s: float
    between_s: float
    spread_s: float

    @property
    def quiet_s(self) -> float:
        """What the last turn takes at least, in which all come to where they are in the end."""
        return self.in_s + self.out_s


@dataclass(frozen=True, kw_only=True, eq=False)
class Turns:
    """A super-period of L turns: when each begins and ends, seconds (L,); ends may lie beyond its end, period_s.

    round_s: the longest time from one turn of a robot to its next; charge_s: how long each charges at least; ready_s:
    before it, for those that are at chargers where it begins; places: how many are in use.
    """

    begins_s: Floats
    ends_s: Floats
    period_s: float
    round_s: float
    charge_s: float
    ready_s: float
    places: int

    @property
    def docked(self) -> Flags:
        """Which turns (L,) go on across the end of the super-period."""
        return self.ends_s >= self.period_s

    def longest_flight_s(self, robots: int, allowed: Allowed) -> float:
        """The longest flight that any of so many robots begins with: that of the last one to leave for the first time.

        Robots that are at chargers where the super-period begins go there at once, and are full by then.
        """
        waits = robots - int(self.docked.sum())
        own_turn_s = self.ready_s + float(self.begins_s[waits - 1]) if waits > 0 else 0.0
        return allowed.spread_s + own_turn_s + allowed.in_s


def turns_of(needs: Needs, total: int, allowed: Allowed) -> Turns:
    """The turns of the longest round that batteries last for: ways to chargers are fewest then. total: places of all.

    Raises NoPlanFound where the places, or the batteries, do not suffice.
    """
    round_s, usable_s = needs.longest_round_s(), float(needs.usable_s.min())
    while True:
        turns = turns_in(round_s, needs, total, allowed)
        excess_s = turns.longest_flight_s(len(needs.share), allowed) - usable_s
        if excess_s <= 0:
            return turns
        round_s -= max(excess_s, SHORTER * round_s)


def turns_in(round_s: float, needs: Needs, total: int, allowed: Allowed) -> Turns:
    """The turns of a round that takes so long.

    Robots leave evenly, and each is off its charger as soon as it has what it needs; no more are away at once. Of
    numbers of places that suffice the one is used after which all repeats soonest. Nobody leaves a charger while robots
    come home: who would, stays.
    """
    n, quiet_s = len(needs.share), allowed.quiet_s
    every_s = round_s / n
    if n > 1 and every_s < quiet_s:
        every_s = (round_s - quiet_s) / (n - 1)
    charge_s = needs.charge_s(round_s)
    taken_s = charge_s + allowed.between_s  # who comes sooner than its place is free waits beside it
    if every_s <= 0 or taken_s + quiet_s > round_s:
        raise NoPlanFound(
            f"fleet.endurance_s: batteries that last for {needs.usable_s.min():.0f} s are too short for {n} robot"
            f"{'s' if n != 1 else ''}: they have spread after {allowed.spread_s:.0f} s, ways to chargers and back take"
            f" up to {allowed.in_s:.0f} s and {allowed.out_s:.0f} s, and charging {charge_s:.0f} s; more endurance,"
            " nearer chargers or fewer robots are needed"
        )
    needed = min(math.ceil(taken_s / every_s - 1e-9), n)
    if needed > total:
        raise NoPlanFound(
            f"chargers: {total} place{'s' if total != 1 else ''} cannot suffice for {n} robots, {needed} would do:"
            f" batteries last for rounds of {round_s:.0f} s, in which each robot takes a place for"
            f" {taken_s:.0f} s, {charge_s:.0f} s of them to charge"
        )
    places = min(range(needed, min(total, n) + 1), key=lambda count: math.lcm(n, count))
    begins_s: Floats = every_s * np.arange(math.lcm(n, places), dtype=np.float64)
    period_s = float(begins_s[-1]) + max(every_s, quiet_s)
    ends_s: Floats = begins_s + (allowed.in_s + charge_s)
    ends_s[(ends_s > period_s - allowed.out_s) & (ends_s < period_s)] = period_s
    ready_s = allowed.in_s + needs.fills_s(allowed.spread_s + allowed.in_s) if (ends_s >= period_s).any() else 0.0
    return Turns(
        begins_s=begins_s, ends_s=ends_s, period_s=period_s, round_s=round_s, charge_s=charge_s, ready_s=ready_s,
        places=places,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True, eq=False)
class Roster:
    """Which robot's turn it is, and which charger it goes to: numbers (L,) of robots 0 to n - 1 and of chargers."""

    robot: Ints
    charger: Ints


def roster_of(ways_s: Floats, rooms: Ints, turns: Turns) -> Roster:
    """The order of n robots, in which the ways to the places are shortest in sum; ways_s: (n, m) to each charger.

    rooms: (m,) places of each. Robots that follow each other go to different chargers where there are some. Raises
    NoPlanFound where a robot comes to none of those (inf).
    """
    n, length = len(ways_s), len(turns.begins_s)
    dealt = [q for round_ in range(int(rooms.max())) for q in np.flatnonzero(rooms > round_).tolist()][: turns.places]
    place = np.arange(length) % turns.places
    charger = np.array(dealt, np.int64)[place]
    costs = ways_s[:, charger].reshape(n, length // n, n).mean(axis=1)
    far_s = 1 + n * float(costs[np.isfinite(costs)].max(initial=0.0))
    rows, columns = linear_sum_assignment(np.where(np.isfinite(costs), costs, far_s))
    order = rows[np.argsort(columns)].astype(np.int64)
    robot = order[np.arange(length) % n]
    if np.isinf(ways_s[robot, charger]).any():
        raise NoPlanFound("chargers: robots come to too few of them: not all are in the same part of the ground")
    return Roster(robot=robot, charger=charger)
