"""A dask scheduler and workers as processes of their own, on loopback."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

WITHIN_S = 120.0
ROOT = Path(__file__).parents[2]


class Loopback:
    """A scheduler, and workers that are begun one by one."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._file = folder, folder / "scheduler.json"
        self._processes: list[subprocess.Popen[bytes]] = []
        self._begin("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(self._file))
        end_s = time.monotonic() + WITHIN_S
        while not self._file.exists() or not self._file.read_text().endswith("}"):
            assert time.monotonic() < end_s, self.log()
            time.sleep(0.02)
        self.address: str = json.loads(self._file.read_text())["address"]

    def worker(self) -> subprocess.Popen[bytes]:
        """A new worker of one thread, which joins when it is ready."""
        return self._begin("worker", self.address, "--host", "127.0.0.1", "--nthreads", "1", "--no-nanny")

    def _begin(self, what: str, *options: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "dask", what, *options, "--no-dashboard"]
        with (self._folder / "log.txt").open("ab") as log:
            process = subprocess.Popen(command, stdout=log, stderr=log, cwd=ROOT)
        self._processes.append(process)
        return process

    def log(self) -> str:
        """What scheduler and workers said."""
        return (self._folder / "log.txt").read_text()

    def end(self) -> None:
        """End them all."""
        for process in reversed(self._processes):
            process.kill()
            process.wait()


@contextmanager
def loopback(folder: Path) -> Iterator[Loopback]:
    """A scheduler within the block, as yet without workers."""
    found = Loopback(folder)
    try:
        yield found
    finally:
        found.end()
