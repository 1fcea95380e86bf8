"""Ways between chargers and rounds as robots can drive them: corners, turns, curves, and run-ups to a round's speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rota.errors import PlanError
from rota.geometry.kernels import free_segments
from rota.geometry.shortest_path import ShortestPaths
from rota.model.arrays import Floats, Ints
from rota.model.mission import Robot
from rota.planners.patrol.driving.round_starts import steady_legs
from rota.planners.patrol.driving.rounded import driving_with_mass
from rota.planners.patrol.driving.timed_line import TimedLine, chain, steady, stretch
from rota.planners.patrol.tolerances import ROUNDING, SAME_PLACE_M
from rota.planners.patrol.tours.curve_kernels import STEP_RAD
from rota.planners.patrol.traffic.starts.approaches import timed_approach, without_short_legs
from rota.planners.patrol.traffic.starts.paths_by_body import PathsByBody

PAUSES = 50  # between robots that pass each other beside a post, each by a tenth longer, that are tried
MOST_LOOKED_AT = 24  # places of a round, the nearest to a charger, while a battery lasts for whole rounds from there
LANDED_S = 1.0  # on a charger between two flights, of who need not turn back there


class Motion(NamedTuple):
    """How a round is driven at a place (2,): in a direction (2,) of length 1, and how fast; no direction: it stays.

    aside_s: seconds from there to the nearer end of the leg; inf at an end itself. is_steady: amid a leg before, on and
    after which its velocity does not jump.
    """

    place_m: Floats
    direction: Floats | None
    speed_m_s: float
    aside_s: float
    is_steady: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class Way:
    """A way from rest at a charger into a moving round: the line to where a run-up begins, and the run-up.

    The run-up is for a round as fast as it can be driven. One row: none is needed.
    """

    line: TimedLine
    run_up: TimedLine

    def lasts_s(self, slower: float) -> float:
        """Seconds to a round that takes ``slower`` times as long."""
        return self.line.duration_s + slower * self.run_up.duration_s

    def line_to(self, slower: float) -> TimedLine:
        """The way to such a round. Its run-up takes as much longer: so it ends as fast as the round goes."""
        return chain(self.line, stretch(self.run_up, slower))


class Passing(NamedTuple):
    """Ways from a charger to a post and back on which robots pass each other that are there ``pause_s`` apart."""

    there: TimedLine
    back: TimedLine
    pause_s: float


class Ways:
    """The ways of robots of one kind between chargers and places of rounds; ``paths`` are the shortest ones.

    steadily: they come and go where rounds are driven at a constant velocity: curves, if cut there, tell higher jerks.
    """

    def __init__(self, robot: Robot, paths_by_body: PathsByBody, *, steadily: bool = False) -> None:
        self._robot, self._paths_by_body, self._steadily = robot, paths_by_body, steadily
        self.paths = paths_by_body.paths(robot.body_radius_m)
        self._at_once = robot.turns_at_once
        self._known: dict[bytes, Way | None] = {}

    @property
    def turns_back_s(self) -> float:
        """How long a robot takes to turn back where it stands."""
        return _turns_back_s(self._robot)

    @property
    def pause_s(self) -> float:
        """How long it stays on a charger between two flights at least."""
        return pause_s(self._robot)

    def straight_s(self, chargers_m: Floats, places_m: Floats) -> Floats:
        """How long the shortest ways take (c, k) from chargers (c, 2) to places (k, 2) at full speed all the way."""
        return np.asarray(self.paths.distances(chargers_m, places_m) / self._robot.ground_speed_m_s)

    def last_s(self, line: TimedLine, phases_s: Floats, chargers_m: Floats, slower: float, even: Ints) -> Floats:
        """How long ways take (c, k) from chargers (c, 2) into a round at its phases (k,), or back, whichever is longer.

        slower: by how much longer than ``line`` its rounds may take. even: the phases that are enough where batteries
        last for parts of a round only. inf: no way leads there, or it was not looked for, since there are nearer ones
        and a battery lasts for whole rounds, or for none.
        """
        straight_s = self.straight_s(chargers_m, line.at(phases_s))
        if self._at_once:
            return straight_s
        both = list(zip(*(motions_of(line, phases_s, before=before) for before in (False, True)), strict=True))
        found = np.full(straight_s.shape, np.inf)
        rest_s = self._robot.battery.usable_s - line.duration_s * slower
        in_parts = line.duration_s > self._robot.battery.usable_s
        for own_s, nearest_s, charger_m in zip(found, straight_s, chargers_m, strict=True):
            for n, k in enumerate(even if in_parts else np.argsort(nearest_s, kind="stable")):
                if n >= MOST_LOOKED_AT and 2 * float(own_s.min()) <= rest_s:
                    break
                own_s[k] = self._longer_s(charger_m, both[k], slower)
        return found

    def _longer_s(self, charger_m: Floats, both: Sequence[Motion], slower: float) -> float:
        """Seconds of the longer of the ways there and back; inf: there is none."""
        ways = [self.way(charger_m, at) for at in both]
        return max(math.inf if way is None else way.lasts_s(slower) for way in ways)

    def passing(self, charger_m: Floats, post_m: Floats, clearance_s: float) -> Passing | None:
        """Ways to a post on which robots pass each other; None: walls leave no room, or robots turn on arcs.

        clearance_s: how long after each other they are there if they change speed at once.
        """
        robot, straight_m = self._robot, clearance_s * self._robot.ground_speed_m_s
        if robot.turn_radius_m or (lines := passing_ways(self.paths, charger_m, post_m, straight_m)) is None:
            return None
        if self._at_once:
            there, gone = (steady(_along_m(line_m) / robot.ground_speed_m_s, line_m) for line_m in lines)
            return Passing(there, gone.backwards(), clearance_s)
        there, gone = (timed_approach(line_m, robot).line for line_m in lines)
        for pause_s in clearance_s * 1.1 ** np.arange(PAUSES):
            moments_s = np.linspace(0.0, pause_s, 200)
            apart_m = there.at(there.duration_s - pause_s + moments_s) - gone.at(gone.duration_s - moments_s)
            if np.hypot(*apart_m.T).min() >= straight_m / math.sqrt(2) * (1 - ROUNDING):
                return Passing(there, gone.backwards(), float(pause_s))
        return None

    def into(self, charger_m: Floats, line: TimedLine, phase_s: float, slower: float, lasts_s: float) -> TimedLine:
        """The way from a charger into a round that is ``slower`` times as long as its line; lasts_s: at most."""
        return self._way_at(charger_m, line, phase_s, slower, lasts_s, before=False)

    def back(self, charger_m: Floats, line: TimedLine, phase_s: float, slower: float, lasts_s: float) -> TimedLine:
        """The way out of such a round, and to the charger."""
        return self._way_at(charger_m, line, phase_s, slower, lasts_s, before=True).backwards()

    def _way_at(
        self, charger_m: Floats, line: TimedLine, phase_s: float, slower: float, lasts_s: float, *, before: bool
    ) -> TimedLine:
        """The way from a charger to where a round is at a phase, on or backwards from there."""
        [at] = motions_of(line, np.array([phase_s]), before=before)
        if self._at_once:
            way_m = self.paths.path(charger_m, at.place_m)
            return steady(_shares(way_m) * lasts_s, way_m)
        way = self.way(charger_m, at)
        assert way is not None, "a handover with a way has one"
        return way.line_to(slower)

    def way(self, charger_m: Floats, at: Motion) -> Way | None:
        """The way from a charger (2,) into a round, kept for the next time; None: walls leave no room for it."""
        heading = np.zeros(2) if at.direction is None else at.direction
        key = np.concatenate([charger_m, at.place_m, heading, [at.speed_m_s]]).tobytes()
        if key not in self._known:
            self._known[key] = self._new_way(charger_m, at)
        return self._known[key]

    def _new_way(self, charger_m: Floats, at: Motion) -> Way | None:
        """The same, looked for."""
        if (run_up := self._run_up(at)) is None:
            return None
        begins_m = run_up.places_m[0]
        if np.hypot(*(begins_m - charger_m)) <= SAME_PLACE_M:
            return Way(line=steady(np.zeros(1), begins_m[None]), run_up=run_up)
        onward_m = None if at.direction is None else begins_m + at.direction
        try:
            line_m = self._paths_by_body.line(self._robot, charger_m, begins_m, onward_m)
        except PlanError:
            return None
        if self._robot.turn_radius_m and not free_segments(line_m[:-1], line_m[1:], self.paths.grid).all():
            return None
        line = timed_approach(line_m, self._robot, None if self._robot.turn_radius_m else onward_m).line
        return Way(line=self._with_turn(line, onward_m), run_up=run_up)

    def past(self, charger_m: Floats, at: Motion, place_m: Floats, slower: float) -> tuple[TimedLine, TimedLine] | None:
        """A way from a charger into a round by a place (2,), at which robots may wait: the lines to there and on.

        slower: by how much longer than as fast as can be the round takes. None: walls leave no room, or the place is
        the charger or in the round. Robots that turn on arcs have none.
        """
        robot, paths = self._robot, self.paths
        if robot.turn_radius_m or (run_up := self._run_up(at)) is None:
            return None
        begins_m = run_up.places_m[0]
        try:
            there_m, on_m = (
                without_short_legs(paths.path(*ends)) for ends in ((charger_m, place_m), (place_m, begins_m))
            )
        except PlanError:
            return None
        if len(there_m) < 2 or len(on_m) < 2:
            return None
        if self._at_once:
            there, on = (steady(_along_m(line_m) / robot.ground_speed_m_s, line_m) for line_m in (there_m, on_m))
            return there, on
        onward_m = None if at.direction is None else begins_m + at.direction
        there, on = (
            self._with_turn(timed_approach(line_m, robot, next_m).line, next_m)
            for line_m, next_m in ((there_m, on_m[1]), (on_m, onward_m))
        )
        return there, chain(on, stretch(run_up, slower))

    def _run_up(self, at: Motion) -> TimedLine | None:
        """What robots with mass drive to get up the speed of a round; None: walls leave no room for it."""
        if self._within_curve(at):
            return None
        if not self._robot.motion.has_mass or at.direction is None:
            return steady(np.zeros(1), at.place_m[None])
        run_up = driving_with_mass(self._robot).run_up(at.place_m, at.direction, at.speed_m_s)
        is_free = free_segments(run_up.places_m[:1], at.place_m[None], self.paths.grid)[0]
        return run_up if is_free else None

    def _within_curve(self, at: Motion) -> bool:
        """Whether a place may be so near to the end of a leg of a curve that what is left of the leg is no tangent."""
        radius_m = self._robot.turn_radius_m
        if radius_m > 0:
            return at.aside_s * at.speed_m_s < radius_m * STEP_RAD
        if self._steadily and at.speed_m_s > 0 and not at.is_steady:
            return True
        return self._robot.motion.has_mass and at.aside_s < driving_with_mass(self._robot).step_s / 2

    def _with_turn(self, line: TimedLine, onward_m: Floats | None) -> TimedLine:
        """The line of a robot with mass, with the time to turn on to its run-up; others have it in their lines."""
        if onward_m is None or line.stays or not self._robot.motion.has_mass:
            return line
        steps_m = np.diff(line.places_m, axis=0)
        before, after = steps_m[np.hypot(*steps_m.T) > 0][-1], onward_m - line.places_m[-1]
        turn_rad = abs(math.atan2(before[0] * after[1] - before[1] * after[0], before @ after))
        pause_s = turn_rad * driving_with_mass(self._robot).limits.turn_s
        return chain(line, steady(np.array([0.0, pause_s]), line.places_m[[-1, -1]])) if pause_s > 0 else line


def pause_s(robot: Robot) -> float:
    """How long it stays on a charger between two flights at least: it turns there, or takes off anew on an arc."""
    return _turns_back_s(robot) or LANDED_S


def _turns_back_s(robot: Robot) -> float:
    """How long it takes to turn back where it stands."""
    return math.pi / (robot.turn_rate_rad_s or math.inf)


def _along_m(line_m: Floats) -> Floats:
    """How far along a polyline (k, 2) its corners lie."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line_m, axis=0).T))])


def _shares(line_m: Floats) -> Floats:
    """The same, in 0..1."""
    along_m = _along_m(line_m)
    return along_m / along_m[-1] if along_m[-1] > 0 else np.linspace(0.0, 1.0, len(line_m))


def motions_of(line: TimedLine, phases_s: Floats, *, before: bool) -> list[Motion]:
    """How a round is driven at some of its phases (k,), on from there; before: backwards from there.

    Who turns there or waits has not turned yet, or not turned back: it looks where it goes next.
    """
    if line.stays:
        return [Motion(line.places_m[0], None, 0.0, math.inf) for _ in phases_s]
    steps_m, lasts_s = np.diff(line.places_m, axis=0), np.diff(line.times_s)
    lengths_m, count = np.hypot(*steps_m.T), len(lasts_s)
    moves = np.flatnonzero(lengths_m > 0)
    at_s = np.mod(phases_s, line.duration_s)
    nearest_s = line.times_s[np.abs(line.times_s - at_s[:, None]).argmin(axis=1)]
    # as a round begins that is begun there: on a row, where one is so near
    at_s = np.where(np.abs(nearest_s - at_s) < 1e-6 * line.duration_s / len(line.times_s), nearest_s, at_s)
    at_s[at_s == line.duration_s] = 0.0
    found, are_steady = [], steady_legs(line)
    for place_m, time_s in zip(line.at(at_s), at_s, strict=True):
        if before:
            leg = int(np.searchsorted(line.times_s, time_s, side="left") - 1) % count
            own = moves[np.searchsorted(moves, leg, side="right") - 1]  # the last one before the first
            done_s = lasts_s[leg] if time_s == 0 else time_s - line.times_s[leg]
        else:
            leg = int(np.searchsorted(line.times_s, time_s, side="right") - 1) % count
            own = moves[np.searchsorted(moves, leg) % len(moves)]
            done_s = time_s - line.times_s[leg]
        speed_m_s = lengths_m[leg] / lasts_s[leg] + line.accelerations_m_s2[leg] * (done_s - lasts_s[leg] / 2)
        direction = steps_m[own] / lengths_m[own]
        speed_m_s = max(0.0, float(speed_m_s)) if lengths_m[leg] > 0 else 0.0
        aside_s = min(done_s, lasts_s[leg] - done_s) or math.inf
        is_steady = bool(are_steady[leg]) and aside_s < math.inf
        found.append(Motion(place_m, -direction if before else direction, speed_m_s, aside_s, is_steady))
    return found


def passing_ways(
    paths: ShortestPaths, charger_m: Floats, post_m: Floats, straight_m: float
) -> tuple[Floats, Floats] | None:
    """Two ways (k, 2) from a charger to a post, at right angles for ``straight_m`` there: to come by, and to go back.

    None: walls leave no room for them, no way leads there, or the charger is as near.
    """
    try:
        way_m = paths.path(charger_m, post_m)
    except PlanError:
        return None
    steps_m = np.diff(way_m, axis=0)
    if np.hypot(*steps_m.T).sum() <= straight_m + SAME_PLACE_M:
        return None
    ahead_rad = math.atan2(*-steps_m[-1][::-1])
    for turn in sorted(range(-5, 7), key=abs):  # about the post, until walls leave room
        turned_rad = ahead_rad + turn * math.pi / 6 + np.array([-math.pi / 4, math.pi / 4])
        beside_m = post_m + straight_m * np.column_stack([np.cos(turned_rad), np.sin(turned_rad)])
        if not free_segments(beside_m, np.vstack([post_m, post_m]), paths.grid).all():
            continue
        comes_m, goes_m = (np.vstack([paths.path(charger_m, each), post_m]) for each in beside_m)
        return comes_m, goes_m
    return None
