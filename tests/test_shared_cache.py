"""That processes side by side compile a kernel once between them, and anew when a file that it imports has changed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from tests.shared_cache import PROJECT, source_stamp

KERNEL = """
from numba import njit

@njit(cache=True)
def halved(number):
    total = number
    for _ in range(3):
        total = total / 2
    return total

@njit(cache=True)
def quartered(number):
    return halved(halved(number))
"""
PROGRAM = """
import sys
from kernel import halved, quartered
number = {"int": 64, "float": 64.0}[sys.argv[1]]
print(quartered(number), sum(quartered.stats.cache_misses.values()) + sum(halved.stats.cache_misses.values()))
"""


def test_each_function_is_compiled_once_for_each_signature(tmp_path: Path) -> None:
    (tmp_path / "kernel.py").write_text(KERNEL)
    path = os.pathsep.join([str(tmp_path), str(PROJECT)])
    locator = "tests.shared_cache.SharedCache"
    environment = {**os.environ, "NUMBA_CACHE_LOCATOR_CLASSES": locator, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    running = [
        subprocess.Popen(
            [sys.executable, "-c", PROGRAM, kind], env={**environment, "PYTHONPATH": path}, stdout=subprocess.PIPE
        )
        for kind in ("int", "float", "int")
    ]
    told = [process.communicate(timeout=120)[0].split() for process in running]
    assert [float(result) for result, _ in told] == [1.0, 1.0, 1.0]
    # quartered of an int and of a float; halved of an int, and of a float for both
    assert sum(int(misses) for _, misses in told) == 4


def test_a_change_far_down_counts(tmp_path: Path) -> None:
    texts = {
        "a_kernels": "from rota.b_kernels import (\n    b,\n)\n",
        "b_kernels": "from rota import c_kernels, other\n",
        "c_kernels": "C = 1\n",
        "unrelated_kernels": "",
    }
    files = {name: tmp_path / "rota" / f"{name}.py" for name in texts}
    (tmp_path / "rota").mkdir()
    for name, text in texts.items():
        files[name].write_text(text)

    def stamp() -> bytes:
        source_stamp.cache_clear()
        return source_stamp(files["a_kernels"], tmp_path)

    before = stamp()
    files["unrelated_kernels"].write_text("D = 1\n")
    assert stamp() == before
    files["c_kernels"].write_text("C = 2\n")
    assert stamp() != before
