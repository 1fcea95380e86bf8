"""Whether the kernels are compiled already: a first run says why it takes a minute."""

from __future__ import annotations

import logging
from functools import cache
from pathlib import Path

from rota.compiled.code_cache import cache_folder
from rota.compiled.source_stamp import code_prefix

PACKAGE = Path(__file__).parents[1]


log = logging.getLogger(__name__)


def mention_compiling(*packages: str) -> None:
    """Log a warning, once, that these packages (as in ``is_compiled``) are not compiled yet, which takes a while."""
    if _has_to_compile(cache_folder(), packages):
        _log_once(cache_folder())


@cache
def _has_to_compile(folder: Path, packages: tuple[str, ...]) -> bool:
    return not is_compiled(*packages)


@cache
def _log_once(folder: Path) -> None:
    log.warning("compiling, once: half a minute to a minute")


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
