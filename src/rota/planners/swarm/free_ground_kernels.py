# mypy: disable-error-code="no-any-return"
"""Compiled news of free ground: numbers at places of the map, which the robots near them keep and pass on.

All robots have the same map, and on it the same places and ways between them. The load of a place tells how much of
discs lies round it, by a cone of ``REACH`` sensor radii; so much ground lies there, too. A place of little load for its
ground is free, others are held by the robots round them. Robots tell each other the number of each place that they
hold: how far it is from there to free ground, along ways and over places that are held. That is 0 where a way ends at
a free place, and else follows from the numbers beside it, so that news go on by one way, less than a sensor's radius,
in a step. The numbers are the same to all that hold a place, hence kept once.
"""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import allocation_free
from rota.planners.swarm.offer_kernels import cost_m, cover_places, pass_on_offers, settle_offers
from rota.planners.swarm.place_kernels import places_of_row, rows_within

REACH = 2.0  # sensor radii, within which a robot loads places
# square metres of discs for one of ground: a place gets free with less than the one, and is held from the other on;
# measured: where both are .3, robots that hold a place by coming and free it by going keep 1 in 10 heaps from rest
FREE_BELOW, HELD_FROM = 0.25, 0.5
SIGHT_SHARE = 0.98  # of the way to a place seen counts, so that of two on the same way the farther one leads


@allocation_free
def add_load(x: float, y: float, sensor_m: float, discs: float, graph: Any) -> None:
    """Load the places within reach of (x, y) with ``discs`` discs, each spread as a cone as large as a disc."""
    reach_m = REACH * sensor_m
    top = 3.0 / (REACH * REACH) * discs
    low, high = rows_within(y, reach_m, graph)
    for row in range(low, high):
        begin, end = places_of_row(row, x, reach_m, graph)
        for k in range(begin, end):
            dx, dy = graph.x[k] - x, graph.y[k] - y
            distance2 = dx * dx + dy * dy
            if distance2 < reach_m * reach_m:
                graph.load[k] += top * (1.0 - math.sqrt(distance2) / reach_m)


@allocation_free
def load_with_capacity(area_m2: Any, sensor_m: float, graph: Any) -> None:
    """Load the places with the ground about each of them, area_m2 (k,): up to 1 disc, less where there are walls."""
    graph.load[:] = 0.0
    for k in range(graph.x.shape[0]):
        add_load(graph.x[k], graph.y[k], sensor_m, area_m2[k] / (math.pi * sensor_m * sensor_m), graph)


@allocation_free
def clear_load(graph: Any) -> None:
    """Begin with places that nobody holds."""
    graph.load[:] = 1.0 if graph.worth.shape[0] else 0.0


@allocation_free
def load_with_disc(x: float, y: float, sensor_m: float, graph: Any) -> None:
    """Load the places about (x, y) with a robot's disc, or take it from them where ground differs in importance."""
    if graph.worth.shape[0]:
        cover_places(x, y, sensor_m, graph)
    else:
        add_load(x, y, sensor_m, 1.0, graph)


@allocation_free
def load_with_all(robots: Any, kinds: Any, graph: Any) -> None:
    """Load the places with the discs of robots where they are."""
    clear_load(graph)
    for i in range(robots.x.shape[0]):
        sensor = kinds.sensor_m[robots.kind[i]]
        if sensor > 0.0:
            load_with_disc(robots.x[i], robots.y[i], sensor, graph)


@allocation_free
def pass_on_distances(step: int, graph: Any) -> None:
    """Make the next step's numbers of those told at this one: 0 at free places, else the least by way of another place.

    A number that would grow tells nothing for a step: ``far_m``, which is longer than any way. Where free ground is
    taken, old numbers go round from place to place and back and grow for ever, and robots that went by them went to and
    fro for ever. Measured: 2 of 12 heaps of 100 robots did so; silence for two steps costs rooms 1 % of the ground.
    """
    if graph.worth.shape[0]:
        pass_on_offers(step, graph)
        return
    old, new = graph.away_m[step % 2], graph.away_m[(step + 1) % 2]
    for k in range(graph.x.shape[0]):
        least, most = 0.0, HELD_FROM if old[k] == 0.0 else FREE_BELOW
        if graph.load[k] >= most * graph.capacity[k]:
            least = graph.far_m
            for link in range(graph.link_start[k], graph.link_start[k + 1]):
                least = min(least, old[graph.link_to[link]] + graph.link_m[link])
        new[k] = least if least <= old[k] else graph.far_m


@allocation_free
def settle_distances(step: int, graph: Any, settled: Any) -> None:
    """Write (k,) what ``pass_on_distances`` comes to while nobody moves: the shortest ways to what is free at a step.

    ``far_m`` where no way leads to free ground (Bellman-Ford, by sweeps in place).
    """
    if graph.worth.shape[0]:
        settle_offers(step, graph, settled)
        return
    n, told = graph.x.shape[0], graph.away_m[step % 2]
    for k in range(n):
        settled[k] = 0.0 if told[k] == 0.0 else graph.far_m
    changes = True
    while changes:
        changes = False
        for k in range(n):
            for link in range(graph.link_start[k], graph.link_start[k + 1]):
                away = settled[graph.link_to[link]] + graph.link_m[link]
                if away < settled[k]:
                    settled[k], changes = away, True


@allocation_free
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


@allocation_free
def direction_to_free_ground(
    x: float, y: float, within_m: float, step: int, c: int, grid: Any
) -> tuple[float, float, float]:
    """Metres from (x, y) to free ground by way of a place in sight, and the way (dx, dy) to that place.

    ``far_m``, 0, 0 where there is none. c: the cell of the grid that (x, y) is in. Only places within a distance count,
    in the 25 cells of the map round about, which reach as far as ways do.
    """
    graph = grid.place_graph
    differs = graph.worth.shape[0] > 0
    least, dx, dy = graph.way_m + graph.dear_m, 0.0, 0.0
    away_m = graph.away_m[step % 2]
    i = min(max(int((x - graph.x0) / graph.cell_m), 0), graph.columns - 1)
    j = min(max(int((y - graph.y0) / graph.cell_m), 0), graph.rows - 1)
    for row in range(max(j - 2, 0), min(j + 2, graph.rows - 1) + 1):
        begin = graph.cell_start[row * graph.columns + max(i - 2, 0)]
        end = graph.cell_start[row * graph.columns + min(i + 2, graph.columns - 1) + 1]
        for k in range(begin, end):
            told_m = cost_m(away_m[k], graph) if differs else away_m[k]
            if told_m >= least:
                continue
            ex, ey = graph.x[k] - x, graph.y[k] - y
            length = math.sqrt(ex * ex + ey * ey)
            away = told_m + SIGHT_SHARE * length
            if length <= within_m and away < least and is_seen(x, y, graph.x[k], graph.y[k], c, grid):
                least, dx, dy = away, ex, ey
    return least, dx, dy
