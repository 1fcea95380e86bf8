"""Measurements with all kernels compiled: repeated while short, and made again when one of them had to compile."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from rota.compiled.code_cache import kept_names

SHORT_S = 20.0  # shorter measurements are repeated: a passing disturbance is a larger part of them
REPEATS = 3
MOST_WARM_UPS = 3

Measured = TypeVar("Measured")


def measured_warm(
    measure: Callable[[], Measured], wall_s: Callable[[Measured], float], *, repeats: int = REPEATS
) -> list[Measured]:
    """Call ``measure`` until a call compiles nothing; that one and, where it is short, the ``repeats`` - 1 after it."""
    for _ in range(MOST_WARM_UPS):
        before = kept_names()
        first = measure()
        if kept_names() == before:
            break
    if wall_s(first) >= SHORT_S:
        return [first]
    return [first] + [measure() for _ in range(repeats - 1)]
