"""The grid of cells and the period asked of each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapely import Polygon, box

from rota.cells.cell_map import cell_map_of, neighbours
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone

FLEET = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1))


def test_smallest_period_rules_and_a_zone_replaces_the_areas_even_by_nothing():
    zones = (
        Zone(name="slow", shape=box(0, 0, 40, 100), period_s=200),
        Zone(name="fast", shape=box(20, 0, 60, 100), period_s=10),
        Zone(name="off", shape=box(50, 0, 80, 100), period_s=None),
        Zone(name="call", shape=box(70, 0, 90, 100), period_s=5, demand="visit"),
    )
    obstacles = (Obstacle(shape=box(0, 0, 100, 10)), Obstacle(shape=box(0, 90, 100, 100), blocks="motion"))
    mission = Mission(name="m", area=box(0, 0, 100, 100), period_s=40, fleet=FLEET, zones=zones, obstacles=obstacles)
    cell_map = cell_map_of(mission, cells=100)
    assert cell_map.cell_m == 10
    np.testing.assert_allclose(cell_map.x_m, np.arange(5, 100, 10))
    across = [200, 200, 10, 10, 10, 10, np.nan, np.nan, np.nan, 40]
    np.testing.assert_array_equal(cell_map.period_s[1:], np.tile(across, (9, 1)))
    # a no-fly strip is looked at, ground under an obstacle is not
    assert cell_map.inside.sum(axis=1).tolist() == [0] + [10] * 9
    assert np.flatnonzero(cell_map.visit[5]).tolist() == [7, 8]
    assert cell_map.extent_m == (0, 100, 0, 100)


def test_an_obstacle_that_asks_nothing_outdoes_the_zones():
    field = Obstacle(shape=box(0, 0, 50, 50), blocks="motion", asks="nothing")
    zone = Zone(name="z", shape=box(0, 0, 100, 20), period_s=10)
    mission = Mission(name="m", area=box(0, 0, 100, 100), period_s=40, fleet=FLEET, zones=(zone,), obstacles=(field,))
    cell_map = cell_map_of(mission, cells=100)
    assert (cell_map.inside.sum(), cell_map.asked.sum()) == (100, 75)
    assert cell_map.period_s[0].tolist()[4:] == pytest.approx([np.nan, *[10] * 5], nan_ok=True)


def test_cells_in_a_wall_show_what_a_neighbour_shows():
    wall = Obstacle(shape=box(40, 0, 50, 100))
    mission = Mission(name="m", area=box(0, 0, 100, 100), period_s=40, fleet=FLEET, obstacles=(wall,))
    shown = neighbours(cell_map_of(mission, cells=100))
    assert shown.shape == (10, 10)
    assert shown[3].tolist() == [30, 31, 32, 33, 35, 35, 36, 37, 38, 39]
    broad = replace(mission, obstacles=(Obstacle(shape=box(20, 0, 80, 100)),))
    # too far from the inside: their own
    assert neighbours(cell_map_of(broad, cells=100))[3].tolist() == [30, 31, 31, 33, 34, 35, 36, 38, 38, 39]


LONG = [(1000, 60, (55, 913)), (100, 100, (224, 224)), (1e5, 1, (1, 1600)), (10, 10.01, (224, 224))]


def test_holes_and_parts_of_the_area_are_left_out():
    ring = Polygon(box(0, 0, 90, 90).exterior, [box(30, 30, 60, 60).exterior])
    cell_map = cell_map_of(Mission(name="m", area=ring, period_s=40, fleet=FLEET), cells=81)
    assert cell_map.inside.sum() == 81 - 9
    assert cell_map.asked.sum() == 72
    assert len(cell_map.points_m(cell_map.asked)) == 72


@pytest.mark.parametrize(("width", "height", "shape"), LONG)
def test_long_areas_get_long_grids(width: float, height: float, shape: tuple[int, int]):
    mission = Mission(name="m", area=box(0, 0, width, height), period_s=40, fleet=FLEET)
    cell_map = cell_map_of(mission, cells=50_000)
    assert cell_map.inside.shape == shape
    left, right, bottom, top = cell_map.extent_m
    assert max(left, bottom) <= 1e-6 * cell_map.cell_m
    assert min(right - width, top - height) >= -1e-6 * cell_map.cell_m
