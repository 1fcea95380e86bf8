"""How dense the samples lie that stand for the ground."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest
from shapely import MultiPolygon, Polygon, box
from tests.planners.patrol.searching import YARD

from rota.errors import NoPlanFound
from rota.planners.patrol.efforts import EFFORTS
from rota.planners.patrol.ground.problem import finer_spacing_m, set_up_problem
from rota.planners.patrol.loop_settings import SamplingSettings

SETTINGS = SamplingSettings(per_reach=8, shrink=0.4, few_samples=2_500)


@pytest.mark.parametrize(
    ("asked_m2", "expected_m"),
    [
        (100.0, 5 / 12),  # never denser
        (5_000.0, 5 / 8),  # many samples anyway
        (700.0, math.sqrt(700 / 2_500)),  # as many as are few
    ],
)
def test_samples_lie_denser_where_they_are_few(asked_m2: float, expected_m: float) -> None:
    assert finer_spacing_m(asked_m2, 5.0, SETTINGS, 5 / 8) == pytest.approx(expected_m)


def test_other_efforts_have_one_spacing() -> None:
    assert finer_spacing_m(1.0, 5.0, EFFORTS["normal"].sampling, 5 / 12) == 5 / 12


def test_small_ground_has_denser_samples_unless_the_team_is_fixed() -> None:
    small = replace(YARD, area=MultiPolygon([box(0, 0, 10, 10)]), obstacles=())
    assert set_up_problem(small).spacing_m == pytest.approx(0.2)
    team = tuple(small.fleet.equal_robot(name) for name in ("one", "two"))
    assert set_up_problem(replace(small, fleet=replace(small.fleet, robots=team))).spacing_m == pytest.approx(2 / 8)


@pytest.mark.parametrize("at", [1, 2, 3, 4, 5])
def test_a_stop_is_heeded_between_the_steps(at: int) -> None:
    asked = itertools.count(1)
    with pytest.raises(NoPlanFound, match="stopped before"):
        set_up_problem(YARD, should_stop=lambda: next(asked) == at)
    assert next(asked) == at + 1


def test_corners_that_lie_at_one_place_but_for_rounding_do_no_harm() -> None:
    nearly = Polygon([(0, 0), (3.4e-218, 0), (6, 6), (0, 6)])
    assert len(set_up_problem(replace(YARD, area=MultiPolygon([nearly]), obstacles=())).points) > 0
