"""Places that see what no candidate place does, and short ways across a line of sight."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota.model.mission import DiscSensor, Fleet, Mission
from rota.planners.patrol.ground import problem as ground_problem
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.last_places import ACROSS, off_vertices, way_across
from rota.planners.patrol.tolerances import CUT_M


@pytest.fixture(scope="module")
def hall() -> Problem:
    fleet = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=4.0), body_radius_m=0.5)
    planning = PatrolSettings(effort="quick")
    return set_up_problem(
        Mission(name="hall", area=MultiPolygon([box(0, 0, 10, 10)]), fleet=fleet, period_s=200.0, planning=planning)
    )


def test_in_the_open_a_way_leads_as_far_to_either_side(hall: Problem, monkeypatch: pytest.MonkeyPatch) -> None:
    place_m = np.array([5.0, 5.0])
    assert np.array_equal(way_across(hall, np.array([5.0, 3.0]), place_m), place_m[None])  # the ground is smooth
    monkeypatch.setattr(ground_problem, "MOST_DENSE", -1)
    way_m = way_across(hall, np.array([5.0, 3.0]), place_m)
    wide_m = ACROSS * 4.0
    assert np.allclose(sorted(way_m[:, 0]), [5 - wide_m, 5, 5 + wide_m])
    assert np.allclose(way_m[:, 1], 5.0)


def test_from_the_border_a_way_lies_farther_on_or_ends_there(hall: Problem, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ground_problem, "MOST_DENSE", -1)
    # the line of sight leads off the border: somewhere along it there is room on both sides
    onwards_m = way_across(hall, np.array([0.0, 4.0]), np.array([0.5, 4.1]))
    assert len(onwards_m) == 3
    assert onwards_m[:, 0].min() > 0.5
    # it runs along the border: the way ends there, in the space
    ending_m = way_across(hall, np.array([0.5, 1.0]), np.array([0.5, 2.0]))
    assert ending_m[:, 0].min() == pytest.approx(0.5)
    assert ending_m[:, 0].max() == pytest.approx(0.5 + ACROSS * 4.0)
    assert (hall.paths.part_of(ending_m) == 0).all()


def test_a_place_beside_a_vertex_gives_way_to_another_in_the_same_view(
    hall: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ground_problem, "MOST_DENSE", -1)
    point_m, place_m = np.array([0.2, 5.0]), np.array([0.5, 5.0])
    far_m, beside_m = np.array([[5.0, 5.0]]), np.array([[5.0, 5.0], [0.5, 5.0 + 2e-7]])
    assert np.array_equal(off_vertices(hall, far_m, point_m, place_m), place_m)
    other_m = off_vertices(hall, beside_m, point_m, place_m)
    assert np.hypot(*(other_m - beside_m[1])) > CUT_M
    assert np.hypot(*(other_m - point_m)) < 4.0
    assert hall.paths.part_of(other_m[None])[0] == 0
