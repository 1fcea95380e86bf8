"""What nobody can see, against closed forms and against sight from many standing places."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon, box
from tests.seeds import seeds

from rota.check.pieces import convex_pieces, point_pieces
from rota.check.revisits import worst_gaps_s
from rota.check.seeable import seeable, seeable_ground
from rota.check.standing import standing, standing_areas
from rota.geometry.free_space import sight_walls
from rota.geometry.line_of_sight import visibility_polygon
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Sensor, SquareSensor
from rota.model.plan import Plan, Trajectory


def mission(area: Polygon, *obstacles: Obstacle, body: float = 0.0, sensor: Sensor | None = None) -> Mission:
    fleet = Fleet(speed_m_s=1.0, sensor=sensor or DiscSensor(radius_m=5.0), body_radius_m=body)
    return Mission(name="m", area=MultiPolygon([area]), obstacles=obstacles, fleet=fleet, period_s=1.0)


def obstacle(shape: Polygon, blocks: str = "both") -> Obstacle:
    return Obstacle(shape=shape, blocks=blocks)


def seen(m: Mission, *points: tuple[float, float]) -> list[bool]:
    return seeable(m, standing_areas(m), np.array(points, dtype=float)).tolist()


def any_seen(m: Mission, piece: Polygon) -> bool:
    """Whether any of a convex piece is seen."""
    return bool(seeable_ground(m).sees(convex_pieces(piece, 100.0, 1e-9)).any())


def test_standing_ground_of_a_body_in_a_square_with_a_block() -> None:
    m = mission(box(0, 0, 10, 10), obstacle(box(4, 4, 6, 6)), body=1.0)
    ground = standing(m.area, m.obstacles, 1.0)
    expected = 8 * 8 - (2 * 2 + 4 * 2 * 1 + math.pi)
    assert ground.area == pytest.approx(expected, abs=2e-3)
    assert ground.area >= expected  # never too small
    corridors = [mission(box(0, 0, 10, wide)).area for wide in (1.9, 2.0)]
    assert standing(corridors[0], (), 1.0).is_empty
    assert standing(corridors[1], (), 1.0).area == pytest.approx(8 * 2e-6, rel=0.1)  # a corridor just wide


def test_reach_into_ground_that_nobody_enters() -> None:
    m = mission(box(0, 0, 30, 30), obstacle(box(10, 10, 20, 20), "motion"), sensor=DiscSensor(radius_m=3.0))
    assert seen(m, (12.9, 15), (13.1, 15), (15, 15), (10.5, 10.5), (5, 5)) == [True, False, False, True, True]
    m = mission(box(0, 0, 30, 30), obstacle(box(10, 10, 20, 20), "motion"), sensor=SquareSensor(side_m=6.0))
    assert seen(m, (12.9, 15), (13.1, 13.1)) == [True, False]
    assert not any_seen(m, box(13.7, 13.7, 16.3, 16.3))
    assert any_seen(m, box(12.9, 14, 17.1, 16))


def test_room_behind_a_door_too_narrow_for_the_body_is_seen_through_it_alone() -> None:
    room = box(4.2, 4.55, 6.8, 5.45)  # too low for the body; its door is 0.4 m wide and 0.2 m deep
    left = box(0, 0, 4, 10)
    solid = box(0, 0, 8, 10).difference(left.union(room).union(box(4, 4.8, 4.2, 5.2)))
    m = mission(
        left.union(room).union(box(4, 4.8, 4.2, 5.2)), obstacle(solid), body=0.5, sensor=DiscSensor(radius_m=20)
    )
    # the steepest line through the door, from (4, 4.8) to (4.2, 5.2), goes on to (4.25, 5.3)
    assert seen(m, (5, 5), (6.7, 5), (4.25, 5.29), (4.25, 4.71)) == [True, True, True, True]
    assert seen(m, (4.25, 5.31), (4.25, 4.69), (4.21, 5.44)) == [False, False, False]
    assert not any_seen(m, Polygon([(4.21, 5.23), (4.25, 5.305), (4.21, 5.4)]))
    assert any_seen(m, Polygon([(4.21, 5.23), (4.25, 5.295), (4.21, 5.4)]))


def test_hedge_is_entered_and_not_looked_through() -> None:
    room = box(0, 0, 10, 10)
    m = mission(room, obstacle(box(4, 0, 6, 10), "sight"), obstacle(box(6, 0, 10, 10), "motion"))
    # from inside of the hedge nobody sees, from its border one does
    assert seen(m, (7, 5), (3, 5)) == [True, True]
    m = mission(room, obstacle(box(4, 0, 6, 10), "sight"), obstacle(box(5.9, 0, 10, 10), "motion"))
    assert seen(m, (7, 5), (3, 5)) == [False, True]


def blocks_by_chance(seed: int, body: float) -> Mission:
    """Blocks on a lattice of 0.25 m, so that many touch along sides or at corners, and what some do not let in."""
    rng = np.random.default_rng(seed)
    places = 0.25 * rng.integers(0, 40, (150, 2))
    sizes = 0.25 * rng.integers(1, 4, (150, 2))
    kinds = rng.choice(["both", "both", "both", "sight", "motion"], 150)
    shapes = shapely.box(*places.T, *(places + sizes).T)
    sensor: Sensor = SquareSensor(side_m=3.0) if rng.random() < 0.5 else DiscSensor(radius_m=1.5)
    blocks = (obstacle(shape, str(kind)) for shape, kind in zip(shapes, kinds, strict=True))
    return mission(box(0, 0, 10, 10), *blocks, body=body, sensor=sensor)


@pytest.mark.parametrize("seed", seeds(8, at_once=3))
def test_matches_sight_from_many_standing_places(seed: int) -> None:
    rng = np.random.default_rng(seed)
    blocks = []
    for _ in range(7):
        x, y = rng.uniform(0, 8, 2)
        w, h = rng.uniform(0.2, 3, 2)
        blocks.append(obstacle(box(x, y, x + w, y + h), str(rng.choice(["both", "sight", "motion"]))))
    square = rng.random() < 0.5
    half = float(rng.uniform(1, 4))
    m = mission(
        box(0, 0, 10, 10),
        *blocks,
        body=0.6,
        sensor=SquareSensor(side_m=2 * half) if square else DiscSensor(radius_m=half),
    )
    hidden = shapely.union_all([b.shape for b in blocks if b.blocks_sight])
    points = rng.uniform(0, 10, (400, 2))
    points = points[~shapely.contains_xy(hidden, *points.T)]
    places = np.stack(np.meshgrid(*2 * [np.arange(0.0, 10.0, 0.06)]), axis=-1).reshape(-1, 2)
    ground = standing(m.area, m.obstacles, 0.6)
    places = places[shapely.contains_xy(ground, *places.T)]
    core = shapely.buffer(hidden, -1e-7)
    shapely.prepare(core)
    found = seeable(m, standing_areas(m), points)
    robust = 0
    for point, known in zip(points[:150], found[:150], strict=True):
        away = np.abs(places - point)
        near = places[(away.max(axis=1) if square else np.hypot(*away.T)) <= half]
        # where a few far apart see the point, the others need not be asked
        sampled = any(sees_any(point, some, core) for some in (near[::64], near))
        assert known or not sampled
        robust += known == sampled
    assert robust >= 0.97 * min(len(points), 150)


def sees_any(point: NDArray[np.float64], places_m: NDArray[np.float64], core: shapely.Geometry) -> bool:
    """Whether the core is not between a point and any of (n, 2) places."""
    lines = shapely.linestrings(np.stack([np.broadcast_to(point, places_m.shape), places_m], axis=1))
    return not shapely.intersects(core, lines).all()


def test_fleet_of_different_robots_sees_what_any_of_them_can() -> None:
    small = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=1.0), body_radius_m=0.1).equal_robot("small")
    big = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=4.0), body_radius_m=1.0).equal_robot("big")
    fleet = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=1.0), robots=(small, big))
    m = Mission(name="m", area=MultiPolygon([box(0, 0, 10, 10).union(box(10, 4, 14, 4.6))]), fleet=fleet, period_s=1.0)
    # the passage takes the small one alone
    assert seen(m, (13.5, 4.3), (0.05, 0.05)) == [True, True]
    only_big = Mission(
        name="m", area=m.area, fleet=Fleet(speed_m_s=1.0, sensor=big.sensor, body_radius_m=1.0), period_s=1.0
    )
    assert seen(only_big, (13.5, 4.3), (12.9, 4.3)) == [False, True]


@pytest.mark.parametrize("seed", seeds(6, at_once=2))
def test_nothing_is_seen_of_a_piece_that_is_hidden_and_next_to_all_hidden_pieces_are_known(seed: int) -> None:
    """Beside places in it: a piece of which none is seen may yet be seen in between, so that most are to agree."""
    m = blocks_by_chance(seed, body=0.3)
    rng = np.random.default_rng(seed)
    hidden = shapely.union_all([block.shape for block in m.obstacles if block.blocks_sight])
    ground = seeable_ground(m)
    for size_m in (0.5, 0.1):
        pieces = convex_pieces(m.area.difference(hidden), size_m, 1e-6)
        counts = np.diff(pieces.offsets)
        inside = [
            rng.dirichlet(np.full(count, 0.5), 30) @ pieces.corners_m[first : first + count]
            for first, count in zip(pieces.offsets, counts, strict=False)
        ]
        places = ground.sees(point_pieces(np.vstack(inside))).reshape(-1, 30).any(axis=1)
        found = ground.sees(pieces)
        assert not (places & ~found).any()
        assert (~found).sum() >= 0.7 * (~places).sum() > 0


def test_a_place_is_asked_for_only_if_it_is_seen_by_the_tolerance_that_plans_are_judged_by() -> None:
    """On top of a wall, 2e-9 m beside its edge: the straight way down to the robots' lane goes through that edge."""
    walls = (box(3, 0.6, 10, 0.8), box(0, 0.6, 3 - 1e-6, 1))  # between them is a slit of 1e-6 m
    m = mission(box(0, 0, 10, 1), *(obstacle(wall, "sight") for wall in walls), obstacle(box(0, 0.6, 10, 1), "motion"))
    place = (3 + 2e-9, 0.8 + 4e-9)
    assert seen(m, place) == [False]
    # who sees it from below sees it from where that line leaves the lane
    along = np.array([[0.0, 0.6], [10.0, 0.6], [0.0, 0.6]])
    drive = Trajectory(robot="robot-1", times_s=np.array([0.0, 10.0, 20.0]), positions_m=along)
    plan = Plan(mission=m, trajectories=(drive,))
    assert worst_gaps_s(plan, np.array([place, (3 - 5e-7, 0.7)])).tolist() == [np.inf, pytest.approx(14.0, abs=1e-3)]


def test_where_bodies_stand_is_the_same_in_tiles(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(3)
    places = rng.uniform(0, 16, (60, 2))
    blocks = shapely.union_all(shapely.box(*places.T, *(places + rng.uniform(0.1, 1.2, (60, 2))).T))
    m = mission(MultiPolygon([box(0, 0, 16, 16)]).difference(blocks), obstacle(blocks), body=0.3)
    whole = standing(m.area, m.obstacles, 0.3)
    monkeypatch.setattr("rota.check.standing.TILE_SIDES", 20)
    tiled = standing(m.area, m.obstacles, 0.3)
    assert shapely.symmetric_difference(whole, tiled).area < 1e-12
    assert shapely.hausdorff_distance(whole.boundary, tiled.boundary) < 1e-9
    assert whole.area > 50


def test_among_very_many_walls_a_place_is_seen_exactly_where_its_view_meets_standing_ground() -> None:
    rng = np.random.default_rng(5)
    low = np.vstack([rng.uniform(0, 12, (60, 2)), rng.uniform(4, 8, (400, 2))])
    blocks = shapely.union_all(shapely.box(*low.T, *(low + rng.uniform(0.05, 0.5, (460, 2))).T))
    m = mission(box(0, 0, 12, 12), obstacle(blocks), body=0.25, sensor=DiscSensor(radius_m=4.0))
    ground = standing(m.area, m.obstacles, 0.25)
    points = rng.uniform(3.8, 8.2, (700, 2))
    points = points[~shapely.intersects_xy(shapely.buffer(blocks, 1e-3), *points.T)]
    walls = sight_walls(m)
    views = [visibility_polygon(point, walls, 4.0).intersection(shapely.Point(point).buffer(4.0)) for point in points]
    common_m2 = np.array([view.intersection(ground).area for view in views])
    clear = (common_m2 == 0) | (common_m2 > 1e-3)  # a hair of a view is up to rounding
    assert 30 < (common_m2[clear] == 0).sum() < clear.sum() - 30
    np.testing.assert_array_equal(np.array(seen(m, *points))[clear], common_m2[clear] > 0)
