"""A million robots for a thousand steps: ``python -m benchmarks.swarm_million STEPS`` makes them and prints seconds."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator

from benchmarks.row import Options, Row
from benchmarks.shell import python
from benchmarks.swarm_step import SIZES, swarm_of
from rota.planners.swarm.deciding import FEWEST_IN_BLOCKS

ROBOTS, THREADS = SIZES[-1], 2
MOST_BYTES, MOST_STEP_S = 4e9, 0.06
PATIENCE_S = 3 * 3600.0


def swarm_million(options: Options) -> Iterator[Row]:
    """In a process of its own, whose memory is that of the run."""
    run = python("-m", "benchmarks.swarm_million", str(options.steps), patience_s=PATIENCE_S)
    name = f"swarm, {ROBOTS:,} robots for {options.steps:,} steps, {THREADS} threads"
    asked = f"< {MOST_STEP_S * options.steps:.0f} s, < 4 GB"
    if run.code != 0:
        yield Row(name, asked, run.failure(), False)
        return
    told = json.loads(run.out)
    measured = (
        f"{told['seconds']:,.0f} s, {told['seconds'] / options.steps * 1e3:.0f} ms a step;"
        f" {told['cpu_seconds']:,.0f} s of processor time; {run.peak_bytes / 1e9:.2f} GB;"
        f" last step: at most {told['farthest_m']:.2f} m"
    )
    soon = told["seconds"] < MOST_STEP_S * options.steps
    yield Row(name, asked, measured, soon and run.peak_bytes < MOST_BYTES)


def main() -> None:
    """Make the steps."""
    swarm_of(FEWEST_IN_BLOCKS).step()  # compiles
    swarm = swarm_of(ROBOTS, THREADS)
    began_s, began_cpu_s, farthest_m = time.perf_counter(), time.process_time(), 0.0
    for _ in range(int(sys.argv[1])):
        farthest_m = swarm.step()
    seconds, cpu_seconds = time.perf_counter() - began_s, time.process_time() - began_cpu_s
    print(json.dumps({"seconds": seconds, "cpu_seconds": cpu_seconds, "farthest_m": farthest_m}))


if __name__ == "__main__":
    main()
