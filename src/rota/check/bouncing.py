"""Whether trajectories are those of bouncing robots, and whether a floor that is to be covered is entered everywhere.

A bouncing robot drives straight along its heading, from cell to cell, or without cells until its body touches a wall.
Where something is in the way it stays, and turns counterclockwise by its bouncing angle; then the same again. Nothing
else turns it, but for the clock where it is to cover the floor. How long a turn takes is a matter of the speed and the
turn rate alone.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from rota.check.arrays import Ints
from rota.check.bounce_contacts import Around
from rota.check.bounce_floor import Floor
from rota.check.bounce_lines import Walls, line_violations
from rota.check.report import MOST_PER_ROBOT, Violation, violation
from rota.check.tolerances import BOUNCE_TOLERANCE_RAD, TOUCH_M
from rota.model.mission import Bouncing
from rota.model.plan import Plan, Trajectory
from rota.model.violation_kinds import ViolationKind

MOST_MOVES = 5_000_000  # of one robot


@dataclass(frozen=True, kw_only=True)
class Bounced:
    """What the check found of bouncing robots: violations, cells entered, and what is not judged.

    cells: (entered, all) where the floor is to be covered, else None.
    """

    violations: tuple[Violation, ...] = ()
    cells: tuple[int, int] | None = None
    not_judged: tuple[str, ...] = ()


def bounce_violations(plan: Plan) -> Bounced:
    """Judge a plan of the bounce planner by its mission alone; plans of other planners have no violations here."""
    rules = plan.mission.planning.bouncing
    if rules is None:
        return Bounced()
    if rules.cell_m == 0:
        return Bounced(violations=tuple(_without_cells(plan, rules)))
    floor = Floor(plan.mission, rules)
    if not floor.judgeable:
        wide_m = float(rules.cell_m)
        wrong = violation("too many cells to judge", "area", None, None, wide_m, wide_m, "m wide")
        return Bounced(violations=(wrong,))
    violations: list[Violation] = []
    entered = [np.empty((0, 2), np.int64)]
    by_clock = 0
    for k, trajectory in enumerate(plan):
        angles = rules.bouncing_angles_deg
        index = _index_in_fleet(plan, trajectory, k) if len(angles) > 1 else 0
        if index >= len(angles):
            violations.append(_no_angle(trajectory, index, len(angles)))
            continue
        judge = _Robot(plan, floor, rules, trajectory, round(angles[index] * rules.headings / 360))
        violations += judge.violations()[:MOST_PER_ROBOT]
        entered.append(judge.cells_entered())
        by_clock += judge.by_clock
    if not rules.covers:
        return Bounced(violations=tuple(violations))
    wanted = floor.every_free_cell()
    held = np.zeros(floor.shape, np.bool_)
    inside = np.vstack(entered)
    inside = inside[((inside >= 0) & (inside < floor.shape)).all(axis=1)]
    held[inside[:, 0], inside[:, 1]] = True
    missed = wanted[~held[wanted[:, 0], wanted[:, 1]]]
    if len(missed) or not len(wanted):
        x, y = floor.centres_m(missed[:1])[0] if len(missed) else floor.corner_m
        place = (float(x), float(y))
        violations.append(violation("cells never entered", "area", place, None, float(len(missed)), 0.0, "cells"))
    are = "turns are" if by_clock != 1 else "turn is"
    told = f"{by_clock} {are} taken to be by the clock: no bounce explains" + (" them" if by_clock != 1 else " it")
    not_judged = (told,) if by_clock else ()
    return Bounced(violations=tuple(violations), cells=(len(wanted) - len(missed), len(wanted)), not_judged=not_judged)


def _without_cells(plan: Plan, rules: Bouncing) -> list[Violation]:
    """Violations of robots without a grid, which touch walls exactly and never come near another robot."""
    walls, violations = Walls(plan.mission), []
    angles = rules.bouncing_angles_deg
    for k, trajectory in enumerate(plan):
        index = _index_in_fleet(plan, trajectory, k) if len(angles) > 1 else 0
        if index >= len(angles):
            violations.append(_no_angle(trajectory, index, len(angles)))
        else:
            violations += line_violations(trajectory, walls, math.radians(angles[index]))[:MOST_PER_ROBOT]
    return violations


def _no_angle(trajectory: Trajectory, index: int, angles: int) -> Violation:
    """The violation of a robot whose number ``index`` has none of the mission's ``angles`` bouncing angles."""
    return violation("no bouncing angle", trajectory.robot, None, None, float(index), float(angles), "angles")


def _index_in_fleet(plan: Plan, trajectory: Trajectory, otherwise: int) -> int:
    """The robot's number in a fleet that is listed; in one of equals, its number in the plan."""
    names = [robot.name for robot in plan.mission.fleet.robots or ()]
    return names.index(trajectory.robot) if names else otherwise


class _Robot:
    """One robot's way as moves from cell to cell and what it does between them."""

    def __init__(self, plan: Plan, floor: Floor, rules: Bouncing, trajectory: Trajectory, bounce: int) -> None:
        self._plan, self._floor, self._rules, self._trajectory = plan, floor, rules, trajectory
        self._bounce = bounce
        self._covers = rules.covers
        self._places = trajectory.positions_m[:, :2]
        self._cells, self._centred = floor.cells_at(self._places)
        self.by_clock = 0
        self._passed: list[Ints] = []
        self._found: list[Violation] = []
        self._walls: dict[tuple[int, int, int], bool] = {}

    def cells_entered(self) -> Ints:
        """(n, 2) cells that the robot is in, at the beginning and after each move."""
        return np.vstack([self._cells[self._centred], *self._passed])

    def violations(self) -> list[Violation]:
        """What no bouncing robot does: be off its cells, drive off its headings or through what blocks it, turn so."""
        off = np.flatnonzero(~self._centred)
        if len(off):
            gaps = np.hypot(*(self._places - self._floor.centres_m(self._cells)).T)
            return [self._wrong("off its cells", int(k), float(gaps[k]), TOUCH_M, "m") for k in off[:MOST_PER_ROBOT]]
        headings, counts = self._legs()
        if not self._found:
            self._judge_moves(headings, counts)
            self._judge_turns(headings)
        return self._found

    # ------------------------------------------------------------ ways

    def _legs(self) -> tuple[Ints, Ints]:
        """The heading (-1: it stands) and the number of moves of each leg; legs along no heading are noted."""
        steps, moves = np.diff(self._cells, axis=0), self._floor.moves
        headings, counts = np.full(len(steps), -1), np.zeros(len(steps), np.int64)
        for h, move in enumerate(moves):
            along = steps @ move
            count = np.where(along > 0, along // (move @ move), 0)
            same = (count > 0) & (count[:, None] * move == steps).all(axis=1)
            headings[same], counts[same] = h, count[same]
        for k in np.flatnonzero((headings < 0) & (steps != 0).any(axis=1))[:MOST_PER_ROBOT]:
            angle = math.degrees(math.atan2(steps[k, 1], steps[k, 0])) % 360
            self._found.append(self._wrong("along no heading", int(k), angle, 360 / len(moves), "degrees apart"))
        if counts.sum() > MOST_MOVES:
            self._found.append(self._wrong("too many moves to judge", 0, float(counts.sum()), MOST_MOVES, "moves"))
        return headings, counts

    def _judge_moves(self, headings: Ints, counts: Ints) -> None:
        """Each move must be free: no wall, and no corner where corners block; and the robot faces the way it drives."""
        leg = np.repeat(np.arange(len(counts)), counts)
        nth = np.arange(len(leg)) - np.repeat(np.cumsum(counts) - counts, counts)
        begins = self._cells[leg] + nth[:, None] * self._floor.moves[headings[leg]]
        self._passed.append(begins + self._floor.moves[headings[leg]])
        across = begins - (begins.min(axis=0) if len(begins) else 0)
        numbers = across[:, 0] * (across[:, 1].max(initial=0) + 1) + across[:, 1]  # of rows it would take ten times
        _, first, inverse = np.unique(
            numbers * len(self._floor.moves) + headings[leg], return_index=True, return_inverse=True
        )
        blocked = self._floor.blocks_moves(begins[first], headings[leg][first])[inverse]
        for k in np.unique(leg[blocked])[:MOST_PER_ROBOT]:
            self._found.append(
                self._wrong("drives through what blocks it", int(k), float(blocked[leg == k].sum()), 0, "moves")
            )
        faced = self._trajectory.headings_rad
        if faced is None:
            return
        moving = np.flatnonzero(headings >= 0)
        way = self._floor.moves[headings[moving]]
        true = np.arctan2(way[:, 1], way[:, 0])
        for end in (0, 1):
            off = np.abs(np.remainder(faced[moving + end] - true + math.pi, math.tau) - math.pi)
            for k in np.flatnonzero(off > BOUNCE_TOLERANCE_RAD)[:MOST_PER_ROBOT]:
                wrong = self._wrong(
                    "faces another way than it drives", int(moving[k]), float(off[k]), BOUNCE_TOLERANCE_RAD, "rad"
                )
                self._found.append(wrong)

    # ------------------------------------------------------------ turns

    def _judge_turns(self, headings: Ints) -> None:
        """Between two moves: bounces, each with something in the way, or the clock where the floor is to be covered."""
        order = list(range(len(headings)))
        start = self._trajectory.loop_index
        looping = self._trajectory.loop_duration_s > 0
        faced = self._nearest_headings(headings)
        stand: list[int] = []
        before = -1  # the heading of the last move
        turns = 0
        # the loop's beginning once more, for what is done across its seam
        moving = [k for k in order[start:] if headings[k] >= 0]
        next_round = order[start : moving[0] + 1] if looping and moving else order[start:] if looping else []
        for k in [*order, *next_round]:
            if headings[k] < 0:
                stand.append(k)
                continue
            turns += self._judge_stand(stand, before, int(headings[k]), k, faced)
            stand, before = [], int(headings[k])
        self.by_clock = turns
        if not self._covers and not (looping and moving):
            self._judge_rest(before, faced)

    def _nearest_headings(self, headings: Ints) -> Ints | None:
        """The heading nearest to what the file gives at each timed point; None: it gives none."""
        if self._trajectory.headings_rad is None:
            return None
        moves = self._floor.moves
        true = np.arctan2(moves[:, 1], moves[:, 0])
        off = np.remainder(self._trajectory.headings_rad[:, None] - true + math.pi, math.tau) - math.pi
        return np.asarray(np.abs(off).argmin(axis=1))

    def _judge_stand(self, stand: list[int], before: int, after: int, leg: int, faced: Ints | None) -> int:
        """Judge the turns between two moves; returns how many of them only the clock explains.

        stand: legs on which the robot stands. before, after: headings of the moves round it, before is -1 where there
        is none. leg: the one that begins with the move after. faced: headings that the file gives, by timed point;
        None: it gives none.
        """
        count = len(self._floor.moves)
        ways = [before, after]
        if faced is not None:
            ways = [int(faced[k]) for k in stand] + [after]
            ways = ways if before < 0 or ways[0] == before else [before, *ways]
        elif before < 0:
            ways = [(after - self._bounce) % count, after] if stand else [after]
        waited = faced is None and bool(stand) and before == after
        by_clock = 0
        for nth, (heading, next_heading) in enumerate(itertools.pairwise(ways)):
            if heading == next_heading and not waited:
                if faced is not None and nth < len(stand) and not self._covers:
                    self._note_turn("waits where nothing is in the way", stand[nth], 0.0)
                continue
            bounces = self._bounces(heading, next_heading)
            step_s = self._trajectory.times_s[leg] - self._trajectory.times_s[stand[0]] if stand else 0.0
            begin_s = float(self._trajectory.times_s[stand[min(nth, len(stand) - 1)] if stand else leg])
            if bounces is None and not self._covers:
                self._note_turn("turns by another angle", leg, (next_heading - heading) % count * 360 / count)
                continue
            free = 0
            for j in range(bounces or 0):
                time_s = begin_s if faced is not None else begin_s + step_s * j / (bounces or 1)
                if not self._is_stopped(leg, (heading + j * self._bounce) % count, time_s):
                    free += 1
                    if not self._covers:
                        self._note_turn("turns where nothing is in the way", leg, self._bounce * 360 / count)
            if self._covers and (bounces is None or free or (faced is not None and bounces > 1)):
                by_clock += self._clock_turns(leg, heading, next_heading, begin_s)
        return by_clock

    def _clock_turns(self, leg: int, heading: int, next_heading: int, time_s: float) -> int:
        """How many turns by the clock, of one heading step each way, lead to the next heading, in the fewest turns.

        A bounce is such a turn, too, where something is in the way. Of as few turns those with fewest by the clock.
        """
        count = len(self._floor.moves)
        best = {heading: 0}
        while next_heading not in best:
            further: dict[int, int] = {}
            for at, clock in best.items():
                ways = [((at + 1) % count, clock + 1), ((at - 1) % count, clock + 1)]
                if self._is_stopped(leg, at, time_s):
                    ways.append(((at + self._bounce) % count, clock))
                for to, turns in ways:
                    if to not in best:
                        further[to] = min(further.get(to, turns), turns)
            best |= further
        return best[next_heading]

    def _bounces(self, heading: int, next_heading: int) -> int | None:
        """How many bounces turn the robot to the next heading, a whole round for the same one; None: no number does."""
        count = len(self._floor.moves)
        for n in range(1, count + 1):
            if (heading + n * self._bounce) % count == next_heading:
                return n
        return None

    def _is_stopped(self, leg: int, heading: int, time_s: float) -> bool:
        """Whether something is in the way of the robot that stands where the leg begins."""
        cell = self._cells[leg]
        key = (int(cell[0]), int(cell[1]), heading)
        if key not in self._walls:
            self._walls[key] = bool(self._floor.blocks_moves(cell[None], np.array([heading]))[0])
        if self._walls[key]:
            return True
        if not self._covers and (time_s >= self._trajectory.loop_start_s or self._rules.contact_free == "trajectory"):
            return False
        return Around(self._plan, self._floor).meets(self._trajectory, cell, heading, time_s)

    def _judge_rest(self, before: int, faced: Ints | None) -> None:
        """A robot that comes to rest must be hemmed in: whichever way it turns at each bounce, something is there.

        Where it goes on turning there, it must turn by bounces.
        """
        count = len(self._floor.moves)
        known = [int(faced[-1])] if faced is not None else [before] if before >= 0 else range(count)
        turned = [] if faced is None else [int(heading) for heading in faced[self._trajectory.loop_index :]]
        for k, (heading, after) in enumerate(itertools.pairwise(turned), start=self._trajectory.loop_index):
            if heading != after and self._bounces(heading, after) is None:
                self._note_turn("turns by another angle", k, (after - heading) % count * 360 / count)
        cell = np.tile(self._cells[-1], (count, 1))
        for first in known:
            if self._floor.blocks_moves(cell, (first + self._bounce * np.arange(count)) % count).all():
                return
        self._note_turn("rests where nothing is in the way", len(self._cells) - 1, 0.0)

    def _note_turn(self, kind: ViolationKind, leg: int, angle_deg: float) -> None:
        """Note a wrong turn by ``angle_deg`` where the leg begins; the limit is the bouncing angle."""
        allowed = self._bounce * 360 / len(self._floor.moves)
        self._found.append(self._wrong(kind, leg, angle_deg, allowed, "degrees"))

    def _wrong(self, kind: ViolationKind, leg: int, value: float, limit: float, unit: str) -> Violation:
        """A violation of this robot at the place and time at which the leg begins."""
        x, y = self._places[leg]
        time_s = float(self._trajectory.times_s[leg])
        return violation(kind, self._trajectory.robot, (x, y), time_s, float(value), float(limit), unit)
