"""When a robot that cannot turn or change its speed at once can come into a round: on a charger, or as that moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rota.model.arrays import Flags, Floats, Ints
from rota.model.mission import TOUCH_M, Charger
from rota.planners.patrol.driving.timed_line import chain, round_of
from rota.planners.patrol.handover.charging.flyers import Arrival, Flyer, fills_s, flight_left
from rota.planners.patrol.handover.charging.needs import Needs
from rota.planners.patrol.handover.charging.timetables import Round, begin_at
from rota.planners.patrol.handover.rounds import COMPARED
from rota.planners.patrol.relief.ways import Way, Ways, motions_of
from rota.planners.patrol.tolerances import SHORTEST_S

BEHIND = 12  # places of a flight, from where the round is on, of which the first one to which a way leads is taken


@dataclass(frozen=True, kw_only=True, eq=False)
class _Moments:
    """Moments (n,) of a round: at which charger it is, -1 at none, and what it asks of batteries.

    landed_s: of one that has landed there. flying_s: of one that comes in flight. straight_s: from each charger (c, n)
    to where the round is then, at full speed.
    """

    phases_s: Floats
    docks: Ints
    landed_s: Floats
    flying_s: Floats
    straight_s: Floats

    def choose(self, chosen: Ints) -> _Moments:
        """Some of them, by their numbers."""
        return _Moments(
            phases_s=self.phases_s[chosen], docks=self.docks[chosen], landed_s=self.landed_s[chosen],
            flying_s=self.flying_s[chosen], straight_s=self.straight_s[:, chosen],
        )  # fmt: skip


class Landed:
    """How robots come into one round once they have landed on a charger.

    phases_s: moments (k,) of the round that are asked for again and again. moving: they may come into it as it moves.
    """

    def __init__(self, round_: Round, needs: Needs, phases_s: Floats, chargers: Sequence[Charger], ways: Ways) -> None:
        self._way, self._lasts_s, self._needs = round_.way, round_.way.loop_duration_s, needs
        self._phases_s, self._chargers, self._ways, self.moving = phases_s, chargers, ways, True
        self._line, self._known_ways = round_of(round_.way), dict[tuple[str, float], Way | None]()

    def first(self, one: Flyer, now_s: float, moments_s: Floats, order: Ints | None) -> Arrival:
        """The first of moments (n,) at which a robot can be in the round, which is so far on at the time 0.

        It is on a charger of the round as that is there, where it lands, if any; or it comes into the round as that
        moves, where that is sooner. order: numbers of the known phases that these moments are at; None: of others.
        """
        if self._lasts_s == 0:
            moments_s, order = np.array([self._ready_s(one)]), None
        if order is None:
            asked = self._at(np.mod(now_s + moments_s, self._lasts_s) if self._lasts_s > 0 else 0.0 * moments_s)
        else:
            asked = self._known.choose(order)
        goes_on = self._goes_on(one, now_s)
        found = self._first_landed(one, moments_s, asked, 0.0 if goes_on else self._needs.spare_s)
        if self.moving:
            found = self._first_moving(one, moments_s, asked, found.joins_s) or found
        if not np.isfinite(found.joins_s):
            return found
        # who goes on with its own flight flies in its place
        alone_s = one.lands.duration_s if one.lands is not None and goes_on else 0.0
        served_s = self._needs.service_s(np.array([now_s + alone_s, now_s + max(found.joins_s, alone_s)]))
        return replace(found, unserved_s=float(served_s[1] - served_s[0]))

    def behind(self, one: Flyer, now_s: float) -> Arrival | None:
        """Into the flight that the round is on now, as soon as can be, and late to its end; None: it is on none.

        Nothing of the flight is left out then, as it is where a robot catches up with the round. Once it has landed it
        is where the round is.
        """
        assert one.charger is not None, f"{one.robot.name} lands nowhere"
        moments_s = np.mod(self._phases_s - now_s, self._lasts_s or 1.0)
        order = np.argsort(moments_s, kind="stable")
        asked, battery = self._known.choose(order), one.robot.battery
        for phase_s, dock in zip(asked.phases_s[:BEHIND].tolist(), asked.docks, strict=False):
            if dock >= 0 or self._lasts_s == 0:
                return None
            if (way := self._way_into(one.charger, phase_s)) is not None:
                break
        else:
            return None
        left, used_s, charger = flight_left(begin_at(self._way, phase_s), one.robot, self._chargers)
        enters = chain(way.line_to(1.0), left)
        used_s += battery.departure_s + (enters.duration_s - left.duration_s) * max(1.0, battery.standing_uses)
        asked_s = min(battery.reserve_s + used_s + self._needs.spare_s, battery.endurance_s or np.inf)
        lacks_s = max(asked_s - one.level_s, 0.0)
        leaves_s = self._leaves_s(one) + fills_s(one.robot, one.charger, lacks_s)
        if used_s > battery.usable_s or not np.isfinite(leaves_s):
            return None
        ready_s = leaves_s + enters.duration_s + battery.landing_s
        found = self._first_on(one, charger, one.level_s + lacks_s - used_s, ready_s, moments_s[order], asked, 0.0)
        return replace(found, via=charger, leaves_s=leaves_s, enters=enters) if np.isfinite(found.joins_s) else None

    @cached_property
    def _known(self) -> _Moments:
        return self._at(self._phases_s)

    def _at(self, phases_s: Floats) -> _Moments:
        """The round at its moments (n,)."""
        flies, chargers_m = np.ones(len(phases_s), np.bool_), np.array([one.at for one in self._chargers])
        return _Moments(
            phases_s=phases_s, docks=self._needs.docks_at(phases_s), landed_s=self._needs.at(phases_s, lands=~flies),
            flying_s=self._needs.at(phases_s, lands=flies),
            straight_s=self._ways.straight_s(chargers_m, self._way.at(phases_s)),
        )  # fmt: skip

    def _goes_on(self, one: Flyer, now_s: float) -> bool:
        """Whether the flight that a robot has to end is what the round flies from now on."""
        if one.lands is None or one.lands.stays or self._lasts_s == 0:
            return False
        moments_s = np.linspace(0, one.lands.duration_s, COMPARED)
        off_m = self._way.at(np.mod(now_s + moments_s, self._lasts_s))[:, :2] - one.lands.at(moments_s)
        return bool(np.abs(off_m).max() <= TOUCH_M)

    def _ready_s(self, one: Flyer) -> float:
        """When it has landed on its own charger."""
        assert one.lands is not None, f"{one.robot.name} lands nowhere"
        return one.lands.duration_s + (one.lands_s if one.lands.stays else one.robot.battery.landing_s)

    def _leaves_s(self, one: Flyer) -> float:
        """When it can leave its own charger at the earliest: it has landed, climbed, and turned on it."""
        if one.lands is None or one.lands.stays:
            return self._ready_s(one) + one.climbs_s
        return max(self._ready_s(one) + one.robot.battery.climbing_s, one.lands.duration_s + self._ways.pause_s)

    def _first_landed(self, one: Flyer, moments_s: Floats, asked: _Moments, spare_s: float) -> Arrival:
        """The first moment at which the round is on a charger on which the robot is: its own, if any is."""
        assert one.charger is not None, f"{one.robot.name} lands nowhere"
        if self._chargers.index(one.charger) in self._known.docks:
            return self._first_on(one, one.charger, one.level_s, self._ready_s(one), moments_s, asked, spare_s)
        best = Arrival()
        for each in one.transfers:
            ready_s = each.leaves_s + each.way.duration_s + one.robot.battery.landing_s
            found = self._first_on(one, each.charger, each.level_s, ready_s, moments_s, asked, spare_s)
            if found.joins_s < best.joins_s:
                best = replace(found, via=each.charger)
        return best

    def _first_on(
        self, one: Flyer, charger: Charger, level_s: float, ready_s: float, moments_s: Floats, asked: _Moments,
        spare_s: float,
    ) -> Arrival:  # fmt: skip
        """The same at a charger at which the robot charges from some time on, with so much to spare."""
        left_s = one.level_after_s(level_s, moments_s - ready_s, charger)
        is_enough = (asked.docks == self._chargers.index(charger)) & (
            left_s >= asked.landed_s + np.where(moments_s == 0, 0.0, spare_s)
        )
        if not is_enough.any():
            return Arrival()
        first = int(np.argmax(is_enough))
        joins_s = float(moments_s[first])
        return Arrival(joins_s=joins_s, phase_s=float(asked.phases_s[first]), leaves_s=joins_s)

    def _first_moving(self, one: Flyer, moments_s: Floats, asked: _Moments, before_s: float) -> Arrival | None:
        """The first moment before that at which the robot can come from its charger into the round as that moves."""
        assert one.charger is not None, f"{one.robot.name} lands nowhere"
        leaves_s = self._leaves_s(one)
        early = np.flatnonzero((asked.docks < 0) & (moments_s > leaves_s) & (moments_s < before_s))
        if not len(early):
            return None
        way_s = asked.straight_s[self._chargers.index(one.charger), early]
        enough = self._has_enough(one, moments_s[early] - leaves_s - way_s, way_s, asked.flying_s[early])
        from_s = 0.0
        for k in early[enough].tolist():
            joins_s, phase_s = float(moments_s[k]), float(asked.phases_s[k])
            if joins_s < from_s or (way := self._way_into(one.charger, phase_s)) is None:
                continue
            lasts_s = way.lasts_s(1.0)
            stays_s = np.array(joins_s - leaves_s - lasts_s)
            if stays_s < 0:
                from_s = joins_s - float(stays_s) / 2  # places that the round comes to sooner are about as far
            elif self._has_enough(one, stays_s, np.array(lasts_s), asked.flying_s[k]):
                return Arrival(joins_s=joins_s, phase_s=phase_s, leaves_s=joins_s - lasts_s, enters=way.line_to(1.0))
        return None

    def _has_enough(self, one: Flyer, stays_s: Floats, way_s: Floats, needs_s: Floats) -> Flags:
        """Whether a robot that charges for so long and then flies so long into the round can go on with it for ever."""
        assert one.charger is not None, f"{one.robot.name} lands nowhere"
        battery, least_s = one.robot.battery, self._needs.spare_s + SHORTEST_S
        used_s = battery.departure_s + way_s * max(1.0, battery.standing_uses)
        return np.asarray(one.level_after_s(one.level_s, stays_s, one.charger) - used_s >= needs_s + least_s)

    def _way_into(self, charger: Charger, phase_s: float) -> Way | None:
        """The way from a charger into the round at a moment of it; None: walls or a curve leave no room for it."""
        key = charger.name, phase_s
        if key not in self._known_ways:
            [at] = motions_of(self._line, np.array([phase_s]), before=False)
            self._known_ways[key] = self._ways.way(np.array(charger.at), at)
        return self._known_ways[key]
