"""Cells, and what a virtual sensor sees of them, against plain geometry."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, Point, Polygon, box

from rota.errors import NoPlanFound
from rota.model.polygons import polygons_of
from rota_studies.sun2019_stages.cells import (
    Cells,
    cells_of,
    cells_seen_from,
    ground_for,
    lattice_over,
)

NOTHING = MultiPolygon()


def seen_by_shapely(place: np.ndarray, cells: Cells, space: MultiPolygon, hidden: MultiPolygon, reach_m: float) -> set:
    """Cells all of whose corners are in reach, joined to the place by a line that stays out of what hides."""
    found = set()
    inside = hidden.buffer(-1e-6)
    for c, shape in enumerate(cells.shapes):
        corners = np.unique(shapely.get_coordinates(shape), axis=0)
        near = np.hypot(*(corners - place).T).max() <= reach_m
        if near and not any(shapely.LineString([place, corner]).intersects(inside) for corner in corners):
            found.add(c)
    return found


def test_the_paper_s_map_has_50_by_50_cells() -> None:
    lattice = lattice_over(box(0, 0, 120, 120), 2.4)
    assert (lattice.nx, lattice.ny) == (50, 50)
    assert len(lattice.points_m) == 50 * 50 + 51 * 51
    assert lattice.points_m.max() == pytest.approx(120.0)


def test_cells_by_centre_are_those_whose_middle_lies_in_the_zone() -> None:
    # middles at (k + 0.5) 2.4 m: k = 29..41 lie in 70..100, k = 29..43 in 70..105
    region = MultiPolygon([box(70, 70, 100, 105)])
    cells = cells_of(region, lattice_over(box(0, 0, 120, 120), 2.4), hidden=NOTHING, border="centre")
    assert len(cells) == 13 * 15
    assert shapely.area(cells.shapes) == pytest.approx(2.4**2)


def test_clipped_cells_hold_all_the_ground_and_no_other() -> None:
    ring = Polygon([(1, 1), (19, 3), (17, 18), (4, 15)], holes=[[(8.5, 8.5), (10.2, 8.5), (10.2, 11.1), (8.5, 11.1)]])
    region = MultiPolygon([ring, box(22.3, 2.2, 22.7, 6.1)])
    cells = cells_of(region, lattice_over(box(0, 0, 24, 20), 2.0), hidden=NOTHING, border="clipped")
    assert shapely.area(cells.shapes).sum() == pytest.approx(region.area)
    assert shapely.union_all(cells.shapes).symmetric_difference(region).area == pytest.approx(0, abs=1e-9)
    column, row = cells.square % 12, cells.square // 12
    squares = shapely.box(2.0 * column, 2.0 * row, 2.0 * column + 2, 2.0 * row + 2)
    assert shapely.covers(squares.tolist(), cells.shapes.tolist()).all()


def test_a_cell_whose_centre_counts_is_asked_for_but_for_what_hides() -> None:
    hidden = MultiPolygon([box(0, 0, 0.9, 10)])
    region = MultiPolygon([box(0.9, 0, 10, 10)])
    cells = cells_of(region, lattice_over(box(0, 0, 10, 10), 2.0), hidden=hidden, border="centre")
    assert len(cells) == 25
    assert shapely.bounds(cells.shapes)[:, 0].min() == 0.9


def test_an_open_view_sees_the_cells_with_all_corners_in_range() -> None:
    lattice = lattice_over(box(0, 0, 60, 60), 2.4)
    region = MultiPolygon([box(0, 0, 60, 60)])
    cells = cells_of(region, lattice, hidden=NOTHING, border="clipped")
    ground = ground_for(region, NOTHING, 10.0)
    place = np.array([31.3, 28.9])
    corners = np.stack(np.meshgrid(np.arange(26), np.arange(26)), axis=-1) * 2.4
    near = np.hypot(*np.moveaxis(corners - place, 2, 0)) <= 10
    whole = near[:-1, :-1] & near[1:, :-1] & near[:-1, 1:] & near[1:, 1:]
    start, items = cells_seen_from(place, cells, ground)
    assert start.tolist() == [0, whole.sum()]
    assert items.tolist() == np.flatnonzero(whole.ravel()).tolist()


def test_obstacles_hide_cells_as_plain_geometry_says() -> None:
    rng = np.random.default_rng(3)
    hidden = polygons_of(
        shapely.union_all(
            [box(10, 12, 18, 15), Point(24, 22).buffer(3), Polygon([(5, 25), (12, 22), (9, 31)]), box(27, 3, 27.2, 9)]
        )
    )
    region = polygons_of(box(0, 0, 34, 34).difference(hidden))
    cells = cells_of(region, lattice_over(box(0, 0, 34, 34), 1.7), hidden=hidden, border="clipped")
    ground = ground_for(region, hidden, 7.0)
    places = rng.uniform(0, 34, size=(60, 2))
    places = places[~shapely.intersects_xy(hidden, *places.T)]
    start, items = cells_seen_from(places, cells, ground)
    assert len(places) > 40
    for k, place in enumerate(places):
        assert set(items[start[k] : start[k + 1]]) == seen_by_shapely(place, cells, region, hidden, 7.0), place


def test_nothing_is_seen_from_inside_an_obstacle_and_all_from_its_edge() -> None:
    hidden = MultiPolygon([box(4, 4, 8, 8)])
    region = polygons_of(box(0, 0, 12, 12).difference(hidden))
    cells = cells_of(region, lattice_over(box(0, 0, 12, 12), 2.0), hidden=hidden, border="clipped")
    ground = ground_for(region, hidden, 6.0)
    start, items = cells_seen_from(np.array([[6.0, 6.0], [6.0, 4.0]]), cells, ground)
    assert start[1] == 0
    below = [c for c in range(len(cells)) if cells.centres_m[c, 1] < 4 and 2 < cells.centres_m[c, 0] < 10]
    assert set(below) <= set(items.tolist())
    assert all(cells.centres_m[c, 1] < 4 for c in items)


def test_quartered_cells_are_the_same_ground() -> None:
    region = MultiPolygon([box(0, 0, 4, 4)])
    cells = cells_of(region, lattice_over(box(0, 0, 4, 4), 2.0), hidden=NOTHING, border="clipped")
    finer = cells.quarter(np.array([1, 2]))
    assert sorted(shapely.area(finer.shapes).tolist()) == [1.0] * 8 + [4.0] * 2
    assert finer.square.tolist() == [0, 1, 1, 1, 1, 2, 2, 2, 2, 3]
    assert shapely.union_all(finer.shapes).area == 16


def test_too_many_cells_are_refused_with_a_size_that_is_allowed() -> None:
    with pytest.raises(NoPlanFound, match=r"cell_m: cells of 0\.001 m .* of about 0\.05 m or more"):
        lattice_over(box(0, 0, 100, 100), 0.001)
