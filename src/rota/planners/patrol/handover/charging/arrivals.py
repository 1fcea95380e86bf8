"""When a robot can come into a round of flights, by which way, and how full its battery has to be for that."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from rota.geometry.shortest_path import ShortestPaths
from rota.model.arrays import Floats
from rota.model.mission import Charger
from rota.model.plan import Charge, Trajectory
from rota.model.trajectory import forward_accelerations
from rota.planners.patrol.driving.timed_line import TimedLine, chain, steady
from rota.planners.patrol.handover.charging.flyers import Arrival, Flyer
from rota.planners.patrol.handover.charging.landed import Landed
from rota.planners.patrol.handover.charging.needs import Needs
from rota.planners.patrol.handover.charging.timetables import Round, begin_at
from rota.planners.patrol.relief.ways import Ways
from rota.planners.patrol.tolerances import SHORTEST_S, SLOWER

POINTS = 240  # of a round at which robots may come into it, beside its corners


class Arrivals:
    """How each of some robots can come into one round, at each of its places.

    moving: those that have to land first may come into the round as it moves, not on its chargers alone. spare: they
    have more than it needs.
    """

    def __init__(
        self, round_: Round, flyers: Sequence[Flyer], chargers: tuple[Charger, ...], ways: Ways, *, moving: bool,
        spare: bool,
    ) -> None:  # fmt: skip
        self.round, self._flyers, self._chargers, self._ways, self._paths = round_, flyers, chargers, ways, ways.paths
        self._way, self._lasts_s = round_.way, round_.way.loop_duration_s
        self._moving = moving
        self._needs = Needs(round_.way, flyers[0].robot, chargers, spare=spare)
        self._speed_m_s = flyers[0].robot.ground_speed_m_s * SLOWER

    @cached_property
    def _phases_s(self) -> Floats:
        """Moments (k,) of the round at which robots may come into it: its rows, its roles' now, and others between."""
        if self._lasts_s == 0:
            return np.zeros(1)
        even_s = np.linspace(0, self._lasts_s, POINTS, endpoint=False)
        now_s = np.arange(self.round.robots) * self.round.turn_s
        return np.unique(np.concatenate([even_s, now_s, self._way.times_s[:-1]]))

    @cached_property
    def _travel_s(self) -> Floats:
        """From each robot, then from each charger, to the places of the round."""
        return self._travel_to(self._way.at(self._phases_s))

    def _travel_to(self, places_m: Floats) -> Floats:
        """From each robot, then from each charger, to places (k, 2)."""
        here_m = np.array([*(one.place_m for one in self._flyers), *(one.at for one in self._chargers)])
        return np.asarray(self._paths.distances(here_m, places_m) / self._speed_m_s)

    @cached_property
    def _to_chargers_s(self) -> Floats:
        """From each robot to each charger."""
        return self._travel_to(np.array([one.at for one in self._chargers]))[: len(self._flyers)]

    @cached_property
    def _landed(self) -> Landed:
        landed = Landed(self.round, self._needs, self._phases_s, self._chargers, self._ways)
        landed.moving = self._moving
        return landed

    def arrival(self, k: int, now_s: float) -> Arrival:
        """The first that the k-th robot can make it into the round, which is so far on at the time 0."""
        lasts_s = self._lasts_s
        if lasts_s == 0:
            return self._first(k, now_s, np.array([*self._travel_s[k], *self._to_chargers_s[k]]), None)
        moments_s = np.mod(self._phases_s - now_s, lasts_s)
        moments_s[moments_s > lasts_s - SHORTEST_S] = 0.0
        order = np.argsort(moments_s, kind="stable")
        if self._flyers[k].lands is not None:
            return self._landed.first(self._flyers[k], now_s, moments_s[order], order)
        return self._first(k, now_s, moments_s[order], self._travel_s[:, order])

    def behind(self, k: int, now_s: float) -> Arrival | None:
        """How the k-th robot can come into the flight that the round is on, late, and leave nothing out; None: not."""
        one = self._flyers[k]
        return None if one.lands is None else self._landed.behind(one, now_s)

    def finer(self, k: int, now_s: float, arrival: Arrival) -> Arrival:
        """The same nearer to the first moment at which it can be."""
        if self._lasts_s == 0 or arrival.joins_s == 0 or not math.isfinite(arrival.joins_s):
            return arrival
        step_s = self._lasts_s / POINTS
        for _ in range(2):
            moments_s = np.linspace(max(0.0, arrival.joins_s - step_s), arrival.joins_s, 12)
            found = self._first(k, now_s, moments_s, None)
            arrival, step_s = found if found.joins_s <= arrival.joins_s else arrival, step_s / 11
        return arrival

    def _first(self, k: int, now_s: float, moments_s: Floats, travel_s: Floats | None) -> Arrival:
        """The first of moments (n,) at which the k-th robot can be there with enough left."""
        one, count = self._flyers[k], len(self._flyers)
        if one.lands is not None:
            return self._landed.first(one, now_s, moments_s, None)
        phases_s = np.mod(now_s + moments_s, self._lasts_s) if self._lasts_s > 0 else np.zeros(len(moments_s))
        if travel_s is None:
            travel_s = self._travel_to(self._way.at(phases_s))
        best, battery = Arrival(), one.robot.battery
        docked, takeoff_s = self._needs.docked[self._needs.leg_at(phases_s)], battery.departure_s
        for via in (None, *self._chargers):
            if via is not None and one.charger is via:
                continue
            to_s = 0.0 if via is None else float(self._to_chargers_s[k, self._chargers.index(via)])
            way_s = travel_s[k] if via is None else travel_s[count + self._chargers.index(via)]
            stays_s, charger = moments_s - way_s - to_s, one.charger if via is None else via
            stays_s = np.where(np.abs(stays_s) <= SHORTEST_S, 0.0, stays_s)
            leaves = ~docked | (way_s > SHORTEST_S) if charger is not None else np.ones(len(stays_s), np.bool_)
            needs_s = self._needs.at(phases_s, lands=leaves)
            there_s = one.level_s - to_s - takeoff_s * (via is not None and one.charger is not None)
            if charger is None:
                left_s = np.where(stays_s >= 0, there_s - battery.standing_uses * stays_s, np.nan)
            elif there_s < battery.reserve_s + SHORTEST_S * (to_s > 0):
                continue
            else:  # who has no way to a round that is docked stays where it is
                lands_s = one.lands_s if via is None else battery.landing_s
                climbs_s = one.climbs_s if via is None else battery.climbing_s
                charges_s = np.where(stays_s >= 0, stays_s - lands_s - climbs_s * leaves, np.nan)
                left_s = one.level_after_s(there_s, charges_s, charger) - takeoff_s * leaves
            is_enough = left_s - way_s >= needs_s + np.where(moments_s == 0, 0.0, self._needs.spare_s + SHORTEST_S)
            if is_enough.any() and moments_s[first := int(np.argmax(is_enough))] < best.joins_s:
                served_s = self._needs.service_s(np.array([now_s, now_s + moments_s[first]]))
                best = Arrival(
                    joins_s=float(moments_s[first]), phase_s=float(phases_s[first]), via=via,
                    leaves_s=float(max(0.0, moments_s[first] - way_s[first])),
                    unserved_s=float(served_s[1] - served_s[0]),
                )  # fmt: skip
        return best

    def trajectory(self, k: int, arrival: Arrival, battery: float) -> Trajectory:
        """What the k-th robot flies that comes into the round so."""
        one, way = self._flyers[k], begin_at(self._way, arrival.phase_s)
        if one.lands is not None and one.charger is not None:
            line = _Line(one.lands, self._paths)
            moves = next((each for each in one.transfers if each.charger is arrival.via), None)
            if moves is not None and arrival.enters is None:
                leaves_s = moves.by(arrival.joins_s - one.robot.battery.landing_s)
                line.stay(leaves_s, one.charger.name)
                line.follow(moves.way)
            if arrival.enters is not None:
                line.stay(arrival.leaves_s, one.charger.name)
                line.follow(arrival.enters)
            line.stay(arrival.joins_s, (arrival.via or one.charger).name)
            return line.lead_into(one.robot.name, way, arrival.joins_s, battery)
        way_m, joins_s = way.positions_m[0, :2], arrival.joins_s
        line = _Line(steady(np.zeros(1), one.place_m[None]), self._paths)
        if arrival.via is not None:
            line.go(np.array(arrival.via.at), float(self._to_chargers_s[k, self._chargers.index(arrival.via)]))
        charger = arrival.via or one.charger
        line.stay(arrival.leaves_s, None if charger is None else charger.name)
        line.go(way_m, joins_s)
        return line.lead_into(one.robot.name, way, joins_s, battery)


class _Line:
    """Rows of a robot's way into a round."""

    def __init__(self, begun: TimedLine, paths: ShortestPaths) -> None:
        self._paths, self._times_s, self._places_m = paths, begun.times_s.tolist(), list(begun.places_m)
        self._begun, self._charges = begun, list[Charge]()

    def go(self, place_m: Floats, there_s: float) -> None:
        """Go to a place, to be there at that time."""
        here_m, since_s = self._places_m[-1], self._times_s[-1]
        if there_s - since_s <= SHORTEST_S:
            return
        line_m = np.vstack([here_m, self._paths.path(here_m, place_m)[1:-1], place_m])
        steps_m = np.hypot(*np.diff(line_m, axis=0).T)
        moved = np.append(True, steps_m > 0)
        line_m, along_m = line_m[moved], np.append(0.0, np.cumsum(steps_m))[moved]
        if along_m[-1] == 0:
            self.stay(there_s, None)
            return
        times_s = since_s + along_m / along_m[-1] * (there_s - since_s)
        self._times_s += [*times_s[1:-1].tolist(), there_s]
        self._places_m += list(line_m[1:])

    def follow(self, way: TimedLine) -> None:
        """Drive a way that begins here."""
        here = TimedLine(np.array(self._times_s), np.array(self._places_m), np.zeros(len(self._times_s) - 1))
        here.accelerations_m_s2[: len(self._begun.accelerations_m_s2)] = self._begun.accelerations_m_s2
        self._begun = chain(here, way)
        self._times_s, self._places_m = self._begun.times_s.tolist(), list(self._begun.places_m)

    def stay(self, until_s: float, charger: str | None) -> None:
        """Stay where it is, perhaps on a charger."""
        if until_s - self._times_s[-1] <= SHORTEST_S:
            return
        if charger is not None:
            self._charges.append(Charge(charger=charger, from_s=self._times_s[-1], until_s=until_s))
        self._times_s.append(until_s)
        self._places_m.append(self._places_m[-1])

    def lead_into(self, robot: str, way: Trajectory, joins_s: float, battery: float) -> Trajectory:
        """These rows, and the round from then on."""
        joins_s = self._times_s[-1] if abs(self._times_s[-1] - joins_s) <= SHORTEST_S else joins_s
        kept = [k for k, now_s in enumerate(self._times_s) if now_s < joins_s]
        later = [Charge(charger=c.charger, from_s=c.from_s + joins_s, until_s=c.until_s + joins_s) for c in way.charges]
        first_m = np.array(self._places_m)[kept].reshape(-1, 2)
        places_m = np.vstack([first_m, way.positions_m[:, :2]])
        changes, onward = np.zeros(len(places_m) - 1), way.accelerations_m_s2
        changes[: len(self._begun.accelerations_m_s2)] = self._begun.accelerations_m_s2
        changes[len(kept) :] = 0.0 if onward is None else onward
        times_s = np.append(np.array(self._times_s)[kept], way.times_s + joins_s)
        changes = forward_accelerations(times_s, places_m, changes) if changes.any() else changes
        return Trajectory(
            robot=robot, times_s=times_s, positions_m=places_m,
            accelerations_m_s2=changes if changes.any() else None, loop_start_s=way.loop_start_s + joins_s,
            charges=(*self._charges, *later), battery=battery,
        )  # fmt: skip
