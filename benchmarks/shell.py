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

    cpu_s: processor time of its process. ended_early: it was killed, since patience was at its end. cpu_s_after: of it
    what was used after the moment that ``run`` was told to look at; None: it had ended before.
    """

    wall_s: float
    peak_bytes: int
    code: int
    out: str
    err: str
    cpu_s: float = 0.0
    ended_early: bool = False
    cpu_s_after: float | None = None

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
    look_after_s: float | None = None,
    sends: int = 0,
) -> Run:
    """Run ``command`` to its end, and no longer than ``patience_s``; ``environment`` is added to the inherited one.

    look_after_s: when to read its processor time (Linux) and to send it the signal ``sends``, 0: none.
    Python keeps what it compiled, as it does for users: where the shell forbids that, every start would take seconds.
    """
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        started_s = time.perf_counter()
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=out, stderr=err, env={**os.environ, **KEPT, **(environment or {})}
        )
        patience = threading.Timer(patience_s, process.kill)
        patience.start()
        used_s: list[float] = []
        look = threading.Timer(look_after_s or 0.0, lambda: used_s.append(_looked_at(process, sends)))
        if look_after_s is not None:
            look.start()
        peak = _PeakMemory(process.pid)
        peak.start()
        # wait4 gives this process's own peak; RUSAGE_CHILDREN would give the largest of all so far
        _, status, usage = os.wait4(process.pid, 0)
        wall_s = time.perf_counter() - started_s
        process.returncode = os.waitstatus_to_exitcode(status)
        patience.cancel()
        look.cancel()
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
        cpu_s_after=usage.ru_utime + usage.ru_stime - used_s[0] if used_s else None,
    )


def _looked_at(process: subprocess.Popen[bytes], sends: int) -> float:
    """Processor seconds that the process has used, with those of its children that have ended; then the signal."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    if sends:
        process.send_signal(sends)
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")


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


def rota(
    *arguments: str | Path,
    environment: Mapping[str, str] | None = None,
    patience_s: float = PATIENCE_S,
    look_after_s: float | None = None,
    sends: int = 0,
) -> Run:
    """Run the installed ``rota`` program, as ``run`` does."""
    command = [Path(sysconfig.get_path("scripts")) / "rota", *arguments]
    return run(command, environment=environment, patience_s=patience_s, look_after_s=look_after_s, sends=sends)


def python(*arguments: str | Path, patience_s: float = PATIENCE_S) -> Run:
    """Run this Python interpreter."""
    return run([sys.executable, *arguments], patience_s=patience_s)
