"""What pydantic finds wrong with a parsed file, in a newcomer's words and with positions."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from typing import Any, NamedTuple

from pydantic import ValidationError

from rota.files.yaml_text import Document, Place, shortened

_NEEDED = {
    "float_type": "a number",
    "finite_number": "a finite number",
    "int_type": "a whole number",
    "string_type": "text",
    "tuple_type": "a list of numbers",
    "list_type": "a list",
    "model_type": "a mapping of keys to values",
    "model_attributes_type": "a mapping of keys to values",
}


class Fault(NamedTuple):
    """What is wrong, what is allowed, and where; ``at_key``: the key itself is at fault, not its value."""

    place: Place
    message: str
    at_key: bool = False


_COMPARED = {
    "greater_than": ("gt", "must be greater than {}"),
    "greater_than_equal": ("ge", "must be at least {}"),
    "less_than": ("lt", "must be less than {}"),
    "less_than_equal": ("le", "must be at most {}"),
}


def schema_faults(document: Document, error: ValidationError) -> list[Fault]:
    """Every fault pydantic found: its place in the document, and what is wrong and what is allowed there."""
    found: list[Fault] = []
    for line in error.errors(include_url=False):
        place = tuple(step for step in line["loc"] if not str(step).startswith("<"))
        kind, value = line["type"], line["input"]
        if kind == "missing" and place and isinstance(place[-1], int):
            # a tuple that is too short: pydantic tells each missing number by itself
            if found and found[-1].place == place[:-1]:
                found.pop()
            message = f"{shown(value)} is too short; {int(place[-1]) + 1} numbers are needed"
            place = place[:-1]
        else:
            message = _message(kind, value, dict(line.get("ctx", {})), line["msg"])
        found.append(Fault(place, message, at_key=kind == "unknown_key"))
    return found


def positioned(document: Document, faults: Iterable[Fault]) -> list[str]:
    """One line ``file:line:column: path.to.field: message`` per fault, in the file's order, none twice."""
    ordered = sorted(faults, key=lambda fault: document.position(fault.place, key=fault.at_key))
    return list(dict.fromkeys(document.line(fault.place, fault.message, key=fault.at_key) for fault in ordered))


def _message(kind: str, value: Any, ctx: dict[str, Any], otherwise: str) -> str:
    if kind == "missing":
        return "is missing; it is required"
    if kind in _NEEDED:
        needed = _NEEDED[kind]
        quoted = isinstance(value, str) and needed.endswith("number") and _reads_as_number(value)
        unquoted = needed == "text" and isinstance(value, int | float | None)
        hint = "; remove the quotes" if quoted else "; put it in quotes" if unquoted else ""
        return f"{shown(value)} is not allowed; {needed} is needed{hint}"
    if kind in _COMPARED:
        key, allowed = _COMPARED[kind]
        return f"{shown(value)} is not allowed; it {allowed.format(f'{ctx[key]:.9g}')}"
    if kind == "literal_error":
        return f"{shown(value)} is not allowed; {str(ctx['expected']).replace(chr(39), '')} is needed"
    if kind == "too_long" and ctx.get("field_type") == "Tuple":
        return f"{shown(value)} is too long; {ctx['max_length']} numbers are needed"
    if kind in ("too_short", "string_too_short"):
        return f"{shown(value)} is not allowed; it must not be empty"
    if kind == "too_long":
        return f"has {ctx['actual_length']} entries; at most {ctx['max_length']} are allowed"
    if kind == "bool_type":
        return f"{shown(value)} is not allowed; true or false is needed"
    if kind == "wrong_kind":
        return f"{shown(value)} is not allowed; {otherwise}"
    return otherwise


def _reads_as_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def shown(value: Any) -> str:
    """A value as a mission file writes it, shortened."""
    if isinstance(value, float):
        return f"{value:.12g}" if math.isfinite(value) else f"{value:.1f}".replace("inf", ".inf").replace("nan", ".nan")
    text = json.dumps(value, ensure_ascii=False, default=str)
    return shortened(text if text.isprintable() else json.dumps(value, default=str))
