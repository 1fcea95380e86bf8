"""Boxes with few corners near each: they cover all, share nothing, and hold as few as was asked."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from rota.geometry.tiles import clip, few_cornered_boxes, grown_box


@pytest.mark.parametrize("seed", range(5))
def test_boxes_share_no_ground_and_hold_few_corners(seed: int) -> None:
    rng = np.random.default_rng(seed)
    corners = np.vstack([rng.uniform(0, 100, (2000, 2)), rng.normal(30, 3, (2000, 2))])
    boxes = few_cornered_boxes((0.0, -5.0, 100.0, 60.0), corners, 1.0, most=300)
    shapes = shapely.box(*np.array(boxes).T)
    assert shapely.area(shapes).sum() == pytest.approx(100 * 65)
    assert shapely.union_all(shapes).equals(shapely.box(0, -5, 100, 60))
    for box in boxes:
        x0, y0, x1, y1 = grown_box(box, 1.0)
        near = ((corners >= [x0, y0]) & (corners <= [x1, y1])).all(axis=1).sum()
        assert near <= 300 or max(box[2] - box[0], box[3] - box[1]) <= 2.0


def test_few_corners_need_one_box() -> None:
    assert few_cornered_boxes((0.0, 0.0, 9.0, 9.0), np.zeros((10, 2)), 1.0) == [(0.0, 0.0, 9.0, 9.0)]


def test_a_part_of_a_shape_is_polygons() -> None:
    shape = shapely.union_all([shapely.box(0, 0, 4, 4), shapely.box(6, 0, 8, 2)])
    assert clip(shape, (2.0, 0.0, 6.0, 9.0)).equals(shapely.box(2, 0, 4, 4))  # the line at x = 6 is left out
    assert clip(shape, (10.0, 0.0, 11.0, 1.0)).is_empty
