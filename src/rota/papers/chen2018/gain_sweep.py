"""The gain of the virtual forces, which the paper does not print: what it does to speed, smoothness and rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rota.geometry.free_space import free_ground
from rota.mission import Mission
from rota.papers.chen2018 import maps, paper
from rota.papers.chen2018.runs import FORCES, Runs
from rota.papers.tables import Table
from rota.planners.swarm.baseline_kernels import STIFFNESS, virtual_force
from rota.planners.swarm.metrics import History, Observer
from rota.planners.swarm.planner import make_swarm
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.rollout import Beginning
from rota.planners.swarm.starts import place_starts

GAINS = (0.1, 0.2, 0.25, 0.3, 0.4)


def gain_table(runs: Runs) -> Table:
    """Virtual forces by gain, with and without an obstacle."""
    rows = []
    for gain in GAINS:
        cells = []
        for mission in (maps.small("between"), maps.with_obstacle("between")):
            histories = [forced(runs, mission, gain, runs.seed + k) for k in range(runs.settings.gain_seeds)]
            turned = [100 * float(history.reversals[1 : paper.STEPS_FIGURE_12 + 1].mean()) for history, _ in histories]
            at = [100 * history.coverage[min(paper.STEPS_FIGURE_12, history.steps)] for history, _ in histories]
            end = [100 * history.coverage[-1] for history, _ in histories]
            rested = sum(rest for _, rest in histories)
            cells += [f"{np.mean(turned):.2f} (at most {max(turned):.2f})", f"{np.mean(at):.2f}", f"{np.mean(end):.2f}",
                      f"{rested} of {len(histories)}"]  # fmt: skip
        rows.append((f"{gain:g}" + (", taken" if gain == STIFFNESS else ""), *cells))
    columns = ("reversals %", f"covered % at k = {paper.STEPS_FIGURE_12}", "covered % in the end", "at rest")
    return Table(
        title=f"VFA by its gain, the share of an overlap that a step takes away, {runs.settings.gain_seeds} seeds",
        head=("gain", *columns, *(f"obstacle: {name}" for name in columns)),
        rows=tuple(rows),
    )


def forced(runs: Runs, mission: Mission, gain: float, seed: int) -> tuple[History, bool]:
    """The history of a run by virtual forces of a gain, and whether the stop rule ended it."""
    runs.stop_if_asked()
    runs.tell(f"{mission.name}: VFA with gain {gain:g}, seed {seed}")
    mission = replace(mission, planning=FORCES.settings)
    ground = free_ground(mission)
    starts = place_starts(mission, ground, seed=seed, reserve_m=0.0)
    swarm = make_swarm(mission, ground, Beginning(starts), seed=seed, decide=virtual_force(gain))
    observer = Observer(swarm, ground, SwarmSettings.of(mission).stop_m)
    while swarm.steps < runs.settings.steps:
        moved_m = swarm.step()
        observer.note(0.0)
        if moved_m <= SwarmSettings.of(mission).stop_m:
            return observer.history(), True
    return observer.history(), False
