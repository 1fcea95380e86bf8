"""What a corner of a tour costs a robot that takes time to turn, turns on arcs, or has mass (compiled)."""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import allocation_free
from rota.planners.patrol.annealing.state import Tours
from rota.planners.patrol.tolerances import STRAIGHT


@allocation_free
def from_table(table: Any, row: float, column: float) -> float:
    """The value between four entries of a table, each coordinate taken as linear."""
    i, j = min(int(row), table.shape[0] - 2), min(int(column), table.shape[1] - 2)
    p, q = row - i, column - j
    low = table[i, j] + q * (table[i, j + 1] - table[i, j])
    high = table[i + 1, j] + q * (table[i + 1, j + 1] - table[i + 1, j])
    return float(low + p * (high - low))


@allocation_free
def turning_m(ux: float, uy: float, vx: float, vy: float, turn_m: float, arc_m: float) -> float:
    """Turning from the leg u into the leg v, as metres of travel that take the same time.

    On arcs of radius arc_m, legs too short for the turn cost up to a full circle more: ``at_once.spool_m``.
    """
    if turn_m == 0:
        return 0.0
    turn = abs(math.atan2(ux * vy - uy * vx, ux * vx + uy * vy))
    total: float = turn_m * turn
    if arc_m > 0:
        need = 2 * arc_m * math.tan(min(turn, math.pi / 2) / 2)
        short = min(math.hypot(ux, uy), math.hypot(vx, vy))
        if short < need:
            total += 2 * math.pi * arc_m * (1 - short / need)
    return total


@allocation_free
def rounding_m(ux: float, uy: float, vx: float, vy: float, t: Tours) -> float:
    """What a corner between the legs u and v costs a robot with mass, in the same metres, from its table."""
    before, after, table = math.sqrt(ux * ux + uy * uy), math.sqrt(vx * vx + vy * vy), t.corners
    sine2 = (1 - (ux * vx + uy * vy) / (before * after)) / 2
    if sine2 < STRAIGHT * STRAIGHT:
        return float((before + after) / 2 * t.corner_leg_m[1])
    row, last = math.sqrt(min(1.0, sine2)) * (table.shape[0] - 1), table.shape[1] - 1
    longest = t.corner_leg_m[0]
    cost = from_table(table, row, last * math.sqrt(min(1.0, before / longest)))
    return float(cost + from_table(table, row, last * math.sqrt(min(1.0, after / longest))))


@allocation_free
def corner_m(ax: float, ay: float, bx: float, by: float, cx: float, cy: float, k: int, t: Tours) -> float:
    """What tour k loses at b on the way a-b-c, as metres of travel that take the same time."""
    ux, uy, vx, vy = bx - ax, by - ay, cx - bx, cy - by
    if t.costly[k] == 0 or (ux == 0 and uy == 0) or (vx == 0 and vy == 0):
        return 0.0
    if t.corners.shape[0] > 0:
        return float(rounding_m(ux, uy, vx, vy, t))
    return float(turning_m(ux, uy, vx, vy, t.turn_m[k], t.arc_m[k]))
