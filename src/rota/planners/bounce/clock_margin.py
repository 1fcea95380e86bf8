"""Limit cycles that robots may follow together although their clocks drift apart for a while."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rota.model.arrays import Floats
from rota.planners.bounce.cells import Cells
from rota.planners.bounce.clock_kernels import forbid_near_phases
from rota.planners.bounce.limit_cycles import LimitCycles


def apart_in_time(cycles: LimitCycles, cells: Cells, apart_m: Floats, margin_steps: float) -> LimitCycles:
    """The cycles with fewer compatible pairs: robots stay apart for all differences of clocks up to the margin.

    apart_m: (m, m) metres by which bodies keep the centres of the team's robots apart. margin_steps: in steps; 0 leaves
    all as it is. Contact by the grid counts as well, but at equal times only.
    """
    if margin_steps <= 0:
        return cycles
    kinds = len(set(cycles.kind_of_robot))
    of_kinds = np.zeros((kinds, kinds))
    for i, a in enumerate(cycles.kind_of_robot):
        for j, b in enumerate(cycles.kind_of_robot):
            if i != j:
                of_kinds[a, b] = apart_m[i, j]
    kind_of_cycle = cycles.kind[cycles.start]
    compatible = cycles.compatible.copy()
    forbid_near_phases(
        np.ascontiguousarray(cells.centres_m[cycles.state // cells.headings]),
        np.ascontiguousarray(of_kinds[np.ix_(kind_of_cycle, kind_of_cycle)]),
        cycles.start, cycles.length, float(margin_steps), np.empty(int(cycles.length.max()), np.bool_), compatible,
    )  # fmt: skip
    return replace(cycles, compatible=compatible)
