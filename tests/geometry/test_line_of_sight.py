from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, Polygon, box
from tests.seeds import seeds

from rota.geometry.free_space import border_segments
from rota.geometry.line_of_sight import edge_grid, points_inside, sees, segments_free, visibility_polygon

BLOCK = MultiPolygon([box(3, 3, 7, 7)])
ROOM = MultiPolygon([Polygon(box(0, 0, 10, 10).difference(box(3, 3, 7, 7)))])


def pairs(*rows: tuple[float, float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    table = np.array(rows, dtype=np.float64)
    return np.ascontiguousarray(table[:, :2]), np.ascontiguousarray(table[:, 2:])


@pytest.mark.parametrize("cell_m", [None, 0.7, 1.0, 100.0])
@pytest.mark.parametrize("seed", range(15))
def test_segments_and_points_are_judged_as_shapely_judges_them(seed, cell_m, random_space, points_in):
    space = random_space(seed)
    rng = np.random.default_rng(seed)
    points = points_in(space, 60, 200 + seed)
    a, b = points[rng.integers(0, 60, 800)], points[rng.integers(0, 60, 800)]
    grid = edge_grid(border_segments(space), cell_m)
    grown = space.buffer(1e-8, join_style="mitre")
    shapely.prepare(grown)
    expected = shapely.covers(grown, shapely.linestrings(np.stack([a, b], axis=1)))
    np.testing.assert_array_equal(segments_free(a, b, grid), expected)
    assert 0.05 < expected.mean() < 0.95
    anywhere = rng.uniform(-2, 22, (1000, 2))
    np.testing.assert_array_equal(points_inside(anywhere, grid), shapely.contains_xy(space, anywhere))
    assert points_inside(points, grid).all()
    assert points_inside(shapely.get_coordinates(space), grid).all()


@pytest.mark.parametrize("seed", range(15))
def test_sight_is_judged_as_shapely_judges_it(seed, random_space):
    walls = box(-5, -5, 25, 25).difference(random_space(seed))
    blockers = MultiPolygon([part for part in shapely.get_parts(walls) if part.area > 1e-6])
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(-8, 28, (1500, 2)), rng.uniform(-8, 28, (1500, 2))
    b[:700] = a[:700] + rng.normal(0, 2, (700, 2))
    expected = ~shapely.intersects(blockers, shapely.linestrings(np.stack([a, b], axis=1)))
    np.testing.assert_array_equal(sees(a, b, edge_grid(border_segments(blockers))), expected)
    assert 0.02 < expected.mean() < 0.9


def test_what_touches_is_free_and_what_enters_is_not():
    a, b = pairs(
        (0, 3, 10, 3),  # along a side of the block and beyond both its ends
        (3, 3, 7, 3),  # that side itself
        (4, 3, 6, 3),  # a piece of it
        (1, 5, 5, 1),  # past the corner (3, 3)
        (3, 3, 7, 7),  # corner to opposite corner
        (2, 2, 8, 8),  # the same line, longer
        (3, 3, 5, 7),  # corner to the far side
        (3, 5, 7, 5),  # side to side
        (3, 5, 0, 5),  # away from a side
        (0, 0, 10, 0),  # along the outer border
        (0, 0, 3, 3),  # outer corner to a corner of the block
        (3, 3, 3, 3),  # no length
        (1, 5, 9, 5),
        (2.9, 0, 2.9, 10),
    )
    expected = [True, True, True, True, False, False, False, False, True, True, True, True, False, True]
    grid = edge_grid(border_segments(ROOM))
    assert segments_free(a, b, grid).tolist() == expected
    assert segments_free(b, a, grid).tolist() == expected
    assert sees(a, b, edge_grid(border_segments(BLOCK))).tolist() == expected


@pytest.mark.parametrize(("depth_m", "free"), [(-1e-6, True), (0.0, True), (4e-10, True), (1e-7, False), (1e-3, False)])
def test_a_line_may_cut_a_corner_by_a_billionth_of_a_metre(depth_m, free):
    # the line x + y = 6 grazes the corner (3, 3); moved towards (7, 7) it cuts the corner off
    shift = depth_m / math.sqrt(2)
    a, b = pairs((1 + shift, 5 + shift, 5 + shift, 1 + shift), (0, 3 + depth_m, 10, 3 + depth_m))
    assert segments_free(a, b, edge_grid(border_segments(ROOM))).tolist() == [free, free]
    assert sees(a, b, edge_grid(border_segments(BLOCK))).tolist() == [free, free]


@pytest.mark.parametrize("turn", np.linspace(0, 2 * math.pi, 13))
@pytest.mark.parametrize("away_m", [0.0, 1e3, 1e5])
def test_touching_is_judged_the_same_wherever_the_room_lies(turn, away_m):
    # rotation and distance bring rounding into every coordinate
    def place(points):
        spin = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
        return points @ spin + away_m

    room = MultiPolygon([shapely.transform(ROOM.geoms[0], place)])
    a, b = pairs((0, 3, 10, 3), (3, 3, 7, 3), (1, 5, 5, 1), (3, 3, 7, 7), (2, 2, 8, 8), (3, 5, 7, 5), (0, 0, 3, 3))
    grid = edge_grid(border_segments(room))
    assert segments_free(place(a), place(b), grid).tolist() == [True, True, True, False, False, False, True]


def test_between_obstacles_that_touch_in_a_point_one_can_look():
    two = MultiPolygon([box(2, 2, 5, 5), box(5, 5, 8, 8)])
    grid = edge_grid(border_segments(two))
    a, b = pairs((4, 6, 6, 4), (2, 8, 8, 2), (2, 2, 8, 8), (4.5, 6, 5, 5), (3, 6, 7, 4))
    assert sees(a, b, grid).tolist() == [True, True, False, True, True]


def test_inside_an_obstacle_nothing_is_seen():
    grid = edge_grid(border_segments(BLOCK))
    a, b = pairs((4, 4, 5, 5), (4, 4, 4, 4), (4, 4, 1, 1), (1, 1, 4, 4), (3, 4, 1, 1), (3, 4, 3, 6))
    assert sees(a, b, grid).tolist() == [False, False, False, False, True, True]


def test_without_edges_nothing_is_inside_and_everything_is_seen():
    grid = edge_grid(np.zeros((0, 4)))
    a, b = pairs((0, 0, 5, 5), (-9, 3, 0.5, 0.5))
    assert sees(a, b, grid).all()
    assert not points_inside(a, grid).any()
    assert segments_free(np.zeros((0, 2)), np.zeros((0, 2)), grid).shape == (0,)


def test_bad_input_is_refused():
    with pytest.raises(ValueError, match=r"edges_m: shape \(2, 2\)"):
        edge_grid(np.zeros((2, 2)))
    with pytest.raises(ValueError, match="edges_m: row 1 is not finite"):
        edge_grid(np.array([[0, 0, 1, 1], [0, 0, 1, np.inf]]))
    with pytest.raises(ValueError, match="cell_m: 0"):
        edge_grid(border_segments(ROOM), 0.0)
    with pytest.raises(ValueError, match="2 and 1 points"):
        sees(np.zeros((2, 2)), np.zeros((1, 2)), edge_grid(np.zeros((0, 4))))
    with pytest.raises(ValueError, match="reach_m: -1"):
        visibility_polygon((0, 0), np.zeros((0, 4)), -1.0)
    with pytest.raises(ValueError, match="sides: 2"):
        visibility_polygon((0, 0), np.zeros((0, 4)), 1.0, sides=2)


def test_an_open_view_is_a_polygon_round_the_circle():
    view = visibility_polygon((2, 1), np.zeros((0, 4)), 5.0)
    assert len(view.exterior.coords) == 65
    assert view.area == pytest.approx(64 * math.tan(math.pi / 64) * 25)
    assert view.exterior.distance(shapely.Point(2, 1)) == pytest.approx(5.0)
    square = visibility_polygon((2, 1), np.zeros((0, 4)), 5.0, sides=4)
    assert square.symmetric_difference(box(-3, -4, 7, 6)).area < 1e-12


def test_a_wall_casts_its_shadow():
    # from the middle of a square of half side 10 the block (2, -1)-(4, 1) hides a trapezium from x = 2 to 10
    block = border_segments(MultiPolygon([box(2, -1, 4, 1)]))
    view = visibility_polygon((0, 0), block, 10.0, sides=4)
    assert view.area == pytest.approx(400 - (2 + 10) / 2 * 8)
    assert not view.covers(shapely.Point(3, 0))
    assert view.covers(shapely.Point(2, 0))


def test_against_a_wall_half_is_seen_and_at_a_corner_three_quarters():
    block = border_segments(BLOCK)
    assert visibility_polygon((3, 5), block, 1.0, sides=4).area == pytest.approx(2)
    assert visibility_polygon((3, 3), block, 1.0, sides=4).area == pytest.approx(3)
    assert visibility_polygon((2, 3), block, 2.0, sides=4).area == pytest.approx(16 - 1 * 2)
    assert visibility_polygon((5, 5), block, 9.0).is_empty
    room = border_segments(MultiPolygon([Polygon(box(-1, -1, 11, 11).difference(box(0, 0, 10, 10)))]))
    assert visibility_polygon((0, 0), room, 1.0, sides=4).area == pytest.approx(1)


def test_where_two_obstacles_touch_both_sides_are_seen():
    two = border_segments(MultiPolygon([box(2, 2, 5, 5), box(5, 5, 8, 8)]))
    view = visibility_polygon((5, 5), two, 1.0, sides=4)
    assert len(view.geoms) == 2
    assert view.area == pytest.approx(2)


@pytest.mark.parametrize("sides", [4, 64])
@pytest.mark.parametrize("seed", seeds(12, at_once=4))
def test_views_hold_the_points_that_lines_of_sight_reach(seed, sides, random_space, points_in):
    space = random_space(seed)
    surroundings = box(-30, -30, 50, 50).difference(space)
    blockers = MultiPolygon([part for part in shapely.get_parts(surroundings) if part.area > 1e-6])
    walls = border_segments(blockers)
    rng = np.random.default_rng(seed)
    for point in points_in(space, 9, 300 + seed):
        view = visibility_polygon(point, walls, 6.0, sides=sides)
        assert view.is_valid
        rim = visibility_polygon(point, walls[:0], 6.0, sides=sides)
        targets = point + rng.uniform(-6.2, 6.2, (300, 2))
        lines = shapely.linestrings(np.stack([np.broadcast_to(point, targets.shape), targets], axis=1))
        hidden = shapely.length(shapely.intersection(lines, blockers.buffer(-1e-9))) > 1e-7
        expected = shapely.contains_xy(rim, targets) & ~hidden
        clear_cut = shapely.distance(shapely.points(targets), view.boundary) > 1e-6
        found = shapely.contains_xy(view, targets)
        np.testing.assert_array_equal(found[clear_cut], expected[clear_cut])


@pytest.mark.parametrize("seed", range(12))
def test_views_are_the_rim_less_every_shadow(seed, random_space, points_in):
    space = random_space(seed)
    surroundings = box(-2, -2, 22, 22).difference(space)
    walls = border_segments(MultiPolygon([part for part in shapely.get_parts(surroundings) if part.area > 1e-6]))
    for point in points_in(space, 30, 400 + seed)[20:]:
        shadows = []
        for x0, y0, x1, y1 in walls:
            near = np.array([[x0, y0], [x1, y1]])
            far = point + 1e5 * (near - point)  # so far that no chord comes back into reach
            shadows.append(shapely.MultiPoint(np.vstack([near, far])).convex_hull)
        rim = visibility_polygon(point, walls[:0], 30.0)
        expected = rim.difference(shapely.union_all(shadows))
        view = visibility_polygon(point, walls, 30.0)
        assert view.area == pytest.approx(expected.area, rel=1e-8)
        assert view.symmetric_difference(expected).area < 1e-6
