"""What several commands take: a plan's path, an effort, a file to write."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from rota.command.terminal import STANDARD_STREAM

if TYPE_CHECKING:
    from rota.mission import Mission
    from rota.plan import Plan

PICTURES = (".png", ".svg", ".pdf")

EffortName = Literal["quick", "normal", "high"]
PlanPath = Annotated[str, typer.Argument(metavar="PLAN", help="A plan file; - reads stdin.")]


def read_plan_argument(path: str) -> Plan:
    """The plan of a file, or of stdin where the path is ``-``."""
    from rota.files.plan_file import plan_from_text, read_plan

    return plan_from_text(sys.stdin.buffer.read(), "stdin") if path == STANDARD_STREAM else read_plan(path)


def compiled_for_check(mission: Mission) -> tuple[str, ...]:
    """The package whose loops the check of a mission's plans runs: none where no period asks for every point."""
    every_point = any(zone.period_s is not None and zone.demand == "every_point" for zone in mission.zones)
    return ("check",) if every_point or mission.period_s is not None else ()


def require_target(target: str, source: str | Path) -> None:
    """Refuse what is known beforehand not to work, and to overwrite the input."""
    from rota.files import atomic_write

    if target != STANDARD_STREAM:
        atomic_write.require_target(target, source)
