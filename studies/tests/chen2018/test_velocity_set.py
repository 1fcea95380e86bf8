"""The centroid of (polygon within disc) and what half-planes leave, against shapely and closed forms."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
import shapely
from shapely import Point, Polygon

from rota.planners.swarm.state import Outline
from rota.planners.swarm.velocity_set_kernels import MOST_CORNERS, centroid_in_disc, cut, square_round

Room = Callable[[], Outline]


@pytest.fixture
def outlines() -> Callable[[], Outline]:
    return lambda: Outline(np.empty(MOST_CORNERS), np.empty(MOST_CORNERS))


def half_plane(ex: float, ey: float, bound: float, size: float = 50) -> Polygon:
    along, foot = np.array([-ey, ex]) * size, np.array([ex, ey]) * bound
    back = np.array([ex, ey]) * size
    return Polygon([foot - along, foot + along, foot + along - back, foot - along - back])


def cut_by(planes: np.ndarray, half: float, outlines: Room) -> tuple[Outline, int]:
    outline, spare = outlines(), outlines()
    corners = square_round(half, outline)
    for ex, ey, bound in planes:
        if corners:
            corners = cut(outline, corners, ex, ey, bound, spare)
            outline, spare = spare, outline
    return outline, corners


def random_planes(rng: np.random.Generator, count: int, spread: float) -> np.ndarray:
    angles = rng.uniform(0, math.tau, count)
    return np.stack([np.cos(angles), np.sin(angles), rng.uniform(-0.3, 1, count) * spread], axis=1)


def test_half_planes_leave_what_shapely_leaves(outlines: Room) -> None:
    rng = np.random.default_rng(0)
    empty = 0
    for _ in range(300):
        planes = random_planes(rng, int(rng.integers(1, 7)), 2.5)
        outline, corners = cut_by(planes, 2.0, outlines)
        expected = shapely.intersection_all([shapely.box(-2, -2, 2, 2), *(half_plane(*p) for p in planes)])
        empty += corners == 0
        got = Polygon(np.stack([outline.x, outline.y], axis=1)[:corners]) if corners > 2 else Polygon()
        assert got.symmetric_difference(expected).area < 1e-9
    assert 5 < empty < 200


def test_the_centroid_is_shapely_s_on_a_fine_polygon(outlines: Room) -> None:
    rng = np.random.default_rng(1)
    compared = 0
    for _ in range(300):
        planes = random_planes(rng, int(rng.integers(1, 6)), 2.0)
        outline, corners = cut_by(planes, 2.0, outlines)
        disc = Point(0, 0).buffer(2, quad_segs=4096)
        whole = shapely.intersection_all([disc, *(half_plane(*p) for p in planes)])
        found, x, y = centroid_in_disc(outline, corners, 2.0) if corners else (False, 0.0, 0.0)
        if whole.area < 1e-3:
            continue
        compared += 1
        assert found
        assert (x, y) == pytest.approx((whole.centroid.x, whole.centroid.y), abs=1e-6)
    assert compared > 150


@pytest.mark.parametrize("angle", [0.0, 0.7, math.pi / 2, 2.5, math.pi, 4.0])
def test_the_centroid_of_half_a_disc(angle: float, outlines: Room) -> None:
    ex, ey = math.cos(angle), math.sin(angle)
    outline, corners = cut_by(np.array([[ex, ey, 0.0]]), 3.0, outlines)
    _, x, y = centroid_in_disc(outline, corners, 3.0)
    assert (x, y) == pytest.approx((-4 * 3 / (3 * math.pi) * ex, -4 * 3 / (3 * math.pi) * ey), abs=1e-12)


@pytest.mark.parametrize("height", [1.999999, 1.9, 1.0, -1.0, -1.9, -1.999])
def test_the_centroid_of_a_disc_that_one_line_cuts(height: float, outlines: Room) -> None:
    # the segment beyond the line: area r^2 (a - sin a cos a), moment 2/3 r^3 sin^3 a, with cos a = height / r
    outline, corners = cut_by(np.array([[0.0, 1.0, height]]), 2.0, outlines)
    half = math.acos(height / 2)
    cap = 4 * (half - math.sin(half) * math.cos(half))
    expected = -2 / 3 * (2 * math.sin(half)) ** 3 / (4 * math.pi - cap)
    _, x, y = centroid_in_disc(outline, corners, 2.0)
    assert (x, y) == pytest.approx((0, expected), abs=1e-9)


def test_a_square_round_the_disc_and_one_beside_it(outlines: Room) -> None:
    outline = outlines()
    corners = square_round(3.0, outline)
    assert centroid_in_disc(outline, corners, 2.0) == (True, 0.0, 0.0)
    outline.x[:4] += 5.5
    assert not centroid_in_disc(outline, corners, 2.0)[0]


def test_sets_without_area_keep_a_place(outlines: Room) -> None:
    planes = np.array([[1, 0, 0.5], [-1, 0, -0.5]], float)
    outline, corners = cut_by(planes, 2.0, outlines)
    assert corners == 2
    assert centroid_in_disc(outline, corners, 2.0) == (True, pytest.approx(0.5), pytest.approx(0, abs=1e-9))
    point, corners = cut_by(np.array([*planes, [0, 1, -1], [0, -1, 1]]), 2.0, outlines)
    assert centroid_in_disc(point, corners, 2.0) == (True, pytest.approx(0.5), pytest.approx(-1))


def test_a_tiny_set_far_out_keeps_its_digits(outlines: Room) -> None:
    # a triangle of a millionth of a millimetre, whose centroid lies a third of its height in
    size = 1e-9
    planes = np.array([[-1, 0, -1.0], [0, -1, -1.0], [math.sqrt(0.5), math.sqrt(0.5), (2 + size) * math.sqrt(0.5)]])
    outline, corners = cut_by(planes, 2.0, outlines)
    _, x, y = centroid_in_disc(outline, corners, 2.0)
    assert (x - 1, y - 1) == pytest.approx((size / 3, size / 3), abs=2e-10)
