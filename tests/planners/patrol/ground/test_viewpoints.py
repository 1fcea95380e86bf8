"""Places to look from: greedy cover against the best one, and single places against shapely."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely import LineString, MultiPolygon, Point, box

from rota.geometry.free_space import border_segments
from rota.model.mission import DiscSensor, Fleet, Robot, SquareSensor
from rota.planners.patrol.ground import viewpoints
from rota.planners.patrol.ground.samples import points_of, prepare
from rota.planners.patrol.ground.sight import sensor_arguments
from rota.planners.patrol.ground.viewpoints import (
    candidate_places,
    choose_viewpoints,
    place_that_sees,
    search_unseen,
    what_places_see,
)

Floats = NDArray[np.float64]
DISC = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=3)).equal_robot("r")
SQUARE = Fleet(speed_m_s=1, sensor=SquareSensor(side_m=6)).equal_robot("r")
NO_WALLS = np.zeros((0, 4))


def lists(sets: list[set[int]]) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    start = np.cumsum([0, *(len(s) for s in sets)]).astype(np.int64)
    return start, np.array([i for s in sets for i in sorted(s)], dtype=np.int32)


def test_greedy_cover_covers_all_that_any_place_sees() -> None:
    rng = np.random.default_rng(1)
    for _ in range(60):
        samples, places = int(rng.integers(1, 40)), int(rng.integers(1, 15))
        sets = [set(np.flatnonzero(rng.random(samples) < 0.2).tolist()) for _ in range(places)]
        wanted = rng.random(samples) < 0.8
        weight = rng.uniform(0.1, 2, samples)
        weight[rng.random(samples) < 0.1] = 0  # what weighs nothing is wanted all the same
        chosen, hidden = choose_viewpoints(*lists(sets), wanted, weight)
        coverable = set().union(*sets) & set(np.flatnonzero(wanted).tolist())
        assert coverable <= set().union(*(sets[i] for i in chosen))
        assert set(np.flatnonzero(hidden).tolist()) == set(np.flatnonzero(wanted).tolist()) - coverable
        # each was chosen for the greatest weight of samples that were still missing
        missing = set(coverable)
        for i in chosen:
            gains = [sum(max(weight[s], 1e-6) for s in seen & missing) for seen in sets]
            assert gains[i] == pytest.approx(max(gains), abs=1e-9)
            assert gains[i] > 0
            missing -= sets[i]


def test_greedy_cover_is_no_worse_than_its_theorem() -> None:
    # Chvatal 1979: at most H(largest set) times the fewest
    rng = np.random.default_rng(2)
    for _ in range(30):
        sets = [set(np.flatnonzero(rng.random(12) < 0.4).tolist()) for _ in range(9)]
        union = set().union(*sets)
        wanted = np.isin(np.arange(12), list(union))
        chosen, _ = choose_viewpoints(*lists(sets), wanted, np.ones(12))
        fewest = next(k for k in range(10) if any(set().union(*c) == union for c in itertools.combinations(sets, k)))
        assert fewest <= len(chosen) <= fewest * sum(1 / i for i in range(1, max(map(len, sets)) + 1))


def test_nothing_wanted_needs_no_place() -> None:
    chosen, hidden = choose_viewpoints(*lists([{0, 1}, {1}]), np.zeros(2, dtype=bool), np.ones(2))
    assert len(chosen) == 0
    assert not hidden.any()


def test_sensors_as_the_kernels_take_them() -> None:
    assert sensor_arguments(DISC, 0.1) == (pytest.approx(2.9), 0)
    assert sensor_arguments(SQUARE, 0.1) == (pytest.approx(2.9), 1)


@pytest.mark.parametrize("robot", [DISC, SQUARE])
def test_what_places_see_in_the_open(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(3)
    points = points_of(rng.uniform(0, 20, (300, 2)), 1.0, 0, 0)
    _, samples, order = prepare(points, NO_WALLS, reach_m=robot.sensor.reach_m, weight=np.ones(300), wall_margin_m=0)
    places = rng.uniform(0, 20, (40, 2))
    start, items = what_places_see(places, robot, 0.1, samples)
    away = np.abs(points.xy_m[order][None] - places[:, None])
    near = away.max(axis=2) <= 2.9 if robot is SQUARE else np.hypot(*away.transpose(2, 0, 1)) <= 2.9
    for i in range(len(places)):
        assert set(items[start[i] : start[i + 1]].tolist()) == set(np.flatnonzero(near[i]).tolist())
    monkeypatch.setattr(viewpoints, "TOGETHER", 7)
    in_threads = what_places_see(places, robot, 0.1, samples)
    assert (in_threads[0].tolist(), in_threads[1].tolist()) == (start.tolist(), items.tolist())


def test_candidates_lie_in_the_space_and_leave_no_gap() -> None:
    space = MultiPolygon([box(0, 0, 20, 10).difference(box(8, 3, 12, 7)), box(30, 0, 30.3, 0.3)])
    places = candidate_places(space, 1.5)
    assert shapely.intersects_xy(space.buffer(1e-9), places).all()
    # each part has some, even one smaller than the lattice, and nobody in the space is far from one
    rng = np.random.default_rng(4)
    anywhere = rng.uniform((0, 0), (31, 10), (4000, 2))
    anywhere = anywhere[shapely.contains_xy(space, anywhere)]
    away = np.hypot(*(anywhere[:, None] - places[None]).transpose(2, 0, 1)).min(axis=1)
    assert away.max() <= 1.5
    assert any(space.geoms[1].covers(Point(place)) for place in places)
    corners = {tuple(xy) for xy in shapely.get_coordinates(space).tolist()}
    assert corners <= {tuple(xy) for xy in places.tolist()}


def test_candidates_lie_farther_apart_in_a_large_space_but_never_too_far() -> None:
    space = MultiPolygon([box(0, 0, 1000, 300)])
    few = len(candidate_places(space, 0.5))
    assert 60_000 <= few < 75_000  # a lattice of 60,000 and the border
    near = candidate_places(space, 0.5, 1.1)
    assert len(near) > 1000 * 300 / 1.1**2


def in_sight(a: Floats, b: Floats, blocks: MultiPolygon) -> bool:
    return not LineString([a, b]).relate_pattern(blocks.buffer(-1e-6), "T********")


@pytest.mark.parametrize("robot", [DISC, SQUARE])
def test_a_place_that_sees_a_point_is_found_wherever_there_is_one(robot: Robot) -> None:
    rng = np.random.default_rng(5)
    blocks = MultiPolygon([box(4, 4, 9, 5), box(11, 2, 12, 9), box(3, 10, 10, 14)])
    walls = border_segments(blocks)
    # robots may only stand in two corridors: much is seen from afar, some not at all
    space = MultiPolygon([box(0, 6, 10.5, 7), box(13, 0, 14, 14)])
    standing = rng.uniform((0, 0), (14, 14), (3000, 2))
    standing = standing[shapely.contains_xy(space, standing)]
    found = 0
    for point in rng.uniform(0, 15, (120, 2)):
        if shapely.intersects_xy(blocks, *point):
            continue
        place = place_that_sees(point, 0.0, space, walls, robot, 0.1)
        away = np.abs(standing - point)
        near = away.max(axis=1) <= 2.85 if robot is SQUARE else np.hypot(*away.T) <= 2.85
        possible = any(in_sight(point, p, blocks.buffer(0.01)) for p in standing[near])
        if possible:
            assert place is not None, point
        if place is not None:
            found += 1
            assert space.buffer(1e-9).covers(Point(place))
            assert in_sight(point, place, blocks)
            reach = np.abs(place - point).max() if robot is SQUARE else math.dist(place, point)
            assert reach <= 2.9 * 1.01  # the view is a polygon round the circle
    assert found > 20


def test_a_place_for_a_visit_is_inside() -> None:
    space = MultiPolygon([box(0, 0, 10, 10)])
    place = place_that_sees(np.array([11.0, 5.0]), 2.0, space, NO_WALLS, DISC, 0.1)
    assert place is not None
    assert math.dist(place, (11, 5)) <= 2
    assert space.covers(Point(place))
    assert place_that_sees(np.array([13.0, 5.0]), 2.0, space, NO_WALLS, DISC, 0.1) is None
    # a point that can be stood on is its own place, however little room there is
    corner = np.array([10.0, 10.0])
    assert place_that_sees(corner, 1e-9, space, NO_WALLS, DISC, 0.1) == pytest.approx(corner, abs=0)


def test_the_search_for_the_unseen_tells_places_and_the_hopeless() -> None:
    points = points_of(np.array([[0.0, 0], [1, 0], [2, 0], [50, 0], [60, 0]]), 1.0, 0, 0)
    asked: list[float] = []

    def find(i: int) -> Floats | None:
        asked.append(float(points.xy_m[i, 0]))
        return None if points.xy_m[i, 0] == 50 else np.asarray(points.xy_m[i] + np.array([0, 1]))

    def sees(place_m: Floats) -> NDArray[np.int64]:
        near = np.flatnonzero(np.abs(points.xy_m[:, 0] - place_m[0]) <= 1)
        return near[near != 4]  # (60, 0) is seen from the rim only: not from the place that was found

    places, hopeless = search_unseen(np.arange(5), find, sees)
    # the first place serves its neighbour too, which is not asked for any more
    assert asked == [0, 2, 50, 60]
    assert places.tolist() == [[0, 1], [2, 1]]
    assert hopeless.tolist() == [3, 4]
    places, hopeless = search_unseen(np.array([], dtype=np.int64), find, sees)
    assert places.shape == (0, 2)
    assert len(hopeless) == 0
