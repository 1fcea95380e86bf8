"""Reads mutated missions one after another, and tells of each on a line: what became of it, CPU seconds, peak bytes.

Run by ``reader_runs`` in a process of its own, so that a crash is noticed: ``benchmarks.reader_process FIRST END``.
"""

from __future__ import annotations

import os
import resource
import sys
import tempfile
import time
import traceback
from pathlib import Path

from benchmarks.mutated_missions import mutated
from rota.errors import RotaError
from rota.files.mission_file import read_mission
from rota.files.plan_file import plan_from_text, plan_text
from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory


def main() -> None:
    """Read those of the seeds from FIRST on, below END."""
    first, end = map(int, sys.argv[1:])
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for seed in range(first, end):
            print(seed, "began", flush=True)
            name, files = mutated(seed)
            for path, data in files.items():
                Path(path).write_bytes(data)
            began_s = time.process_time()
            outcome = outcome_of(name, confine=seed % 2 == 0)
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
            print(seed, outcome, f"{time.process_time() - began_s:.3f}", peak, flush=True)


def outcome_of(name: str, *, confine: bool) -> str:
    """read, refused, or fault with its type; a mission that is read must come back from a plan file as it was."""
    try:
        mission = read_mission(name, confine=confine).mission
        require_same(mission)
    except RotaError as error:
        return "refused" if all(line.startswith(name) for line in str(error).splitlines()) else "fault-unplaced"
    except Exception as error:
        traceback.print_exc()
        return f"fault-{type(error).__name__}"
    return "read"


def require_same(mission: Mission) -> None:
    """Raise AssertionError where the mission is another one once it has been written to a plan file and read."""
    kinds = [f"{kind.name}-1" for kind in mission.fleet.kinds]
    names = [*(robot.name for robot in mission.fleet.robots or ()), *kinds, "robot-1"][:1]
    place = mission.area.representative_point()
    standing = tuple(Trajectory(robot=name, times_s=[0.0], positions_m=[[place.x, place.y]]) for name in names)
    plan = Plan(mission=mission, trajectories=standing)
    assert plan_from_text(plan_text(plan).encode(), "plan") == plan


if __name__ == "__main__":
    main()
