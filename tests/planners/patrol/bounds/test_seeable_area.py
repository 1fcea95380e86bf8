"""The area that proofs count on is never more than what can be seen, and nearly all of it."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, Polygon, box

from rota.geometry.free_space import DemandedRegion, border_segments, demanded_regions, sight_walls, standing_space
from rota.geometry.tiles import Box, few_cornered_boxes
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.bounds.seeable_area import surely_seeable_m2
from rota.planners.patrol.ground.nearest_places import nearest_places


def test_the_area_surely_seen_is_never_too_much_and_nearly_all() -> None:
    # a box hides its shadow, a hedge cuts sight where robots stand, a pond is looked over from its shore
    obstacles = (
        Obstacle(shape=MultiPolygon([box(3, 3, 5, 6)])),
        Obstacle(shape=MultiPolygon([box(20, 4, 24.5, 7)]), blocks="motion"),
        Obstacle(shape=MultiPolygon([box(10, 1, 10.2, 9)]), blocks="sight"),
    )
    robot = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=2), body_radius_m=0.5).equal_robot("r")
    for some in (obstacles[:1], obstacles[:2], obstacles):
        mission = Mission(
            name="yard", area=MultiPolygon([box(0, 0, 30, 10)]), obstacles=some, period_s=100,
            fleet=Fleet(speed_m_s=1, sensor=robot.sensor, body_radius_m=0.5),
        )  # fmt: skip
        regions, space, walls = demanded_regions(mission), standing_space(mission, 0.5), sight_walls(mission)
        [area] = surely_seeable_m2(regions, space, walls, robot)
        points = np.random.default_rng(5).uniform((0, 0), (30, 10), (20_000, 2))
        points = points[shapely.contains_xy(regions[0].shape, points)]
        _, ranges = nearest_places(points, space, walls, robot)
        truly = regions[0].shape.area * float((ranges <= 2).mean())
        assert area <= truly + 0.3  # the error of so many throws
        assert area >= 0.88 * truly


@pytest.mark.parametrize(("body_m", "reach_m"), [(1.0, 1.0), (0.0, 1.0)])
def test_dents_of_the_space_are_not_filled_in(body_m: float, reach_m: float) -> None:
    # GEOS draws round an outline without its shallow dents, which takes in ground that no sensor reaches
    space = MultiPolygon([Polygon([(-5, -5), (5, -5), (5, 0), (0.5, 0), (0, -0.009), (-0.5, 0), (-5, 0)])])
    asked = MultiPolygon([box(-5, -5, 5, 3)])
    robot = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=reach_m), body_radius_m=body_m).equal_robot("r")
    region = DemandedRegion(name="area", period_s=100, demand="every_point", shape=asked)
    sides = shapely.linestrings(border_segments(space).reshape(-1, 2, 2))
    truly = shapely.union_all([space, *shapely.buffer(sides, reach_m, quad_segs=64)]).intersection(asked).area
    [area] = surely_seeable_m2([region], space, np.zeros((0, 4)), robot)
    assert 0.998 * truly < area < truly


def test_areas_added_up_over_boxes_are_those_of_all_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(1)
    places = rng.uniform(0, 12, (60, 2))
    blocks = shapely.union_all(shapely.box(*places.T, *(places + rng.uniform(0.05, 0.8, (60, 2))).T))
    mission = Mission(
        name="yard", area=MultiPolygon([box(0, 0, 12, 12)]), obstacles=(Obstacle(shape=blocks),), period_s=100,
        fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=0.5)),
    )  # fmt: skip
    regions, space, walls = demanded_regions(mission), standing_space(mission, 0.2), sight_walls(mission)
    # a body smaller than the one that the space was made for: ground beyond it counts where no wall is near
    robot = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=0.5), body_radius_m=0.1).equal_robot("r")
    boxes = []

    def areas(most: int) -> list[float]:
        def cut(bounds: Box, corners: np.ndarray, near_m: float) -> list[Box]:
            found = few_cornered_boxes(bounds, corners, near_m, most)
            boxes.append(len(found))
            return found

        monkeypatch.setattr("rota.planners.patrol.bounds.seeable_area.few_cornered_boxes", cut)
        return surely_seeable_m2(regions, space, walls, robot)

    whole = areas(10**9)
    assert areas(100) == pytest.approx(whole, abs=1e-6)
    assert boxes[0] == 1 < 6 <= boxes[1]
    assert 0.8 * regions[0].shape.area < whole[0] < regions[0].shape.area
