# mypy: disable-error-code="no-any-return,return-value"
"""Compiled loops of Algorithm 1: joint trajectories that cover, and how much a turn by the clock would add to them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.compiled.kernel import allocation_free, always_inline
from rota.planners.bounce.arrays import Ints, Longs
from rota.planners.bounce.kernels import Team, step_team

Bytes = NDArray[np.uint8]


class Log(NamedTuple):
    """A joint trajectory and what is known of it.

    path: (most, m) states; contact: (most,) pairs in contact in the step to each; jump: (most,) the robot that turned
    by the clock, plus 1; 0: none. table: a power of 2 of places, the number of a state on the path plus 1; 0: empty.
    covered: (n,) cells that were entered. added: (n,), the cells in the order of their first visit.
    """

    path: Ints
    contact: Ints
    jump: Ints
    table: Longs
    covered: Bytes
    added: Ints


@always_inline
def place_of(log: Log, states: Ints) -> int:
    """The place of a joint state in the table: the place that holds it, or the empty place where it belongs."""
    value = np.uint64(0x9E3779B97F4A7C15)
    for i in range(len(states)):
        value = (value ^ np.uint64(states[i])) * np.uint64(0xFF51AFD7ED558CCD)
        value ^= value >> np.uint64(29)
    mask = len(log.table) - 1
    place = np.int64(value & np.uint64(mask))
    while log.table[place] != 0:
        entry = log.table[place] - 1
        same = True
        for i in range(len(states)):
            if log.path[entry, i] != states[i]:
                same = False
                break
        if same:
            break
        place = (place + 1) & mask
    return place


@allocation_free
def enter_cells(log: Log, states: Ints, headings: int, cells: int) -> int:
    """Cover the robots' cells; ``cells`` were covered before, and the number afterwards is returned."""
    for i in range(len(states)):
        c = states[i] // headings
        if log.covered[c] == 0:
            log.covered[c] = 1
            log.added[cells] = c
            cells += 1
    return cells


@allocation_free
def follow(
    team: Team, log: Log, headings: int, wanted: int, count: int, cells: int, scratch: Ints, stays: NDArray[np.int8]
) -> tuple[int, int, int]:
    """Go on from path[count - 1] until a joint state comes back, ``wanted`` cells are covered or the path is full.

    The state that comes back is on the path, and only once in the table. Returns the numbers of states and cells by
    then, and the contacts on the way.
    """
    m = len(scratch)
    contacts = 0
    while cells < wanted and count < len(log.path):
        now = log.path[count - 1]
        place = place_of(log, now)
        if log.table[place] != 0:
            break
        log.table[place] = count
        touched = step_team(team, now, stays, scratch)
        for i in range(m):
            log.path[count, i] = scratch[i]
        log.contact[count], log.jump[count] = touched, 0
        contacts += touched
        cells = enter_cells(log, scratch, headings, cells)
        count += 1
    return count, cells, contacts


@allocation_free
def forget(log: Log, count: int, to_count: int, cells: int, to_cells: int) -> None:
    """Undo what ``follow`` wrote since there were to_count states and to_cells cells."""
    for k in range(count - 1, to_count - 2, -1):
        place = place_of(log, log.path[k])
        # what came last is at the end of its run of places, so nothing behind it is lost
        if log.table[place] == k + 1:
            log.table[place] = 0
    for k in range(to_cells, cells):
        log.covered[log.added[k]] = 0


@allocation_free
def cover_as_printed(
    team: Team, log: Log, headings: int, wanted: int, scratch: Ints, stays: NDArray[np.int8]
) -> tuple[int, int]:
    """Algorithm 1 from path[0] on; returns how many states there are and how many cells are covered.

    A sequence is followed until a joint state comes back. Then each robot in turn is turned by one heading step either
    way. Of the new joint states that this gives, the one is taken whose sequence covers most cells in total, then has
    the fewest contacts, then is shortest. It ends when all is covered, or when no joint state is new.
    """
    m = len(scratch)
    cells = enter_cells(log, log.path[0], headings, 0)
    count, cells, _ = follow(team, log, headings, wanted, 1, cells, scratch, stays)
    while cells < wanted and count < len(log.path):
        best, best_cells, best_contacts, best_count = -1, 0, 0, 0
        for neighbour in range(2 * m):
            turn_robot(log, headings, count, neighbour)
            if log.table[place_of(log, log.path[count])] != 0:
                continue
            n, c, contacts = follow(team, log, headings, wanted, count + 1, cells, scratch, stays)
            forget(log, n, count + 1, c, cells)
            better = best < 0 or c > best_cells
            if not better and c == best_cells:
                better = contacts < best_contacts or (contacts == best_contacts and n < best_count)
            if better:
                best, best_cells, best_contacts, best_count = neighbour, c, contacts, n
        if best < 0:
            break
        turn_robot(log, headings, count, best)
        count, cells, _ = follow(team, log, headings, wanted, count + 1, cells, scratch, stays)
    return count, cells


@allocation_free
def turn_robot(log: Log, headings: int, count: int, neighbour: int) -> None:
    """Write the joint state after path[count - 1] in which robot neighbour // 2 has turned by a heading step."""
    for i in range(log.path.shape[1]):
        log.path[count, i] = log.path[count - 1, i]
    i = neighbour // 2
    cell, h = divmod(log.path[count - 1, i], headings)
    h = (h + (1 if neighbour % 2 == 0 else headings - 1)) % headings
    log.path[count, i] = cell * headings + h
    log.contact[count], log.jump[count] = 0, i + 1


class Search(NamedTuple):
    """Scratch of ``cover_by_rate``: (m,) states; stamps (n,) of cells; and of a search over the s states of one robot
    marks of those that it came to, distances, actions that led there, states before, and a queue.
    """

    begin: Ints
    states: Ints
    after: Ints
    stays: NDArray[np.int8]
    stamps: Longs
    marks: Longs
    distance: Ints
    action: Ints
    before: Ints
    queue: Ints


STEP, LEFT, RIGHT = 0, 1, 2


@allocation_free
def gain_of(
    team: Team, log: Log, headings: int, horizon: int, turns: int, stamp: int, search: Search
) -> tuple[int, int]:
    """The best rate of new cells for steps, as cells and steps to them, from search.begin within ``horizon`` steps.

    turns: steps needed to come to ``begin``. stamp: greater than all in search.stamps. (0, 0): no cell is new.
    """
    states, after = search.states, search.after
    m = len(states)
    for i in range(m):
        states[i] = search.begin[i]
    best_new, best_steps, new = 0, 0, 0
    for t in range(1, horizon + 1):
        step_team(team, states, search.stays, after)
        fresh = False
        for i in range(m):
            states[i] = after[i]
            c = after[i] // headings
            if log.covered[c] == 0 and search.stamps[c] != stamp:
                search.stamps[c] = stamp
                new += 1
                fresh = True
        if fresh and (best_new == 0 or new * (best_steps + turns) > best_new * (t + turns)):
            best_new, best_steps = new, t
    return best_new, best_steps


@allocation_free
def way_to_new_cell(team: Team, log: Log, headings: int, robot: int, stamp: int, search: Search) -> int:
    """The fewest steps and turns after which a robot that meets nobody enters a new cell; -1: it cannot.

    stamp: greater than all in search.marks. search.queue holds these actions afterwards, the last one first.
    """
    distance, queue, before, action = search.distance, search.queue, search.before, search.action
    start = search.states[robot]
    search.marks[start], distance[start], queue[0] = stamp, 0, start
    head, tail = 0, 1
    while head < tail:
        s = queue[head]
        head += 1
        if log.covered[s // headings] == 0:
            steps = distance[s]
            at = s
            for k in range(steps):
                queue[k] = action[at]
                at = before[at]
            return steps
        cell, h = divmod(s, headings)
        for a in range(3):
            if a == STEP:
                to = team.moved[s] if team.moved[s] >= 0 else team.bumped[robot, s]
            else:
                to = np.int32(cell * headings + (h + (1 if a == LEFT else headings - 1)) % headings)
            if search.marks[to] != stamp:
                search.marks[to] = stamp
                distance[to], action[to], before[to] = distance[s] + 1, a, s
                queue[tail] = to
                tail += 1
    return -1


@allocation_free
def go_to_new_cell(
    team: Team, log: Log, headings: int, robot: int, steps: int, count: int, cells: int, search: Search
) -> tuple[int, int]:
    """Do the actions in search.queue, all robots step by step, until one covers a new cell or a contact intervenes."""
    known = cells
    for k in range(steps - 1, -1, -1):
        if count == len(log.path):
            break
        if search.queue[k] == STEP:
            alone = log.path[count - 1, robot]
            alone = team.moved[alone] if team.moved[alone] >= 0 else team.bumped[robot, alone]
            log.contact[count] = step_team(team, log.path[count - 1], search.stays, log.path[count])
            log.jump[count] = 0
            cells = enter_cells(log, log.path[count], headings, cells)
            count += 1
            if cells > known or log.path[count - 1, robot] != alone:
                break
        else:
            turn_robot(log, headings, count, 2 * robot + search.queue[k] - LEFT)
            count += 1
    return count, cells


@allocation_free
def cover_by_rate(team: Team, log: Log, headings: int, wanted: int, horizon: int, search: Search) -> tuple[int, int]:
    """Cover from path[0] on, by turns whenever they pay; returns how many states and covered cells there are.

    Each time either all robots go on, or one of them first turns by one or more heading steps while the others wait.
    The choice that enters most new cells for a step within the horizon is taken, up to its best step. A robot's
    shortest way to a new cell, with turns on it, is taken instead where its rate is better still.
    """
    m = len(search.begin)
    cells = enter_cells(log, log.path[0], headings, 0)
    count, stamp = 1, 0
    while cells < wanted and count < len(log.path):
        best_new, best_all, best_steps, best_robot, best_turn = 0, 1, 0, 0, 0
        for robot in range(m):
            for turn in range(-(headings // 2) + 1, headings // 2 + 1):
                if turn == 0 and robot > 0:
                    continue
                for i in range(m):
                    search.begin[i] = log.path[count - 1, i]
                cell, h = divmod(search.begin[robot], headings)
                search.begin[robot] = cell * headings + (h + turn) % headings
                stamp += 1
                new, steps = gain_of(team, log, headings, horizon, abs(turn), stamp, search)
                spent = steps + abs(turn)
                if new > 0 and new * best_all > best_new * spent:
                    best_new, best_all, best_steps, best_robot, best_turn = new, spent, steps, robot, turn
        nearest, near_robot = -1, 0
        for robot in range(m):
            for i in range(m):
                search.states[i] = log.path[count - 1, i]
            stamp += 1
            steps = way_to_new_cell(team, log, headings, robot, stamp, search)
            if steps >= 0 and (nearest < 0 or steps < nearest):
                nearest, near_robot = steps, robot
        if nearest >= 0 and best_all > best_new * nearest:
            stamp += 1
            way_to_new_cell(team, log, headings, near_robot, stamp, search)
            count, cells = go_to_new_cell(team, log, headings, near_robot, nearest, count, cells, search)
            continue
        if best_new == 0:
            break
        for _ in range(abs(best_turn)):
            if count == len(log.path):
                break
            turn_robot(log, headings, count, 2 * best_robot + (1 if best_turn < 0 else 0))
            count += 1
        for _ in range(best_steps):
            if count == len(log.path):
                break
            log.contact[count] = step_team(team, log.path[count - 1], search.stays, log.path[count])
            log.jump[count] = 0
            cells = enter_cells(log, log.path[count], headings, cells)
            count += 1
    return count, cells
