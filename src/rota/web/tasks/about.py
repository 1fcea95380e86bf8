"""What this Rota can do: its planners with their efforts, and the formats it exports to."""

from __future__ import annotations

import json
from importlib.metadata import version

from rota.files.mission_file import mission_schema as schema_of_missions
from rota.planner import loadable_planners, planner_named
from rota.planner_settings import settings_of
from rota.web.refusal import Json
from rota.web.tasks.context import Context


def about(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """What GET /api/about answers, but for what only the server knows."""
    planners = []
    for name in loadable_planners():
        settings = {item.name: item for item in settings_of(planner_named(name).settings)}
        efforts = list(settings["effort"].options) if "effort" in settings else None
        planners.append({"name": name, "efforts": efforts})
    return {}, json.dumps({"version": version("rota"), "planners": planners, "formats": []}).encode()


def mission_schema(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """The JSON Schema of mission files, of which the page makes the planners' forms."""
    return {}, json.dumps(schema_of_missions()).encode()
