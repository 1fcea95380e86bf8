"""Pictures and films appear whole or not at all, and only in formats that are known."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rota.errors import RotaError


def require_suffix(path: Path, allowed: tuple[str, ...], what: str) -> str:
    """The suffix of ``path`` in lower case; raises RotaError when it is none of ``allowed``."""
    suffix = path.suffix.lower()
    if suffix not in allowed:
        found = repr(path.suffix) if path.suffix else "no suffix"
        raise RotaError(
            f"{path}: {found} is no format for {what}; {', '.join(allowed[:-1])} or {allowed[-1]} is needed"
        )
    return suffix


@contextmanager
def replaced_file(path: Path) -> Iterator[Path]:
    """A temporary file beside ``path`` that takes its place when the block ends well, and disappears otherwise.

    Raises RotaError when the folder is missing or cannot be written to.
    """
    partial = path.with_name(f".{path.stem}.{secrets.token_hex(4)}{path.suffix}")
    try:
        partial.touch(exist_ok=False)
        yield partial
        os.replace(partial, path)
    except OSError as error:
        raise RotaError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        partial.unlink(missing_ok=True)
