# mypy: disable-error-code="no-any-return"
"""Compiled news of what free ground offers, where ground differs in importance.

A place offers the importance that a robot there would cover and nobody covers yet. Offers are told by levels, each
``LEVEL`` of the one before; level 0 is the most that any place can offer, ``graph.most``. The number of a place
(``free_ground_kernels``) tells both a level and how far it is from there to that offer: level * way_m + metres. Robots
go by its cost: an offer counts as farther by ``graph.dear_m`` times what it lacks of the most.
"""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import allocation_free
from rota.planners.swarm.place_kernels import places_of_row, rows_within

LEVEL, LEVELS = 0.7071067811865476, 12
KEPT_FROM = 0.6  # of a level, down to which an offer that was told is told again
LEAST_HOP = 0.5  # of the distance between places
ROUNDING = 1e-9


@allocation_free
def share_in_disc(distance: float, radius: float, side: float) -> float:
    """About how much of the ground round a place, of such a side, lies in a disc at that distance."""
    return min(max((radius - distance) / side + 0.5, 0.0), 1.0)


@allocation_free
def cover_places(x: float, y: float, sensor_m: float, graph: Any) -> None:
    """Take the part that the disc round (x, y) covers from what is left of the ground about each place, graph.load."""
    reach_m = sensor_m + 0.5 * graph.cell_m
    low, high = rows_within(y, reach_m, graph)
    for row in range(low, high):
        begin, end = places_of_row(row, x, reach_m, graph)
        for k in range(begin, end):
            dx, dy = graph.x[k] - x, graph.y[k] - y
            graph.load[k] *= 1.0 - share_in_disc(math.sqrt(dx * dx + dy * dy), sensor_m, graph.cell_m)


@allocation_free
def offer_of(place: int, graph: Any) -> float:
    """The importance that a robot of the least sensor would find at a place and that nobody covers yet."""
    x, y, reach_m, total = graph.x[place], graph.y[place], graph.reach_m + 0.5 * graph.cell_m, 0.0
    low, high = rows_within(y, reach_m, graph)
    for row in range(low, high):
        begin, end = places_of_row(row, x, reach_m, graph)
        for k in range(begin, end):
            if graph.load[k] * graph.worth[k] > 0.0:
                dx, dy = graph.x[k] - x, graph.y[k] - y
                share = share_in_disc(math.sqrt(dx * dx + dy * dy), graph.reach_m, graph.cell_m)
                total += share * graph.load[k] * graph.worth[k]
    return total


@allocation_free
def most_offered(graph: Any) -> float:
    """The greatest offer of any place."""
    most = 0.0
    for k in range(graph.x.shape[0]):
        most = max(most, offer_of(k, graph))
    return most


@allocation_free
def level_of(number: float, graph: Any) -> int:
    """The level of an offer that a number tells; ``LEVELS`` of none."""
    return min(int(number / graph.way_m + ROUNDING), LEVELS)


@allocation_free
def cost_m(number: float, graph: Any) -> float:
    """How far away an offer counts as, by its number: the way to it, and what it lacks of the most."""
    level = level_of(number, graph)
    if level == LEVELS:
        return graph.way_m + graph.dear_m
    return number - level * graph.way_m + graph.dear_m * (1.0 - LEVEL**level)


@allocation_free
def is_better(number: float, other: float, graph: Any) -> bool:
    """Whether a number costs less than another one; of those that cost as much the smaller is better."""
    own_m, other_m = cost_m(number, graph), cost_m(other, graph)
    return number < other if own_m == other_m else own_m < other_m


@allocation_free
def told_offer(offer: float, old: float, graph: Any) -> float:
    """The number by which a place tells its own offer, after it told ``old``; far_m of an offer below all levels."""
    worth = graph.most
    for level in range(LEVELS):
        number = level * graph.way_m
        if offer >= worth or (number == old and offer >= KEPT_FROM * worth):
            return number
        worth *= LEVEL
    return graph.far_m


@allocation_free
def hear(place: int, told: Any, graph: Any) -> float:
    """The number of least cost that a place hears from those beside it, which tell ``told``; far_m where none does."""
    least = graph.far_m
    for link in range(graph.link_start[place], graph.link_start[place + 1]):
        number = told[graph.link_to[link]]
        passed = number + max(graph.link_m[link], LEAST_HOP * graph.cell_m)
        if level_of(passed, graph) == level_of(number, graph) and is_better(passed, least, graph):
            least = passed
    return least


@allocation_free
def pass_on_offers(step: int, graph: Any) -> None:
    """Make the next step's numbers of those told at this one: that of least cost, a place's own or by way of another.

    Hearsay that would cost more than before tells nothing for a step, as in ``pass_on_distances``, and none is told of
    ways longer than way_m. Each hop counts as ``LEAST_HOP`` at least: rumours between places side by side lived long.
    """
    old, new = graph.away_m[step % 2], graph.away_m[(step + 1) % 2]
    for k in range(graph.x.shape[0]):
        least = hear(k, old, graph)
        if cost_m(least, graph) > cost_m(old[k], graph):
            least = graph.far_m
        own = told_offer(offer_of(k, graph), old[k], graph)
        new[k] = least if is_better(least, own, graph) else own


@allocation_free
def settle_offers(step: int, graph: Any, settled: Any) -> None:
    """Write (k,) what ``pass_on_offers`` comes to while nobody moves, from the offers that are told at a step."""
    n, told = graph.x.shape[0], graph.away_m[step % 2]
    for k in range(n):
        settled[k] = told[k] if told[k] == level_of(told[k], graph) * graph.way_m else graph.far_m
    changes = True
    while changes:
        changes = False
        for k in range(n):
            least = hear(k, settled, graph)
            if is_better(least, settled[k], graph):
                settled[k], changes = least, True


@allocation_free
def worth_of_offer(away_m: float, graph: Any) -> float:
    """The importance that a cost stands for, less what the way to it counts; 0 where nothing is offered."""
    return graph.most * (1.0 - away_m / graph.dear_m) if away_m < graph.dear_m else 0.0
