# mypy: disable-error-code="no-any-return"
"""Compiled news of free ground: numbers at places of the map, which the robots near them keep and pass on.

All robots have the same map, and on it the same places and ways between them. A place that is within ``HELD`` sensor
radii of a robot is held by it, one that nobody holds is free. Robots tell each other the number of each place that they
hold: how far it is from there to free ground, along ways and over places that are held. That is 0 where a way ends at
a free place, and else follows from the numbers beside it, so that news go on by one way, less than a sensor's radius,
in a step. The numbers are the same to all that hold a place, hence kept once.
"""

from __future__ import annotations

import math
from typing import Any

from rota.planners.swarm.kernels import compiled

# sensor radii; of a robot at a place that is free by this and has neighbours all round half is for itself
HELD = 1.5
FARTHER = 0.98  # of the way to a place seen counts, so that of two on the same way the farther one leads


@compiled
def hold_places(x: float, y: float, reach_m: float, step: int, roads: Any) -> None:
    """Mark the places within reach of (x, y) as held at a step."""
    i0 = max(int((x - reach_m - roads.x0) / roads.cell_m), 0)
    i1 = min(int((x + reach_m - roads.x0) / roads.cell_m), roads.columns - 1)
    j0 = max(int((y - reach_m - roads.y0) / roads.cell_m), 0)
    j1 = min(int((y + reach_m - roads.y0) / roads.cell_m), roads.rows - 1)
    for j in range(j0, j1 + 1):
        begin, end = roads.cell_start[j * roads.columns + i0], roads.cell_start[j * roads.columns + i1 + 1]
        for k in range(begin, end):
            dx, dy = roads.x[k] - x, roads.y[k] - y
            if dx * dx + dy * dy < reach_m * reach_m:
                roads.held[k] = step


@compiled
def hold_places_of_all(step: int, robots: Any, kinds: Any, roads: Any) -> None:
    """Mark the places that robots hold where they are at a step."""
    for i in range(robots.x.shape[0]):
        sensor = kinds.sensor_m[robots.kind[i]]
        if sensor > 0.0:
            hold_places(robots.x[i], robots.y[i], HELD * sensor, step, roads)


@compiled
def pass_on_news(step: int, roads: Any) -> None:
    """From the numbers told at a step those of the next one: 0 at free places, else the least by way of another one.

    A number that would grow tells nothing for a step: ``far_m``, which no way is as long as. Where free ground is taken
    old numbers go round from place to place and back, ever greater, and robots that went by them all the time went to
    and fro for ever. Measured: 2 of 12 heaps of 100 robots did so; silence for two steps costs rooms 1 % of the ground.
    """
    told, new = roads.away_m[step % 2], roads.away_m[(step + 1) % 2]
    for k in range(roads.x.shape[0]):
        least = 0.0
        if roads.held[k] == step:
            least = roads.far_m
            for way in range(roads.way_start[k], roads.way_start[k + 1]):
                least = min(least, told[roads.way_to[way]] + roads.way_m[way])
        new[k] = least if least <= told[k] else roads.far_m


@compiled
def is_seen(x: float, y: float, px: float, py: float, c: int, grid: Any) -> bool:
    """Whether none of the walls of a grid's cell crosses the way from (x, y) to a place."""
    dx, dy = px - x, py - y
    for item in range(grid.wall_start[c], grid.wall_start[c + 1]):
        wall = grid.walls[grid.wall_item[item]]
        ex, ey = wall[2] - wall[0], wall[3] - wall[1]
        from_wall = ex * (y - wall[1]) - ey * (x - wall[0])
        to_wall = ex * (py - wall[1]) - ey * (px - wall[0])
        if (from_wall > 0.0) == (to_wall > 0.0):
            continue
        if (dx * (wall[1] - y) - dy * (wall[0] - x) > 0.0) != (dx * (wall[3] - y) - dy * (wall[2] - x) > 0.0):
            return False
    return True


@compiled
def way_to_free_ground(x: float, y: float, within_m: float, step: int, c: int, grid: Any) -> tuple[float, float, float]:
    """How far it is from (x, y) to free ground by a place in sight, and the way (dx, dy) there; ``far_m``, 0, 0: none.

    c: the cell of the grid that (x, y) is in. Of places within a distance only those in the 25 cells of the map round
    about count, which reach as far as ways do.
    """
    roads = grid.roads
    least, dx, dy = roads.far_m, 0.0, 0.0
    told = roads.away_m[step % 2]
    i = min(max(int((x - roads.x0) / roads.cell_m), 0), roads.columns - 1)
    j = min(max(int((y - roads.y0) / roads.cell_m), 0), roads.rows - 1)
    for row in range(max(j - 2, 0), min(j + 2, roads.rows - 1) + 1):
        begin = roads.cell_start[row * roads.columns + max(i - 2, 0)]
        end = roads.cell_start[row * roads.columns + min(i + 2, roads.columns - 1) + 1]
        for k in range(begin, end):
            if told[k] >= least:
                continue
            ex, ey = roads.x[k] - x, roads.y[k] - y
            length = math.sqrt(ex * ex + ey * ey)
            away = told[k] + FARTHER * length
            if length <= within_m and away < least and is_seen(x, y, roads.x[k], roads.y[k], c, grid):
                least, dx, dy = away, ex, ey
    return least, dx, dy
