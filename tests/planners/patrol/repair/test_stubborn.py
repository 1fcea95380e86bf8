"""What stays unmet after it was asked for."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box

from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.ground import problem as ground_problem
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.ground.nooks import nooks_of
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.ground.samples import points_of
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.stubborn import ask_again

SLAB = box(4.0, 4.0, 6.0, 4.5)


@pytest.fixture(scope="module")
def hall() -> Problem:
    slab = Obstacle(shape=MultiPolygon([SLAB]))
    return set_up_problem(
        Mission(
            name="hall",
            area=MultiPolygon([box(0, 0, 10, 10)]),
            obstacles=(slab,),
            fleet=Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=4.0), body_radius_m=0.2),
            period_s=200.0,
            planning=PatrolSettings(effort="quick"),
        )
    )


def near_slab(*xy: tuple[float, float]) -> Any:
    return points_of(np.array(xy), 1.0, 0, 0)


def test_nooks_lie_beside_the_middle_of_each_side_and_in_each_inner_corner(
    hall: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    xy_m = nooks_of(hall).xy_m
    expected = [(5, 0), (10, 5), (5, 10), (0, 5), (0, 0), (10, 0), (10, 10), (0, 10)]  # of the hall
    expected += [(5, 4), (6, 4.25), (5, 4.5), (4, 4.25)]  # of the slab, whose corners are outer ones
    assert len(xy_m) == len(expected)
    for place in expected:
        assert np.hypot(*(xy_m - place).T).min() < 1e-7
    clear = hall.regions[0].shape
    assert shapely.contains_xy(clear, xy_m).all()
    monkeypatch.setattr(ground_problem, "MOST_DENSE", 0)
    ragged_m = nooks_of(dataclasses.replace(hall)).xy_m
    assert len(ragged_m) == 4 + 2 * 8  # both halves of each side have one
    assert np.hypot(*(ragged_m - (2.5, 0)).T).min() < 1e-7


def test_on_ragged_ground_one_of_each_crowd_that_was_asked_for_is_asked_again(
    hall: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = near_slab((5.0, 3.99), (8.0, 8.0))
    new = near_slab((5.005, 3.99), (5.01, 3.98), (2.0, 2.0))
    assert len(ask_again(hall, asked, new)) == 0  # the ground is smooth
    monkeypatch.setattr(ground_problem, "MOST_DENSE", 0)
    ragged = dataclasses.replace(hall)
    assert ragged.is_ragged
    again = ask_again(ragged, asked, new)
    assert len(again) == 1
    assert tuple(again.xy_m[0]) in [(5.005, 3.99), (5.01, 3.98)]
    assert len(ask_again(ragged, no_points(), new)) == 0
