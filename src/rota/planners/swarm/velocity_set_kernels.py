# mypy: disable-error-code="no-any-return"
"""Compiled sets of velocities: a convex polygon, cut by half-planes, within a disc round the origin; its centroid."""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import allocation_free

MOST_CORNERS = 64
SLIVER = 1e-12  # an area below this share of the disc's square has no centroid that rounding leaves


@allocation_free
def square_round(half: float, outline: Any) -> int:
    """Make the outline the square with sides 2 half round the origin; returns its number of corners."""
    outline.x[0], outline.y[0] = -half, -half
    outline.x[1], outline.y[1] = half, -half
    outline.x[2], outline.y[2] = half, half
    outline.x[3], outline.y[3] = -half, half
    return 4


@allocation_free
def is_cut(outline: Any, corners: int, ex: float, ey: float, bound: float) -> bool:
    """Whether any corner lies beyond the half-plane v . e <= bound."""
    for k in range(corners):  # noqa: SIM110 (a compiled loop)
        if outline.x[k] * ex + outline.y[k] * ey > bound:
            return True
    return False


@allocation_free
def cut(outline: Any, corners: int, ex: float, ey: float, bound: float, result: Any) -> int:
    """Write the part of a convex polygon with v . e <= bound into ``result``; returns its corners, 0: none is left.

    A polygon may have one or two corners: a place or a segment. A polygon that has no room for one more corner stays
    whole.
    """
    if corners + 1 > result.x.shape[0]:
        for k in range(corners):
            result.x[k], result.y[k] = outline.x[k], outline.y[k]
        return corners
    m = 0
    px, py = outline.x[corners - 1], outline.y[corners - 1]
    beyond_before = px * ex + py * ey - bound
    for k in range(corners):
        qx, qy = outline.x[k], outline.y[k]
        beyond = qx * ex + qy * ey - bound
        if (beyond_before < 0.0 and beyond > 0.0) or (beyond_before > 0.0 and beyond < 0.0):
            t = beyond_before / (beyond_before - beyond)
            result.x[m], result.y[m] = px + t * (qx - px), py + t * (qy - py)
            m += 1
        if beyond <= 0.0:
            result.x[m], result.y[m] = qx, qy
            m += 1
        px, py, beyond_before = qx, qy, beyond
    return m


@allocation_free
def polygon_centroid(outline: Any, corners: int, least_area: float) -> tuple[float, float]:
    """Centroid of a convex polygon; the mean of its corners where its area is below the least area."""
    x0, y0 = outline.x[0], outline.y[0]
    twice, mx, my = 0.0, 0.0, 0.0
    for k in range(1, corners - 1):  # triangles from the first corner, so that a small set far out loses no digits
        ax, ay = outline.x[k] - x0, outline.y[k] - y0
        bx, by = outline.x[k + 1] - x0, outline.y[k + 1] - y0
        cross = ax * by - ay * bx
        twice += cross
        mx += cross * (ax + bx)
        my += cross * (ay + by)
    if twice > least_area:
        return x0 + mx / (3.0 * twice), y0 + my / (3.0 * twice)
    mx, my = 0.0, 0.0
    for k in range(corners):
        mx += outline.x[k]
        my += outline.y[k]
    return mx / corners, my / corners


@allocation_free
def arc_angle(px: float, py: float, qx: float, qy: float, whole: bool) -> float:
    """Angle in radians from p counter-clockwise to q, 0..2 pi; ``whole``: 2 pi where rounding leaves 0 or 2 pi."""
    angle = math.atan2(px * qy - py * qx, px * qx + py * qy)
    if angle >= 0.0:
        return angle
    return 0.0 if angle > -1e-9 and not whole else angle + 2.0 * math.pi


@allocation_free
def centroid_in_disc(outline: Any, corners: int, radius: float) -> tuple[bool, float, float]:
    """Centroid of a convex polygon's part in the disc of a radius round the origin, in closed form; False: empty.

    The border of that part runs along chords, the pieces of the polygon's sides in the disc, and along arcs between one
    chord's end and the beginning of the next. A chord (u, w) gives the triangle 0 u w, an arc the sector over it.
    """
    r2 = radius * radius
    inside = True
    for k in range(corners):
        if outline.x[k] * outline.x[k] + outline.y[k] * outline.y[k] > r2:
            inside = False
            break
    if inside:
        x, y = polygon_centroid(outline, corners, SLIVER * r2)
        return corners > 0, x, y
    area, mx, my = 0.0, 0.0, 0.0  # twice the area, thrice the first moment
    sx, sy, chords, holds_origin = 0.0, 0.0, 0, True
    fx, fy, lx, ly, first_enters, left, alone = 0.0, 0.0, 0.0, 0.0, False, False, False
    px, py = outline.x[corners - 1], outline.y[corners - 1]
    for k in range(corners):
        qx, qy = outline.x[k], outline.y[k]
        dx, dy = qx - px, qy - py
        side = px * qy - py * qx
        holds_origin = holds_origin and side >= 0.0
        a, b, c = dx * dx + dy * dy, px * dx + py * dy, px * px + py * py - r2
        root = b * b - a * c
        if a > 0.0 and root > 0.0:
            root = math.sqrt(root)
            t0, t1 = (-b - root) / a, (-b + root) / a
            if t1 > 0.0 and t0 < 1.0:
                enters, leaves = t0 > 0.0, t1 < 1.0
                ux, uy = (px + t0 * dx, py + t0 * dy) if enters else (px, py)
                wx, wy = (px + t1 * dx, py + t1 * dy) if leaves else (qx, qy)
                if chords == 0:
                    fx, fy, first_enters, alone = ux, uy, enters, side >= 0.0
                elif left or enters or lx != ux or ly != uy:  # else both meet at a corner in the disc
                    angle = arc_angle(lx, ly, ux, uy, False)
                    area += r2 * angle
                    mx += r2 * (uy - ly)
                    my -= r2 * (ux - lx)
                cross = ux * wy - uy * wx
                area += cross
                mx += 0.5 * cross * (ux + wx)
                my += 0.5 * cross * (uy + wy)
                sx += ux + wx
                sy += uy + wy
                chords += 1
                lx, ly, left = wx, wy, leaves
        px, py = qx, qy
    if chords == 0:  # the disc lies in the polygon, or outside
        return holds_origin and corners > 2, 0.0, 0.0
    if left or first_enters or lx != fx or ly != fy:
        angle = arc_angle(lx, ly, fx, fy, chords == 1 and alone)
        area += r2 * angle
        mx += r2 * (fy - ly)
        my -= r2 * (fx - lx)
    if area > SLIVER * r2:
        return True, 2.0 * mx / (3.0 * area), 2.0 * my / (3.0 * area)
    return True, sx / (2 * chords), sy / (2 * chords)
