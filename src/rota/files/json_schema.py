"""JSON Schemas (draft 2020-12) of files, made of the blocks that read them."""

from __future__ import annotations

import json
from dataclasses import asdict, is_dataclass
from typing import Any

from rota.files.blocks import Block
from rota.model.fields import REQUIRED, Field

JsonSchema = dict[str, Any]
_BOUNDS = {"ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum"}
_TYPES = {"number": "number", "whole": "integer", "truth": "boolean", "text": "string"}


def file_schema(block: Block, title: str) -> JsonSchema:
    """The schema of a file that is one block."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **block_schema(block), "title": title}


def block_schema(block: Block) -> JsonSchema:
    """The schema of a block."""
    needed = [item.name for item in block.fields if item.needed]
    return {
        "type": "object",
        "description": block.meaning,
        "properties": {item.name: _property(item) for item in block.fields},
        **({} if block.is_open else {"additionalProperties": False}),
        **({"required": needed} if needed else {}),
        **block.says,
    }


def _property(item: Field) -> JsonSchema:
    """The schema of a field, with its default where it need not be given."""
    schema = _type(item)
    if item.optional:
        schema = {"anyOf": [schema, {"type": "null"}]}
    if not item.needed and item.default is not REQUIRED:
        default = asdict(item.default) if is_dataclass(item.default) else item.default  # type: ignore[arg-type]
        schema["default"] = json.loads(json.dumps(default))  # lists in place of tuples
    told = {"title": item.title, "description": item.meaning}
    return schema | {key: text for key, text in told.items() if text} | dict(item.says)


def _type(item: Field) -> JsonSchema:
    """What the values of a field are."""
    if item.kind == "block":
        return block_schema(item.block)
    if item.kind == "either":
        return {"anyOf": [_type(each) for each in item.choices]}
    if item.kind == "option":
        texts = all(isinstance(option, str) for option in item.options)
        return {**({"type": "string"} if texts else {}), "enum": list(item.options)}
    least, most = item.count or (None, None)
    if item.item is not None:
        ends = {"minItems": 1 if item.count is None else least, "maxItems": most}
        listed = {"type": "array", "items": _type(item.item), **{key: end for key, end in ends.items() if end}}
        return listed if item.word is None else {"anyOf": [{"const": item.word}, listed]}
    if item.kind not in _TYPES:
        return {}
    ends = {"minLength": least} if item.kind == "text" and least else {}
    bounds = {_BOUNDS[name]: bound for name, bound in item.bounds(in_mission_file=False).items()}
    return {"type": _TYPES[item.kind], **ends, **bounds}
