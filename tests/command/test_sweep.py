"""`rota sweep` from the shell: what it writes, says and ends with, and that a killed one goes on."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pyarrow.parquet
import pytest
from PIL import Image
from tests.sweep.small_sweeps import write_sweep

from rota.command.cli import run
from rota.files.plan_file import read_plan
from rota.sweep.results import JOURNAL, TABLE

ROTA = [sys.executable, "-m", "rota"]


def finished(folder: Path) -> list[str]:
    """The keys of all cells that are kept for good."""
    journal = folder / JOURNAL
    lines = journal.read_text().split("\n")[:-1] if journal.exists() else []
    return [json.loads(line)["key"] for line in lines]


def wait_for_cells(process: subprocess.Popen[str], folder: Path, count: int) -> None:
    end_s = time.monotonic() + 120
    while len(finished(folder)) < count:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end_s
        time.sleep(0.01)


def test_a_sweep_ends_with_a_table_a_summary_and_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sweep = write_sweep(tmp_path, seeds=[0, 1], settings={"fleet.speed_m_s": [4, 6]}, time_limit_s=60)
    out = tmp_path / "out"
    assert run(["sweep", str(sweep), "-o", str(out), "--processes", "1"]) == 0
    told = capsys.readouterr().out
    assert told.splitlines()[0].split() == [
        "mission", "planner", "effort", "fleet.speed_m_s", "met", "bound", "robots", "loops", "m", "CPU", "s",
    ]  # fmt: skip
    assert "2 of 2" in told.splitlines()[1]
    table = pyarrow.parquet.read_table(out / TABLE).to_pylist()
    assert [(row["seed"], row["fleet.speed_m_s"], row["met"]) for row in table] == [
        (0, 4.0, True), (1, 4.0, True), (0, 6.0, True), (1, 6.0, True),
    ]  # fmt: skip
    assert len(list((out / "plans").iterdir())) == 4
    assert read_plan(out / table[2]["plan_file"]).mission.fleet.speed_m_s == 6
    for name in ("summary.png", "by-fleet.speed_m_s.png"):
        with Image.open(out / name) as picture:
            assert min(picture.size) > 200
    assert run(["sweep", str(sweep), "-o", str(out), "--processes", "1"]) == 0
    assert "4 of 4 cells are finished already" in capsys.readouterr().err
    assert pyarrow.parquet.read_table(out / TABLE).to_pylist() == table


@pytest.mark.slow  # three programs, each with a worker that loads the compiled loops: 15 s
def test_a_sweep_goes_on_after_any_end_and_does_nothing_twice(tmp_path: Path) -> None:
    sweep = write_sweep(tmp_path, seeds={"count": 12})
    out = tmp_path / "out"
    command = [*ROTA, "sweep", str(sweep), "-o", str(out), "--processes", "1"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wait_for_cells(process, out, 2)
    process.send_signal(signal.SIGINT)
    told, said = process.communicate(timeout=60)
    assert process.returncode == 130
    interrupted = finished(out)
    assert f"interrupted: {len(interrupted)} of 12 cells are finished; to go on:" in said
    assert f"rota sweep {sweep} -o {out} --processes 1" in said
    assert f"{len(interrupted)} of {len(interrupted)}" in told
    assert pyarrow.parquet.read_table(out / TABLE).num_rows == len(interrupted)
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wait_for_cells(process, out, len(interrupted) + 2)
    process.kill()
    process.wait()
    killed = finished(out)
    assert killed[: len(interrupted)] == interrupted
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert f"{len(killed)} of 12 cells are finished already" in done.stderr
    assert finished(out)[: len(killed)] == killed
    assert len(finished(out)) == len(set(finished(out))) == 12
    table = pyarrow.parquet.read_table(out / TABLE)
    assert sorted(table["key"].to_pylist()) == sorted(finished(out))
    assert table["seed"].to_pylist() == list(range(12))
    assert sorted(os.listdir(out / "plans")) == sorted(Path(name).name for name in table["plan_file"].to_pylist())


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--cluster", "tcp://127.0.0.1:1", "--processes", "2"], "--processes: is for this machine"),
        (["--cluster", "nowhere"], "'nowhere' is no address of a scheduler; one such as tcp://10.0.0.1:8786 is needed"),
        (["--cluster", "tcp://127.0.0.1:1"], "no scheduler answers at 'tcp://127.0.0.1:1'"),
    ],
)
def test_wrong_options_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], said: str
) -> None:
    sweep = write_sweep(tmp_path)
    assert run(["sweep", str(sweep), "-o", str(tmp_path / "out"), *arguments]) == 2
    assert said in capsys.readouterr().err


def test_a_sweep_without_a_mission_that_can_be_planned_says_why(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sweep = write_sweep(tmp_path, settings={"fleet.sped_m_s": [1, 2]})
    assert run(["sweep", str(sweep), "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert "no mission can be planned" in said
    assert "fleet.sped_m_s: unknown key; did you mean 'speed_m_s'?" in said
    assert not (tmp_path / "out").exists()
