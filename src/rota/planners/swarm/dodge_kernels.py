# mypy: disable-error-code="no-any-return"
"""Compiled dodging: the velocity nearest to a wish by which a robot gets out of the way of discs that do not give way.

The velocities by which the robot would meet a disc within a time, while the disc goes on as it does, are a cone with a
round tip: the velocity obstacle, truncated. The nearest velocity outside is on its tip or on one of its two legs.
Source: van den Berg, Guy, Lin and Manocha, Reciprocal n-body collision avoidance, 2011, section 4, with all of the
change made by the robot.
"""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import allocation_free

CLEAR_M = 1e-6  # kept from discs, above rounding
MARGIN = 0.1  # of both radii, kept as well by robots that are faster than the disc: walls and others may take of it
LOOK_AHEAD = 4.0  # times as long as a robot takes for both radii, which it may have to go aside, it looks ahead
PASSES = 2  # times that all discs are looked at, since dodging one may lead to another


@allocation_free
def out_of_way(
    px: float, py: float, vx: float, vy: float, reach_m: float, ahead_s: float, time_step_s: float
) -> tuple[float, float]:
    """The least change of a relative velocity by which a disc at (px, py) is not met within ahead_s; (0, 0): none.

    reach_m: the sum of both radii. A disc that is met already is left within one step.
    """
    distance2, speed2 = px * px + py * py, vx * vx + vy * vy
    if distance2 > reach_m * reach_m:
        t = min(max((px * vx + py * vy) / speed2, 0.0), ahead_s) if speed2 > 0.0 else 0.0
        cx, cy = px - t * vx, py - t * vy
        if cx * cx + cy * cy >= reach_m * reach_m:
            return 0.0, 0.0
    else:
        ahead_s = time_step_s
    wx, wy = vx - px / ahead_s, vy - py / ahead_s  # from the middle of the tip
    away = math.sqrt(wx * wx + wy * wy)
    along = wx * px + wy * py
    if distance2 <= reach_m * reach_m or (along < 0.0 and along * along > reach_m * reach_m * away * away):
        if away > 0.0:
            wx, wy = wx / away, wy / away
        elif distance2 > 0.0:
            wx, wy = -px / math.sqrt(distance2), -py / math.sqrt(distance2)
        else:
            wx, wy = 1.0, 0.0
        change = max(reach_m / ahead_s - away, 0.0)
        return change * wx, change * wy
    leg = math.sqrt(distance2 - reach_m * reach_m)
    if px * wy - py * wx > 0.0:
        dx, dy = (px * leg - py * reach_m) / distance2, (px * reach_m + py * leg) / distance2
    else:
        dx, dy = (px * leg + py * reach_m) / distance2, (py * leg - px * reach_m) / distance2
    on_leg = vx * dx + vy * dy
    return on_leg * dx - vx, on_leg * dy - vy


@allocation_free
def dodge(
    x: float, y: float, wx: float, wy: float, body: float, speed: float, moving: Any, time_step_s: float
) -> tuple[float, float]:
    """The wish (wx, wy), changed by the least that keeps the robot clear of coming discs; no faster than ``speed``."""
    if speed <= 0.0:
        return wx, wy
    for _ in range(PASSES):
        for m in range(moving.x.shape[0]):
            reach_m = body + moving.radius_m[m]
            faster = speed * speed > moving.vx[m] * moving.vx[m] + moving.vy[m] * moving.vy[m]
            reach_m += MARGIN * reach_m if faster else CLEAR_M
            ux, uy = out_of_way(
                moving.x[m] - x, moving.y[m] - y, wx - moving.vx[m], wy - moving.vy[m], reach_m,
                max(LOOK_AHEAD * reach_m / speed, time_step_s), time_step_s,
            )  # fmt: skip
            wx, wy = wx + ux, wy + uy
    length = math.sqrt(wx * wx + wy * wy)
    return (wx * (speed / length), wy * (speed / length)) if length > speed else (wx, wy)


@allocation_free
def clearance_m(x: float, y: float, vx: float, vy: float, body: float, moving: Any, within_s: float) -> float:
    """The least gap in metres of a body that goes on at a velocity and any disc within a time; inf without discs."""
    least = math.inf
    for m in range(moving.x.shape[0]):
        px, py, ux, uy = moving.x[m] - x, moving.y[m] - y, vx - moving.vx[m], vy - moving.vy[m]
        speed2 = ux * ux + uy * uy
        t = min(max((px * ux + py * uy) / speed2, 0.0), within_s) if speed2 > 0.0 else 0.0
        cx, cy = px - t * ux, py - t * uy
        least = min(least, math.sqrt(cx * cx + cy * cy) - body - moving.radius_m[m])
    return least
