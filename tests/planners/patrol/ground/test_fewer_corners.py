"""Small obstacles with few corners: each holds the one it stands for, hardly grows, and closes no gap."""

from __future__ import annotations

import shapely
from shapely import MultiPolygon, Point, box

from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.ground.fewer_corners import GROWN, with_fewer_corners

REACH_M, BODY_M, TRUNK_M = 4.0, 0.3, 0.4


def orchard(*more: shapely.Polygon, trunks: int = 12) -> Mission:
    """A field with trunks of 64 corners in a row, 8 m apart, and more obstacles."""
    row = [Point(8.0 * (k + 1), 10.0).buffer(TRUNK_M, quad_segs=16) for k in range(trunks)]
    return Mission(
        name="orchard", area=MultiPolygon([box(0, 0, 120, 40)]), period_s=600,
        obstacles=tuple(Obstacle(shape=MultiPolygon([shape])) for shape in (*row, *more)),
        fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=REACH_M), body_radius_m=BODY_M),
    )  # fmt: skip


def test_trunks_have_few_corners_and_hardly_grow() -> None:
    mission = orchard()
    simple = with_fewer_corners(mission, REACH_M, BODY_M)
    for obstacle, drawn in zip(mission.obstacles, simple.obstacles, strict=True):
        assert shapely.get_num_coordinates(drawn.shape) - 1 <= 8
        assert drawn.shape.covers(obstacle.shape)
        farthest = shapely.distance(obstacle.shape, shapely.points(shapely.get_coordinates(drawn.shape)))
        assert 0 < farthest.max() <= GROWN * REACH_M


def test_gaps_that_bodies_fit_through_stay_as_wide() -> None:
    # 0.62 m between the two: a body of 0.6 m passes
    beside = Point(8.0, 10.0 + 2 * TRUNK_M + 0.62).buffer(TRUNK_M, quad_segs=16)
    mission = orchard(beside)
    simple = with_fewer_corners(mission, REACH_M, BODY_M)
    assert simple.obstacles[0] is mission.obstacles[0]
    assert simple.obstacles[-1] is mission.obstacles[-1]
    assert shapely.get_num_coordinates(simple.obstacles[1].shape) <= 9


def test_large_obstacles_and_few_corners_are_kept() -> None:
    few = orchard(trunks=3)
    assert with_fewer_corners(few, REACH_M, BODY_M) is few
    tower = Point(60.0, 30.0).buffer(2.0, quad_segs=16)
    mission = orchard(tower)
    assert with_fewer_corners(mission, REACH_M, BODY_M).obstacles[-1] is mission.obstacles[-1]
