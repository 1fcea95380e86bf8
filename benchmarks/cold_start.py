"""What a first run compiles: functions, and seconds on the processor with a cache that is empty and one that is not."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from benchmarks.row import Options, Row

# before: numba's njit, of the harbour's first plan, check and drawing; its own functions are not counted
ASKED = "nothing compiled twice; before: 146 functions in 148 compilations, 102 s of CPU"


def cold_start(options: Options) -> Iterator[Row]:
    """All that a first patrol plan and its check compile, by the two processes of ``rota compile patrol``."""
    folder = options.folder / "cold"
    cold_s, warm_s = _cpu_s(folder), _cpu_s(folder)
    names = [file.name for file in (folder / "rota").glob("*.code")]
    functions = {name.split("-")[0] for name in names}
    measured = f"{len(functions)} functions in {len(names)} compilations, {cold_s - warm_s:.0f} s of CPU"
    yield Row("patrol's first run compiles", ASKED, measured, len(names) == len(functions) and cold_s - warm_s < 102)


def _cpu_s(folder: Path) -> float:
    """Seconds on the processor of one run and its processes."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder)}
    command = [sys.executable, "-m", "rota", "compile", "patrol"]
    subprocess.run(command, env=environment, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
