# mypy: disable-error-code="no-any-return"
"""Compiled loops of the bounce planner: one step of a team, successor maps, and cycles and basins of such maps.

A robot's state is ``cell * headings + heading``; a team's packed state is the sum of ``state_i * states ** i``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.compiled.kernel import allocation_free, always_inline
from rota.planners.bounce.arrays import Floats, Ints


class Team(NamedTuple):
    """Robots on cells, as compiled loops read them.

    For each of s states, (s,) int32: column and row of the cell, those of the cell that the move ends in (the same
    where it is blocked), the state after the move (BLOCKED where it is) and, for each robot, (m, s), the state after a
    bump. apart2: (m, m) float64, squared distance in cells below which two bodies touch; 0: the grid alone decides.
    """

    x: Ints
    y: Ints
    to_x: Ints
    to_y: Ints
    moved: Ints
    bumped: Ints
    apart2: Floats


@always_inline
def too_near(ax: int, ay: int, bx: int, by: int, apart2: float) -> bool:
    """Whether two robots cannot stand in these cells at once."""
    dx, dy = bx - ax, by - ay
    return (dx == 0 and dy == 0) or dx * dx + dy * dy < apart2 - 1e-9


@always_inline
def touching(a: tuple[int, int, int, int], b: tuple[int, int, int, int], apart2: float) -> bool:
    """Whether two robots come in contact that move in one step as a and b say: from column, row to column, row.

    Published grid (Alam & Bobadilla 2020, Figure 2b, as read): same target cell, or moves with equal midpoints. With
    apart2 > 0 besides: centres come nearer to each other than that (squared, in cells).
    """
    ax, ay, au, av = a
    bx, by, bu, bv = b
    if au == bu and av == bv:
        return True
    if ax + au == bx + bu and ay + av == by + bv:
        return True
    if apart2 <= 0.0:
        return False
    dx, dy = bx - ax, by - ay
    wx, wy = (bu - bx) - (au - ax), (bv - by) - (av - ay)
    along = -(dx * wx + dy * wy)
    squared = wx * wx + wy * wy
    if along <= 0 or squared == 0:
        nearest = float(dx * dx + dy * dy)
    elif along >= squared:
        nearest = float((dx + wx) * (dx + wx) + (dy + wy) * (dy + wy))
    else:
        cross = dx * wy - dy * wx
        nearest = cross * cross / squared
    return nearest < apart2 - 1e-9


@allocation_free
def step_team(team: Team, states: Ints, stays: NDArray[np.int8], after: Ints) -> int:
    """One step of m robots; returns how many pairs come in contact.

    states: (m,) before; after: (m,), written. stays: (m,) scratch. What a wall blocks stays and turns; what comes in
    contact stays and turns; all contacts of a round are found before any robot is stopped for them, and rounds are
    repeated until none is new, so that the outcome does not depend on the robots' order.
    """
    m = len(states)
    for i in range(m):
        s = states[i]
        stays[i] = 1 if team.moved[s] < 0 else 0
    contacts = 0
    while True:
        fresh = False
        for i in range(m):
            a = states[i]
            au, av = (team.x[a], team.y[a]) if stays[i] & 1 else (team.to_x[a], team.to_y[a])
            for j in range(i + 1, m):
                if stays[i] & 1 and stays[j] & 1:
                    continue
                b = states[j]
                bu, bv = (team.x[b], team.y[b]) if stays[j] & 1 else (team.to_x[b], team.to_y[b])
                move, other = (team.x[a], team.y[a], au, av), (team.x[b], team.y[b], bu, bv)
                if touching(move, other, team.apart2[i, j]):
                    stays[i] |= 2
                    stays[j] |= 2
                    contacts += 1
                    fresh = True
        if not fresh:
            break
        for i in range(m):
            if stays[i] & 2:
                stays[i] = 1
    for i in range(m):
        s = states[i]
        after[i] = team.bumped[i, s] if stays[i] else team.moved[s]
    return contacts


@always_inline
def pair_touches(team: Team, a: int, b: int, apart2: float) -> bool:
    """Whether robots in two states come in contact in the next step, with nothing but walls to stop them."""
    move = (team.x[a], team.y[a], team.to_x[a], team.to_y[a])
    other = (team.x[b], team.y[b], team.to_x[b], team.to_y[b])
    return touching(move, other, apart2)
