"""One wording for all that is refused: the place, the value and what is allowed there."""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rota.errors import MissionError

Where = tuple[str | int, ...]
# control characters, separators of lines and paragraphs, marks of the writing direction, halves of characters
_STEERING = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff]")

_NEEDED = {
    "float_type": "a number",
    "finite_number": "a finite number",
    "int_type": "a whole number",
    "string_type": "text",
    "tuple_type": "a list of numbers",
    "list_type": "a list",
    "model_attributes_type": "a mapping of keys to values",
    "model_type": "a mapping of keys to values",
}
_COMPARED = {
    "greater_than": ("gt", "must be greater than {}"),
    "greater_than_equal": ("ge", "must be at least {}"),
    "less_than": ("lt", "must be less than {}"),
    "less_than_equal": ("le", "must be at most {}"),
}


def refusal(kind: str, value: Any, given: Mapping[str, Any], otherwise: str = "") -> str:
    """What is said of a value. kind, given: the kind of fault and the numbers that it speaks of.

    ``otherwise`` is said of kinds that have no words here.
    """
    if kind == "missing":
        return "is missing; it is required"
    if kind in _NEEDED:
        needed = _NEEDED[kind]
        quoted = isinstance(value, str) and needed.endswith("number") and _reads_as_number(value, needed)
        unquoted = needed == "text" and isinstance(value, int | float | None)
        hint = "; remove the quotes" if quoted else "; put it in quotes" if unquoted else ""
        return f"{show_value(value)} is not allowed; {needed} is needed{hint}"
    if kind in _COMPARED:
        key, allowed = _COMPARED[kind]
        return f"{show_value(value)} is not allowed; it {allowed.format(f'{given[key]:.9g}')}"
    if kind == "literal_error":
        others = f"; {given['elsewhere']}" if given.get("elsewhere") else ""
        return f"{show_value(value)} is not allowed; {str(given['expected']).replace(chr(39), '')} is needed{others}"
    if kind == "too_long" and (given.get("exact") or given.get("field_type") == "Tuple"):
        return f"{show_value(value)} is too long; {given['max_length']} numbers are needed"
    if kind == "too_short" and "exact" in given:
        needed = f"{given['min_length']} numbers" if given["exact"] else f"at least {given['min_length']} entries"
        return f"{show_value(value)} is too short; {needed} are needed"
    if kind in ("too_short", "string_too_short"):
        return f"{show_value(value)} is not allowed; it must not be empty"
    if kind == "too_long":
        return f"has {given['actual_length']} entries; at most {given['max_length']} are allowed"
    if kind == "bool_type":
        return f"{show_value(value)} is not allowed; true or false is needed"
    if kind == "wrong_kind":
        return f"{show_value(value)} is not allowed; {otherwise}"
    return otherwise


def _reads_as_number(text: str, needed: str) -> bool:
    """Whether the text is such a number without its quotes; YAML takes nan and inf for text, quotes or none."""
    try:
        return math.isfinite(int(text) if needed == _NEEDED["int_type"] else float(text))
    except ValueError:
        return False


def show_value(value: Any) -> str:
    """A value as a mission file writes it, shortened."""
    if isinstance(value, float):
        return f"{value:.12g}" if math.isfinite(value) else f"{value:.1f}".replace("inf", ".inf").replace("nan", ".nan")
    text = json.dumps(value, ensure_ascii=False, default=str)
    return shorten(text if text.isprintable() else json.dumps(value, default=str))


def shorten(text: str) -> str:
    """The text, or its beginning where it is long."""
    return text if len(text) <= 60 else text[:56] + " ..."


def path_of(place: Where) -> str:
    """A place as people write it, as in ``zones[2].shape``."""
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in place).lstrip(".")


def require(ok: bool, where: str, value: object, allowed: str) -> None:
    """Raise MissionError that names the place, the value and what is allowed, unless all is well."""
    if not ok:
        raise MissionError(f"{where}: {repr(value).removesuffix('.0')} is not allowed; {allowed}")


def require_positive(where: str, value: float, most: float = sys.float_info.max) -> None:
    """Raise MissionError for what is not a finite number greater than 0, and at most ``most``."""
    allowed = f" and at most {most:g}" if most < sys.float_info.max else ""
    require(0 < value <= most, where, value, "must be a finite number greater than 0" + allowed)


def require_text(where: str, name: str) -> None:
    """Raise MissionError for a name that is empty, that no file can hold, or that steers the terminal that shows it.

    Control characters move the cursor or begin a line; marks of the writing direction turn round what stands beside.
    """
    require(bool(name.strip()), where, name, "must not be empty, nor blank")
    halves = [letter for letter in name if 0xD800 <= ord(letter) <= 0xDFFF]
    require(not halves, where, name, "must be text; lone surrogates are half a character each")
    allowed = "must be one line of text, without control characters and marks of the writing direction"
    require(_STEERING.search(name) is None, where, name, allowed)


def escape(text: str) -> str:
    """The text with ``\\x1b`` and the like in place of what steers a terminal, and of halves of characters."""
    return _STEERING.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


# ---------------------------------------------------------------- what planners cannot use of a mission


def inner(data: Any, *keys: str) -> Any:
    """The value under keys inside each other; None where there is none."""
    for key in keys:
        data = data.get(key) if isinstance(data, dict) else None
    return data


def listed_robots(data: Mapping[str, Any]) -> list[Any]:
    """The robots of a mission as written that are listed by name; none where a number of them is asked for."""
    robots = inner(data, "fleet", "robots")
    return robots if isinstance(robots, list) else []


def robot_count(data: Mapping[str, Any]) -> int | None:
    """How many robots a mission as written has; None: as few as possible."""
    robots = inner(data, "fleet", "robots")
    return len(robots) if isinstance(robots, list) else robots if isinstance(robots, int) else None


def fleet_blocks(data: Mapping[str, Any]) -> list[tuple[Where, Any]]:
    """The fleet's block, and those of each listed robot and each kind, with their places."""
    listed: list[tuple[Where, Any]] = [(("fleet", "robots", k), robot) for k, robot in enumerate(listed_robots(data))]
    kinds = inner(data, "fleet", "kinds")
    listed += [(("fleet", "kinds", k), kind) for k, kind in enumerate(kinds if isinstance(kinds, list) else [])]
    return [(("fleet",), inner(data, "fleet")), *listed]


def every_stated(data: Mapping[str, Any], field: str, message: str) -> Iterator[tuple[Where, str]]:
    """The message for each period or importance, by its field's name, that a mission as written states."""
    if data.get(field) is not None:
        yield (field,), message
    zones = data.get("zones")
    for k, zone in enumerate(zones if isinstance(zones, list) else []):
        if inner(zone, field) is not None:
            yield ("zones", k, field), message


def every_change_of_presence(data: Mapping[str, Any], message: str) -> Iterator[tuple[Where, str]]:
    """The message for each robot that joins or leaves."""
    for k, robot in enumerate(listed_robots(data)):
        for name in ("joins_s", "leaves_s"):
            if inner(robot, name):
                yield ("fleet", "robots", k, name), message


def every_choice_of_robots(data: Mapping[str, Any], message: str) -> Iterator[tuple[Where, str]]:
    """The message for kinds of robots, and for each zone that names the sensors that count."""
    if inner(data, "fleet", "kinds"):
        yield ("fleet", "kinds"), message
    zones = data.get("zones")
    for k, zone in enumerate(zones if isinstance(zones, list) else []):
        if inner(zone, "sensors"):
            yield ("zones", k, "sensors"), message


def every_motion(data: Mapping[str, Any], names: Sequence[str], message: str) -> Iterator[tuple[Where, str]]:
    """The message for each limit of motion, by these names, that a fleet or a robot has."""
    for where, block in fleet_blocks(data):
        for name in names:
            if inner(block, name) not in (None, 0, "none"):
                yield (*where, name), message
