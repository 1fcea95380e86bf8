"""Work that compiles, in parts that processes share out."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence

from rota.compiled.code_cache import claim

Part = Callable[[], None]  # a function that compiles something; it is told from others by its name


def compile_parts(parts: Sequence[Part], tell: Callable[[float, str], None] | None = None) -> None:
    """Do all parts but those that another process is at; tell: called with the share done and what comes next.

    What two parts have in common is compiled by one process, and the other one waits for it.
    """
    for k, part in enumerate(parts):
        if tell is not None:
            tell(k / len(parts), f"compiling {part.__name__}")
        with claim(_number(part)) as mine:
            if mine:
                part()


def _number(part: Part) -> int:
    """The same 62 bits for the same part in all processes."""
    name = f"{part.__module__}.{part.__qualname__}"
    return int.from_bytes(hashlib.sha256(name.encode()).digest()[:8]) >> 2
