"""How near Create 2 robots come to each other as they really drive: to a wall, back, and on when the clock says so."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from rota.model.arrays import Ints
from rota.model.plan import Floats

TOUCH_M = 1e-6
MOST_TOGETHER = 4096  # rounds of a loop that are looked at until two robots' loops come together again


@dataclass(frozen=True, kw_only=True)
class Driven:
    """Where a robot's centre is: straight from each of the places (n, 2) to the next, at the times (n,).

    ``legs`` (n,): the leg on which each place comes. ``loop_s``: the last so many seconds repeat for ever; 0: it stays.
    """

    times_s: Sequence[float]
    places_m: Sequence[tuple[float, float]]
    legs: Sequence[int]
    loop_s: float

    def until(self, end_s: float) -> tuple[Floats, Floats, Ints]:
        """Times, places and legs from 0 to beyond ``end_s``, as arrays."""
        times, places, legs = np.array(self.times_s), np.array(self.places_m), np.array(self.legs)
        if self.loop_s > 0 and times[-1] < end_s:
            again = np.flatnonzero(times > times[-1] - self.loop_s + 1e-9)
            rounds = math.ceil((end_s - times[-1]) / self.loop_s)
            more = [times[again] + (n + 1) * self.loop_s for n in range(rounds)]
            times = np.concatenate([times, *more])
            places = np.concatenate([places, *([places[again]] * rounds)])
            legs = np.concatenate([legs, *([legs[again]] * rounds)])
        elif times[-1] < end_s:
            times, places, legs = np.append(times, end_s), np.vstack([places, places[-1]]), np.append(legs, legs[-1])
        return times, places, legs


def touching_legs(robots: Sequence[Driven], apart_m: float) -> set[tuple[int, int]]:
    """Robots (their numbers) and legs on which some two centres are nearer than ``apart_m``, by more than 1e-6 m.

    Exact: between two times at which either changes its motion, two centres are nearest where a quadratic is least.
    """
    touching: set[tuple[int, int]] = set()
    for (i, first), (j, second) in itertools.combinations(enumerate(robots), 2):
        end_s = _together_s(first, second)
        (times_a, places_a, legs_a), (times_b, places_b, legs_b) = first.until(end_s), second.until(end_s)
        times = np.union1d(times_a, times_b)
        times = times[times <= end_s + 1e-9]
        gap = _at(times, times_b, places_b) - _at(times, times_a, places_a)
        start, change = gap[:-1], np.diff(gap, axis=0)
        change2 = (change**2).sum(axis=1)
        share = np.clip(-(start * change).sum(axis=1) / np.where(change2 > 0, change2, 1.0), 0.0, 1.0)
        nearest_m = np.hypot(*(start + share[:, None] * change).T)
        middle = (times[:-1] + times[1:])[nearest_m < apart_m - TOUCH_M] / 2
        for number, at, legs in ((i, times_a, legs_a), (j, times_b, legs_b)):
            on = legs[np.minimum(np.searchsorted(at, middle), len(legs) - 1)]
            touching |= {(number, int(leg)) for leg in np.unique(on)}
    return touching


def _at(times: Floats, known: Floats, places: Floats) -> Floats:
    return np.column_stack([np.interp(times, known, places[:, k]) for k in (0, 1)])


def _together_s(first: Driven, second: Driven) -> float:
    """A time after which two robots do nothing that they have not done together before."""
    longest = max(first.times_s[-1], second.times_s[-1])
    if first.loop_s == 0 or second.loop_s == 0:
        return longest + max(first.loop_s, second.loop_s)
    ratio = Fraction(first.loop_s / second.loop_s).limit_denominator(MOST_TOGETHER)
    return longest + first.loop_s * min(ratio.denominator, MOST_TOGETHER)
