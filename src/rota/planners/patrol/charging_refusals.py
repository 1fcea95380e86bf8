"""What patrol cannot plan for of robots whose batteries run low."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rota.model.fields import flat_fields_of
from rota.model.fleet import Abilities
from rota.model.motion_limits import MOTION_FIELDS
from rota.model.refusals import Where, every_motion, fleet_blocks, inner, listed_robots

AT_ONCE = "robots that charge turn and change their speed at once: remove it, or endurance_s"
ALIKE = "robots that relieve each other are alike: give it for the fleet"
ABLE = tuple(item.name for item in flat_fields_of(Abilities))


def charging_refusals(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """Limits of motion and turning, starts, lanes, and what single robots can do, where robots have an endurance."""
    if not any(inner(block, "endurance_s") is not None for _, block in fleet_blocks(data)):
        return
    yield from every_motion(data, [*MOTION_FIELDS, "turn_rate_rad_s", "turn_radius_m"], AT_ONCE)
    for where, block in fleet_blocks(data):
        if inner(block, "start") is not None:
            yield (*where, "start"), "robots that charge begin anywhere on their flights: remove it"
    for k, robot in enumerate(listed_robots(data)):
        for name in ABLE:
            if inner(robot, name) is not None:
                yield ("fleet", "robots", k, name), ALIKE
    if data.get("lanes") or inner(data, "area", "graph") is not None:
        yield ("fleet", "endurance_s"), "on lanes no charging is planned: remove it"
