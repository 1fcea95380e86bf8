"""What a corner of a tour costs a robot that takes time to turn, or turns on arcs (compiled)."""

from __future__ import annotations

import math

from rota.planners.patrol.ground.sight_kernels import compiled


@compiled
def corner_m(ax: float, ay: float, bx: float, by: float, cx: float, cy: float, turn_m: float, arc_m: float) -> float:
    """Turning at b on the way a-b-c, as metres of travel that take the same time.

    On arcs of radius arc_m, legs too short for the turn cost up to a full circle more: ``tour.spool_m``.
    """
    ux, uy, vx, vy = bx - ax, by - ay, cx - bx, cy - by
    if turn_m == 0 or (ux == 0 and uy == 0) or (vx == 0 and vy == 0):
        return 0.0
    turn = abs(math.atan2(ux * vy - uy * vx, ux * vx + uy * vy))
    total: float = turn_m * turn
    if arc_m > 0:
        need = 2 * arc_m * math.tan(min(turn, math.pi / 2) / 2)
        short = min(math.hypot(ux, uy), math.hypot(vx, vy))
        if short < need:
            total += 2 * math.pi * arc_m * (1 - short / need)
    return total
