"""What patrol cannot plan for of robots whose batteries run low."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rota.model.refusals import Where, fleet_blocks, inner
from rota.vehicles.presets import ON_MISSIONS


def charging_refusals(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """Copters on missions of their own, starts and lanes, where robots have an endurance."""
    fleet, (_, *listed) = inner(data, "fleet"), fleet_blocks(data)
    refused: dict[Where, str] = {}
    for where, block in listed or [(("fleet",), fleet)]:
        told = {name: (where if inner(block, name) is not None else ("fleet",)) for name in ("vehicle", "start")}
        values = {name: inner(block, name) if told[name] == where else inner(fleet, name) for name in told}
        told_by = next((name for name in ("endurance_s", "battery") if inner(block, name) or inner(fleet, name)), None)
        if told_by is None:
            continue
        if values["vehicle"] in ON_MISSIONS:
            refused[(*told["vehicle"], "vehicle")] = (
                "robots that charge are not planned for as their firmware flies missions: write arducopter-targets,"
                " whose timed targets rota fly sends"
            )
        if values["start"] is not None:
            refused[(*told["start"], "start")] = "robots that charge begin anywhere on their flights: remove it"
        if data.get("lanes") or inner(data, "area", "graph") is not None:
            refused["fleet", told_by] = "on lanes no charging is planned: remove it"
    yield from refused.items()
