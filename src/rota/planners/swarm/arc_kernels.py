# mypy: disable-error-code="no-any-return"
"""Compiled gradient of the covered area: the arcs of a robot's circle that lie in the ground and that nobody covers.

The area that discs cover of the ground grows, as disc i moves by p, at the rate p . g with g = R integral n da over
the exposed arcs of its circle: those in the ground and in no other disc, n their outward normal. What any other arc
sweeps is covered anyway, or is not ground.
"""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import allocation_free
from rota.planners.swarm.kernels import cell_of

SAME_PLACE_M = 1e-9


@allocation_free
def toggle(angle: float, count: int, ends: Any) -> int:
    """Add an angle in radians to ascending ones, ends (m,), or take it out where it is among them.

    count: how many of ``ends`` are in use; returns how many are then. Where there is no room for another one they stay.
    """
    k = count
    while k > 0 and ends[k - 1] > angle:
        k -= 1
    if k > 0 and ends[k - 1] == angle:
        for m in range(k, count):
            ends[m - 1] = ends[m]
        return count - 1
    if count + 2 >= ends.shape[0]:
        return count
    for m in range(count, k, -1):
        ends[m] = ends[m - 1]
    ends[k] = angle
    return count + 1


@allocation_free
def arcs_in_ground(x: float, y: float, sensor: float, grid: Any, arcs: Any) -> int:
    """Fill ``arcs`` with the arcs of the circle round (x, y), a place in the ground, that lie in the ground.

    arcs: their beginnings and ends in radians, ascending from -pi to pi; returns how many arcs there are. A point of
    the circle lies in the ground when the radius to it crosses walls an even number of times. The angles at which a
    radius begins and ceases to cross a wall are those of the wall's ends in the disc. Two walls have the same angle at
    their corner, where nothing changes.
    """
    count, odd, r2 = 0, False, sensor * sensor
    c = cell_of(x, y, grid)
    for item in range(grid.wall_start[c], grid.wall_start[c + 1]):
        wall = grid.walls[grid.wall_item[item]]
        ax, ay, bx, by = wall[0] - x, wall[1] - y, wall[2] - x, wall[3] - y
        dx, dy = bx - ax, by - ay
        length2, cross = dx * dx + dy * dy, ax * dy - ay * dx
        height2 = cross * cross / length2
        if height2 >= r2:
            continue
        along, half = -(ax * dx + ay * dy) / length2, math.sqrt((r2 - height2) / length2)
        a_in, b_in = ax * ax + ay * ay < r2, bx * bx + by * by < r2
        if not a_in and not b_in and (along <= 0.0 or along >= 1.0):
            continue
        if not b_in:
            bx, by = ax + (along + half) * dx, ay + (along + half) * dy
        if not a_in:
            ax, ay = ax + (along - half) * dx, ay + (along - half) * dy
        first, last = math.atan2(ay, ax), math.atan2(by, bx)
        odd = odd != (abs(first - last) > math.pi)  # it hides the direction of pi
        count = toggle(first, count, arcs.x)
        count = toggle(last, count, arcs.x)
    if not odd:
        for k in range(count, 0, -1):
            arcs.x[k] = arcs.x[k - 1]
        arcs.x[0], arcs.x[count + 1] = -math.pi, math.pi
        count += 2
    for k in range(count // 2):
        arcs.x[k], arcs.y[k] = arcs.x[2 * k], arcs.x[2 * k + 1]
    return count // 2


@allocation_free
def cover(begin: float, end: float, count: int, arcs: Any) -> int:
    """Take the angles from begin to end, both within -pi and pi, out of the arcs; returns how many arcs are left."""
    k = 0
    while k < count:
        low, high = arcs.x[k], arcs.y[k]
        if high <= begin or low >= end:
            k += 1
        elif low < begin and high > end:
            if count == arcs.x.shape[0]:
                return count
            arcs.x[count], arcs.y[count] = end, high
            arcs.y[k] = begin
            return count + 1
        elif low < begin:
            arcs.y[k] = begin
            k += 1
        elif high > end:
            arcs.x[k] = end
            k += 1
        else:
            count -= 1
            arcs.x[k], arcs.y[k] = arcs.x[count], arcs.y[count]
    return count


@allocation_free
def exposed_arcs(i: int, neighbours: int, robots: Any, kinds: Any, grid: Any, near: Any, arcs: Any) -> int:
    """Fill ``arcs`` with the arcs of robot i's circle that lie in the ground and in no neighbour's disc.

    near: ``neighbours`` robots, by ``find_neighbours``. arcs: as ``arcs_in_ground`` has them; returns how many. Of
    equal discs in one place, that of the smallest number in the fleet counts as the one on top.
    """
    x, y, sensor = robots.x[i], robots.y[i], kinds.sensor_m[robots.kind[i]]
    if sensor <= 0.0:
        return 0
    count = arcs_in_ground(x, y, sensor, grid, arcs)
    for k in range(neighbours):
        j = near.robot[k]
        other, distance = kinds.sensor_m[robots.kind[j]], math.sqrt(near.distance2[k])
        if distance <= SAME_PLACE_M and sensor == other:
            if robots.name[j] < robots.name[i]:
                return 0
            continue
        if distance <= other - sensor:
            return 0
        if distance >= sensor + other or distance <= sensor - other:
            continue
        cosine = (sensor * sensor + distance * distance - other * other) / (2.0 * sensor * distance)
        half = math.acos(min(max(cosine, -1.0), 1.0))
        middle = math.atan2(robots.y[j] - y, robots.x[j] - x)
        begin, end = middle - half, middle + half
        if begin < -math.pi:
            count = cover(begin + 2.0 * math.pi, math.pi, count, arcs)
            begin = -math.pi
        elif end > math.pi:
            count = cover(-math.pi, end - 2.0 * math.pi, count, arcs)
            end = math.pi
        count = cover(begin, end, count, arcs)
        if count == 0:
            break
    return count


@allocation_free
def area_gradient(sensor: float, count: int, arcs: Any) -> tuple[float, float]:
    """The gradient of the covered area, R integral n da over the circle's arcs: square metres per metre along x, y."""
    gx, gy = 0.0, 0.0
    for k in range(count):
        gx += math.sin(arcs.y[k]) - math.sin(arcs.x[k])
        gy += math.cos(arcs.x[k]) - math.cos(arcs.y[k])
    return sensor * gx, sensor * gy
