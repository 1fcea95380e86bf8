"""How full a battery has to be at each moment of a round of flights, so that a robot can go on with it for ever."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from rota.model.arrays import Flags, Floats, Ints
from rota.model.mission import Charger, Robot
from rota.model.plan import Trajectory
from rota.planners.patrol.tolerances import SAME_ROUND
from rota.routes.charging_legs import charging_legs

SPARE_SHARE = 0.05  # of what the longest flight of a round takes: at most so much is to spare


class Needs:
    """What a round asks of a battery at each of its moments.

    spare_s: what a robot that comes into it has beyond that, since nobody flies exactly by plan: at most half of what a
    robot has that begins with a full battery.
    """

    def __init__(self, way: Trajectory, robot: Robot, chargers: tuple[Charger, ...], *, spare: bool) -> None:
        self._legs, self._reserve_s = charging_legs(way, robot, chargers), robot.battery.reserve_s
        self._lands_s, self._climbs_s = robot.battery.landing_s, robot.battery.climbing_s
        takeoff_s = robot.battery.departure_s
        self.docked, self._way = self._legs.docks >= 0, way
        count, self._after_s = len(self._legs.begins_s), np.full(len(self._legs.begins_s), robot.battery.reserve_s)
        self.spare_s = 0.0
        if way.loop_duration_s > 0:
            before = np.roll(self.docked, 1)
            departs_s = np.where(before & ~self.docked, takeoff_s, 0.0).tolist()
            more_s, swapped = self._on_legs(
                np.arange(count), self._legs.begins_s, np.where(~before & self.docked, self._lands_s, 0.0)
            )
            after_s, takes_s, full = self._after_s.tolist(), more_s.tolist(), swapped.tolist()
            for leg in [*range(count - 1, -1, -1), *range(count - 1, -1, -1)]:
                needs_s = 0.0 if full[leg] else after_s[leg] + takes_s[leg]
                after_s[leg - 1] = max(needs_s, self._reserve_s) + departs_s[leg]
            self._after_s = np.array(after_s)
            full_s = robot.battery.endurance_s or math.inf
            if spare and math.isfinite(full_s):
                self.spare_s = self._spare_s(full_s, departs_s, takes_s, full)

    def _spare_s(
        self, full_s: float, departs_s: Sequence[float], takes_s: Sequence[float], full: Sequence[bool]
    ) -> float:
        """What is to spare: departs_s at the beginnings of legs and takes_s on them are used; full at their ends."""
        level_s = least_s = full_s
        for leg in [*range(len(takes_s)), *range(len(takes_s))]:  # of the first round nobody knows how it was begun
            level_s -= departs_s[leg]
            level_s = full_s if full[leg] else min(level_s - takes_s[leg], full_s)
            least_s = min(least_s, level_s - float(self._after_s[leg]))
        longest_s = float(np.max(np.where(self.docked, self._legs.needs_s, 0.0), initial=0.0))
        return max(0.0, min(SPARE_SHARE * longest_s, least_s / 2))

    def leg_at(self, phases_s: Floats) -> Ints:
        """The leg of the round at each of its moments (k,)."""
        legs = np.searchsorted(self._legs.begins_s, phases_s, side="right") - 1
        return np.clip(legs, 0, len(self.docked) - 1)

    def docks_at(self, phases_s: Floats) -> Ints:
        """The charger, by its number, at which the round is at each of its moments (k,); -1: at none."""
        return self._legs.docks[self.leg_at(phases_s)]

    def at(self, phases_s: Floats, *, lands: Flags) -> Floats:
        """The least level (k,) at moments of the round with which a robot can go on for ever; inf: it cannot climb.

        lands: (k,) where the round is on a charger, whether the robot comes in flight and has to land first.
        """
        leg = self.leg_at(phases_s)
        lands_s = np.where(lands & self.docked[leg], self._lands_s, 0.0)
        is_late = self.docked[leg] & (self._legs.leaves_s[leg] - phases_s - lands_s < self._climbs_s)
        return np.where(is_late, np.inf, self._at(leg, phases_s, lands_s))

    def _at(self, leg: Ints, phases_s: Floats, lands_s: Floats | float) -> Floats:
        """The same at moments within these legs; lands_s: for how long nothing is charged from then on."""
        more_s, swapped = self._on_legs(leg, phases_s, lands_s)
        return np.asarray(np.maximum(np.where(swapped, 0.0, self._after_s[leg] + more_s), self._reserve_s))

    def _on_legs(self, leg: Ints, phases_s: Floats, lands_s: Floats | float) -> tuple[Floats, Flags]:
        """How much more is needed there than at the ends of these legs, and where the battery is full by then."""
        legs = self._legs
        ends_s = np.where(self.docked[leg], np.minimum(legs.ends_s[leg], legs.leaves_s[leg] - self._climbs_s),
                          legs.ends_s[leg])  # fmt: skip
        rest_s = np.where(np.isfinite(ends_s), ends_s - phases_s, 0.0)
        rest_s = np.where(self.docked[leg], np.maximum(rest_s - lands_s, 0.0), rest_s)
        more_s = np.where(self.docked[leg], -legs.fills[leg], legs.uses[leg]) * rest_s
        swapped = legs.leaves_s[leg] - phases_s - lands_s - self._climbs_s > legs.swaps_s[leg] * (1 - SAME_ROUND)
        return more_s, swapped

    def service_s(self, phases_s: Floats) -> Floats:
        """For how long the round is flown from its time 0 to moments of it (k,), those of later rounds as well."""
        lasts_s = self._way.loop_duration_s
        if lasts_s == 0:
            return np.zeros(len(phases_s))
        legs_s = np.where(self.docked, 0.0, np.diff(self._way.times_s))
        known_s = np.append(0.0, np.cumsum(legs_s))
        rounds = np.floor(phases_s / lasts_s)
        return np.asarray(rounds * known_s[-1] + np.interp(phases_s - rounds * lasts_s, self._way.times_s, known_s))
