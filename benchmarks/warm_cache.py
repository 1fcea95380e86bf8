"""Measurements with a warm numba cache: repeated while short, and made again when one of them had to compile."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

SHORT_S = 20.0  # shorter measurements are repeated: a passing disturbance is a larger part of them
REPEATS = 3
MOST_WARM_UPS = 3

Measured = TypeVar("Measured")


def measured_warm(
    measure: Callable[[], Measured], wall_s: Callable[[Measured], float], *, repeats: int = REPEATS
) -> list[Measured]:
    """Call ``measure`` until a call compiles nothing; that one and, where it is short, the ``repeats`` - 1 after it."""
    for _ in range(MOST_WARM_UPS):
        before = _compiled_forms()
        first = measure()
        if _compiled_forms() == before:
            break
    if wall_s(first) >= SHORT_S:
        return [first]
    return [first] + [measure() for _ in range(repeats - 1)]


def _compiled_forms() -> set[tuple[Path, int]]:
    """The files in which numba keeps compiled code, and when each was written."""
    return {(file, file.stat().st_mtime_ns) for place in _places() for file in place.rglob("*.nbc")}


def _places() -> list[Path]:
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    if chosen:
        return [Path(chosen)]
    package = importlib.util.find_spec("rota")
    return [Path(package.origin).parent, Path.home() / ".cache" / "numba"]
