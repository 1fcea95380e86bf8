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
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planning.make_plan import search_plan
from rota.planning.progress import SearchState
from rota_studies.progress_curve import ProgressPoint, progress_curve

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
        search = search_plan(
            mission,
            seed=seed,
            progress=progress,
            should_stop=should_stop,
            watch=lambda state: told.append((time.perf_counter() - started_s, state)),
        )
        plan, reason, early = search.plan, None, search.stopped_early
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


def progress_table(search: PatrolProgress) -> str:
    """A row for each number of robots that was tried, in the order of the first try, and a line on the outcome."""
    rows = [HEAD]
    for robots in dict.fromkeys(point.state.robots for point in search.points):
        own_points = [point for point in search.points if point.state.robots == robots]
        met_s = [point.time_s for point in own_points if point.state.met]
        rows.append(
            (
                str(robots),
                f"{own_points[0].time_s:.1f}",
                f"{own_points[-1].time_s:.1f}",
                str(len(own_points)),
                str(sum(point.state.stage == "checked" for point in own_points)),
                f"{100 * min(point.state.unseen_share for point in own_points):.3g} %",
                f"{met_s[0]:.1f}" if met_s else "-",
            )
        )
    widths = [max(len(row[k]) for row in rows) for k in range(len(HEAD))]
    lines = ["  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    return "\n".join([*lines, outcome_sentence(search)])


def outcome_sentence(search: PatrolProgress) -> str:
    """What the search came to, when, and how far from the proved bound."""
    bound = "" if search.lower_bound_robots is None else f" (proved: no fewer than {search.lower_bound_robots})"
    early = ", stopped early" if search.stopped_early else ""
    ended = f"the search ended after {search.search_s:.1f} s{early}"
    if search.reason is not None:
        return f"no plan{bound}; {ended}: {search.reason}"
    best = search.points[-1].best
    first_s = next(point.time_s for point in search.points if point.best == best)
    robots = "1 robot" if best.robots == 1 else f"{best.robots} robots"
    return f"{robots}{bound} after {first_s:.1f} s; {ended}"


def progress_to_json(search: PatrolProgress) -> dict[str, Any]:
    """The numbers as plain values for JSON: times in seconds, shares in 0..1."""
    return {
        "rota_patrol_progress": 1,
        "mission": search.mission.name,
        "effort": PatrolSettings.of(search.mission).effort,
        "seed": search.seed,
        "lower_bound_robots": search.lower_bound_robots,
        "met": search.reason is None,
        "reason": search.reason,
        "stopped_early": search.stopped_early,
        "search_s": search.search_s,
        "points": [dict(zip(COLUMNS, _row(point), strict=True)) for point in search.points],
    }


def progress_to_csv(search: PatrolProgress) -> str:
    """The points as CSV with a line of names: true and false in lower case, times in seconds, shares in 0..1."""
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(COLUMNS)
    for point in search.points:
        lines.writerow([str(cell).lower() if isinstance(cell, bool) else cell for cell in _row(point)])
    return text.getvalue()


def _row(point: ProgressPoint) -> tuple[Any, ...]:
    """The values of a point in the order of COLUMNS."""
    state, best = point.state, point.best
    return (
        point.time_s, state.stage, state.robots, state.unseen_share, state.late_share, state.met,
        best.robots, best.unseen_share, best.late_share, best.met,
    )  # fmt: skip


def write_progress(search: PatrolProgress, path: str | Path) -> None:
    """Write a picture (.png, .svg, .pdf) or the numbers (.csv, .json), by the suffix; the file appears whole or not.

    Raises RotaError for another suffix or a folder that cannot be written to.
    """
    suffix = require_suffix(path, OUTPUTS, "a progress curve")
    if suffix == ".csv":
        write_atomically(path, progress_to_csv(search))
    elif suffix == ".json":
        write_atomically(path, json.dumps(progress_to_json(search), indent=1) + "\n")
    else:
        from rota_studies.progress_picture import draw_progress

        title = f"{search.mission.name}, effort {PatrolSettings.of(search.mission).effort}, seed {search.seed}"
        draw_progress(search.points, path, title=title, bound=search.lower_bound_robots, search_s=search.search_s)
