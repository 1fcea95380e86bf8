"""JSON Schemas of what the HTTP interface takes and gives; missions, plans and reports have their own."""

from __future__ import annotations

from typing import Any

Schema = dict[str, Any]

TEXT: Schema = {"type": "string"}
NUMBER: Schema = {"type": "number"}
COUNT: Schema = {"type": "integer", "minimum": 0}
TRUTH: Schema = {"type": "boolean"}
ANYTHING: Schema = {"type": "object"}
MOMENT: Schema = {"type": "string", "format": "date-time"}


def or_null(schema: Schema) -> Schema:
    """A value, or null."""
    return {"oneOf": [schema, {"type": "null"}]}


def list_of(schema: Schema) -> Schema:
    """A list of values."""
    return {"type": "array", "items": schema}


def ref(name: str) -> Schema:
    """One of the named schemas."""
    return {"$ref": f"#/components/schemas/{name}"}


def an_object(required: dict[str, Schema], optional: dict[str, Schema] | None = None) -> Schema:
    """An object with these fields and no others."""
    return {
        "type": "object",
        "properties": {**required, **(optional or {})},
        "required": list(required),
        "additionalProperties": False,
    }


FAULT = an_object({"field": TEXT, "path": list_of({"type": ["string", "integer"]}), "message": TEXT})
ATTACHMENT = an_object({"name": TEXT, "size": COUNT})
_SHAPE = {**list_of(list_of(list_of(list_of(NUMBER)))), "description": "polygons, each its rings, the outer one first"}
_ORIGIN = or_null(an_object({"lat": NUMBER, "lon": NUMBER}))
_CHANGE = {
    **or_null(an_object({"plan": TEXT, "at_s": NUMBER, "lost": list_of(TEXT)})),
    "description": "the plan that it takes over from, at which moment of its clock, and who is lost then",
}
_SETTINGS = list_of(an_object({"name": TEXT, "what": TEXT, "default": {}}))

VALUES: dict[str, Schema] = {
    "Error": an_object({"error": an_object({"message": TEXT, "faults": list_of(FAULT)})}),
    "About": an_object(
        {
            "version": TEXT,
            "planners": list_of(an_object({"name": TEXT, "efforts": or_null(list_of(TEXT))})),
            "formats": list_of(
                an_object(
                    {
                        "name": TEXT,
                        "what": TEXT,
                        "suffix": TEXT,
                        "needs_origin": TRUTH,
                        "takes_origin": TRUTH,
                        "has_clock": TRUTH,
                        "in_phase": or_null(TEXT),
                        "settings": _SETTINGS,
                    }
                )
            ),
            "links": list_of(an_object({"name": TEXT, "what": TEXT, "settings": _SETTINGS})),
            "limits": {"type": "object", "additionalProperties": NUMBER},
            "tile_url": or_null(TEXT),
            "tile_attribution": TEXT,
        }
    ),
    "Example": an_object({"name": TEXT, "title": TEXT}),
    "ReadMission": an_object(
        {"document": ANYTHING, "attachments": list_of(ATTACHMENT), "warnings": list_of(TEXT)},
        {
            "upload": TEXT,
            "features": {
                **list_of(an_object({"name": TEXT, "file": TEXT, "m2": NUMBER, "shape": _SHAPE})),
                "description": "of GeoJSON, all of which is the area: ask again with what each is",
            },
        },
    ),
    "MissionEntry": an_object({"id": TEXT, "name": TEXT, "revision": COUNT, "changed_at": MOMENT, "planner": TEXT}),
    "Mission": an_object(
        {
            "id": TEXT,
            "revision": {**COUNT, "description": "counted up by each change"},
            "name": TEXT,
            "planner": TEXT,
            "document": {
                **ANYTHING,
                "description": "a mission file as JSON, perhaps with faults",
            },
            "attachments": list_of(ATTACHMENT),
            "created_at": MOMENT,
            "changed_at": MOMENT,
        }
    ),
    "Ground": an_object(
        {
            "area": _SHAPE,
            "obstacles": list_of(
                an_object(
                    {"shape": _SHAPE, "blocks": {"enum": ["both", "motion", "sight"]}},
                    {"asks": {"enum": ["all", "nothing"], "description": "absent: all"}},
                )
            ),
            "zones": list_of(
                an_object(
                    {
                        "name": TEXT,
                        "period_s": or_null(NUMBER),
                        "demand": {"enum": ["every_point", "visit"]},
                        "shape": _SHAPE,
                    }
                )
            ),
            "origin": _ORIGIN,
        }
    ),
    "Validation": an_object(
        {
            "faults": list_of(FAULT),
            "warnings": list_of(FAULT),
            "ground": or_null(ref("Ground")),
            "bound": or_null(an_object({"robots": COUNT, "reason": TEXT})),
            "compiling": {**TRUTH, "description": "no bound yet: the loops that prove it are being compiled"},
            "free_m2": or_null(NUMBER),
            "asked_m2_s": or_null(NUMBER),
        }
    ),
    "Job": an_object(
        {
            "id": TEXT,
            "mission": or_null(TEXT),
            "mission_name": TEXT,
            "state": {"enum": ["queued", "running", "done", "no_plan", "failed", "stopped", "interrupted"]},
            "planner": TEXT,
            "effort": or_null(TEXT),
            "seed": COUNT,
            "time_limit_s": or_null(NUMBER),
            "revision": {**or_null(COUNT), "description": "of the mission when it was asked"},
            "change": _CHANGE,
            "created_at": MOMENT,
            "started_at": or_null(MOMENT),
            "ended_at": or_null(MOMENT),
            "progress": an_object(
                {
                    "fraction": {**NUMBER, "description": "of the work, 0..1; it never falls"},
                    "doing": TEXT,
                    "elapsed_s": NUMBER,
                    "left_s": {
                        **or_null(NUMBER),
                        "description": "about so long yet, by the rate so far; null: unknown",
                    },
                }
            ),
            "best": or_null(an_object({"robots": or_null(COUNT), "met": TRUTH, "plan": or_null(TEXT)})),
            "message": or_null(TEXT),
            "plan": or_null(TEXT),
            "place_in_queue": or_null(COUNT),
        }
    ),
    "Plan": {
        "type": "object",
        "properties": {
            "id": TEXT,
            "name": TEXT,
            "mission": or_null(TEXT),
            "job": or_null(TEXT),
            "planner": TEXT,
            "effort": or_null(TEXT),
            "created_at": MOMENT,
            "robots": COUNT,
            "bound": or_null(COUNT),
            "bound_reason": or_null(TEXT),
            "verdict": {"enum": ["met", "violated", "not proven"]},
            "worst_ratio": or_null(NUMBER),
            "length_m": NUMBER,
            "plan_s": or_null(NUMBER),
            "partial": {**TRUTH, "description": "its demand is not met, or its search was cut short"},
            "facts": list_of(TEXT),
            "revision": {**or_null(COUNT), "description": "of the mission that it was made of"},
            "change": _CHANGE,
            "stale": {**list_of(TEXT), "description": "what has changed in its mission since; empty: it still holds"},
            "report": ref("Report"),
        },
        "required": ["id", "name", "planner", "robots", "verdict", "length_m", "partial"],
    },
    "Watch": an_object(
        {
            "id": TEXT,
            "plan": TEXT,
            "link": TEXT,
            "state": {"enum": ["starting", "watching", "ended", "failed"]},
            "began_at": MOMENT,
            "message": or_null(TEXT),
        }
    ),
}
