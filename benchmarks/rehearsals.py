"""How long rehearsals take, and how near they come to the check where nothing goes wrong."""

from __future__ import annotations

from collections.abc import Iterator
from json import loads
from pathlib import Path

import numpy as np

from benchmarks.missions import EXAMPLES
from benchmarks.row import Options, Row
from benchmarks.shell import rota
from benchmarks.warm_cache import measured_warm
from rota.check import worst_gaps_s
from rota.check.charging import battery_levels
from rota.files.plan_file import read_plan
from rota.model.plan import Plan
from rota.rehearsal.conditions import Conditions
from rota.rehearsal.many_runs import rehearse_once
from rota.rehearsal.scene import HOUR_S, scene_of

AGREEING = ("harbour", "parcel", "building", "port-relief")
ASKED_S, ASKED_OFF_S = 60.0, 1e-6
TIMED = {  # 100 runs of 24 h: the example and what goes wrong
    "harbour": ("--failures-per-hour", "0.01", "--speed-noise", "2%"),
    "port-relief": ("--speed-noise", "2%", "--late-relief", "10"),
}
REPLANNED = ("--failures-per-hour", "0.01", "--speed-noise", "2%", "--replan")


def rehearsals(options: Options) -> Iterator[Row]:
    """100 runs of 24 hours from the shell, and runs without chance beside the check at every place."""
    plans = {name: _planned(name, options.folder) for name in AGREEING}
    for name in TIMED:
        yield replanned_row(name, plans[name])
    for name, given in TIMED.items():
        command = ("rehearse", plans[name], *given, "--json")
        runs = measured_warm(lambda command=command: rota(*command), lambda run: run.wall_s)
        run = min(runs, key=lambda run: run.wall_s)
        told = run.failure()
        if run.code == 0:
            made = loads(run.out)
            told = f"{run.wall_s:.1f} s, CPU {run.cpu_s:.0f} s, {run.peak_bytes / 1e6:.0f} MB; {made['places']} places,"
            told += f" available {made['available']['mean']:.1%}"
        reached = run.code == 0 and run.wall_s <= ASKED_S
        what = f"rehearsal of the {name}, 100 runs of 24 h"
        yield Row(what, f"< {ASKED_S:.0f} s on two cores", told, reached)
    for name, path in plans.items():
        plan = read_plan(path)
        scene = scene_of(plan, Conditions(hours=24.0))
        exact_s = np.minimum(worst_gaps_s(plan, scene.points_m), 24 * HOUR_S)
        run_alone, _, worst_s = rehearse_once(scene, 0, 0)
        off_s = float(np.abs(worst_s[: len(exact_s)] - exact_s).max())
        what = f"rehearsal of {name} where nothing goes wrong: longest gaps beside the check's"
        yield Row(what, f"within {ASKED_OFF_S:g} s", f"{off_s:.1g} s at {len(exact_s)} places", off_s <= ASKED_OFF_S)
        if run_alone.charging is not None:
            off_s = float(np.abs(run_alone.charging.least_s - _least_left_s(plan)).max())
            what = f"rehearsal of {name} where nothing goes wrong: the least in batteries beside the check's"
            yield Row(what, f"within {ASKED_OFF_S:g} s", f"{off_s:.1g} s of {len(plan)} robots", off_s <= ASKED_OFF_S)


def replanned_row(name: str, path: Path) -> Row:
    """What 100 runs take in which plans for those that remain take over."""
    run = rota("rehearse", path, *REPLANNED, "--json")
    told = run.failure()
    if run.code == 0:
        made = loads(run.out)
        told = f"{run.wall_s:.0f} s, CPU {run.cpu_s:.0f} s; {100 * made['takeovers']['mean']:.0f} plans take over,"
        told += f" available {made['available']['mean']:.1%}"
        if made["charging"] is not None:
            told += f", below the reserve in {made['charging']['runs_below_reserve']['mean']:.0%} of the runs"
        if made["not_replanned"] is not None:
            told += f"; not all: {made['not_replanned']}"
    what = f"rehearsal of the {name}, 100 runs of 24 h, a plan for those that remain takes over when one fails"
    return Row(what, "", told, None)


def _least_left_s(plan: Plan) -> list[float]:
    """What the check has as the least that is left in each battery."""
    return [float(battery_levels(plan, way).levels_s.min()) for way in plan]


def _planned(name: str, folder: Path) -> Path:
    path = folder / f"{name}.rota.json"
    made = rota("plan", EXAMPLES / f"{name}.yaml", "--effort", "quick", "-o", path)
    if made.code != 0:
        raise RuntimeError(made.err)
    return path
