"""The gain of the virtual forces, which the paper does not print: what it does to speed, smoothness and rest."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rota.geometry.free_space import free_ground
from rota.model.mission import Mission
from rota.planners.swarm.baseline_kernels import STIFFNESS, virtual_force
from rota.planners.swarm.metrics import History, Observer
from rota.planners.swarm.planner import make_swarm
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.sorted_robots import Beginning
from rota.planners.swarm.starts import place_starts
from rota_studies.chen2018 import maps, paper
from rota_studies.chen2018.runs import FORCES, Runs, what
from rota_studies.tables import Table

GAINS = (0.1, 0.2, 0.25, 0.3, 0.4)


def gain_table(runs: Runs) -> Table:
    """Virtual forces by gain, with and without an obstacle."""
    rows = []
    for gain in GAINS:
        cells = []
        for mission in (maps.small("between"), maps.with_obstacle("between")):
            outcomes = [forced(runs, mission, gain, seed) for seed in runs.some(runs.settings.gain_seeds)]
            turned = [run.turned for run in outcomes]
            end = np.mean([run.covered_in_end for run in outcomes])
            cells += [
                f"{np.mean(turned):.2f} (at most {max(turned):.2f})",
                f"{np.mean([run.covered for run in outcomes]):.2f}",
                f"{end:.2f}",
                f"{sum(run.at_rest for run in outcomes)} of {len(outcomes)}",
            ]
        rows.append((f"{gain:g}" + (", taken" if gain == STIFFNESS else ""), *cells))
    columns = ("reversals %", f"covered % at k = {paper.STEPS_FIGURE_12}", "covered % in the end", "at rest")
    return Table(
        title=f"VFA by its gain, the share of an overlap that a step takes away, {runs.settings.gain_seeds} seeds",
        head=("gain", *columns, *(f"obstacle: {name}" for name in columns)),
        rows=tuple(rows),
    )


@dataclass(frozen=True, kw_only=True)
class Forced:
    """A run by virtual forces: percent of velocities turned back, and covered by the paper's step and in the end.

    at_rest: whether the stop rule ended it.
    """

    turned: float
    covered: float
    covered_in_end: float
    at_rest: bool


def forced(runs: Runs, mission: Mission, gain: float, seed: int) -> Forced:
    """What a run by virtual forces of a gain comes to."""

    def make() -> Forced:
        runs.now(f"{mission.name}: VFA with gain {gain:g}, seed {seed}")
        history, at_rest = force(replace(mission, planning=FORCES.settings), gain, seed, runs.settings.steps)
        return Forced(
            turned=100 * float(history.reversals[1 : paper.STEPS_FIGURE_12 + 1].mean()),
            covered=100 * float(history.coverage[min(paper.STEPS_FIGURE_12, history.steps)]),
            covered_in_end=100 * float(history.coverage[-1]),
            at_rest=at_rest,
        )

    run = {"what": "gain", **what(mission, FORCES), "gain": gain, "seed": seed, "most_steps": runs.settings.steps}
    return runs.records.get(Forced, run, make)


def force(mission: Mission, gain: float, seed: int, most_steps: int) -> tuple[History, bool]:
    """The history of a run by virtual forces of a gain, and whether the stop rule ended it."""
    ground = free_ground(mission)
    starts = place_starts(mission, ground, seed=seed, reserve_m=0.0)
    swarm = make_swarm(mission, ground, Beginning(starts), seed=seed, decide=virtual_force(gain))
    observer = Observer(swarm, ground, SwarmSettings.of(mission).stop_m)
    while swarm.steps < most_steps:
        moved_m = swarm.step()
        observer.note(0.0)
        if moved_m <= SwarmSettings.of(mission).stop_m:
            return observer.history(), True
    return observer.history(), False
