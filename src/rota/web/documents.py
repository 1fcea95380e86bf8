"""Missions as JSON, read without spending more than their bytes: depth, numbers and the count of points."""

from __future__ import annotations

import json
from typing import Any

from rota.files.json_text import unique_keys
from rota.files.yaml_text import MOST_NESTED
from rota.web.refusal import Json, Refusal


def document_from(text: bytes) -> Json:
    """A mission's document from JSON text; Refusal for what is none."""

    def refuse(constant: str) -> Any:
        raise Refusal(400, f"{constant} is no number of JSON; numbers must be finite")

    try:
        document = json.loads(text, parse_constant=refuse, object_pairs_hook=unique_keys)
    except RecursionError:
        raise Refusal(400, f"the JSON is nested too deep; {MOST_NESTED} levels are allowed") from None
    except ValueError as error:  # also bytes that are no UTF-8, and endless numbers
        raise Refusal(400, f"the body is not JSON: {error}") from None
    if not isinstance(document, dict):
        raise Refusal(400, f"the body is a JSON {type(document).__name__}; an object is needed")
    return document


def require_few_vertices(value: Any, most: int) -> None:
    """Refuse a document with more typed points than allowed, or nested deeper than any mission."""
    count = 0
    stack: list[tuple[Any, int]] = [(value, 0)]
    while stack:
        item, depth = stack.pop()
        if depth > MOST_NESTED:
            raise Refusal(422, f"lists or objects are nested deeper than {MOST_NESTED} levels")
        if isinstance(item, dict):
            stack.extend((inner, depth + 1) for inner in item.values())
        elif isinstance(item, list):
            if len(item) == 2 and all(isinstance(part, int | float) for part in item):
                count += 1
            else:
                stack.extend((inner, depth + 1) for inner in item)
    if count > most:
        raise Refusal(413, f"{count:,} points are drawn; at most {most:,} are allowed: simplify the shapes")
