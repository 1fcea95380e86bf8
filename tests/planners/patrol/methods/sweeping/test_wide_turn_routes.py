"""Pieces joined by arcs: short against brute force, on curves that keep the radius, within the space."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import shapely
from shapely import LineString, MultiPolygon, box

from rota.geometry.shortest_path import ShortestPaths
from rota.planners.patrol.driving.polylines import keeps_radius
from rota.planners.patrol.methods.sweeping.wide_turn_routes import Route, short_route
from rota.planners.patrol.tours.curve_kernels import BLOCKED_M

RADIUS_M = 20.0
WIDE = ShortestPaths(MultiPolygon([box(-300, -300, 500, 500)])).grid
NARROW = ShortestPaths(MultiPolygon([box(-45, -45, 145, 125)])).grid


def lane(height_m: float) -> np.ndarray:
    return np.array([[0.0, height_m], [100.0, height_m]])


def whole_m(route: Route) -> float:
    return float(route.joins_m.sum()) + sum(LineString(piece).length for piece in route.pieces)


@pytest.mark.parametrize("grid", [WIDE, NARROW])
def test_the_order_is_nearly_the_best_of_all(grid: object) -> None:
    lanes = [lane(y) for y in (0.0, 20.0, 40.0, 60.0, 80.0)]
    found = short_route(lanes, RADIUS_M, grid)  # type: ignore[arg-type]
    best = min(
        whole_m(Route(pieces=tuple(lanes[k][::way] for k, way in zip(order, ways, strict=True)), radius_m=RADIUS_M,
                      space=grid))  # type: ignore[arg-type]
        for order in ((0, *rest) for rest in itertools.permutations(range(1, 5)))
        for ways in ((1, *rest) for rest in itertools.product((1, -1), repeat=4))
    )  # fmt: skip
    assert found.is_free
    assert whole_m(found) <= 1.1 * best


def test_the_whole_route_keeps_the_radius_and_stays_in_the_space() -> None:
    route = short_route([lane(y) for y in (0.0, 20.0, 40.0, 60.0, 80.0)], RADIUS_M, NARROW)
    assert keeps_radius(route.vertices_m, RADIUS_M * (1 - 1e-9))
    assert shapely.box(-45, -45, 145, 125).covers(shapely.MultiPoint(route.vertices_m))
    length_m = LineString(np.vstack([route.vertices_m, route.vertices_m[:1]])).length
    assert length_m == pytest.approx(whole_m(route), rel=1e-3)


def test_ways_into_walls_are_told() -> None:
    tight = ShortestPaths(MultiPolygon([box(-1, -1, 101, 21)])).grid
    route = short_route([lane(0.0), lane(20.0)], RADIUS_M, tight)
    assert not route.is_free
    assert (route.joins_m >= BLOCKED_M).all()
