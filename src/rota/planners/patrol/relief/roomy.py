"""Cycles at chargers that have places for the robots that are at them on average."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

from rota.model.arrays import Floats
from rota.model.battery_limits import BatteryLimits
from rota.planners.patrol.relief.shifts import Clearance, Cycle, best_cycle
from rota.planners.patrol.relief.slots import Handovers, Slot, chargers_by_way


def cycles_with_room(
    slots: Sequence[Slot],
    handovers: Sequence[Sequence[Handovers]],
    battery: BatteryLimits,
    clearance: Clearance,
    turns_s: Floats | None,
) -> list[tuple[Cycle, ...]]:
    """A cycle for each charger in use that has places for its robots on average: those of few robots first.

    handovers: of each slot, for each charger. Slots are shared among chargers in all ways, where these are few; else
    each is served from the nearest charger, or all are from one.
    """
    found: list[tuple[Cycle, ...]] = []
    numbers = range(len(handovers[0]))
    dealt = {tuple(chargers_by_way(own)[0] for own in handovers)}
    dealt |= {(number,) * len(slots) for number in numbers}
    if len(numbers) ** len(slots) <= 64:
        dealt |= set(itertools.product(numbers, repeat=len(slots)))
    for chargers in sorted(dealt):
        members = [[k for k, own in enumerate(chargers) if own == charger] for charger in sorted(set(chargers))]
        each = [
            list(_cycles_at([every[chargers[own[0]]] for every in handovers], slots, own, battery, clearance, turns_s))
            for own in members
        ]
        found += itertools.product(*each)
    return sorted(found, key=lambda cycles: sum(cycle.robots for cycle in cycles))


def _cycles_at(
    handovers: Sequence[Handovers], slots: Sequence[Slot], members: Sequence[int], battery: BatteryLimits,
    clearance: Clearance, turns_s: Floats | None,
) -> Iterator[Cycle]:  # fmt: skip
    """Cycles of some slots, by their numbers, at the charger of these handovers, which has places for their robots."""
    # in a pause of more than two ways both robots that change are at the charger at once
    for most_pause_ways in (math.inf, 2.0):
        cycle = best_cycle(
            slots, handovers, members, battery, clearance, places=handovers[0].charger.places,
            most_pause_ways=most_pause_ways, turns_s=turns_s,
        )  # fmt: skip
        if cycle is not None:
            yield cycle
