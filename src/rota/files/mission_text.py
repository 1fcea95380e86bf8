"""A mission's document as a YAML file that people can read on: a key a line, short values in one line."""

from __future__ import annotations

import json
import re
from typing import Any

LONGEST_LINE = 110
_PLAIN = re.compile(r"[A-Za-z][A-Za-z0-9_]*([ -][A-Za-z0-9_]+)*")
_WORDS = re.compile(r"(?i)null|true|false|yes|no|on|off|y|n|\.?inf|\.?nan")
_UNPRINTABLE = re.compile("[\x7f-\x9f\u2028\u2029\ufeff\ufffe\uffff\ud800-\udfff]")
_MAP = re.compile(r"[.#]+(\n[.#]+)*\n?")


def mission_text(document: dict[str, Any]) -> str:
    """The file's text, which reads back as the document: keys in its order, all digits of its numbers.

    document: dicts, lists, text, finite numbers, truth values and None, as JSON has them.
    """
    return "".join(f"{line}\n" for line in _mapping(document, ""))


def _mapping(values: dict[str, Any], indent: str) -> list[str]:
    """The lines of a mapping."""
    lines: list[str] = []
    for key, value in values.items():
        lines += _entry(f"{indent}{_scalar(key)}:", value, indent + "  ")
    return lines


def _entry(head: str, value: Any, indent: str) -> list[str]:
    """A value behind ``head``: beside it where that is short, otherwise in lines below it, indented."""
    if isinstance(value, str) and "\n" in value and _MAP.fullmatch(value):
        keep = "" if value.endswith("\n") else "-"
        return [f"{head} |{keep}", *(f"{indent}{line}" for line in value.splitlines())]
    flow = value_in_a_line(value)
    if len(head) + len(flow) < LONGEST_LINE or not isinstance(value, dict | list):
        return [f"{head} {flow}"]
    if isinstance(value, dict):
        return [head, *_mapping(value, indent)]
    if all(_is_point(item) for item in value):
        return [head, *_points(value, indent)]
    return [head, *(line for item in value for line in _item(item, indent))]


def _item(item: Any, indent: str) -> list[str]:
    """One item of a list, behind a dash."""
    lines = _entry(f"{indent}-", item, indent + "  ")
    if len(lines) > 1 and isinstance(item, dict) and lines[0] == f"{indent}-":
        return [f"{indent}- {lines[1].lstrip()}", *lines[2:]]
    return lines


def _points(points: list[Any], indent: str) -> list[str]:
    """A list of points in lines that are not too long."""
    lines, line = [], f"{indent}["
    for k, point in enumerate(points):
        text = value_in_a_line(point) + ("," if k < len(points) - 1 else "]")
        if len(line) + len(text) > LONGEST_LINE:
            lines.append(line.rstrip())
            line = f"{indent} "
        line += text + " "
    return [*lines, line.rstrip()]


def _is_point(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(isinstance(part, int | float) for part in value)


def value_in_a_line(value: Any) -> str:
    """A value in one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_scalar(key)}: {value_in_a_line(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(value_in_a_line(item) for item in value) + "]"
    return _scalar(value)


def _scalar(value: Any) -> str:
    """Text, a number, a truth value or null."""
    if not isinstance(value, str):
        return json.dumps(value, allow_nan=False)
    if _PLAIN.fullmatch(value) and not _WORDS.fullmatch(value):
        return value
    return _UNPRINTABLE.sub(lambda mark: f"\\u{ord(mark[0]):04x}", json.dumps(value, ensure_ascii=False))
