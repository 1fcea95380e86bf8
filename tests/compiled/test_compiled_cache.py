"""Whether a first run would compile is told from the names of what is kept."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from subprocess import Popen

import pytest

from rota.compiled.code_cache import write_code
from rota.compiled.compiled_cache import PACKAGE, is_compiled
from rota.compiled.source_stamp import code_prefix, source_stamp
from rota.planning import first_run
from rota.planning.first_run import compile_by_two
from rota.planning.planner import planner_named


def kept(module: str, *, stamp: str | None = None) -> None:
    """A file as a kernel of the module leaves it, compiled of its present sources or of those with this stamp."""
    file = PACKAGE.joinpath(*module.split(".")[1:]).with_suffix(".py")
    name = code_prefix(module, "worst_gaps", file) + "0" * 40
    write_code(name if stamp is None else name.replace(source_stamp(file)[:12], stamp), b"code")


def test_only_the_main_kernels_of_each_package_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    kept("rota.check.triangle_kernels")
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


def test_a_first_run_compiles_by_two_processes_and_says_what(monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []
    ran: list[list[str]] = []

    def part() -> None:
        done.append("here")

    planner = planner_named("patrol")
    monkeypatch.setattr(type(planner), "parts_to_compile", lambda self: (part,))
    monkeypatch.setattr(first_run, "PARTS", ())
    monkeypatch.setattr(
        first_run, "Popen", lambda command, **_: ran.append(command) or Popen([sys.executable, "-c", ""])
    )
    told: list[tuple[float, str]] = []
    with compile_by_two(planner, tell=lambda share, doing: told.append((share, doing)), to_the_end=True):
        assert done == ["here"]
    assert told == [(0.0, "compiling part")]
    assert ran == [[sys.executable, "-m", "rota.planning.first_run", "patrol"]]


def test_planners_that_compile_in_a_moment_take_no_other_process() -> None:
    assert first_run.parts_of(planner_named("bounce")) == ()


@pytest.mark.slow  # loads all of the check, and compiles what is not kept
def test_the_other_process_runs_through() -> None:
    done = subprocess.run([sys.executable, "-m", "rota.planning.first_run", "patrol"], capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
