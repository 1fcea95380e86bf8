"""JSON Schema of a report, version 1."""

from __future__ import annotations

from typing import Any, get_args

from rota.check.late_report import lateness_properties
from rota.check.margin_report import margin_properties
from rota.check.report import LISTED_POINTS
from rota.model.plan import EndReason
from rota.model.violation_kinds import ViolationKind

# what values a report has, as JSON Schema
NUMBER, TEXT, COUNT = {"type": "number"}, {"type": "string"}, {"type": "integer", "minimum": 0}
SIZE = {"type": "number", "minimum": 0}
OUTCOMES = {"enum": ["met", "violated", "not proven"]}
SECONDS_OR_NEVER = {"type": ["number", "null"], "description": "seconds; null: never"}


def _object(**properties: Any) -> dict[str, Any]:
    """A JSON schema of an object that has all of these properties and no others."""
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }


def report_schema() -> dict[str, Any]:
    """JSON Schema (2020-12) of what ``report_to_json`` returns, version 1."""
    ratio = {"type": ["number", "null"], "minimum": 0}
    report = _object(
        rota_report={"const": 1},
        verdict=OUTCOMES,
        robots=COUNT,
        lower_bound_robots={
            "type": ["integer", "null"],
            "minimum": 0,
            "description": "what the plan claims; the check does not prove it",
        },
        cells={
            "description": "of a floor that is to be covered",
            "oneOf": [{"type": "null"}, _object(entered=COUNT, of=COUNT)],
        },
        not_judged={"type": "array", "items": TEXT, "description": "what the plan says and the check leaves open"},
        first_coverage_s=SECONDS_OR_NEVER,
        holds_from_s={**SIZE, "description": "seconds from which on what is met is met in every period"},
        run_end=_run_end_schema(),
        holding={
            "description": "what a swarm has in range and sees through no wall where it holds, and ground that no robot"
            " can reach; null: the plan is of no swarm",
            "oneOf": [
                {"type": "null"},
                _object(
                    ground_m2=SIZE,
                    in_range_m2=SIZE,
                    seen_m2=SIZE,
                    unreached={"type": "array", "items": _object(x=NUMBER, y=NUMBER, area_m2=SIZE)},
                    importance_in_range={**ratio, "description": "share of the ground's; null: none is stated"},
                    in_range_least_m2={**ratio, "description": "over a loop; null: all robots stay"},
                    in_range_mean_m2={**ratio, "description": "over a loop; null: all robots stay"},
                ),
            ],
        },
        lateness={
            "description": "where it takes over from another plan, how late places are since; null: it does not",
            "oneOf": [{"type": "null"}, _lateness_schema()],
        },
        margins={
            "type": "array",
            "items": _object(**margin_properties()),
            "description": "of a plan that is met, the thinnest reserve of each kind, the thinnest first",
        },
        clock_margin_s={**ratio, "description": "by how much clocks may differ; null: by anything, or not judged"},
        worst_ratio={**ratio, "description": "no gap is longer than so many times its period; null: not shown"},
        worst_ratio_at_least={**ratio, "description": "some gap is so many times its period; null: for ever"},
        demands={"type": "array", "items": _demand_schema()},
        violations={"type": "array", "items": _violation_schema()},
        unmet_points=COUNT,
        unmet_points_m={
            "type": "array",
            "maxItems": LISTED_POINTS,
            "items": _object(x=NUMBER, y=NUMBER, demand=TEXT),
        },
    )
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "Rota report, version 1"}
    return {**head, **report}


def _run_end_schema() -> dict[str, Any]:
    """What a report says of the end of a run."""
    return {
        "description": "what the plan says of the end of a swarm's run; null: nothing",
        "oneOf": [
            {"type": "null"},
            _object(
                at_rest={"type": "boolean"},
                steps=COUNT,
                reason={"enum": list(get_args(EndReason))},
                blocked={"type": "array", "items": TEXT, "description": "robots that want to move on and cannot"},
            ),
        ],
    }


def _demand_schema() -> dict[str, Any]:
    """What a report says of one demand."""
    gap = SECONDS_OR_NEVER
    return _object(
        name=TEXT,
        period_s=NUMBER,
        demand={"enum": ["every_point", "visit"]},
        area_m2=SIZE,
        worst_gap_s={**gap, "description": "no point waits longer; null: some of it is never seen"},
        worst_gap_at_least_s={**gap, "description": "some point waits at least so long; null: for ever"},
        unseen_area_m2=SIZE,
        excluded_area_m2=SIZE,
        excluded_places={"type": "array", "items": _object(x=NUMBER, y=NUMBER, area_m2=SIZE)},
        undecided_cells=COUNT,
        outcome=OUTCOMES,
    )


def _violation_schema() -> dict[str, Any]:
    """What a report says of one violation."""
    return _object(
        kind={"type": "string", "enum": list(get_args(ViolationKind))},
        who=TEXT,
        place_m={"type": ["array", "null"], "items": NUMBER, "minItems": 2, "maxItems": 2},
        time_s=SECONDS_OR_NEVER,
        value={**SECONDS_OR_NEVER, "description": "in unit; null: without end"},
        limit=NUMBER,
        unit=TEXT,
        text=TEXT,
    )


def _lateness_schema() -> dict[str, Any]:
    """What a report says of how late places are."""
    whole, demand = lateness_properties()
    return _object(**whole, demands={"type": "array", "items": _object(**demand)})
