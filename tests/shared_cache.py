"""One cache of compiled kernels for all processes of the tests: the first to need a kernel compiles it, others wait.

numba's own cache is not made for processes that compile one function for several signatures at the same time (one may
write its code under the name that the other's index gives), and it does not notice a change in a kernel of another
file. `SharedCache` mends both for every process that finds it in NUMBA_CACHE_LOCATOR_CLASSES (see conftest.py).
"""

from __future__ import annotations

import fcntl
import hashlib
import re
from collections.abc import Callable
from functools import cache, wraps
from pathlib import Path
from typing import Any

from numba.core.caching import NullCache, UserProvidedCacheLocator
from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import Dispatcher

PROJECT = Path(__file__).parents[1]
SOURCE = PROJECT / "src"
_IMPORT = re.compile(r"^ *(?:from|import) (rota[\w.]*)(?: import ([\w, ]+))?", re.MULTILINE)


@cache
def imports_of(file: Path, source: Path = SOURCE) -> frozenset[Path]:
    """The files of rota that one of its files imports."""
    named: set[str] = set()
    for module, names in _IMPORT.findall(file.read_text()):
        named |= {module, *(f"{module}.{name.strip()}" for name in names.split(","))}
    paths = {source.joinpath(*name.split(".")).with_suffix(".py") for name in named}
    return frozenset(path for path in paths if path.is_file())


@cache
def source_stamp(file: Path, source: Path = SOURCE) -> bytes:
    """A hash of the file and of every file of rota that it imports, at whatever depth."""
    files, new = set[Path](), {file}
    while new:
        files |= new
        new = {other for one in new for other in imports_of(one, source)} - files
    return hashlib.sha256(b"".join(other.read_bytes() for other in sorted(files))).digest()


class SharedCache(UserProvidedCacheLocator):
    """Where numba keeps a function's compiled code, and of which sources that code is."""

    def get_source_stamp(self) -> bytes:
        return source_stamp(Path(self._py_file).resolve())


def one_at_a_time(compile_it: Callable[..., Any]) -> Callable[..., Any]:
    """Let one process compile a function while the others wait; they then find it in the cache."""
    held: set[str] = set()

    @wraps(compile_it)
    def locked(self: Dispatcher, signature: Any) -> Any:
        if isinstance(self._cache, NullCache):
            return compile_it(self, signature)
        name = f"{self._cache.cache_path}/{self._cache._impl.filename_base}.lock"
        # numba's own lock first: threads take both in one order, and functions call each other in no circle
        with global_compiler_lock:
            if name in held:
                return compile_it(self, signature)
            with open(name, "w") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX)
                held.add(name)
                try:
                    return compile_it(self, signature)
                finally:
                    held.remove(name)

    return locked


Dispatcher.compile = one_at_a_time(Dispatcher.compile)
