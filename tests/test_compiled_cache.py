"""Whether a first run would compile is told from the names of what is kept."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rota.compiled.code_cache import code_prefix, write_code
from rota.compiled.source_stamp import source_stamp
from rota.compiled_cache import PACKAGE, is_compiled
from rota.planners.patrol.compiled_by_two import OTHER_HALF, compiled_by_two


def kept(module: str, *, stamp: str | None = None) -> None:
    """A file as a kernel of the module leaves it, compiled of its present sources or of those with this stamp."""
    file = PACKAGE.joinpath(*module.split(".")[1:]).with_suffix(".py")
    name = code_prefix(module, "worst_gaps", file) + "0" * 40
    write_code(name if stamp is None else name.replace(source_stamp(file)[:12], stamp), b"code")


def test_only_the_main_kernels_of_each_package_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    kept("rota.check.sight_kernels")
    kept("rota.geometry.kernels")
    assert not is_compiled("check")
    kept("rota.check.kernels", stamp="0123456789ab")  # of older sources
    assert not is_compiled("check")
    kept("rota.check.kernels")
    assert is_compiled("check")
    assert is_compiled("check", "geometry")
    assert not is_compiled("check", "geometry", "planners/patrol/annealing")


def test_a_package_without_kernels_is_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "none"))
    assert is_compiled("files")
    assert is_compiled()


def test_the_packages_that_the_program_asks_for_have_main_kernels() -> None:
    for package in ("check", "geometry", "planners/patrol/annealing"):
        assert (PACKAGE / package / "kernels.py").exists()


@pytest.mark.slow  # compiles all of the check anew
def test_the_check_is_compiled_in_another_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # with the usual cache, compiled by now, it is over soon; what counts is that it runs through without a fault
    done = subprocess.run([sys.executable, "-c", OTHER_HALF], capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    with compiled_by_two():
        assert is_compiled()
