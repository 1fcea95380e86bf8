"""A first run: what it compiles, in processor seconds with and without a filled cache, and how long a user waits."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from benchmarks.row import Options, Row

PROJECT = Path(__file__).parent.parent
# before: numba's njit, of the harbour's first plan, check and drawing; its own functions are not counted
ASKED = "nothing compiled twice; before: 146 functions in 148 compilations, 102 s of CPU"


def cold_start(options: Options) -> Iterator[Row]:
    """All that a first patrol plan and its check compile, by ``rota compile patrol``; then make demo."""
    folder = options.folder / "cold"
    cold_s, warm_s = _cpu_s(folder), _cpu_s(folder)
    names = [file.name for file in (folder / "rota").glob("*.kernel")]
    functions = {name.split("-")[0] for name in names}
    measured = f"{len(functions)} functions in {len(names)} compilations, {cold_s - warm_s:.0f} s of CPU"
    yield Row("patrol's first run compiles", ASKED, measured, len(names) == len(functions) and cold_s - warm_s < 102)
    lasted_s = _demo_s(options.folder)
    yield Row(
        "make demo in a fresh clone, nothing compiled", "< 75 s (before: 180)", f"{lasted_s:.0f} s", lasted_s < 75
    )


def _demo_s(folder: Path) -> float:
    """Seconds that ``make demo`` takes, with what it installs; packages may come from the installer's cache."""
    clone = folder / "clone"
    subprocess.run(["git", "clone", "--quiet", PROJECT, clone], check=True)
    began_s = time.monotonic()
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "of-the-demo")}
    subprocess.run(["make", "demo"], cwd=clone, env=environment, check=True, capture_output=True)
    return time.monotonic() - began_s


def _cpu_s(folder: Path) -> float:
    """Seconds on the processor of one run and its processes."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder)}
    command = [sys.executable, "-m", "rota", "compile", "patrol"]
    subprocess.run(command, env=environment, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
