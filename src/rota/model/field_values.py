"""The values of declared fields: checked as a block is made of them, and as files have them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Iterable, Mapping
from functools import cache
from numbers import Real
from typing import Any

import numpy as np

from rota.errors import MissionError
from rota.model.fields import AS_FLEET, Field, fields_of
from rota.model.refusals import path_of, refusal

Json = dict[str, Any]


def check_fields(block: Any, where: str = "") -> None:
    """Make tuples of lists and floats of numbers. Raises MissionError for a value that its field does not take.

    where: what stands before the name of a field, such as ``fleet.``. What is ``AS_FLEET`` is passed over.
    """
    for item in fields_of(type(block)):
        value = getattr(block, item.name, AS_FLEET)  # blocks of methods check themselves
        if value is AS_FLEET:
            continue
        if item.kind in ("pair", "list") and value is not None and value != item.word:
            value = _list_up(item, value)
        for place, part, fault in item.faults(value):
            message = refusal(fault.kind, part, fault.given, fault.given.get("expected", ""))
            raise MissionError(f"{where}{path_of((item.name, *place))}: {message}")
        if item.kind in ("pair", "list") and value is not None:
            object.__setattr__(block, item.name, () if value == item.word else tuples_of(item, value))
        elif item.kind in ("number", "either") and type(value) is not float and isinstance(value, Real):
            object.__setattr__(block, item.name, float(value))


def _list_up(item: Field, value: Any) -> Any:
    """A tuple of whatever can be iterated, so that arrays and generators serve, too."""
    if isinstance(value, str | Mapping) or value == [] or not isinstance(value, Iterable) or item.item is None:
        return value
    return tuple(_list_up(item.item, entry) if item.item.item is not None else entry for entry in value)


def tuples_of(item: Field, value: Any) -> Any:
    """Tuples in place of lists, and Python's own numbers."""
    if item.item is not None:
        return tuple(tuples_of(item.item, entry) for entry in value)
    return float(value) if item.kind == "number" else int(value) if item.kind == "whole" else value


def in_file_form(block: Any, other: Callable[[Any], Any] = lambda value: value, without: Collection[str] = ()) -> Json:
    """A block as plan files have it: dicts, lists, text and numbers by their names, without what is spared.

    other: makes such a value of what is declared with another type, as shapes are. without: fields to leave out.
    """
    if hasattr(block, "in_file"):
        return dict(block.in_file)
    told: Json = dict([block.tag] if hasattr(block, "tag") else ())
    told |= dict.fromkeys(getattr(block, "first", ()))
    for item in fields_of(type(block)):
        value = block.value_of(item.name) if hasattr(block, "value_of") else getattr(block, item.name)
        if item.name in without or (item.spared and _is_at_default(block, item)):
            continue
        if item.flat:
            told |= in_file_form(value, other)
        else:
            told[item.key or item.name] = _value_as_written(item, value, other)
    return told


def _is_at_default(block: Any, item: Field) -> bool:
    """Whether a field, and all that are spared with it, is at its default."""
    for name, usual in _defaults_together(block.__class__, item.name):
        if (value := getattr(block, name)) is not usual and (isinstance(value, np.ndarray) or value != usual):
            return False
    return True


@cache
def _defaults_together(kind: type, name: str) -> tuple[tuple[str, Any], ...]:
    """The names and defaults of the fields that are spared with a field of a type of block."""
    (item,) = (each for each in fields_of(kind) if each.name == name)
    together = item.spared if isinstance(item.spared, tuple) else (name,)
    return tuple((each.name, each.default) for each in fields_of(kind) if each.name in together)


def _value_as_written(item: Field, value: Any, other: Callable[[Any], Any]) -> Any:
    """A value of a field in a file."""
    if type(value) is float and item.kind == "number":
        return value  # most are
    if value is None:
        return item.null_word
    if isinstance(value, np.ndarray):
        return value.tolist()
    if item.kind in ("pair", "list") and item.item is not None:
        return [_value_as_written(item.item, entry, other) for entry in value] or item.word or []
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return in_file_form(value, other)
    if item.kind in ("number", "either") and isinstance(value, Real):
        return float(value)
    return int(value) if item.kind == "whole" else other(value)
