"""Whether the kernels are compiled already: a first run says why it takes a minute."""

from __future__ import annotations

from pathlib import Path

from rota.compiled.code_cache import cache_folder
from rota.compiled.source_stamp import code_prefix

PACKAGE = Path(__file__).parents[1]


def is_compiled(*packages: str) -> bool:
    """Whether ``kernels.py`` of each of ``packages`` (folders below rota) has a compiled form of its present sources.

    A guess for a message to people: many functions are for missions of some kind only. A package without ``kernels.py``
    counts as compiled.
    """
    files = [PACKAGE / package / "kernels.py" for package in packages]
    return all(_has_compiled_form(file) for file in files if file.exists())


def _has_compiled_form(file: Path) -> bool:
    module = ".".join(("rota", *file.relative_to(PACKAGE).with_suffix("").parts))
    return any(cache_folder().glob(code_prefix(module, "*", file) + "*"))
