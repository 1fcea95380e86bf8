"""Pictures of robots that charge: each loop once, chargers, and a chart of flights and batteries by hand."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from tests.draw.test_plan_picture import drawn_routes
from tests.relieved import SQUARE_M, relieved, with_battery

from rota.draw.palette import CHARGES, LANDS, RESERVE, RESTS, pale, route_style
from rota.draw.plan_picture import plan_figure
from rota.draw.routes import routes_of
from rota.model.plan import Charge, Trajectory
from rota.routes.served_loops import loop_letter


def chart_of(count: int, **battery: float) -> Axes:
    fig = plan_figure(with_battery(relieved(count), **battery), cells=400)
    fig.canvas.draw()
    return fig.axes[2] if fig.axes[2].get_xlabel().startswith("time") else fig.axes[-1]


def bars(ax: Axes, row: int, colour: object) -> list[tuple[float, float]]:
    """From when to when the bars of a row go that have a colour, in minutes."""
    found = []
    for collection in ax.collections:
        if isinstance(collection, PolyCollection) and np.allclose(collection.get_facecolor()[0, :3], to_rgb(colour)):
            for path in collection.get_paths():
                (x0, y0), (x1, y1) = path.vertices.min(axis=0), path.vertices.max(axis=0)
                if y0 < row < y1:
                    found.append((round(float(x0), 6), round(float(x1), 6)))
    return sorted(found)


def test_a_loop_is_drawn_once_with_its_ways_and_the_charger() -> None:
    plan = relieved(3)
    (route,) = routes_of(plan)
    assert (route.letter, route.robots, route.duration_s) == ("A", (0, 1, 2), pytest.approx(80))
    assert route.length_m == pytest.approx(80)
    ax = drawn_routes(plan)
    labels = [line.get_label() for line in ax.get_lines() if not str(line.get_label()).startswith("_")]
    assert labels == ["A: 80.0 m, 80.0 s, robots 1–3 in turns"]
    assert [text.get_text() for text in ax.texts] == ["pad", "A"]
    (way,) = [line for line in ax.get_lines() if line.get_linewidth() == 0.8 and len(line.get_xdata()) == 2]
    np.testing.assert_allclose(way.get_xydata(), [(0, 0), SQUARE_M[0]])


def test_bars_are_the_flights_and_stays_of_each_robot() -> None:
    # a flight takes 10 s there, two rounds of 80 s and 10 s back; the next robot takes over 160 s later
    ax = chart_of(3)
    assert ax.get_xlabel() == "time (min)"
    assert [label.get_text() for label in ax.get_yticklabels()] == ["robot-1", "robot-2", "robot-3"]
    colour = pale(route_style(0)[0])
    assert bars(ax, 0, colour) == [(0, 3)]
    assert bars(ax, 1, colour) == [pytest.approx((160 / 60, 340 / 60))]
    # the third one is under way at the end, and so at the beginning
    assert bars(ax, 2, colour) == [pytest.approx((0, 20 / 60)), pytest.approx((320 / 60, 8))]
    # 180 s of driving are charged in 90 s
    assert bars(ax, 0, CHARGES) == [pytest.approx((3, 4.5))]
    assert bars(ax, 0, RESTS) == [pytest.approx((4.5, 8))]


def test_who_lands_and_climbs_is_seen_at_either_end_of_its_stay() -> None:
    ax = chart_of(3, landing_s=12, climbing_s=6)
    assert bars(ax, 0, LANDS) == [pytest.approx((3, 3.2)), pytest.approx((7.9, 8))]
    assert bars(ax, 1, LANDS) == [pytest.approx((154 / 60, 160 / 60)), pytest.approx((340 / 60, 352 / 60))]
    assert bars(ax, 2, LANDS) == [pytest.approx((20 / 60, 32 / 60)), pytest.approx((314 / 60, 320 / 60))]
    assert not bars(chart_of(3), 0, LANDS)


def test_lines_are_the_batteries_and_their_reserves() -> None:
    ax = chart_of(3)
    batteries = [line for line in ax.get_lines() if line.get_color() != RESERVE]
    reserves = [line for line in ax.get_lines() if line.get_color() == RESERVE]
    assert len(batteries) == len(reserves) == 3
    low, high = 0.41, -0.41
    minutes, level = np.array(batteries[0].get_xydata()).T
    # 180 s of 400 are used
    asked = np.interp([0, 3, 4.5, 8], minutes, (level - low) / (high - low))
    np.testing.assert_allclose(asked, [1, 0.55, 1, 1], atol=1e-6)
    np.testing.assert_allclose((reserves[0].get_ydata()[0] - low) / (high - low), 40 / 400)
    # who is under way at the beginning has flown 160 s before
    level = np.array(batteries[2].get_xydata())[0, 1] - 2
    assert (level - low) / (high - low) == pytest.approx(240 / 400)


def test_charts_of_many_robots_name_as_many_as_there_is_room_for() -> None:
    ax = chart_of(60)
    fig = ax.figure
    labels = [label.get_window_extent() for label in ax.get_yticklabels()]
    assert all(upper.y0 >= lower.y1 - 1 for upper, lower in itertools.pairwise(labels))
    assert all(box.x0 >= 0 for box in labels)
    assert ax.get_window_extent().height / fig.dpi < 7


def test_loops_have_letters() -> None:
    assert [loop_letter(k) for k in (0, 25, 26, 27, 701, 702)] == ["A", "Z", "AA", "AB", "ZZ", "AAA"]


def test_a_robot_that_charges_once_and_then_flies_for_ever_is_drawn_with_its_loop() -> None:
    plan = relieved(2)
    once = Charge(charger="pad", from_s=0, until_s=30)
    places = [(0, 0), (0, 0), (10, 0), (0, 0)]
    gone = Trajectory(robot="robot-3", times_s=[0, 30, 40, 50], positions_m=places, loop_start_s=30, charges=(once,))
    routes = routes_of(replace(plan, trajectories=(*plan.trajectories, gone)))
    assert [(route.letter, route.robots) for route in routes] == [("A", (0, 1)), (None, (2,))]
    assert plan_figure(replace(plan, trajectories=(gone,)), cells=400).axes[-1].get_xlabel() != "time (min)"
