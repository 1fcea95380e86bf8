"""Values of the studies as JSON, and back by their types: numbers, text, arrays, tuples, dataclasses, named tuples."""

from __future__ import annotations

import dataclasses
import math
import types
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from rota.errors import RotaError

T = TypeVar("T")
DIGITS = 7
"""That a number keeps: a millimetre in a kilometre."""
SAME = 1e-5  # share by which numbers may differ that another processor rounds otherwise


def plain(value: Any) -> Any:
    """A value as JSON has it: infinite numbers as text, fields of dataclasses and named tuples by their names.

    What a plan file leaves out at its default, and older ones did not have, is left out here as well.
    """
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, np.ndarray):
        return _numbers(value)
    if isinstance(value, np.bool_):
        return bool(value)
    if isinstance(value, int | np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return _number(float(value))
    if dataclasses.is_dataclass(value):
        items = [(item, getattr(value, item.name)) for item in dataclasses.fields(value)]
        return {item.name: plain(part) for item, part in items if not _is_spared(item, part)}
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return {name: plain(part) for name, part in value._asdict().items()}
    if isinstance(value, Mapping):
        return {str(name): plain(part) for name, part in value.items()}
    if isinstance(value, Sequence):
        return [plain(part) for part in value]
    raise TypeError(f"{type(value).__name__}: a record cannot hold it")


def _is_spared(item: dataclasses.Field[Any], value: Any) -> bool:
    """Whether a field is one that plan files leave out at its default, and that is at it."""
    may_be = item.metadata.get("newer") and item.metadata.get("spared")
    return bool(may_be) and type(value) is type(item.default) and bool(value == item.default)


def _numbers(values: np.ndarray[Any, Any]) -> Any:
    """An array as nested lists."""
    if values.dtype.kind != "f":
        return values.tolist()
    if values.ndim != 1:
        return [_numbers(row) for row in values]
    return [_number(value) for value in values.tolist()]


def _number(value: float) -> float | int | str:
    """A number to ``DIGITS``; whole ones without a point, which saves room."""
    if not math.isfinite(value):
        return str(value)
    kept = float(f"{value:.{DIGITS}g}")
    return int(kept) if kept == int(kept) else kept


def changes(settings: Any) -> Any:
    """The fields of a dataclass that are not at their defaults, those of dataclasses within likewise."""
    found = {}
    for item in dataclasses.fields(settings):
        value, usual = getattr(settings, item.name), item.default
        if item.default_factory is not dataclasses.MISSING:
            usual = item.default_factory()
        if value != usual:
            inner = dataclasses.is_dataclass(value) and type(value) is type(usual)
            found[item.name] = changes(value) if inner else plain(value)
    return found


def built(kind: Any, value: Any) -> Any:
    """The value of a type that ``plain`` made JSON of. Raises RotaError where it cannot be one."""
    try:
        return _built(kind, value)
    except (TypeError, ValueError, KeyError, AttributeError) as error:
        raise RotaError(f"a record holds no {getattr(kind, '__name__', kind)}: {error}") from error


def _built(kind: Any, value: Any) -> Any:
    """The same, with whatever error Python raises."""
    origin, inner = get_origin(kind), get_args(kind)
    if hasattr(origin, "__value__"):  # from Python 3.12 on NDArray is an alias with a name of its own
        return _built(origin.__value__[inner], value)
    if kind is Any or origin is Literal:
        return value
    if origin in (Union, types.UnionType):
        (kind,) = (one for one in inner if one is not type(None))
        return None if value is None else _built(kind, value)
    if origin is np.ndarray:
        return np.array(value, dtype=get_args(inner[1])[0])
    if origin is tuple and inner[1:] == (...,):
        return tuple(_built(inner[0], part) for part in value)
    if origin is tuple:
        return tuple(_built(one, part) for one, part in zip(inner, value, strict=True))
    if origin is list:
        return [_built(inner[0], part) for part in value]
    if origin is not None and issubclass(origin, Mapping):
        return {_built(inner[0], name): _built(inner[1], part) for name, part in value.items()}
    if kind in (bool, str, type(None)):
        if not isinstance(value, kind):
            raise TypeError(f"{value!r} is not a {kind.__name__}")
        return value
    if kind in (int, float):
        return kind(value)
    hints = _hints(kind)
    return kind(**{name: _built(hints[name], part) for name, part in value.items()})


@cache
def _hints(kind: type) -> dict[str, Any]:
    return get_type_hints(kind)


def alike(one: Any, other: Any) -> bool:
    """Whether two values as JSON are the same, but for rounding; fields that are not there are null or empty."""
    if one is None or other is None:
        return one in (None, []) and other in (None, [])
    if isinstance(one, dict) and isinstance(other, dict):
        return all(alike(one.get(name), other.get(name)) for name in one.keys() | other.keys())
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, float) or isinstance(other, float):
        numbers = isinstance(one, int | float) and isinstance(other, int | float)
        return numbers and math.isclose(one, other, rel_tol=SAME, abs_tol=SAME)
    return bool(one == other)
