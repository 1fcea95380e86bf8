from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, Polygon, affinity, box


def _shape_of(number: int, rng: np.random.Generator) -> Polygon:
    """Boxes on whole metres (they share corners and borders), triangles, L-shapes and turned boxes, in 20 x 20 m."""
    x, y = (float(v) for v in rng.integers(0, 18, 2))
    wide, high = (float(v) for v in rng.integers(1, 6, 2))
    plain = box(x, y, x + wide, y + high)
    if number % 4 == 0:
        return plain
    if number % 4 == 1:
        return Polygon([(x, y), (x + wide, y), (x + wide / 2, y + high)])
    if number % 4 == 2:
        return Polygon(plain.difference(box(x + wide / 2, y + high / 2, x + 9, y + 9)).exterior)
    return affinity.rotate(plain, float(rng.uniform(0, 90)))


def _random_space(seed: int) -> MultiPolygon:
    rng = np.random.default_rng(seed)
    blocked = [_shape_of(int(rng.integers(4)), rng) for _ in range(int(rng.integers(1, 9)))]
    area = box(0, 0, 20, 20) if seed % 3 else Polygon([(0, 0), (20, 0), (20, 8), (11, 9), (12, 20), (0, 20)])
    free = area.difference(shapely.union_all(blocked))
    parts = [p for p in shapely.get_parts(free) if p.geom_type == "Polygon" and p.area > 1e-6]
    return MultiPolygon(parts)


def _points_in(space: MultiPolygon, count: int, seed: int) -> np.ndarray:
    """Points inside, on borders and at corners, a third of each."""
    rng = np.random.default_rng(seed)
    corners = shapely.get_coordinates(space)
    at_corners = corners[rng.integers(0, len(corners), count // 3)]
    on_border = shapely.line_interpolate_point(space.boundary, rng.uniform(0, space.boundary.length, count // 3))
    inside: list[np.ndarray] = []
    while len(inside) < count - 2 * (count // 3):
        point = rng.uniform(0, 20, 2)
        if space.contains(shapely.Point(point)):
            inside.append(point)
    return np.vstack([at_corners, shapely.get_coordinates(on_border), inside])


@pytest.fixture
def random_space() -> Callable[[int], MultiPolygon]:
    return _random_space


@pytest.fixture
def points_in() -> Callable[[MultiPolygon, int, int], np.ndarray]:
    return _points_in
