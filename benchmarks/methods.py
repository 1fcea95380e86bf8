"""``rota compare`` of one mission at quick effort, as rows: what each method needs, side by side in one run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from benchmarks.shell import rota


def compared(mission: Path) -> list[dict[str, Any]]:
    """What ``rota compare --json`` says of each method; raises RuntimeError when it says nothing."""
    run = rota("compare", mission, "--effort", "quick", "--json")
    if not run.out.startswith("{"):
        raise RuntimeError(run.failure())
    return json.loads(run.out)["methods"]


def cell(entry: dict[str, Any]) -> str:
    """The measured cell of the table for one method."""
    if entry["robots"] is None:
        return f"no plan: {entry['reason']}"
    met = "met" if entry["met"] else f"not met: {entry['reason']}"
    bound = f"{entry['robots']} robots (bound {entry['lower_bound_robots']})"
    return f"{bound}, loops {entry['loops_m']:,.0f} m, planned in {entry['planning_s']:.1f} s; {met}"
