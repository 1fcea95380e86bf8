"""Where the sensor need reach least far: against dense sampling of the space, in the open and between walls."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely import LineString, MultiPolygon, Point, box

from rota.geometry.free_space import border_segments
from rota.model.mission import DiscSensor, Fleet, Robot, SquareSensor
from rota.planners.patrol.ground import nearest_places as places_module
from rota.planners.patrol.ground.nearest_places import nearest_places, segments_of

Floats = NDArray[np.float64]
DISC = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=3)).equal_robot("r")
SQUARE = Fleet(speed_m_s=1, sensor=SquareSensor(side_m=6)).equal_robot("r")
NO_WALLS = np.zeros((0, 4))
SPACE = MultiPolygon([box(0, 0, 10, 4).difference(box(3, 1, 6, 3)), shapely.Polygon([(12, 6), (15, 9), (11, 10)])])


def standing(space: MultiPolygon, step_m: float) -> Floats:
    """Places all over the space and along its border."""
    x0, y0, x1, y1 = space.bounds
    xs, ys = np.meshgrid(np.arange(x0, x1, step_m), np.arange(y0, y1, step_m))
    inner = np.column_stack([xs.ravel(), ys.ravel()])
    border = shapely.get_coordinates(shapely.segmentize(space.boundary, step_m))
    return np.vstack([inner[shapely.intersects_xy(space, inner)], border])


@pytest.mark.parametrize("robot", [DISC, SQUARE])
def test_in_the_open_no_place_is_nearer(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    points = np.random.default_rng(1).uniform((-4, -4), (18, 13), (300, 2))
    places, ranges = nearest_places(points, SPACE, NO_WALLS, robot)
    away = np.abs(places - points)
    own = away.max(axis=1) if robot is SQUARE else np.hypot(*away.T)
    assert own == pytest.approx(ranges, abs=1e-9)
    assert (shapely.distance(SPACE, shapely.points(places)) < 1e-9).all()
    others = np.abs(standing(SPACE, 0.05)[None] - points[:, None])
    best = (others.max(axis=2) if robot is SQUARE else np.hypot(others[..., 0], others[..., 1])).min(axis=1)
    assert (ranges <= best + 1e-9).all()
    assert (ranges >= best - 0.04).all()
    inside = shapely.intersects_xy(SPACE, *points.T)
    assert inside.sum() > 20
    assert (ranges[inside] == 0).all()
    monkeypatch.setattr(places_module, "PAIRS_TOGETHER", 100)  # a few points to a thread
    assert [found.tolist() for found in nearest_places(points, SPACE, NO_WALLS, robot)] == [
        places.tolist(),
        ranges.tolist(),
    ]


def test_by_hand() -> None:
    # a square measures the greater of |dx| and |dy|; of places that are equally far the nearest is told
    space = MultiPolygon([box(0, 0, 1, 4)])
    points = np.array([[3.0, 2], [3, 5], [2, 7]])
    places, ranges = nearest_places(points, space, NO_WALLS, SQUARE)
    assert places.tolist() == [[1, 2], [1, 4], [1, 4]]
    assert ranges.tolist() == [2, 2, 3]
    places, ranges = nearest_places(points, space, NO_WALLS, DISC)
    assert places.tolist() == [[1, 2], [1, 4], [1, 4]]
    assert ranges.tolist() == [2, math.sqrt(5), math.sqrt(10)]


@pytest.mark.parametrize("robot", [DISC, SQUARE])
def test_walls_send_one_farther_or_hide_a_point(robot: Robot) -> None:
    blocks = MultiPolygon([box(4, 1.9, 8, 2.1), box(1, 3, 1.2, 6), box(10, 0, 10.2, 9)])
    space = MultiPolygon([box(0, 0, 9, 1), box(11, 0, 12, 1)])
    points = np.random.default_rng(2).uniform((0, 0), (10, 4), (150, 2))
    points = points[~shapely.intersects_xy(blocks, *points.T)]
    places, ranges = nearest_places(points, space, border_segments(blocks), robot)
    _, in_the_open = nearest_places(points, space, NO_WALLS, robot)
    # a line of sight may touch a wall: asked with walls a hair thinner and a hair thicker
    thin, thick = blocks.buffer(-1e-6), blocks.buffer(0.02)
    looks = standing(space, 0.1)
    farther = hidden = 0
    for point, place, range_m, open_m in zip(points, places, ranges, in_the_open, strict=True):
        away = np.abs(looks - point)
        far = away.max(axis=1) if robot is SQUARE else np.hypot(*away.T)
        near = far <= 3
        lines = shapely.linestrings(np.stack([np.broadcast_to(point, looks[near].shape), looks[near]], axis=1))
        surely = far[near][~shapely.intersects(thick, lines)]
        perhaps = far[near][~shapely.intersects(thin, lines)]
        if len(surely):
            assert range_m <= surely.min() + 1e-9
        if range_m <= 3:
            assert not LineString([point, place]).intersects(thin)
            assert range_m >= perhaps.min(initial=math.inf) - 0.1
            farther += bool(range_m > open_m + 0.1)
        hidden += not len(perhaps)
        if not len(perhaps) and far.min() <= 2.9:
            assert range_m == math.inf
    assert farther >= 1
    assert hidden > 5


def test_segments_of_geometries_of_every_kind() -> None:
    mixed = shapely.GeometryCollection([Point(1, 2), LineString([(0, 0), (1, 0), (1, 1)]), box(0, 0, 2, 2)])
    assert len(segments_of(mixed)) == 1 + 2 + 4
    assert segments_of(mixed)[0].tolist() == [1, 2, 1, 2]
    assert segments_of(MultiPolygon()).shape == (0, 4)
