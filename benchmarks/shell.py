"""Runs of a command as a shell would make them: wall time, peak memory, exit code and what was printed."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import sysconfig
import tempfile
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

KEPT = {"PYTHONDONTWRITEBYTECODE": ""}  # empty: not set
PATIENCE_S = 900.0  # a command that takes longer is ended, unless told otherwise: its figure is missed many times over


@dataclass(frozen=True, kw_only=True)
class Run:
    """What one command took and said. ``peak_bytes``: most resident memory of its process.

    cpu_s: processor time of its process. ended_early: it was killed, since patience was at its end.
    """

    wall_s: float
    peak_bytes: int
    code: int
    out: str
    err: str
    cpu_s: float = 0.0
    ended_early: bool = False

    def failure(self) -> str:
        """Why it failed, in a few words."""
        lines = self.err.strip().splitlines() or ["nothing on stderr"]
        ended = "no end, killed" if self.ended_early else f"exit code {self.code}"
        return f"{ended} after {self.wall_s:.1f} s: {lines[-1]}"


def run(
    command: Sequence[str | Path],
    *,
    environment: Mapping[str, str] | None = None,
    patience_s: float = PATIENCE_S,
) -> Run:
    """Run ``command`` to its end, and no longer than ``patience_s``; ``environment`` is added to the inherited one.

    Python keeps what it compiled, as it does for users: where the shell forbids that, every start would take seconds.
    """
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        started_s = time.perf_counter()
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=out, stderr=err, env={**os.environ, **KEPT, **(environment or {})}
        )
        patience = threading.Timer(patience_s, process.kill)
        patience.start()
        peak = _PeakMemory(process.pid)
        peak.start()
        # wait4 gives this process's own peak; RUSAGE_CHILDREN would give the largest of all so far
        _, status, usage = os.wait4(process.pid, 0)
        wall_s = time.perf_counter() - started_s
        process.returncode = os.waitstatus_to_exitcode(status)
        patience.cancel()
        peak.join()
        texts = [_text(stream) for stream in (out, err)]
    return Run(
        wall_s=wall_s,
        peak_bytes=peak.of(usage),
        code=process.returncode,
        out=texts[0],
        err=texts[1],
        cpu_s=usage.ru_utime + usage.ru_stime,
        ended_early=wall_s >= patience_s,
    )


class _PeakMemory(threading.Thread):
    """The most resident memory of a child process.

    What the system tells at the child's end is never less than this process had at most when it started the child: on
    Linux the child counts as this process until it runs its own program. Where that hides the child's figure, the one
    counts that Linux tells of the child itself while it runs.
    """

    EVERY_S = 0.02

    def __init__(self, pid: int) -> None:
        super().__init__(daemon=True)
        self._status = Path(f"/proc/{pid}/status")
        self._own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        self._seen = 0  # kB

    def run(self) -> None:
        """Look again and again, until the process has ended."""
        while True:
            try:
                lines = self._status.read_text().splitlines()
            except OSError:  # it has ended, or this is no Linux
                return
            told = [int(line.split()[1]) for line in lines if line.startswith("VmHWM")]
            if not told:
                return  # it has given its memory back
            self._seen = max(self._seen, *told)
            time.sleep(self.EVERY_S)

    def of(self, usage: resource.struct_rusage) -> int:
        """In bytes, with what the system told at the end."""
        most = self._seen if self._seen and usage.ru_maxrss <= self._own else usage.ru_maxrss
        return most * (1 if sys.platform == "darwin" else 1024)


def _text(stream: IO[bytes]) -> str:
    stream.seek(0)
    return stream.read().decode(errors="replace")


def rota(*arguments: str | Path, environment: Mapping[str, str] | None = None, patience_s: float = PATIENCE_S) -> Run:
    """Run the installed ``rota`` program."""
    program = Path(sysconfig.get_path("scripts")) / "rota"
    return run([program, *arguments], environment=environment, patience_s=patience_s)


def python(*arguments: str | Path, patience_s: float = PATIENCE_S) -> Run:
    """Run this Python interpreter."""
    return run([sys.executable, *arguments], patience_s=patience_s)
