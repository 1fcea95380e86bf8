"""Whether a first run would compile is told from numba's index files."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import rota
from rota.compiled_cache import is_compiled
from rota.planners.patrol.compiled_by_two import OTHER_HALF, compiled_by_two


def index_of(folder: Path, name: str, *, age_s: float) -> None:
    """An index file as numba would leave it, ``age_s`` older than the source of the check's main kernels."""
    made_s = (Path(rota.__file__).parent / "check" / "kernels.py").stat().st_mtime
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).touch()
    os.utime(folder / name, (made_s - age_s, made_s - age_s))


def test_only_the_main_kernels_of_each_package_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    index_of(tmp_path / "check_0a1b", "sight_kernels.sees_ground-62.py311.nbi", age_s=-1)
    index_of(tmp_path / "geometry_0a1b", "kernels.clearances-100.py311.nbi", age_s=-1e9)
    assert not is_compiled("check")
    index_of(tmp_path / "check_0a1b", "kernels.worst_gaps-219.py311.nbi", age_s=1)
    assert not is_compiled("check")
    index_of(tmp_path / "check_0a1b", "kernels.worst_gaps-219.py311.nbi", age_s=-1)
    assert is_compiled("check")
    assert is_compiled("check", "geometry")
    assert not is_compiled("check", "geometry", "planners/patrol/annealing")


def test_a_package_without_kernels_is_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "none"))
    assert is_compiled("files")
    assert is_compiled()


def test_the_packages_that_the_program_asks_for_have_main_kernels() -> None:
    for package in ("check", "geometry", "planners/patrol/annealing"):
        assert (Path(rota.__file__).parent / package / "kernels.py").exists()


@pytest.mark.slow  # compiles all of the check anew
def test_the_check_is_compiled_in_another_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # with the usual cache, compiled by now, it is over soon; what counts is that it runs through without a fault
    done = subprocess.run([sys.executable, "-c", OTHER_HALF], capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    with compiled_by_two():
        assert is_compiled()
