"""Bouncing robots on their cells: the arrows and the heat map hold what a hand-made plan does."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import LogNorm
from matplotlib.quiver import Quiver
from shapely import box

from rota.cells.entered_cells import entries_of_cells, faced_cells
from rota.draw.cells_picture import cells_figure, draw_cells
from rota.draw.plan_picture import plan_figure
from rota.errors import PlanError
from rota.model.mission import DiscSensor, Fleet, Mission, Robot, Zone
from rota.model.plan import Plan, Trajectory
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planners.patrol.planner_settings import PatrolSettings

VISITED = Zone(name="door", shape=box(1, 2, 1.5, 2.5), period_s=60, demand="visit")


def plan() -> Plan:
    """East over three cells of 0.5 m, a turn by 135 degrees, and north-west by one cell."""
    sensor = DiscSensor(radius_m=1)
    fleet = Fleet(speed_m_s=1, sensor=sensor, robots=(Robot(name="a", speed_m_s=1, sensor=sensor, body_radius_m=0.1),))
    mission = Mission(
        name="strip",
        area=box(1, 2, 2.5, 3),
        fleet=fleet,
        planning=BounceSettings(cell_m=0.5, task="cover"),
    )
    trajectory = Trajectory(
        robot="a",
        times_s=np.array([0.0, 2.0, 3.0, 4.0]),
        positions_m=np.array([[1.25, 2.25], [2.25, 2.25], [2.25, 2.25], [1.75, 2.75]]),
        headings_rad=np.radians([0.0, 0.0, 135.0, 135.0]),
        loop_start_s=4.0,
    )
    return Plan(mission=mission, trajectories=(trajectory,))


def test_cells_are_told_step_by_step_with_the_ways_faced() -> None:
    answer = plan()
    faced = faced_cells(answer.mission, answer.trajectories[0])
    assert faced.cells.tolist() == [[0, 0], [1, 0], [2, 0], [2, 0], [1, 1]]
    assert np.degrees(faced.headings_rad) == pytest.approx([0, 0, 0, 135, 135])
    assert faced.entered.tolist() == [True, True, True, False, True]
    assert entries_of_cells(answer).tolist() == [[1, 1, 1], [0, 1, 0]]


def test_the_picture_has_an_arrow_for_each_state_and_a_cell_for_each_visit() -> None:
    fig = cells_figure(plan())
    left, right, _ = fig.axes
    (arrows,) = (artist for artist in left.collections if isinstance(artist, Quiver))
    tails = {(round(x, 6), round(y, 6)) for x, y in arrows.get_offsets()}
    assert tails == {(1.25, 2.25), (1.75, 2.25), (2.25, 2.25), (1.75, 2.75)}
    assert arrows.N == 5
    assert sorted(np.degrees(np.arctan2(arrows.V, arrows.U)).round(6).tolist()) == [0, 0, 0, 135, 135]
    assert np.hypot(arrows.U, arrows.V) == pytest.approx(0.36 * 0.5)
    (image,) = right.images
    assert image.get_extent() == [1, 2.5, 2, 3]
    assert np.ma.filled(image.get_array(), 0).tolist() == [[1, 1, 1], [0, 1, 0]]
    assert math.isclose(image.norm.vmax or 0, 1)


def test_many_entries_have_even_factors_and_whole_numbers_on_their_scale() -> None:
    once = plan()
    fig = cells_figure(once)
    assert [label.get_text() for label in fig.axes[2].get_xticklabels()] == ["1"]
    there_and_back = np.array([[1.25, 2.25], [2.25, 2.25]] * 30 + [[1.25, 2.25]])
    often = Trajectory(
        robot="a",
        times_s=2.0 * np.arange(61),
        positions_m=there_and_back,
        headings_rad=np.pi * (np.arange(61) % 2),
        loop_start_s=0.0,
    )
    fig = cells_figure(Plan(mission=once.mission, trajectories=(often,)))
    (image,) = fig.axes[1].images
    assert np.ma.filled(image.get_array(), 0)[0].tolist() == [31, 60, 30]
    assert isinstance(image.norm, LogNorm)
    assert [label.get_text() for label in fig.axes[2].get_xticklabels()] == ["1", "2", "5", "10", "20", "50"]


def test_a_plans_picture_shows_entries_instead_of_gaps() -> None:
    fig = plan_figure(plan())
    titles = [ax.get_title(loc="left") for ax in fig.axes]
    assert titles[:2] == [
        "Ways from the starts, robots numbered where they hold",
        "Times entered, starts included; 4 cells",
    ]
    assert any("cover the area once · cells of 0.5 m" in text.get_text() for text in fig.texts)


def test_small_cells_have_fewer_arrows_which_are_longer() -> None:
    whole = plan()
    wide = replace(whole.mission, area=box(1, 2, 101, 52))
    fig = cells_figure(replace(whole, mission=wide))
    (arrows,) = (artist for artist in fig.axes[0].collections if isinstance(artist, Quiver))
    assert arrows.N == 1
    assert np.hypot(arrows.U, arrows.V)[0] > 2 * 0.36 * 0.5


def test_files_are_equal_and_a_plan_without_cells_is_refused(tmp_path: Path) -> None:
    for name in ("a.svg", "b.svg"):
        draw_cells(plan(), tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    bounced = plan()
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1))
    mission = Mission(name="m", area=bounced.mission.area, fleet=fleet, period_s=9, planning=PatrolSettings())
    with pytest.raises(PlanError, match="a plan of patrol has no cells"):
        draw_cells(Plan(mission=mission, trajectories=()), tmp_path / "c.svg")
    free = replace(bounced.mission, planning=BounceSettings(cells="none"), zones=(VISITED,))
    with pytest.raises(PlanError, match=r"without a grid .* has no cells"):
        draw_cells(replace(bounced, mission=free), tmp_path / "d.svg")
    assert not (tmp_path / "d.svg").exists()
