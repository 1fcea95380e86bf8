from __future__ import annotations

import numpy as np
import pytest
import shapely
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from shapely import MultiPolygon, Polygon, box
from tests.seeds import seeds

from rota.errors import PlanError
from rota.geometry.shortest_path import ShortestPaths

SQUARE_WITH_BLOCK = MultiPolygon([Polygon(box(0, 0, 10, 10).difference(box(3, 3, 7, 7)))])


def lengths_over_all_corners(space: MultiPolygon, points: np.ndarray) -> np.ndarray:
    """Shortest lengths between points by a graph over every corner of the space, every line tried with shapely."""
    found = np.full((len(points), len(points)), np.inf)
    for part in space.geoms:
        grown = part.buffer(1e-8, join_style="mitre")
        shapely.prepare(grown)
        mine = np.flatnonzero(shapely.covers(grown, shapely.points(points)))
        places = np.vstack([points[mine], np.unique(shapely.get_coordinates(part), axis=0)])
        one, other = np.triu_indices(len(places), 1)
        lines = shapely.linestrings(np.stack([places[one], places[other]], axis=1))
        open_lines = shapely.covers(grown, lines)
        graph = csr_array(
            (shapely.length(lines[open_lines]), (one[open_lines], other[open_lines])), shape=(len(places), len(places))
        )
        within = dijkstra(graph, directed=False)[: len(mine), : len(mine)]
        found[np.ix_(mine, mine)] = np.minimum(found[np.ix_(mine, mine)], within)
    return found


@pytest.mark.parametrize("seed", range(40))
def test_lengths_are_those_of_a_graph_over_all_corners(seed, random_space, points_in):
    space = random_space(seed)
    points = points_in(space, 18, seed)
    paths = ShortestPaths(space)
    expected = lengths_over_all_corners(space, points)
    part = paths.part_of(points)
    assert (part >= 0).all()
    together = part[:, None] == part
    found = paths.all_pairs(points)
    np.testing.assert_allclose(found[together], expected[together], rtol=0, atol=1e-6)
    assert np.isinf(found[~together]).all()
    assert (found == found.T).all()
    np.testing.assert_allclose(paths.distances(points[:7], points[5:]), found[:7, 5:], rtol=0, atol=1e-9)


@pytest.mark.parametrize("seed", seeds(40, at_once=10))
def test_paths_stay_in_the_space_and_have_the_length_given(seed, random_space, points_in):
    space = random_space(seed)
    points = points_in(space, 12, 100 + seed)
    paths = ShortestPaths(space)
    lengths = paths.all_pairs(points)
    grown = space.buffer(2e-9, join_style="mitre")
    shapely.prepare(grown)
    for k in range(len(points)):
        for m in range(len(points)):
            if np.isinf(lengths[k, m]):
                with pytest.raises(PlanError, match="two parts"):
                    paths.path(points[k], points[m])
                continue
            line = paths.path(points[k], points[m])
            assert (line[0] == points[k]).all()
            assert (line[-1] == points[m]).all()
            assert np.hypot(*np.diff(line, axis=0).T).sum() == pytest.approx(lengths[k, m], abs=1e-9)
            assert shapely.LineString(line).difference(grown).length < 1e-6


def test_round_a_square_block():
    paths = ShortestPaths(SQUARE_WITH_BLOCK)
    assert len(paths.corners_m) == 4
    found = paths.distances(np.array([[1.0, 5.0], [0.0, 0.0]]), np.array([[9.0, 5.0], [10.0, 10.0]]))
    around = np.hypot(2, 2) + 4 + np.hypot(2, 2)
    past_one_corner = np.hypot(2, 2) + np.hypot(7, 3)
    expected = [[around, past_one_corner], [past_one_corner, 2 * np.hypot(7, 3)]]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(paths.path((3, 3), (7, 7))[[0, -1]], [[3, 3], [7, 7]])


def test_a_line_through_two_opposite_corners_is_no_path():
    paths = ShortestPaths(SQUARE_WITH_BLOCK)
    assert paths.all_pairs(np.array([[3.0, 3.0], [7.0, 7.0]]))[0, 1] == 8
    assert paths.all_pairs(np.array([[2.0, 2.0], [8.0, 8.0]]))[0, 1] == pytest.approx(2 * np.hypot(1, 5), abs=1e-12)


def test_a_line_along_a_wall_and_past_its_corners_is_straight():
    paths = ShortestPaths(SQUARE_WITH_BLOCK)
    np.testing.assert_array_equal(paths.path((0, 3), (10, 3)), [[0, 3], [10, 3]])
    np.testing.assert_array_equal(paths.path((1, 5), (5, 1)), [[1, 5], [5, 1]])  # grazes the corner (3, 3)


def test_an_l_shaped_room_bends_at_its_only_reflex_corner():
    room = MultiPolygon([Polygon([(0, 0), (10, 0), (10, 4), (4, 4), (4, 10), (0, 10)])])
    paths = ShortestPaths(room)
    np.testing.assert_array_equal(paths.corners_m, [[4, 4]])
    np.testing.assert_array_equal(paths.path((10, 4), (4, 10)), [[10, 4], [4, 4], [4, 10]])
    np.testing.assert_array_equal(paths.path((9, 2), (2, 9)), [[9, 2], [4, 4], [2, 9]])
    np.testing.assert_array_equal(paths.path((6, 2), (2, 6)), [[6, 2], [2, 6]])


def test_a_squeeze_between_two_blocks_that_touch_is_open_to_a_point():
    blocks = box(2, 2, 5, 5).union(box(5, 5, 8, 8))
    paths = ShortestPaths(MultiPolygon([Polygon(box(0, 0, 10, 10).difference(blocks))]))
    np.testing.assert_allclose(paths.path((4, 6), (6, 4)), [[4, 6], [6, 4]])
    assert paths.distances([(5, 7)], [(7, 5)])[0, 0] == 4
    assert len(paths.path((5, 7), (7, 5))) == 3


def test_parts_are_numbered_largest_first_and_nobody_crosses():
    paths = ShortestPaths(MultiPolygon([box(0, 0, 1, 1), box(2, 0, 5, 3)]))
    points = np.array([[0.5, 0.5], [3.0, 1.0], [1.5, 0.5], [2.0, 2.0], [1.0, 1.0]])
    np.testing.assert_array_equal(paths.part_of(points), [1, 0, -1, 0, 1])
    lengths = paths.all_pairs(points)
    assert np.isfinite(lengths).tolist() == [
        [True, False, False, False, True],
        [False, True, False, True, False],
        [False] * 5,
        [False, True, False, True, False],
        [True, False, False, False, True],
    ]
    with pytest.raises(PlanError, match=r"\[1.5, 0.5\] lies outside"):
        paths.path((1.5, 0.5), (3, 1))
    with pytest.raises(PlanError, match=r"no path leads from \[0.5, 0.5\] to \[3.0, 1.0\]"):
        paths.paths_along(points[:2])


def test_parts_that_touch_at_a_point_are_apart():
    paths = ShortestPaths(MultiPolygon([box(0, 0, 1, 1), box(1, 1, 3, 3)]))
    assert np.isinf(paths.distances([(0.5, 0.5)], [(2, 2)])[0, 0])


def test_a_polyline_goes_through_all_points_in_order():
    paths = ShortestPaths(SQUARE_WITH_BLOCK)
    line = paths.paths_along(np.array([[1.0, 5], [9, 5], [9, 5], [9, 9], [1, 9]]))
    assert len(line) == 6
    np.testing.assert_array_equal(line[[0, 3, 4, 5]], [[1, 5], [9, 5], [9, 9], [1, 9]])
    np.testing.assert_array_equal(paths.paths_along([(1, 5)]), [[1, 5]])
    np.testing.assert_array_equal(paths.path((1, 5), (1, 5)), [[1, 5], [1, 5]])
    assert paths.paths_along(np.zeros((0, 2))).shape == (0, 2)


def test_an_empty_space_holds_nothing():
    paths = ShortestPaths(MultiPolygon())
    assert paths.part_of([(0, 0)]).tolist() == [-1]
    assert np.isinf(paths.all_pairs([(0, 0), (1, 1)])).all()
    assert paths.distances(np.zeros((0, 2)), [(1, 1)]).shape == (0, 1)


def test_points_of_a_wrong_shape_are_refused():
    paths = ShortestPaths(SQUARE_WITH_BLOCK)
    with pytest.raises(ValueError, match=r"shape \(2, 3\)"):
        paths.all_pairs(np.zeros((2, 3)))
    with pytest.raises(ValueError, match="row 1 is not finite"):
        paths.part_of([(0, 0), (np.nan, 0)])


def test_a_spiral_is_followed_to_its_middle():
    walls = [box(0, 1, 6, 1.2), box(5.8, 1, 6, 6), box(1, 5.8, 6, 6), box(1, 2.2, 1.2, 6), box(1, 2.2, 5, 2.4)]
    space = box(0, 0, 7, 7).difference(shapely.union_all(walls))
    paths = ShortestPaths(MultiPolygon([Polygon(space)]))
    by_hand = [[0.5, 0.5], [6, 1], [6, 6], [1, 6], [1, 2.2], [5, 2.2], [5, 2.4], [3, 4]]
    np.testing.assert_allclose(paths.path((0.5, 0.5), (3, 4)), by_hand)
    expected = np.hypot(*np.diff(by_hand, axis=0).T).sum()
    assert paths.distances([(0.5, 0.5)], [(3, 4)])[0, 0] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("seed", range(8))
def test_searching_along_the_links_gives_the_lengths_and_ways_of_the_whole_table(seed, random_space, points_in):
    space = random_space(seed)
    points = points_in(space, 18, seed)
    table, searched = ShortestPaths(space), ShortestPaths(space, most_dense=0)
    expected = table.all_pairs(points)
    found = searched.all_pairs(points)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)
    assert (found == found.T).all()
    np.testing.assert_allclose(searched.distances(points[:7], points[5:]), expected[:7, 5:], rtol=0, atol=1e-9)
    for k in range(len(points) - 1):
        if np.isfinite(expected[k, k + 1]):
            way = searched.path(points[k], points[k + 1])
            steps = np.diff(way, axis=0)
            assert np.hypot(steps[:, 0], steps[:, 1]).sum() == pytest.approx(expected[k, k + 1], abs=1e-9)
            assert (way[[0, -1]] == points[k : k + 2]).all()
        else:
            with pytest.raises(PlanError, match="no path leads"):
                searched.path(points[k], points[k + 1])


@pytest.mark.parametrize("seed", range(3))
def test_ways_from_point_to_point_are_shortest_up_to_a_step_and_never_shorter(seed, random_space, points_in):
    space = random_space(seed)
    points = points_in(space, 40, seed)
    exact = ShortestPaths(space).all_pairs(points)
    near = 0.3 * exact[np.isfinite(exact)].max()
    found = ShortestPaths(space, most_dense=0).lengths_from_point_to_point(points, near)
    np.testing.assert_allclose(found[exact <= near], exact[exact <= near], rtol=0, atol=1e-9)
    assert (found >= exact - 1e-9).all()
    assert (np.isfinite(found) == np.isfinite(exact)).all()
    assert (found == found.T).all()


@pytest.mark.parametrize("seed", range(8))
def test_links_that_are_taken_over_give_the_same_lengths_where_ground_is_lost(seed, random_space, points_in):
    """And ways that are hardly too long where ground is new."""
    space = random_space(seed)
    corner = shapely.get_coordinates(space)[3]
    less = shapely.difference(space, shapely.Point(corner).buffer(0.4, quad_segs=3))
    less = MultiPolygon([part for part in shapely.get_parts(less) if part.geom_type == "Polygon"])
    points = points_in(less, 12, seed)
    whole, cut = ShortestPaths(space, most_dense=0), ShortestPaths(less, most_dense=0)
    taken = ShortestPaths(less, most_dense=0, like=whole)
    assert np.allclose(taken.all_pairs(points), cut.all_pairs(points), rtol=0, atol=1e-9)
    again = ShortestPaths(space, most_dense=0, like=taken)
    lengths_m, least_m = again.all_pairs(points), whole.all_pairs(points)
    assert (lengths_m >= least_m - 1e-9).all()
    assert (lengths_m <= cut.all_pairs(points) + 1e-9).all()
