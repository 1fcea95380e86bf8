# mypy: disable-error-code="no-any-return"
"""Compiled decision of the reciprocal controller in three dimensions, and the last filter there.

Chen et al., Sensors 18(6):1864, 2018, with balls and half-spaces in place of discs and half-planes (their section 6
leaves three dimensions to the future). Walls are upright. Robots stand in the grid by their places in the plane;
heights and climbs are in the order of the fleet.

Nobody is held down. By half-spaces alone a robot among higher ones could rest there for ever: to climb would be to
come nearer to each of them. So a neighbour above a robot that has still to climb counts by its direction in the plane.
It keeps the robot from coming nearer in the plane and leaves climbing free; bodies are kept apart by the filter.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from rota.compiled.by_reference import by_reference
from rota.compiled.kernel import allocation_free
from rota.model.arrays import Floats
from rota.planners.swarm.filter_kernels import ROUNDING_M, greatest_speed, wall_normal
from rota.planners.swarm.kernels import cell_of, comes_before, to_wall
from rota.planners.swarm.reciprocal_kernels import SAME_PLACE_M2
from rota.planners.swarm.space_set_kernels import add_plane, centroid_in_ball
from rota.planners.swarm.state import Grid, Kinds, Near, Outline, Robots, Rule

STRAIGHT_ABOVE = 1e-9  # a direction that leads by no more along the plane has none there
GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))  # of its multiples no two are near each other soon
MOST_PROJECTIONS = 8  # half-spaces that a filtered velocity is brought into, one after the other


class Heights(NamedTuple):
    """Heights of n robots in metres and how fast they climb, (n,) each, in the order of the fleet."""

    z: Floats
    vz: Floats


class Bands(NamedTuple):
    """Heights between which the middles of n robots' bodies stay, (n,) each, in the order of the fleet."""

    low_m: Floats
    high_m: Floats


@by_reference
class SpaceSnapshot(NamedTuple):
    """All that robots in space decide from in one step.

    full_m: (n,) in the order of the fleet, the height from which on a robot's footprint grows no more.
    """

    robots: Robots
    heights: Heights
    kinds: Kinds
    full_m: Floats
    grid: Grid
    bands: Bands
    rule: Rule


class SpaceDecisions(NamedTuple):
    """Velocities in m/s that a step decides, (n,) each: vx, vy in the order of the grid, vz in that of the fleet."""

    vx: Floats
    vy: Floats
    vz: Floats


class SpaceRoom(NamedTuple):
    """What is written to while robots in space decide: neighbours, (m, 4) half-spaces, and two polygons."""

    near: Near
    planes: Floats
    outline: Outline
    spare: Outline


@allocation_free
def find_neighbours(i: int, most: int, robots: Any, heights: Any, grid: Any, range_m: float, near: Any) -> int:
    """The ``most`` nearest robots within range_m (no more than a cell's side) of robot i, nearest first, into ``near``.

    Returns how many there are.
    """
    x, y, z = robots.x[i], robots.y[i], heights.z[robots.name[i]]
    count, stride = 0, grid.columns + 2
    below = cell_of(x, y, grid) - stride
    for row in range(3):
        c = below + row * stride
        for j in range(grid.start[c - 1], grid.start[c + 2]):
            dx, dy, dz = robots.x[j] - x, robots.y[j] - y, heights.z[robots.name[j]] - z
            distance2 = dx * dx + dy * dy + dz * dz
            if j == i or distance2 > range_m * range_m or most == 0:
                continue
            k = min(count, most - 1)
            if count == most and not comes_before(distance2, robots.name[j], k, near, robots.name):
                continue
            count = min(count + 1, most)
            while k > 0 and comes_before(distance2, robots.name[j], k - 1, near, robots.name):
                near.robot[k] = near.robot[k - 1]
                near.distance2[k] = near.distance2[k - 1]
                k -= 1
            near.robot[k] = j
            near.distance2[k] = distance2
    return count


@allocation_free
def lowest_m(z: float, low_m: float, full_m: float) -> float:
    """How far down a robot may go: to the floor, and not where its footprint, full from full_m on, would shrink."""
    return max(low_m, min(z, full_m))


@allocation_free
def in_plane(ex: float, ey: float, sign: float) -> tuple[float, float]:
    """The unit vector along (ex, ey); along x or against it, as the sign says, where that is nothing."""
    length = math.sqrt(ex * ex + ey * ey)
    return (ex / length, ey / length) if length > STRAIGHT_ABOVE else (sign, 0.0)


@allocation_free
def decide_in_space(begin: int, end: int, snapshot: Any, decisions: Any, room: Any) -> None:
    """New velocities of the robots begin..end - 1 from one snapshot: the centroid of what each may choose.

    0 where that is nothing. room: of one thread.

    A neighbour at the unit vector e, velocity w: v . e <= (v_now + w) . e / 2; a wall within reach, e towards its
    nearest point: v . e <= 0; ceiling and floor, as robots may go right up to them: no farther than there in one step.
    Where a robot's footprint grows with height, below full_m, to sink is to weaken coverage, and neighbours above count
    by their direction in the plane; of two in one place there, each gives way to its own side.
    """
    robots, heights, kinds, full_m = snapshot.robots, snapshot.heights, snapshot.kinds, snapshot.full_m
    grid, bands, rule = snapshot.grid, snapshot.bands, snapshot.rule
    near, planes, outline, spare = room
    for i in range(begin, end):
        kind, name, x, y = robots.kind[i], robots.name[i], robots.x[i], robots.y[i]
        z, vx, vy, vz = heights.z[name], robots.vx[i], robots.vy[i], heights.vz[name]
        neighbours = find_neighbours(i, rule.neighbours, robots, heights, grid, kinds.neighbour_range_m[kind], near)
        lowest = lowest_m(z, bands.low_m[name], full_m[name])
        count = add_plane(planes, 0, 0.0, 0.0, 1.0, (bands.high_m[name] - z) / rule.time_step_s)
        count = add_plane(planes, count, 0.0, 0.0, -1.0, (z - lowest) / rule.time_step_s)
        c, range_m = cell_of(x, y, grid), kinds.wall_range_m[kind]
        for item in range(grid.wall_start[c], grid.wall_start[c + 1]):
            dx, dy = to_wall(x, y, grid.walls[grid.wall_item[item]])
            distance = math.sqrt(dx * dx + dy * dy)
            if distance * distance >= SAME_PLACE_M2 and distance < range_m:
                count = add_plane(planes, count, dx / distance, dy / distance, 0.0, 0.0)
        for k in range(neighbours):
            if near.distance2[k] < SAME_PLACE_M2:
                continue
            j, distance = near.robot[k], math.sqrt(near.distance2[k])
            other = robots.name[j]
            ex, ey, ez = (robots.x[j] - x) / distance, (robots.y[j] - y) / distance, (heights.z[other] - z) / distance
            if ez > 0.0 and z < full_m[name]:
                ex, ey = in_plane(ex, ey, 1.0 if name < other else -1.0)
                ez = 0.0
            # half of what the relative velocity must change by, as in the plane
            closing = (vx - robots.vx[j]) * ex + (vy - robots.vy[j]) * ey + (vz - heights.vz[other]) * ez
            count = add_plane(planes, count, ex, ey, ez, vx * ex + vy * ey + vz * ez - 0.5 * closing)
        ok, cx, cy, cz = centroid_in_ball(planes, count, kinds.speed_m_s[kind], outline, spare)
        decisions.vx[i] = cx if ok else 0.0
        decisions.vy[i] = cy if ok else 0.0
        decisions.vz[name] = cz if ok else 0.0


@allocation_free
def tighter(limit: Any, vx: float, vy: float, vz: float, ex: float, ey: float, ez: float, bound: float) -> Any:
    """The worse of the half-space that a velocity violates most so far and v . e <= bound, and the least share allowed.

    limit: violation, e and bound of the worst so far, and the share. bound >= 0.
    """
    towards = vx * ex + vy * ey + vz * ez
    share = min(limit[5], bound / towards) if towards > bound else limit[5]
    if towards - bound > limit[0]:
        return towards - bound, ex, ey, ez, bound, share
    return limit[0], limit[1], limit[2], limit[3], limit[4], share


@allocation_free
def limits_of(i: int, snapshot: Any, vx: float, vy: float, vz: float) -> Any:
    """The half-space that robot i's velocity violates most, as (violation, e, bound), and the share that all allow."""
    robots, heights, kinds = snapshot.robots, snapshot.heights, snapshot.kinds
    grid, bands, time_step_s = snapshot.grid, snapshot.bands, snapshot.rule.time_step_s
    kind, name, x, y = robots.kind[i], robots.name[i], robots.x[i], robots.y[i]
    z, body, step_m = heights.z[name], kinds.body_m[kind], kinds.speed_m_s[kind] * time_step_s
    limit = (0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    limit = tighter(limit, vx, vy, vz, 0.0, 0.0, 1.0, max(bands.high_m[name] - z, 0.0) / time_step_s)
    limit = tighter(limit, vx, vy, vz, 0.0, 0.0, -1.0, max(z - bands.low_m[name], 0.0) / time_step_s)
    c, stride = cell_of(x, y, grid), grid.columns + 2
    for row in range(3):
        first = c + (row - 1) * stride
        for j in range(grid.start[first - 1], grid.start[first + 2]):
            dx, dy, dz = robots.x[j] - x, robots.y[j] - y, heights.z[robots.name[j]] - z
            distance = math.sqrt(dx * dx + dy * dy + dz * dz)
            bodies = body + kinds.body_m[robots.kind[j]]
            if j == i or distance > bodies + step_m + kinds.speed_m_s[robots.kind[j]] * time_step_s:
                continue
            bound = greatest_speed(distance - bodies, 2.0 * time_step_s)
            apart = distance if distance > 0.0 else 1.0
            limit = tighter(limit, vx, vy, vz, dx / apart, dy / apart, dz / apart, bound)
    for item in range(grid.wall_start[c], grid.wall_start[c + 1]):
        wall = grid.walls[grid.wall_item[item]]
        dx, dy = to_wall(x, y, wall)
        distance = math.sqrt(dx * dx + dy * dy)
        if distance > body + step_m + ROUNDING_M:
            continue
        ex, ey = wall_normal(dx, dy, distance, wall)
        bound = greatest_speed(distance - body, time_step_s)
        limit = tighter(limit, vx, vy, vz, ex, ey, 0.0, bound)
        if distance <= 1e-12:
            limit = tighter(limit, vx, vy, vz, -ex, -ey, 0.0, bound)
    return limit


@allocation_free
def climb(begin: int, end: int, snapshot: Any, nearest2: Any, decisions: Any) -> None:
    """Let the robots begin..end - 1, which have decided in the plane, climb to where their footprints are full.

    A robot goes no faster than it can: a velocity longer than that is shortened, climbing included. nearest2: (n,) as
    ``Decisions`` has them. Robots straight above each other know no direction away; each takes one of its own.
    """
    robots, heights, rule = snapshot.robots, snapshot.heights, snapshot.rule
    for i in range(begin, end):
        name, speed = robots.name[i], snapshot.kinds.speed_m_s[robots.kind[i]]
        vx, vy = decisions.vx[i], decisions.vy[i]
        if nearest2[i] < STRAIGHT_ABOVE * STRAIGHT_ABOVE:
            vx, vy = speed * math.cos(GOLDEN_ANGLE * name), speed * math.sin(GOLDEN_ANGLE * name)
        vz = min(max(snapshot.full_m[name] - heights.z[name], 0.0) / rule.time_step_s, speed)
        length = math.sqrt(vx * vx + vy * vy + vz * vz)
        share = speed / length if length > speed else 1.0
        decisions.vx[i], decisions.vy[i], decisions.vz[name] = share * vx, share * vy, share * vz


@allocation_free
def filter_in_space(begin: int, end: int, snapshot: Any, decisions: Any) -> None:
    """Replace the velocities of the robots begin..end - 1 by ones that are safe for one step.

    No balls can then touch each other or a wall, or leave their band.

    The bounds are those of the filter in the plane. A velocity glides: a few times it is brought into the half-space
    that it violates most. That makes it no longer, since 0 is in all half-spaces. Then it is shortened to what all of
    them allow.
    """
    robots = snapshot.robots
    for i in range(begin, end):
        vx, vy, vz = decisions.vx[i], decisions.vy[i], decisions.vz[robots.name[i]]
        for glide in range(MOST_PROJECTIONS):
            over, ex, ey, ez, _bound, share = limits_of(i, snapshot, vx, vy, vz)
            if over <= 0.0:
                break
            if glide < MOST_PROJECTIONS - 1:
                vx, vy, vz = vx - over * ex, vy - over * ey, vz - over * ez
            else:
                vx, vy, vz = share * vx, share * vy, share * vz
        decisions.vx[i], decisions.vy[i], decisions.vz[robots.name[i]] = vx, vy, vz
