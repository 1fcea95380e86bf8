"""What this Rota can do: its planners with their efforts, and the formats it exports to."""

from __future__ import annotations

import json
from importlib import import_module
from importlib.metadata import version

from rota.files.mission_file import mission_schema
from rota.links.names import LINKS
from rota.model.planner_settings import settings_of
from rota.planning.planner import loadable_planners, planner_named
from rota.web.refusal import Json
from rota.web.tasks.context import Context
from rota.web.tasks.export import formats_json, settings_json


def about(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """What GET /api/about answers, but for what only the server knows."""
    planners = []
    for name in loadable_planners():
        settings = {item.name: item for item in settings_of(planner_named(name).settings)}
        efforts = list(settings["effort"].options) if "effort" in settings else None
        planners.append({"name": name, "efforts": efforts})
    told = {"version": version("rota"), "planners": planners, "formats": formats_json(), "links": links_json()}
    return {}, json.dumps(told).encode()


def links_json() -> list[Json]:
    """The links to robots, each with its settings."""
    return [
        {"name": name, "what": what, "settings": settings_json(import_module(module).SETTINGS)}
        for name, (module, what) in LINKS.items()
    ]


def mission_schema_text(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """What GET /api/schema/mission answers."""
    return {}, json.dumps(mission_schema()).encode()
