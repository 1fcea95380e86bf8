"""Mutated missions, read in a process of their own: none may crash the reader, or take long or much memory."""

from __future__ import annotations

import queue
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

from benchmarks.missions import PROJECT
from benchmarks.row import Options, Row

MISSIONS, FIRST_SEED = 5000, 10_000
LONGEST_S, MOST_BYTES = 10.0, 2e9
PATIENCE_S = 120.0  # for one mission, on a busy machine too, files and start of the process included


class Reading(NamedTuple):
    """What became of one mission: "read", "refused", or what went wrong."""

    seed: int
    outcome: str
    seconds: float
    peak_bytes: int


def mutated_missions(options: Options) -> Iterator[Row]:
    """A row for each mission that was neither read nor refused well, then one for all."""
    counts: Counter[str] = Counter()
    slowest, peak = Reading(0, "", 0.0, 0), 0
    for reading in readings(FIRST_SEED, FIRST_SEED + MISSIONS):
        ok = reading.outcome in ("read", "refused") and reading.seconds < LONGEST_S and reading.peak_bytes < MOST_BYTES
        if not ok:
            counts["fault"] += 1
            yield Row(
                f"mutated mission {reading.seed}",
                "read or refused",
                f"{reading.outcome}, {reading.seconds:.1f} s",
                False,
            )
        counts[reading.outcome] += 1
        slowest, peak = max(slowest, reading, key=lambda one: one.seconds), max(peak, reading.peak_bytes)
    yield Row(
        f"{MISSIONS:,} mutated missions: YAML, JSON, GeoJSON, ROS maps, images",
        "read or refused with line, value and what is allowed; each < 10 s, < 2 GB",
        f"{counts['read']} read, {counts['refused']} refused, {counts['fault']} neither; CPU {slowest.seconds:.1f} s, "
        f"{peak / 1e6:.0f} MB",
        counts["fault"] == 0,
    )


def readings(first: int, end: int) -> Iterator[Reading]:
    """What becomes of each mission; a process that dies or hangs is told, and the next one goes on behind it."""
    while first < end:
        began = first
        process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.reader_process", str(first), str(end)],
            cwd=PROJECT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        for line in _lines(process):
            seed, outcome, *figures = line.split()
            if figures:
                first = int(seed) + 1
                yield Reading(int(seed), outcome, float(figures[0]), int(figures[1]))
            else:
                began = int(seed)
        process.kill()
        code = process.wait()
        if first < end:
            yield Reading(began, f"the process ended with {code}", PATIENCE_S, 0)
            first = began + 1


def _lines(process: subprocess.Popen[str]) -> Iterator[str]:
    """The lines that a process prints, until it ends or prints nothing for ``PATIENCE_S``."""
    found: queue.Queue[str | None] = queue.Queue()

    def read() -> None:
        assert process.stdout is not None
        for line in process.stdout:
            found.put(line)
        found.put(None)

    threading.Thread(target=read, daemon=True).start()
    while True:
        try:
            line = found.get(timeout=PATIENCE_S)
        except queue.Empty:
            return
        if line is None:
            return
        yield line
