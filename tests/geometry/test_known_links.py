"""Links that are taken over from a space that is much the same: they are those that a look at everything finds."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, Point, box

from rota.geometry.known_links import boxes_of_change
from rota.geometry.shortest_path import ShortestPaths


def yard(rng: np.random.Generator) -> MultiPolygon:
    corners, sizes = rng.uniform(1, 18, (25, 2)), rng.uniform(0.3, 2, (25, 2))
    blocks = [box(x, y, x + a, y + b) for (x, y), (a, b) in zip(corners, sizes, strict=True)]
    ground = box(0, 0, 20, 20).difference(shapely.union_all(blocks))
    return MultiPolygon([max(shapely.get_parts(ground), key=lambda part: part.area)])


@pytest.mark.parametrize("seed", range(4))
def test_links_of_a_space_that_grows_or_shrinks_here_and_there(seed: int) -> None:
    rng = np.random.default_rng(seed)
    before = ShortestPaths(yard(rng), most_dense=0)
    assert before._links.nnz > 100
    space = before.parts[0]
    for place in before.corners_m[rng.integers(0, len(before.corners_m), 2)]:
        space = space.difference(Point(place).buffer(0.4, quad_segs=3))
    for place in before.corners_m[rng.integers(0, len(before.corners_m), 2)]:
        space = space.union(Point(place).buffer(0.5, quad_segs=3)).intersection(box(0, 0, 20, 20))
    changed = MultiPolygon([max(shapely.get_parts(space), key=lambda part: part.area)])
    fresh, after = ShortestPaths(changed, most_dense=0), ShortestPaths(changed, most_dense=0, like=before)
    assert abs(fresh._links - after._links).nnz == 0
    assert abs(fresh._links).sum() != pytest.approx(abs(before._links).sum())


def test_boxes_hold_what_only_one_border_has() -> None:
    one, other = np.array([[0.0, 0, 1, 0], [5, 5, 6, 6]]), np.array([[0.0, 0, 1, 0], [5, 5, 6, 7], [9, 9, 9, 8]])
    boxes = boxes_of_change(one, other)
    assert sorted(boxes.round(2).tolist()) == [[4.99, 4.99, 6.01, 7.01], [8.99, 7.99, 9.01, 9.01]]
    assert boxes_of_change(one, one).shape == (0, 4)
