"""What a leg sees, against shapely: range and line of sight at every moment at which either could change."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely import LineString, MultiPolygon, Polygon, box
from shapely.geometry.base import BaseGeometry

from rota.geometry.free_space import border_segments
from rota.planners.patrol.ground.sample_kernels import Leg, Samples, leg_sees
from rota.planners.patrol.ground.samples import SamplePoints, join, lattice_places, points_of, prepare
from rota.planners.patrol.ground.sight_kernels import Line, range_interval

Floats = NDArray[np.float64]
NO_WALLS = np.zeros((0, 4))


@dataclass(frozen=True)
class Scene:
    """Prepared samples, and the points and walls in the same order for the brute force."""

    samples: Samples
    points: SamplePoints
    walls: Floats


def scene(points: SamplePoints, walls: Floats, reach_m: float, wall_margin_m: float = 0.0) -> Scene:
    _, samples, order = prepare(
        points, walls, reach_m=reach_m, weight=np.ones(len(points)), wall_margin_m=wall_margin_m
    )
    return Scene(samples=samples, points=points[order], walls=samples.walls)


def seen(leg: Floats, reach: float, square: int, serves: int, samples: Samples) -> set[int]:
    a, b = leg
    found = items(float(a[0]), float(a[1]), float(b[0]), float(b[1]), reach, square, serves, samples)
    assert len(set(found)) == len(found)  # each once
    return set(found)


def items(
    ax: float, ay: float, bx: float, by: float, reach: float, square: int, serves: int, samples: Samples
) -> list[int]:
    """The samples of the runs that ``leg_sees`` tells; no run is empty or reaches past the last sample."""
    out = np.empty(2 * len(samples.x), dtype=np.int32)
    runs = out[: leg_sees(Leg(ax, ay, bx, by, reach, square), serves, samples, out)].reshape(-1, 2)
    assert (runs[:, 0] < runs[:, 1]).all()
    assert (runs <= len(samples.x)).all()
    return [i for first, end in runs for i in range(first, end)]


def in_range(point: Floats, places: Floats, reach: float, square: bool) -> NDArray[np.bool_]:
    apart = places - point
    return np.abs(apart).max(axis=1) <= reach if square else np.hypot(*apart.T) <= reach


def moments(leg: Floats, point: Floats, walls: Floats) -> Floats:
    """Leg parameters at which the sight line from the point may come to or leave a wall: 0, 1 and those between."""
    a, d = leg[0], leg[1] - leg[0]
    found = [0.0, 1.0]
    if (d != 0).any():
        for wall in walls.reshape(-1, 2, 2):
            along = wall[1] - wall[0]
            rays = [(end - point, point) for end in wall] + [(along, wall[0])]
            for ray, through in rays:
                slope = d[0] * ray[1] - d[1] * ray[0]
                if slope != 0:
                    found.append(((through[0] - a[0]) * ray[1] - (through[1] - a[1]) * ray[0]) / slope)
    return np.unique(np.clip(found, 0, 1))


def brute_force(leg: Floats, reach: float, square: bool, serves: int, s: Scene) -> set[int]:
    """Samples seen from some place of the leg: dense ones, and between every two moments of change."""
    found = set()
    away_m = shapely.distance(LineString(leg), shapely.points(s.points.xy_m))
    for i in range(len(s.points)):
        point, visit = s.points.xy_m[i], s.points.visit_m[i]
        if s.points.period[i] < serves or away_m[i] > 1.5 * max(reach, visit):
            continue
        walls = s.walls if visit == 0 else NO_WALLS
        changes = moments(leg, point, walls)
        t = np.concatenate([np.linspace(0, 1, 201), (changes[1:] + changes[:-1]) / 2])
        places = leg[0] + t[:, None] * (leg[1] - leg[0])
        limit = visit if visit > 0 else reach - s.points.shrink_m[i]
        places = places[in_range(point, places, limit, square and visit == 0)]
        if not len(places):
            continue
        sight = shapely.linestrings(np.stack([np.broadcast_to(point, places.shape), places], axis=1))
        cut = shapely.crosses(sight[:, None], shapely.linestrings(walls.reshape(-1, 2, 2))[None])
        if (~cut.any(axis=1)).any():
            found.add(i)
    return found


def random_points(rng: np.random.Generator, n: int) -> SamplePoints:
    parts = [
        points_of(rng.uniform(0, 30, (n, 2)), 1.0, 0, 0),
        points_of(rng.uniform(0, 30, (n, 2)), 1.0, 1, 1, shrink_m=0.7),
        points_of(rng.uniform(0, 30, (n // 4, 2)), 1.0, 2, 2, visit_m=2.5),
        points_of(rng.uniform(0, 30, (n // 4, 2)), 1.0, 0, 3, visit_m=9.0),  # farther than the sensor sees
    ]
    return join(parts)


def random_walls(rng: np.random.Generator, n: int) -> Floats:
    """Walls (n, 4) of which none cross."""
    walls: list[Floats] = []
    while len(walls) < n:
        start = rng.uniform(0, 30, 2)
        wall = np.concatenate([start, start + rng.normal(0, 4, 2)])
        if not any(LineString(wall.reshape(2, 2)).intersects(LineString(other.reshape(2, 2))) for other in walls):
            walls.append(wall)
    return np.array(walls).reshape(-1, 4)


@pytest.mark.parametrize("square", [False, True])
@pytest.mark.parametrize("walls", [0, 3, 12])
def test_random_legs_among_random_walls(square: bool, walls: int) -> None:
    rng = np.random.default_rng([walls, square])
    reach, disagreements, total = 6.0, 0, 0
    for _ in range(25):
        s = scene(random_points(rng, 40), random_walls(rng, walls), reach * 1.4143)
        for _ in range(5):
            a = rng.uniform(0, 30, 2)
            leg = np.stack([a, a + rng.normal(0, 8, 2) * rng.choice([0.0, 0.3, 1.0])])
            serves = int(rng.integers(0, 3))
            got = seen(leg, reach, int(square), serves, s.samples)
            truth = brute_force(leg, reach, square, serves, s)
            # between two moments of change the range may be touched too shortly for the brute force's steps
            surely = brute_force(leg, reach - 1e-3, square, serves, s) if got != truth else truth
            assert surely <= got
            assert all(brushed(leg, i, reach, square, s) for i in got - truth)
            disagreements += len(got ^ truth)
            total += len(truth)
    assert total > 500
    assert disagreements <= 3


def brushed(leg: Floats, i: int, reach: float, square: bool, s: Scene) -> bool:
    """Whether a very fine brute force sees the sample after all."""
    visit = s.points.visit_m[i]
    limit = visit if visit > 0 else reach - s.points.shrink_m[i]
    places = leg[0] + np.linspace(0, 1, 200_001)[:, None] * (leg[1] - leg[0])
    places = places[in_range(s.points.xy_m[i], places, limit + 1e-9, square and visit == 0)]
    if visit > 0:
        return len(places) > 0
    sight = shapely.linestrings(np.stack([np.broadcast_to(s.points.xy_m[i], places.shape), places], axis=1))
    walls = shapely.linestrings(s.walls.reshape(-1, 2, 2))
    return bool((~shapely.crosses(sight[:, None], walls[None]).any(axis=1)).any())


def corners_of(shape: MultiPolygon) -> Floats:
    return np.unique(shapely.get_coordinates(shape), axis=0)


def past_blocks(leg: Floats, point: Floats, reach: float, square: bool, shape: MultiPolygon, t: Floats) -> Floats:
    """Sight lines (m,) from the point to the leg's places in range that do not enter the shape's interior."""
    places = leg[0] + t[:, None] * (leg[1] - leg[0])
    places = places[in_range(point, places, reach, square)]
    sight = shapely.linestrings(np.stack([np.broadcast_to(point, places.shape), places], axis=1))
    return sight[~shapely.relate_pattern(sight, shape, "T********")] if len(sight) else sight


@pytest.mark.parametrize("square", [False, True])
def test_legs_and_points_that_touch_the_walls_of_solid_blocks(square: bool) -> None:
    rng = np.random.default_rng(11 + square)
    total = hidden = 0
    for _ in range(3):
        at, size = 2 * rng.integers(1, 9, (3, 2)), rng.integers(2, 9, (3, 2))
        shape = shapely.union_all(shapely.box(*at.T, *(at + size).T))
        shape = MultiPolygon([part for part in shapely.get_parts(shape) if isinstance(part, Polygon)])
        corners = corners_of(shape)
        edge = shapely.get_coordinates(shapely.line_interpolate_point(shape.boundary, np.arange(0.37, 60, 1.1)))
        edge = edge[np.hypot(*(edge[:, None] - corners[None]).transpose(2, 0, 1)).min(axis=1) > 0.1]
        free = rng.uniform(0, 26, (50, 2))
        free = free[~shapely.intersects_xy(shape, free)]
        s = scene(points_of(np.vstack([edge, free]), 1.0, 0, 0), border_segments(shape), 7.1, wall_margin_m=0.005)
        pairs = [np.stack([corners[i], corners[j]]) for i, j in rng.integers(0, len(corners), (16, 2))]
        pairs += [np.stack([edge[i], edge[i]]) for i in rng.integers(0, len(edge), 6)]
        shrunk = shape.buffer(-1e-6, join_style="mitre")
        nodes = shapely.multipoints(corners)
        for leg in pairs:  # along walls, from corner to corner, and standing at a wall
            if LineString(leg).relate_pattern(shape, "T********"):
                continue
            got = seen(leg, 5.0, int(square), 0, s.samples)
            away_m = shapely.distance(LineString(leg), shapely.points(s.points.xy_m))
            assert not any(away_m[i] > 7.5 for i in got)
            for i, point in enumerate(s.points.xy_m):
                if away_m[i] > 7.5:  # farther than the corner of a square
                    continue
                changes = moments(leg, point, s.walls)
                t = np.unique(np.concatenate([np.linspace(0, 1, 81), changes, (changes[1:] + changes[:-1]) / 2]))
                most = past_blocks(leg, point, 5.0 + 1e-9, square, shrunk, t)
                # walls reach 5 mm beyond their corners: past them by two centimetres sight is free beyond doubt
                least = past_blocks(leg, point, 5.0 - 1e-3, square, shape, t)
                surely = bool((shapely.distance(least, nodes) > 0.02).any()) if len(least) else False
                assert surely <= (i in got) <= (len(most) > 0), (leg, point, square)
                total += surely
                hidden += not len(most) and len(past_blocks(leg, point, 5.0, square, MultiPolygon(), t)) > 0
    assert total > 300
    assert hidden > 300


def test_a_point_on_a_wall_is_not_seen_through_its_block() -> None:
    # a robot that brushes one side of a block does not see the others, thin as the block may be
    block = MultiPolygon([box(0, 0, 10, 0.2)])
    points = np.array([[5.0, 0.0], [0.0, 0.1], [5.0, 0.2]])
    s = scene(points_of(points, 1.0, 0, 0), border_segments(block), 7.0, wall_margin_m=0.005)
    names = {tuple(xy): i for i, xy in enumerate(s.points.xy_m.tolist())}
    above = np.array([[2.0, 0.2], [8.0, 0.2]])
    assert seen(above, 5.0, 0, 0, s.samples) == {names[5.0, 0.2]}
    assert seen(np.array([[4.0, 0.2], [4.0, 0.2]]), 5.0, 0, 0, s.samples) == {names[5.0, 0.2]}
    # going on past the end it sees the short side, and at last the far one
    beyond = np.array([[-1.0, 0.2], [8.0, 0.2]])
    assert seen(beyond, 5.0, 0, 0, s.samples) == {names[5.0, 0.2], names[0.0, 0.1]}
    behind = np.array([[2.0, -3.0], [8.0, -3.0]])
    assert seen(behind, 5.0, 0, 0, s.samples) == {names[5.0, 0.0]}


def test_no_sight_through_the_corner_where_two_walls_meet() -> None:
    walls = np.array([[0.0, 0, 5, 0], [5, 0, 5, 5]])
    for margin, expected in ((0.005, set()), (0.0, {0})):
        s = scene(points_of(np.array([[4.0, 1.0]]), 1.0, 0, 0), walls, 7.0, wall_margin_m=margin)
        through_the_corner = np.array([[6.0, -1.0], [6.0, -1.0]])
        assert seen(through_the_corner, 5.0, 0, 0, s.samples) == expected


def test_a_gap_between_two_walls_lets_a_passing_robot_see_through() -> None:
    # the gap of 10 cm at distance 1 shows 20 cm of the lane at distance 2
    walls = np.array([[-9.0, 1, 0, 1], [0.1, 1, 9, 1]])
    s = scene(points_of(np.array([[0.05, 0.0]]), 1.0, 0, 0), walls, 10.0)
    for x0, x1, expected in ((-5, 5, {0}), (-5, -0.06, set()), (-5, -0.04, {0}), (0.14, 5, {0}), (0.16, 5, set())):
        assert seen(np.array([[x0, 2.0], [x1, 2.0]]), 6.0, 0, 0, s.samples) == expected, (x0, x1)
        assert seen(np.array([[x1, 2.0], [x0, 2.0]]), 6.0, 0, 0, s.samples) == expected, (x1, x0)


def test_range_by_hand() -> None:
    points = np.array([[0.0, 3.0], [0.0, 3.1], [12.9, 0.0], [13.1, 0.0], [-3.0, 3.0], [-2.2, 2.2]])
    s = scene(points_of(points, 1.0, 0, 0), NO_WALLS, 5.0)
    leg = np.array([[0.0, 0.0], [10.0, 0.0]])
    name = {tuple(xy): i for i, xy in enumerate(s.points.xy_m.tolist())}
    disc = {name[0.0, 3.0], name[12.9, 0.0]}
    assert seen(leg, 3.0, 0, 0, s.samples) == disc
    assert seen(leg, 3.0, 1, 0, s.samples) == disc | {name[-3.0, 3.0], name[-2.2, 2.2]}
    assert seen(leg, 3.12, 0, 0, s.samples) == disc | {name[0.0, 3.1], name[13.1, 0.0], name[-2.2, 2.2]}


def test_too_little_room_is_told() -> None:
    # of six points in one bin every second one is seen: three runs, two numbers each
    points = points_of(np.array([[0.0, 0.9 + 0.2 * (i % 2)] for i in range(6)]), 1.0, 0, 0)
    s = scene(points, NO_WALLS, 4.0)
    assert leg_sees(Leg(0.0, 0.0, 1.0, 0.0, 1.0, 0), 0, s.samples, np.empty(5, dtype=np.int32)) == -1
    assert leg_sees(Leg(0.0, 0.0, 1.0, 0.0, 1.0, 0), 0, s.samples, np.empty(6, dtype=np.int32)) == 6
    grid = scene(lattice_of(box(0, 0, 6, 6), 1.0), NO_WALLS, 4.0)
    assert leg_sees(Leg(3.0, 3.0, 3.0, 3.0, 1.0, 0), 0, grid.samples, np.empty(3, dtype=np.int32)) == -1
    assert leg_sees(Leg(3.0, 3.0, 3.0, 3.0, 1.0, 0), 0, grid.samples, np.empty(4, dtype=np.int32)) == 4
    # rows of nothing but seen samples that follow each other are one run
    assert leg_sees(Leg(3.0, 3.0, 3.0, 3.0, 9.0, 0), 0, grid.samples, np.empty(2, dtype=np.int32)) == 2


def lattice_of(
    shape: BaseGeometry, spacing_m: float, region: int = 0, period: int = 0, shrink_m: float = 0.0
) -> SamplePoints:
    xy_m, row, column = lattice_places(MultiPolygon(list(getattr(shape, "geoms", [shape]))), spacing_m)
    points = points_of(xy_m, spacing_m**2, period, region, shrink_m=shrink_m)
    return replace(points, row=row, column=column)


@pytest.mark.parametrize("square", [0, 1])
def test_rows_of_lattices_see_what_single_points_see(square: int) -> None:
    rng = np.random.default_rng(5)
    compared = 0
    for _ in range(12):
        corners = 8 * np.argwhere(rng.random((4, 4)) < 0.4) + rng.uniform(1, 4, (1, 2))
        blocks = shapely.union_all(
            [box(x, y, x + w, y + 3) for (x, y), w in zip(corners, rng.uniform(1, 7, len(corners)), strict=True)]
        )
        parts = [box(0, 0, 15, 34).difference(blocks), box(15, 0, 34, 34).difference(blocks)]
        points = join([lattice_of(part, 0.7 + 0.2 * i, i, i, 0.1 * i) for i, part in enumerate(parts)])
        # a few of them are missing, as those are that nobody can see
        points = points[np.flatnonzero(rng.random(len(points)) < 0.97)]
        walls = border_segments(blocks)
        loose = replace(points, row=np.full(len(points), -1), column=np.full(len(points), -1))
        rows, single = scene(points, walls, 6.0, 0.005), scene(loose, walls, 6.0, 0.005)
        for leg in np.hstack([rng.uniform(0, 34, (40, 2)), rng.normal(0, 6, (40, 2))]):
            ends = np.array([leg[:2], leg[:2] + leg[2:] * rng.choice([0.0, 1.0], 2, p=[0.1, 0.9])])
            if LineString(ends).intersects(blocks):
                continue
            serves = int(rng.integers(0, 2))
            one = rows.points.xy_m[sorted(seen(ends, 5.0, square, serves, rows.samples))]
            other = single.points.xy_m[sorted(seen(ends, 5.0, square, serves, single.samples))]
            assert sorted(map(tuple, one.tolist())) == sorted(map(tuple, other.tolist()))
            compared += len(one)
    assert compared > 5000


def test_the_interval_in_range_against_dense_times() -> None:
    rng = np.random.default_rng(2)
    t = np.linspace(0, 1, 20_001)
    for _ in range(200):
        p, d = rng.normal(0, 5, 2), rng.normal(0, 6, 2) * rng.choice([0.0, 1.0], 2, p=[0.2, 0.8])
        square, reach = int(rng.integers(0, 2)), 4.0
        inside = in_range(np.zeros(2), p + t[:, None] * d, reach, bool(square))
        first, last = range_interval(Line(p[0], p[1], d[0], d[1]), reach, square)
        if not inside.any():
            assert last - first < 1e-3
            continue
        assert first == pytest.approx(t[inside].min(), abs=1e-4)
        assert last == pytest.approx(t[inside].max(), abs=1e-4)
