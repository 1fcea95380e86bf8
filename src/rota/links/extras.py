"""Libraries that single links need, and the extra that brings each."""

from __future__ import annotations

from importlib.util import find_spec

from rota.errors import RotaError


def required(library: str, extra: str) -> None:
    """Raise RotaError with what to do where a library is not installed."""
    if find_spec(library) is None:
        raise RotaError(f"the package {library} is needed and not installed: pip install 'rota[{extra}]'")
