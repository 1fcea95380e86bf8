"""How long a way past places is, at least: a convex program, and what its dual proves.

The shortest way past convex places D_i is min sum |x_{i+1} - x_i| over x_i in D_i. For any vectors |y_i| <= 1, with
y_0 = y_m = 0, it is at least the sum over i of the minimum over D_i of (y_{i-1} - y_i) . x, which has a closed form. So
iterations that end too soon only make what is proved less. The vectors are the directions of the legs of a way that is
made shorter step by step: each place's point becomes the one nearest to a weighted mean of its neighbours.

Source. The weights: E. Weiszfeld, "Sur le point pour lequel la somme des distances de n points donnes est minimum",
Tohoku Mathematical Journal 43, 1937.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from rota.compiled.kernel import allocation_free, kernel

LONGEST = 32  # tasks of one robot: a longer order ends the search


class Tasks(NamedTuple):
    """Tasks (n,) and their places (p,), all in metres.

    place: (n,) the number of each task's place. opens_m, closes_m: (n,) when it is to be done. centre_m: (p, 2),
    radius_m: (p,) of the disc; where corners (p,) is not 0, the place is the convex polygon with so many corner_m
    (p, c, 2), anticlockwise. apart_m: (p, p) ways between two places at least; 0 where nothing is known.
    """

    place: Any
    opens_m: Any
    closes_m: Any
    centre_m: Any
    radius_m: Any
    corners: Any
    corner_m: Any
    apart_m: Any


@allocation_free
def move_into(place: int, x: float, y: float, tasks: Any, at: Any) -> None:
    """Write the point of the place that is nearest to (x, y) into at (2,)."""
    at[0], at[1] = x, y
    corners = tasks.corners[place]
    if corners == 0:
        dx, dy = x - tasks.centre_m[place, 0], y - tasks.centre_m[place, 1]
        away = math.sqrt(dx * dx + dy * dy)
        if away > tasks.radius_m[place]:
            share = tasks.radius_m[place] / away
            at[0], at[1] = tasks.centre_m[place, 0] + dx * share, tasks.centre_m[place, 1] + dy * share
        return
    nearest = np.inf
    for k in range(corners):
        from_x, from_y = tasks.corner_m[place, k]
        to_x, to_y = tasks.corner_m[place, k + 1 if k + 1 < corners else 0]
        along_x, along_y, dx, dy = to_x - from_x, to_y - from_y, x - from_x, y - from_y
        if along_x * dy - along_y * dx >= 0:
            continue
        square = along_x * along_x + along_y * along_y
        share = min(1.0, max(0.0, (dx * along_x + dy * along_y) / square)) if square > 0 else 0.0
        near_x, near_y = from_x + share * along_x, from_y + share * along_y
        away = (x - near_x) * (x - near_x) + (y - near_y) * (y - near_y)
        if away < nearest:
            nearest = away
            at[0], at[1] = near_x, near_y


@allocation_free
def least_along(place: int, x: float, y: float, tasks: Any) -> float:
    """The least scalar product of (x, y) with a point of the place."""
    if tasks.corners[place] == 0:
        middle = x * tasks.centre_m[place, 0] + y * tasks.centre_m[place, 1]
        return float(middle - math.sqrt(x * x + y * y) * tasks.radius_m[place])
    least = np.inf
    for k in range(tasks.corners[place]):
        least = min(least, x * tasks.corner_m[place, k, 0] + y * tasks.corner_m[place, k, 1])
    return least


@allocation_free
def proved_length(order: Any, xy: Any, weight: Any, first: int, last: int, tasks: Any) -> float:
    """What the dual program proves of the way past the tasks order[first : last + 1], by its legs' directions.

    Legs without weight count as long as the two places are apart.
    """
    proved, before_x, before_y = 0.0, 0.0, 0.0
    for i in range(first, last + 1):
        along_x, along_y, place = 0.0, 0.0, tasks.place[order[i]]
        if i < last and weight[i] > 0:
            along_x, along_y = weight[i] * (xy[i + 1, 0] - xy[i, 0]), weight[i] * (xy[i + 1, 1] - xy[i, 1])
        elif i < last:
            proved += tasks.apart_m[place, tasks.place[order[i + 1]]]
        proved += least_along(place, before_x - along_x, before_y - along_y, tasks)
        before_x, before_y = along_x, along_y
    return proved


@kernel
def is_longer(order: Any, xy: Any, first: int, last: int, limit_m: float, tasks: Any) -> bool:
    """Whether every way past the tasks order[first : last + 1] is surely longer than the limit; xy (m, 2) moves.

    A leg that walls make longer than it is now counts as long as its two places are apart, and pulls no more, once
    nothing else is left to prove it by.
    """
    weight, fixed = np.empty(LONGEST), np.zeros(LONGEST)
    blur = 0.02 * tasks.radius_m[tasks.place[order[first]]] + 1e-9  # points nearer to each other pull no harder
    for step in range(80):  # later ones prove next to nothing more
        length, most, round_walls = 0.0, 0.0, -1
        for i in range(first, last):
            leg = math.sqrt((xy[i + 1, 0] - xy[i, 0]) ** 2 + (xy[i + 1, 1] - xy[i, 1]) ** 2)
            if fixed[i] > 0:
                length += fixed[i]
                weight[i] = 0.0
                continue
            length += leg
            weight[i] = 1 / math.sqrt(leg * leg + blur * blur)
            more = tasks.apart_m[tasks.place[order[i]], tasks.place[order[i + 1]]] - leg
            if more > most:
                most, round_walls = more, i
        if length <= limit_m and round_walls < 0:
            return False
        if length <= limit_m:
            fixed[round_walls] = tasks.apart_m[tasks.place[order[round_walls]], tasks.place[order[round_walls + 1]]]
            weight[round_walls] = 0.0
        elif step % 4 == 0 and proved_length(order, xy, weight, first, last, tasks) > limit_m:
            return True
        for turn in range(2 * (last - first + 1)):
            i = first + turn if turn <= last - first else last - (turn - (last - first + 1))
            x, y, pull = 0.0, 0.0, 0.0
            if i > first:
                x, y, pull = weight[i - 1] * xy[i - 1, 0], weight[i - 1] * xy[i - 1, 1], weight[i - 1]
            if i < last:
                x, y, pull = x + weight[i] * xy[i + 1, 0], y + weight[i] * xy[i + 1, 1], pull + weight[i]
            if pull > 0:
                move_into(tasks.place[order[i]], x / pull, y / pull, tasks, xy[i])
    return False
