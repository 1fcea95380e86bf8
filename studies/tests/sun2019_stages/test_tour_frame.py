"""The frame: closed paths past all sensors, which keep to the free space and change the sub-region seldom."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import shapely
from benchmarks.missions import EXAMPLES
from numpy.typing import NDArray
from shapely import LineString, MultiPolygon, box

from rota.errors import MissionError, NoPlanFound
from rota.files.mission_file import read_mission
from rota.geometry.free_space import standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota_studies.sun2019_stages.algorithms import FrameTour
from rota_studies.sun2019_stages.frame import Frame
from rota_studies.sun2019_stages.tour import canonical_order, find_frame

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
OPEN = ShortestPaths(MultiPolygon([box(-100, -100, 100, 100)]))


def over_figure_13() -> tuple[Floats, Ints, ShortestPaths]:
    """A hexagonal lattice of sensors 12 m apart over the free space of Figure 13, zones 1 and 2 and the rest."""
    mission = read_mission(EXAMPLES / "sun2019-fig13.yaml").mission
    space = standing_space(mission, 0.0)
    rows = np.arange(5, 120, 6 * 3**0.5)
    lattice = np.array([(5 + 6.0 * (j % 2) + 12 * i, y) for j, y in enumerate(rows) for i in range(10)])
    inside = lattice[shapely.contains_xy(space, lattice)]
    zone = np.full(len(inside), 2)
    for k, one in enumerate(mission.zones):
        zone[shapely.contains_xy(one.shape, inside)] = k
    return inside, zone, ShortestPaths(space)


def whole(frame: Frame, positions_m: Floats) -> None:
    """What holds for every frame."""
    n = len(positions_m)
    assert sorted(frame.order.tolist()) == list(range(n))
    assert frame.path_m[0].tolist() == frame.path_m[-1].tolist()
    assert frame.path_m[frame.leg_start[:-1]].tolist() == positions_m[frame.order].tolist()
    assert frame.leg_start.shape == (n + 1,)
    assert frame.leg_start[-1] == len(frame.path_m) - 1
    assert frame.length_m == pytest.approx(LineString(frame.path_m).length)
    for k, leg_m in enumerate(frame.legs_m):
        leg = frame.path_m[frame.leg_start[k] : frame.leg_start[k + 1] + 1]
        assert np.hypot(*np.diff(leg, axis=0).T).sum() == pytest.approx(leg_m)


def test_sensors_on_a_ring() -> None:
    angles = np.random.default_rng(1).permutation(24) * 2 * np.pi / 24
    places = 30 * np.column_stack([np.cos(angles), np.sin(angles)])
    frame = find_frame(places, np.zeros(24, np.int64), OPEN, virtual_radius_m=10, seed=0)
    whole(frame, places)
    assert frame.length_m == pytest.approx(2 * 30 * 24 * math.sin(math.pi / 24))
    assert frame.tour_length == pytest.approx(frame.length_m)
    assert (frame.zone_crossings, frame.blocked_legs) == (0, 0)
    assert frame.history[-1] == pytest.approx(frame.tour_length)


def test_a_lattice_with_an_even_side() -> None:
    places = np.array(list(itertools.product(range(8), range(7)))) * 12.0
    frame = find_frame(places, np.zeros(56, np.int64), OPEN, virtual_radius_m=10, seed=3)
    whole(frame, places)
    assert frame.length_m == pytest.approx(56 * 12)


def test_figure_8_equation_14_crosses_less_often_than_straight_distances() -> None:
    places, zone, paths = over_figure_13()
    frames = {
        distance: find_frame(places, zone, paths, virtual_radius_m=10, algorithm=FrameTour(distance=distance), seed=0)
        for distance in ("graph", "euclidean")
    }
    for frame in frames.values():
        whole(frame, places)
        assert np.hypot(*np.diff(places[np.append(frame.order, frame.order[0])], axis=0).T).min() > 11.9
    # into each of the two zones once, and out of it: fewer there cannot be, as they have no common border
    assert frames["graph"].zone_crossings == 4
    assert frames["graph"].tour_length == pytest.approx(frames["graph"].length_m + 4 * 10_000)
    assert frames["euclidean"].zone_crossings > 8
    assert frames["euclidean"].tour_length == pytest.approx(frames["euclidean"].length_m)
    # no tour past n places that are 12 m apart is shorter
    assert frames["euclidean"].length_m == pytest.approx(12 * len(places))


def test_the_path_keeps_out_of_obstacles_and_straight_legs_do_not() -> None:
    # two columns of sensors at either side of a wall with a gap at the top, 10 m between neighbours
    space = MultiPolygon([box(0, 0, 60, 60).difference(box(29, 0, 31, 45))])
    places = np.array([(x, y) for x in (25.0, 35.0) for y in range(5, 60, 10)])
    paths = ShortestPaths(space)
    zone = np.zeros(len(places), np.int64)
    frame = find_frame(places, zone, paths, virtual_radius_m=10, seed=0)
    whole(frame, places)
    assert frame.blocked_legs == 0
    assert LineString(frame.path_m).within(space.buffer(1e-9))
    straight = find_frame(places, zone, paths, virtual_radius_m=10, algorithm=FrameTour(distance="euclidean"), seed=0)
    whole(straight, places)
    assert straight.length_m == pytest.approx(120)
    assert straight.blocked_legs == 1  # at the bottom
    # up one side and down the other, and back again past sensors already visited, over the wall's very end
    assert frame.length_m == pytest.approx(2 * 50 + 2 * 40 + 2 * 10)


def test_places_that_see_no_other_in_range_are_joined_round_obstacles() -> None:
    space = MultiPolygon([box(0, 0, 100, 100).difference(box(20, 20, 80, 80))])
    places = np.array([(10.0, 10.0), (90, 10), (90, 90), (10, 90)])
    frame = find_frame(places, np.array([0, 1, 1, 0]), ShortestPaths(space), virtual_radius_m=5, seed=0)
    whole(frame, places)
    assert frame.length_m == pytest.approx(4 * 80)
    assert frame.zone_crossings == 2
    places = np.array([(15.0, 50.0), (85, 50)])
    frame = find_frame(places, np.zeros(2, np.int64), ShortestPaths(space), virtual_radius_m=5, seed=0)
    whole(frame, places)
    assert frame.length_m == pytest.approx(2 * (2 * math.hypot(5, 30) + 60))
    assert len(frame.path_m) == 7  # two corners on either leg


def test_a_passage_through_another_sub_region_is_counted() -> None:
    # the middle one lies on the way of both legs between the outer ones and is another sub-region
    places = np.array([(0.0, 0.0), (18, 0), (36, 0), (54, 0)])
    frame = find_frame(places, np.array([0, 1, 0, 0]), OPEN, virtual_radius_m=10, seed=0)
    assert frame.length_m == pytest.approx(2 * 54)
    assert frame.zone_crossings == 4
    assert frame.tour_length == pytest.approx(2 * 54 + 40_000)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_hardly_any_sensors(n: int) -> None:
    places = np.array([(0.0, 0.0), (3, 4), (3, 0)])[:n]
    frame = find_frame(places, np.zeros(n, np.int64), OPEN, virtual_radius_m=10, seed=0)
    whole(frame, places)
    assert frame.length_m == pytest.approx([0, 10, 12][n - 1])


def test_a_frame_is_told_from_where_it_enters_the_first_sub_region() -> None:
    zone = np.array([2, 0, 1, 0, 2, 1])
    order = np.array([4, 5, 2, 0, 3, 1])
    # zone 0 is sensors 3, 1: entered from 0 into 3, or the other way round from 4 into 1
    assert canonical_order(order, zone).tolist() == [4, 1, 3, 0, 2, 5]
    for turned in (np.roll(order, 2), order[::-1], np.roll(order[::-1], 3)):
        assert canonical_order(turned, zone).tolist() == [4, 1, 3, 0, 2, 5]
    assert canonical_order(order, np.zeros(6, np.int64)).tolist() == [0, 2, 5, 4, 1, 3]


def test_the_seed_decides() -> None:
    places = np.random.default_rng(0).uniform(-90, 90, (80, 2))
    zone = (places[:, 0] > 0).astype(np.int64)
    one, again = (find_frame(places, zone, OPEN, virtual_radius_m=20, seed=4) for _ in range(2))
    assert one.order.tolist() == again.order.tolist()
    assert one.path_m.tolist() == again.path_m.tolist()
    assert one.history.tolist() == again.history.tolist()


def test_what_cannot_be_used_is_refused() -> None:
    with pytest.raises(ValueError, match="no sensors"):
        find_frame(np.zeros((0, 2)), np.zeros(0, np.int64), OPEN, virtual_radius_m=10, seed=0)
    with pytest.raises(ValueError, match="virtual_radius_m: 0"):
        find_frame(np.zeros((1, 2)), np.zeros(1, np.int64), OPEN, virtual_radius_m=0, seed=0)
    apart = ShortestPaths(MultiPolygon([box(0, 0, 10, 10), box(20, 0, 25, 10)]))
    with pytest.raises(NoPlanFound, match="two parts"):
        find_frame(np.array([(3.0, 3.0), (21, 3)]), np.zeros(2, np.int64), apart, virtual_radius_m=10, seed=0)
    with pytest.raises(MissionError, match="neighbour_range"):
        FrameTour(neighbour_range=1.5)
