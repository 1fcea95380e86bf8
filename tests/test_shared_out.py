"""Tests shared out among copies: each is run once, whatever ends copies is told, and each copy tears down."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

HOOKS = "from tests.conftest import pytest_addoption, pytest_runtestloop\n"
TESTS = """
import os, pathlib, signal, warnings
import pytest

@pytest.fixture(scope="session")
def lent():
    yield 1
    pathlib.Path(f"ended-{os.getpid()}").touch()

@pytest.mark.parametrize("k", range(20))
def test_well(k, lent):
    with open("ran", "a") as file:
        file.write(f"{k}\\n")

def test_badly():
    print("told on the way")
    assert 1 == 2

def test_one_that_dies():
    os.kill(os.getpid(), signal.SIGKILL)

def test_one_that_leaves():
    os._exit(7)

def test_skipped():
    pytest.skip("nothing to do")

def test_warned():
    warnings.warn("careful")

def test_without_fixture(nowhere):
    pass
"""


def run(folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--copies", "3", *options]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)


def test_each_is_run_once_and_what_fails_or_ends_a_copy_is_told(tmp_path: Path) -> None:
    (tmp_path / "conftest.py").write_text(HOOKS)
    (tmp_path / "test_some.py").write_text(TESTS)
    done = run(tmp_path)
    assert done.returncode == 1
    assert "= 3 failed, 21 passed, 1 skipped, 1 warning, 1 error in " in done.stdout
    assert "test_one_that_dies - its process ended: SIGKILL" in done.stdout
    assert "test_one_that_leaves - its process ended: exit code 7" in done.stdout
    assert "told on the way" in done.stdout
    assert "UserWarning: careful" in done.stdout
    assert "fixture 'nowhere' not found" in done.stdout
    assert sorted(map(int, (tmp_path / "ran").read_text().split())) == list(range(20))
    assert list(tmp_path.glob("ended-*"))
    stopped = run(tmp_path, "--maxfail", "1")
    assert stopped.returncode == 1
    assert "stopping after 1 failures" in stopped.stdout
    assert stopped.stderr == ""
    assert run(tmp_path, "-k", "skipped").returncode == 0
