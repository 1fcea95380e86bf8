"""What JSON leaves open, decided: a key that stands twice is a fault, and a digest says whether values are the same."""

from __future__ import annotations

import hashlib
import json
from typing import Any


def unique_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A mapping of these keys and values, for ``json.loads(object_pairs_hook=)``.

    Raises ValueError for a key that stands twice, of which ``json.loads`` by itself keeps the last value.
    """
    values = dict(pairs)
    if len(values) < len(pairs):
        seen: set[str] = set()
        twice = next(key for key, _ in pairs if key in seen or seen.add(key))  # type: ignore[func-returns-value]
        raise ValueError(f"the key {json.dumps(twice)} stands twice in one mapping; remove one of them")
    return values


def digest_of(value: Any) -> str:
    """The SHA-256 of JSON values, in hexadecimal digits: the same for any order of keys, white space and 60 or 60.0."""
    text = json.dumps(_with_floats(value), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _with_floats(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _with_floats(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [_with_floats(inner) for inner in value]
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value
