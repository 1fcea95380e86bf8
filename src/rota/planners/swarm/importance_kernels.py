# mypy: disable-error-code="no-any-return"
"""Compiled integrals of importance: along the arcs of a circle, and over a robot's part of the ground."""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import allocation_free
from rota.planners.swarm.arc_kernels import area_gradient

SECTORS = 128  # of a circle: importance counts by its middles
LEAST_UNIT = 0.02  # of the greatest importance: on ground that is worth less steps are shorter
STRIPS = 24  # of a part of a disc: importance counts along their middles


@allocation_free
def matters(grid: Any) -> bool:
    """Whether some ground is worth more than other ground."""
    return grid.importance.values.shape[0] > 0


@allocation_free
def importance_at(x: float, y: float, field: Any) -> float:
    """Importance per square metre at a place: straight between the middles of cells, and beyond the rim as there."""
    rows, columns = field.values.shape
    i = min(max((x - field.x0) / field.side_m - 0.5, 0.0), columns - 1.0)
    j = min(max((y - field.y0) / field.side_m - 0.5, 0.0), rows - 1.0)
    i0, j0 = int(i), int(j)
    i1, j1 = min(i0 + 1, columns - 1), min(j0 + 1, rows - 1)
    a, b, v = i - i0, j - j0, field.values
    return (1.0 - b) * ((1.0 - a) * v[j0, i0] + a * v[j0, i1]) + b * ((1.0 - a) * v[j1, i0] + a * v[j1, i1])


@allocation_free
def importance_gradient(x: float, y: float, sensor: float, count: int, arcs: Any, field: Any) -> tuple[float, float]:
    """The gradient of the covered importance, R integral importance n da over the arcs of the circle round (x, y).

    Importance is that of the middle of each of ``SECTORS`` sectors; the integral of n over a sector's part of an arc is
    exact. So the gradient changes without jumps as robots move.
    """
    gx, gy, width = 0.0, 0.0, 2.0 * math.pi / SECTORS
    for k in range(count):
        low, high = arcs.x[k], arcs.y[k]
        sector = min(int((low + math.pi) / width), SECTORS - 1)
        sine, cosine = math.sin(low), math.cos(low)
        while low < high and sector < SECTORS:
            end = high if sector == SECTORS - 1 else min(high, (sector + 1) * width - math.pi)
            middle = (sector + 0.5) * width - math.pi
            phi = importance_at(x + sensor * math.cos(middle), y + sensor * math.sin(middle), field)
            sine_end, cosine_end = math.sin(end), math.cos(end)
            gx, gy = gx + phi * (sine_end - sine), gy + phi * (cosine - cosine_end)
            low, sine, cosine, sector = end, sine_end, cosine_end, sector + 1
    return sensor * gx, sensor * gy


@allocation_free
def most_on_circle(x: float, y: float, sensor: float, field: Any) -> float:
    """The greatest importance per square metre on a circle."""
    most, width = 0.0, 2.0 * math.pi / SECTORS
    for k in range(SECTORS):
        angle = (k + 0.5) * width - math.pi
        most = max(most, importance_at(x + sensor * math.cos(angle), y + sensor * math.sin(angle), field))
    return most


@allocation_free
def up_to(u: float, row: int, field: Any) -> tuple[float, float]:
    """Importance of a row from its left end to u cells from there, and its moment about that end."""
    columns = field.values.shape[1]
    u = min(max(u, 0.0), float(columns))
    i = min(int(u), columns - 1)
    part = (u - i) * field.side_m
    value = field.values[row, i]
    return field.sums[row, i] + part * value, field.moments[row, i] + part * value * (i * field.side_m + 0.5 * part)


@allocation_free
def importance_in_disc(
    x: float, y: float, outline: Any, corners: int, radius: float, field: Any
) -> tuple[float, float, float]:
    """Importance of a convex polygon's part in the disc of a radius, both round (x, y), and its moments about (x, y).

    The part is cut into ``STRIPS`` strips along x. Along the middle of each, between two rows of the field, the
    integral is exact.
    """
    low, high = radius, -radius
    for k in range(corners):
        low, high = min(low, outline.y[k]), max(high, outline.y[k])
    low, high = max(low, -radius), min(high, radius)
    whole, mx, my, step, rows = 0.0, 0.0, 0.0, (high - low) / STRIPS, field.values.shape[0]
    if step <= 0.0:
        return 0.0, 0.0, 0.0
    for strip in range(STRIPS):
        v = low + (strip + 0.5) * step
        left, right = math.inf, -math.inf
        px, py = outline.x[corners - 1], outline.y[corners - 1]
        for k in range(corners):
            qx, qy = outline.x[k], outline.y[k]
            if (py <= v) != (qy <= v):
                at = px + (v - py) / (qy - py) * (qx - px)
                left, right = min(left, at), max(right, at)
            px, py = qx, qy
        half = math.sqrt(max(radius * radius - v * v, 0.0))
        left, right = max(left, -half), min(right, half)
        if left >= right:
            continue
        j = min(max((y + v - field.y0) / field.side_m - 0.5, 0.0), rows - 1.0)
        j0 = int(j)
        b, u0, u1 = j - j0, (x + left - field.x0) / field.side_m, (x + right - field.x0) / field.side_m
        s0, m0 = up_to(u0, j0, field)
        s1, m1 = up_to(u1, j0, field)
        t0, n0 = up_to(u0, min(j0 + 1, rows - 1), field)
        t1, n1 = up_to(u1, min(j0 + 1, rows - 1), field)
        along, moment = (1.0 - b) * (s1 - s0) + b * (t1 - t0), (1.0 - b) * (m1 - m0) + b * (n1 - n0)
        whole += along
        mx += moment - (x - field.x0) * along
        my += v * along
    return whole * step, mx * step, my * step


@allocation_free
def worth_gradient(x: float, y: float, sensor: float, count: int, arcs: Any, grid: Any) -> tuple[float, float]:
    """The gradient of the covered area, or of the covered importance where that differs."""
    if matters(grid):
        return importance_gradient(x, y, sensor, count, arcs, grid.importance)
    return area_gradient(sensor, count, arcs)


@allocation_free
def unit_of_worth(x: float, y: float, sensor: float, whole: float, grid: Any) -> float:
    """The importance that a robot's steps are made by: the mean in its disc, or the most on its rim where that is more.

    So steps are as long on poor ground as on rich. whole: the importance in the disc. 1 where all ground is worth as
    much.
    """
    if not matters(grid):
        return 1.0
    return max(whole / (math.pi * sensor * sensor), most_on_circle(x, y, sensor, grid.importance), LEAST_UNIT)
