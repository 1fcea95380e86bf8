"""Lanes against closed forms: rectangles, footprints, cells, and obstacles that reach into strips."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
import shapely
from shapely import LineString, MultiPolygon, Point, Polygon, affinity, box

from rota.model.mission import DiscSensor, SquareSensor
from rota.planners.patrol.methods.sweeping.boustrophedon import cells, events
from rota.planners.patrol.methods.sweeping.lanes import Swath, lane_ends, lanes_in

DISC = DiscSensor(radius_m=5)


def lengths(lanes: Sequence[np.ndarray]) -> list[float]:
    return [float(np.hypot(*np.diff(lane, axis=0).T).sum()) for lane in lanes]


def seen(lanes: Sequence[np.ndarray], radius_m: float) -> shapely.Geometry:
    return shapely.union_all([(LineString(x) if len(x) > 1 else Point(x[0])).buffer(radius_m, 64) for x in lanes])


@pytest.mark.parametrize("angle_deg", [0, 30, 90, 137])
@pytest.mark.parametrize(
    ("sensor", "high", "count", "inset"),
    [
        (DISC, 30, 3, 0.0),  # lanes 10 m apart: the corners are seen only from beside the border
        (DISC, 24, 3, 3.0),  # 8 m apart: 3-4-5
        (DISC, 6, 1, 4.0),
        (DISC, 30.1, 4, math.sqrt(25 - (30.1 / 8) ** 2)),
    ],
)
def test_a_rectangle_has_as_many_lanes_as_swaths_and_each_ends_where_its_corners_are_seen(
    sensor: DiscSensor, high: float, count: int, inset: float, angle_deg: float
) -> None:
    shape = MultiPolygon([affinity.rotate(box(0, 0, 40, high), angle_deg, origin=(0, 0))])
    lanes = lanes_in(shape, shape, Swath(sensor=sensor, angle_rad=math.radians(angle_deg)))
    assert len(lanes) == count
    assert lengths(lanes) == pytest.approx([40 - 2 * inset] * count, abs=1e-5)
    assert shapely.difference(shape, seen(lanes, 5.0)).area < 0.02  # the buffer's arcs are polygons


def test_a_square_sensor_sweeps_its_side_along_the_axes_and_its_diagonal_across_them() -> None:
    along, across = (Swath(sensor=SquareSensor(side_m=8), angle_rad=angle) for angle in (0.0, math.pi / 4))
    assert 2 * along.half_m == 8
    assert 2 * across.half_m == pytest.approx(8 * math.sqrt(2))
    shape = MultiPolygon([box(0, 0, 40, 24)])
    assert lengths(lanes_in(shape, shape, along)) == pytest.approx([32, 32, 32])
    behind, ahead = across.chords_m(np.array([0.0, 2.0, 4 * math.sqrt(2)]))
    assert ahead == pytest.approx([4 * math.sqrt(2), 4 * math.sqrt(2) - 2, 0.0])
    assert behind == pytest.approx(-ahead)


def test_a_strip_seen_from_one_place_has_a_lane_of_one_place() -> None:
    shape = MultiPolygon([box(0, 0, 6, 6)])
    (lane,) = lanes_in(shape, shape, Swath(sensor=DISC, angle_rad=0.0))
    assert lane == pytest.approx(np.array([[3.0, 3.0]]))
    assert lane_ends(box(0, 0, 6, 6), 3.0, Swath(sensor=DISC, angle_rad=0.0)) == (3.0, 3.0)


def test_a_margin_narrows_the_swath() -> None:
    shape = MultiPolygon([box(0, 0, 40, 30)])
    assert len(lanes_in(shape, shape, Swath(sensor=DISC, angle_rad=0.0, margin_m=0.01))) == 4


@pytest.mark.parametrize("seed", range(8))
def test_lanes_never_cross_obstacles_and_leave_little_unseen(seed: int) -> None:
    random = np.random.default_rng(seed)
    blocks = [affinity.rotate(box(0, 0, *random.uniform(3, 15, 2)), random.uniform(0, 90)).buffer(0) for _ in range(5)]
    blocks = [affinity.translate(block, *random.uniform(0, 60, 2)) for block in blocks]
    free = box(0, 0, 70, 60).difference(shapely.union_all(blocks))
    space = MultiPolygon(sorted(shapely.get_parts(free), key=lambda part: -part.area)[:1])
    lanes = lanes_in(space, space, Swath(sensor=DISC, angle_rad=random.uniform(0, math.pi)))
    for lane in lanes:
        line = LineString(lane) if len(lane) > 1 else Point(lane[0])
        assert space.buffer(1e-7).covers(line)
    assert shapely.difference(space, seen(lanes, 5.0)).area < 0.03 * space.area


def test_a_lane_goes_round_an_obstacle_that_reaches_over_the_middle_of_its_strip() -> None:
    ground = MultiPolygon([box(0, 0, 40, 10).difference(box(15, 3, 25, 10))])
    (lane,) = lanes_in(ground, ground, Swath(sensor=DISC, angle_rad=0.0))
    assert lane == pytest.approx(np.array([[0, 5], [15, 5], [15, 3], [25, 3], [25, 5], [40, 5]]))


def test_rounding_at_a_turned_obstacle_does_not_part_a_lane() -> None:
    block = box(20, 75, 50, 100)
    ground = MultiPolygon([box(0, 0, 64.5, 110).difference(block)])
    lanes = lanes_in(ground, ground, Swath(sensor=DISC, angle_rad=math.pi / 2, margin_m=0.025))
    assert len(lanes) == 9  # seven strips, of which the obstacle's inside cuts two
    (beside,) = [lane for lane in lanes if abs(lane[0, 0] - 23.04) < 0.01]
    assert beside[:, 0] == pytest.approx([23.04, 23.04, 20, 20, 23.04, 23.04], abs=0.01)
    assert beside[1:5, 1] == pytest.approx([75, 75, 100, 100])


def test_an_obstacle_across_the_whole_strip_parts_the_lane() -> None:
    ground = MultiPolygon([box(0, 0, 15, 10), box(25, 0, 40, 10)])
    lanes = lanes_in(ground, ground, Swath(sensor=DISC, angle_rad=0.0))
    assert lengths(lanes) == pytest.approx([15, 15])


def test_ground_where_no_robot_can_be_has_no_lanes() -> None:
    far = MultiPolygon([box(100, 100, 110, 110)])
    assert lanes_in(MultiPolygon([box(0, 0, 10, 10)]), far, Swath(sensor=DISC, angle_rad=0.0)) == ()


def test_a_block_in_a_square_makes_four_cells() -> None:
    shape = box(0, 0, 30, 30).difference(box(10, 12, 20, 18))
    found = sorted(cell.bounds for cell in cells(shape))
    assert found == [(0, 0, 30, 12), (0, 12, 10, 18), (0, 18, 30, 30), (20, 12, 30, 18)]
    assert events(shape) == pytest.approx([12, 18])


def test_arms_of_a_u_are_cells_of_their_own_and_an_l_is_one() -> None:
    u = box(0, 0, 30, 30).difference(box(10, 10, 20, 30))
    assert sorted(cell.area for cell in cells(u)) == pytest.approx([200, 200, 300])
    ell = box(0, 0, 30, 30).difference(box(10, 10, 30, 30))
    assert [cell.area for cell in cells(ell)] == pytest.approx([ell.area])
    flipped = affinity.scale(u, 1, -1)
    assert sorted(cell.area for cell in cells(flipped)) == pytest.approx([200, 200, 300])


@pytest.mark.parametrize("seed", range(6))
def test_every_line_meets_a_cell_in_one_stretch_and_cells_tile_the_shape(seed: int) -> None:
    random = np.random.default_rng(seed)
    angles = np.sort(random.uniform(0, 2 * math.pi, 9))
    far = random.uniform(12, 30, 9)
    shape = Polygon(np.column_stack([far * np.cos(angles), far * np.sin(angles)])).buffer(0)
    shape = max(shapely.get_parts(shape.difference(box(-4, -3, 3, 5))), key=lambda part: part.area)
    found = cells(shape)
    assert sum(cell.area for cell in found) == pytest.approx(shape.area, rel=1e-6)
    assert shapely.union_all(found, grid_size=1e-6).area == pytest.approx(shape.area, rel=1e-5)
    for cell in found:
        _, low, _, high = cell.bounds
        for y in random.uniform(low, high, 10):
            cut = cell.intersection(LineString([(-50, y), (50, y)]))
            assert len([part for part in shapely.get_parts(cut) if part.length > 1e-4]) <= 1
