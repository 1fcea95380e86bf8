"""Robots in the cells of a grid: neighbours and walls against brute force."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import LineString, box
from tests.planners.swarm.conftest import in_box

from rota.planners.swarm.kernels import find_neighbours, to_wall
from rota.planners.swarm.state import Near


def found_by(swarm, i: int, most: int, range_m: float) -> tuple[list[int], float]:
    near = Near(np.empty(max(most, 1), np.int64), np.empty(max(most, 1)))
    place = int(np.flatnonzero(swarm._robots.name == i)[0])
    count, nearest2 = find_neighbours(place, most, swarm._robots, swarm.grid, range_m, near)
    return [int(swarm._robots.name[k]) for k in near.robot[:count]], nearest2


@pytest.mark.parametrize("most", [0, 1, 4, 30])
@pytest.mark.parametrize("range_m", [20.0, 51.0])
def test_the_nearest_are_those_of_brute_force(most: int, range_m: float) -> None:
    places = np.random.default_rng(3).uniform(0, 400, (150, 2))
    swarm = in_box(places, (400, 400))
    for _ in range(3):
        here = swarm.places_m
        for i in range(0, 150, 7):
            distance = np.hypot(*(here - here[i]).T)
            order = [int(j) for j in np.argsort(distance, kind="stable") if j != i and distance[j] <= range_m]
            assert found_by(swarm, i, most, range_m)[0] == order[:most]
        swarm.step()


def test_equal_distances_go_by_the_number_in_the_fleet() -> None:
    centre, ring = [[100, 100]], [[110, 100], [100, 110], [90, 100], [100, 90]]
    assert found_by(in_box([*centre, *ring]), 0, 2, 51)[0] == [1, 2]
    assert found_by(in_box([*centre, *ring[::-1]]), 0, 2, 51)[0] == [1, 2]


def test_a_robot_alone_has_no_neighbours() -> None:
    assert found_by(in_box([[10, 10], [200, 200]]), 0, 4, 51) == ([], np.inf)


def test_every_cell_lists_the_walls_near_it() -> None:
    rng = np.random.default_rng(4)
    walls = rng.uniform(0, 400, (40, 4))
    swarm = in_box([[1, 1]], walls=walls, wall_range_m=30.0)
    grid = swarm.grid
    assert grid.columns * grid.rows > 40
    for j in range(grid.rows):
        for i in range(grid.columns):
            c = (j + 1) * (grid.columns + 2) + i + 1
            x, y = grid.x0 + i * grid.cell_m, grid.y0 + j * grid.cell_m
            cell = box(x, y, x + grid.cell_m, y + grid.cell_m)
            near = {w for w, wall in enumerate(walls) if cell.distance(LineString(wall.reshape(2, 2))) <= 30}
            assert near <= set(grid.wall_item[grid.wall_start[c] : grid.wall_start[c + 1]].tolist())


def test_the_way_to_a_wall() -> None:
    wall = np.array([0.0, 0.0, 10.0, 0.0])
    assert to_wall(3.0, 4.0, wall) == (0, -4)
    assert to_wall(-3.0, 4.0, wall) == (3, -4)
    assert to_wall(13.0, -4.0, wall) == (-3, 4)
    assert to_wall(1.0, 1.0, np.array([4.0, 5.0, 4.0, 5.0])) == (3, 4)
