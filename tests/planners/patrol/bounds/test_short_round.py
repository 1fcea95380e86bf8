"""Rounds on which robots serve all places: closed forms, and that what is passed is where places are served from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from tests.planners.patrol.bounds.test_tour_bound import ROBOT, SPEED_M_S, places

from rota.planners.patrol.bounds.tour_bound import points_passed, robots_on_rounds
from rota.planners.patrol.bounds.witness_points import Witnesses

SQUARE = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]


def on_square(period_m: float, **changes: object) -> Witnesses:
    """Its corners, each served from a metre round it."""
    return replace(places(SQUARE, 1.0, [period_m / SPEED_M_S] * 4), **changes)  # type: ignore[arg-type]


def test_robots_follow_each_other_past_the_nearest_points_of_all_places() -> None:
    side_m = 10 - 2**0.5  # from a metre within each corner
    for robots in (1, 2, 3):
        assert robots_on_rounds(on_square(4 * side_m / robots * 1.001), ROBOT) == robots
        assert robots_on_rounds(on_square(4 * side_m / robots * 0.999), ROBOT) == robots + 1


def test_where_ways_are_bent_the_round_leads_past_the_centres() -> None:
    bent_m = np.where(np.eye(4), 0, 30.0)
    assert robots_on_rounds(on_square(121, way_m=bent_m), ROBOT) == 1
    assert robots_on_rounds(on_square(119, way_m=bent_m), ROBOT) == 2


def test_each_part_has_a_round_of_its_own() -> None:
    # from one corner to the next and back, two metres less at either end
    parts = np.array([0, 0, 1, 1])
    assert robots_on_rounds(on_square(16.1, component=parts), ROBOT) == 2
    assert robots_on_rounds(on_square(15.9, component=parts), ROBOT) == 4
    far = np.where(np.eye(4), 0, np.inf)
    assert robots_on_rounds(on_square(1000, way_m=far), ROBOT) == np.inf
    assert robots_on_rounds(places([], 1.0, []), ROBOT) == np.inf


@pytest.mark.parametrize("seed", range(4))
def test_every_point_that_is_passed_serves_its_place(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = 9
    some = places([tuple(xy) for xy in rng.uniform(0, 10, (n, 2))], 2.0, [1.0] * n)
    hulls = [
        None if k % 3 == 0 else shapely.convex_hull(shapely.MultiPoint(rng.uniform(-2, 2, (9, 2)) + some.centre_m[k]))
        for k in range(n)
    ]
    hulls = [hull if hull is not None and hull.contains(shapely.Point(at)) else None
             for hull, at in zip(hulls, some.centre_m, strict=True)]  # fmt: skip
    corner_m = np.zeros((n, 9, 2))
    corners = np.zeros(n, dtype=np.int64)
    for k, hull in enumerate(hulls):
        if hull is not None:
            ring = shapely.get_coordinates(shapely.normalize(hull).exterior)[-2::-1]
            corners[k], corner_m[k, : len(ring)] = len(ring), ring
    spread_m = rng.uniform(1, 3, n)
    passed_m = points_passed(replace(some, corners=corners, corner_m=corner_m, spread_m=spread_m))
    assert sum(hull is not None for hull in hulls) >= 3
    off_m = np.hypot(*(passed_m - some.centre_m).T)
    assert (off_m <= np.minimum(2.0, spread_m) + 1e-9).all()
    assert (off_m > 0.1).any()
    for point_m, hull in zip(passed_m, hulls, strict=True):
        assert hull is None or hull.distance(shapely.Point(point_m)) < 1e-9
    lengths_m = [np.hypot(*(way - np.roll(way, -1, axis=0)).T).sum() for way in (passed_m, some.centre_m)]
    assert lengths_m[0] < lengths_m[1]
