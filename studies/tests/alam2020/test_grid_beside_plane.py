"""Grid and plane: the same in an open room when the disc fills a cell, told apart by obstacles' corners."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota.errors import MissionError
from rota.planners.bounce.cells import Cells, cells_of
from rota_studies.alam2020.grid_beside_plane import GridBesidePlane, compare_grid_and_plane

RADIUS_M = 0.5  # as wide as a cell


def compared(ground: MultiPolygon, turn: int, headings: int = 8) -> tuple[Cells, GridBesidePlane]:
    cells = cells_of(ground, ground.bounds, cell_m=1.0, headings=headings, body_radius_m=0.3)
    return cells, compare_grid_and_plane(cells, ground, turn=turn, body_radius_m=RADIUS_M)


@pytest.mark.parametrize("turn", [1, 2, 3, 4, 5, 6, 7])
@pytest.mark.parametrize(("columns", "rows"), [(5, 5), (7, 4), pytest.param(9, 6, marks=pytest.mark.slow)])
def test_in_an_open_room_both_are_the_same(turn: int, columns: int, rows: int) -> None:
    _, both = compared(MultiPolygon([box(0, 0, columns, rows)]), turn)
    assert both.plane.unsettled_share == 0
    assert both.same_share == 1.0
    assert both.shares.sum() == pytest.approx(1.0)


def test_a_round_along_the_walls_worked_by_hand() -> None:
    cells, both = compared(MultiPolygon([box(0, 0, 4, 3)]), turn=1, headings=4)
    np.testing.assert_allclose(both.lengths_m, [10.0])  # twice 3 and 2 moves
    assert both.bumps.tolist() == [4]
    assert [cycle.stability for cycle in both.plane.cycles] == ["attracting"]
    assert len(both.cycle_of) == cells.states == 48


def test_obstacles_corners_make_a_difference() -> None:
    """The grid turns at a cell's centre where a real disc goes on until it touches the corner."""
    ground = MultiPolygon([box(0, 0, 7, 6).difference(box(3, 2, 4, 4))])
    _, both = compared(ground, turn=3)
    assert 0 < both.same_share < 1
    settled = round((1 - both.plane.unsettled_share - both.plane.stuck_share) * 8 * 40)
    assert len(both.length_ratios) == settled
    assert abs(both.length_ratios - 1).max() > 0.01


def test_headings_that_are_not_equally_spaced_are_refused() -> None:
    ground = MultiPolygon([box(0, 0, 9, 9)])
    cells = cells_of(ground, ground.bounds, cell_m=1.0, headings=16, body_radius_m=0.3)
    with pytest.raises(MissionError, match="headings: 16 is not allowed"):
        compare_grid_and_plane(cells, ground, turn=3, body_radius_m=RADIUS_M)
