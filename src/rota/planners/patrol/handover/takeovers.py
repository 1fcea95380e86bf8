"""Plans in which the robots that remain share rounds: who keeps its own, who comes into which, and at which phase."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import shapely
from shapely import MultiPolygon

from rota.errors import NoPlanFound, PlanError
from rota.geometry.free_space import free_ground
from rota.model.mission import Robot, Zone, inner_reach_m
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.driving.timed_line import TimedLine
from rota.planners.patrol.handover.charging.takeovers import takeovers_with_chargers
from rota.planners.patrol.handover.joining import Entries, Standing, heading_of, join_at, join_evenly, stand_by
from rota.planners.patrol.handover.on_lanes import takeovers_on_lanes
from rota.planners.patrol.handover.rounds import (
    HALVINGS,
    PHASES,
    Round,
    begin_at,
    distances_between,
    is_clear,
    join_rounds,
    lead_round,
    rounds_of,
    slow_down,
)
from rota.planners.patrol.handover.shares import Share, Sharing, sharings
from rota.planners.patrol.tolerances import TIE
from rota.planners.patrol.traffic.starts.assignment import least_sum
from rota.planners.patrol.traffic.starts.from_starts import lead_from_starts
from rota.planners.patrol.traffic.starts.paths_by_body import PathsByBody
from rota.planning.planner import Handover


def takeovers(asked: Handover) -> Iterator[Plan]:
    """Plans for the mission with a seam, the one that changes least first; see ``Planner.takeovers``."""
    if asked.mission.chargers:
        yield from takeovers_with_chargers(asked)
        return
    takeover = _Takeover(asked)
    if takeover.going_on.keys() == asked.going_on.keys() and asked.going_on:
        waiting = {name: stand_by(one) for name, one in takeover.standing.items() if name not in asked.going_on}
        yield takeover.plan({**waiting, **takeover.going_on})
    if asked.mission.lanes:
        yield from takeovers_on_lanes(asked)
        return
    # who is under way with mass would have to brake first
    if not takeover.rounds or any(one.robot.motion.has_mass for one in takeover.standing.values()):
        return
    for sharing in takeover.sharings():
        yield from takeover.plans_of(sharing)
    takeover.finer.sort(key=lambda one: one[0])
    for _, finer in takeover.finer[:4]:  # the least late ones
        yield from finer


class _Option(NamedTuple):
    """What robots of one share may drive, by their names; at a phase of their round, with a step to others beside it.

    entries: of robots that are evenly spaced; None: there is no other phase.
    """

    lines: dict[str, Trajectory]
    entries: Entries | None = None
    phase_s: float = 0.0
    step_s: float = 0.0

    @property
    def last_s(self) -> float:
        """When the last of these robots is in its loop."""
        return max(one.loop_start_s for one in self.lines.values())

    def beside(self) -> list[_Option]:
        """The options half a step before and after this one."""
        if self.entries is None or self.entries.line.stays:
            return []
        step_s = self.step_s / 2
        both = (_option_at(self.entries, self.phase_s + shift_s, step_s) for shift_s in (-step_s, step_s))
        return [option for option in both if option is not None]


def _option_at(entries: Entries, phase_s: float, step_s: float) -> _Option | None:
    """All robots of a round evenly spaced, the first at this phase; None where one cannot come."""
    joined = join_evenly(entries, phase_s)
    return None if joined is None else _Option({one.robot: one for one in joined}, entries, phase_s, step_s)


class _Takeover:
    """The rounds that are to be shared, and the robots that remain."""

    def __init__(self, asked: Handover) -> None:
        self.asked, self.mission = asked, asked.mission
        fleet = asked.mission.fleet
        headings = {driven.robot: heading_of(driven) for driven in asked.seam.driven}
        self.standing = {
            robot.name: Standing(
                robot=robot, place_m=np.array(asked.places[robot.name]), heading_rad=headings.get(robot.name)
            )
            for robot in fleet.robots or ()
        }
        self.paths_by_body = PathsByBody(asked.mission)
        self.robot = max((one.robot for one in self.standing.values()), key=lambda robot: robot.body_radius_m)
        ground = free_ground(asked.mission)
        self.going_on = {
            name: line
            for name, line in asked.going_on.items()
            if is_clear(line.positions_m[:, :2], ground, self.standing[name].robot.body_radius_m)
        }
        self.rounds = self._rounds_in_reach(ground)
        # how late a plan is, and plans like it at phases beside its own
        self.finer: list[tuple[tuple[float, ...], Iterator[Plan]]] = []
        self._joined: dict[tuple[tuple[int, ...], float], Round] = {}
        self._drivers = [
            drivers_of(self.mission.zones, round_.line, [asked.drivers[name] for name in round_.ahead_s])
            for round_ in self.rounds
        ]

    def plan(self, trajectories: dict[str, Trajectory]) -> Plan:
        """The plan in which robots drive these, in the order of the fleet."""
        return Plan(
            mission=self.mission,
            seed=self.asked.seed,
            seam=self.asked.seam,
            trajectories=tuple(trajectories[name] for name in self.standing),
        )

    def _rounds_in_reach(self, ground: MultiPolygon) -> list[Round]:
        """The rounds, led past what is in their way now; those of which nothing can be driven are left out."""
        rounds, paths = [], self.paths_by_body.paths(self.robot.body_radius_m)
        for round_ in rounds_of(self.asked.loops):
            if is_clear(round_.line.places_m, ground, self.robot.body_radius_m):
                rounds.append(round_)
            elif (line := lead_round(round_.line, self._slowest, paths)) is not None:
                rounds.append(Round(line=line, ahead_s=round_.ahead_s))
        return rounds

    @property
    def _slowest(self) -> Robot:
        """The robot that is slowest, at whose speed rounds are driven that anybody may come into."""
        return min((one.robot for one in self.standing.values()), key=lambda robot: robot.ground_speed_m_s)

    def sharings(self) -> list[Sharing]:
        """Ways to share the rounds that are worth a look."""
        paths = self.paths_by_body.paths(self.robot.body_radius_m)
        between_m = distances_between(self.rounds, paths)
        matters = self.asked.importance
        importance = [max(matters.get(name, 0.0) for name in round_.ahead_s) for round_ in self.rounds]
        speed_m_s = self._slowest.ground_speed_m_s
        return sharings(self.rounds, list(self.standing), between_m, speed_m_s, self.asked.most, importance)

    def plans_of(self, sharing: Sharing) -> Iterator[Plan]:
        """Plans with rounds shared so: robots keep theirs and others fill in for lost ones, or are spaced evenly."""
        own = list(zip(sharing, self._who(sharing), strict=True))
        fills = [self._can_fill(share, names) for share, names in own]
        if any(fills):
            yield from self._least_late(
                [self._options(*each, fill=fill) for each, fill in zip(own, fills, strict=True)]
            )
        settled = [fill and self._is_as_before(*each) for each, fill in zip(own, fills, strict=True)]
        if not all(settled):
            yield from self._least_late(
                [self._options(*each, fill=fill) for each, fill in zip(own, settled, strict=True)]
            )
        if self.robot.body_radius_m > 0:
            yield from self._lead_all(sharing, [names for _, names in own])

    def _who(self, sharing: Sharing) -> list[list[str]]:
        """The names of the robots of each share: those that drove its rounds before, and others that are near."""
        names, slots = list(self.standing), [k for k, share in enumerate(sharing) for _ in range(share.robots)]
        costs_s = np.zeros((len(names), len(sharing)))
        for k, share in enumerate(sharing):
            drivers = [one for number in share.rounds for one in self._drivers[number]]
            for i, name in enumerate(names):
                if not any(name in self.rounds[number].ahead_s for number in share.rounds):
                    one = self.standing[name]
                    places = np.vstack([self.rounds[number].line.places_m[::4] for number in share.rounds])
                    paths = self.paths_by_body.paths(one.robot.body_radius_m)
                    here_m = self.paths_by_body.standing(one.robot, one.place_m)[None]
                    costs_s[i, k] = 1.0 + paths.distances(here_m, places).min() / one.robot.ground_speed_m_s
                costs_s[i, k] += 1e6 * max(  # for a robot that is slower, sees less far or does not count there
                    (one.shortfalls(self.standing[name].robot) for one in drivers), default=0
                )
        costs_s = np.where(np.isfinite(costs_s), costs_s, 1e9)
        who, where = least_sum(costs_s[:, slots])
        own: list[list[str]] = [[] for _ in sharing]
        for i, slot in zip(who, where, strict=True):
            own[slots[slot]].append(names[i])
        return own

    def _can_fill(self, share: Share, names: Sequence[str]) -> bool:
        """Whether these robots can go on in the one round of a share as before, and others fill in for lost ones."""
        before = self.rounds[share.rounds[0]].ahead_s
        here = [name for name in names if name in before and name in self.going_on]
        return len(share.rounds) == 1 and len(names) <= len(before) and bool(here)

    def _is_as_before(self, share: Share, names: Sequence[str]) -> bool:
        """Whether the robots of one round are those of before, so that they are spaced as they were."""
        round_ = self.rounds[share.rounds[0]]
        return round_.line.stays or set(names) == set(round_.ahead_s)

    def _round_of(self, share: Share, names: Sequence[str]) -> Round:
        """The round of a share, no faster than the slowest of these robots drives."""
        robot = min((self.standing[name].robot for name in names), key=lambda robot: robot.ground_speed_m_s)
        if len(share.rounds) == 1:
            return slow_down(self.rounds[share.rounds[0]], robot)
        key = share.rounds, robot.ground_speed_m_s
        if key not in self._joined:
            paths = self.paths_by_body.paths(self.robot.body_radius_m)
            lines = [self.rounds[number].line for number in share.rounds]
            self._joined[key] = Round(line=join_rounds(lines, robot, paths), ahead_s={})
        return self._joined[key]

    def _options(self, share: Share, names: Sequence[str], *, fill: bool) -> list[_Option]:
        """What robots of a share may drive, each at another phase; those that go on as before have no other."""
        round_ = self._round_of(share, names)
        here = [name for name in names if fill and name in round_.ahead_s and name in self.going_on]
        kept = {name: self.going_on[name] for name in here}
        others = [name for name in names if name not in kept]
        if not others:
            return [_Option(kept)]
        entries = Entries(round_.line, [self.standing[name] for name in others], self.paths_by_body)
        if fill:
            vacant_s = [ahead_s for name, ahead_s in round_.ahead_s.items() if name not in kept]
            joined = join_at(entries, vacant_s)
            return [] if joined is None else [_Option(kept | {one.robot: one for one in joined})]
        apart_s = round_.duration_s / len(names)
        every = (_option_at(entries, phase_s, apart_s / PHASES) for phase_s in self._phases_s(round_, names))
        return [option for option in every if option is not None]

    def _least_late(self, choices: list[list[_Option]]) -> Iterator[Plan]:
        """The plan with the least late option of each share, chosen one after the other; none where one has none."""
        if not all(choices):
            return
        found: dict[str, Trajectory] = {}
        for options in choices:
            found |= min(options, key=lambda option: option.last_s).lines
        best = [options[0] for options in choices]
        for k, options in enumerate(choices):
            if len(options) > 1:
                found, best[k] = self._least_late_of(found, options)
        plan = self.plan(found)
        yield plan
        self.finer.append((self.asked.lateness(plan), self._finer(found, best)))

    def _finer(self, found: dict[str, Trajectory], best: list[_Option]) -> Iterator[Plan]:
        """Plans with phases beside the best ones, nearer and nearer to them."""
        for _ in range(HALVINGS):
            finer = [option.beside() for option in best]
            if not any(finer):
                return
            for k, options in enumerate(finer):
                if options:
                    found, best[k] = self._least_late_of(found, [best[k], *options])
            yield self.plan(found)

    def _least_late_of(
        self, found: dict[str, Trajectory], options: Sequence[_Option]
    ) -> tuple[dict[str, Trajectory], _Option]:
        """What all drive with the least late of these options, and that option, from which finer steps lead on."""
        ranked = [(self.asked.lateness(self.plan({**found, **one.lines})), k) for k, one in enumerate(options)]
        best = options[min(ranked)[1]]
        return {**found, **best.lines}, best._replace(step_s=min(one.step_s for one in options))

    def _phases_s(self, round_: Round, names: Sequence[str]) -> list[float]:
        """Phases of the first robot that are tried: at each of them robots are as far round as they are, or evenly."""
        if round_.line.stays:
            return [0.0]
        apart_s = round_.duration_s / len(names)
        own = [round_.ahead_s[name] % apart_s for name in names if name in round_.ahead_s]
        evenly = np.linspace(0, apart_s, PHASES, endpoint=False) + (own[0] if own else 0.0)
        return list(dict.fromkeys([*own, *(float(phase) % apart_s for phase in evenly)]))

    def _lead_all(self, sharing: Sharing, own: Sequence[Sequence[str]]) -> Iterator[Plan]:
        """The plan in which all wait for the last, so that bodies stay apart on their ways, if there is one."""
        loops = []
        for share, names in zip(sharing, own, strict=True):
            round_ = self._round_of(share, names)
            before = [round_.ahead_s[name] for name in names if name in round_.ahead_s]
            for k, name in enumerate(names):
                ahead_s = (before[0] if before else 0.0) + k * round_.duration_s / len(names)
                line = begin_at(round_.line, ahead_s)
                loops.append(
                    Trajectory(
                        robot=name, times_s=line.times_s, positions_m=line.places_m,
                        accelerations_m_s2=line.accelerations_m_s2 if line.accelerations_m_s2.any() else None,
                    )
                )  # fmt: skip
        with suppress(NoPlanFound, PlanError):
            led = lead_from_starts(Plan(mission=self.mission, trajectories=tuple(loops)), self.mission, None)
            yield replace(led, seed=self.asked.seed, seam=self.asked.seam)


@dataclass(frozen=True, kw_only=True)
class Driver:
    """A robot that drove a round, and the names of sensors that count for each zone on its way where its own did."""

    robot: Robot
    counting: tuple[tuple[str, ...], ...]

    def shortfalls(self, other: Robot) -> int:
        """In how many respects another robot is no match: speed, reach, and whether it counts for all these zones."""
        slower = other.ground_speed_m_s < (1 - TIE) * self.robot.ground_speed_m_s
        nearer = inner_reach_m(other.sensor) < (1 - TIE) * inner_reach_m(self.robot.sensor)
        return slower + nearer + any(other.sensor.name not in names for names in self.counting)


def drivers_of(zones: Sequence[Zone], line: TimedLine, robots: Sequence[Robot]) -> list[Driver]:
    """The robots that drove a round as its drivers, one of each kind."""
    way = shapely.linestrings(line.places_m) if len(line.places_m) > 1 else shapely.points(line.places_m[0])
    found: dict[tuple[object, ...], Driver] = {}
    for robot in robots:
        near = [zone for zone in zones if zone.shape.distance(way) <= robot.sensor.reach_m]
        counting = tuple(zone.sensors for zone in near if robot.sensor.name in zone.sensors)
        found[robot.ground_speed_m_s, robot.sensor] = Driver(robot=robot, counting=counting)
    return list(found.values())
