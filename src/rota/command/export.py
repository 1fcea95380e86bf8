"""What `rota export` does once its plan is read: write it for maps or for robots.

``TEXTS`` and ``FOLDERS`` name all formats; the command line takes its choices and its help from them.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from rota.command.terminal import STANDARD_STREAM, say
from rota.errors import RotaError

if TYPE_CHECKING:
    from rota.plan import Plan


def geojson(plan: Plan) -> str:
    """A map's text; with a warning where maps would look for it elsewhere."""
    from rota.files.geojson import geojson_text

    if plan.mission.origin is None:
        say("warning: the mission has no origin: coordinates are in local metres, not in WGS84 as maps expect")
    return geojson_text(plan)


def ardupilot_missions(plan: Plan, folder: str) -> tuple[Path, ...]:
    """A QGroundControl plan per robot, for ArduPilot."""
    from rota.files.qgroundcontrol import write_qgroundcontrol

    return write_qgroundcontrol(plan, folder, autopilot="ardupilot")


def px4_missions(plan: Plan, folder: str) -> tuple[Path, ...]:
    """A QGroundControl plan per robot, for PX4."""
    from rota.files.qgroundcontrol import write_qgroundcontrol

    return write_qgroundcontrol(plan, folder, autopilot="px4")


def create2_sketches(plan: Plan, folder: str) -> tuple[Path, ...]:
    """A sketch per robot, which may drive slower than planned as far as all demands stay met."""
    from rota.check import check_plan
    from rota.files.create2_legs import MOST_SLOWING
    from rota.files.create2_sketch import write_create2_sketches

    # a slower clock makes every gap as much longer
    ratio = check_plan(plan).worst_ratio
    most = min(1 / ratio if ratio > 0 else MOST_SLOWING, MOST_SLOWING)
    return write_create2_sketches(plan, folder, most_slowing=max(most, 1.0))


# formats of one file: its text
TEXTS: dict[str, Callable[[Plan], str]] = {
    "geojson": geojson,
}
# formats of a folder with a file per robot: what writes it and returns the paths
FOLDERS: dict[str, Callable[[Plan, str], tuple[Path, ...]]] = {
    "qgroundcontrol": ardupilot_missions,
    "qgroundcontrol-px4": px4_missions,
    "create2-sketch": create2_sketches,
}
FORMATS = (*TEXTS, *FOLDERS)
FORMATS_HELP = f"{', '.join(TEXTS)} (a file); {', '.join(FOLDERS)} (a folder)."


def export_format(name: str) -> str:
    """The name of a format; raises RotaError for others."""
    if name not in FORMATS:
        raise RotaError(f"--to: {name!r} is not one of {', '.join(map(repr, FORMATS))}")
    return name


def write_export(plan: Plan, source: str, to: str, output: str) -> tuple[str | Path, ...]:
    """Write the plan, read from ``source``, in a format; returns the paths written, none for stdout.

    output: a file for a format of one file (``-`` for stdout), else a folder.
    """
    if to in TEXTS:
        return _write_text(plan, source, TEXTS[to], output)
    if output == STANDARD_STREAM:
        raise RotaError(f"-: {to} makes one file per robot and cannot write to stdout; the path of a folder is needed")
    return FOLDERS[to](plan, output)


def _write_text(plan: Plan, source: str, text_of: Callable[[Plan], str], output: str) -> tuple[str, ...]:
    from rota.files.atomic_write import require_target, write_atomically

    if output == STANDARD_STREAM:
        sys.stdout.write(text_of(plan))
        sys.stdout.flush()
        return ()
    require_target(output, source)
    write_atomically(output, text_of(plan))
    return (output,)
