"""The grid's limit cycles beside those of straight lines and exact bounces, from the same starts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from shapely import MultiPolygon

from rota.errors import MissionError
from rota.planners.bounce.bounce_map import cycles_and_basins, make_team, single_map
from rota.planners.bounce.cells import Cells
from rota.planners.bounce.polygon import BounceRule, make_rim
from rota.planners.bounce.polygon_cycles import LongRun, limit_cycles

Floats = NDArray[np.float64]
Longs = NDArray[np.int64]
_SAME_LENGTH = 1e-6  # share


@dataclass(frozen=True, kw_only=True, eq=False)
class GridBesidePlane:
    """What one robot comes to on the grid and in the plane, from every cell with every heading: n starts.

    Of the grid's c cycles, (c,): ``lengths_m``, ``bumps`` in one round and ``shares`` of all starts; ``cycle_of`` (n,)
    the cycle that each start comes to. ``plane``: the same starts without a grid. ``same_share``: of the starts whose
    cycle is as long in both (0 where a robot turns in one place for ever); ``length_ratios`` (k,): plane by grid, of
    those that go round in both.
    """

    lengths_m: Floats
    bumps: Longs
    shares: Floats
    cycle_of: NDArray[np.int32]
    plane: LongRun
    same_share: float
    length_ratios: Floats


def compare_grid_and_plane(
    cells: Cells, ground: MultiPolygon, *, turn: int, body_radius_m: float, bounces: int = 2000
) -> GridBesidePlane:
    """Compare the grid and the plane for a robot that turns by ``turn`` heading steps at a bump; cells: of ``ground``.

    The grid stops at centres of cells, the plane at contacts. A disc as wide as a cell makes both the same in a room
    whose walls lie along cells' borders. Raises MissionError for more than 8 headings, which are not equally spaced on
    the grid.
    """
    if cells.headings > 8:
        raise MissionError(f"bounce.headings: {cells.headings} is not allowed; the plane has 4 or 8 to compare with")
    successor = single_map(make_team(cells, [turn]))
    basins = cycles_and_basins(successor.copy())
    lengths_m, bumps = _rounds(cells, successor, basins.first)
    rim = make_rim(ground, body_radius_m)
    step = 2 * np.pi / cells.headings
    plane = limit_cycles(
        rim,
        BounceRule(angle_rad=turn * step),
        np.repeat(cells.centres_m, cells.headings, axis=0),
        np.tile(step * np.arange(cells.headings), cells.count),
        bounces=bounces,
    )
    on_grid_m = lengths_m[basins.cycle]
    same = np.abs(plane.lengths_m - on_grid_m) <= _SAME_LENGTH * np.maximum(on_grid_m, cells.cell_m)
    go_round = (plane.lengths_m > 0) & (on_grid_m > 0)
    return GridBesidePlane(
        lengths_m=lengths_m,
        bumps=bumps,
        shares=basins.basin / cells.states,
        cycle_of=basins.cycle,
        plane=plane,
        same_share=float(same.mean()),
        length_ratios=plane.lengths_m[go_round] / on_grid_m[go_round],
    )


def _rounds(cells: Cells, successor: NDArray[np.int32], first: Longs) -> tuple[Floats, Longs]:
    """Length in metres and number of bumps of each cycle, (c,) each, by letting all go round at once."""
    move_m = np.hypot(*cells.moves.T) * cells.cell_m
    lengths_m, bumps = np.zeros(len(first)), np.zeros(len(first), dtype=np.int64)
    state, going = first.copy(), np.arange(len(first))
    while len(going):
        after = successor[state].astype(np.int64)
        moved = after // cells.headings != state // cells.headings
        lengths_m[going] += np.where(moved, move_m[state % cells.headings], 0.0)
        bumps[going] += ~moved
        on = after != first[going]
        state, going = after[on], going[on]
    return lengths_m, bumps
