"""What one robot can do for ever: the order of its visits, exact up to the rounding of times."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.planners.patrol.cycles.deadline_kernels import Outcome, round_for_ever, shortest_part
from rota.planners.patrol.tolerances import SURELY

TICKS = 1_000_000  # of the clock within the shortest deadline
DEAD_KEPT = 1000  # dead states of each place that are compared with


class Answer(NamedTuple):
    """The round (m,) of places that keeps all deadlines, if one was found; is_settled: it was, or there is none."""

    order: Ints | None
    is_settled: bool


def visit_for_ever(leg_s: Floats, period_s: Floats, *, most_states: int) -> Answer:
    """A round that comes to all places for ever, each again within its period; see ``deadline_kernels``.

    leg_s (n, n): from place to place in seconds, 0 on the diagonal and more elsewhere; period_s (n,). most_states:
    looked at, in each of two orders, before the question is left open. Times are rounded so that what is found keeps
    the periods; that there is nothing is proved for legs longer by a ``TICKS``-th of the shortest period, at most.
    """
    tick_s = float(period_s.min()) / TICKS
    leg = np.ceil(np.minimum(leg_s, 2 * period_s.max()) / tick_s).astype(np.int64)
    period = np.floor(period_s / tick_s).astype(np.int64)
    answer = _search(leg, period, most_states)
    if answer.order is None:
        return answer
    begin, end = shortest_part(answer.order, leg, period)
    return Answer(answer.order[begin:end], True)


def is_hopeless(leg_s: Floats, period_s: Floats, *, most_states: int) -> bool:
    """Whether it is proved that no robot can come to all places for ever in time; legs and periods as above.

    Legs are rounded down and periods up. Legs need not keep the triangle inequality: a robot passes the places in some
    order whatever they are, and takes no less time between two that follow each other. No leg may be shorter than a
    tick, else nothing is proved.
    """
    tick_s = float(period_s.min()) / TICKS
    leg = np.floor(np.minimum(leg_s, 2 * period_s.max()) / tick_s).astype(np.int64)
    period = np.ceil(SURELY * period_s / tick_s).astype(np.int64)
    if (leg + np.eye(len(leg), dtype=np.int64) < 1).any():
        return False
    answer = _search(leg, period, most_states)
    return answer.is_settled and answer.order is None


def is_surely_too_much(leg_s: Floats, period_s: Floats) -> bool:
    """Whether the legs alone take more time than there is: each visit takes its place's shortest leg, at least.

    Half of the leg to a place and half of the leg from it are no less. Visits come at least once in a period.
    """
    shortest_s = np.where(np.eye(len(leg_s), dtype=bool), np.inf, leg_s).min(axis=1)
    return len(leg_s) > 1 and bool((shortest_s / period_s).sum() > SURELY)


def _search(leg: Ints, period: Ints, most_states: int) -> Answer:
    """The search in one order of ways, then in another where that leaves the question open."""
    if len(period) == 1:
        return Answer(np.zeros(1, dtype=np.int64), True)
    longest_way = 2000  # visits before the search is given up
    most = np.array([most_states, longest_way, DEAD_KEPT])
    for by_age in (True, False):
        found = np.zeros(longest_way, dtype=np.int64)
        outcome, length = round_for_ever(leg, period, by_age, most, found)
        if outcome == Outcome.FOUND:
            return Answer(found[:length], True)
        if outcome == Outcome.NONE:
            return Answer(None, True)
    return Answer(None, False)


def stretch_of(order: Ints, leg_s: Floats, period_s: Floats) -> tuple[float, float]:
    """The time of a round (m,), and by how much it may be stretched until some place is late; inf for one place."""
    if len(order) == 1:
        return 0.0, np.inf
    steps_s = leg_s[order, np.roll(order, -1)]
    clock_s, round_s = np.concatenate([[0.0], np.cumsum(steps_s)[:-1]]), float(steps_s.sum())
    stretch = np.inf
    for place in np.unique(order):
        times_s = clock_s[order == place]
        gaps_s = np.diff(np.append(times_s, times_s[0] + round_s))
        stretch = min(stretch, float(period_s[place] / gaps_s.max()))
    return round_s, stretch
