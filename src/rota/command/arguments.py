"""What several commands take: a plan's path, an effort, a file to write."""

from __future__ import annotations

import sys
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from rota.command.terminal import STANDARD_STREAM

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from rota.model.plan import Plan

PICTURES = (".png", ".svg", ".pdf")

EffortName = Literal["quick", "normal", "high"]
ClusterAddress = Annotated[
    str | None,
    typer.Option(
        "--cluster", metavar="ADDRESS", help="Work on a dask cluster: its scheduler's address, tcp://HOST:8786."
    ),
]
PlanPath = Annotated[str, typer.Argument(metavar="PLAN", help="A plan file; - reads stdin.")]


def read_plan_argument(path: str) -> Plan:
    """The plan of a file, or of stdin where the path is ``-``."""
    from rota.files.plan_file import plan_from_text, read_plan

    return plan_from_text(sys.stdin.buffer.read(), "stdin") if path == STANDARD_STREAM else read_plan(path)


def cluster_or_none(address: str | None) -> AbstractContextManager[Executor | None]:
    """The workers of a cluster within a block; None, which means this process alone, where no address is given."""
    if address is None:
        return nullcontext()
    from rota.engines.workers import workers

    return workers(address)


def require_target(target: str, source: str | Path) -> None:
    """Refuse what is known beforehand not to work, and to overwrite the input."""
    from rota.files import atomic_write

    if target != STANDARD_STREAM:
        atomic_write.require_target(target, source)
