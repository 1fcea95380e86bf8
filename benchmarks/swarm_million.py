"""A million robots for a thousand steps: ``python -m benchmarks.swarm_million STEPS`` makes them and prints seconds."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator

from benchmarks.row import Options, Row
from benchmarks.shell import python
from benchmarks.swarm_step import SIZES, swarm_of

ROBOTS, THREADS = SIZES[-1], 2
MOST_BYTES = 4e9
PATIENCE_S = 3 * 3600.0


def swarm_million(options: Options) -> Iterator[Row]:
    """In a process of its own, whose memory is that of the run."""
    run = python("-m", "benchmarks.swarm_million", str(options.steps), patience_s=PATIENCE_S)
    name, asked = f"swarm, {ROBOTS:,} robots for {options.steps:,} steps, {THREADS} threads", "completes, < 4 GB"
    if run.code != 0:
        yield Row(name, asked, run.failure(), False)
        return
    told = json.loads(run.out)
    measured = (
        f"{run.peak_bytes / 1e9:.2f} GB; {told['seconds']:,.0f} s, {told['seconds'] / options.steps:.2f} s a step;"
        f" last step: at most {told['farthest_m']:.2f} m"
    )
    yield Row(name, asked, measured, run.peak_bytes < MOST_BYTES)


def main() -> None:
    """Make the steps."""
    swarm = swarm_of(ROBOTS, THREADS)
    began_s, farthest_m = time.perf_counter(), 0.0
    for _ in range(int(sys.argv[1])):
        farthest_m = swarm.step()
    print(json.dumps({"seconds": time.perf_counter() - began_s, "farthest_m": farthest_m}))


if __name__ == "__main__":
    main()
