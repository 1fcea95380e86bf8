"""The part of ground with very many corners that a view depends on."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box

from rota.geometry.free_space import border_segments
from rota.geometry.line_of_sight import visibility_polygon
from rota.planners.patrol.ground import surroundings as surroundings_module
from rota.planners.patrol.ground.surroundings import Surroundings, places_in_sight

RNG = np.random.default_rng(0)
BLOCKS = shapely.union_all([box(x, y, x + 0.3, y + 0.3) for x, y in RNG.uniform(0, 30, (120, 2))])
SPACE = MultiPolygon([box(0, 0, 30, 30).difference(BLOCKS.buffer(0.2, quad_segs=2))])
WALLS = border_segments(MultiPolygon(shapely.get_parts(BLOCKS)))


def test_places_in_sight_are_those_of_all_of_the_ground(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(surroundings_module, "MANY_WALLS", 0)
    for point_m in RNG.uniform(0, 30, (60, 2)):
        whole = visibility_polygon(point_m, WALLS, 3.0).intersection(SPACE)
        near = places_in_sight(point_m, SPACE, WALLS, 3.0)
        assert shapely.symmetric_difference(near, whole).area < 1e-9


def test_what_lies_far_away_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    few, all_walls = Surroundings(SPACE, WALLS, 3.0), WALLS
    assert few.at(np.array([5.0, 5.0])) == (SPACE, all_walls)
    monkeypatch.setattr(surroundings_module, "MANY_WALLS", 0)
    space, walls = few.at(np.array([5.0, 5.0]))
    assert space.area < SPACE.area / 4
    assert len(walls) < len(WALLS) / 2
