"""Parts of one piece of work on all cores, for functions that leave Python to compiled code."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Given = TypeVar("Given")
Found = TypeVar("Found")


def side_by_side(of: Callable[[Given], Found], parts: Sequence[Given]) -> list[Found]:
    """What a function gives for each part, in their order."""
    if len(parts) <= 1:  # to start a thread takes longer
        return [of(part) for part in parts]
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        return list(pool.map(of, parts))
