"""Cells and moves: hand-worked maps, bodies beside walls, and lattice directions for many headings."""

from __future__ import annotations

import math

import numpy as np
import pytest
from maps import PlainTeam, typed_cells
from shapely import MultiPolygon, Point, box

from rota.errors import MissionError
from rota.planners.bounce.cells import BLOCKED, cells_of, crossed_cells, heading_moves

WALLED = """
...
.#.
...
"""


def test_a_ring_of_eight_cells_has_no_diagonal_move_unless_corners_may_be_passed() -> None:
    cells = typed_cells(WALLED)
    assert cells.count == 8
    # two straight moves from each of the eight cells
    assert (cells.target != BLOCKED).sum() == 16
    passing = typed_cells(WALLED, corners="pass")
    # and one diagonal move past a corner of the obstacle from each middle cell to both others beside it
    assert (passing.target != BLOCKED).sum() == 16 + 8


@pytest.mark.parametrize("corners", ["blocked", "pass"])
@pytest.mark.parametrize("headings", [4, 8])
def test_moves_are_those_of_the_definition(corners: str, headings: int) -> None:
    text = "..#..\n.....\n#..#.\n.#..."
    cells = typed_cells(text, headings=headings, corners=corners)
    plain = PlainTeam(text, [1], headings, corners)
    for cell, (x, y) in enumerate(zip(cells.column, cells.row, strict=True)):
        for h in range(headings):
            to = cells.target[cell, h]
            end = None if to == BLOCKED else (cells.column[to], cells.row[to])
            assert end == plain.aim((int(x), int(y), h))


def test_a_body_keeps_its_distance_from_walls() -> None:
    ground = MultiPolygon([box(0, 0, 4, 3).difference(box(1.6, 1.2, 2.4, 1.8))])
    thin = cells_of(ground, ground.bounds, cell_m=1.0, body_radius_m=0.5)
    # centres at 0.5 .. 3.5: those in the middle row are 0.1 m from the obstacle at x = 1.5 and 2.5
    assert thin.count == 10
    assert thin.at((1.5, 1.5)) is None
    room = ground.buffer(-0.5 + 1e-6, quad_segs=64)
    for cell, centre in enumerate(thin.centres_m):
        for to in thin.target[cell][thin.target[cell] != BLOCKED]:
            middle = (centre + thin.centres_m[to]) / 2
            assert room.covers(Point(middle))
    # 4 x 3 cells with two gone: no diagonal is left past the obstacle
    assert all(thin.target[thin.at((0.5, 0.5)), [1, 3, 5, 7]] == [BLOCKED] * 4)


def test_a_wall_between_two_cells_blocks_the_way_but_not_the_cells() -> None:
    ground = MultiPolygon([box(0, 0, 2, 1).difference(box(0.95, 0, 1.05, 0.9))])
    cells = cells_of(ground, ground.bounds, cell_m=1.0)
    assert cells.count == 2
    assert (cells.target == BLOCKED).all()


@pytest.mark.parametrize("headings", [4, 8, 12, 16, 20, 24, 32])
def test_moves_turn_round_and_stay_near_their_headings(headings: int) -> None:
    moves = heading_moves(headings)
    assert len({tuple(move) for move in moves.tolist()}) == headings
    assert (moves[headings // 2 :] == -moves[: headings // 2]).all()
    angles = np.unwrap(np.arctan2(moves[:, 1], moves[:, 0]))
    assert np.abs(angles - np.arange(headings) * math.tau / headings).max() <= math.tau / headings / 4 + 1e-9
    assert np.abs(moves).max() <= {4: 1, 8: 1, 12: 2, 16: 2, 20: 3, 24: 3, 32: 5}[headings]


def test_cells_beside_a_move() -> None:
    assert crossed_cells((1, 1)) == [(0, 1), (1, 0)]
    assert crossed_cells((2, 1)) == [(1, 0), (1, 1)]
    assert crossed_cells((1, 0)) == []
    assert crossed_cells((-1, 2)) == [(-1, 1), (0, 1)]


def test_a_ground_without_room_and_one_with_too_many_cells_are_refused() -> None:
    ground = MultiPolygon([box(0, 0, 3, 3)])
    with pytest.raises(MissionError, match=r"radius 1\.6 m fits at the centre of none of the 3 x 3"):
        cells_of(ground, ground.bounds, cell_m=1.0, body_radius_m=1.6)
    with pytest.raises(MissionError, match=r"cell_m: 0\.001 is not allowed; .* 3000 x 3000 cells"):
        cells_of(ground, ground.bounds, cell_m=0.001)
