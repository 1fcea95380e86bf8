"""The bounce map in the plane against closed forms, exact fractions and distances measured by shapely."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely import Polygon, box

from rota.errors import MissionError
from rota.planners.bounce.polygon import BounceRule, Rim, bounce_path, make_rim
from rota.planners.bounce.polygon_cycles import random_starts
from rota.planners.bounce.polygon_kernels import bounce

Corner = tuple[Fraction, Fraction]
Floats = NDArray[np.float64]
QUARTER = math.pi / 2
HALL = box(0, 0, 7, 5).difference(box(2, 2, 3, 4)).difference(box(5, 0, 5.5, 1.5))
YARD = Polygon([(0, 0), (9, 1), (8, 6), (4.5, 4), (1, 7)]).difference(Polygon([(3, 2), (5, 2.2), (4, 3.2)]))


class Image(NamedTuple):
    """Where contacts lead to, (k,) each: arc length of the next contact, way there, d arc / d arc of the start."""

    arcs_m: Floats
    ways_m: Floats
    slopes: Floats


def bounce_map(rim: Rim, rule: BounceRule, arcs_m: Floats, headings_in_rad: Floats) -> Image:
    """The next contacts after those at arc lengths (k,) come to with headings (k,)."""
    turning, contacts = rule.compiled._replace(whole=0), zip(*rim.at(arcs_m), headings_in_rad, strict=True)
    rows = np.array([bounce(rim.compiled, turning, heading, e, s, 0) for e, s, heading in contacts])
    return Image(rim.arcs_m(rows[:, 0].astype(int), rows[:, 1]), rows[:, 3], rows[:, 5])


def regular_polygon(n: int) -> tuple[Polygon, float]:
    """Counterclockwise from (1, 0) on the unit circle, and the length of a side."""
    angles = 2 * math.pi * np.arange(n) / n
    return Polygon(np.column_stack([np.cos(angles), np.sin(angles)])), 2 * math.sin(math.pi / n)


@pytest.mark.parametrize("n", [3, 4, 5, 8, 40])
def test_a_regular_polygon_maps_side_to_side_by_the_law_of_sines(n: int) -> None:
    polygon, side_m = regular_polygon(n)
    rim = make_rim(polygon)
    angle = 0.7 * math.pi / n
    x = np.linspace(0.05, 0.95, 7) * side_m
    image = bounce_map(rim, BounceRule(angle_rad=angle, bounce="from_wall"), x, np.zeros(7))
    ratio = math.sin(angle) / math.sin(2 * math.pi / n - angle)
    np.testing.assert_allclose(image.arcs_m, side_m + (side_m - x) * ratio, atol=1e-12)
    np.testing.assert_allclose(image.slopes, -ratio, rtol=1e-12)
    np.testing.assert_allclose(
        image.ways_m, (side_m - x) * math.sin(math.pi - 2 * math.pi / n) / math.sin(2 * math.pi / n - angle), atol=1e-12
    )


def test_chords_of_a_circle_all_have_one_length() -> None:
    polygon, _ = regular_polygon(3000)
    rim = make_rim(polygon)
    path = bounce_path(rim, BounceRule(angle_rad=0.4, bounce="from_wall"), (0.1, 0.2), 1.0, 200)
    chords_m = np.linalg.norm(np.diff(path.positions_m[1:], axis=0), axis=1)
    np.testing.assert_allclose(chords_m, 2 * math.sin(0.4), atol=2.5e-3)


def exact_walls(shape: Polygon) -> list[tuple[Corner, Corner]]:
    turned = shapely.orient_polygons(shape)
    rings = [list(ring.coords) for ring in (turned.exterior, *turned.interiors)]
    exact = [[(Fraction(x), Fraction(y)) for x, y in ring] for ring in rings]
    return [wall for ring in exact for wall in pairwise(ring)]


def exact_path(shape: Polygon, place: Corner, heading: int, turn: int, bounces: int) -> list[Corner]:
    """Contacts of a point in a polygon, in fractions; headings and turns are numbers of 45 degrees."""
    steps = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]
    walls = exact_walls(shape)
    contacts = []
    for _ in range(bounces):
        while True:
            dx, dy = steps[heading % 8]
            way = None
            for (ax, ay), (bx, by) in walls:
                closing = (bx - ax) * dy - (by - ay) * dx  # below 0: towards the wall, which has its room on the left
                if closing >= 0:
                    continue
                t = ((by - ay) * (place[0] - ax) - (bx - ax) * (place[1] - ay)) / closing
                hit = (place[0] + t * dx, place[1] + t * dy)
                on = min(ax, bx) <= hit[0] <= max(ax, bx) and min(ay, by) <= hit[1] <= max(ay, by)
                if t >= 0 and on and (way is None or t < way):
                    way = t
            assert way is not None
            if way > 0:
                break
            heading += turn
        place = (place[0] + way * dx, place[1] + way * dy)
        contacts.append(place)
    return contacts


@pytest.mark.parametrize("turn", [1, 2, 3, 4, 5, 7])
@pytest.mark.parametrize("heading", [0, 1, 6])
def test_contacts_agree_with_exact_fractions(turn: int, heading: int) -> None:
    """Corners and slides along walls included: headings along the axes make them."""
    start = (Fraction(17, 16), Fraction(41, 32))
    expected = exact_path(HALL, start, heading, turn, 200)
    rule = BounceRule(angle_rad=turn * math.pi / 4)
    path = bounce_path(make_rim(HALL), rule, (float(start[0]), float(start[1])), heading * math.pi / 4, 200)
    np.testing.assert_allclose(path.positions_m[1:], np.array(expected, dtype=np.float64), atol=1e-10)


@pytest.mark.parametrize("rule", [BounceRule(angle_rad=1.9), BounceRule(angle_rad=1.1, bounce="from_wall")])
def test_a_disc_goes_on_until_it_touches_and_no_farther(rule: BounceRule) -> None:
    radius_m = 0.35
    rim = make_rim(YARD, radius_m)
    starts, headings = random_starts(rim, 20, seed=1)
    for start, heading in zip(starts, headings, strict=True):
        path = bounce_path(rim, rule, (start[0], start[1]), heading, 40)
        assert len(path.arcs_m) == 40
        gaps_m = shapely.distance(YARD.boundary, shapely.points(path.positions_m[1:]))
        np.testing.assert_allclose(gaps_m, radius_m, atol=1e-9)
        shares = np.linspace(0, 1, 60)[:, None, None]
        between = (1 - shares) * path.positions_m[:-1] + shares * path.positions_m[1:]
        assert shapely.distance(YARD.boundary, shapely.points(between)).min() > radius_m - 1e-9
        ahead = path.positions_m[1:] + 1e-5 * np.column_stack([np.cos(path.headings_rad), np.sin(path.headings_rad)])
        assert (shapely.distance(YARD.boundary, shapely.points(ahead)) < radius_m).all()


@pytest.mark.parametrize("radius_m", [0.0, 0.35])
@pytest.mark.parametrize("rule", [BounceRule(angle_rad=1.9), BounceRule(angle_rad=1.1, bounce="from_wall")])
def test_slopes_are_those_of_finite_differences(rule: BounceRule, radius_m: float) -> None:
    rim = make_rim(YARD, radius_m)
    arcs_m, headings = arrivals(rim, rule, 300)
    image = bounce_map(rim, rule, arcs_m, headings)
    step_m = 1e-6
    low, high = (bounce_map(rim, rule, arcs_m + sign * step_m, headings) for sign in (-1, 1))
    element = rim.at(image.arcs_m)[0]
    smooth = (rim.at(low.arcs_m)[0] == element) & (rim.at(high.arcs_m)[0] == element)
    assert smooth.sum() > 250
    slopes = (high.arcs_m - low.arcs_m) / (2 * step_m)
    np.testing.assert_allclose(image.slopes[smooth], slopes[smooth], rtol=1e-4, atol=1e-4)
    if radius_m > 0:
        assert (rim.kinds[element[smooth]] == 1).sum() > 10  # arcs round corners took part


def arrivals(rim: Rim, rule: BounceRule, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Contacts that are reached, with the headings in; some way from the ends of walls."""
    starts, headings = random_starts(rim, 2 * count, seed=3)
    paths = [bounce_path(rim, rule, (x, y), heading, 1) for (x, y), heading in zip(starts, headings, strict=True)]
    arcs_m = np.array([path.arcs_m[0] for path in paths])
    element, s_m = rim.at(arcs_m)
    inner = (s_m > 1e-4) & (s_m < rim.elements[element, 4] - 1e-4)
    return arcs_m[inner][:count], headings[inner][:count]


def test_a_pillars_corner_disperses_what_leaves_it_squarely() -> None:
    """From an arc of radius r squarely to a wall at distance L, displacements grow 1 + L / r fold."""
    rim = make_rim(box(0, 0, 10, 6).difference(Polygon([(5, 3), (6, 4.5), (4, 4.5)])), 0.5)
    path = bounce_path(rim, BounceRule(angle_rad=QUARTER, bounce="from_wall"), (5, 1), QUARTER, 3)
    np.testing.assert_allclose(path.positions_m[1:], [[5, 2.5], [5, 0.5], [5, 2.5]], atol=1e-12)
    image = bounce_map(rim, BounceRule(angle_rad=QUARTER, bounce="from_wall"), path.arcs_m[:1], np.zeros(1))
    assert abs(image.slopes[0]) == pytest.approx(1 + 2 / 0.5, rel=1e-12)


def test_a_robot_that_turns_by_a_right_angle_slides_round_a_room() -> None:
    path = bounce_path(make_rim(box(0, 0, 4, 3), 0.5), BounceRule(angle_rad=QUARTER), (1, 1), 0.0, 5)
    expected = [[1, 1], [3.5, 1], [3.5, 2.5], [0.5, 2.5], [0.5, 0.5], [3.5, 0.5]]
    np.testing.assert_allclose(path.positions_m, expected, atol=1e-12)
    assert path.length_m == pytest.approx(2.5 + 1.5 + 3 + 2 + 3)


def test_a_corner_too_sharp_for_the_rule_holds_the_robot() -> None:
    triangle = Polygon([(0, 0), (2, 0), (1, math.sqrt(3))])
    path = bounce_path(
        make_rim(triangle), BounceRule(angle_rad=QUARTER, bounce="from_wall"), (1.5, 0.5 * math.tan(math.pi / 6)),
        -math.pi / 6, 9,
    )  # fmt: skip
    np.testing.assert_allclose(path.positions_m[-1], [2, 0], atol=1e-9)
    assert len(path.arcs_m) == 1


def test_headings_come_back_exactly() -> None:
    assert [BounceRule(angle_rad=math.radians(deg)).turns_to_whole for deg in (45, 90, 135, 100, 0.1)] == [
        8, 4, 8, 18, 3600,
    ]  # fmt: skip
    assert BounceRule(angle_rad=1.0).turns_to_whole == 0


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(MissionError, match="must lie between 0 and 2 pi"):
        BounceRule(angle_rad=7.0)
    with pytest.raises(MissionError, match="must lie between 0 and pi"):
        BounceRule(angle_rad=3.2, bounce="from_wall")
    with pytest.raises(MissionError, match="fits nowhere"):
        make_rim(box(0, 0, 1, 1), 0.6)
    rim = make_rim(box(0, 0, 1, 1), 0.2)
    with pytest.raises(MissionError, match=r"start \[0.1, 0.5\] is not allowed"):
        bounce_path(rim, BounceRule(angle_rad=1.0), (0.1, 0.5), 0.0, 3)
    with pytest.raises(MissionError, match=r"must lie in 0\.\.4 m"):
        rim.at(np.array([4.5]))
