"""Rounds of equal time of several robots that share places, each place in time: a search of states of them all.

A state (2 m + n,) of m robots and n places holds of each robot where it goes and how long until it is there, then of
each place the time that is left until a robot must be there. A robot that arrives goes on at once. From a state with
robots no later, on their ways to the same places, and no less time left for any place, all can be done that can be done
from another one: as with one robot (``deadline_kernels``) this tells rounds, since who is early can wait, and dead
states. Robots may begin anywhere: they come from a place n from which no way takes time.

What is found keeps all periods. That nothing is found proves nothing, since robots that wait on their way are left out.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rota.compiled.kernel import kernel
from rota.planners.patrol.cycles.deadline_kernels import insert_by_worth


@kernel
def is_no_better(state: Any, other: Any, robots: int) -> bool:
    """Whether all that can be done from a state can be done from the other one."""
    for r in range(robots):
        if state[r] != other[r] or state[robots + r] < other[robots + r]:
            return False
    for k in range(2 * robots, state.shape[0]):  # noqa: SIM110 (a compiled loop)
        if state[k] > other[k]:
            return False
    return True


@kernel
def who_arrives(state: Any, robots: int) -> int:
    """The first robot that is where it went."""
    for r in range(robots):
        if state[robots + r] == 0:
            return r
    return 0


@kernel
def lay_out_next(state: Any, robots: int, leg: Any, period: Any, order: Any) -> int:
    """Write where the robot that has arrived may go into order, places that are near and old first; their number.

    Where others go to already comes last.
    """
    n, count, who = period.shape[0], 0, who_arrives(state, robots)
    here = state[who]
    worth = np.empty(n)
    for j in range(n):
        if j == here:
            continue
        worth[j] = leg[here, j] - 0.5 * (period[j] - state[2 * robots + j])
        for r in range(robots):
            if r != who and state[r] == j:
                worth[j] += period[j]
        insert_by_worth(j, worth, order, count)
        count += 1
    return count


@kernel
def go_until_next_arrival(state: Any, robots: int, to: int, leg: Any, period: Any) -> int:
    """Send the robot that has arrived to a place and let time pass; that time, or -1 where some place is late then."""
    n, who = period.shape[0], who_arrives(state, robots)
    state[robots + who], state[who] = leg[state[who], to], to
    spent = state[robots : 2 * robots].min()
    for k in range(n):
        state[2 * robots + k] -= spent
        if state[2 * robots + k] < 0:
            return -1
    for r in range(robots):
        state[robots + r] -= spent
        if state[robots + r] == 0 and spent > 0:
            state[2 * robots + state[r]] = period[state[r]]
    for k in range(n):
        soonest = state[2 * robots + k] + 1
        for r in range(robots):
            soonest = min(soonest, state[robots + r] + (leg[state[r], k] if state[r] != k else 0))
        if soonest > state[2 * robots + k]:
            return -1
    return int(spent)


@kernel
def rounds_in_step(leg: Any, period: Any, robots: int, most: Any, arrivals: Any) -> tuple[int, int]:
    """How many arrivals (robot, place, time) a round of all robots has, and its time; 0 where none was found.

    leg (n + 1, n): times between places, and 0 from anywhere in the last row. period (n,). most (3,): states that are
    looked at, arrivals that a way may have, and dead states kept. arrivals (k, 3): for what is found, k at least
    robots times most[1].
    """
    n, deepest = period.shape[0], most[1]
    states, clock = np.zeros((deepest + 1, 2 * robots + n), np.int64), np.zeros(deepest + 1, np.int64)
    order, turn, count = np.zeros((deepest + 1, n), np.int64), np.zeros(deepest, np.int64), np.zeros(deepest, np.int64)
    dead, dead_count = np.zeros((most[2], 2 * robots + n), np.int64), 0
    states[0, :robots], states[0, 2 * robots :] = n, period
    count[0] = lay_out_next(states[0], robots, leg, period, order[0])
    depth, looked_at = 0, 0
    while depth >= 0 and looked_at < most[0]:
        if turn[depth] == count[depth]:
            dead[dead_count % most[2]] = states[depth]
            dead_count += 1
            depth -= 1
            continue
        states[depth + 1] = states[depth]
        spent = go_until_next_arrival(states[depth + 1], robots, order[depth, turn[depth]], leg, period)
        turn[depth] += 1
        looked_at += 1
        if spent < 0 or is_known_dead(states[depth + 1], dead, dead_count, robots):
            continue
        depth += 1
        clock[depth] = clock[depth - 1] + spent
        for begin in range(depth - 1, -1, -1):
            if is_no_better(states[begin], states[depth], robots):
                found = write_arrivals(states[begin : depth + 1], clock[begin : depth + 1], robots, arrivals)
                return found, clock[depth] - clock[begin]
        if depth == deepest:
            return 0, 0
        count[depth], turn[depth] = lay_out_next(states[depth], robots, leg, period, order[depth]), 0
    return 0, 0


@kernel
def is_known_dead(state: Any, dead: Any, count: int, robots: int) -> bool:
    """Whether a state is no better than some dead one; count: of all that were ever found."""
    for d in range(min(count, dead.shape[0])):  # noqa: SIM110 (a compiled loop)
        if is_no_better(state, dead[d], robots):
            return True
    return False


@kernel
def write_arrivals(states: Any, clock: Any, robots: int, arrivals: Any) -> int:
    """Write who arrives where, and when after the first of these states, into arrivals; their number."""
    count = 0
    for k in range(1, states.shape[0]):
        for r in range(robots):
            if states[k, robots + r] == 0 and clock[k] > clock[k - 1]:
                arrivals[count, 0], arrivals[count, 1], arrivals[count, 2] = r, states[k, r], clock[k] - clock[0]
                count += 1
    return count
