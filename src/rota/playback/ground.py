"""A mission's ground as JSON for maps: area, obstacles and zones in local metres."""

from __future__ import annotations

from rota.files.mission_json import mission_to_json
from rota.model.field_values import Json
from rota.model.mission import Mission


def ground_to_json(mission: Mission) -> Json:
    """Area, obstacles, zones and the period outside zones as plan files have them; the origin, null without one."""
    whole = mission_to_json(mission)
    return {name: whole[name] for name in ("area", "obstacles", "zones", "period_s", "origin")}
