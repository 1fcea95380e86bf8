"""Jobs of which a user expects an answer at once: open ground, a long corridor, ground that nobody can see."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

from benchmarks.first_plans import write_trunks
from benchmarks.row import Options, Row
from benchmarks.shell import rota
from benchmarks.stopping_missions import write_corridor, write_open_field
from rota.files.plan_file import read_plan

REACH_M, SIZE_M, NO_FLY_M = 5.0, (100, 60), (80, 30)
TOLD_S = 5.0


def small_jobs(options: Options) -> Iterator[Row]:
    """Processor time to a plan that passes, and wall time to the sentence that there can be none."""
    yield _planned("open field of 300 m x 200 m, bodies of 0.5 m, r = 5 m, quick", write_open_field(options.folder), 20)
    yield _planned("corridor of 22 km x 60 m, r = 30 m, quick", write_corridor(options.folder), 60)
    yield _trunks(options.folder)
    yield _refused(options.folder)


def _trunks(folder: Path) -> Row:
    """A field with 60 trunks planned to the end, with its memory."""
    name, asked = "300 m x 200 m with 60 trunks of 64 corners, quick", "met, 6 robots, 12 s of processor time, 300 MB"
    run = rota("plan", write_trunks(folder), "--effort", "quick", "-o", folder / "trunks.rota.json")
    if run.code:
        return Row(name, asked, run.failure(), False)
    robots, peak_mb = len(read_plan(folder / "trunks.rota.json").trajectories), run.peak_bytes / 1e6
    measured = f"{robots} robots, met, {run.cpu_s:.1f} s, {peak_mb:.0f} MB"
    return Row(name, asked, measured, robots <= 6 and run.cpu_s <= 12 and peak_mb <= 300)


def _planned(name: str, mission: Path, asked_s: float) -> Row:
    """A mission planned to the end."""
    plan = mission.with_suffix(".rota.json")
    run = rota("plan", mission, "--effort", "quick", "-o", plan)
    if run.code:
        return Row(name, f"met, {asked_s:g} s of processor time", run.failure(), False)
    robots = len(read_plan(plan).trajectories)
    measured = f"{robots} robots, met, {run.cpu_s:.1f} s"
    return Row(name, f"met, {asked_s:g} s of processor time", measured, run.cpu_s <= asked_s)


def _refused(folder: Path) -> Row:
    """A no-fly zone whose middle nobody has in range: a rectangle, narrower by the reach on all sides."""
    (x, y), (wide, high) = SIZE_M, NO_FLY_M
    left, low = (x - wide) / 2, (y - high) / 2
    ring = [[left, low], [left + wide, low], [left + wide, low + high], [left, low + high]]
    mission = {
        "rota": 1, "name": "no-fly", "area": [[0, 0], [x, 0], [x, y], [0, y]], "period_s": 600,
        "obstacles": [{"ring": ring, "blocks": "motion"}],
        "fleet": {"speed_m_s": 2, "sensor": {"shape": "disc", "radius_m": REACH_M}},
    }  # fmt: skip
    path = folder / "no-fly.json"
    path.write_text(json.dumps(mission))
    run = rota("plan", path, "-o", folder / "no-fly.rota.json")
    true_m2 = (wide - 2 * REACH_M) * (high - 2 * REACH_M)
    told = re.search(r"([\d.]+) m2 \(([\d.]+%)", run.err)
    asked = f"refused within {TOLD_S:g} s with its {true_m2:.2f} m2 ({true_m2 / (x * y):.1%})"
    name = f"no-fly zone of {wide} m x {high} m in {x} m x {y} m, r = {REACH_M:g} m: ground that nobody can see"
    if run.code != 3 or told is None:
        return Row(name, asked, run.failure(), False)
    reached = run.wall_s <= TOLD_S and abs(float(told[1]) - true_m2) < 0.01
    return Row(name, asked, f"{told[1]} m2 ({told[2]}) after {run.wall_s:.1f} s", reached)
