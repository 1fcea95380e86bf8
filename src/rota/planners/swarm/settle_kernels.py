# mypy: disable-error-code="no-any-return"
"""Compiled decision of the controller that comes to rest: where each robot covers most, and on to free ground."""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import allocation_free
from rota.planners.swarm.arc_kernels import arcs_in_ground, area_gradient, exposed_arcs
from rota.planners.swarm.baseline_kernels import FULL_SHARE_CAUSES, overlaps_with_robots, towards
from rota.planners.swarm.free_ground_kernels import direction_to_free_ground
from rota.planners.swarm.friction_kernels import friction_unit_m, rub
from rota.planners.swarm.importance_kernels import matters, unit_of_worth, worth_gradient
from rota.planners.swarm.kernels import cell_of, find_neighbours, to_wall
from rota.planners.swarm.offer_kernels import worth_of_offer
from rota.planners.swarm.own_ground_kernels import own_share

# ------------------------------------------------------------ steps

OVERLAP_SHARE = 0.3  # of an overlap that a robot takes away in a step; measured: with more, swarms tremble
MOMENTUM = 0.92  # share of the last step that is made again
# share of the last step with late news; measured: with 0.4, 0.5 and 0.55 1, none and 7 of 36 swarms do not rest within
# 6,000 steps
LATE_MOMENTUM = 0.5
# robots with shorter last steps that would turn back drop their momentum; share of the sensor's radius, with a wall in
# range twice that
SLOW_STEP = 2e-3
TURN_BACK_SHARE = 0.5  # and go this share of the way back: by the whole of it some go to and fro for ever
TOUCH_SHARE = 1e-3  # of the sensor's radius; a body so near a wall does not push on into it

# ------------------------------------------------------------ by the share of the ground in range that is a robot's own

FULL_PUSH_BELOW, NO_PUSH_ABOVE = 0.85, 1.1  # pushes count in full up to one share, and not at all from the other on
# where ground differs in importance: there robots cover most where discs overlap; measured in docs/ablation.md
FULL_PUSH_WHERE_IT_DIFFERS, NO_PUSH_WHERE_IT_DIFFERS = 0.2, 0.5
PARKED_BELOW, PUSHED_FROM = 0.12, 0.25  # of redundant robots
MOVE_ON_BELOW, MOVE_ON_BELOW_AT_WALLS = 0.5, 0.85  # with less, robots go on to free ground
MOVE_ON_GAIN = 3.0  # they do so at full speed when 1 / MOVE_ON_GAIN is missing from that share
GAP_TO_AHEAD = 0.6  # of the sum of two bodies' radii, which the one behind keeps between them


@allocation_free
def touch_m(kind: int, kinds: Any) -> float:
    """How near to a wall the middle of a robot of a kind must be not to push on into it."""
    return kinds.body_m[kind] + TOUCH_SHARE * kinds.sensor_m[kind]


@allocation_free
def not_into_walls(x: float, y: float, near_m: float, dx: float, dy: float, grid: Any) -> tuple[float, float]:
    """The step (dx, dy) from (x, y) without its part that leads into walls within near_m.

    A robot at a wall goes along it. What pushes it into the wall must not count: it would make each step along the wall
    too long and friction too weak, and the robot would go to and fro for ever.
    """
    c = cell_of(x, y, grid)
    for item in range(grid.wall_start[c], grid.wall_start[c + 1]):
        wx, wy = to_wall(x, y, grid.walls[grid.wall_item[item]])
        distance2, into = wx * wx + wy * wy, dx * wx + dy * wy
        if into > 0.0 and 0.0 < distance2 < near_m * near_m:
            dx, dy = dx - into * wx / distance2, dy - into * wy / distance2
    return dx, dy


@allocation_free
def room_for_those_ahead(
    i: int, neighbours: int, away_m: float, snapshot: Any, near: Any
) -> tuple[float, float, float]:
    """A push away from near robots that are nearer to free ground than robot i: sum and greatest of the shares.

    Robots that all press on through a door block each other in it. Robots that leave those ahead their room pass.
    away_m: how far it is from robot i to free ground.
    """
    robots, kinds, grid = snapshot.robots, snapshot.kinds, snapshot.grid
    body, sensor = kinds.body_m[robots.kind[i]], kinds.sensor_m[robots.kind[i]]
    bx, by, most = 0.0, 0.0, 0.0
    for k in range(neighbours):
        j = near.robot[k]
        distance, bodies = math.sqrt(near.distance2[k]), body + kinds.body_m[robots.kind[j]]
        if distance <= 0.0 or distance >= (1.0 + GAP_TO_AHEAD) * bodies:
            continue
        x, y = robots.x[j], robots.y[j]
        other_m, _, _ = direction_to_free_ground(x, y, sensor, snapshot.step, cell_of(x, y, grid), grid)
        if other_m > away_m or (other_m == away_m and robots.name[j] > robots.name[i]):
            continue
        share = min(1.0 - (distance - bodies) / (GAP_TO_AHEAD * bodies), 1.0)
        bx -= share * (x - robots.x[i]) / distance
        by -= share * (y - robots.y[i]) / distance
        most = max(most, share)
    return bx, by, most


@allocation_free
def pushes(
    i: int, neighbours: int, crowd: bool, robots: Any, kinds: Any, grid: Any, near: Any, arcs: Any
) -> tuple[float, float]:
    """The step (dx, dy) in metres by which neighbours and walls push robot i: ``OVERLAP_SHARE`` of the overlaps.

    It is less where very many push. crowd: there may be more neighbours than those that count, and no free ground:
    heaps that have some round them spread worse by lesser pushes. Walls push by |h|^2 / 4 R for the gradient h of the
    ground in the disc. One straight wall pushes by nearly twice its overlap, since it does not give way, and so does a
    round obstacle of however many short walls. Where each of those pushed by its own overlap, together they pushed by
    far too much, and robots went to and fro for ever.
    """
    sensor = kinds.sensor_m[robots.kind[i]]
    last_m = math.sqrt(near.distance2[neighbours - 1]) if crowd else math.inf
    fx, fy, causes = overlaps_with_robots(i, neighbours, last_m, robots, kinds, near)
    hx, hy = area_gradient(sensor, arcs_in_ground(robots.x[i], robots.y[i], sensor, grid, arcs), arcs)
    by_walls = math.sqrt(hx * hx + hy * hy) / (4.0 * sensor)
    share = OVERLAP_SHARE * FULL_SHARE_CAUSES / max(FULL_SHARE_CAUSES, causes)
    return share * (fx + by_walls * hx), share * (fy + by_walls * hy)


@allocation_free
def share_moving_on(own: float, walled: float) -> float:
    """How far a robot makes for free ground, 0..1: more, the less of the ground in its range it has to itself.

    own, walled: as ``own_share`` returns them.
    """
    below = MOVE_ON_BELOW + walled * (MOVE_ON_BELOW_AT_WALLS - MOVE_ON_BELOW)
    return min(max(MOVE_ON_GAIN * (below - own), 0.0), 1.0)


@allocation_free
def tightness(i: int, neighbours: int, robots: Any, kinds: Any, near: Any) -> float:
    """How near the nearest robot's body is, 0..1: 1 where it touches, 0 from ``GAP_TO_AHEAD`` of both radii on."""
    if neighbours == 0:
        return 0.0
    bodies = kinds.body_m[robots.kind[i]] + kinds.body_m[robots.kind[near.robot[0]]]
    gap_m = GAP_TO_AHEAD * bodies
    return min(max(1.0 - (math.sqrt(near.distance2[0]) - bodies) / gap_m, 0.0), 1.0) if gap_m > 0.0 else 0.0


@allocation_free
def moving_on(
    x: float, y: float, sensor: float, own: float, has: float, walled: float, crowd: bool, snapshot: Any
) -> tuple[float, float, float, float]:
    """How far a robot at (x, y) makes for free ground, 0..1, how far away that is, and the way (wx, wy) there.

    Where ground differs in importance, it counts how much it ``has`` for itself beside what is offered elsewhere, and
    everywhere as at walls.
    own, walled: as ``own_share`` returns them. crowd: how far away it is must be told in any case.
    """
    grid = snapshot.grid
    if not (matters(grid) or crowd) and share_moving_on(own, walled) <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    away_m, wx, wy = direction_to_free_ground(x, y, sensor, snapshot.step, cell_of(x, y, grid), grid)
    if wx == 0.0 and wy == 0.0:
        return 0.0, away_m, wx, wy
    if matters(grid):
        offer = worth_of_offer(away_m, grid.place_graph)
        own, walled = has / offer if offer > 0.0 else 1.0, 1.0
    return share_moving_on(own, walled), away_m, wx, wy


@allocation_free
def share_pushed(own: float, walled: float, going: float, told: bool, tight: float, differs: bool) -> float:
    """How far a robot goes by pushes, 0..1, not by the gradient: not at walls, nor where it makes for free ground.

    going: as ``share_moving_on`` returns it. told: news of free ground would have come by now if there were any. Then a
    robot with hardly any ground of its own is redundant and parks: many that push each other never rest. tight: by
    ``tightness``; robots do not park side by side, where nobody could make way. differs: ground differs in importance.
    """
    full, none = FULL_PUSH_BELOW, NO_PUSH_ABOVE
    if differs:
        full, none = FULL_PUSH_WHERE_IT_DIFFERS, NO_PUSH_WHERE_IT_DIFFERS
    pressed = min(max((none - own) / (none - full), 0.0), 1.0)
    if told:
        parked = min(max((own - PARKED_BELOW) / (PUSHED_FROM - PARKED_BELOW), 0.0), 1.0)
        pressed *= max(parked, tight)
    return pressed * max(0.0, 1.0 - 4.0 * going) * (1.0 - walled)


@allocation_free
def wish_of(
    i: int, neighbours: int, snapshot: Any, room: Any
) -> tuple[float, float, float, float, float, float, float]:
    """What robot i would do if it had neither momentum nor friction and nobody stood in its way.

    Returns the step (dx, dy) in metres by the gradient and by pushes; how far it makes for free ground instead, 0..1;
    how far away that is, and the way (wx, wy) there; and how much walls are in range, as ``own_share`` has it.
    room.near: ``neighbours`` robots, by ``find_neighbours``.
    """
    robots, kinds, grid = snapshot.robots, snapshot.kinds, snapshot.grid
    near, outline = room.near, room.outline
    kind = robots.kind[i]
    sensor, x, y = kinds.sensor_m[kind], robots.x[i], robots.y[i]
    count = exposed_arcs(i, neighbours, robots, kinds, grid, near, outline)
    gx, gy = worth_gradient(x, y, sensor, count, outline, grid)
    gx, gy = not_into_walls(x, y, touch_m(kind, kinds), gx, gy, grid)
    own, walled, whole = own_share(i, neighbours, robots, kinds, grid, room)
    unit = unit_of_worth(x, y, sensor, whole, grid)
    gx, gy = gx / unit, gy / unit
    gain = OVERLAP_SHARE * math.sqrt(gx * gx + gy * gy) / (4.0 * sensor)
    dx, dy = gain * gx, gain * gy
    told = snapshot.step >= grid.place_graph.news_steps
    crowd = told and neighbours == snapshot.rule.neighbours
    going, away_m, wx, wy = moving_on(x, y, sensor, own, own * whole, walled, crowd, snapshot)
    crowd = crowd and away_m >= grid.place_graph.way_m + grid.place_graph.dear_m
    tight = tightness(i, neighbours, robots, kinds, near)
    pressed = share_pushed(own, walled, going, told, tight, matters(grid))
    if pressed > 0.0:
        px, py = pushes(i, neighbours, crowd, robots, kinds, grid, near, outline)
        dx, dy = dx + pressed * (px - dx), dy + pressed * (py - dy)
    return dx, dy, going, away_m, wx, wy, walled


@allocation_free
def note_wishes(snapshot: Any, wishes: Any, room: Any) -> None:
    """Write how far each robot would go in its next step, (n,) metres in the order of the state, as ``wish_of`` says.

    0 where it makes for no free ground: pushes in a crowd that has nowhere to go are no wish to go on. room: of one
    thread.
    """
    robots, kinds, grid, rule = snapshot.robots, snapshot.kinds, snapshot.grid, snapshot.rule
    for i in range(robots.x.shape[0]):
        wishes[i], kind = 0.0, robots.kind[i]
        most_m = kinds.speed_m_s[kind] * rule.time_step_s
        if kinds.sensor_m[kind] <= 0.0 or most_m <= 0.0:
            continue
        neighbours, _ = find_neighbours(i, rule.neighbours, robots, grid, kinds.neighbour_range_m[kind], room.near)
        dx, dy, going, _, wx, wy, _ = wish_of(i, neighbours, snapshot, room)
        if going > 0.0:
            share, (dx, dy) = going * most_m / math.sqrt(wx * wx + wy * wy), towards(dx, dy, most_m, 1.0)
            dx, dy = (1.0 - going) * dx + share * wx, (1.0 - going) * dy + share * wy
            dx, dy = not_into_walls(robots.x[i], robots.y[i], touch_m(kind, kinds), dx, dy, grid)
            wishes[i] = math.sqrt(dx * dx + dy * dy)


@allocation_free
def decide_settle(begin: int, end: int, snapshot: Any, decisions: Any, room: Any) -> None:
    """Up the gradient of the covered area, with momentum; pressed robots by overlaps, and on to free ground.

    Which share of the ground in its range is nearer to it than to others tells a robot what to do. With all of it for
    itself it goes along the gradient g of the covered area, by ``OVERLAP_SHARE`` |g|^2 / 4 R: for two discs that is of
    their overlap, and it fades where g does, so that steps do not overshoot. The gradient of a disc that others cover
    is 0 and heaps would never open: with less for themselves, robots in the open push each other by their overlaps.
    Pushes end at walls and hold up heaps in corners, and rooms: a robot that has little for itself goes on by the
    shortest way to ground that it has heard is free (``free_ground_kernels``), and leaves those ahead their room.

    Momentum (Polyak's heavy ball) takes the long waves through a swarm that forces alone need thousands of steps for.
    Slow robots drop it where they would turn back, and go half as far there. Near walls, where pushes fade on a short
    way, faster ones do so as well. Dry friction, greater the slower a robot is, ends each motion in finite time, and
    holds back what leads on to free ground as well: without that robots at the border of going on tremble for ever.
    With late news there is less momentum and more friction: with all of it old places of others drive a swarm to and
    fro at full speed.

    Decides for the robots begin..end - 1 of a ``Snapshot``, into ``Decisions``; room: of one thread.
    """
    robots, kinds, grid, rule = snapshot.robots, snapshot.kinds, snapshot.grid, snapshot.rule
    for i in range(begin, end):
        kind = robots.kind[i]
        sensor, speed = kinds.sensor_m[kind], kinds.speed_m_s[kind]
        range_m = kinds.neighbour_range_m[kind]
        neighbours, decisions.nearest2[i] = find_neighbours(i, rule.neighbours, robots, grid, range_m, room.near)
        decisions.vx[i], decisions.vy[i] = 0.0, 0.0
        if sensor <= 0.0 or speed <= 0.0:
            continue
        dx, dy, going, away_m, wx, wy, walled = wish_of(i, neighbours, snapshot, room)
        momentum, most_m = LATE_MOMENTUM if rule.late else MOMENTUM, speed * rule.time_step_s
        if going > 0.0:
            bx, by, behind = room_for_those_ahead(i, neighbours, away_m, snapshot, room.near)
            length = math.sqrt(wx * wx + wy * wy)
            wx, wy = towards((1.0 - behind) * wx / length + bx, (1.0 - behind) * wy / length + by, most_m, 1.0 / most_m)
            dx, dy = towards(dx, dy, most_m, 1.0)
            dx, dy, momentum = dx + going * (wx - dx), dy + going * (wy - dy), (1.0 - going) * momentum
        last_x, last_y = robots.vx[i] * rule.time_step_s, robots.vy[i] * rule.time_step_s
        last_m = math.sqrt(last_x * last_x + last_y * last_y)
        unit_m = friction_unit_m(sensor, most_m, snapshot)
        slow_m = SLOW_STEP * sensor * (2.0 if walled > 0.0 else 1.0)
        if not rule.late and last_m < slow_m and dx * last_x + dy * last_y < 0.0:
            momentum, dx, dy = 0.0, TURN_BACK_SHARE * dx, TURN_BACK_SHARE * dy
        dx, dy = dx + momentum * last_x, dy + momentum * last_y
        dx, dy = not_into_walls(robots.x[i], robots.y[i], touch_m(kind, kinds), dx, dy, grid)
        dx, dy = rub(dx, dy, last_m, unit_m)
        decisions.vx[i], decisions.vy[i] = towards(dx, dy, speed, rule.time_step_s)
