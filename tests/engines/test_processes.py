"""Processes of this machine as an executor: what is killed is done again, and nothing else is lost."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import CancelledError
from pathlib import Path

import pytest
from tests.engines.calls import (
    begin_and_wait,
    cores,
    die,
    die_at_first,
    doubled,
    environment,
    leave_work,
    printed,
    process_and,
    refuse,
    wait_for,
)

from rota.engines.processes import MOST_DEATHS, LocalProcesses, WorkerDied


@pytest.fixture
def two() -> Iterator[LocalProcesses]:
    with LocalProcesses(2) as executor:
        yield executor


def test_calls_are_answered_whoever_does_them(two: LocalProcesses) -> None:
    assert list(two.map(doubled, range(20))) == [2 * value for value in range(20)]
    numbers = {number for number, _ in two.map(process_and, range(20))}
    assert 1 <= len(numbers) <= 2
    assert os.getpid() not in numbers
    assert two.submit(printed, "not an answer").result() == "not an answer"
    assert two.submit(environment, "NUMBA_NUM_THREADS").result() == "1"
    assert two.submit(cores).result() == 1


def test_an_exception_comes_back_with_its_place(two: LocalProcesses) -> None:
    with pytest.raises(ValueError, match="no such thing") as caught:
        two.submit(refuse, "no such thing").result()
    assert "in refuse" in caught.value.__notes__[0]
    assert two.submit(doubled, 4).result() == 8


def test_what_cannot_be_sent_is_refused_at_once(two: LocalProcesses) -> None:
    with pytest.raises((AttributeError, TypeError)):
        two.submit(lambda: 1)


def test_a_call_whose_process_is_killed_is_done_again(two: LocalProcesses, tmp_path: Path) -> None:
    waiting = two.submit(begin_and_wait, tmp_path / "begun", tmp_path / "go", 5)
    wait_for(tmp_path / "begun")
    assert two.submit(die_at_first, tmp_path / "mark", 7).result() == 7
    assert not waiting.done()  # the other process was left alone
    first = (tmp_path / "begun").read_text()
    (tmp_path / "go").touch()
    assert waiting.result() == 5
    assert (tmp_path / "begun").read_text() == first


def test_a_process_killed_from_outside_costs_its_own_call_only(two: LocalProcesses, tmp_path: Path) -> None:
    calls = [two.submit(begin_and_wait, tmp_path / f"begun{k}", tmp_path / "go", k) for k in range(2)]
    for k in range(2):
        wait_for(tmp_path / f"begun{k}")
    numbers = [int((tmp_path / f"begun{k}").read_text()) for k in range(2)]
    (tmp_path / "begun0").unlink()
    os.kill(numbers[0], signal.SIGKILL)
    wait_for(tmp_path / "begun0")
    assert int((tmp_path / "begun0").read_text()) not in numbers
    assert int((tmp_path / "begun1").read_text()) == numbers[1]
    (tmp_path / "go").touch()
    assert [call.result() for call in calls] == [0, 1]


def test_a_process_that_left_work_running_does_no_more_calls(tmp_path: Path) -> None:
    with LocalProcesses(1) as one:
        left = one.submit(leave_work, tmp_path / "go").result()
        after = {one.submit(process_and, value).result()[0] for value in range(3)}
    assert len(after) == 1
    assert left not in after


def test_a_call_that_ends_every_process_is_given_up(two: LocalProcesses, tmp_path: Path) -> None:
    with pytest.raises(WorkerDied, match=r"each of 3 processes ended: SIGKILL, SIGKILL, SIGKILL"):
        two.submit(die, tmp_path / "count").result()
    assert len((tmp_path / "count").read_text()) == MOST_DEATHS
    assert two.submit(doubled, 3).result() == 6


def test_kill_ends_what_runs_and_cancels_what_waits(tmp_path: Path) -> None:
    executor = LocalProcesses(1)
    running = executor.submit(begin_and_wait, tmp_path / "begun", tmp_path / "never", 1)
    waiting = executor.submit(doubled, 1)
    wait_for(tmp_path / "begun")
    number = int((tmp_path / "begun").read_text())
    executor.kill()
    with pytest.raises(WorkerDied):
        running.result(timeout=10)
    with pytest.raises(CancelledError):
        waiting.result(timeout=10)
    assert not is_there(number)
    with pytest.raises(RuntimeError):
        executor.submit(doubled, 1)


def test_processes_end_with_the_one_that_began_them(tmp_path: Path) -> None:
    code = (
        "import sys, pathlib; from rota.engines.processes import LocalProcesses;"
        "from tests.engines.calls import begin_and_wait; folder = pathlib.Path(sys.argv[1]);"
        "LocalProcesses(1).submit(begin_and_wait, folder / 'begun', folder / 'never', 1).result()"
    )
    root = Path(__file__).parents[2]
    parent = subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], cwd=root)
    try:
        wait_for(tmp_path / "begun")
    finally:
        parent.kill()
        parent.wait()
    number = int((tmp_path / "begun").read_text())
    end_s = time.monotonic() + 30
    while is_there(number):
        assert time.monotonic() < end_s, "the process outlived its parent"
        time.sleep(0.01)


def is_there(number: int) -> bool:
    """Whether there is such a process that has not ended."""
    try:
        return Path(f"/proc/{number}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False
