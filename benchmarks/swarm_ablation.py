"""What each mechanism of the swarm's default controller is worth: ``python -m benchmarks.swarm_ablation``.

Kernels are compiled with what they are made of. So the sources are copied, one mechanism is written out of the copy,
and a process of its own measures that. Prints a row of a table for each; ``--only NAME`` measures one.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from shapely import MultiPolygon, Polygon

from benchmarks.missions import EXAMPLES
from benchmarks.swarm_coverage import mission
from benchmarks.swarm_rest import DIAMETERS_M, covered, door, grid, like, places_of
from rota.files.mission_file import read_mission
from rota.geometry.free_space import free_ground
from rota.model.mission import Mission, Obstacle, StartBox
from rota.planners.swarm.metrics import covered_share
from rota.planners.swarm.planner import SwarmRun, run_mission
from rota.planners.swarm.sensing import sensors_of

SOURCES = Path(__file__).parents[1] / "src"
LEFT_OUT = {  # the file in planners/swarm, what is written there, and what instead
    "nothing": ("rest.py", "", ""),
    "waiting for true news": ("rollout.py", "(settled >= graph.far_m) | (settled", "(graph.away_m[1 - step % 2]"),
    "waiting for any news": ("planner.py", " and swarm.news_rest else 0", " else 0"),
    "rest as a share of what robots drive": ("rest.py", "WANTS_SHARE = 0.01,", "WANTS_SHARE = 1e9,"),
    "lesser pushes in crowds": ("settle_kernels.py", "pushes(i, neighbours, crowd,", "pushes(i, neighbours, False,"),
    "these only without free ground": ("settle_kernels.py", "crowd and away_m >=", "crowd and 1e300 >="),
    "parking": ("settle_kernels.py", "    if told:\n        parked", "    if False:\n        parked"),
    "no parking side by side": ("settle_kernels.py", "max(parked, tight)", "parked"),
    "friction by short steps": ("friction_kernels.py", "min(sensor_m, STEPS_FOR_SENSOR * most_m)", "sensor_m"),
    "friction that grows": ("friction_kernels.py", "if impatience > 0.0 else", "if impatience > 1e9 else"),
    "bodies widened less at doors": ("planner.py", "passable_reserve_m(mission, ground, ", "("),
}  # fmt: skip
CROWDS, CROWD_SEEDS, SEEDS, DOOR_SEEDS = (30, 45, 60, 80, 100, 150), range(10, 20), range(15), range(5, 10)
STEP_SHARES = (1e-4, 3e-4, 1e-3, 1e-2, 0.1)
U = Polygon([(40, 40), (110, 40), (110, 120), (105, 120), (105, 45), (45, 45), (45, 120), (40, 120)])


def rows() -> Iterator[str]:
    """The cells of a mechanism's row."""
    for name in ("swarm-port", "swarm-square", "swarm-squares"):
        asked = read_mission(EXAMPLES / f"{name}.yaml").mission
        runs = [run_mission(asked, seed=seed) for seed in SEEDS]
        share = np.mean([covered_share(places_of(run), sensors_of(asked), free_ground(asked)) for run in runs])
        yield f"{share:.1%}, {steps(runs)}"
    crowds = [in_square(robots, 60.0, 20.0, StartBox(low_m=(2, 2), high_m=(58, 58))) for robots in CROWDS]
    yield resting([run_mission(asked, seed=seed) for asked in crowds for seed in CROWD_SEEDS])
    prompt = [(share, covered(run_mission(grid(share, 0), seed=0))) for share in STEP_SHARES]
    late = [(run_mission(grid(share, delay), seed=0), most) for share, most in prompt for delay in (1, 2)]
    yield f"{min(covered(run) / most for run, most in late):.0%}; {resting([run for run, _ in late])}"
    passed = [(places_of(run_mission(door(d), seed=seed))[:, 0] > 10).sum() for d in DIAMETERS_M for seed in DOOR_SEEDS]
    yield f"{min(passed)} to {max(passed)}"
    u = in_square(25, 150.0, 16.0, StartBox(low_m=(52, 52), high_m=(98, 98)))
    u = replace(u, obstacles=(Obstacle(shape=MultiPolygon([U])),))
    yield resting([run_mission(u, seed=seed) for seed in range(10)])


def in_square(robots: int, side_m: float, sensor_m: float, start: StartBox) -> Mission:
    """Robots of 2 m/s in a square."""
    return like(mission(robots, (side_m, side_m), start, 6000), sensor_m, 2.0, 0.5)


def resting(runs: list[SwarmRun]) -> str:
    """How many runs end at rest, and the steps that they take."""
    return f"{sum(run.at_rest for run in runs)} of {len(runs)}, {steps(runs)}"


def steps(runs: list[SwarmRun]) -> str:
    """The mean of the steps that runs take."""
    return f"{np.mean([run.steps for run in runs]):.0f}"


def measure_without(name: str) -> str:
    """The row of one mechanism, measured by a process of its own."""
    file, old, new = LEFT_OUT[name]
    with tempfile.TemporaryDirectory() as folder:
        copied = Path(folder) / "src"
        shutil.copytree(SOURCES, copied)
        changed = copied / "rota" / "planners" / "swarm" / file
        text = changed.read_text()
        if old not in text:
            raise SystemExit(f"{name}: {file} has no {old!r} any more")
        changed.write_text(text.replace(old, new) if old else text)
        paths = os.pathsep.join([str(copied), str(SOURCES.parent)])
        environment = {**os.environ, "PYTHONPATH": paths, "NUMBA_CACHE_DIR": str(Path(folder) / "compiled")}
        command = [sys.executable, "-m", "benchmarks.swarm_ablation", "--measure"]
        return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout.strip()


def main() -> None:
    """Measure all mechanisms, or one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", choices=LEFT_OUT)
    parser.add_argument("--measure", action="store_true", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.measure:
        print(" | ".join(rows()))
        return
    for name in LEFT_OUT if asked.only is None else (asked.only,):
        print(f"| {name} | {measure_without(name)} |", flush=True)


if __name__ == "__main__":
    main()
