"""Settings of planners in mission and plan files: the reader of a block and its JSON Schema, both made from it.

``Setting`` of ``rota.model.planner_settings`` is where a setting is declared.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Annotated, Any

from pydantic import PlainValidator, ValidationError, WithJsonSchema
from pydantic_core import InitErrorDetails, PydanticCustomError

from rota.files.schema_block import nearest_key
from rota.model.planner_settings import Setting, Settings, settings_of
from rota.model.refusals import Where, refusal

JsonSchema = dict[str, Any]
_BOUNDS = {"ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum"}


def settings_field(block: type[Settings], *, in_mission_file: bool) -> Any:
    """The type of a field that holds a block: its values by name, those that are given; None where there is none."""

    def read(data: Any) -> dict[str, Any] | None:
        return None if data is None else _values(block, data, in_mission_file)

    schema = settings_json_schema(block, in_mission_file=in_mission_file)
    return Annotated[Any, PlainValidator(read), WithJsonSchema({"anyOf": [schema, {"type": "null"}]})]


# ---------------------------------------------------------------- reading


def _values(block: type[Settings], data: Any, in_mission_file: bool) -> dict[str, Any]:
    """The values that a block gives, by name. Raises ValidationError with every fault at its place."""
    if not isinstance(data, dict):
        raise _refused(block, [_line((), refusal("model_type", data, {}), data)])
    items = {item.name: item for item in settings_of(block)}
    lines = [
        _line((key,), f"unknown key; {nearest_key(str(key), list(items))}", data[key], "unknown_key")
        for key in data
        if key not in items
    ]
    values: dict[str, Any] = {}
    unclear = False
    for name, item in items.items():
        if name not in data:
            if not in_mission_file and not item.newer:
                lines.append(_line((name,), refusal("missing", None, {}), None))
            continue
        faults = list(_faults(item, data[name], in_mission_file))
        lines += faults
        unclear |= bool(faults) and item.kind == "option"
        if not faults and (data[name] is not None or item.optional):
            values[name] = _value(item, data[name], in_mission_file)
    if in_mission_file and not unclear:
        for find in (block.contradictions, block.unused):
            lines += [_line(where, message, data) for where, message in find(values)]
    if lines:
        raise _refused(block, lines)
    return values


def _faults(item: Setting, value: Any, in_mission_file: bool) -> Iterator[InitErrorDetails]:
    if item.block is not None:
        if value is None and in_mission_file:
            return
        try:
            _values(item.block, value, in_mission_file)
        except ValidationError as error:
            for line in error.errors(include_url=False):
                yield _line((item.name, *line["loc"]), line["msg"], line["input"], line["type"])
        return
    for where, part, fault in item.faults(value, in_mission_file):
        message = refusal(fault.kind, part, fault.given, fault.given.get("message", ""))
        yield _line((item.name, *where), message, part)


def _value(item: Setting, value: Any, in_mission_file: bool) -> Any:
    if item.block is not None:
        return item.block(**_values(item.block, value, in_mission_file))
    if item.word is not None and value == item.word:
        return ()
    return float(value) if item.kind == "number" and value is not None else value


def _line(where: Where, message: str, value: Any, kind: str = "fault") -> InitErrorDetails:
    return InitErrorDetails(type=PydanticCustomError(kind, "{message}", {"message": message}), loc=where, input=value)


def _refused(block: type[Settings], lines: list[InitErrorDetails]) -> ValidationError:
    return ValidationError.from_exception_data(block.__name__, lines)


# ---------------------------------------------------------------- JSON Schema


def settings_json_schema(block: type[Settings], *, in_mission_file: bool) -> JsonSchema:
    """The JSON Schema of a block: of what people may write, or of what plan files hold."""
    items = settings_of(block)
    schema: JsonSchema = {
        "type": "object",
        "description": (block.__doc__ or "").partition("\n")[0],
        "properties": {item.name: _property(item, in_mission_file) for item in items},
        "additionalProperties": False,
    }
    required = [] if in_mission_file else [item.name for item in items if not item.newer]
    return schema | ({"required": required} if required else {})


def _property(item: Setting, in_mission_file: bool) -> JsonSchema:
    schema = _type(item, in_mission_file)
    default = list(item.default) if isinstance(item.default, tuple) else item.default
    may_be_null = item.optional or (in_mission_file and (item.empty or item.block is not None))
    if may_be_null:
        schema = {"anyOf": [schema, {"type": "null"}]}
    if in_mission_file or item.newer:
        schema["default"] = None if may_be_null else asdict(item.block()) if item.block else default
    return schema | ({"description": item.meaning} if item.meaning else {})


def _type(item: Setting, in_mission_file: bool) -> JsonSchema:
    if item.block is not None:
        return settings_json_schema(item.block, in_mission_file=in_mission_file)
    if item.kind == "option":
        return {"type": "string", "enum": list(item.options)}
    if item.kind in ("truth", "text"):
        return {"type": "boolean" if item.kind == "truth" else "string"}
    bounds = {_BOUNDS[name]: bound for name, bound in item.bounds(in_mission_file).items()}
    number = {"type": "integer" if item.kind == "whole" or item.whole else "number", **bounds}
    if item.kind == "pair":
        return {"type": "array", "items": number, "minItems": 2, "maxItems": 2}
    if item.kind != "list":
        return number
    listed = {"type": "array", "items": number, "minItems": 1}
    return listed if item.word is None else {"anyOf": [{"const": item.word}, listed]}
