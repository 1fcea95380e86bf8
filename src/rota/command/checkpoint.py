"""Checkpoints on the command line: where that of a stopped run is kept, and what is said of it."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from rota.command.terminal import say

if TYPE_CHECKING:
    from rota.planning.checkpoint import Checkpoint

PLAN_SUFFIX, CHECKPOINT_SUFFIX = ".rota.json", ".rota-run"


def checkpoint_path(plan_path: str, resumed: str | None) -> str | None:
    """Where a run is kept: where it was resumed from, or beside its plan; None for a plan that goes to stdout."""
    if resumed is not None or plan_path == "-":
        return resumed
    return stem_of(plan_path) + CHECKPOINT_SUFFIX


def stem_of(plan_path: str) -> str:
    """A plan file's path without its suffix, of which ``.rota.json`` is one."""
    stem = plan_path.removesuffix(PLAN_SUFFIX)
    return stem if stem != plan_path else os.path.splitext(plan_path)[0]


def keep_checkpoint(checkpoint: Checkpoint, plan_path: str, resumed: str | None) -> None:
    """Write a run that ended before its robots came to rest, and say how it goes on."""
    from rota.files.checkpoint_file import write_checkpoint

    path, end = checkpoint_path(plan_path, resumed), f"the robots were not at rest after {checkpoint.steps} steps"
    if path is None:
        say(f"{end}; a plan that goes to stdout leaves no run to go on with")
        return
    write_checkpoint(checkpoint, path)
    settings = checkpoint.mission.planning
    most = settings.most_steps
    done = most is not None and checkpoint.steps >= most
    more = f" and {settings.planner}.most_steps of more than {most}" if done else ""
    say(f"{end}; the same plan command with --resume {path}{more} goes on")
