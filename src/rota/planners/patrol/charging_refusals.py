"""What patrol cannot plan for of robots whose batteries run low."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rota.model.refusals import Where, fleet_blocks, inner
from rota.planners.patrol.lane_refusals import DRIVING_FIELDS

RUNNING_DOWN = ("endurance_s", "battery")  # by which robots have batteries that run low


def charging_refusals(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """Limits of motion and turning, starts and lanes, where robots have an endurance."""
    fleet, (_, *listed) = inner(data, "fleet"), fleet_blocks(data)
    refused: dict[Where, str] = {}
    for where, block in listed or [(("fleet",), fleet)]:
        told = {name: (where if inner(block, name) is not None else ("fleet",)) for name in (*DRIVING_FIELDS, "start")}
        values = {name: inner(block, name) if told[name] == where else inner(fleet, name) for name in told}
        told_by = next((name for name in RUNNING_DOWN if inner(block, name) or inner(fleet, name)), None)
        if told_by is None:
            continue
        at_once = f"robots that charge turn and change their speed at once: remove it, or {told_by}"
        refused |= {(*told[name], name): at_once for name in DRIVING_FIELDS if values[name] not in (None, 0, "none")}
        if values["start"] is not None:
            refused[(*told["start"], "start")] = "robots that charge begin anywhere on their flights: remove it"
        if data.get("lanes") or inner(data, "area", "graph") is not None:
            refused["fleet", told_by] = "on lanes no charging is planned: remove it"
    yield from refused.items()
