"""A folder with files for each robot, named after it."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path

from rota.errors import PlanError, RotaError
from rota.files.atomic_write import replaced_file, require_short_names, require_writable_folder
from rota.model.plan import Plan, Trajectory

PLAN_MARK, FILE_HEAD = b'"rota_plan"', 100  # how many bytes of a file are looked at for it


def write_robot_files(
    plan: Plan, folder: str | os.PathLike[str], suffix: str, text_of: Callable[[Trajectory], str]
) -> tuple[Path, ...]:
    """Write a file for each robot, ``ROBOT`` + ``suffix``; returns their paths. Raises as ``write_contents``."""
    return write_contents(plan, folder, lambda trajectory: {suffix: text_of(trajectory).encode()})


def write_contents(
    plan: Plan, folder: str | os.PathLike[str], contents_of: Callable[[Trajectory], Mapping[str, bytes]]
) -> tuple[Path, ...]:
    """Write ``ROBOT`` + suffix for each robot and suffix into ``folder`` (made if missing); returns their paths.

    contents_of: from suffixes to contents. Letters that file names cannot have everywhere become ``_``. Raises
    PlanError for robots whose names give the same file name, RotaError when the folder cannot be written to and when a
    file there, which would be replaced, is a plan of Rota, such as the one that is exported. Nothing is written
    unless every content could be made.
    """
    require_writable_folder(folder)
    contents: dict[str, bytes] = {}
    known: set[str] = set()
    for trajectory in plan:
        stem = re.sub(r"[^\w.-]+", "_", trajectory.robot).lstrip(".") or "robot"
        for suffix, content in contents_of(trajectory).items():
            name = stem + suffix
            if name.casefold() in known:
                raise PlanError(f"robot {trajectory.robot}: another robot's file is called {name}; rename one of them")
            known.add(name.casefold())
            contents[name] = content
    require_short_names(contents)
    for name in contents:
        _require_no_plan(Path(folder) / name)
    try:
        Path(folder).mkdir(exist_ok=True)
    except OSError as error:
        raise RotaError(f"{folder}: cannot be made: {error.strerror or error}") from error
    paths = tuple(Path(folder) / name for name in contents)
    for path, content in zip(paths, contents.values(), strict=True):
        with replaced_file(path) as partial:
            partial.write_bytes(content)
    return paths


def _require_no_plan(path: Path) -> None:
    """Raise RotaError for a plan file; what cannot be read is found out when it is written."""
    try:
        with path.open("rb") as file:
            is_plan = PLAN_MARK in file.read(FILE_HEAD)
    except OSError:
        return
    if is_plan:
        raise RotaError(f"{path}: is a plan of Rota and is not overwritten; name another folder")
