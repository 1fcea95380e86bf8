"""What several commands take: a plan's path, an effort, a file to write."""

from __future__ import annotations

import math
import sys
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from rota.command.terminal import STANDARD_STREAM, say
from rota.errors import RotaError

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from rota.model.mission import Mission
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


def read_and_warn(path: str | Path) -> Mission:
    """The mission of a file, with its warnings told."""
    from rota.files.mission_file import read_mission

    read = read_mission(path)
    for warning in read.warnings:
        say(f"warning: {warning}")
    return read.mission


def wind_given(text: str, otherwise: str) -> tuple[float, float | None]:
    """The speed of the wind and where it comes from, if the text says so; ``otherwise``: from where else, in words."""
    try:
        speed_m_s, *rest = (float(number) for number in text.split(","))
        if len(rest) > 1 or not 0 <= speed_m_s < math.inf or not all(abs(from_deg) <= 360 for from_deg in rest):
            raise ValueError
    except ValueError:
        raise RotaError(
            f"--wind: {text!r} is not allowed; M_S,FROM_DEG is needed, such as 5,240: 0 m/s or more, and where the wind"
            f" comes from, 0 north, 90 east, 360 at most; or M_S alone, such as 5: {otherwise}"
        ) from None
    return speed_m_s, rest[0] if rest else None
