"""Whether numba has compiled the kernels already: a first run says why it takes a minute, and uses a second core."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PACKAGE = Path(__file__).parents[1]


def is_compiled(*packages: str) -> bool:
    """Whether ``kernels.py`` of each of ``packages`` (folders below rota) has a compiled form no older than itself.

    A guess for a message to people: numba itself decides, function by function, and many functions are for missions
    of some kind only. A package without ``kernels.py`` counts as compiled.
    """
    files = [PACKAGE / package / "kernels.py" for package in packages]
    return all(_has_compiled_form(file) for file in files if file.exists())


def _has_compiled_form(file: Path) -> bool:
    made_s = file.stat().st_mtime
    return any(index.stat().st_mtime >= made_s for place in _places(file) for index in place.glob(f"{file.stem}.*.nbi"))


def _places(file: Path) -> list[Path]:
    # numba looks in this order; elsewhere than beside the file, it keeps one folder for each folder of sources, whose
    # name ends in that folder's name and a hash of its path
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    if chosen:
        return _folders_for(file, Path(chosen))
    return [file.parent / "__pycache__", *_folders_for(file, Path.home() / ".cache" / "numba")]


def _folders_for(file: Path, root: Path) -> list[Path]:
    return [folder for folder in root.glob(f"{file.parent.name}_*") if folder.is_dir()]


# the longest moves first, for they are wanted first; then all that a planner does before it anneals; then a robot that
# circles a block, which takes the check through sight, motion and two bodies' separation
_OTHER_HALF = """
import numpy as np
from shapely import MultiPolygon, box
from rota.planners.patrol.annealing.compile_ahead import compile_exchanges
compile_exchanges()
from rota.check import check_plan
from rota.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.plan import Plan, Trajectory
from rota.planners.patrol.annealing.search import Annealing
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.initial.allocation import period_groupings
ring = [[2, 2], [18, 2], [18, 18], [2, 18], [2, 2]]
mission = Mission(
    name="first run", area=MultiPolygon([box(0, 0, 20, 20)]), period_s=100,
    obstacles=(Obstacle(shape=MultiPolygon([box(8, 8, 12, 12)])),),
    fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=5), body_radius_m=0.1),
)
problem = set_up_problem(mission)
tours, one = period_groupings(problem, 1)[0].tours, np.ones(1)
weights = {'length_weight': one, 'budget_penalty': one}
Annealing(tours[:1], problem.samples, problem.paths.grid, **weights, seed=0, range_margin_m=0.01)
robots = [Trajectory(robot=f"robot-{k}", times_s=[0, 16, 32, 48, 64], positions_m=ring) for k in (1, 2)]
check_plan(Plan(mission=mission, trajectories=tuple(robots)))
"""


@contextmanager
def compiled_by_two() -> Iterator[None]:
    """Compile the annealing while another process compiles all else: a first plan comes sooner by a third.

    Both write numba's shared cache, of different functions; what the other has not finished is compiled when needed.
    """
    quiet = subprocess.DEVNULL
    process = subprocess.Popen([sys.executable, "-c", _OTHER_HALF], stdin=quiet, stdout=quiet, stderr=quiet)
    try:
        from rota.planners.patrol.annealing.compile_ahead import compile_moves

        compile_moves()
        yield
    finally:
        process.kill()
        process.wait()
