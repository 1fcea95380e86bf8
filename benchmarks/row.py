"""A line of the table, and what a reader may choose about the figures."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

# figures that heed ``effort``; all others are measured at quick
EFFORT_TAKEN = (
    "sun-cases",
    "charging",
    "loop-lengths",
    "sun2019-method",
    "one-robot",
    "plan-1-km2",
    "plan-10-km2",
    "random-missions",
    "plan-on-cluster",
)


class Row(NamedTuple):
    """One line of the table. ``reached`` None: not measured, or nothing is asked."""

    name: str
    asked: str
    measured: str
    reached: bool | None


class Options(NamedTuple):
    """Where to put files, and what the figures take; see ``python -m benchmarks --help``."""

    folder: Path
    effort: str = "quick"
    missions: int = 1000
    first_seed: int = 0
    tile_m: float = 1000.0
    processes: int | None = None
    steps: int = 1000
    flights: Path | None = None
    graphs: Path | None = None
