"""Whether so many robots can do tasks in time: branch and bound over who does what in which order.

A task is to be in a disc, or in a convex polygon, at some time between two. Times count as metres at full speed. A
state is an order of some of the tasks for each robot. The next task is the one with the fewest places in these orders,
out of those that the robots' shortest ways, where they now lead, miss by most. ``length_kernels`` proves how long the
ways are.

Source. Branch and bound that puts discs into an order one by one: W. P. Coutinho, R. Q. do Nascimento, A. A. Pessoa
and A. Subramanian, "A Branch-and-Bound Algorithm for the Close-Enough Traveling Salesman Problem", INFORMS Journal on
Computing 28, 2016.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from rota.compiled.kernel import allocation_free, kernel
from rota.planners.patrol.bounds.length_kernels import LONGEST, is_longer, move_into
from rota.planners.patrol.cycles.deadline_kernels import Outcome

DEEPEST = 64  # tasks of all robots


class Orders(NamedTuple):
    """Who does what: for each robot the number of its tasks, count (k,), and these, task (k, m), at xy_m (k, m, 2)."""

    count: Any
    task: Any
    xy_m: Any


@allocation_free
def write_orders(orders: Any, onto: Any) -> int:
    """Write the orders into others of the same shape; the most tasks that a robot has."""
    longest = 0
    for robot in range(orders.count.shape[0]):
        count = orders.count[robot]
        onto.count[robot], longest = count, max(longest, count)
        for i in range(count):
            onto.task[robot, i] = orders.task[robot, i]
            onto.xy_m[robot, i, 0], onto.xy_m[robot, i, 1] = orders.xy_m[robot, i, 0], orders.xy_m[robot, i, 1]
    return longest


@allocation_free
def insert(orders: Any, robot: int, task: int, at: int, order: Any, xy: Any, tasks: Any) -> int:
    """Write the robot's tasks with one more at a place in their order into order (m,) and xy (m, 2); how many."""
    count = orders.count[robot]
    for i in range(count):
        k = i if i < at else i + 1
        order[k], xy[k, 0], xy[k, 1] = orders.task[robot, i], orders.xy_m[robot, i, 0], orders.xy_m[robot, i, 1]
    order[at] = task
    place = tasks.place[task]
    x, y, beside = 0.0, 0.0, 0
    if at > 0:
        x, y, beside = xy[at - 1, 0], xy[at - 1, 1], 1
    if at < count:
        x, y, beside = x + xy[at + 1, 0], y + xy[at + 1, 1], beside + 1
    if beside:
        move_into(place, x / beside, y / beside, tasks, xy[at])
    else:
        xy[at, 0], xy[at, 1] = tasks.centre_m[place, 0], tasks.centre_m[place, 1]
    return int(count + 1)


@kernel
def can_be_in_time(order: Any, xy: Any, count: int, at: int, tasks: Any) -> bool:
    """Whether nothing proves that the tasks order[:count], of which that at ``at`` is new, take too long.

    The tasks from first to last must be done between the opening of the first and the closing of the last. Longer parts
    that have no more time are looked at in place of shorter ones.
    """
    opens, closes, place = tasks.opens_m, tasks.closes_m, tasks.place
    for i in range(count):
        first, last = min(i, at), max(i, at)
        if i != at and tasks.apart_m[place[order[i]], place[order[at]]] > closes[order[last]] - opens[order[first]]:
            return False
    for first in range(at + 1):
        for last in range(count - 1, at - 1, -1):
            limit = closes[order[last]] - opens[order[first]]
            if limit < 0:
                return False
            if first == last or (first > 0 and closes[order[last]] - opens[order[first - 1]] <= limit):
                continue
            if last + 1 < count and closes[order[last + 1]] - opens[order[first]] <= limit:
                continue
            along = 0.0
            for i in range(first, last):
                along += tasks.apart_m[place[order[i]], place[order[i + 1]]]
            some = xy if last - first == count - 1 else xy.copy()
            if along > limit or is_longer(order, some, first, last, limit, tasks):
                return False
    return True


@allocation_free
def least_miss(task: int, known: float, xy: Any, count: int, early: Any, late: Any, tasks: Any, near: Any) -> float:
    """By how many metres a robot that does its tasks on the way xy misses one more, at least; its time counts half.

    known: others miss it by no more. early, late: (m,) when it can be at each of its tasks. near: (2,), written.
    """
    place, opens, closes = tasks.place[task], tasks.opens_m[task], tasks.closes_m[task]
    x, y, radius = tasks.centre_m[place, 0], tasks.centre_m[place, 1], tasks.radius_m[place]
    least, around = known, 1.1 * radius  # corners of convex places are a little farther from the centre
    for i in range(max(1, count - 1) if known > 0 else 0):
        at_x, at_y, begins, ends = xy[i, 0], xy[i, 1], -np.inf, np.inf
        if count > 1:
            along_x, along_y = xy[i + 1, 0] - at_x, xy[i + 1, 1] - at_y
            square = along_x * along_x + along_y * along_y
            share = ((x - at_x) * along_x + (y - at_y) * along_y) / square if square > 0 else 0.0
            share = min(1.0, max(0.0, share))
            at_x, at_y = at_x + share * along_x, at_y + share * along_y
            if (x - at_x) ** 2 + (y - at_y) ** 2 >= (least + around) ** 2:
                continue
            if i > 0 or share > 0:
                begins = early[i] + share * math.sqrt(square)
            if i < count - 2 or share < 1:
                ends = late[i + 1] - (1 - share) * math.sqrt(square)
            if begins > ends:
                begins = ends = (begins + ends) / 2
        if tasks.corners[place]:
            move_into(place, at_x, at_y, tasks, near)
            away = math.hypot(near[0] - at_x, near[1] - at_y)
        else:
            away = math.hypot(x - at_x, y - at_y) - radius
        wait = max(0.0, opens - ends, begins - closes)
        least = min(least, max(0.0, away) + 0.5 * wait)
    return least


@kernel
def weigh_tasks(orders: Any, tasks: Any, missed: Any) -> None:
    """Write by how much each task is missed by all robots that have tasks into missed (n,)."""
    early, late, near = np.empty(LONGEST), np.empty(LONGEST), np.empty(2)
    missed[:] = np.inf
    for robot in range(orders.count.shape[0]):
        count, order, xy = orders.count[robot], orders.task[robot], orders.xy_m[robot]
        if count == 0:
            continue
        early[0], late[count - 1] = tasks.opens_m[order[0]], tasks.closes_m[order[count - 1]]
        for i in range(1, count):
            leg = math.hypot(xy[i, 0] - xy[i - 1, 0], xy[i, 1] - xy[i - 1, 1])
            early[i] = max(tasks.opens_m[order[i]], early[i - 1] + leg)
        for i in range(count - 2, -1, -1):
            leg = math.hypot(xy[i + 1, 0] - xy[i, 0], xy[i + 1, 1] - xy[i, 1])
            late[i] = min(tasks.closes_m[order[i]], late[i + 1] - leg)
        for task in range(missed.shape[0]):
            missed[task] = least_miss(task, missed[task], xy, count, early, late, tasks, near)


@kernel
def lay_out_ways(orders: Any, task: int, order: Any, xy: Any, ways: Any, tasks: Any) -> int:
    """Write (robot, place in its order, task) for all places a task can be put in, the shortest first; how many.

    Of robots without tasks one stands for all.
    """
    count = 0
    cost = np.empty(ways.shape[0])
    has_begun = False
    for robot in range(orders.count.shape[0]):
        if orders.count[robot] == 0 and has_begun:
            continue
        has_begun = has_begun or orders.count[robot] == 0
        for at in range(orders.count[robot] + 1):
            more = insert(orders, robot, task, at, order, xy, tasks)
            if not can_be_in_time(order, xy, more, at, tasks):
                continue
            length = 0.0
            for i in range(more - 1):
                length += math.hypot(xy[i + 1, 0] - xy[i, 0], xy[i + 1, 1] - xy[i, 1])
            for i in range(more - 2):
                before = orders.xy_m[robot]
                length -= math.hypot(before[i + 1, 0] - before[i, 0], before[i + 1, 1] - before[i, 1])
            k = count
            while k > 0 and cost[k - 1] > length:
                cost[k] = cost[k - 1]
                ways[k, 0], ways[k, 1], ways[k, 2] = ways[k - 1, 0], ways[k - 1, 1], ways[k - 1, 2]
                k -= 1
            cost[k], ways[k, 0], ways[k, 1], ways[k, 2] = length, robot, at, task
            count += 1
    return count


@kernel
def branch(orders: Any, begin_with: int, tasks: Any, missed: Any, ways: Any) -> int:
    """Choose the next task and write its ways, as ``lay_out_ways`` does; how many, or -1 where no task is missed.

    The tasks from ``begin_with`` on come first, whether they are missed or not.
    """
    order, xy, some = np.zeros(LONGEST, np.int64), np.zeros((LONGEST, 2)), np.zeros(ways.shape, np.int64)
    done = 0
    for robot in range(orders.count.shape[0]):
        done += orders.count[robot]
    if begin_with + done < missed.shape[0]:
        return int(lay_out_ways(orders, begin_with + done, order, xy, ways, tasks))
    weigh_tasks(orders, tasks, missed)
    fewest = -1
    for _ in range(4):  # of so many the one with the fewest places in the orders comes next
        task = int(np.argmax(missed))
        if missed[task] <= 1e-9:
            break
        here = tasks.place[task]
        for other in range(missed.shape[0]):  # others near it, to be done at the same time, would tell the same
            there = tasks.place[other]
            x = tasks.centre_m[here, 0] - tasks.centre_m[there, 0]
            y = tasks.centre_m[here, 1] - tasks.centre_m[there, 1]
            if tasks.opens_m[other] == tasks.opens_m[task] and math.hypot(x, y) < 0.7 * tasks.radius_m[here]:
                missed[other] = 0.0
        count = lay_out_ways(orders, task, order, xy, some, tasks)
        if fewest < 0 or count < fewest:
            fewest = count
            for k in range(count):
                ways[k, 0], ways[k, 1], ways[k, 2] = some[k, 0], some[k, 1], some[k, 2]
        if count < 2:
            break
    return fewest


@kernel
def search_orders(robots: int, begin_with: int, tasks: Any, most_states: int) -> int:
    """NONE where surely no orders of so many robots do all tasks in time.

    FOUND where orders were found that miss none, by what is known here; OPEN after most_states. Tasks begin_with to
    the last come first.
    """
    count = np.zeros((DEEPEST, robots), np.int64)
    order, xy = np.zeros((DEEPEST, robots, LONGEST), np.int64), np.zeros((DEEPEST, robots, LONGEST, 2))
    ways, left = np.zeros((DEEPEST, robots * LONGEST, 3), np.int64), np.zeros((DEEPEST, 2), np.int64)
    missed = np.zeros(tasks.place.shape[0])
    place = tasks.place[begin_with]
    count[0, 0], order[0, 0, 0] = 1, begin_with
    xy[0, 0, 0, 0], xy[0, 0, 0, 1] = tasks.centre_m[place, 0], tasks.centre_m[place, 1]
    depth, longest = 0, 1
    for _ in range(most_states):
        orders = Orders(count[depth], order[depth], xy[depth])
        if depth == DEEPEST - 1 or longest == LONGEST - 1:
            return Outcome.OPEN
        found = branch(orders, begin_with, tasks, missed, ways[depth])
        if found < 0:
            return Outcome.FOUND
        left[depth, 0], left[depth, 1] = 0, found
        while left[depth, 0] == left[depth, 1]:
            if depth == 0:
                return Outcome.NONE
            depth -= 1
        robot, at, task = ways[depth, left[depth, 0]]
        left[depth, 0] += 1
        orders = Orders(count[depth], order[depth], xy[depth])
        longest = write_orders(orders, Orders(count[depth + 1], order[depth + 1], xy[depth + 1]))
        more = insert(orders, robot, task, at, order[depth + 1, robot], xy[depth + 1, robot], tasks)
        can_be_in_time(order[depth + 1, robot], xy[depth + 1, robot], more, at, tasks)
        count[depth + 1, robot], longest = more, max(longest, more)
        depth += 1
    return Outcome.OPEN
