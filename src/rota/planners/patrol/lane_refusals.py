"""What patrol cannot plan for on lanes: robots come from place to place there, and see no ground from them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rota.model.motion_limits import MOTION_FIELDS
from rota.model.refusals import Where, every_motion, fleet_blocks, inner


def lane_refusals(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """Limits of motion and turning, starts, demands other than visits, and other methods, on lanes or in a graph."""
    is_graph = inner(data, "area", "graph") is not None
    if not (is_graph or data.get("lanes")):
        return
    driving_fields = (*MOTION_FIELDS, "turn_rate_rad_s", "turn_radius_m")
    yield from every_motion(data, driving_fields, "on lanes robots turn and change their speed at once: remove it")
    for where, block in fleet_blocks(data):
        for name in ("start", "entrances"):
            if inner(block, name) is not None:
                yield (*where, name), "on lanes robots begin where their rounds do: remove it"
    if inner(data, "patrol", "method") not in (None, "tours"):
        yield ("patrol", "method"), "on lanes only tours are planned"
    if inner(data, "patrol", "prefer") not in (None, "shortest"):
        yield ("patrol", "prefer"), "on lanes only the shortest rounds are looked for"
    if not is_graph and data.get("period_s") is not None:
        yield ("period_s",), "on lanes robots come to places: remove it, and give zones with demand: visit"
    zones = data.get("zones")
    for k, zone in enumerate(zones if isinstance(zones, list) else []):
        demand = inner(zone, "demand") or ("visit" if inner(zone, "place") is not None else "every_point")
        if inner(zone, "period_s") is not None and demand != "visit":
            yield ("zones", k, "demand"), "on lanes robots come to places: write demand: visit"
