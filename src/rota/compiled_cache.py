"""Whether numba has compiled the kernels already, so that a first run can say why it takes a minute."""

from __future__ import annotations

import os
from pathlib import Path

PACKAGE = Path(__file__).parent


def is_compiled(*packages: str) -> bool:
    """Whether every kernels file of ``packages`` (folders below rota) has a compiled form no older than itself.

    A guess for a message to people: numba itself decides, function by function.
    """
    return all(_has_compiled_form(file) for package in packages for file in (PACKAGE / package).rglob("*kernels.py"))


def _has_compiled_form(file: Path) -> bool:
    made_s = file.stat().st_mtime
    return any(
        index.stat().st_mtime >= made_s for place in _places(file) for index in place.rglob(f"{file.stem}.*.nbi")
    )


def _places(file: Path) -> list[Path]:
    # numba looks in this order; the home folder serves installations that may not be written to
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    if chosen:
        return [Path(chosen)]
    return [file.parent / "__pycache__", Path.home() / ".cache" / "numba"]
