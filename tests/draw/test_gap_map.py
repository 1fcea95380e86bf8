"""The numbers behind the map of worst gaps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from shapely import Polygon, box

from rota.cells.cell_map import neighbours
from rota.check import check_plan
from rota.draw.gap_map import gap_legend, gap_map
from rota.draw.palette import AREA_EDGE
from rota.draw.plan_picture import draw_gaps
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.model.plan import Plan, Trajectory


def axes():
    fig = Figure(figsize=(4, 4))
    FigureCanvasAgg(fig)
    return fig.add_subplot()


def test_a_robot_to_and_fro_leaves_gaps_of_twice_the_way_to_the_farther_end(strip: Plan):
    gaps = gap_map(strip, cells=500)
    x = np.broadcast_to(gaps.cell_map.x_m, gaps.ratio.shape)
    expected_s = np.maximum(2 * (85 - x), 2 * (x - 15))
    seen = (x > 5) & (x < 95)
    assert gaps.ratio.shape == (5, 100)
    np.testing.assert_allclose(gaps.ratio[seen], expected_s[seen] / 100, atol=1e-6)
    np.testing.assert_array_equal(gaps.never, ~seen)
    np.testing.assert_array_equal(gaps.late, seen & (expected_s > 100))


def test_the_drawn_image_holds_these_numbers(strip: Plan):
    gaps = gap_map(strip, cells=500)
    image = draw_gaps(strip, axes(), gaps)
    drawn = image.get_array()
    np.testing.assert_array_equal(drawn.mask, gaps.never)
    np.testing.assert_array_equal(drawn[~drawn.mask], gaps.ratio[~gaps.never])
    assert tuple(image.get_extent()) == (0, 100, 0, 5)
    assert image.norm.vmin == 0
    assert image.norm.vmax == 1
    colours = image.to_rgba(drawn)
    assert (colours[gaps.late] == colours[gaps.late][0]).all()
    labels = [entry.get_label() for entry in gap_legend(gaps)]
    # gaps over 100 s: x in 5..35 and 65..95, of 100; the worst at the cells 5.5 and 94.5
    assert labels == ["over the period: 60.0 %, worst 1.59", "never seen: 10.0 %"]


def test_a_gap_of_exactly_the_period_is_in_time(strip: Plan):
    exact = replace(strip, mission=replace(strip.mission, period_s=2 * 79.5))
    assert not gap_map(exact, cells=500).late.any()
    image = draw_gaps(exact, axes(), gap_map(exact, cells=500))
    assert 1 - 1e-9 < image.get_array().max() <= 1


def test_what_no_robot_can_see_is_excluded_not_missed():
    # a shaft 2 m wide behind a wall, too narrow for the body, walled on all sides
    walls = tuple(Obstacle(shape=shape) for shape in (box(7, 0, 8, 10), box(0, 10, 10, 11)))
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=20), body_radius_m=1.5)
    mission = Mission(name="shaft", area=box(0, 0, 10, 11), obstacles=walls, period_s=10, fleet=fleet)
    plan = Plan(mission=mission, trajectories=(Trajectory(robot="robot-1", times_s=[0], positions_m=[(3, 5)]),))
    gaps = gap_map(plan, cells=110)
    x, y = np.meshgrid(gaps.cell_map.x_m, gaps.cell_map.y_m)
    np.testing.assert_array_equal(gaps.excluded, (x > 8) & (y < 10))
    assert not gaps.never.any()
    refused = gap_map(replace(plan, mission=replace(mission, unseeable="refuse")), cells=110)
    np.testing.assert_array_equal(refused.never, gaps.excluded)
    assert [entry.get_label() for entry in gap_legend(gaps)] == ["cannot be seen by any robot: 22.2 %"]


def test_a_slanted_border_is_coloured_up_to_its_line_which_is_on_top(strip: Plan):
    wedge = Polygon([(0, 0), (100, 0), (100, 60)])
    plan = replace(strip, mission=replace(strip.mission, area=wedge))
    ax = axes()
    image = draw_gaps(plan, ax, gaps := gap_map(plan, cells=600))
    coloured = ~np.ma.getmaskarray(image.get_array()) | gaps.never.ravel()[neighbours(gaps.cell_map)]
    left, _, bottom, _ = image.get_extent()
    inside = np.random.default_rng(1).uniform((0, 0), (100, 60), (20_000, 2))
    inside = inside[shapely.contains_xy(wedge, inside)]
    column, row = ((inside - (left, bottom)) // gaps.cell_map.cell_m).astype(int).T
    assert coloured[row, column].all()
    assert not gaps.cell_map.inside[row, column].all(), "some of it lies in cells whose middle is outside"
    border = [patch for patch in ax.patches if patch.get_edgecolor() == to_rgba(AREA_EDGE)]
    assert [patch.get_zorder() > image.get_zorder() for patch in border] == [True]
    assert image.get_clip_path() is not None


def test_nothing_asked_is_not_mapped_and_visits_are_as_the_check_has_them(yard: Plan):
    ax = axes()
    drawn = draw_gaps(yard, ax, gaps := gap_map(yard, cells=2500)).get_array()
    x, y = np.meshgrid(gaps.cell_map.x_m, gaps.cell_map.y_m)
    visited = next(demand for demand in check_plan(yard).demands if demand.demand == "visit")
    assert drawn.mask[np.hypot(x - 25, y - 25) < 11].all()
    assert gaps.ratio[(x > 90) & (y < 10)] == pytest.approx(visited.worst_gap_s / visited.period_s)
    assert np.isnan(gaps.ratio[(x > 40) & (x < 60) & (y > 40) & (y < 55)]).all()
    assert gaps.never[(x > 10) & (x < 20) & (y > 70) & (y < 80)].all()
    assert "nothing asked" in [entry.get_label() for entry in gap_legend(gaps)]
