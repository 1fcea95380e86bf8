"""What the tests of the executors call: functions that other processes can import."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

from rota.planning.stopping import OwnThread


def doubled(value: int) -> int:
    return 2 * value


def process_and(value: int) -> tuple[int, int]:
    return os.getpid(), value


def refuse(why: str) -> None:
    raise ValueError(why)


def die_at_first(mark: Path, value: int) -> int:
    """End the process that calls this before any other; the next one finds the mark."""
    try:
        mark.touch(exist_ok=False)
    except FileExistsError:
        return value
    os.kill(os.getpid(), signal.SIGKILL)
    return -1


def die(count: Path) -> None:
    """End the process, and note it."""
    with count.open("a") as stream:
        stream.write("x")
    os.kill(os.getpid(), signal.SIGKILL)


def leave_work(go: Path) -> int:
    """Leave a thread that works until a file is there; answer with this process's number."""
    assert OwnThread(lambda: wait_for(go)).result(lambda: True) is None
    return os.getpid()


def begin_and_wait(begun: Path, go: Path, value: int) -> int:
    """Tell that it began, by a file with the process's number; answer once another file is there."""
    partial = begun.with_suffix(f".{os.getpid()}")
    partial.write_text(str(os.getpid()))
    partial.replace(begun)
    wait_for(go)
    return value


def wait_for(path: Path, within_s: float = 60.0) -> None:
    """Return once there is such a file."""
    end_s = time.monotonic() + within_s
    while not path.exists():
        assert time.monotonic() < end_s, f"{path} did not come"
        time.sleep(0.005)


def printed(text: str) -> str:
    print(text)
    return text


def environment(name: str) -> str | None:
    return os.environ.get(name)


def cores() -> int | None:
    return os.cpu_count()
