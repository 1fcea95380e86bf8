"""Curves for robots with a turn radius: shortest paths against brute force, walls, and plans that the check passes."""

from __future__ import annotations

import math
from itertools import pairwise, product

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, box

import rota
from rota.check import check_plan
from rota.errors import MissionError
from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import DiscSensor, Fleet, Mission, Robot, StartPoints
from rota.model.plan import Plan
from rota.planners.patrol.driving.polylines import turns_rad
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.tours.curve_kernels import WORDS, word_pieces
from rota.planners.patrol.tours.curves import approach_curve, closed_curve

Floats = NDArray[np.float64]
FIELD = box(0, 0, 100, 60)
BLOCK = box(40, 20, 60, 40)


def space(*holes: shapely.Polygon) -> ShortestPaths:
    return ShortestPaths(MultiPolygon([FIELD.difference(shapely.union_all(holes))]))


def end_of(word: int, heading: float, pieces: Floats) -> Floats:
    """Where a word leads that begins at the origin, with radius 1: x, y and heading."""
    x = y = 0.0
    for side, piece in zip(WORDS[word], pieces, strict=True):
        if side == 0:
            x, y = x + piece * math.cos(heading), y + piece * math.sin(heading)
        else:
            after = heading + side * piece
            x, y = x + side * (math.sin(after) - math.sin(heading)), y - side * (math.cos(after) - math.cos(heading))
            heading = after
    return np.array([x, y, heading])


@pytest.mark.parametrize("word", range(6))
def test_words_lead_where_they_should(word: int) -> None:
    rng, pieces, led = np.random.default_rng(word), np.zeros(3), 0
    for _ in range(500):
        d, a, b = rng.uniform(0.01, 6), *rng.uniform(-7, 7, 2)
        if word_pieces(word, d, a, b, pieces):
            led += 1
            x, y, heading = end_of(word, a, pieces)
            assert (x, y) == pytest.approx((d, 0), abs=1e-7)
            assert math.cos(heading - b) == pytest.approx(1, abs=1e-9)
            assert (pieces >= 0).all()
    assert led > 20


def test_no_path_of_bounded_curvature_is_shorter_than_the_best_word() -> None:
    # brute force: all sequences of left, right and straight pieces of 1/4 from the same place and heading
    pieces, step = np.zeros(3), 0.25
    for moves in product((-1, 0, 1), repeat=7):
        x, y, heading = 0.0, 0.0, 0.3
        for side in moves:
            after = heading + side * step
            if side == 0:
                x, y = x + step * math.cos(heading), y + step * math.sin(heading)
            else:
                x += side * (math.sin(after) - math.sin(heading))
                y -= side * (math.cos(after) - math.cos(heading))
            heading = after
        d, along = math.hypot(x, y), math.atan2(y, x)
        if d < 1e-9:
            continue
        lengths = [
            float(pieces.sum()) for word in range(6) if word_pieces(word, d, 0.3 - along, heading - along, pieces)
        ]
        assert min(lengths) <= 7 * step + 1e-7


def tightest_m(corners_m: Floats) -> float:
    """The largest radius whose arcs fit into all corners of a closed polyline."""
    half = np.tan(turns_rad(corners_m) / 2)
    legs = np.hypot(*(np.roll(corners_m, -1, axis=0) - corners_m).T)
    return float((legs / (half + np.roll(half, -1))).min())


@pytest.mark.parametrize("radius_m", [0.5, 3.0, 8.0])
def test_closed_curves_pass_their_vertices_and_turn_no_tighter(radius_m: float) -> None:
    rng = np.random.default_rng(5)
    for n in (2, 3, 6):
        vertices_m = rng.uniform((20, 20), (80, 40), (n, 2))
        curve = closed_curve(vertices_m, radius_m, space().grid)
        line = shapely.LineString(np.vstack([curve, curve[:1]]))
        assert shapely.distance(line, shapely.points(vertices_m)).max() < 1e-9
        assert tightest_m(curve) >= radius_m
        assert turns_rad(curve).max() <= math.pi / 16 + 1e-9


def test_a_turn_back_on_long_legs_takes_a_half_circle_more() -> None:
    curve = closed_curve(np.array([[20.0, 30.0], [80.0, 30.0]]), 5.0, space().grid)
    length = shapely.LineString(np.vstack([curve, curve[:1]])).length
    # out and back side by side would take (pi - 2) r at each end; the way must also come together again
    assert 120 + 2 * (math.pi - 2) * 5 < length < 120 + 2 * math.pi * 5


def test_curves_keep_to_the_space_round_a_block() -> None:
    paths = space(BLOCK)
    ring = np.array([[40.0, 20.0], [60.0, 20.0], [60.0, 40.0], [40.0, 40.0]])  # the corners themselves
    curve = closed_curve(ring, 6.0, paths.grid)
    legs = shapely.LineString(np.vstack([curve, curve[:1]]))
    assert not legs.crosses(BLOCK.buffer(-1e-9))
    assert tightest_m(curve) >= 6


def test_where_walls_leave_no_room_a_vertex_is_left_out() -> None:
    lane = box(90, 28, 100, 32)  # 4 m wide: a robot with 6 m of turn radius can drive in and never out
    field = box(0, 0, 90, 60).union(lane)
    grid = ShortestPaths(MultiPolygon([field])).grid
    ring = np.array([[20.0, 10.0], [80.0, 10.0], [97.0, 30.0], [80.0, 50.0], [20.0, 50.0]])
    curve = closed_curve(ring, 6.0, grid)
    legs = shapely.LineString(np.vstack([curve, curve[:1]]))
    assert field.buffer(1e-9).covers(legs)
    assert shapely.distance(legs, shapely.points(ring[[0, 1, 3, 4]])).max() < 1e-6
    stopped = closed_curve(ring, 6.0, grid, lambda: True)  # passes it still, whatever is in the way
    assert shapely.distance(shapely.linearrings(stopped), shapely.points(ring)).max() < 1e-6


def test_one_vertex_is_gone_round_where_there_is_room() -> None:
    circle = closed_curve(np.array([[50.0, 30.0]]), 7.0, space().grid)
    assert len(circle) == 32
    assert tightest_m(circle) >= 7
    assert closed_curve(np.array([[3.0, 30.0]]), 7.0, space().grid).tolist() == [[3, 30]]


def test_approaches_end_as_the_loop_goes_on() -> None:
    line = np.array([[10.0, 10.0], [50.0, 30.0]])
    curve = approach_curve(line, 5.0, space().grid, np.array([50.0, 20.0]))
    assert curve[[0, -1]].tolist() == line.tolist()
    last = curve[-1] - curve[-2]
    assert np.arctan2(last[1], last[0]) == pytest.approx(-math.pi / 2)
    straight = approach_curve(line, 5.0, space().grid, None)
    assert shapely.LineString(straight).length == pytest.approx(math.hypot(40, 20))


@pytest.mark.parametrize("start_m", [(10.0, 10.0), (30.0, 52.0), (20.0, 31.0)])
def test_an_approach_begins_straight_since_any_heading_will_do(start_m: tuple[float, float]) -> None:
    end_m, radius_m = np.array([50.0, 30.0]), 5.0
    curve = approach_curve(np.array([start_m, end_m]), radius_m, space().grid, np.array([50.0, 20.0]))
    # the tangent from the start to the nearer of both circles that the end leaves, and the arc from there
    lengths = []
    for side in (-1, 1):
        centre_m = end_m + np.array([side * radius_m * 1.001, 0.0])
        away = np.array(start_m) - centre_m
        far_m = math.hypot(*away)
        spread = math.acos(radius_m * 1.001 / far_m)
        touch = math.atan2(away[1], away[0]) + side * spread
        arc = (side * ((0.0 if side < 0 else math.pi) - touch)) % (2 * math.pi)
        lengths.append(math.sqrt(far_m**2 - (radius_m * 1.001) ** 2) + radius_m * 1.001 * arc)
    # legs beside an arc are longer than it by up to turn^2 / 12
    arc_room = 2 * math.pi * radius_m * (math.pi / 16) ** 2 / 12
    assert min(lengths) - 1e-6 <= shapely.LineString(curve).length <= min(lengths) + arc_room
    assert np.hypot(*np.diff(curve, axis=0).T).min() > 0.04 * radius_m


def test_a_small_field_is_watched_on_arcs() -> None:
    fleet = Fleet(
        speed_m_s=10, sensor=DiscSensor(radius_m=15), turn_radius_m=5, start=StartPoints(points_m=((5, 5), (5, 12)))
    )
    area = MultiPolygon([box(0, 0, 60, 40).difference(box(25, 15, 35, 25))])
    quick = PatrolSettings(effort="quick")
    assert_driven_on_arcs(
        rota.make_plan(Mission(name="field", area=area, period_s=40, fleet=fleet, planning=quick), seed=0)
    )


def assert_driven_on_arcs(plan: Plan) -> None:
    report = check_plan(plan)
    assert (report.verdict, report.violations) == ("met", ())
    for trajectory in plan:
        steps = np.diff(trajectory.positions_m, axis=0)
        headings = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0])[np.hypot(*steps.T) > 1e-9])
        assert max(abs(b - a) for a, b in pairwise(headings)) <= math.pi / 16 + 1e-6


def test_robots_that_turn_on_the_spot_and_on_arcs_are_not_mixed() -> None:
    with pytest.raises(MissionError, match=r"robot a: turn_radius_m: 2 .*turns on the spot or on arcs"):
        Robot(name="a", speed_m_s=1, sensor=DiscSensor(radius_m=1), turn_rate_rad_s=1, turn_radius_m=2)
    robots = tuple(
        Robot(name=name, speed_m_s=10, sensor=DiscSensor(radius_m=15), turn_rate_rad_s=rate, turn_radius_m=radius)
        for name, rate, radius in (("a", 1.0, 0.0), ("b", None, 6.0))
    )
    with pytest.raises(MissionError, match=r"fleet\.robots\[1\]\.turn_radius_m"):
        Mission(
            name="field",
            area=MultiPolygon([FIELD]),
            period_s=60,
            fleet=Fleet(speed_m_s=10, sensor=DiscSensor(radius_m=15), robots=robots),
            planning=PatrolSettings(effort="quick"),
        )
