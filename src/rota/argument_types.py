"""Public functions refuse arguments of other types where they are given, by their names, as missions refuse fields."""

from __future__ import annotations

import ast
import inspect
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from datetime import datetime
from functools import cache, wraps
from importlib import import_module
from numbers import Integral, Real
from typing import Any

from rota.errors import ArgumentError
from rota.model.refusals import shorten

_HOMES = {"Mission": "rota.model.mission", "Plan": "rota.model.plan", "Checkpoint": "rota.planning.checkpoint"}
_READ_BY = {"Mission": "rota.read_mission(...).mission", "Plan": "rota.read_plan(...)"}
_CALLED = ("Callable", "Progress", "ShouldStop", "Watch")  # as annotations name what is to be called


def with_types_required(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function as ``rota`` offers it, which raises ArgumentError for arguments that its annotations rule out.

    Annotations are taken as they are written: some name what is loaded for type checkers alone. An argument with a type
    that is not known here is not looked at.
    """
    signature = inspect.signature(function)

    @wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        """The function's answer, or ArgumentError."""
        try:
            given = signature.bind(*args, **kwargs).arguments
        except TypeError:
            return function(*args, **kwargs)  # which says what is missing, or too much
        for name, value in given.items():
            _require_type(name, value, str(signature.parameters[name].annotation))
        return function(*args, **kwargs)

    call.__module__ = "rota"  # where it is found again when it is sent to another process
    return call


def _require_type(name: str, value: object, annotation: str) -> None:
    """Raise ArgumentError unless the value is of one of the types that the annotation names."""
    kinds = _kinds_in(annotation)
    answers = [_is_a(value, kind) for kind in kinds]
    if True in answers or None in answers:
        return
    needed = " or ".join(dict.fromkeys(_words_for(kind) for kind in kinds if kind != "None"))
    hints = [f"; its .{kind.lower()} is one" for kind in _HOMES if kind in kinds and _has_one(value, kind)]
    hints += [f"; {_READ_BY[kind]} reads one from a file" for kind in _READ_BY if kind in kinds and type(value) is str]
    is_plain = type(value).__module__ == "builtins"
    shown = shorten(repr(value)) if is_plain else f"a {type(value).__name__}"
    raise ArgumentError(f"{name}: {shown} is not allowed; {needed} is needed{''.join(hints[:1])}")


@cache
def _kinds_in(annotation: str) -> tuple[str, ...]:
    """The names of the types in an annotation that are divided by ``|``, without what is in their brackets."""
    return tuple(_names_in(ast.parse(annotation, mode="eval").body))


def _names_in(node: ast.expr) -> Iterator[str]:
    if isinstance(node, ast.BinOp):
        yield from _names_in(node.left)
        yield from _names_in(node.right)
    elif isinstance(node, ast.Subscript):
        inner = f"[{ast.unparse(node.slice)}]" if ast.unparse(node.slice) == "str" else ""
        yield from (name + inner for name in _names_in(node.value))
    else:
        yield ast.unparse(node).rsplit(".", 1)[-1]


def _is_a(value: object, kind: str) -> bool | None:
    """Whether a value is of a type of this name; None for types that are not known here."""
    match kind:
        case "None":
            return value is None
        case "bool":
            return type(value).__name__ in ("bool", "bool_")  # numpy's, too
        case "int" | "float":
            number = Integral if kind == "int" else Real
            return isinstance(value, number) and not isinstance(value, bool)
        case "str":
            return isinstance(value, str)
        case "Path" | "FilePath" | "PathLike[str]":
            return isinstance(value, os.PathLike)
        case "Iterable[str]" | "Sequence[str]":
            listed = isinstance(value, Iterable) and not isinstance(value, str | bytes | Mapping)
            return (
                listed and all(isinstance(each, str) for each in value) if isinstance(value, list | tuple) else listed
            )
        case "Mapping":
            return isinstance(value, Mapping)
        case "tuple":
            return isinstance(value, tuple)
        case "datetime":
            return isinstance(value, datetime)
        case "Axes":
            drawing = sys.modules.get("matplotlib.axes")  # where it is not loaded, there are no axes
            return drawing is not None and isinstance(value, drawing.Axes)
        case _ if kind in _CALLED:
            return callable(value)
        case _ if kind in _HOMES:
            return isinstance(value, getattr(import_module(_HOMES[kind]), kind))
    return None


def _has_one(value: object, kind: str) -> bool:
    """Whether what was given holds what is needed, as what a reader or a search answers does."""
    return _is_a(getattr(value, kind.lower(), None), kind) is True


def _words_for(kind: str) -> str:
    """What is needed, in words."""
    words = {
        "bool": "True or False", "int": "a whole number", "float": "a number", "str": "text", "Path": "a path",
        "FilePath": "a path", "PathLike[str]": "a path", "Mapping": "a mapping", "tuple": "a tuple",
        "Iterable[str]": "a list of text", "Sequence[str]": "a list of text",
        "datetime": "a datetime", "Axes": "an Axes of matplotlib",
    }  # fmt: skip
    return words.get(kind, "what can be called" if kind in _CALLED else f"a rota.{kind}")
