"""Twelve jobs of which a user expects an answer at once: a plan that the check passes, or a proof that none does."""

from __future__ import annotations

import json
import math
import random
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from benchmarks.row import Options, Row
from benchmarks.stopping_missions import (
    write_building,
    write_corridor,
    write_drones,
    write_entered_building,
    write_open_field,
    write_rectangle,
    write_wide_turns,
)
from rota.check.report import Report
from rota.errors import NoPlanFound
from rota.files.mission_file import read_mission
from rota.model.plan import Plan
from rota.planning.make_plan import search_plan

EXAMPLES = Path(__file__).parents[1] / "examples"
ASKED_S, PATIENCE_S = 5.0, 60.0
TRUNKS, TRUNK_M, APART_M = 60, 0.4, 8.0


def write_trunks(folder: Path) -> Path:
    """60 trunks of 0.4 m, circles of 64 corners, on 300 m by 200 m."""
    rng, centres = random.Random(1), list[tuple[float, float]]()
    while len(centres) < TRUNKS:
        centre = round(rng.uniform(5, 295), 2), round(rng.uniform(5, 195), 2)
        if all(math.dist(centre, other) > APART_M for other in centres):
            centres.append(centre)
    circles = [{"circle": {"centre": list(centre), "radius_m": TRUNK_M}} for centre in centres]
    path = write_rectangle(folder, "trunks", (300.0, 200.0), 800.0, speed_m_s=2.0, radius_m=4.0, body_radius_m=0.3)
    return _with(path, obstacles=circles)


def write_no_fly(folder: Path) -> Path:
    """A no-fly zone, under which nothing is asked, over a third of 100 m by 60 m."""
    path = write_rectangle(folder, "no-fly", (100.0, 60.0), 600.0, speed_m_s=2.0, radius_m=5.0)
    ring = [[15, 15], [85, 15], [85, 45], [15, 45]]
    return _with(path, obstacles=[{"ring": ring, "blocks": "motion", "asks": "nothing"}])


def write_long_corridor(folder: Path) -> Path:
    """220 km by 60 m, ten times as long as the other."""
    return write_rectangle(folder, "corridor-220-km", (220_000.0, 60.0), 10_000.0, speed_m_s=10.0, radius_m=30.0)


def write_wide_ground(folder: Path) -> Path:
    """7.4 km2 for four robots and no more."""
    return write_rectangle(folder, "seven-km2", (3700.0, 2000.0), 3600.0, speed_m_s=15.0, radius_m=25.0, robots=4)


MISSIONS: Mapping[str, Callable[[Path], Path]] = {
    "open field of 300 m x 200 m, bodies of 0.5 m": write_open_field,
    "the same with 60 trunks": write_trunks,
    "three drones with starts over 34 ha": write_drones,
    "turn radius 75 m, lanes 50 m apart, 800 m x 600 m": write_wide_turns,
    "a corridor of 22 km x 60 m": write_corridor,
    "a corridor of 220 km x 60 m": write_long_corridor,
    "a no-fly zone over a third of the area": write_no_fly,
    "a drawn building": lambda _: EXAMPLES / "building.yaml",
    "a ragged building of 1,400 corners, with a pocket in the way": write_building,
    "another, without": lambda folder: write_building(folder, seed=1),
    "the first, entered where the map says": write_entered_building,
    "7.4 km2 for four robots": write_wide_ground,
}


def first_plans(options: Options) -> Iterator[Row]:
    """Seconds of processor time until the first plan passes, at quick, in a process that has planned before."""
    searched(write_open_field(options.folder))  # compiles
    for name, write in MISSIONS.items():
        first, robots = searched(write(options.folder))
        found = "proved that there is none" if robots == 0 else f"robots: {robots}"
        told = f"none within {PATIENCE_S:g} s" if first is None else f"{first:.1f} s, {found}"
        yield Row(f"first plan that passes: {name}", f"{ASKED_S:g} s", told, first is not None and first <= ASKED_S)


def searched(path: Path) -> tuple[float | None, int]:
    """After how many seconds of processor time the first plan passes, and its robots; None: none does.

    0 robots: it is proved that no plan can.
    """
    mission = read_mission(path).mission.with_effort("quick")
    began_s, passed = time.process_time(), list[tuple[float, int]]()

    def note(plan: Plan, report: Report) -> None:
        if report.verdict == "met":
            passed.append((time.process_time() - began_s, len(plan)))

    try:
        search_plan(
            mission,
            on_better=note,
            should_stop=lambda: bool(passed) or time.process_time() - began_s > PATIENCE_S,
        )
    except NoPlanFound as refusal:
        is_proof = str(refusal).startswith("nobody sees all")
        passed = [(time.process_time() - began_s, 0)] if is_proof else []
    return passed[0] if passed else (None, 0)


def _with(path: Path, **blocks: object) -> Path:
    """The mission file with more blocks."""
    path.write_text(json.dumps({**json.loads(path.read_text()), **blocks}))
    return path
