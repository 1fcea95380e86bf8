"""The gradient of the covered area, against finite differences of the exact area of discs in the ground."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, Point, box
from tests.planners.swarm.conftest import PAPER, in_box
from tests.seeds import seeds

from rota.planners.swarm.arc_kernels import area_gradient, exposed_arcs
from rota.planners.swarm.deciding import deciding_room
from rota.planners.swarm.kernels import find_neighbours
from rota.planners.swarm.own_ground_kernels import own_share
from rota.planners.swarm.planner import ALL_NEIGHBOURS
from rota.planners.swarm.settle_kernels import decide_settle
from rota.planners.swarm.world import walls_of

ALL = PAPER._replace(neighbours=ALL_NEIGHBOURS)
# thin walls, a corner that stands out, a round block
BLOCKS = shapely.union_all([box(30, 20, 31, 60), box(60, 50, 80, 55), Point(75, 20).buffer(6)])
GROUND = MultiPolygon([box(0, 0, 100, 80).difference(BLOCKS)])
MOVED_M = 1e-3


def gradients(places: np.ndarray, sensors: np.ndarray, ground: MultiPolygon) -> np.ndarray:
    """What the kernels say, (n, 2) in the order of the places."""
    swarm = in_box(
        places, walls=walls_of(ground), rule=ALL, decide=decide_settle, sensor_m=sensors, wall_range_m=sensors,
        neighbour_range_m=sensors + sensors.max(),
    )  # fmt: skip
    room, found = deciding_room(ALL), np.empty((len(places), 2))
    robots, kinds = swarm.robots, swarm.kinds
    for i in range(len(places)):
        kind = robots.kind[i]
        near, _ = find_neighbours(i, ALL_NEIGHBOURS, robots, swarm.grid, kinds.neighbour_range_m[kind], room.near)
        arcs = exposed_arcs(i, near, robots, kinds, swarm.grid, room.near, room.outline)
        found[robots.name[i]] = area_gradient(kinds.sensor_m[kind], arcs, room.outline)
    return found


def covered_m2(places: np.ndarray, sensors: np.ndarray, ground: MultiPolygon) -> float:
    discs = shapely.buffer(shapely.points(places), sensors, quad_segs=500)
    return float(shapely.union_all(discs).intersection(ground).area)


@pytest.mark.parametrize("unequal", [False, True])
@pytest.mark.parametrize("seed", seeds(3, at_once=1))
def test_it_is_that_of_the_exact_area(seed: int, unequal: bool) -> None:
    rng = np.random.default_rng(seed)
    places = rng.uniform(0, (100, 80), (60, 2))
    places = places[shapely.intersects_xy(GROUND.buffer(-0.5), *places.T)][:9]
    sensors = rng.uniform(8, 20, len(places)) if unequal else np.full(len(places), 14.0)
    told = gradients(places, sensors, GROUND)
    assert np.abs(told).max() > 5
    for k in range(len(places)):
        for axis in range(2):
            step = np.zeros_like(places)
            step[k, axis] = MOVED_M
            more, less = (covered_m2(places + sign * step, sensors, GROUND) for sign in (1, -1))
            assert told[k, axis] == pytest.approx((more - less) / (2 * MOVED_M), abs=0.01)


def test_two_discs_by_hand() -> None:
    # 30 m apart, R = 25: the hidden half-angle has the cosine 0.6, and 2 R sin of it is the chord, 40 m
    found = gradients(np.array([[100.0, 100.0], [130.0, 100.0]]), np.full(2, 25.0), MultiPolygon([box(0, 0, 250, 250)]))
    assert found == pytest.approx(np.array([[-40.0, 0.0], [40.0, 0.0]]), abs=1e-9)


def test_what_others_hide_has_none_and_of_equal_discs_in_one_place_one_is_on_top() -> None:
    area = MultiPolygon([box(0, 0, 250, 250)])
    inner = gradients(np.array([[100.0, 100.0], [102.0, 101.0]]), np.array([25.0, 8.0]), area)
    assert inner == pytest.approx(np.zeros((2, 2)), abs=1e-9)
    same = gradients(np.array([[100.0, 100.0], [100.0, 100.0], [120.0, 100.0]]), np.full(3, 25.0), area)
    assert same[1] == pytest.approx([0, 0])
    assert same[0, 0] < -10


def test_the_own_share_is_that_of_the_voronoi_cell() -> None:
    rng = np.random.default_rng(5)
    places = rng.uniform(60, 190, (20, 2))
    swarm = in_box(places, rule=ALL, decide=decide_settle, neighbour_range_m=50)
    cells = shapely.get_parts(
        shapely.voronoi_polygons(shapely.multipoints(places), extend_to=box(0, 0, 250, 250), ordered=True)
    )
    room, robots, kinds = deciding_room(ALL), swarm.robots, swarm.kinds
    for i in range(20):
        near, _ = find_neighbours(i, ALL_NEIGHBOURS, robots, swarm.grid, 50.0, room.near)
        share, walled, _ = own_share(i, near, robots, kinds, swarm.grid, room)
        disc = Point(robots.x[i], robots.y[i]).buffer(25, quad_segs=512)
        assert share == pytest.approx(cells[robots.name[i]].intersection(disc).area / disc.area, abs=1e-4)
        assert not walled
