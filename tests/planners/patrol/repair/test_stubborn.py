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


def test_nooks_lie_beside_both_halves_of_each_side_and_in_each_inner_corner(hall: Problem) -> None:
    xy_m = nooks_of(hall).xy_m
    expected = [(0.0, 0.0), (10, 0), (10, 10), (0, 10)]  # of the hall
    expected += [place for q in (2.5, 7.5) for place in [(q, 0.0), (10, q), (q, 10), (0, q)]]
    expected += [(q, y) for q in (4.5, 5.5) for y in (4, 4.5)]  # of the slab, whose corners are outer ones
    expected += [(x, q) for q in (4.125, 4.375) for x in (4.0, 6)]
    assert len(xy_m) == len(expected)
    for place in expected:
        assert np.hypot(*(xy_m - place).T).min() < 1e-7
    clear = hall.regions[0].shape
    assert shapely.contains_xy(clear, xy_m).all()


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
