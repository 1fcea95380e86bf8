"""What a leg sees, against shapely: range and line of sight at every moment at which either could change."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely import LineString, Polygon, box

from rota.geometry.free_space import border_segments
from rota.planners.patrol.kernels import Samples, hidden_until, leg_sees, range_interval
from rota.planners.patrol.samples import SamplePoints, joined, points_of, prepare

Floats = NDArray[np.float64]
NO_WALLS = np.zeros((0, 4))


@dataclass(frozen=True)
class Scene:
    """Prepared samples, and the points and walls in the same order for the brute force."""

    samples: Samples
    points: SamplePoints
    walls: Floats


def scene(points: SamplePoints, walls: Floats, reach_m: float, wall_margin_m: float = 0.0) -> Scene:
    samples, order = prepare(
        points, walls, reach_m=reach_m, weight=np.ones(len(points)), wall_margin_m=wall_margin_m
    )
    return Scene(samples=samples, points=points[order], walls=samples.walls)


def seen(leg: Floats, reach: float, square: int, serves: int, samples: Samples) -> set[int]:
    out = np.empty(len(samples.x), dtype=np.int32)
    a, b = leg
    found = leg_sees(float(a[0]), float(a[1]), float(b[0]), float(b[1]), reach, square, serves, samples, out)
    assert len(set(out[:found].tolist())) == found  # each once
    return set(out[:found].tolist())


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
    for i in range(len(s.points)):
        point, visit = s.points.xy_m[i], s.points.visit_m[i]
        if s.points.period[i] < serves:
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


def seen_if_reach_were(leg: Floats, reach: float, square: bool, serves: int, s: Scene) -> set[int]:
    return brute_force(leg, reach, square, serves, s)


def random_points(rng: np.random.Generator, n: int) -> SamplePoints:
    parts = [
        points_of(rng.uniform(0, 30, (n, 2)), 1.0, 0, 0),
        points_of(rng.uniform(0, 30, (n, 2)), 1.0, 1, 1, shrink_m=0.7),
        points_of(rng.uniform(0, 30, (n // 4, 2)), 1.0, 2, 2, visit_m=2.5),
        points_of(rng.uniform(0, 30, (n // 4, 2)), 1.0, 0, 3, visit_m=9.0),  # farther than the sensor sees
    ]
    return joined(parts)


@pytest.mark.parametrize("square", [False, True])
@pytest.mark.parametrize("walls", [0, 3, 12])
def test_random_legs_among_random_walls(square: bool, walls: int) -> None:
    rng = np.random.default_rng([walls, square])
    reach, disagreements, total = 6.0, 0, 0
    for _ in range(12):
        start = rng.uniform(0, 30, (walls, 2))
        s = scene(random_points(rng, 40), np.hstack([start, start + rng.normal(0, 4, (walls, 2))]), reach * 1.4143)
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
    assert total > 300
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


@pytest.mark.parametrize("square", [False, True])
def test_legs_and_points_that_touch_the_walls_of_solid_blocks(square: bool) -> None:
    rng = np.random.default_rng(11 + square)
    total = 0
    for _ in range(6):
        blocks = shapely.union_all(
            [box(x, y, x + w, y + h) for x, y, w, h in rng.integers(2, 9, (3, 4)) * np.array([2, 2, 1, 1])]
        )
        shape = shapely.multipolygons([p for p in shapely.get_parts(blocks) if isinstance(p, Polygon)])
        corners = np.unique(shapely.get_coordinates(shape), axis=0)
        edge = np.unique(shapely.get_coordinates(shapely.segmentize(shape.boundary, 1.3)), axis=0)
        free = rng.uniform(0, 26, (60, 2))
        free = free[~shapely.intersects_xy(shape, free)]
        s = scene(points_of(np.vstack([edge, free]), 1.0, 0, 0), border_segments(shape), 7.0, wall_margin_m=0.005)
        # legs along walls, from corner to corner, and standing in a corner
        legs = [np.stack([corners[i], corners[j]]) for i, j in rng.integers(0, len(corners), (10, 2))]
        legs = [leg for leg in legs if not LineString(leg).crosses(shape) and not shape.contains(LineString(leg))]
        legs = [leg for leg in legs if shape.boundary.covers(LineString(leg)) or not shape.covers(LineString(leg))]
        for leg in legs:
            got = seen(leg, 5.0, int(square), 0, s.samples)
            most = sees_past(leg, 5.0 + 1e-9, square, shape, -0.02, s)
            least = sees_past(leg, 5.0 - 1e-3, square, shape, 0.02, s)
            assert least <= got <= most
            total += len(least)
    assert total > 300


def sees_past(leg: Floats, reach: float, square: bool, shape: Polygon, grown_m: float, s: Scene) -> set[int]:
    """Samples in sight past blocks grown (or shrunk) a little; what is near the sample itself does not count."""
    blocks = shape.buffer(grown_m, join_style="mitre")
    shapely.prepare(blocks)
    found = set()
    places = leg[0] + np.linspace(0, 1, 161)[:, None] * (leg[1] - leg[0])
    for i, point in enumerate(s.points.xy_m):
        here = places[in_range(point, places, reach, square)]
        if not len(here):
            continue
        sight = shapely.linestrings(np.stack([np.broadcast_to(point, here.shape), here], axis=1))
        if grown_m > 0:
            # the block's own skin covers points and legs on it: cut both ends off, and ask that the rest is free
            from_ends = shapely.multipoints([point]).buffer(8 * grown_m)
            sight = shapely.difference(sight, from_ends)
            sight = shapely.difference(sight, shapely.points(here).view() if False else shapely.buffer(shapely.points(here), 8 * grown_m))
        if (~shapely.intersects(sight, blocks)).any() if grown_m > 0 else (~shapely.crosses(sight, blocks)).any():
            found.add(i)
    return found
