"""A step of the published controller beside one of pyrvo (RVO2): as many robots, as dense, with as many neighbours."""

from __future__ import annotations

import json
import math
import statistics
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

from benchmarks.peer_environment import peer_python
from benchmarks.row import Options, Row
from benchmarks.swarm_step import AREA_M2, SETTLING_STEPS, swarm_of

REQUIREMENT, PROGRAM = "pyrvo", "peer_crowd.py"
ROBOTS, STEPS = 100_000, 41


def swarm_peer(options: Options) -> Iterator[Row]:
    """Both in one thread, a step of each in turns, so that both have the machine as it is."""
    name = f"swarm, {ROBOTS:,} robots, one thread, beside pyrvo with the same density, neighbours and range"
    python = peer_python(options.folder, REQUIREMENT, PROGRAM)
    if isinstance(python, str):
        yield Row(name, "as fast", f"not measured: {python}", None)
        return
    problem = {
        "robots": ROBOTS,
        "side_m": math.sqrt(ROBOTS * AREA_M2),
        "time_step_s": 0.25,
        "range_m": 51.0,
        "neighbours": 4,
        "body_m": 0.5,
        "speed_m_s": 2.0,
    }
    file = options.folder / "peer-crowd-problem.json"
    file.write_text(json.dumps(problem))
    version, mine, theirs = in_turns(python, file)
    ours, peers = statistics.median(mine) / ROBOTS * 1e6, statistics.median(theirs) / ROBOTS * 1e6
    measured = f"{peers / ours:.2f} x as fast: {ours:.2f} us for one robot, pyrvo {version} {peers:.2f} us; CPU medians"
    yield Row(name, "as fast", measured, ours <= peers)


def in_turns(python: Path, problem: Path) -> tuple[str, list[float], list[float]]:
    """The peer's version, and CPU seconds of many steps of ours and of theirs, made in turns."""
    swarm = swarm_of(ROBOTS)
    mine, theirs = [], []
    # -I: without the paths by which this project is found
    command = [python, "-I", Path(__file__).with_name(PROGRAM), problem]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1) as peer:
        assert peer.stdin is not None
        assert peer.stdout is not None
        version = peer.stdout.readline().strip()
        for _ in range(SETTLING_STEPS + STEPS):
            began_s = time.process_time()
            swarm.step()
            mine.append(time.process_time() - began_s)
            peer.stdin.write("step\n")
            theirs.append(float(peer.stdout.readline()))
        peer.stdin.close()
    return version, mine[SETTLING_STEPS:], theirs[SETTLING_STEPS:]
