"""A hash per plan shows whether a change leaves plans as they are: ``python -m benchmarks.plan_hashes``.

Plans 60 random missions, all examples and the cases of Sun et al. 2019 at effort quick with seed 0, by all three
planners, and prints a line for each: name, robots, proved bound, and the beginning of the SHA-256 of the plan file; or
what kept it from planning. Lines come in the order of the names, on any number of processes. ``--against`` reads lines
printed before, tells which differ, and ends with 1 if any does.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import sys
import tempfile
from collections.abc import Iterator
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import rota
from benchmarks.missions import example_missions
from benchmarks.random_missions import random_mission
from benchmarks.sun_cases import CASES, FIGURE_16, write_case
from rota.errors import RotaError
from rota.model.mission import Mission
from rota.planners.patrol.planner_settings import PatrolSettings

RANDOM_MISSIONS = 60
SHOWN = 16  # hexadecimal digits


def names() -> list[str]:
    """Of all missions: a path in examples/, a case, or a seed."""
    return [
        *(f"examples/{path.name}" for path in example_missions()),
        *(f"case/{case.name}" for case in (*CASES, FIGURE_16)),
        *(f"random/{seed}" for seed in range(RANDOM_MISSIONS)),
    ]


def mission_of(name: str, folder: Path) -> Mission:
    """The mission of that name, at effort quick where it is planned by routes."""
    kind, which = name.split("/", 1)
    if kind == "random":
        mission = random_mission(int(which))
    elif kind == "case":
        case = next(case for case in (*CASES, FIGURE_16) if case.name == which)
        mission = rota.read_mission(write_case(case, folder)).mission
    else:
        mission = rota.read_mission(next(path for path in example_missions() if path.name == which)).mission
    return mission.with_effort("quick") if isinstance(mission.planning, PatrolSettings) else mission


def line_of(name: str, folder: Path) -> str:
    """Name, robots, bound and hash of the plan, or the error there was."""
    try:
        plan = rota.make_plan(mission_of(name, folder), seed=0)
    except RotaError as error:
        return f"{name}: {type(error).__name__}: {' '.join(str(error).split())}"
    path = folder / f"{os.getpid()}.rota.json"
    rota.write_plan(plan, path)
    kept = [line for line in path.read_text().splitlines(keepends=True) if "mission_sha256" not in line]
    told = hashlib.sha256("".join(kept).encode()).hexdigest()[:SHOWN]
    return f"{name}: {len(plan.trajectories)} robots, bound {plan.lower_bound_robots}, {told}"


def lines(chosen: list[str], processes: int) -> Iterator[str]:
    """The line of each mission, in their order."""
    with tempfile.TemporaryDirectory() as folder, get_context("spawn").Pool(processes) as pool:
        yield from pool.imap(partial(line_of, folder=Path(folder)), chosen)


def differences(before: list[str], now: list[str]) -> list[str]:
    """What lines printed before say otherwise, of the missions of now: ``before -> now``."""
    known = {line.split(": ", 1)[0]: line for line in before}
    return [
        f"{known.get(line.split(': ', 1)[0], 'not there before')} -> {line}"
        for line in now
        if known.get(line.split(": ", 1)[0]) != line
    ]


def main(arguments: list[str] | None = None) -> int:
    """Print the lines; 1 where they differ from those of ``--against``."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.plan_hashes", description="Print a hash per plan.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="some missions only, by the beginnings of their names")
    parser.add_argument("--against", type=Path, metavar="FILE", help="lines printed before")
    parser.add_argument("--processes", type=int, default=os.cpu_count(), metavar="N")
    chosen = parser.parse_args(arguments)
    wanted = [name for name in names() if not chosen.names or name.startswith(tuple(chosen.names))]
    before = chosen.against.read_text().splitlines() if chosen.against else None
    printed = []
    for line in lines(wanted, chosen.processes):
        print(line, flush=True)
        printed.append(line)
    found = differences(before, printed) if before is not None else []
    for line in found:
        print(f"differs: {line}", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
