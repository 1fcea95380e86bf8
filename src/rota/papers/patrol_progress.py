"""The anytime curve of the patrol planner: unseen ground and robots of the best plan so far, against seconds."""

from __future__ import annotations

import csv
import io
import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rota.compare import load_compiled_loops
from rota.errors import NoPlanFound
from rota.files.atomic_write import require_suffix, write_atomically
from rota.make_plan import search_plan
from rota.mission import Mission
from rota.plan import Plan
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.progress import ProgressPoint, SearchState, progress_curve

PICTURES, NUMBERS = (".png", ".svg", ".pdf"), (".csv", ".json")
OUTPUTS = PICTURES + NUMBERS
COLUMNS = (
    "time_s", "stage", "robots", "unseen_share", "late_share", "met", "best_robots", "best_unseen_share",
    "best_late_share", "best_met",
)  # fmt: skip
HEAD = ("robots", "tried from s", "to s", "states", "checks", "least unseen", "met after s")


@dataclass(frozen=True, kw_only=True)
class PatrolProgress:
    """How one search went. ``points``: what it told, in time; ``search_s``: seconds until it ended.

    plan: what it found, or the best plan that is not met, or None. reason: why there is no plan that is met.
    """

    mission: Mission
    seed: int
    points: tuple[ProgressPoint, ...]
    search_s: float
    plan: Plan | None
    reason: str | None = None
    stopped_early: bool = False

    @property
    def lower_bound_robots(self) -> int | None:
        """Robots below which no plan exists, proved; None when no plan came with it."""
        return None if self.plan is None else self.plan.lower_bound_robots


def patrol_progress(
    mission: Mission,
    *,
    seed: int = 0,
    progress: Callable[[float, str], None] | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> PatrolProgress:
    """Plan ``mission`` and keep the time of every state that the search tells of.

    progress, should_stop: as for ``search_plan``. Compiled loops are loaded before the clock starts. A search that
    finds no plan that is met is an outcome with a reason; raises MissionError for a mission that cannot be planned.
    """
    load_compiled_loops()
    told: list[tuple[float, SearchState]] = []
    started_s = time.perf_counter()
    plan: Plan | None
    try:
        found = search_plan(
            mission,
            seed=seed,
            progress=progress,
            should_stop=should_stop,
            watch=lambda state: told.append((time.perf_counter() - started_s, state)),
        )
        plan, reason, early = found.plan, None, found.stopped_early
    except NoPlanFound as failure:
        plan = failure.best if isinstance(failure.best, Plan) else None
        reason, early = str(failure), False
    return PatrolProgress(
        mission=mission,
        seed=seed,
        points=progress_curve(told),
        search_s=time.perf_counter() - started_s,
        plan=plan,
        reason=reason,
        stopped_early=early,
    )


def progress_table(found: PatrolProgress) -> str:
    """A row for each number of robots that was tried, in the order of the first try, and a line on the outcome."""
    rows = [HEAD]
    for robots in dict.fromkeys(point.state.robots for point in found.points):
        here = [point for point in found.points if point.state.robots == robots]
        met_s = [point.time_s for point in here if point.state.met]
        rows.append(
            (
                str(robots),
                f"{here[0].time_s:.1f}",
                f"{here[-1].time_s:.1f}",
                str(len(here)),
                str(sum(point.state.stage == "checked" for point in here)),
                f"{100 * min(point.state.unseen_share for point in here):.3g} %",
                f"{met_s[0]:.1f}" if met_s else "-",
            )
        )
    widths = [max(len(row[k]) for row in rows) for k in range(len(HEAD))]
    lines = ["  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    return "\n".join([*lines, outcome_sentence(found)])


def outcome_sentence(found: PatrolProgress) -> str:
    """What the search came to, when, and how far from the proved bound."""
    bound = "" if found.lower_bound_robots is None else f" (proved: no fewer than {found.lower_bound_robots})"
    early = ", stopped early" if found.stopped_early else ""
    ended = f"the search ended after {found.search_s:.1f} s{early}"
    if found.reason is not None:
        return f"no plan{bound}; {ended}: {found.reason}"
    best = found.points[-1].best
    first_s = next(point.time_s for point in found.points if point.best == best)
    robots = "1 robot" if best.robots == 1 else f"{best.robots} robots"
    return f"{robots}{bound} after {first_s:.1f} s; {ended}"


def progress_to_json(found: PatrolProgress) -> dict[str, Any]:
    """The numbers as plain values for JSON: times in seconds, shares in 0..1."""
    return {
        "rota_patrol_progress": 1,
        "mission": found.mission.name,
        "effort": PatrolSettings.of(found.mission).effort,
        "seed": found.seed,
        "lower_bound_robots": found.lower_bound_robots,
        "met": found.reason is None,
        "reason": found.reason,
        "stopped_early": found.stopped_early,
        "search_s": found.search_s,
        "points": [dict(zip(COLUMNS, _row(point), strict=True)) for point in found.points],
    }


def progress_to_csv(found: PatrolProgress) -> str:
    """The points as CSV with a line of names: true and false in lower case, times in seconds, shares in 0..1."""
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(COLUMNS)
    for point in found.points:
        lines.writerow([str(cell).lower() if isinstance(cell, bool) else cell for cell in _row(point)])
    return text.getvalue()


def _row(point: ProgressPoint) -> tuple[Any, ...]:
    state, best = point.state, point.best
    return (
        point.time_s, state.stage, state.robots, state.unseen_share, state.late_share, state.met,
        best.robots, best.unseen_share, best.late_share, best.met,
    )  # fmt: skip


def write_progress(found: PatrolProgress, path: str | Path) -> None:
    """Write a picture (.png, .svg, .pdf) or the numbers (.csv, .json), by the suffix; the file appears whole or not.

    Raises RotaError for another suffix or a folder that cannot be written to.
    """
    suffix = require_suffix(path, OUTPUTS, "a progress curve")
    if suffix == ".csv":
        write_atomically(path, progress_to_csv(found))
    elif suffix == ".json":
        write_atomically(path, json.dumps(progress_to_json(found), indent=1) + "\n")
    else:
        from rota.draw import draw_progress

        title = f"{found.mission.name}, effort {PatrolSettings.of(found.mission).effort}, seed {found.seed}"
        draw_progress(found.points, path, title=title, bound=found.lower_bound_robots, search_s=found.search_s)
