from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, seed, settings, strategies as st
from shapely import MultiPolygon, Point, Polygon, affinity, box

from rota.check.demands import demands_of
from rota.errors import MissionError
from rota.geometry.free_space import (
    border_corners,
    border_segments,
    demanded_regions,
    nearest_free_point,
    sight_walls,
    standing_parts,
    standing_space,
)
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone


def mission(area, *obstacles, zones=(), period_s=60.0):
    shapes = [o if isinstance(o, Obstacle) else Obstacle(shape=o) for o in obstacles]
    fleet = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=2.0))
    return Mission(name="m", area=area, obstacles=tuple(shapes), zones=tuple(zones), period_s=period_s, fleet=fleet)


def zone(name, period_s, shape, demand="every_point"):
    return Zone(name=name, shape=shape, period_s=period_s, demand=demand)


corner = st.integers(0, 12)
size = st.integers(1, 6)
obstacle = st.builds(
    lambda x, y, w, h, turn: affinity.rotate(box(x, y, x + w, y + h), turn),
    corner,
    corner,
    size,
    size,
    st.integers(0, 89),
)
area = st.sampled_from(
    [
        box(0, 0, 14, 14),
        Polygon([(0, 0), (14, 0), (14, 6), (6, 7), (7, 14), (0, 14)]),
        Polygon([(0, 0), (14, 0), (7, 5), (14, 14), (0, 14)]),
        MultiPolygon([box(0, 0, 6, 14), box(7, 0, 14, 14)]),
    ]
)


@seed(2)
@settings(max_examples=150, deadline=None)
@given(area, st.lists(obstacle, min_size=1, max_size=6), st.floats(0.05, 1.5))
def test_no_standing_point_is_closer_to_a_border_than_the_body(area, obstacles, radius_m):
    space = standing_space(mission(area, *obstacles), radius_m)
    solid = shapely.union_all(obstacles)
    free = area.difference(solid)
    assert space.is_valid
    if space.is_empty:
        assert free.buffer(-1.03 * radius_m).area < 1e-9
        return
    assert shapely.distance(space, solid) >= radius_m - 1e-9
    assert shapely.distance(space, area.boundary) >= radius_m - 1e-9
    assert space.difference(area).area < 1e-9
    # nothing is given away but the corners of the polygons round the corners
    fine = free.buffer(-radius_m, quad_segs=256)
    assert space.difference(fine.buffer(1e-4 * radius_m)).area < 1e-9
    assert free.buffer(-radius_m / math.cos(math.pi / 16) - 1e-9).difference(space).area < 1e-9
    if fine.area > 20 * radius_m**2:
        assert space.area == pytest.approx(fine.area, rel=0.01)


def test_round_a_square_block_the_border_is_a_rounded_square():
    space = standing_space(mission(box(0, 0, 20, 20), box(8, 8, 12, 12)), 1.0)
    hole = Polygon(space.geoms[0].interiors[0])
    quarter = 4 * math.tan(math.pi / 16)  # of a 16-gon round the unit circle
    assert hole.area == pytest.approx(16 + 4 * 4 + 4 * quarter, abs=1e-12)
    assert space.area == pytest.approx(18 * 18 - hole.area, abs=1e-12)
    assert len(border_corners(space)[0]) == 16
    # straight borders lie at exactly the radius
    for point in [(10, 7), (13, 10), (10, 13), (7, 10), (1, 5), (19, 5)]:
        assert space.boundary.distance(Point(point)) < 1e-12


@pytest.mark.parametrize("arc_corners", [8, 16, 64])
def test_finer_arcs_come_closer_to_the_circle(arc_corners):
    space = standing_space(mission(box(0, 0, 20, 20), box(8, 8, 12, 12)), 1.0, arc_corners=arc_corners)
    hole = Polygon(space.geoms[0].interiors[0])
    assert hole.area == pytest.approx(32 + arc_corners * math.tan(math.pi / arc_corners), abs=1e-12)


@pytest.mark.parametrize(("gap_m", "parts"), [(0.9, 2), (1.0, 2), (1.001, 1), (1.5, 1)])
def test_a_gap_is_passed_by_what_is_narrower(gap_m, parts):
    walls = [box(9, -1, 11, 10 - gap_m / 2), box(9, 10 + gap_m / 2, 11, 21)]
    space = standing_space(mission(box(0, 0, 20, 20), *walls), 0.5)
    assert len(space.geoms) == parts
    assert space.distance(shapely.union_all(walls)) == pytest.approx(0.5, abs=1e-12)


def test_a_body_without_size_stands_anywhere_free():
    block, fence = Obstacle(shape=box(3, 3, 7, 7)), Obstacle(shape=box(0, 8, 10, 9), blocks="motion")
    hedge = Obstacle(shape=box(1, 1, 2, 2), blocks="sight")
    space = standing_space(mission(box(0, 0, 10, 10), block, fence, hedge), 0.0)
    assert space.equals(box(0, 0, 10, 10).difference(box(3, 3, 7, 7)).difference(box(0, 8, 10, 9)))
    assert [part.area for part in standing_parts(space)] == [80 - 16, 10]


def test_a_body_too_large_stands_nowhere():
    assert standing_space(mission(box(0, 0, 10, 10)), 5.0).is_empty
    assert standing_space(mission(box(0, 0, 10, 10), box(-1, -1, 11, 11)), 0.0).is_empty
    with pytest.raises(MissionError, match="no free space at all"):
        nearest_free_point(MultiPolygon(), (1, 2))


@pytest.mark.parametrize("radius_m", [-1.0, math.nan, math.inf])
def test_a_radius_that_is_none_is_refused(radius_m):
    with pytest.raises(ValueError, match="body_radius_m"):
        standing_space(mission(box(0, 0, 10, 10)), radius_m)


def test_the_nearest_free_point():
    space = standing_space(mission(box(0, 0, 10, 10), box(4, 4, 10, 6)), 0.0)
    assert nearest_free_point(space, (1, 1)) == (1, 1)
    assert nearest_free_point(space, (7, 5.5)) == (7, 6)
    assert nearest_free_point(space, (-3, 2)) == (0, 2)


def test_borders_have_the_shape_on_their_left():
    ring = Polygon(box(0, 0, 10, 10).difference(box(3, 3, 7, 7)))
    for shape in (ring, Polygon(ring.exterior.coords[::-1], [ring.interiors[0].coords[::-1]])):
        edges = border_segments(MultiPolygon([shape]))
        assert edges.shape == (8, 4)
        middle = (edges[:, :2] + edges[:, 2:]) / 2
        along = edges[:, 2:] - edges[:, :2]
        left = np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(*along.T)[:, None]
        assert shapely.contains_xy(ring, middle + 0.01 * left).all()
        assert not shapely.contains_xy(ring, middle - 0.01 * left).any()
    assert border_segments(MultiPolygon()).shape == (0, 4)


def test_reflex_corners_are_the_corners_of_obstacles_and_of_bays():
    bay = Polygon([(0, 0), (10, 0), (10, 4), (4, 4), (4, 10), (0, 10)], [[(1, 1), (2, 1), (2, 1.5), (2, 2), (1, 2)]])
    at, before, after = border_corners(MultiPolygon([bay]))
    assert sorted(map(tuple, at.tolist())) == [(1, 1), (1, 2), (2, 1), (2, 2), (4, 4)]  # (2, 1.5) is on a side
    k = at.tolist().index([4, 4])
    assert (before[k].tolist(), after[k].tolist()) == ([10, 4], [4, 10])


def test_walls_of_sight_are_those_of_the_union_of_what_blocks_sight():
    shapes = [box(0, 0, 2, 2), box(2, 0, 4, 2)]
    fence, hedge = Obstacle(shape=box(6, 6, 7, 7), blocks="motion"), Obstacle(shape=box(8, 8, 9, 9), blocks="sight")
    walls = sight_walls(mission(box(0, 0, 10, 10), *shapes, fence, hedge))
    lengths = np.hypot(*(walls[:, 2:] - walls[:, :2]).T)
    assert lengths.sum() == pytest.approx(12 + 4)
    assert sight_walls(mission(box(0, 0, 10, 10), fence)).shape == (0, 4)


def regions_of(*args, **settings):
    return {region.name: region for region in demanded_regions(mission(*args, **settings))}


def test_among_overlapping_zones_the_smallest_period_rules():
    zones = [
        zone("slow", 30, box(0, 0, 6, 6)),
        zone("fast", 10, box(4, 4, 12, 12)),
        zone("never", None, box(0, 0, 3, 9)),
    ]
    found = regions_of(box(0, 0, 10, 10), zones=zones, period_s=60)
    assert list(found) == ["slow", "fast", "area"]
    assert found["fast"].shape.area == 36  # what sticks out of the area is cut off
    assert found["slow"].shape.area == 36 - 4
    assert found["area"].shape.area == 100 - 36 - 36 + 4 - 3 * 3  # less what only "never" covers
    assert [found[name].period_s for name in found] == [30, 10, 60]
    total = shapely.union_all([region.shape for region in found.values()])
    assert total.area == pytest.approx(sum(region.shape.area for region in found.values()), abs=1e-12)


def test_a_zone_may_ask_more_seldom_than_the_area():
    found = regions_of(box(0, 0, 10, 10), zones=[zone("yard", 500, box(0, 0, 5, 10))], period_s=60)
    assert (found["yard"].shape.area, found["area"].shape.area) == (50, 50)


def test_what_blocks_sight_is_not_demanded_and_what_blocks_motion_is():
    fence, hedge = Obstacle(shape=box(1, 1, 2, 2), blocks="motion"), Obstacle(shape=box(3, 1, 4, 2), blocks="sight")
    found = regions_of(box(0, 0, 10, 10), box(5, 5, 7, 7), fence, hedge, zones=[zone("z", 9, box(0, 0, 6, 6))])
    assert found["z"].shape.area == 36 - 1 - 1
    assert found["area"].shape.area == 100 - 36 - 4 + 1


def test_the_planner_and_the_check_ask_nothing_under_an_obstacle_that_asks_nothing():
    fence = Obstacle(shape=box(1, 1, 5, 5), blocks="motion", asks="nothing")
    block = Obstacle(shape=box(4, 4, 6, 6), asks="nothing")
    ground = mission(box(0, 0, 10, 10), fence, block, zones=[zone("z", 9, box(0, 0, 3, 10))])
    asked = {"z": 30 - 2 * 4, "area": 70 - 2 * 4 - 4 + 1}
    assert {region.name: region.shape.area for region in demanded_regions(ground)} == pytest.approx(asked)
    assert {demand.name: demand.region.area for demand in demands_of(ground)} == pytest.approx(asked)


def test_a_zone_to_visit_keeps_itself_and_frees_its_ground_from_the_area_only():
    visit = zone("dock", 20, box(0, 0, 4, 4), demand="visit")
    found = regions_of(box(0, 0, 10, 10), box(0, 0, 1, 1), zones=[visit, zone("z", 30, box(2, 2, 6, 6))], period_s=60)
    assert (found["dock"].demand, found["dock"].shape.area) == ("visit", 16)
    assert found["z"].shape.area == 16
    assert found["area"].shape.area == 100 - 16 - 16 + 4


def test_regions_left_empty_are_absent():
    assert list(regions_of(box(0, 0, 10, 10), zones=[zone("z", 9, box(0, 0, 5, 5))], period_s=None)) == ["z"]
    assert list(regions_of(box(0, 0, 10, 10), zones=[zone("z", 9, box(-1, -1, 11, 11))])) == ["z"]
    hidden = regions_of(box(0, 0, 10, 10), box(2, 2, 5, 5), zones=[zone("z", 9, box(3, 3, 4, 4))])
    assert list(hidden) == ["area"]
    twins = [zone("a", 9, box(0, 0, 5, 5)), zone("b", 9, box(0, 0, 5, 5))]
    assert list(regions_of(box(0, 0, 10, 10), zones=twins)) == ["a", "area"]
