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
from rota.files.plan_file import read_plan
from rota.rehearsal.conditions import Conditions
from rota.rehearsal.run import rehearse_once
from rota.rehearsal.scene import HOUR_S, scene_of

AGREEING = ("harbour", "parcel", "building")
ASKED_S, ASKED_OFF_S = 60.0, 1e-6


def rehearsals(options: Options) -> Iterator[Row]:
    """100 runs of 24 hours of the harbour from the shell, and runs without chance beside the check at every place."""
    plans = {name: _planned(name, options.folder) for name in AGREEING}
    command = ("rehearse", plans["harbour"], "--failures-per-hour", "0.01", "--speed-noise", "2%", "--json")
    runs = measured_warm(lambda: rota(*command), lambda run: run.wall_s)
    run = min(runs, key=lambda run: run.wall_s)
    told = run.failure()
    if run.code == 0:
        made = loads(run.out)
        told = f"{run.wall_s:.1f} s, CPU {run.cpu_s:.0f} s, {run.peak_bytes / 1e6:.0f} MB; {made['places']} places,"
        told += f" available {made['available']['mean']:.1%}"
    reached = run.code == 0 and run.wall_s <= ASKED_S
    yield Row("rehearsal of the harbour, 100 runs of 24 h", f"< {ASKED_S:.0f} s on two cores", told, reached)
    for name, path in plans.items():
        plan = read_plan(path)
        scene = scene_of(plan, Conditions(hours=24.0))
        exact_s = np.minimum(worst_gaps_s(plan, scene.points_m), 24 * HOUR_S)
        off_s = float(np.abs(rehearse_once(scene, 0, 0)[2][: len(exact_s)] - exact_s).max())
        what = f"rehearsal of {name} where nothing goes wrong: longest gaps beside the check's"
        yield Row(what, f"within {ASKED_OFF_S:g} s", f"{off_s:.1g} s at {len(exact_s)} places", off_s <= ASKED_OFF_S)


def _planned(name: str, folder: Path) -> Path:
    path = folder / f"{name}.rota.json"
    made = rota("plan", EXAMPLES / f"{name}.yaml", "--effort", "quick", "-o", path)
    if made.code != 0:
        raise RuntimeError(made.err)
    return path
