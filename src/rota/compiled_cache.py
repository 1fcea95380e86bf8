"""Whether numba has compiled the kernels already: a first run says why it takes a minute."""

from __future__ import annotations

import os
from pathlib import Path

PACKAGE = Path(__file__).parent


def is_compiled(*packages: str) -> bool:
    """Whether ``kernels.py`` of each of ``packages`` (folders below rota) has a compiled form no older than itself.

    A guess for a message to people: numba itself decides, function by function, and many functions are for missions
    of some kind only. A package without ``kernels.py`` counts as compiled.
    """
    files = [PACKAGE / package / "kernels.py" for package in packages]
    return all(_has_compiled_form(file) for file in files if file.exists())


def _has_compiled_form(file: Path) -> bool:
    made_s = file.stat().st_mtime
    return any(index.stat().st_mtime >= made_s for place in _places(file) for index in place.glob(f"{file.stem}.*.nbi"))


def _places(file: Path) -> list[Path]:
    # numba looks in this order; elsewhere than beside the file, it keeps one folder for each folder of sources, whose
    # name ends in that folder's name and a hash of its path
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    if chosen:
        return _folders_for(file, Path(chosen))
    return [file.parent / "__pycache__", *_folders_for(file, Path.home() / ".cache" / "numba")]


def _folders_for(file: Path, root: Path) -> list[Path]:
    return [folder for folder in root.glob(f"{file.parent.name}_*") if folder.is_dir()]
