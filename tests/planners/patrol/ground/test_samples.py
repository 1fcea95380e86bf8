"""Sample points lie where they should and know the walls that hide them."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely import LineString, MultiPolygon, Point, Polygon, affinity, box

from rota.geometry.free_space import DemandedRegion, border_segments
from rota.planners.patrol.ground.sample_kernels import Leg, leg_sees
from rota.planners.patrol.ground.samples import (
    border,
    join,
    known_walls,
    lattice,
    one_a_cell,
    points_of,
    prepare,
    region_points,
    thin,
    visit_point,
    walls_in_reach,
)

Floats = NDArray[np.float64]
L_SHAPE = MultiPolygon([Polygon([(0, 0), (9, 0), (9, 4), (4, 4), (4, 8), (0, 8)])])
WITH_HOLE = MultiPolygon([Polygon(box(0, 0, 12, 10).exterior, [box(3, 3, 6, 7).exterior])])
TILTED = MultiPolygon([affinity.rotate(L_SHAPE.geoms[0], 33)])
PARTS = MultiPolygon([box(0, 0, 3, 3), box(5, 5, 9, 6)])
SHAPES = [L_SHAPE, WITH_HOLE, TILTED, PARTS]


def region(shape: MultiPolygon, demand: str = "every_point") -> DemandedRegion:
    return DemandedRegion(name="zone", period_s=10, demand=demand, shape=shape)  # type: ignore[arg-type]


@pytest.mark.parametrize("shape", SHAPES)
def test_the_lattice_lies_in_the_shape_and_stands_for_its_area(shape: MultiPolygon) -> None:
    places = lattice(shape, 0.25)
    assert all(shape.contains(Point(place)) for place in places)
    assert len(places) * 0.25**2 == pytest.approx(shape.area, rel=0.05)
    # each pair of neighbours is a whole number of steps apart
    steps = (places - places[0]) / 0.25
    assert steps == pytest.approx(np.rint(steps), abs=1e-6)
    # nothing in the shape is farther from it than half a cell's diagonal, but at the border
    inner = shape.buffer(-0.25)
    anywhere = np.random.default_rng(1).uniform(shape.bounds[:2], shape.bounds[2:], (3000, 2))
    anywhere = anywhere[shapely.contains_xy(inner, anywhere)]
    away = np.hypot(*(anywhere[:, None] - places[None]).transpose(2, 0, 1)).min(axis=1)
    assert away.max() <= 0.25 / math.sqrt(2) + 1e-9


def test_a_lattice_by_hand() -> None:
    # 3.5 m by 2 m in cells of 1 m: four columns and two rows about the middle
    places = lattice(MultiPolygon([box(0, 0, 3.5, 2)]), 1.0)
    assert sorted(places.tolist()) == [[x, y] for x in (0.25, 1.25, 2.25, 3.25) for y in (0.5, 1.5)]
    # a strip too thin for any cell's centre but the middle one's
    assert lattice(MultiPolygon([box(0, 0, 0.2, 3)]), 1.0).tolist() == [[0.1, 0.5], [0.1, 1.5], [0.1, 2.5]]


@pytest.mark.parametrize("shape", SHAPES)
def test_border_points_lie_just_inside_and_close_together(shape: MultiPolygon) -> None:
    places = border(shape, 0.5, 0.01)
    assert shape.contains(shapely.multipoints(places))
    assert shapely.distance(shapely.points(places), shape.boundary) == pytest.approx(0.01, abs=0.01)
    along = shapely.get_coordinates(shapely.segmentize(shape.boundary, 0.01))
    away = np.hypot(*(along[:, None] - places[None]).transpose(2, 0, 1)).min(axis=1)
    assert away.max() <= 0.25 + 0.02
    corners = np.unique(shapely.get_coordinates(shape), axis=0)
    away = np.hypot(*(corners[:, None] - places[None]).transpose(2, 0, 1)).min(axis=1)
    assert away.max() <= 0.01 * math.sqrt(2) + 1e-9


def test_the_border_of_a_sliver_is_its_border() -> None:
    sliver = MultiPolygon([box(0, 0, 5, 0.01)])
    places = border(sliver, 1.0, 0.05)
    assert len(places) >= 10
    assert sliver.covers(shapely.multipoints(places))


def test_the_points_of_a_region() -> None:
    points = region_points(region(WITH_HOLE), 3, 2, WITH_HOLE, spacing_m=0.5, shrink_m=0.15, inset_m=0.01)
    assert set(points.region.tolist()) == {3}
    assert set(points.period.tolist()) == {2}
    assert (points.visit_m == 0).all()
    # lattice points stand for the ground round them, border points only for themselves
    inside = points.shrink_m == 0.15
    assert len(points) > inside.sum() > 0
    assert points.area_m2[inside].sum() == pytest.approx(WITH_HOLE.area, rel=0.1)
    assert (points.shrink_m[~inside] == 0).all()


@pytest.mark.parametrize("shape", SHAPES)
def test_a_quarter_of_the_points_stands_for_all(shape: MultiPolygon) -> None:
    points = region_points(region(shape), 0, 0, shape, spacing_m=0.1, shrink_m=0.02, inset_m=0.01)
    few = thin(points)
    inside, kept = points.row >= 0, few.row >= 0
    assert kept.sum() == pytest.approx(inside.sum() / 4, rel=0.05)
    assert few.area_m2[kept].sum() == pytest.approx(points.area_m2[inside].sum(), rel=0.05)
    assert few.xy_m[~kept].tolist() == points.xy_m[~inside].tolist()  # the border is whole
    # the rest is a lattice of twice the spacing, of places that were there before
    assert {tuple(xy) for xy in few.xy_m[kept].tolist()} <= {tuple(xy) for xy in points.xy_m[inside].tolist()}
    corner = few.xy_m[kept] - 0.2 * np.column_stack([few.column[kept], few.row[kept]])
    assert np.ptp(corner, axis=0) == pytest.approx([0, 0], abs=1e-9)
    _, samples, order = prepare(few, np.zeros((0, 4)), reach_m=1, weight=few.area_m2, wall_margin_m=0.001)
    assert samples.frames[:, 2] == pytest.approx([0.2])
    assert sorted(order.tolist()) == list(range(len(few)))


def test_a_zone_to_visit_is_one_point_deep_inside() -> None:
    points = region_points(region(L_SHAPE, "visit"), 1, 0, L_SHAPE, spacing_m=0.5, shrink_m=0.15, inset_m=0.01)
    assert len(points) == 1
    radius = float(points.visit_m[0])
    # the widest circle of this L touches both outer walls and the inner corner: r sqrt 2 + r = 4 sqrt 2 from the corner
    assert radius == pytest.approx(0.98 * 4 * math.sqrt(2) / (math.sqrt(2) + 1), rel=0.01)
    assert L_SHAPE.covers(Point(points.xy_m[0]).buffer(radius))
    # of several parts the largest
    two = MultiPolygon([box(0, 0, 1, 1), box(5, 5, 9, 6)])
    assert two.geoms[1].contains(Point(visit_point(two, two, 0, 0, 1.0).xy_m[0]))


def test_a_zone_is_visited_where_robots_can_be() -> None:
    zone, east = MultiPolygon([box(0, 0, 4, 4)]), MultiPolygon([box(3, -2, 9, 6)])
    point = visit_point(zone, east, 2, 1, 5.0)
    # all but the last metre is built over: the largest circle there has half a metre
    assert point.visit_m.tolist() == pytest.approx([0.98 * 0.5], rel=1e-3)
    assert point.xy_m[0, 0] == pytest.approx(3.5, abs=1e-3)
    assert 0.5 <= point.xy_m[0, 1] <= 3.5
    assert (point.region.tolist(), point.period.tolist(), point.area_m2.tolist()) == ([2], [1], [5.0])
    # the zone's border is in it: to touch it is a visit, at that very place
    touched = visit_point(zone, MultiPolygon([box(4, 1, 9, 2)]), 0, 0, 1.0)
    assert touched.xy_m[0, 0] == 4
    assert 1 <= touched.xy_m[0, 1] <= 2
    assert touched.visit_m.tolist() == [1e-9]
    assert len(visit_point(zone, MultiPolygon([box(5, 1, 9, 2)]), 0, 0, 1.0)) == 0


def test_joining_and_selecting() -> None:
    one = points_of(np.array([[1.0, 2], [3, 4]]), 0.5, 1, 7, shrink_m=0.1)
    two = points_of(np.array([[5.0, 6]]), 2.0, 0, 8, visit_m=1.5)
    both = join([one, points_of(np.zeros((0, 2)), 0.0, 0, 0), two])
    assert len(both) == 3
    assert both.xy_m.tolist() == [[1, 2], [3, 4], [5, 6]]
    assert both.region.tolist() == [7, 7, 8]
    last = both[np.array([2, 0])]
    assert (last.area_m2.tolist(), last.visit_m.tolist(), last.period.tolist()) == ([2, 0.5], [1.5, 0], [0, 1])
    assert len(join([points_of(np.zeros((0, 2)), 0.0, 0, 0)])) == 0


def blocks(rng: np.random.Generator, n: int) -> MultiPolygon:
    """Boxes and triangles, grown together where they overlap."""
    drawn = rng.uniform(1, 9, (n, 5)) * (3, 3, 0.5, 1, 40)
    union = shapely.union_all([affinity.rotate(box(x, y, x + w, y + h), a) for x, y, w, h, a in drawn])
    return MultiPolygon([part for part in shapely.get_parts(union) if isinstance(part, Polygon)])


def test_walls_in_reach_are_in_reach_and_enough() -> None:
    rng = np.random.default_rng(12)
    dropped = compared = 0
    for _ in range(12):
        shape = blocks(rng, 7)
        walls = border_segments(shape)
        places = rng.uniform(0, 34, (60, 2))
        places = places[~shapely.intersects_xy(shape, places)]
        edge = shapely.get_coordinates(shapely.segmentize(shape.boundary, 3.0))
        points = points_of(np.vstack([places, edge[: 60 - len(places)]]), 1.0, 0, 0)
        start, items = walls_in_reach(points, walls, 8.0)
        _, samples, order = prepare(points, walls, reach_m=8.0, weight=np.ones(len(points)), wall_margin_m=0.004)
        lines = shapely.linestrings(walls.reshape(-1, 2, 2))
        near = shapely.distance(lines[None], shapely.points(points.xy_m)[:, None]) <= 8.0
        for i in range(len(points)):
            chosen = items[start[i] : start[i + 1]].tolist()
            assert chosen == sorted(set(chosen))
            assert near[i, chosen].all()
        dropped += int(near.sum()) - len(items)
        # with every wall in reach instead of the chosen ones, nothing is hidden that was not hidden before
        everything = samples._replace(
            wall_start=np.concatenate([[0], np.cumsum(near[order].sum(axis=1))]).astype(np.int64),
            wall_item=np.nonzero(near[order])[1].astype(np.int64),
        )
        out = np.empty(2 * len(points), dtype=np.int32)
        for leg in np.hstack([rng.uniform(0, 34, (40, 2)), rng.normal(0, 6, (40, 2))]):
            way = (leg[0], leg[1], leg[0] + leg[2], leg[1] + leg[3])
            if LineString([way[:2], way[2:]]).intersects(shape):
                continue
            some, all_ = (out[: leg_sees(Leg(*way, 7.0, 0), 0, s, out)].tolist() for s in (samples, everything))
            assert some == all_
            compared += int(np.diff(np.reshape(some, (-1, 2)), axis=1).sum())
    assert dropped > 1000
    assert compared > 500


def test_no_wall_hides_a_visit_and_where_there_are_none_none_is_kept() -> None:
    points = join([points_of(np.array([[0.0, 0]]), 1.0, 0, 0), points_of(np.array([[0.0, 0]]), 1.0, 0, 0, visit_m=2)])
    wall = np.array([[-1.0, 1, 1, 1]])
    start, items = walls_in_reach(points, wall, 5.0)
    assert (start.tolist(), items.tolist()) == ([0, 1, 1], [0])
    start, items = walls_in_reach(points, np.zeros((0, 4)), 5.0)
    assert (start.tolist(), items.tolist()) == ([0, 0, 0], [])
    assert walls_in_reach(points, wall + np.array([0, 5, 0, 5]), 5.0)[1].tolist() == []  # 6 m away


def test_prepared_points_are_sorted_by_bins() -> None:
    rng = np.random.default_rng(7)
    visits = points_of(rng.uniform(-5, 9, (3, 2)), 1.0, 0, 1, visit_m=6)
    points = join([points_of(rng.uniform(-5, 40, (200, 2)), 1.0, 1, 0), visits])
    weight = rng.uniform(0, 1, 203)
    walls = np.array([[0.0, 0, 3, 4]])
    _, samples, order = prepare(points, walls, reach_m=4.0, weight=weight, wall_margin_m=0.1)
    assert sorted(order.tolist()) == list(range(203))
    assert np.column_stack([samples.x, samples.y]).tolist() == points.xy_m[order].tolist()
    assert samples.weight.tolist() == weight[order].tolist()
    assert samples.period.tolist() == points.period[order].tolist()
    low_x, low_y, cell, far = samples.origin[:4]
    assert (low_x, low_y) == tuple(points.xy_m.min(axis=0))
    assert far == 6  # the visits reach farther than the sensor
    columns, rows = samples.bins
    assert len(samples.bin_start) == columns * rows + 1
    for b in range(columns * rows):
        for i in range(samples.bin_start[b], samples.bin_start[b + 1]):
            assert int((samples.x[i] - low_x) / cell) == b % columns
            assert int((samples.y[i] - low_y) / cell) == b // columns
    # walls are lengthened by the margin at both ends
    assert samples.walls == pytest.approx(np.array([[-0.06, -0.08, 3.06, 4.08]]))


def test_what_is_known_of_the_first_points_is_used_as_if_it_were_found_again() -> None:
    rng = np.random.default_rng(3)
    walls = rng.uniform(0, 20, (30, 4))
    first, second = (points_of(rng.uniform(0, 20, (n, 2)), 1.0, 0, 0) for n in (70, 40))
    settings = {"reach_m": 4.0, "wall_margin_m": 0.01}
    _, known, order = prepare(first, walls, weight=np.ones(70), **settings)
    both = join([first[order], second])
    weight = rng.uniform(1, 2, 110)
    _, at_once, one = prepare(both, walls, weight=weight, **settings)
    _, in_steps, other = prepare(both, walls, weight=weight, known=known_walls(known), **settings)
    assert one.tolist() == other.tolist()
    for name, field in at_once._asdict().items():
        assert getattr(in_steps, name).tolist() == field.tolist(), name


def test_of_very_many_points_one_in_each_cell_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    points = np.random.default_rng(3).uniform(-2, 2, (500, 2))
    assert one_a_cell(points, 0.5) is points  # few
    monkeypatch.setattr("rota.planners.patrol.ground.samples.MANY_CORNERS", 100)
    kept = one_a_cell(points, 0.5)
    assert len(kept) == len(np.unique(np.floor(kept / 0.5), axis=0)) == len(np.unique(np.floor(points / 0.5), axis=0))
    assert {tuple(point) for point in kept} <= {tuple(point) for point in points}
