"""What patrol cannot plan for of robots whose batteries run low."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rota.model.refusals import Where, fleet_blocks, inner
from rota.planners.patrol.lane_refusals import DRIVING_FIELDS


def charging_refusals(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """Limits of motion and turning, starts and lanes, where robots have an endurance."""
    fleet, (_, *listed) = inner(data, "fleet"), fleet_blocks(data)
    refused: dict[Where, str] = {}
    at_once = "robots that charge turn and change their speed at once: remove it, or endurance_s"
    for where, block in listed or [(("fleet",), fleet)]:
        told = {name: (where if inner(block, name) is not None else ("fleet",)) for name in (*DRIVING_FIELDS, "start")}
        values = {name: inner(block, name) if told[name] == where else inner(fleet, name) for name in told}
        if inner(block, "endurance_s") is None and inner(fleet, "endurance_s") is None:
            continue
        refused |= {(*told[name], name): at_once for name in DRIVING_FIELDS if values[name] not in (None, 0, "none")}
        if values["start"] is not None:
            refused[(*told["start"], "start")] = "robots that charge begin anywhere on their flights: remove it"
        if data.get("lanes") or inner(data, "area", "graph") is not None:
            refused["fleet", "endurance_s"] = "on lanes no charging is planned: remove it"
    yield from refused.items()
