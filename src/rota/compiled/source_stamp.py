"""Which sources a kernel is compiled of: its file, and every file that it imports of rota and of its own distribution.

What counts of a source is what it means: comments, docstrings and layout may change, and no kernel is compiled anew.
"""

from __future__ import annotations

import ast
import hashlib
import json
import re
import time
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from uuid import uuid4

from rota.compiled.code_cache import read_code, write_code

SOURCE = Path(__file__).parents[2]
STARTED_S = time.time()  # about when this process began to import rota
THIS_PROCESS = uuid4().hex
STAMP_DIGITS = 12
MEANINGS = "meanings"  # where hashes of meanings are kept, by those of contents: parsing takes 0.4 s
MOST_MEANINGS = 4000
DOCUMENTED = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
_FOR_TYPES = re.compile(r"^if TYPE_CHECKING:.*\n(?:(?: .*)?\n)*", re.MULTILINE)
_IMPORT = re.compile(r"^ *(?:from|import) (rota[\w.]*)(?: import ([\w, ]+|\([^)]*\)))?", re.MULTILINE)


@cache
def imports_of(file: Path, source: Path = SOURCE) -> frozenset[Path]:
    """The files that a file imports when it runs, of rota and of the distribution that it is in."""
    named: set[str] = set()
    for module, names in _IMPORT.findall(_FOR_TYPES.sub("", file.read_text(encoding="utf-8"))):
        named |= {module, *(f"{module}.{name}" for name in re.findall(r"\w+", names))}
    roots = {source, root_of(file)}
    paths = {root.joinpath(*name.split(".")).with_suffix(".py") for name in named for root in roots}
    return frozenset(path for path in paths if path.is_file())


def root_of(file: Path) -> Path:
    """The folder in which the outermost package of a file lies."""
    folder = file.parent
    while (folder / "__init__.py").is_file():
        folder = folder.parent
    return folder


def code_prefix(module: str, function: str, file: Path) -> str:
    """How the names of a function's compiled forms begin: its name, and a part of the hash of its sources."""
    return f"{module}.{function}-{source_stamp(file)[:STAMP_DIGITS]}-"


@cache
def source_stamp(file: Path, source: Path = SOURCE) -> str:
    """A hash of what these files mean, wherever they lie and whenever they were written.

    A process that began before the last change of any runs what they were, and does not know what that was. Its kernels
    then get a stamp that no other process has.
    """
    files, new = set[Path](), {file}
    while new:
        files |= new
        new = {other for one in new for other in imports_of(one, source)} - files
    meanings = sorted(meanings_of([other.read_bytes() for other in files]))
    whose = [THIS_PROCESS] if changed_since(files, STARTED_S) else []
    return hashlib.sha256("".join(meanings + whose).encode()).hexdigest()


def meanings_of(sources: Iterable[bytes]) -> list[str]:
    """A hash of what each source means, the same for all that differ in comments, docstrings and layout alone."""
    known, found, new = _kept_meanings(), [], False
    for source in sources:
        contents = hashlib.sha256(source).hexdigest()
        if contents not in known:
            known[contents], new = _meaning(source), True
        found.append(known[contents])
    if new:
        write_code(MEANINGS, json.dumps(dict(list(known.items())[-MOST_MEANINGS:])).encode())
    return found


@cache
def _kept_meanings() -> dict[str, str]:
    """The hashes that are kept; those of other processes since are worked out again."""
    try:
        return dict(json.loads(read_code(MEANINGS) or b"{}"))
    except (ValueError, TypeError):  # whatever it is: a file of something else
        return {}


def _meaning(source: bytes) -> str:
    """A hash of the syntax tree without docstrings; of the source where it is none of Python."""
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):
        return hashlib.sha256(source).hexdigest()
    for node in ast.walk(tree):
        if isinstance(node, DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            del node.body[0]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest()


def changed_since(files: Iterable[Path], then_s: float) -> bool:
    """Whether any of the files was written, or put in its place, after a time in seconds since the epoch.

    What has a date to come tells nothing: the clock was set back, or the files come from another machine.
    """
    stats, now_s = (file.stat() for file in files), time.time()
    return any(then_s < changed_s <= now_s for stat in stats for changed_s in (stat.st_mtime, stat.st_ctime))
