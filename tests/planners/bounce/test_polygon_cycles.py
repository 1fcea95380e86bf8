"""Limit cycles in the plane: closed forms in regular polygons and rooms, shares and growth that are known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shapely import Polygon, box

from rota.errors import MissionError
from rota.planners.bounce.polygon import BounceRule, bounce_path, make_rim
from rota.planners.bounce.polygon_cycles import limit_cycles, random_starts

QUARTER = math.pi / 2
EIGHT = list(np.arange(8) * math.pi / 4)


def regular_polygon(n: int) -> Polygon:
    angles = 2 * math.pi * np.arange(n) / n
    return Polygon(np.column_stack([np.cos(angles), np.sin(angles)]))


@pytest.mark.parametrize("n", [3, 4, 5, 6, 9])
def test_flat_angles_in_a_regular_polygon_attract_to_one_cycle_through_all_sides(n: int) -> None:
    """Each side maps to the next by x -> (side - x) c: fixed at side c / (1 + c); a round contracts by c^n."""
    angle, side_m = 0.8 * math.pi / n, 2 * math.sin(math.pi / n)
    rim = make_rim(regular_polygon(n))
    run = limit_cycles(rim, BounceRule(angle_rad=angle, bounce="from_wall"), *random_starts(rim, 200, seed=0))
    ratio = math.sin(angle) / math.sin(2 * math.pi / n - angle)
    (cycle,) = run.cycles
    assert (cycle.period, cycle.stability, cycle.share, run.unsettled_share) == (n, "attracting", 1.0, 0.0)
    assert cycle.multiplier == pytest.approx((-ratio) ** n, rel=1e-9)
    np.testing.assert_allclose(rim.at(cycle.arcs_m)[1], side_m * ratio / (1 + ratio), atol=1e-9)


def test_diagonals_of_a_square_are_neutral() -> None:
    rim = make_rim(box(0, 0, 1, 1))
    rule = BounceRule(angle_rad=math.pi / 4, bounce="from_wall")
    (cycle,) = limit_cycles(rim, rule, *random_starts(rim, 100, seed=0)).cycles
    assert (cycle.period, cycle.stability) == (4, "neutral")
    assert cycle.multiplier == pytest.approx(1.0)
    assert cycle.length_m == pytest.approx(2 * math.sqrt(2))  # every inscribed rectangle along the diagonals


def test_steep_angles_in_a_square_go_to_and_fro_between_two_sides() -> None:
    """By symmetry half of all starts come to each pair of sides."""
    rim = make_rim(box(0, 0, 1, 1))
    rule = BounceRule(angle_rad=QUARTER, bounce="from_wall")
    run = limit_cycles(rim, rule, *random_starts(rim, 4000, seed=5))
    assert [cycle.period for cycle in run.cycles] == [2, 2]
    for cycle in run.cycles:
        assert cycle.stability == "neutral"
        assert cycle.length_m == pytest.approx(2.0)
        assert abs(cycle.share - 0.5) < 4 * cycle.share_error
        assert cycle.share_error == pytest.approx(math.sqrt(0.25 / 4000), rel=0.01)


def test_turning_by_a_right_angle_ends_along_the_walls() -> None:
    """Alam and Bobadilla's rule, headings along the axes: the first slide ends in a corner and forgets the start."""
    rim = make_rim(box(0, 0, 4, 3), 0.5)
    (cycle,) = limit_cycles(rim, BounceRule(angle_rad=QUARTER), *random_starts(rim, 300, 1, EIGHT[::2])).cycles
    assert (cycle.period, cycle.multiplier, cycle.stability, cycle.share) == (4, 0.0, "attracting", 1.0)
    assert cycle.grazes  # all along the walls: a heading into one of them is blocked at once
    assert not cycle.holds
    assert cycle.length_m == pytest.approx(2 * (3 + 2))


def test_headings_that_turning_leads_to_share_their_cycles() -> None:
    """135 degrees in an open square room, multiples of 45: every start heading reaches all eight."""
    rim = make_rim(box(0, 0, 5, 5), 0.5)
    run = limit_cycles(rim, BounceRule(angle_rad=math.radians(135)), *random_starts(rim, 500, 2, EIGHT))
    assert run.unsettled_share == 0
    assert len(run.cycles) < 5
    for cycle in run.cycles:
        path = bounce_path(
            rim, BounceRule(angle_rad=math.radians(135)), tuple(cycle.positions_m[0]), cycle.headings_rad[0],
            cycle.period,
        )  # fmt: skip
        np.testing.assert_allclose(path.positions_m[-1], cycle.positions_m[0], atol=1e-9)
        assert path.length_m == pytest.approx(cycle.length_m)
    assert sum(cycle.share for cycle in run.cycles) == pytest.approx(1.0)


def test_a_cycle_through_corners_is_as_stable_as_its_displaced_runs() -> None:
    """135 degrees in an open square room: the rounds along both diagonals and two walls end in corners.

    The return map has a kink there: from one side displacements are forgotten, from the other each stays.
    """
    rim, rule = make_rim(box(0, 0, 10, 10), 0.5), BounceRule(angle_rad=math.radians(135))
    run = limit_cycles(rim, rule, *random_starts(rim, 400, 2, EIGHT))
    through = next(cycle for cycle in run.cycles if cycle.length_m == pytest.approx(36 * (1 + math.sqrt(2))))
    assert (through.multiplier, through.stability) == (0.0, "half-stable")
    offs_m = []
    for k, heading in enumerate(through.headings_rad):
        middle = (through.positions_m[k] + through.positions_m[(k + 1) % 8]) / 2
        for side in (1e-4, -1e-4):
            x, y = middle + side * np.array([-math.sin(heading), math.cos(heading)])
            if 0.5 <= x <= 9.5 and 0.5 <= y <= 9.5:
                places = bounce_path(rim, rule, (float(x), float(y)), float(heading), 80).positions_m[-16:]
                offs_m.append(np.hypot(*(places[:, None] - through.positions_m).T).min(axis=1).max())
    assert sorted({round(1e4 * off, 6) for off in offs_m}) == [0.0, 1.0, pytest.approx(math.sqrt(2), abs=1e-5)]
    # by 90 degrees every slide along a wall ends in the corner, from either side
    (walls,) = limit_cycles(rim, BounceRule(angle_rad=QUARTER), *random_starts(rim, 50, 1, EIGHT[::2])).cycles
    assert walls.stability == "attracting"


def test_leaving_squarely_in_a_triangle_doubles_every_displacement() -> None:
    """Each way meets the next side at 30 degrees: |slope| is 2 at every bounce, so nothing settles, growth is log 2."""
    rim = make_rim(regular_polygon(3))
    rule = BounceRule(angle_rad=QUARTER, bounce="from_wall")
    run = limit_cycles(rim, rule, *random_starts(rim, 50, seed=0), bounces=200, longest=64)
    assert run.unsettled_share == 1.0
    assert run.cycles == ()
    assert run.growth == pytest.approx(math.log(2), rel=1e-9)


def test_a_circles_rotation_by_an_irrational_part_never_closes() -> None:
    rim = make_rim(regular_polygon(720))
    rule = BounceRule(angle_rad=1.0, bounce="from_wall")
    run = limit_cycles(rim, rule, *random_starts(rim, 20, seed=0), bounces=500, longest=300)
    assert run.unsettled_share + sum(cycle.share for cycle in run.cycles) == pytest.approx(1.0)
    assert math.isnan(run.growth) or abs(run.growth) < 0.01


def test_the_same_seed_gives_the_same_cycles() -> None:
    rim = make_rim(box(0, 0, 7, 5).difference(box(2, 2, 3, 4)), 0.3)
    rule = BounceRule(angle_rad=math.radians(100), bounce="from_wall")
    first, second = (limit_cycles(rim, rule, *random_starts(rim, 200, seed=9)) for _ in range(2))
    assert [cycle.share for cycle in first.cycles] == [cycle.share for cycle in second.cycles]
    for cycle, again in zip(first.cycles, second.cycles, strict=True):
        np.testing.assert_array_equal(cycle.arcs_m, again.arcs_m)


def test_starts_must_fit() -> None:
    rim = make_rim(box(0, 0, 4, 3), 0.5)
    with pytest.raises(MissionError, match="2 places and 1 headings"):
        limit_cycles(rim, BounceRule(angle_rad=1.0), np.ones((2, 2)), np.zeros(1))
    with pytest.raises(MissionError, match="must fit there"):
        limit_cycles(rim, BounceRule(angle_rad=1.0), np.array([[9.0, 9.0]]), np.zeros(1))
