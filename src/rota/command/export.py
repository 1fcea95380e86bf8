"""What `rota export` does once its plan is read: write it for maps or for robots."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from rota.command.terminal import STANDARD_STREAM, say
from rota.errors import RotaError

if TYPE_CHECKING:
    from rota.plan import Plan

ExportFormat = Literal["geojson", "qgroundcontrol", "qgroundcontrol-px4", "create2-sketch"]


def write_export(answer: Plan, to: ExportFormat, output: str) -> tuple[str | Path, ...]:
    """Write the plan in a format; returns the paths written: one for a map, one per robot otherwise, none for stdout.

    output: a file for ``geojson`` (``-`` for stdout), else a folder.
    """
    if to == "geojson":
        return _write_map(answer, output)
    if output == STANDARD_STREAM:
        raise RotaError(f"-: {to} makes one file per robot and cannot write to stdout; the path of a folder is needed")
    if to == "create2-sketch":
        return _write_sketches(answer, output)
    from rota.files.qgroundcontrol import write_qgroundcontrol

    return write_qgroundcontrol(answer, output, autopilot="ardupilot" if to == "qgroundcontrol" else "px4")


def _write_map(answer: Plan, output: str) -> tuple[str, ...]:
    """The plan as GeoJSON; with a warning where maps would look for it elsewhere."""
    from rota.files.geojson import geojson_text, write_geojson

    if answer.mission.origin is None:
        say("warning: the mission has no origin: coordinates are in local metres, not in WGS84 as maps expect")
    if output == STANDARD_STREAM:
        sys.stdout.write(geojson_text(answer))
        sys.stdout.flush()
        return ()
    write_geojson(answer, output)
    return (output,)


def _write_sketches(answer: Plan, folder: str) -> tuple[Path, ...]:
    """A sketch per robot, which may drive slower than planned as far as all demands stay met."""
    from rota.check import check_plan
    from rota.files.create2_legs import MOST_SLOWING
    from rota.files.create2_sketch import write_create2_sketches

    # a slower clock makes every gap as much longer
    ratio = check_plan(answer).worst_ratio
    most = min(1 / ratio if ratio > 0 else MOST_SLOWING, MOST_SLOWING)
    return write_create2_sketches(answer, folder, most_slowing=max(most, 1.0))
