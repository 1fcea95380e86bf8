"""What a robot's battery holds, and the chargers at which it is filled. SI units, frozen."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

from shapely import MultiPolygon

from rota.model.field_values import check_fields
from rota.model.fields import field_of
from rota.model.fleet import Fleet, Place
from rota.model.limits import COORDINATE, DURATION, LARGEST_M, LONGEST_S
from rota.model.refusals import require_text
from rota.model.start_faults import TOUCH_M, standing_fault

MOST_PLACES = 100_000


@dataclass(frozen=True, kw_only=True)
class Charger:
    """Where robots charge, and how many at once.

    A robot that charges stands at ``at``, sees nothing and is in nobody's way. With a ``swap_s`` its battery is full
    after so long, however empty it was; otherwise it fills as the robot's ``recharge_s`` says.
    """

    first: ClassVar[tuple[str, ...]] = ("name",)
    name: str = field_of(count=((1, None),))
    at: Place = field_of(meaning="[x, y] where robots charge", least=-LARGEST_M, most=LARGEST_M, written=COORDINATE)
    places: int = field_of(1, "robots that it has room for at once", least=1, most=MOST_PLACES)
    swap_s: float | None = field_of(
        None,
        "after which a battery is full, as where it is swapped; null: it takes as long as recharge_s says",
        above=0,
        most=LONGEST_S,
        written=DURATION,
    )

    def __post_init__(self) -> None:
        check_fields(self, f"charger {self.name}: ")
        require_text("charger.name", self.name)


def charger_faults(
    area: MultiPolygon, blocking: Sequence[MultiPolygon], fleet: Fleet, chargers: Sequence[Charger]
) -> Iterator[tuple[str, str]]:
    """What is wrong with chargers, and with batteries that need some: the field at fault and a message."""
    robots = fleet.unlike_robots
    widest_m = max(robot.body_radius_m for robot in robots)
    counted = Counter(charger.name for charger in chargers)
    for k, charger in enumerate(chargers):
        x, y = charger.at
        if counted[charger.name] > 1:
            yield f"chargers[{k}].name", f"{charger.name!r} is not allowed; names must be unique"
        if wrong := standing_fault(charger.at, widest_m, area, blocking):
            yield f"chargers[{k}].at", f"[{x:.9g}, {y:.9g}] {wrong}"
    for (i, one), (k, other) in itertools.combinations(enumerate(chargers), 2):
        apart_m, need_m = math.dist(one.at, other.at), max(2 * widest_m - TOUCH_M, TOUCH_M)
        if apart_m < need_m:
            yield (
                f"chargers[{k}].at",
                f"[{other.at[0]:.9g}, {other.at[1]:.9g}] is {apart_m:.6g} m from chargers[{i}]; bodies need"
                f" {2 * widest_m:.6g} m, and no two may be in one place: give one of them more places",
            )
    run_down = [robot for robot in robots if robot.battery.endurance_s is not None]
    if run_down and not chargers:
        yield "chargers", "is missing: robots with an endurance_s need at least one charger, as {name: pad, at: [0, 0]}"
    if chargers and not run_down:
        yield "chargers", "nobody needs them: give robots an endurance_s, or remove them"
    for charger in (each for each in chargers if each.swap_s is None):
        if any(robot.battery.recharge_s is None for robot in run_down):
            yield (
                "fleet.recharge_s",
                f"is missing; charger {charger.name!r} swaps no batteries: give seconds, or it a swap_s",
            )
            break
