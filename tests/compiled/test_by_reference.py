"""That compiled functions read a named tuple by its address as they read one by value, and let go of its arrays."""

from __future__ import annotations

import sys
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError

from rota.compiled.by_reference import by_reference


@by_reference
class Scales(NamedTuple):
    loads_n: Any
    arms_m: Any
    count: int


@njit
def moment_of(k: int, s: Scales) -> float:
    return s.loads_n[k] * s.arms_m[k, 1]


@njit
def moments(s: Scales) -> float:
    s.loads_n[0] = 7.0  # arrays are the caller's own
    total = s.loads_n[: s.count].sum()
    for k in range(s.count):
        total += moment_of(k, s)
    return total


@njit
def unknown_field(s: Scales) -> float:
    return s.weights


def scales() -> Scales:
    return Scales(np.arange(4.0), np.arange(8.0).reshape(4, 2), 3)


def test_fields_are_read_and_written_as_in_python() -> None:
    given, same = scales(), scales()
    assert moments(given) == moments.py_func(same) == 7 + 1 + 2 + (7 * 1 + 1 * 3 + 2 * 5)
    assert given.loads_n[0] == 7.0


def test_no_array_is_kept_after_the_call() -> None:
    given = scales()
    moments(given)
    before = [sys.getrefcount(part) for part in given[:2]]
    for _ in range(100):
        moments(given)
    assert [sys.getrefcount(part) for part in given[:2]] == before


def test_an_unknown_field_and_a_part_that_is_no_array_are_refused() -> None:
    with pytest.raises(TypingError, match="weights"):
        unknown_field(scales())
    with pytest.raises(TypingError):
        moments(Scales(object(), np.zeros((1, 2)), 1))


def test_another_class_with_equal_fields_is_another_type() -> None:
    class Plain(NamedTuple):
        loads_n: Any
        arms_m: Any
        count: int

    # by value, beside the first
    assert moment_of(1, Plain(*scales())) == moment_of(1, scales()) == 3.0
    assert len(moment_of.signatures) == 2
