"""Kernels: compiled once for all processes, for the types they are called with, and called rather than taken in."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from hashlib import sha256
from pathlib import Path
from shutil import copytree

import numpy as np
import pytest

from rota.compiled.kernel import kernel
from rota.geometry.kernels import cells_of_edges

SOURCE = """
import math
from rota.compiled.kernel import kernel

@kernel
def root(number):
    return math.sqrt(number)

@kernel(noinline=True)
def doubled(number):
    if number < 0:
        raise ValueError("less than nothing")
    return 2 * root(number)

@kernel
def more(number):
    return doubled(number) + 1

@kernel(nogil=True)
def total(numbers):
    whole = 0.0
    for number in numbers:
        whole += more(number)
    return whole
"""
PROGRAM = """
import sys
import numpy as np
from numba.core import event
compiled = []
class Heard(event.Listener):
    def on_start(self, told): compiled.append(told.data["dispatcher"].__name__)
    def on_end(self, told): pass
event.register("numba:compile", Heard())
import small_kernels as kernels
print(kernels.total(np.array([4.0, 9.0], dtype=sys.argv[1])))
try:
    kernels.doubled(-1.0)
except ValueError as error:
    print(error)
print(*sorted(compiled))
"""

COMPILES = pytest.mark.slow  # another process that compiles


@pytest.fixture
def written(tmp_path: Path) -> Path:
    (tmp_path / "small_kernels.py").write_text(SOURCE)
    return tmp_path


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str]]:
    """A folder of which all is compiled, and what the process printed that did; not to be changed."""
    folder = tmp_path_factory.mktemp("filled")
    (folder / "small_kernels.py").write_text(SOURCE)
    return folder, lines_of(started(folder))


def started(folder: Path, kind: str = "float64", **more: str) -> subprocess.Popen[str]:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "cache"), "PYTHONPATH": str(folder), **more}
    return subprocess.Popen([sys.executable, "-c", PROGRAM, kind], env=environment, stdout=subprocess.PIPE, text=True)


def lines_of(process: subprocess.Popen[str]) -> list[str]:
    """What it printed: the sum, what was wrong, and which kernels it compiled."""
    text, _ = process.communicate(timeout=120)
    assert process.returncode == 0
    return text.splitlines()


def test_processes_side_by_side_compile_each_kernel_once(written: Path) -> None:
    told = [lines_of(process) for process in [started(written) for _ in range(3)]]
    assert [lines[:2] for lines in told] == [["12.0", "less than nothing"]] * 3
    compiled = sorted(name for lines in told for name in lines[2].split())
    # doubled twice: for kernels, which find it by its name, and with the entry for Python
    assert compiled == ["doubled", "doubled", "more", "root", "total"]


EVERYTHING = "doubled doubled more root total"


def test_a_second_process_finds_all(filled: tuple[Path, list[str]], tmp_path: Path) -> None:
    source, first = filled
    assert first[2] == EVERYTHING
    written = Path(copytree(source, tmp_path / "copy"))
    assert lines_of(started(written)) == ["12.0", "less than nothing", ""]


@pytest.mark.parametrize(
    ("kind", "setting", "compiled"),
    [
        ("float32", {}, "doubled more root total"),  # -1.0 is a float64 as before
        pytest.param("float64", {"NUMBA_BOUNDSCHECK": "1"}, EVERYTHING, marks=COMPILES),
        pytest.param("float64", {"NUMBA_OPT": "1"}, EVERYTHING, marks=COMPILES),
    ],
)
def test_other_types_and_settings_are_other_code(
    kind: str, setting: dict[str, str], compiled: str, filled: tuple[Path, list[str]], tmp_path: Path
) -> None:
    written = Path(copytree(filled[0], tmp_path / "copy"))
    assert lines_of(started(written, kind, **setting))[2] == compiled


DAMAGES = ("emptied", "halved", "flipped", "no pickle", "another pickle")


def damaged(data: bytes, how: str) -> bytes:
    """A file's contents after a fault of the disk, or as somebody else would write them."""
    if how == "flipped":
        at = len(data) // 2
        return data[:at] + bytes([data[at] ^ 4]) + data[at + 1 :]
    if how == "no pickle":
        return sha256(b"no pickle").digest() + b"no pickle"
    if how == "another pickle":
        other = pickle.dumps((pickle.dumps([("small_kernels", "absent", ())]), b""))
        return sha256(other).digest() + other
    return {"emptied": b"", "halved": data[: len(data) // 2]}[how]


@pytest.mark.parametrize("turn", [0, pytest.param(2, marks=COMPILES)])
def test_a_damaged_cache_gives_the_same_and_heals(filled: tuple[Path, list[str]], tmp_path: Path, turn: int) -> None:
    source, first = filled
    written = Path(copytree(source, tmp_path / "copy"))
    files = sorted((written / "cache" / "rota").glob("*-*.kernel"))
    assert len(files) == len(DAMAGES) == 5  # each of them in another way
    for k, file in enumerate(files):
        file.write_bytes(damaged(file.read_bytes(), DAMAGES[(k + turn) % 5]))
    assert lines_of(started(written)) == first  # all is compiled again
    assert lines_of(started(written))[2] == ""


def test_a_cache_that_is_read_only_is_used(filled: tuple[Path, list[str]], tmp_path: Path) -> None:
    source, written = filled[0], tmp_path / "copy"
    cache = Path(copytree(source, written)) / "cache" / "rota"
    cache.chmod(0o555)
    (cache / "lock").chmod(0o444)
    try:
        assert lines_of(started(written))[2] == ""
    finally:
        cache.chmod(0o755)


def test_a_kernel_is_compiled_alike_for_whoever_calls_it() -> None:
    # numba hands options of the caller on; here the callee allocates although its caller may not
    @kernel
    def pair(number):  # type: ignore[no-untyped-def]
        return np.full(2, number)

    @kernel(_nrt=False, error_model="numpy")
    def divided(number):  # type: ignore[no-untyped-def]
        return 1.0 / number

    assert pair(3).tolist() == [3, 3]
    assert divided(0.0) == np.inf
    with pytest.raises(ZeroDivisionError):
        kernel(divided.py_func)(0.0)


def test_a_kernel_is_pickled_by_its_name() -> None:
    assert pickle.loads(pickle.dumps(cells_of_edges)) is cells_of_edges


def test_what_kernels_call_has_one_form_for_all_numbers_and_no_machine_code_of_its_own() -> None:
    @kernel
    def sum_of(number, other):  # type: ignore[no-untyped-def]
        return number + other

    @kernel
    def more(number):  # type: ignore[no-untyped-def]
        return sum_of(number, 1) + sum_of(number, 2)

    assert more(3) == 9
    (form,) = sum_of.overloads.values()
    assert form.library.get_pointer_to_function(form.fndesc.llvm_func_name) == 0
    assert sum_of(3, 4) == 7  # Python's call gives it some
