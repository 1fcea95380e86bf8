"""Whether one robot can come to all of some places for ever, each again before its deadline: a search of states.

A state is the place where the robot is, and for each place the time that is left until it must be there again. The
robot goes on at once: who waits has less time left for all others. From a state with as much time left for every place
as another one at the same place, all can be done that can be done from there. So

- a way that leads back to a place with no less time left for any place than before can be gone round for ever;
- a state from which every way ends late is *dead*, and so is one with no more time left for any place than a dead one.

Times are whole numbers, so that there are finitely many states: the search ends, with a round or with none. It begins
where the deadline is shortest, with all deadlines full: from no state can more be done, and every endless way comes by.

Source. The states are those of the problem's membership in PSPACE: H.-M. Ho and J. Ouaknine, "The Cyclic-Routing UAV
Problem is PSPACE-Complete", FoSSaCS 2015; what dead states are good for is new here.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from rota.compiled.kernel import kernel


class _Outcome(NamedTuple):
    """What a search of all ways came to; ``OPEN`` where it was given up."""

    FOUND: int = 1
    NONE: int = 0
    OPEN: int = -1


Outcome = _Outcome()


@kernel
def ends_late(at: int, left: Any, leg: Any) -> bool:
    """Whether some place, or one of two, is surely reached late from here; left (n,) is the time that each has."""
    n = left.shape[0]
    for j in range(n):
        if leg[at, j] > left[j]:
            return True
    for j in range(n):
        if j == at:
            continue
        for k in range(j):
            late_k = leg[at, j] + leg[j, k] > left[k]
            late_j = leg[at, k] + leg[k, j] > left[j]
            if k != at and late_j and late_k:
                return True
    return False


@kernel
def insert_by_worth(place: int, worth: Any, order: Any, count: int) -> None:
    """Put a place among the first count of order (n,), which stand by what they are worth, the least first."""
    k = count
    while k > 0 and worth[order[k - 1]] > worth[place]:
        order[k] = order[k - 1]
        k -= 1
    order[k] = place


@kernel
def lay_out_ways(at: int, left: Any, leg: Any, period: Any, by_age: bool, order: Any) -> None:
    """Write all other places into order (n - 1,): those first that have least time left, or are near and old."""
    n, count = left.shape[0], 0
    worth = np.empty(n)
    for j in range(n):
        if j == at:
            continue
        worth[j] = leg[at, j] - 0.5 * (period[j] - left[j]) if by_age else float(left[j] - leg[at, j])
        insert_by_worth(j, worth, order, count)
        count += 1


@kernel
def has_no_more(left: Any, other: Any) -> bool:
    """Whether no place has more time left than in the other state."""
    for k in range(left.shape[0]):  # noqa: SIM110 (a compiled loop)
        if left[k] > other[k]:
            return False
    return True


@kernel
def is_dead(left: Any, dead: Any, count: int) -> bool:
    """Whether some dead state at the same place has as much time left for every place; count: of all ever found."""
    for d in range(min(count, dead.shape[0])):  # noqa: SIM110 (a compiled loop)
        if has_no_more(left, dead[d]):
            return True
    return False


@kernel
def begins_round(at: Any, left: Any, depth: int) -> int:
    """The latest state before the last one, at the same place and with no more time left for any; -1: there is none."""
    for d in range(depth - 1, -1, -1):
        if at[d] == at[depth] and has_no_more(left[d], left[depth]):
            return d
    return -1


@kernel
def go_on(at: Any, left: Any, depth: int, to: int, leg: Any, period: Any) -> bool:
    """Write the state after going to a place below the one at ``depth``; False where some place is late by then."""
    spent = leg[at[depth], to]
    at[depth + 1] = to
    for k in range(period.shape[0]):
        left[depth + 1, k] = left[depth, k] - spent
        if left[depth + 1, k] < 0:
            return False
    left[depth + 1, to] = period[to]
    return not ends_late(to, left[depth + 1], leg)


@kernel
def round_for_ever(leg: Any, period: Any, by_age: bool, most: Any, found: Any) -> tuple[int, int]:
    """FOUND with the length of the round whose places stand in ``found``, NONE, or OPEN where the search was given up.

    leg (n, n): times between places, at least 1 off the diagonal and 0 on it. period (n,): the deadlines. n is 2 or
    more. by_age: in which order ways are tried. most (3,): states that are looked at, places that a way may have, and
    dead states kept for each place. found (most[1],).
    """
    n, deepest = period.shape[0], most[1]
    at, left = np.zeros(deepest + 1, np.int64), np.zeros((deepest + 1, n), np.int64)
    order, turn = np.zeros((deepest + 1, n), np.int64), np.zeros(deepest + 1, np.int64)
    dead, dead_count = np.zeros((n, most[2], n), np.int64), np.zeros(n, np.int64)
    at[0], left[0] = np.argmin(period), period
    lay_out_ways(at[0], left[0], leg, period, by_age, order[0])
    depth, looked_at = 0, 0
    while depth >= 0:
        here = at[depth]
        if turn[depth] == n - 1:
            dead[here, dead_count[here] % most[2]] = left[depth]
            dead_count[here] += 1
            depth -= 1
            continue
        to = order[depth, turn[depth]]
        turn[depth] += 1
        looked_at += 1
        if looked_at > most[0] or depth + 1 == deepest:
            return Outcome.OPEN, 0
        if not go_on(at, left, depth, to, leg, period) or is_dead(left[depth + 1], dead[to], dead_count[to]):
            continue
        depth += 1
        begin = begins_round(at, left, depth)
        if begin >= 0:
            found[: depth - begin] = at[begin:depth]
            return Outcome.FOUND, depth - begin
        lay_out_ways(to, left[depth], leg, period, by_age, order[depth])
        turn[depth] = 0
    return Outcome.NONE, 0


@kernel
def shortest_part(order: Any, leg: Any, period: Any) -> tuple[int, int]:
    """The part of a round, from one visit of a place to a later one, that does alone and takes least time.

    order (m,): a round that keeps all deadlines. Returns begin and end, 0 and m for all of it; a part never runs past
    the end of the order.
    """
    m, n = order.shape[0], period.shape[0]
    best_begin, best_end = 0, m
    best = 0
    for i in range(m):
        best += leg[order[i], order[(i + 1) % m]]
    last, first = np.empty(n, np.int64), np.empty(n, np.int64)
    for begin in range(m):
        last[:], first[:] = -1, -1
        clock = 0
        for i in range(begin, m):
            place = order[i]
            if i > begin and place == order[begin]:
                if clock >= best:
                    break
                if closes_in_time(first, last, period, clock):
                    best, best_begin, best_end = clock, begin, i
                    break
            if last[place] >= 0 and clock - last[place] > period[place]:
                break
            if first[place] < 0:
                first[place] = clock
            last[place] = clock
            clock += leg[place, order[(i + 1) % m]]
    return best_begin, best_end


@kernel
def closes_in_time(first: Any, last: Any, period: Any, round_time: int) -> bool:
    """Whether a round comes to every place, and from the last visit of each to its first one in time."""
    for k in range(period.shape[0]):  # noqa: SIM110 (a compiled loop)
        if first[k] < 0 or first[k] + round_time - last[k] > period[k]:
            return False
    return True
