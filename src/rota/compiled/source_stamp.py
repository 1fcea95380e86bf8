"""Which sources a kernel is compiled of: its file, and every file of rota that this one imports, at whatever depth."""

from __future__ import annotations

import hashlib
import re
import time
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from uuid import uuid4

SOURCE = Path(__file__).parents[2]
STARTED_S = time.time()  # about when this process began to import rota
THIS_PROCESS = uuid4().hex
_IMPORT = re.compile(r"^ *(?:from|import) (rota[\w.]*)(?: import ([\w, ]+|\([^)]*\)))?", re.MULTILINE)


@cache
def imports_of(file: Path, source: Path = SOURCE) -> frozenset[Path]:
    """The files of rota that a file imports."""
    named: set[str] = set()
    for module, names in _IMPORT.findall(file.read_text(encoding="utf-8")):
        named |= {module, *(f"{module}.{name}" for name in re.findall(r"\w+", names))}
    paths = {source.joinpath(*name.split(".")).with_suffix(".py") for name in named}
    return frozenset(path for path in paths if path.is_file())


@cache
def source_stamp(file: Path, source: Path = SOURCE) -> str:
    """A hash of the contents of these files, wherever they lie and whenever they were written.

    A process that began before the last change of any runs what they were, and does not know what that was. Its kernels
    then get a stamp that no other process has.
    """
    files, new = set[Path](), {file}
    while new:
        files |= new
        new = {other for one in new for other in imports_of(one, source)} - files
    contents = sorted(hashlib.sha256(other.read_bytes()).hexdigest() for other in files)
    whose = [THIS_PROCESS] if changed_since(files, STARTED_S) else []
    return hashlib.sha256("".join(contents + whose).encode()).hexdigest()


def changed_since(files: Iterable[Path], then_s: float) -> bool:
    """Whether any of the files was written, or put in its place, after a time in seconds since the epoch.

    What has a date to come tells nothing: the clock was set back, or the files come from another machine.
    """
    stats, now_s = (file.stat() for file in files), time.time()
    return any(then_s < changed_s <= now_s for stat in stats for changed_s in (stat.st_mtime, stat.st_ctime))
