"""Phases and directions at which no two robots ever meet, each loop driven at one speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from rota.model.arrays import Flags, Floats, Ints
from rota.planners.patrol.driving.timed_line import TimedLine
from rota.planners.patrol.tours.timetable import stretch_line
from rota.planners.patrol.traffic.bodies.loops import Clock, Grid, Loop, Timed, grid_of, near_pairs


class Choice(NamedTuple):
    """How a loop is driven: its offset in samples, and its direction, 1 as it is given or -1 reversed."""

    offset: int
    direction: int


def phases_apart(loops: Sequence[Loop], clock: Clock, body_radius_m: float) -> list[Timed] | None:
    """Each loop stretched to its headway, at a phase and in a direction such that no two robots touch; None: not found.

    To reverse a loop changes nothing of what is seen how often, but all meetings with the others.
    """
    rounds, trees, grid = on_the_clock(loops, clock, body_radius_m)
    if not all(follows_itself(tree, loop.robots, grid.apart_m) for tree, loop in zip(trees, loops, strict=True)):
        return None
    meets = Meetings(trees, [m * grid.bins for m in clock.multiples], grid.apart_m)
    chosen = choices_apart(meets, [loop.is_one_way for loop in loops])
    if chosen is None:
        return None
    return [drive(round_, choice, grid.step_s) for round_, choice in zip(rounds, chosen, strict=True)]


def phases_hardly_touching(loops: Sequence[Loop], clock: Clock, body_radius_m: float) -> list[Timed]:
    """Each loop stretched to its headway, one after the other at the phase at which it meets those before least."""
    rounds, trees, grid = on_the_clock(loops, clock, body_radius_m)
    meets = Meetings(trees, [multiple * grid.bins for multiple in clock.multiples], grid.apart_m)
    taken: list[Choice] = []
    for k in range(len(loops)):
        directions = (1,) if loops[k].is_one_way else (1, -1)
        both = [(meets.meetings(k, direction, taken), direction) for direction in directions]
        met, direction = min(both, key=lambda found: int(found[0].min()))
        taken.append(Choice(int(np.argmin(met)), direction))
    return [drive(round_, choice, grid.step_s) for round_, choice in zip(rounds, taken, strict=True)]


def on_the_clock(
    loops: Sequence[Loop], clock: Clock, body_radius_m: float
) -> tuple[list[TimedLine], list[cKDTree], Grid]:
    """The loops stretched to their headways, where each is at the samples of the common clock, and that clock."""
    durations_s = [loop.robots * m * clock.unit_s for loop, m in zip(loops, clock.multiples, strict=True)]
    rounds = [stretch_line(loop.line, s) for loop, s in zip(loops, durations_s, strict=True)]
    speed_m_s = max(loop.speed_m_s * loop.natural_s / s for loop, s in zip(loops, durations_s, strict=True))
    grid = grid_of(loops, clock, speed_m_s, body_radius_m, most_samples=6_000)
    samples = [loop.robots * multiple * grid.bins for loop, multiple in zip(loops, clock.multiples, strict=True)]
    return rounds, [cKDTree(sample(round_, n)) for round_, n in zip(rounds, samples, strict=True)], grid


def drive(round_: TimedLine, choice: Choice, step_s: float) -> Timed:
    """The round at its phase, in its direction."""
    return Timed(round_.backwards() if choice.direction < 0 else round_, choice.offset * step_s)


def sample(round_: TimedLine, samples: int) -> Floats:
    """Places (n, 2) at so many moments of a round, evenly spaced from its start; one place for a robot that stays."""
    if round_.stays:
        return round_.places_m
    return round_.at(np.arange(samples) * (round_.duration_s / samples))


def follows_itself(tree: cKDTree, robots: int, apart_m: float) -> bool:
    """Whether the robots that share a loop, evenly spaced in time, stay apart."""
    headway = tree.n // robots
    return all(
        bool((np.hypot(*(np.roll(tree.data, -k * headway, axis=0) - tree.data).T) >= apart_m).all())
        for k in range(1, robots)
    )


class Meetings:
    """How much two robots meet in which phases of one loop against another, in either direction of both."""

    def __init__(self, trees: Sequence[cKDTree], headways: Sequence[int], apart_m: float) -> None:
        self.headways = list(headways)
        self._still = [tree.n == 1 for tree in trees]
        self._near = {(i, k): near_pairs(trees[i], trees[k], apart_m) for k in range(len(trees)) for i in range(k)}
        self._shifts: dict[tuple[int, int, int, int], Ints] = {}

    def shifts(self, i: int, k: int, direction_i: int, direction_k: int) -> Ints:
        """Meetings (samples of both that are near) for each shift of k's offset against i's (i < k).

        Modulo the common measure of both headways.
        """
        key = (i, k, direction_i, direction_k)
        if key not in self._shifts:
            measure = math.gcd(self.headways[i], self.headways[k])
            near = self._near[i, k]
            if near is None:
                meets = np.ones(measure, dtype=np.int64)
            elif self._still[i] or self._still[k]:
                meets = np.full(measure, len(near[0]))  # a robot that stays is met at any phase
            else:
                meets = np.bincount((direction_k * near[1] - direction_i * near[0]) % measure, minlength=measure)
            self._shifts[key] = meets
        return self._shifts[key]

    def meetings(self, k: int, direction: int, taken: Sequence[Choice]) -> Ints:
        """For each offset of loop k, modulo its headway: its meetings with the loops before, at their choices."""
        met = np.zeros(self.headways[k], dtype=np.int64)
        for i, choice in enumerate(taken):
            meets = np.roll(self.shifts(i, k, choice.direction, direction), choice.offset)
            met += np.tile(meets, self.headways[k] // len(meets))
        return met

    def free(self, k: int, direction: int, taken: Sequence[Choice]) -> Flags:
        """Which offsets of loop k, modulo its headway, meet none of the loops before."""
        return np.asarray(self.meetings(k, direction, taken) == 0)


def choices_apart(meets: Meetings, one_way: Sequence[bool]) -> list[Choice] | None:
    """A choice for each loop at which nobody meets, by backtracking; None when none was found.

    one_way: of each loop whether it may not be driven backwards.
    """
    taken: list[Choice] = []
    allowed: list[list[Choice]] = []
    for _ in range(5_000):  # steps of the search
        k = len(taken)
        if k == len(one_way):
            return taken
        if len(allowed) == k:
            # the first loop may begin anywhere, and to reverse all of them changes nothing
            directions = (1,) if one_way[k] else (-1, 1)
            allowed.append(open_choices(meets, k, taken, directions) if k else [Choice(0, 1)])
        if allowed[k]:
            taken.append(allowed[k].pop())
            continue
        allowed.pop()
        if not taken:
            return None
        taken.pop()
    return None


def open_choices(meets: Meetings, k: int, taken: Sequence[Choice], directions: Sequence[int]) -> list[Choice]:
    """What loop k can choose, the best last: as it is given before reversed."""
    choices: list[Choice] = []
    for direction in directions:
        choices += [Choice(offset, direction) for offset in roomy_offsets(meets.free(k, direction, taken))]
    return choices


def roomy_offsets(free: Flags) -> list[int]:
    """Some of the free offsets, which go round: the ends of every stretch, evenly some more, the middles last.

    In the middle of a long stretch a late robot has most room; at its ends it leaves most room to others.
    """
    n, most = len(free), 48
    if free.all():
        return sorted({int(k * n / most) for k in range(most)}, reverse=True)
    starts = np.flatnonzero(free & ~np.roll(free, 1))
    ends = np.flatnonzero(free & ~np.roll(free, -1))
    if not len(starts):
        return []
    if ends[0] < starts[0]:
        ends = np.roll(ends, -1)
    lengths = (ends - starts) % n
    order = np.argsort(lengths, kind="stable")
    middles = (starts + lengths // 2)[order] % n
    every = np.flatnonzero(free)
    some = every[np.unique(np.linspace(0, len(every) - 1, most).astype(np.int64))]
    offsets = [*some, *starts[order], *ends[order], *middles]
    return [int(offset) for offset in reversed(dict.fromkeys(reversed(offsets)))][-2 * most :]
