"""A folder with a file for each robot, named after it."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

from rota.errors import PlanError, RotaError
from rota.files.atomic_write import require_short_names, require_writable_folder, write_atomically
from rota.plan import Plan, Trajectory


def write_robot_files(
    plan: Plan, folder: str | os.PathLike[str], suffix: str, text_of: Callable[[Trajectory], str]
) -> tuple[Path, ...]:
    """Write ``ROBOT`` + ``suffix`` for each robot into ``folder`` (made if missing); returns their paths.

    Letters that file names cannot have everywhere become ``_``. Raises PlanError for robots whose names give the same
    file name, RotaError when the folder cannot be written to. Nothing is written unless every text could be made.
    """
    require_writable_folder(folder)
    texts: dict[str, str] = {}
    for trajectory in plan:
        name = (re.sub(r"[^\w.-]+", "_", trajectory.robot).lstrip(".") or "robot") + suffix
        if name.casefold() in (known.casefold() for known in texts):
            raise PlanError(f"robot {trajectory.robot}: another robot's file is called {name}; rename one of them")
        texts[name] = text_of(trajectory)
    require_short_names(texts)
    try:
        Path(folder).mkdir(exist_ok=True)
    except OSError as error:
        raise RotaError(f"{folder}: cannot be made: {error.strerror or error}") from error
    paths = tuple(Path(folder) / name for name in texts)
    for path, text in zip(paths, texts.values(), strict=True):
        write_atomically(path, text)
    return paths
