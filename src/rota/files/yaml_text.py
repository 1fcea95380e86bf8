"""YAML 1.2 and JSON text to plain values, remembering the line and column of every key and value."""

from __future__ import annotations

import json
import math
import re
import warnings
from dataclasses import dataclass
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, ReusedAnchorWarning
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from ruamel.yaml.scanner import Scanner

from rota.errors import MissionError
from rota.model.refusals import shorten

Place = tuple[str | int, ...]

MOST_VALUES = 2_000_000  # a few lines of aliases can stand for billions of values

MOST_NESTED = 64
_TOO_DEEP = f"lists or mappings are nested too deep; {MOST_NESTED} in each other are allowed"

_STANDARD = "tag:yaml.org,2002:"
# beside the core schema's, what ruamel's resolver makes of plain text such as dates and <<
_PLAIN_TAGS = {_STANDARD + kind for kind in ("null", "bool", "int", "float", "str", "timestamp", "merge", "value")}
_TAGS = _PLAIN_TAGS | {_STANDARD + "map", _STANDARD + "seq"}
# YAML 1.2.2, section 10.3.2: the core schema
_NULL = re.compile(r"null|Null|NULL|~|")
_BOOL = re.compile(r"true|True|TRUE|false|False|FALSE")
_INT = re.compile(r"[-+]?[0-9]+")
_OCTAL = re.compile(r"0o[0-7]+")
_HEXADECIMAL = re.compile(r"0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_INFINITY = re.compile(r"[-+]?\.(inf|Inf|INF)")
_NAN = re.compile(r"\.(nan|NaN|NAN)")
_LONGEST_EXACT = 18  # characters of an integer that a float holds about as well; the longest are beyond any float
_VERSION = re.compile(r"^%YAML[ \t]+(?!1\.[12][ \t\r]*$).*$", re.MULTILINE)
_BEYOND_UNICODE = re.compile(r"\\U(?!0010|000)[0-9a-fA-F]{8}")


@dataclass(frozen=True, kw_only=True)
class Document:
    """A parsed file: ``value`` is made of dicts, lists, str, int, float, bool and None only.

    ``values_at`` and ``keys_at`` give the (line, column), counted from 1, of the value or the key at a place;
    ``overridden`` are the places whose values come from elsewhere.
    """

    name: str
    value: Any
    values_at: dict[Place, tuple[int, int]]
    keys_at: dict[Place, tuple[int, int]]
    overridden: frozenset[Place] = frozenset()

    def position(self, place: Place, *, key: bool = False) -> tuple[int, int]:
        """(line, column) of the value (or its key) at ``place``; of what holds it where it is absent."""
        if key and place in self.keys_at:
            return self.keys_at[place]
        while place and place not in self.values_at:
            place = place[:-1]
        return self.values_at.get(place, (1, 1))

    def line(self, place: Place, message: str, *, key: bool = False) -> str:
        """One line ``file:line:column: path.to.field: message``."""
        line, column = self.position(place, key=key)
        field = f"{field_path(place)}: " if place else ""
        message = "".join(mark if mark.isprintable() else ascii(mark)[1:-1] for mark in message)
        if any(place[:depth] in self.overridden for depth in range(len(place) + 1)):
            return f"override: {field}{message}"
        return f"{self.name}:{line}:{column}: {field}{message}"


def field_path(place: Place) -> str:
    """``("zones", 0, "period_s")`` as ``zones[0].period_s``."""
    text = ""
    for step in place:
        if isinstance(step, int):
            text += f"[{step}]"
        else:
            key = shorten(step if step.isprintable() else json.dumps(step))
            text += f".{key}" if text else key
    return text


def parse_text(text: str, name: str, what: str) -> Document:
    """Parse YAML 1.2 or, when ``name`` ends in .json, JSON; ``name`` and ``what`` stand in errors.

    Raises MissionError with ``name:line:column`` for text that is neither, for keys given twice or that are not text,
    and for tags other than the standard ones.
    """
    if name.lower().endswith(".json"):
        text = _checked_json(text, name)
    root = _compose(text, name)
    if root is None:
        raise MissionError(f"{name}:1:1: the file is empty; {what} is needed")
    builder = _Builder(name, text)
    try:
        if _count(root, {}) > MOST_VALUES:
            raise MissionError(f"{name}:1:1: more than {MOST_VALUES:,} values; put large shapes in a GeoJSON file")
        value = builder.build(root, ())
    except RecursionError:  # by aliases
        raise MissionError(f"{name}:1:1: {_TOO_DEEP}") from None
    if builder.faults:
        raise MissionError(*builder.faults)
    return Document(name=name, value=value, values_at=builder.values_at, keys_at=builder.keys_at)


class _TooDeep(Exception):  # noqa: N818 (the reader of the text catches it)
    """Where lists and mappings are nested deeper than any mission needs."""


class _ShallowScanner(Scanner):
    """Stops at deep nesting, which takes it time as the square of the depth."""

    def fetch_flow_collection_start(self, TokenClass: Any, to_push: str) -> None:
        """An opening bracket."""
        self._require_shallow(len(self.flow_context))
        super().fetch_flow_collection_start(TokenClass, to_push)

    def add_indent(self, column: int) -> bool:
        """A deeper block."""
        self._require_shallow(len(self.indents))
        return bool(super().add_indent(column))

    def _require_shallow(self, depth: int) -> None:
        if depth >= MOST_NESTED:
            mark = self.reader.get_mark()
            raise _TooDeep(f"{mark.line + 1}:{mark.column + 1}")


def _compose(text: str, name: str) -> Node | None:
    """The tree of a YAML text; None where there is nothing in it."""
    if not text.strip():
        return None
    try:
        with warnings.catch_warnings():
            # YAML allows an anchor to be given again; what follows means the new one
            warnings.simplefilter("ignore", ReusedAnchorWarning)
            yaml = YAML(typ="safe", pure=True)
            yaml.Scanner = _ShallowScanner
            root: Node | None = yaml.compose(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"{mark.line + 1}:{mark.column + 1}" if mark else "1:1"
        reason = ", ".join(str(part) for part in (error.context, error.problem) if part)
        if "'\\t'" in reason:
            reason = "a tab where only blanks are allowed; indent with blanks"
        raise MissionError(f"{name}:{where}: not YAML: {reason}") from None
    except AttributeError:  # text of nothing but comments and directives
        return None
    except _TooDeep as error:
        raise MissionError(f"{name}:{error}: {_TOO_DEEP}") from None
    except Exception as error:  # the parser asserts and converts numbers of the text without a net
        position, reason = _unreadable(text, error)
        line = text.count("\n", 0, position) + 1
        column = position - text.rfind("\n", 0, position)
        raise MissionError(f"{name}:{line}:{column}: not YAML: {reason}") from None
    return root


def _unreadable(text: str, error: Exception) -> tuple[int, str]:
    """Where in a text the parser failed with an error that has no mark, and why."""
    position = getattr(error, "position", None)
    if position is not None:
        return position, f"the character {text[position : position + 1]!r} is not allowed"
    if (version := _VERSION.search(text)) is not None:
        return (
            version.start(),
            f"{shorten(version[0].strip())} is not allowed; 1.2, 1.1 or none is needed",
        )
    if (beyond := _BEYOND_UNICODE.search(text)) is not None:
        return beyond.start(), f"{beyond[0]} is no character; \\U0010FFFF is the last one"
    return 0, shorten(" ".join(str(error).split()) or type(error).__name__)


def _checked_json(text: str, name: str) -> str:
    """The text if it is JSON, with blanks for tabs; MissionError with line and column if not."""
    if not text.strip():
        return ""
    try:
        # only whether it is JSON is asked; Python refuses to convert very long integers
        json.loads(text, parse_int=str, parse_float=str)
    except json.JSONDecodeError as error:
        raise MissionError(f"{name}:{error.lineno}:{error.colno}: not JSON: {error.msg}") from None
    except (RecursionError, ValueError) as error:
        raise MissionError(f"{name}:1:1: not JSON: {error}") from None
    # JSON allows tabs between values where YAML may not; inside strings JSON has none, so positions stay
    return text.replace("\t", " ")


def _scalar(text: str) -> Any:
    """The value of a plain scalar by the core schema of YAML 1.2."""
    if _NULL.fullmatch(text):
        return None
    if _BOOL.fullmatch(text):
        return text[0] in "tT"
    for kind, base, prefix in ((_INT, 10, 0), (_OCTAL, 8, 2), (_HEXADECIMAL, 16, 2)):
        if kind.fullmatch(text):
            return _whole(text[prefix:], base)
    if _FLOAT.fullmatch(text):
        return float(text)
    if _INFINITY.fullmatch(text):
        return float(text.replace(".", ""))
    if _NAN.fullmatch(text):
        return float("nan")
    return text


def _whole(digits: str, base: int) -> int | float:
    """An integer; as a float where it is so long that it is out of every range all the same."""
    if len(digits) <= _LONGEST_EXACT:
        return int(digits, base)
    try:
        return float(digits) if base == 10 else float(int(digits, base))
    except OverflowError:
        return math.inf


class _Builder:
    """Turns ruamel's nodes into plain values and notes where each one stands."""

    def __init__(self, name: str, source: str) -> None:
        self.name, self.source = name, source
        self.values_at: dict[Place, tuple[int, int]] = {}
        self.keys_at: dict[Place, tuple[int, int]] = {}
        self.faults: list[str] = []
        self.open: set[int] = set()

    def build(self, node: Node, place: Place) -> Any:
        """The plain value of a node at a place, and of all below it; None, with a fault noted, where it is refused."""
        self.values_at[place] = _start(node)
        if id(node) in self.open:
            return self.refuse(node, place, "an alias inside what it stands for; write the values out")
        if node.tag not in _TAGS:
            return self.refuse(node, place, f"the tag {node.tag} is not allowed; write a plain value")
        self.open.add(id(node))
        try:
            if isinstance(node, MappingNode):
                return self.mapping(node, place)
            if isinstance(node, SequenceNode):
                return [self.build(item, (*place, k)) for k, item in enumerate(node.value)]
            assert isinstance(node, ScalarNode)
            return self.scalar(node)
        finally:
            self.open.discard(id(node))

    def mapping(self, node: MappingNode, place: Place) -> dict[str, Any]:
        """A mapping as a dict, without keys that are no text or are given twice, which are noted as faults."""
        values: dict[str, Any] = {}
        for key_node, value_node in node.value:
            key = key_node.value if isinstance(key_node, ScalarNode) else None
            if key is None:
                self.refuse(key_node, place, "a list or mapping as a key is not allowed; keys are plain text")
                continue
            inner = (*place, key)
            if key in values:
                first = self.keys_at[inner][0]
                self.refuse(key_node, inner, f"the key is given twice, first in line {first}; keep one of them")
                continue
            self.keys_at[inner] = _start(key_node)
            values[key] = self.build(value_node, inner)
        return values

    def scalar(self, node: ScalarNode) -> Any:
        """A text as it is where it is quoted or tagged as one, otherwise what the core schema makes of it."""
        text = str(node.value)
        if any(0xD800 <= ord(letter) < 0xE000 for letter in text):
            # JSON writes characters beyond the first plane as two escapes
            text = text.encode("utf-16", "surrogatepass").decode("utf-16", "replace")
        # ruamel calls some plain numbers text; only what is quoted or tagged !!str is meant as text
        source = self.source[node.start_mark.index : node.end_mark.index]
        is_text = node.style is not None or (node.tag == _STANDARD + "str" and "!" in source.removesuffix(text))
        return text if is_text else _scalar(text)

    def refuse(self, node: Node, place: Place, message: str) -> None:
        """Note a fault of the node."""
        line, column = _start(node)
        field = field_path(place)
        self.faults.append(f"{self.name}:{line}:{column}: {field + ': ' if field else ''}{message}")


def _count(node: Node, known: dict[int, int]) -> int:
    """How many values a node stands for once its aliases are written out."""
    if id(node) not in known:
        known[id(node)] = 1  # counts for an alias inside what it stands for, which is refused later
        inner = node.value if isinstance(node, SequenceNode) else []
        if isinstance(node, MappingNode):
            inner = [value for _, value in node.value]
        known[id(node)] = 1 + sum(_count(value, known) for value in inner)
    return known[id(node)]


def _start(node: Node) -> tuple[int, int]:
    return node.start_mark.line + 1, node.start_mark.column + 1
