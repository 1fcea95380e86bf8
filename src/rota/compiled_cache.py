"""Whether numba has compiled the kernels already: a first run says why it takes a minute, and uses a second core."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PACKAGE = Path(__file__).parent


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


# a robot that circles a block: it takes the check through sight, motion and two bodies' separation
_CHECK_SOMETHING = """
from shapely import MultiPolygon, box
from rota.check import check_plan
from rota.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.plan import Plan, Trajectory
ring = [[2, 2], [18, 2], [18, 18], [2, 18], [2, 2]]
mission = Mission(
    name="first run", area=MultiPolygon([box(0, 0, 20, 20)]), period_s=100,
    obstacles=(Obstacle(shape=MultiPolygon([box(8, 8, 12, 12)])),),
    fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=5), body_radius_m=0.1),
)
robots = [Trajectory(robot=f"robot-{k}", times_s=[0, 16, 32, 48, 64], positions_m=ring) for k in (1, 2)]
check_plan(Plan(mission=mission, trajectories=tuple(robots)))
"""


@contextmanager
def check_compiled_meanwhile() -> Iterator[None]:
    """Let another process compile the check while this one compiles the planner: a first plan comes sooner.

    Both write numba's shared cache, of different packages. Should that process fail, the check is compiled here later.
    """
    quiet = subprocess.DEVNULL
    process = subprocess.Popen([sys.executable, "-c", _CHECK_SOMETHING], stdin=quiet, stdout=quiet, stderr=quiet)
    try:
        yield
    finally:
        process.kill()
        process.wait()
