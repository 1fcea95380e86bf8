"""Rows of lanes: whole robots just drive them, the loops see all of their ground, and whatever is cut fits together."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely import LinearRing, MultiPolygon, Point, Polygon, box

from rota.model.mission import DiscSensor, SquareSensor
from rota.planners.patrol.methods.large.lanes import ring_over
from rota.planners.patrol.methods.large.rows import (
    MOST_LANES,
    LaneCell,
    Row,
    RowMeasures,
    best_rows,
    columns_for,
    columns_of,
    lane_cells,
)
from rota.planners.patrol.methods.sweeping.lanes import Swath

FIVE = Swath(sensor=DiscSensor(radius_m=5), angle_rad=0.0)
SETTINGS = RowMeasures(budget_m=200.0, width_m=10.0, short_m=0.0, corner_m=0.0, sharing=16)

FIELD = MultiPolygon([box(0, 0, 300, 200)])
HOLED = MultiPolygon([box(0, 0, 300, 200).difference(Point(140, 90).buffer(35))])
KITE = MultiPolygon([Polygon([(0, 90), (160, 0), (300, 110), (150, 200)])])
COMB = MultiPolygon([box(0, 0, 300, 200).difference(box(100, 60, 180, 200))])


def seen(ring_m: np.ndarray) -> shapely.Geometry:
    """What a disc of 5 m sees that goes round a ring."""
    return LinearRing(ring_m).buffer(5, quad_segs=64)


@pytest.mark.parametrize("ground", [FIELD, HOLED, KITE, COMB])
def test_cells_share_nothing_and_hold_all_of_the_ground_two_lanes_at_a_time(ground: MultiPolygon) -> None:
    lanes = [lane for cell in lane_cells(ground, 0.0, 10.0) for lane in cell.lanes]
    assert sum(lane.area for lane in lanes) == pytest.approx(ground.area, rel=1e-6)
    assert shapely.symmetric_difference(shapely.union_all(lanes), ground).area == pytest.approx(0, abs=0.1)
    assert all(len(cell.lanes) % 2 == 0 for cell in lane_cells(ground, 0.0, 10.0))


def test_a_notch_cuts_the_ground_into_cells_and_a_hole_into_one_on_either_side() -> None:
    assert len(lane_cells(COMB, 0.0, 10.0)) == 3
    assert len(lane_cells(HOLED, 0.0, 10.0)) == 4
    assert len(lane_cells(FIELD, 0.0, 10.0)) == 1


@pytest.mark.parametrize("ground", [FIELD, HOLED, KITE, COMB])
@pytest.mark.parametrize("budget_m", [90.0, 200.0, 1500.0])
def test_loops_over_all_columns_see_all_of_the_ground(ground: MultiPolygon, budget_m: float) -> None:
    settings = replace(SETTINGS, budget_m=budget_m)
    rings = [
        ring_over(column, FIVE)
        for cell in lane_cells(ground, 0.0, settings.width_m)
        for row in best_rows(cell, settings)
        for column in columns_of(cell, row, settings)
    ]
    missed = shapely.difference(ground, shapely.union_all([seen(ring) for ring in rings]))
    assert missed.area == pytest.approx(0, abs=0.02)


@pytest.mark.parametrize("lanes", [2, 4, 6])
def test_a_loop_over_a_rectangle_is_as_long_as_reckoned(lanes: int) -> None:
    # by hand: lanes of 100 m, of which the inner ones begin 5 m later; ways of 10 m between two and back to the first
    (cell,) = lane_cells(MultiPolygon([box(0, 0, 100, 10 * lanes)]), 0.0, 10.0)
    row = Row(first=0, last=lanes, columns=1, robots=1)
    (column,) = columns_of(cell, row, SETTINGS)
    by_hand_m = 100 * lanes - 5 * (lanes - 2) + 10 * (lanes - 1) + 10 * (lanes - 1)
    assert LinearRing(ring_over(column, FIVE)).length == pytest.approx(by_hand_m)
    assert 100 * lanes + SETTINGS.ends_m(lanes) == pytest.approx(by_hand_m)


def test_lanes_of_a_square_sensor_stop_before_the_border() -> None:
    swath = Swath(sensor=SquareSensor(side_m=10), angle_rad=0.0)
    (cell,) = lane_cells(MultiPolygon([box(0, 0, 100, 20)]), 0.0, 10.0)
    (column,) = columns_of(cell, Row(first=0, last=2, columns=1, robots=1), SETTINGS)
    assert shapely.bounds(LinearRing(ring_over(column, swath))) == pytest.approx([5, 5, 95, 15])


def cell_of(lanes: int, length_m: float) -> LaneCell:
    """A rectangle of so many lanes of 10 m."""
    (cell,) = lane_cells(MultiPolygon([box(0, 0, length_m, 10 * lanes)]), 0.0, 10.0)
    assert len(cell.lanes) == lanes
    return cell


@pytest.mark.parametrize(("length_m", "budget_m"), [(70.0, 200.0), (313.0, 171.0), (140.0, 800.0)])
def test_no_other_division_of_the_lanes_takes_fewer_robots(length_m: float, budget_m: float) -> None:
    settings = replace(SETTINGS, budget_m=budget_m)
    pairs = 6

    def robots(rows: tuple[int, ...]) -> int:
        lengths = [columns_for(2 * n * length_m, 2 * n, settings)[1] for n in rows]
        return sum(math.ceil(row_m / budget_m - 1e-9) for row_m in lengths)

    every = [rows for k in range(1, pairs + 1) for rows in itertools.product(range(1, pairs + 1), repeat=k)]
    fewest = min(robots(rows) for rows in every if sum(rows) == pairs)
    rows = best_rows(cell_of(2 * pairs, length_m), settings)
    assert sum(row.robots for row in rows) == fewest
    assert [row.first for row in rows[1:]] == [row.last for row in rows[:-1]]
    assert max(row.last - row.first for row in rows) <= MOST_LANES


def test_columns_have_few_robots_each_in_proportion_to_their_loops() -> None:
    cell = cell_of(4, 2000.0)
    (row,) = best_rows(cell, SETTINGS)
    columns = list(columns_of(cell, row, SETTINGS))
    assert sum(column.robots for column in columns) == row.robots
    assert max(column.robots for column in columns) <= SETTINGS.sharing
    loads = [LinearRing(ring_over(column, FIVE)).length / (column.robots * 200.0) for column in columns]
    assert max(loads) <= 1
    assert max(loads) - min(loads) < 1e-6
