# mypy: disable-error-code="no-any-return"
"""Compiled sets of velocities in space: half-spaces within a ball round the origin, and the centroid in closed form.

With planes f at distance d_f from the origin (below 0: the origin lies beyond f), unit normals n_f outwards and ball
radius R, the divergence theorem turns the set's moments into those of its plane faces, discs of radius
sqrt(R^2 - d_f^2) cut by straight lines: with area A_f and first moment F_f of each, and S the part of the sphere that
is in the set, as a solid angle,

    volume = 1/3 sum d_f A_f + R^3/3 S
    first moment = 1/4 sum d_f F_f - R^2/4 sum A_f n_f

since x is normal to the sphere, and the normals of a closed surface add up to nothing. S follows from the arcs of its
border, which are those of the faces run backwards: an arc from a to b by the angle t round n_f lies, seen from any
direction p, over the solid angle t (1 - d_f / R) + T(p, n_f, b) - T(p, n_f, a), T the spherical triangle; their sum is
-S up to whole turns of 4 pi.
"""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import allocation_free
from rota.planners.swarm.velocity_set_kernels import cut, is_cut, square_round

MOST_PLANES = 56  # each of them may add a corner to a face
SLIVER_VOLUME = 1e-11  # of R^3: below that rounding leaves no centroid, and the set is as good as flat
SLIVER_AREA = 1e-12  # of R^2: likewise for what is as good as a segment
POINT = 1e-200  # what a point counts as where lengths are added
POLE = (0.43622, -0.64117, 0.63136)  # p: a direction that no plane of a mission is likely to face
PARALLEL = 1e-12  # sine of the angle between planes that do not meet within reach


@allocation_free
def add_plane(planes: Any, count: int, ex: float, ey: float, ez: float, bound: float) -> int:
    """Add the half-space v . e <= bound, e a unit vector; returns how many there are. Without room it is left out."""
    if count == planes.shape[0]:
        return count
    planes[count, 0], planes[count, 1], planes[count, 2], planes[count, 3] = ex, ey, ez, bound
    return count + 1


@allocation_free
def across(nx: float, ny: float, nz: float) -> tuple[float, float, float, float, float, float]:
    """Two unit vectors normal to the unit vector (nx, ny, nz) and to each other, right-handed with it."""
    if abs(nx) <= abs(ny) and abs(nx) <= abs(nz):
        ax, ay, az = 1.0 - nx * nx, -nx * ny, -nx * nz
    elif abs(ny) <= abs(nz):
        ax, ay, az = -ny * nx, 1.0 - ny * ny, -ny * nz
    else:
        ax, ay, az = -nz * nx, -nz * ny, 1.0 - nz * nz
    length = math.sqrt(ax * ax + ay * ay + az * az)
    ax, ay, az = ax / length, ay / length, az / length
    return ax, ay, az, ny * az - nz * ay, nz * ax - nx * az, nx * ay - ny * ax


@allocation_free
def face_of(
    planes: Any, count: int, f: int, radius: float, tx: Any, ty: Any, outline: Any, spare: Any
) -> tuple[int, bool]:
    """The polygon of plane f round its disc that the other half-spaces leave, in the axes tx, ty from its foot.

    Returns its corners and whether they lie in ``spare``, not ``outline``. Of planes that coincide the first has the
    face.
    """
    nx, ny, nz, d = planes[f, 0], planes[f, 1], planes[f, 2], planes[f, 3]
    # clear of the disc, whose rim a touching side would interrupt by some 1e-8 where S takes it to be whole
    corners, swapped = square_round(2.0 * math.sqrt(radius * radius - d * d), outline), False
    for g in range(count):
        if corners == 0:
            break
        if g == f or planes[g, 3] >= radius:
            continue
        gx, gy, gz = planes[g, 0], planes[g, 1], planes[g, 2]
        along = nx * gx + ny * gy + nz * gz
        ex, ey = gx * tx[0] + gy * tx[1] + gz * tx[2], gx * ty[0] + gy * ty[1] + gz * ty[2]
        bound = planes[g, 3] - d * along
        if ex * ex + ey * ey < PARALLEL * PARALLEL:
            if bound < -PARALLEL * radius or (along > 0.0 and g < f and bound <= PARALLEL * radius):
                corners = 0
        elif is_cut(outline, corners, ex, ey, bound):
            corners = cut(outline, corners, ex, ey, bound, spare)
            outline, spare = spare, outline
            swapped = not swapped
    return corners, swapped


@allocation_free
def solid_angle(pole: Any, x: float, y: float, scale: float, height: float) -> float:
    """The signed solid angle of a spherical triangle: the pole, a face's normal and the direction of (x, y, height).

    pole: in the face's axes. scale: makes unit vectors of pole and direction, for their products. Source: van Oosterom
    and Strackee, IEEE Trans. Biomed. Eng. 30(2):125, 1983.
    """
    px, py, pz, length = pole
    triple = scale * (py * x - px * y)
    return 2.0 * math.atan2(triple, 1.0 + pz / length + scale * (px * x + py * y + (pz + length) * height))


@allocation_free
def outer(
    px: float, py: float, qx: float, qy: float, radius: float, height: float, pole: Any
) -> tuple[float, float, float, float]:
    """Of the disc's sector from the direction of p to that of q: twice its area, thrice its first moment (x, y), all
    signed, and the solid angle over its arc seen from the pole.
    """  # fmt: skip
    r2 = radius * radius
    ball = math.sqrt(r2 + height * height)
    angle = math.atan2(px * qy - py * qx, px * qx + py * qy)
    p_scale = radius / math.sqrt(px * px + py * py)
    q_scale = radius / math.sqrt(qx * qx + qy * qy)
    ax, ay, bx, by = p_scale * px, p_scale * py, q_scale * qx, q_scale * qy
    scale = 1.0 / (ball * pole[3])
    over = angle * (1.0 - height / ball)
    over += solid_angle(pole, bx, by, scale, height) - solid_angle(pole, ax, ay, scale, height)
    return r2 * angle, r2 * (by - ay), r2 * (ax - bx), over


@allocation_free
def face_moments(
    outline: Any, corners: int, radius: float, height: float, pole: Any
) -> tuple[bool, float, float, float, float, float, float, float]:
    """Of (convex polygon within the disc of a radius round its foot), a face at a height over the ball's centre.

    Whether there is any, its area, its first moment (x, y), the solid angle over its arcs seen from the pole, and of
    the parts of the polygon's sides in the disc the length and its first moment (x, y). Every side adds what lies
    between it and the foot: a triangle where it is in the disc, else a sector.
    """
    r2 = radius * radius
    area, mx, my, over = 0.0, 0.0, 0.0, 0.0
    extent, sx, sy, holds = 0.0, 0.0, 0.0, corners > 2
    px, py = outline.x[corners - 1], outline.y[corners - 1]
    for k in range(corners):
        qx, qy = outline.x[k], outline.y[k]
        dx, dy = qx - px, qy - py
        holds = holds and px * qy - py * qx >= 0.0
        a, b, c = dx * dx + dy * dy, px * dx + py * dy, px * px + py * py - r2
        root = b * b - a * c
        t0, t1 = 1.0, 0.0
        if a > 0.0 and root > 0.0:
            root = math.sqrt(root)
            t0, t1 = max((-b - root) / a, 0.0), min((-b + root) / a, 1.0)
        elif a == 0.0 and c <= 0.0:
            t0, t1 = 0.0, 1.0
        if t0 <= t1:
            ux, uy = (px + t0 * dx, py + t0 * dy) if t0 > 0.0 else (px, py)
            wx, wy = (px + t1 * dx, py + t1 * dy) if t1 < 1.0 else (qx, qy)
            cross = ux * wy - uy * wx
            area, mx, my = area + cross, mx + 0.5 * cross * (ux + wx), my + 0.5 * cross * (uy + wy)
            long = max(math.sqrt((wx - ux) * (wx - ux) + (wy - uy) * (wy - uy)), POINT)
            extent, sx, sy = extent + long, sx + 0.5 * long * (ux + wx), sy + 0.5 * long * (uy + wy)
            if t0 > 0.0:
                twice, ax, ay, angle = outer(px, py, ux, uy, radius, height, pole)
                area, mx, my, over = area + twice, mx + ax, my + ay, over + angle
            if t1 < 1.0:
                twice, ax, ay, angle = outer(wx, wy, qx, qy, radius, height, pole)
                area, mx, my, over = area + twice, mx + ax, my + ay, over + angle
        elif a > 0.0:
            twice, ax, ay, angle = outer(px, py, qx, qy, radius, height, pole)
            area, mx, my, over = area + twice, mx + ax, my + ay, over + angle
        px, py = qx, qy
    return holds or extent > 0.0, 0.5 * area, mx / 3.0, my / 3.0, over, extent, sx, sy


@allocation_free
def sphere_left(over: float, nearly_all: bool) -> float:
    """The part of the sphere in the set, a solid angle, from that over the border's arcs, known up to turns of 4 pi.

    nearly_all: all faces are farther from the centre than R/2, and no larger than R^2 together. Then at least pi - 1
    is left, since no body round a ball has a surface smaller than the ball's; else something of more than 1, or of pi,
    is cut off. So half a unit of room tells 0 from 4 pi.
    """
    least = 0.5 if nearly_all else -0.5
    turn = 4.0 * math.pi
    return -over - turn * math.floor((-over - least) / turn)


@allocation_free
def centroid_in_ball(
    planes: Any, count: int, radius: float, outline: Any, spare: Any
) -> tuple[bool, float, float, float]:
    """Centroid of the velocities no faster than a radius in the first ``count`` of planes (m, 4); False: there is none.

    planes: unit vectors e and bounds, v . e <= bound. Exact but for rounding: 1e-15 R over the volume in R^3, or so.
    A set without volume has the centroid of its area, and one without area that of its length.
    """
    r2, whole, has_face, nearest = radius * radius, True, False, radius
    length = math.sqrt(POLE[0] * POLE[0] + POLE[1] * POLE[1] + POLE[2] * POLE[2])
    volume, over, mx, my, mz = 0.0, 0.0, 0.0, 0.0, 0.0
    area, ax, ay, az = 0.0, 0.0, 0.0, 0.0
    extent, sx, sy, sz = 0.0, 0.0, 0.0, 0.0
    for f in range(count):
        nx, ny, nz, d = planes[f, 0], planes[f, 1], planes[f, 2], planes[f, 3]
        if d <= -radius:
            return False, 0.0, 0.0, 0.0
        if d >= radius:
            continue
        whole = False
        tx0, tx1, tx2, ty0, ty1, ty2 = across(nx, ny, nz)
        corners, swapped = face_of(planes, count, f, radius, (tx0, tx1, tx2), (ty0, ty1, ty2), outline, spare)
        if corners == 0:
            continue
        pole = (
            POLE[0] * tx0 + POLE[1] * tx1 + POLE[2] * tx2,
            POLE[0] * ty0 + POLE[1] * ty1 + POLE[2] * ty2,
            POLE[0] * nx + POLE[1] * ny + POLE[2] * nz,
            length,
        )
        is_face, size, fx, fy, angle, long, px, py = face_moments(
            spare if swapped else outline, corners, math.sqrt(r2 - d * d), d, pole
        )
        if not is_face:
            continue
        has_face, nearest = True, min(nearest, d)
        gx = size * d * nx + fx * tx0 + fy * ty0
        gy = size * d * ny + fx * tx1 + fy * ty1
        gz = size * d * nz + fx * tx2 + fy * ty2
        volume += d * size / 3.0
        over += angle
        mx += 0.25 * (d * gx - r2 * size * nx)
        my += 0.25 * (d * gy - r2 * size * ny)
        mz += 0.25 * (d * gz - r2 * size * nz)
        area, ax, ay, az = area + size, ax + gx, ay + gy, az + gz
        extent += long
        sx += long * d * nx + px * tx0 + py * ty0
        sy += long * d * ny + px * tx1 + py * ty1
        sz += long * d * nz + px * tx2 + py * ty2
    if whole or not has_face:
        return whole, 0.0, 0.0, 0.0
    volume += r2 * radius / 3.0 * sphere_left(over, nearest >= 0.5 * radius and area <= r2)
    if volume > SLIVER_VOLUME * r2 * radius:
        return True, mx / volume, my / volume, mz / volume
    if area > SLIVER_AREA * r2:
        return True, ax / area, ay / area, az / area
    if extent > 0.0:
        return True, sx / extent, sy / extent, sz / extent
    return False, 0.0, 0.0, 0.0
