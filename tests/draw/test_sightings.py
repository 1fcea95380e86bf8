"""What robots see in a film, against closed forms and against straight lines of sight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, Point, box
from tests.live.two_robots import two_robots
from tests.seeds import seeds

from rota.cells.cell_map import cell_map_of
from rota.draw.footprint import cut_footprint, open_footprint, walls_of
from rota.draw.sightings import Sightings, in_range
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, SquareSensor
from rota.model.plan import Plan


def mission_with(*shapes: shapely.Geometry, sensor: DiscSensor | SquareSensor, blocks: str = "both") -> Mission:
    obstacles = tuple(Obstacle(shape=shape, blocks=blocks) for shape in shapes)
    fleet = Fleet(speed_m_s=1, sensor=sensor)
    return Mission(name="m", area=box(-50, -50, 50, 50), obstacles=obstacles, period_s=40, fleet=fleet)


def test_shadow_of_a_block_in_a_square_footprint():
    sensor = SquareSensor(side_m=20)
    walls = walls_of(mission_with(box(2, -1, 3, 1), sensor=sensor))
    # the shadow widens from 2 m at x = 2 to 10 m at x = 10: (2 + 10) / 2 * 8
    assert cut_footprint(walls, sensor, np.zeros(2)).area == pytest.approx(400 - 48)


def test_a_long_wall_hides_the_segment_behind_it():
    sensor = DiscSensor(radius_m=10)
    walls = walls_of(mission_with(box(-50, 5, 50, 6), sensor=sensor))
    seen = cut_footprint(walls, sensor, np.zeros(2))
    disc = open_footprint(sensor, np.zeros(2))
    assert seen.area == pytest.approx(disc.intersection(box(-50, -50, 50, 5)).area)


def test_where_nothing_cuts_sight_the_footprint_is_whole():
    sensor = DiscSensor(radius_m=10)
    for blocks, block in (("motion", box(2, -1, 3, 1)), ("both", box(20, 20, 30, 30))):
        assert cut_footprint(walls_of(mission_with(block, sensor=sensor, blocks=blocks)), sensor, np.zeros(2)) is None
    assert open_footprint(sensor, np.zeros(2)).area == pytest.approx(32 * 100 * np.sin(np.pi / 32))


def test_inside_a_hedge_nothing_is_seen():
    sensor = DiscSensor(radius_m=3)
    walls = walls_of(mission_with(box(-20, -20, 20, 20), sensor=sensor, blocks="sight"))
    for place in ((0.0, 0.0), (19.0, 0.0)):
        assert cut_footprint(walls, sensor, np.array(place)).area == pytest.approx(0, abs=1e-12)


def test_a_robot_close_to_a_wall_sees_half_a_disc():
    sensor = DiscSensor(radius_m=10)
    walls = walls_of(mission_with(box(-50, -5, 50, 0), sensor=sensor))
    whole = open_footprint(sensor, np.zeros(2)).area
    for height_m in (0.0, 1e-10, 1e-6, 1e-3):
        seen = cut_footprint(walls, sensor, np.array([0.3, height_m]))
        assert seen.area == pytest.approx(whole / 2 + 20 * height_m, rel=1e-6)


@pytest.mark.parametrize("seed", seeds(12, at_once=4))
def test_footprints_agree_with_straight_lines_of_sight(seed: int):
    rng = np.random.default_rng(seed)
    sensor = DiscSensor(radius_m=15) if seed % 2 else SquareSensor(side_m=24)
    shapes = [Point(*rng.uniform(-14, 14, 2)).buffer(rng.uniform(0.5, 3), quad_segs=2) for _ in range(7)]
    ring = shapely.difference(box(-13, -13, -4, -4), box(-12, -12, -5, -4))
    mission = mission_with(*shapes, MultiPolygon([ring]), sensor=sensor)
    solid = shapely.union_all([*shapes, ring])
    places = [p for p in rng.uniform(-10, 10, (30, 2)) if solid.distance(Point(p)) > 0.01]
    walls = walls_of(mission)
    wrong = tried = 0
    for place in places:
        points = place + rng.uniform(-12, 12, (400, 2))
        lines = shapely.linestrings(np.stack([np.broadcast_to(place, points.shape), points], axis=1))
        clear = ~shapely.intersects(solid, lines) & shapely.contains_xy(open_footprint(sensor, place), points)
        cut = cut_footprint(walls, sensor, place)
        seen = shapely.contains_xy(open_footprint(sensor, place) if cut is None else cut, points)
        # within a hair of a shadow's edge both answers are right
        near_edge = shapely.distance(shapely.points(points), (cut or Point(place)).boundary) < 1e-9
        wrong += ((seen != clear) & ~near_edge).sum()
        tried += len(points)
    assert tried > 5000
    assert wrong == 0


@pytest.mark.parametrize("sensor", [DiscSensor(radius_m=3), SquareSensor(side_m=5)])
def test_range_along_a_leg_is_the_union_of_footprints(sensor: DiscSensor | SquareSensor):
    rng = np.random.default_rng(7)
    for leg in (rng.uniform(-6, 6, (2, 2)), np.array([(-4.0, 1), (4, 1)]), np.array([(1.0, 1), (1, 1)])):
        points = rng.uniform(-10, 10, (1000, 2))
        places = leg[0] + np.linspace(0, 1, 1501)[:, None] * (leg[1] - leg[0])
        away = np.abs(points[:, None] - places[None])
        if isinstance(sensor, DiscSensor):
            least = np.hypot(away[..., 0], away[..., 1]).min(axis=1) - sensor.radius_m
        else:
            least = away.max(axis=2).min(axis=1) - sensor.side_m / 2
        clear = np.abs(least) > 1e-2
        np.testing.assert_array_equal(in_range(sensor, leg, *points.T)[clear], least[clear] < 0)


def test_last_seen_on_a_strip(strip: Plan):
    sightings = Sightings(strip, cell_map_of(strip.mission, cells=500))
    before_s = 0.0
    for time_s in np.arange(0, 120.5, 0.5):
        sightings.advance(before_s, float(time_s))
        before_s = float(time_s)
    x = sightings.cell_map.x_m
    # at 120 s the robot is at x = 50 on its way back: behind it a point was left when the robot was 5 m farther left
    left_s = np.where(x >= 45, np.minimum(120, 175 - x), x - 5)
    left_s[(x < 5) | (x > 95)] = -np.inf
    step_s = 5 * np.sqrt(2) / 4
    seen = np.isfinite(left_s)
    np.testing.assert_array_equal(np.isfinite(sightings.last_seen_s), np.tile(seen, (5, 1)))
    assert np.abs(sightings.last_seen_s[:, seen] - left_s[seen]).max() <= step_s
    age = sightings.age_in_periods(120.0)
    assert age[2, 50] == 0
    assert np.isinf(age[2, 0])


def test_ground_behind_a_wall_stays_unseen(strip: Plan):
    tall = replace(strip.mission, area=box(0, 0, 100, 8), obstacles=(Obstacle(shape=box(0, 5, 100, 5.5)),))
    sightings = Sightings(replace(strip, mission=tall), cell_map_of(tall, cells=800))
    sightings.advance(0, 160)
    seen_rows = np.isfinite(sightings.last_seen_s).any(axis=1)
    np.testing.assert_array_equal(seen_rows, sightings.cell_map.y_m < 5)


def test_the_later_of_two_looks_counts_whatever_the_robots_order(yard: Plan):
    both = [Sightings(replace(yard, trajectories=order), cell_map_of(yard.mission, cells=900)) for order in
            (yard.trajectories, yard.trajectories[::-1])]  # fmt: skip
    for sightings in both:
        sightings.advance(0, 23)
    np.testing.assert_array_equal(both[0].last_seen_s, both[1].last_seen_s)


def test_a_zone_that_names_a_sensor_is_seen_by_who_has_one():
    plan = two_robots(thermal=True)
    sightings = Sightings(plan, cell_map_of(plan.mission, 4_000))
    x_m, y_m = np.meshgrid(sightings.cell_map.x_m, sightings.cell_map.y_m)
    left, below = ((x_m < 1) & rows for rows in ((y_m > 1) & (y_m < 3), y_m < 1))
    # a, which sees no heat, leaves the left end at 0 s; b comes by at 20 s
    sightings.advance(0.0, 10.0)
    assert (sightings.last_seen_s[left] == -np.inf).all()
    assert (sightings.last_seen_s[below] > 0).all()
    sightings.advance(10.0, 30.0)
    assert (np.abs(sightings.last_seen_s[left] - 20.0) < 1.0).all()
