"""Whatever ends a command: 1 means that the demand is not met, and nothing else ends with 1."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from click import ClickException

from rota.command import cli
from rota.command.ending import exit_code_of
from rota.command.interrupt import Terminated
from rota.errors import MissionError, NoPlanFound

ENVIRONMENT = {**os.environ, "PYTHONUNBUFFERED": ""}


def rota(*arguments: str, **more: object) -> subprocess.CompletedProcess[str]:
    """The program, run as a user runs it."""
    command = [sys.executable, "-m", "rota", *arguments]
    asked: dict[str, object] = {"capture_output": True, "text": True, "check": False, "timeout": 60, **more}
    return subprocess.run(command, **asked)  # type: ignore[call-overload, no-any-return]


@pytest.mark.parametrize(
    ("raised", "code", "told"),
    [
        (typer.Exit(0), 0, ""),
        (typer.Exit(1), 1, ""),
        (typer.Exit(3), 3, ""),
        (EOFError("Ran out of input"), 70, "a fault in Rota"),  # as of a file that is empty
        (ClickException("of a library"), 70, "a fault in Rota"),
        (SystemExit("a library gives up"), 70, "a fault in Rota"),
        (SystemExit(1), 70, "a fault in Rota"),
        (KeyError("a"), 70, "a fault in Rota"),
        (FileNotFoundError(errno.ENOENT, "No such file", "kernels"), 70, "a fault in Rota"),
        (OSError(errno.ENOSPC, "No space left on device"), 2, "output: No space left on device"),
        (OSError(errno.EMFILE, "Too many open files", "a.json"), 2, "a.json: Too many open files"),
        (MemoryError(), 2, "not enough memory"),
        (MissionError("speed_m_s: -1 is not allowed"), 2, "error: speed_m_s: -1 is not allowed"),
        (NoPlanFound("none"), 3, "no plan: none"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (Terminated(), 143, "interrupted"),
    ],
)
def test_every_end_has_its_code(
    raised: BaseException, code: int, told: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def ended() -> None:
        raise raised

    app = typer.Typer(pretty_exceptions_enable=False)
    app.command()(ended)
    monkeypatch.setattr(cli, "app", app)
    assert cli.run([]) == code
    assert told in capsys.readouterr().err


def test_a_pipe_that_nobody_reads_is_no_verdict() -> None:
    assert exit_code_of(BrokenPipeError(errno.EPIPE, "Broken pipe")) == 141
    done = subprocess.run(
        ["bash", "-c", '"$0" -m rota schema mission | true; echo ${PIPESTATUS[0]}', sys.executable],
        capture_output=True, text=True, check=True, timeout=60, env=ENVIRONMENT,
    )  # fmt: skip
    assert done.stdout.strip() in ("141", "0")  # 0 where all was written before the reader ended
    assert done.stderr == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux has a disk that is always full")
def test_output_to_a_full_disk_is_told_and_no_fault_of_rota() -> None:
    with open("/dev/full", "w") as full:
        done = rota("schema", "mission", stdout=full, stderr=subprocess.PIPE, capture_output=False)
    assert (done.returncode, done.stderr) == (2, "rota: error: output: No space left on device\n")


def test_a_library_that_is_too_old_is_told(tmp_path: Path) -> None:
    (tmp_path / "typer.py").write_text("raise ImportError('no Annotated')\n")
    done = rota("--version", env={**os.environ, "PYTHONPATH": str(tmp_path)})
    assert (done.returncode, done.stdout) == (70, "")
    told = "rota: a library that Rota needs is missing, too old or damaged (ImportError: no Annotated)"
    assert done.stderr == f"{told}; install Rota anew\n"


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere names of files are text")
def test_paths_need_not_be_text(tmp_path: Path) -> None:
    path = os.fsencode(tmp_path) + b"/\xff\x1b[31m.yaml"
    command = [sys.executable.encode(), b"-m", b"rota", b"new", path]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0
    assert os.path.exists(path)
    assert "\\udcff" in done.stdout
    again = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert again.returncode == 2
    assert "\\x1b[31m" in again.stderr
    assert "\x1b" not in again.stderr
