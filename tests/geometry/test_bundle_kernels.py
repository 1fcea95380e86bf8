"""Segments from one point: the edges that barred others change nothing of which of them are free."""

from __future__ import annotations

import numpy as np
import pytest

from rota.geometry.bundle_kernels import SECTORS, segment_is_free_too
from rota.geometry.free_space import border_segments
from rota.geometry.line_of_sight import edge_grid, segments_free


@pytest.mark.parametrize("seed", range(6))
def test_segments_of_a_bundle_are_free_where_each_of_them_is(seed, random_space, points_in):
    space = random_space(seed)
    points, grid = points_in(space, 240, seed), edge_grid(border_segments(space))
    spared = 0
    for ax, ay in points[::30]:
        bars = np.full(SECTORS, -1, dtype=np.int64)
        free = []
        for bx, by in points:
            known = bars.copy()
            free.append(segment_is_free_too(ax, ay, bx, by, grid, bars))
            spared += not free[-1] and (bars == known).all()
        np.testing.assert_array_equal(free, segments_free(np.tile((ax, ay), (len(points), 1)), points, grid))
    assert spared > 100
