"""The OpenAPI 3.1 document, made of the operations and of the schemas that Rota publishes."""

from __future__ import annotations

import json
import re
from http import HTTPStatus
from importlib.metadata import version
from typing import Any

from rota.check.report_schema import report_schema
from rota.files.mission_file import mission_schema
from rota.files.plan_schema import plan_schema
from rota.web.interface.operations import OPERATIONS, UPLOAD, Operation
from rota.web.interface.values import VALUES, Schema, ref
from rota.web.refusal import Json
from rota.web.tasks.context import Context

EVERYWHERE = (400, 401, 403, 429, 503, 507)
_PARAMETER = re.compile(r"\{(\w+)\}")


def openapi(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """What GET /openapi.json answers."""
    return {}, json.dumps(document()).encode()


def document() -> Json:
    """The document."""
    paths: dict[str, Json] = {}
    for operation in OPERATIONS:
        paths.setdefault(operation.path, {})[operation.method.lower()] = _describe(operation)
    return {
        "openapi": "3.1.0",
        "info": {
            "title": "Rota",
            "version": version("rota"),
            "description": "What the page of `rota serve` uses. Lengths are metres, times seconds.",
        },
        "paths": paths,
        "components": {
            "schemas": _schemas(),
            "securitySchemes": {
                "token": {"type": "http", "scheme": "bearer", "description": "only where --host lets others in"},
                "cookie": {"type": "apiKey", "in": "cookie", "name": "rota-token"},
            },
        },
        "security": [{}, {"token": []}, {"cookie": []}],
    }


def _describe(operation: Operation) -> Json:
    """An operation as OpenAPI describes it."""
    answer: Json = {"description": HTTPStatus(operation.status).phrase}
    if operation.gives is not None:
        answer["content"] = {operation.kind: {"schema": operation.gives}}
    error = {"content": {"application/json": {"schema": ref("Error")}}}
    refused = {str(s): {"description": HTTPStatus(s).phrase, **error} for s in (*EVERYWHERE, *operation.refuses)}
    told: Json = {
        "summary": operation.what,
        "tags": [operation.subject],
        "operationId": _name(operation),
        "responses": {str(operation.status): answer, **dict(sorted(refused.items()))},
    }
    parameters = [
        {"name": name, "in": "path", "required": True, "schema": {"type": "string", "minLength": 1}}
        for name in _PARAMETER.findall(operation.path)
    ]
    parameters += [
        {"name": name, "in": "query", "schema": schema, "description": what} for name, schema, what in operation.query
    ]
    if parameters:
        told["parameters"] = parameters
    if operation.body is not None:
        told["requestBody"] = {"required": True, "content": {"application/json": {"schema": operation.body}}}
    if operation.uploads:
        files = {"type": "object", "additionalProperties": {"type": "string", "contentMediaType": "*/*"}}
        told["requestBody"] = {"required": True, "content": {UPLOAD: {"schema": files}}}
    return told


def _name(operation: Operation) -> str:
    """A name for programs: the method and the words of the path."""
    words = re.findall(r"[a-z]+", operation.path.removeprefix("/api"))
    return "_".join([operation.method.lower(), *(words or ["page"])])


def _schemas() -> dict[str, Schema]:
    """All named schemas; those that Rota publishes bring their own parts along."""
    schemas = dict(VALUES)
    for name, schema in (("MissionFile", mission_schema()), ("PlanFile", plan_schema()), ("Report", report_schema())):
        parts = {f"{name}.{part}": inner for part, inner in schema.pop("$defs", {}).items()}
        schema.pop("$schema", None)
        for key, inner in {name: schema, **parts}.items():
            schemas[key] = _with_refs_into(inner, name)
    return schemas


def _with_refs_into(schema: Any, name: str) -> Any:
    """A schema whose references to its own parts lead to where those stand in the document."""
    if isinstance(schema, list):
        return [_with_refs_into(item, name) for item in schema]
    if not isinstance(schema, dict):
        return schema
    found = {key: _with_refs_into(value, name) for key, value in schema.items()}
    if isinstance(target := found.get("$ref"), str):
        found["$ref"] = target.replace("#/$defs/", f"#/components/schemas/{name}.")
    return found
