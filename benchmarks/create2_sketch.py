"""Sketches for the iRobot Create 2, driven in simavr: how far from the plan, as planned and with a worse robot."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchmarks.create2.desk import Desk, Floats, drive, off_plan_m, set_up
from benchmarks.create2.plans import TypedMap, bounced_plan
from benchmarks.create2.robot import Faults
from benchmarks.create2.uno import flash_bytes, missing_tools
from benchmarks.missions import EXAMPLES
from benchmarks.row import Options, Row
from rota.errors import PlanError
from rota.files.mission_file import read_mission
from rota.model.plan import Plan
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planning.make_plan import make_plan
from rota_studies.alam2020 import maps
from rota_studies.alam2020.monitoring_figures import PURPOSES
from rota_studies.alam2020.runs import METHODS, Runs, StudySettings

HALL = TypedMap(rows=(".....", ".....", "..#..", "....."), cell_m=0.5)
DURATION_S, SEEDS, FAR_M, MOST_M = 200.0, 5, 0.25, 0.01
WORSE = {
    "bumps told 0.1 s late, sliding along walls": Faults(late_bump_s=0.1, slides=True),
    "turns off by up to 5 %": Faults(turn_error=0.05),
    "both": Faults(late_bump_s=0.1, turn_error=0.05, slides=True),
}


def create2_sketch(options: Options) -> Iterator[Row]:
    """One robot in a hall of 2.5 m x 2 m with an obstacle, turning by 135 degrees: 9 legs in, 8 for ever."""
    name = "Create 2 sketch in simavr"
    if missing_tools():
        yield Row(name, f"within {1e3 * MOST_M:.0f} mm", f"not measured: {', '.join(missing_tools())} missing", None)
        return
    folder = options.folder / "create2"
    folder.mkdir()
    desk = set_up(bounced_plan(HALL, ((0, 1, 0),), turn=3, speed_m_s=0.22), folder)
    began_s = time.perf_counter()
    off_m = off_plan(desk, Faults())
    speed = DURATION_S / (time.perf_counter() - began_s)
    measured = f"{told(off_m)}; {flash_bytes(desk.firmware[0]):,} bytes of flash; {speed:.0f} x real time"
    yield Row(f"{name}, as planned", f"within {1e3 * MOST_M:.0f} mm", measured, bool(off_m.max() <= MOST_M))
    yield from examples(options)
    yield from laboratories(options)
    for what, faults in WORSE.items():
        seeds = range(SEEDS if faults.turn_error else 1)  # nothing else is drawn at random
        runs = [off_plan(desk, replace(faults, seed=seed)) for seed in seeds]
        yield Row(f"{name}, {what}", "", astray(runs), None)


def examples(options: Options) -> Iterator[Row]:
    """Plans of the planner: all robots of an example at once, each with its own Uno."""
    for name in ("bounce-monitor", "bounce-cover"):
        folder = options.folder / name
        folder.mkdir()
        desk = set_up(make_plan(read_mission(EXAMPLES / f"{name}.yaml").mission), folder)
        driven = drive(desk, DURATION_S)
        off_m = np.concatenate([off_plan_m(desk, number, way)[1] for number, way in enumerate(driven)])
        measured = f"{len(driven)} robots, {told(off_m)}"
        what = f"Create 2 sketches in simavr, {name}"
        yield Row(what, f"within {1e3 * MOST_M:.0f} mm", measured, bool(off_m.max() <= MOST_M))


def laboratories(options: Options) -> Iterator[Row]:
    """All plans of Figure 6 and the three of Figure 11 by 90 degrees: how many can be exported, and how they drive."""
    runs = Runs(StudySettings())
    lab = maps.lab(maps.LAB_1, 2, 135.0)
    plans = {f"{method}-{seed}": runs.plan(lab, method, seed) for method in METHODS for seed in runs.starts}
    yield from _driven_in_time("Figure 6", plans, options)
    watched = maps.watching(maps.lab(maps.LAB_2, 2, 90.0), maps.LAB_REGIONS)
    asked = {
        purpose: replace(watched, planning=replace(BounceSettings.of(watched), purpose=purpose)) for purpose in PURPOSES
    }
    yield from _driven_in_time(
        "Figure 11, 90 degrees", {p: make_plan(mission) for p, mission in asked.items()}, options
    )


def _driven_in_time(what: str, plans: dict[str, Plan], options: Options) -> Iterator[Row]:
    worst_m, turns, slowing = 0.0, 0, []
    for name, plan in plans.items():
        folder = options.folder / name.replace(" ", "-").replace(",", "")
        folder.mkdir()
        try:
            desk = set_up(plan, folder)
        except PlanError:
            continue
        slowing.append(desk.drives[0].slowing)
        for number, way in enumerate(drive(desk, DURATION_S)):
            off_m = off_plan_m(desk, number, way)[1]
            worst_m, turns = max(worst_m, float(off_m.max(initial=0.0))), turns + len(off_m)
    measured = (
        f"{len(slowing)} of {len(plans)}, at most {1e3 * worst_m:.1f} mm off at the {turns} turns of {DURATION_S:.0f} s"
        f"; clocks slowed {min(slowing, default=1):.2f} to {max(slowing, default=1):.2f} times"
    )
    good = len(slowing) == len(plans) and worst_m <= MOST_M
    row = f"Create 2 sketches in simavr, laboratory of {what}"
    yield Row(row, f"all exported, within {1e3 * MOST_M:.0f} mm", measured, good)


def off_plan(desk: Desk, faults: Faults) -> Floats:
    """Metres from the planned place at the beginning of each leg."""
    return off_plan_m(desk, 0, drive(desk, DURATION_S, faults)[0])[1]


def told(off_m: Floats) -> str:
    """The worst of a run."""
    return f"at most {1e3 * off_m.max():.1f} mm off at the {len(off_m)} turns of {DURATION_S:.0f} s"


def astray(runs: list[Floats]) -> str:
    """How soon and how far off the plan; the median of all runs."""
    first = [int(np.argmax(off_m > FAR_M)) + 1 if (off_m > FAR_M).any() else None for off_m in runs]
    lost = [number for number in first if number is not None]
    after = {number: statistics.median(off_m[number - 1] for off_m in runs) for number in (4, 8, 16)}
    places = ", ".join(f"{1e3 * off:.0f} mm after {number}" for number, off in after.items())
    when = f"; off by more than half a cell after {min(lost)} to {max(lost)} turns" if lost else ""
    return f"{places} turns (median of {len(runs)} runs); {len(lost)} of {len(runs)} come off the plan{when}"
