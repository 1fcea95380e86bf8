"""What exports hand the programs of Create 2 robots: how much slower they may drive, and how long covering takes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rota.model.plan import Plan


def create2_sketches(plan: Plan, folder: str) -> tuple[Path, ...]:
    """A sketch per robot, which may drive slower than planned as far as all demands stay met."""
    from rota.check import check_plan
    from rota.files.create2_legs import MOST_SLOWING
    from rota.files.create2_sketch import write_create2_sketches

    # a slower clock makes every gap as much longer
    ratio = check_plan(plan).worst_ratio
    most = min(1 / ratio if ratio > 0 else MOST_SLOWING, MOST_SLOWING)
    return write_create2_sketches(plan, folder, most_slowing=max(most, 1.0))


def create2_programs(plan: Plan, folder: str) -> tuple[Path, ...]:
    """A program per robot that only reacts, with how long that takes to cover the ground."""
    from rota.files.create2_reactive import write_create2_programs

    return write_create2_programs(plan, folder, covers=covering_time(plan) or "not known")


def covering_time(plan: Plan) -> str | None:
    """How long robots that only react take to cover their ground; None of robots that do not bounce."""
    from rota.planning.planner import planner_of

    return planner_of(plan.mission).covering_time(plan)
