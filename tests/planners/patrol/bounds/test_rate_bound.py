"""The sweep bound with a weight for every period: its lemma by brute force, its sum on published and made-up cases."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, Point, box

from rota.files.mission_file import read_mission
from rota.geometry.free_space import demanded_regions
from rota.model.mission import DiscSensor, Fleet, Robot, SquareSensor
from rota.planners.patrol.bounds.area_bound import area_rate
from rota.planners.patrol.bounds.rate_bound import rim_share, swept_robots
from rota.planners.patrol.bounds.strongest_robot import footprint_m2, sweep_m2_s

EXAMPLES = Path(__file__).parents[4] / "examples"
# Sun et al. 2019: periods of zones 1, 2, 3 (section 5.1, then Table 6, cases 1 to 6): robots proved and the paper's
CASES = {
    (8, 20, 40): (3, 5),
    (12, 10, 40): (3, 5),
    (12, 20, 30): (3, 5),
    (12, 7, 40): (4, 7),
    (12, 10, 20): (4, 8),
    (8, 10, 20): (5, 9),
    (12, 10, 10): (7, 11),
}
DISC = Fleet(speed_m_s=20, sensor=DiscSensor(radius_m=5)).equal_robot("disc")
SQUARE = Fleet(speed_m_s=3, sensor=SquareSensor(side_m=2)).equal_robot("square")


def polygons(shape: shapely.Geometry) -> MultiPolygon:
    return MultiPolygon([p for p in shapely.get_parts(shape) if p.geom_type == "Polygon"])


def rim(robot: Robot, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points on the footprint's border and, for 32 directions, the share of the most it can sweep that each brings."""
    directions = np.pi * np.arange(32) / 32
    if isinstance(robot.sensor, DiscSensor):
        angle = 2 * np.pi * (np.arange(n) + 0.5) / n
        normal = np.column_stack([np.cos(angle), np.sin(angle)])
        points, ds = robot.sensor.radius_m * normal, 2 * np.pi * robot.sensor.radius_m / n
    else:
        half, along = robot.sensor.side_m / 2, (np.arange(n // 4) + 0.5) / (n // 4) * 2 - 1
        sides = [np.column_stack([np.ones_like(along), along]) @ np.array([[c, s], [-s, c]]) for c, s in TURNS]
        points, ds = half * np.vstack(sides), 8 * half / n
        normal = np.repeat([(c, s) for c, s in TURNS], n // 4, axis=0)
    flow = np.abs(normal @ np.vstack([np.cos(directions), np.sin(directions)])) * robot.speed_m_s * ds / 2
    return points, flow.T / sweep_m2_s(robot)


TURNS = ((1, 0), (0, 1), (-1, 0), (0, -1))


def some_set(rng: np.random.Generator, size: float) -> shapely.Geometry:
    """Boxes, discs, triangles and walls about the origin, some with the part about the origin cut out."""
    shapes = []
    for _ in range(int(rng.integers(1, 6))):
        x, y = rng.uniform(-2.2 * size, 2.2 * size, 2)
        kind = rng.integers(4)
        if kind == 0:
            shapes.append(box(x, y, x + rng.uniform(0, 3 * size), y + rng.uniform(0, 3 * size)))
        elif kind == 1:
            shapes.append(Point(x, y).buffer(rng.uniform(0.01, 1.5) * size))
        elif kind == 2:
            shapes.append(shapely.convex_hull(shapely.multipoints(rng.uniform(-3 * size, 3 * size, (3, 2)))))
        else:
            shapes.append(shapely.linestrings(rng.uniform(-3 * size, 3 * size, (2, 2))).buffer(0.05 * size))
    union = shapely.union_all(shapes)
    return union.difference(Point(0, 0).buffer(rng.uniform(0.1, 1) * size)) if rng.random() < 0.3 else union


@pytest.mark.parametrize("robot", [DISC, SQUARE], ids=["disc", "square"])
def test_the_rim_never_counts_for_more_than_the_footprint_outside(robot: Robot) -> None:
    rng = np.random.default_rng(11)
    points, flow = rim(robot, 480)
    assert flow.sum(axis=1).max() == pytest.approx(1, abs=1e-4)
    size = robot.sensor.radius_m if isinstance(robot.sensor, DiscSensor) else robot.sensor.side_m
    footprint = Point(0, 0).buffer(size, quad_segs=256) if robot is DISC else box(-1, -1, 1, 1)
    slack = []
    for _ in range(400):
        ground = some_set(rng, size)
        psi = np.array([rim_share(d / size, robot) for d in shapely.distance(ground, shapely.points(points))])
        outside = 1 - footprint.intersection(ground).area / footprint.area
        slack.append(outside - (flow @ psi).max())
    assert min(slack) > -2e-3  # the rim is a sum over 480 points
    assert 0 < np.sort(slack)[40] < 0.1  # and the test is no formality: the lemma is nearly sharp now and then


def test_rim_share_grows_from_nothing_to_one() -> None:
    for robot, full in ((DISC, 2.0), (SQUARE, math.sqrt(2))):
        values = [rim_share(s, robot) for s in np.linspace(0, full + 0.1, 400)]
        assert values[0] == 0
        assert values[-1] == 1
        assert (np.diff(values) >= -1e-12).all()
        assert np.diff(values).max() < 0.02


def test_no_robot_earns_more_than_one_on_the_map_of_sun() -> None:
    # the weights of the module's text, written down anew, at places all about the borders of the zones
    periods, speed, r = (8.0, 10.0, 20.0), 20.0, 5.0
    zones = (box(70, 70, 100, 105), box(15, 15, 60, 60))
    swept = 2 * r * speed * np.array(periods)
    share = swept / (swept + math.pi * r * r)

    def weights(xy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        at = shapely.points(xy)
        d1 = shapely.distance(zones[0], at)
        d2 = shapely.distance(shapely.union_all(zones), at)
        own = np.where(d1 == 0, 0, np.where(d2 == 0, 1, 2))
        g = share[own].copy()
        for j, d in enumerate((d1, d2)):
            lost = np.array([1 - rim_share(x / r, DISC) for x in d])
            g -= np.where(own > j, (share[j + 1] - share[j]) * lost, 0)
        return g, g / swept[own] * math.pi * r * r

    points, flow = rim(DISC, 240)
    grid = np.stack(np.meshgrid(np.arange(-4.9, 5, 0.2), np.arange(-4.9, 5, 0.2)), axis=-1).reshape(-1, 2)
    grid = grid[np.hypot(*grid.T) < r]
    rng = np.random.default_rng(2)
    earned = []
    for _ in range(150):
        zone = zones[int(rng.integers(2))]
        away = float(rng.uniform(-1, 2)) * r
        line = zone.buffer(away).exterior
        place = np.array(line.interpolate(rng.uniform(0, 1), normalized=True).coords[0])
        g, _ = weights(points + place)
        _, h = weights(grid + place)
        earned.append((flow @ g).max() + h.mean())
    assert max(earned) < 1 + 2e-4
    assert max(earned) > 0.99


def test_the_cases_of_table_6_take_29_robots() -> None:
    regions = demanded_regions(read_mission(EXAMPLES / "sun2019-fig13.yaml").mission)
    shapes = [region.shape for region in regions]
    for periods, (proved, paper) in CASES.items():
        robots, asked = swept_robots(shapes, [0, 0, 0], periods, DISC)
        assert math.ceil(robots - 1e-6) == proved <= paper
        without_borders = sum(s.area / (200 * t + 25 * math.pi) for s, t in zip(shapes, periods, strict=True))
        assert 0.99 * without_borders < robots < without_borders
        assert asked == pytest.approx(sum(s.area / t for s, t in zip(shapes, periods, strict=True)))
        # never worse than the bound with one window for all by more than the borders cost
        assert robots > area_rate([s.area for s in shapes], periods, DISC)[0] - 0.01
    assert sum(proved for proved, _ in CASES.values()) == 29


def test_one_period_is_the_closed_form() -> None:
    shape = polygons(box(0, 0, 100, 50))
    for robot in (DISC, SQUARE):
        expected = 4000 / (sweep_m2_s(robot) * 9 + footprint_m2(robot))
        assert swept_robots([shape], [1000], [9], robot)[0] == pytest.approx(expected)
        # far from each other, grounds of two periods simply add up
        far = polygons(box(1000, 0, 1100, 50))
        other = 5000 / (sweep_m2_s(robot) * 30 + footprint_m2(robot))
        assert swept_robots([shape, far], [1000, 0], [9, 30], robot)[0] == pytest.approx(expected + other)
    assert swept_robots([], [], [], DISC) == (0.0, 0.0)


def test_a_tiny_urgent_place_does_not_lower_the_bound() -> None:
    whole = box(0, 0, 200, 200)
    plain = swept_robots([polygons(whole)], [0], [30], DISC)[0]
    tiny = box(90, 90, 90.1, 90.1)
    with_tiny = swept_robots([polygons(tiny), polygons(whole.difference(tiny))], [0, 0], [1, 30], DISC)[0]
    assert with_tiny >= plain * (1 - 1e-9)


def test_never_above_robots_on_rings_beside_each_other() -> None:
    # k_i robots follow each other on circle i and see a ring of width 2 r every 2 pi R_i / (k_i V): sum k_i are enough
    rng = np.random.default_rng(7)
    r, speed = 5.0, 20.0
    centre = Point(0, 0)
    for _ in range(25):
        shapes, periods, robots = [], [], 0
        inner = float(rng.uniform(0, 30))
        for _ in range(int(rng.integers(2, 5))):
            k = int(rng.integers(1, 7))
            # a polygon within the true ring, so that nothing is asked that is not seen
            outer = centre.buffer((inner + 2 * r) * (1 - 1e-9), quad_segs=64)
            shapes.append(polygons(outer.difference(centre.buffer(inner * 1.001 + 1e-9, quad_segs=64))))
            periods.append(2 * math.pi * (inner + r) / (k * speed))
            robots += k
            inner += 2 * r + float(rng.choice([0.0, 0.0, 3.0]))
        assert swept_robots(shapes, [0] * len(shapes), periods, DISC)[0] <= robots


def test_longer_periods_and_less_ground_never_raise_it() -> None:
    rng = np.random.default_rng(9)
    zones = [box(10, 10, 40, 40), box(60, 20, 90, 70)]
    rest = box(0, 0, 120, 90).difference(shapely.union_all(zones))
    shapes = [polygons(shape) for shape in (*zones, rest)]
    for _ in range(20):
        periods = rng.uniform(3, 60, 3)
        before = swept_robots(shapes, [0, 0, 0], periods, DISC)[0]
        assert swept_robots(shapes, [0, 0, 0], periods * rng.uniform(1, 1.5), DISC)[0] <= before
        assert swept_robots(shapes, [50, 0, 100], periods, DISC)[0] < before
