"""The runs of a swarm on the command line: where a stopped one is kept, and what is said of it."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from rota.command.terminal import say

if TYPE_CHECKING:
    from rota.checkpoint import SwarmState

PLAN_SUFFIX, RUN_SUFFIX = ".rota.json", ".rota-run"


def run_path(plan_path: str, resumed: str | None) -> str | None:
    """Where a run is kept: where it was resumed from, or beside its plan; None for a plan that goes to stdout."""
    if resumed is not None or plan_path == "-":
        return resumed
    stem = plan_path.removesuffix(PLAN_SUFFIX)
    return (stem if stem != plan_path else os.path.splitext(plan_path)[0]) + RUN_SUFFIX


def keep_run(run: SwarmState, plan_path: str, resumed: str | None) -> None:
    """Write a run that ended before its robots came to rest, and say how it goes on."""
    from rota.files.run_file import write_run

    path, end = run_path(plan_path, resumed), f"the robots were not at rest after {run.steps} steps"
    if path is None:
        say(f"{end}; a plan that goes to stdout leaves no run to go on with")
        return
    write_run(run, path)
    most = run.mission.swarm.most_steps
    more = f" and swarm.most_steps of more than {most}" if run.steps >= most else ""
    say(f"{end}; the same plan command with --resume {path}{more} goes on")
