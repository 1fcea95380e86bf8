"""Worst gaps in closed form: circles, shared loops, shadows, pillars, strips, visits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shapely import MultiPolygon, Polygon, box

from rota.check.demands import visits
from rota.check.pieces import Pieces, convex_pieces, join, point_pieces, quarter
from rota.check.revisits import loop_gap, piece_gaps, sights_of, worst_gaps_s
from rota.check.routes import classes_in_step, commensurable_classes, routes_of
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Sensor, SquareSensor
from rota.model.plan import Plan, Trajectory


def mission(sensor: Sensor, *obstacles: Polygon, size: float = 100.0) -> Mission:
    return Mission(
        name="m",
        area=MultiPolygon([box(-size, -size, size, size)]),
        obstacles=tuple(Obstacle(shape=shape) for shape in obstacles),
        fleet=Fleet(speed_m_s=1.0, sensor=sensor),
        period_s=10.0,
    )


def route(xy: object, speed: float = 1.0, robot: str = "a", delay: float = 0.0) -> Trajectory:
    """A closed loop at constant speed after ``delay`` seconds of waiting at its first point."""
    points = np.array(xy, dtype=float)
    times = delay + np.concatenate([[0], np.cumsum(np.hypot(*np.diff(points, axis=0).T)) / speed])
    if delay:
        points, times = np.vstack([points[:1], points]), np.concatenate([[0], times])
    return Trajectory(robot=robot, times_s=times, positions_m=points, loop_start_s=delay)


def hold(x: float, y: float, robot: str = "a") -> Trajectory:
    return Trajectory(robot=robot, times_s=[0.0], positions_m=[[x, y]])


def plan(mission: Mission, *trajectories: Trajectory) -> Plan:
    return Plan(mission=mission, trajectories=trajectories)


def test_robot_on_a_circle_sees_a_point_on_it_for_the_chord() -> None:
    n, big, reach = 2000, 10.0, 3.0
    angles = np.linspace(0, 2 * math.pi, n + 1)
    ring = big * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    ring[-1] = ring[0]
    watched = plan(mission(DiscSensor(radius_m=reach)), route(ring))
    turn = watched.trajectories[0].loop_duration_s
    seen = 2 * 2 * math.asin(reach / (2 * big)) * big  # arc from which a point of the circle is in range
    gaps = worst_gaps_s(watched, np.array([[big, 0.0], [0.0, -big], [0.0, 0.0], [6.9, 0.0]]))
    np.testing.assert_allclose(gaps[:2], turn - seen, atol=1e-3)
    assert np.isinf(gaps[2:]).all()


def test_two_robots_half_a_loop_apart_halve_the_gap() -> None:
    square = [(0, 0), (8, 0), (8, 8), (0, 8), (0, 0)]
    late = [(8, 8), (0, 8), (0, 0), (8, 0), (8, 8)]
    m = mission(DiscSensor(radius_m=1.0))
    point = np.array([[4.0, 0.0]])
    assert worst_gaps_s(plan(m, route(square)), point) == pytest.approx(30.0)
    assert worst_gaps_s(plan(m, route(square), route(late, robot="b")), point) == pytest.approx(14.0)
    # a second start that is 3 s late makes gaps of 14 - 3 and 14 + 3
    assert worst_gaps_s(plan(m, route(square), route(late, robot="b", delay=3.0)), point) == pytest.approx(17.0)


def test_a_robot_from_rest_to_rest_sees_by_its_parabola() -> None:
    """16 m at 0.5 m/s2 and -0.5 m/s2, 8 s, and back again: s(t) = t^2 / 4, 8 m after sqrt(32) s."""
    way = Trajectory(
        robot="a", times_s=4 * math.sqrt(2) * np.arange(5), positions_m=[(0, 0), (8, 0), (16, 0), (8, 0), (0, 0)],
        accelerations_m_s2=[0.5, -0.5, 0.5, -0.5],
    )  # fmt: skip
    there = plan(mission(DiscSensor(radius_m=1)), way)
    points = np.array([[5.0, 0.0], [16.0, 0.0]])
    found = piece_gaps(sights_of(there, (-1, -1, 17, 2)), point_pieces(points), np.zeros(2))
    whole = way.times_s[-1]
    # in range from 4 m to 6 m on its way, and from 15 m on; points are seen from 1e-9 m farther off
    assert found.firsts_s == pytest.approx([4.0, whole / 2 - 2.0], abs=1e-8)
    assert found.gaps_s == pytest.approx([whole - 2 * math.sqrt(24), whole - 4.0], abs=1e-8)
    inside = visits(
        there.trajectories[0].positions_m[[[0, 1], [1, 2], [2, 3], [3, 4]]].reshape(4, 4), box(4, -1, 6, 1), 1e-9
    )
    gap, begin = loop_gap(routes_of(there), inside)
    assert (gap, begin) == pytest.approx((whole - 2 * math.sqrt(24), math.sqrt(24)))


def test_slower_robot_on_the_same_loop_meets_in_every_phase_of_the_common_measure() -> None:
    square = [(0, 0), (8, 0), (8, 8), (0, 8), (0, 0)]
    m = mission(DiscSensor(radius_m=1.0))
    # periods 32 and 64: seen at 3..5 (mod 32) and, at half speed, at 6..10 (mod 64): gaps 1, 25, 30 -> after joining
    pair = plan(m, route(square), route(square, speed=0.5, robot="b"))
    assert worst_gaps_s(pair, np.array([[4.0, 0.0]])) == pytest.approx(30.0)
    # incommensurable: as bad as the better of the two alone
    pair = plan(m, route(square), route(square, speed=1 / math.sqrt(2), robot="b"))
    assert worst_gaps_s(pair, np.array([[4.0, 0.0]])) == pytest.approx(30.0)


def test_point_behind_a_wall_is_seen_only_past_its_end() -> None:
    wall = box(-50, 4, 0, 5)
    m = mission(DiscSensor(radius_m=20.0), wall)
    line = [(-10, 0), (10, 0), (-10, 0)]
    point = np.array([[-5.0, 10.0]])
    # the sight line over the corner (0, 5) meets y = 0 at x = 5: hidden from -10 up to there and back
    assert worst_gaps_s(plan(m, route(line)), point) == pytest.approx(30.0, rel=1e-6)
    assert worst_gaps_s(plan(m, hold(-2.0, 0.0)), point) == math.inf
    assert worst_gaps_s(plan(m, hold(5.001, 0.0)), point) == 0.0
    hedge = Mission(
        name="m",
        area=m.area,
        fleet=m.fleet,
        period_s=1.0,
        obstacles=(Obstacle(shape=MultiPolygon([wall]), blocks="motion"),),
    )
    assert worst_gaps_s(plan(hedge, hold(-2.0, 0.0)), point) == 0.0


def test_thin_pillar_hides_part_of_a_piece_whose_corners_are_all_in_sight() -> None:
    pillar = box(4.9, -0.01, 5.0, 0.01)
    m = mission(DiscSensor(radius_m=20.0), pillar)
    piece = Pieces(offsets=np.array([0, 4]), corners_m=np.array([[8.0, -1], [9, -1], [9, 1], [8, 1]]))
    held = plan(m, hold(0.0, 0.0))
    assert (worst_gaps_s(held, piece.corners_m) == 0).all()
    assert piece_gaps(sights_of(held, m.area.bounds), piece, np.zeros(1)).gaps_s == math.inf
    aside = plan(m, hold(0.0, 3.0))
    assert piece_gaps(sights_of(aside, m.area.bounds), piece, np.zeros(1)).gaps_s == 0.0


def test_what_hides_the_tip_of_a_long_piece_may_lie_farther_from_its_middle_than_robots_see() -> None:
    m = mission(DiscSensor(radius_m=10.0), box(21.65, 0.2, 21.75, 0.3))
    piece = Pieces(offsets=np.array([0, 3]), corners_m=np.array([[3.5, 0], [22.5, 0], [3.5, 0.2]]))
    assert piece_gaps(sights_of(plan(m, hold(13.0, 3.0)), m.area.bounds), piece, np.zeros(1)).gaps_s == math.inf
    assert piece_gaps(sights_of(plan(m, hold(13.0, -2.9)), m.area.bounds), piece, np.zeros(1)).gaps_s == 0.0


def test_piece_beside_a_wall_and_a_robot_that_touches_it_see_each_other() -> None:
    block = box(0, -10, 10, 0)
    m = mission(DiscSensor(radius_m=30.0), block)
    piece = Pieces(offsets=np.array([0, 4]), corners_m=np.array([[4.0, 0], [5, 0], [5, 1], [4, 1]]))
    for x, y, gap in [
        (-3, 0, 0),
        (0, 0, 0),
        (10, 0, 0),
        (12, 0, 0),
        (2, 0, 0),
        (-3, -0.01, math.inf),
        (10, -5, math.inf),
    ]:
        held = plan(m, hold(x, y))
        assert piece_gaps(sights_of(held, m.area.bounds), piece, np.zeros(1)).gaps_s == gap, (x, y)


def test_route_round_a_corner_of_an_obstacle_sees_both_sides_in_turn() -> None:
    block = box(0, -10, 10, 0)
    m = mission(DiscSensor(radius_m=30.0), block)
    around = route([(0, 0), (10, 0), (10, -10), (0, -10), (0, 0)])
    above = Pieces(offsets=np.array([0, 4]), corners_m=np.array([[4.0, 1], [5, 1], [5, 2], [4, 2]]))
    # seen from the upper side alone: 10 s of 40
    assert piece_gaps(sights_of(plan(m, around), m.area.bounds), above, np.zeros(1)).gaps_s == pytest.approx(30.0)


def test_square_sensor_sees_a_strip_with_exact_edges() -> None:
    m = mission(SquareSensor(side_m=2.0))
    line = plan(m, route([(0, 0), (10, 0), (0, 0)]))
    gaps = worst_gaps_s(line, np.array([[5.0, 0.999], [5.0, 1.001], [10.9, 0.0], [11.001, 0.0], [2.0, -0.5]]))
    # seen at x = 4..6 both ways; at 10.9 from 9.9 on; at 2 from 1 to 3
    np.testing.assert_allclose(gaps, [8.0, math.inf, 19.8, math.inf, 14.0], rtol=1e-9)
    diagonal = plan(m, route([(0, 0), (10, 10), (0, 0)]))
    assert worst_gaps_s(diagonal, np.array([[5.0, 6.5]])) == pytest.approx(2 * 5.5 * math.sqrt(2))


def test_piece_is_judged_by_its_last_corner_in_and_its_first_out() -> None:
    m = mission(SquareSensor(side_m=2.0))
    piece = Pieces(offsets=np.array([0, 4]), corners_m=np.array([[4.5, 0], [5.5, 0], [5.5, 0.5], [4.5, 0.5]]))
    found = piece_gaps(sights_of(plan(m, route([(0, 0), (10, 0), (0, 0)])), m.area.bounds), piece, np.zeros(1))
    assert found.gaps_s == pytest.approx(9.0, abs=1e-6)
    assert found.firsts_s == pytest.approx(4.5, abs=1e-6)
    assert found.begins_s % 20 == pytest.approx(15.5, abs=1e-6)


def test_sight_across_the_seam_of_a_loop_is_one_sight() -> None:
    m = mission(DiscSensor(radius_m=1.0))
    ring = [(4, 0), (8, 0), (8, 8), (0, 8), (0, 0), (4, 0)]
    assert worst_gaps_s(plan(m, route(ring)), np.array([[4.0, 0.0]])) == pytest.approx(30.0)


def test_what_is_seen_only_before_the_loop_counts_as_first_sight_and_not_for_the_gap() -> None:
    m = mission(DiscSensor(radius_m=1.0))
    trajectory = Trajectory(
        robot="a", times_s=[0, 10, 12, 14], positions_m=[(0, 0), (10, 0), (12, 0), (10, 0)], loop_start_s=10
    )
    piece = Pieces(offsets=np.array([0, 1]), corners_m=np.array([[3.0, 0.0]]))
    found = piece_gaps(sights_of(plan(m, trajectory), m.area.bounds), piece, np.zeros(1))
    assert found.gaps_s == math.inf
    assert found.firsts_s == pytest.approx(2.0)


def test_no_robots_and_no_points() -> None:
    m = mission(DiscSensor(radius_m=1.0))
    assert np.isinf(worst_gaps_s(plan(m), np.zeros((3, 2)))).all()
    assert worst_gaps_s(plan(m, hold(0, 0)), np.empty((0, 2))).shape == (0,)


def test_far_from_the_origin_the_answers_stay() -> None:
    far = np.array([5e5, 5.3e6])
    m = mission(DiscSensor(radius_m=2.0))
    moved = Mission(name="m", area=MultiPolygon([box(*(far - 100), *(far + 100))]), fleet=m.fleet, period_s=1.0)
    line = np.array([(0.0, 0.0), (10.0, 0.0), (0.0, 0.0)])
    points = np.array([[5.0, 1.0], [3.0, 0.0]])
    near, there = worst_gaps_s(plan(m, route(line)), points), worst_gaps_s(plan(moved, route(line + far)), points + far)
    np.testing.assert_allclose(there, near, atol=1e-6)


def test_loops_share_a_period_up_to_a_denominator_of_64() -> None:
    classes, parts, units = commensurable_classes([10.0, 15.0, 10.0 * 65 / 64, 10.0 * math.pi, 0.0, 20 * (1 + 5e-10)])
    assert classes.tolist() == [0, 0, 0, 1, 2, 0]
    np.testing.assert_allclose(parts[[0, 1, 2, 5]] * units[0], [10, 15, 10 * 65 / 64, 20], rtol=1e-9)
    assert commensurable_classes([10.0, 10.0 * 66 / 65])[0].tolist() == [0, 1]
    assert commensurable_classes([10.0, 15.0 * (1 + 3e-9)])[0].tolist() == [0, 1]


@pytest.mark.parametrize("ratios", [(1.0,), (1.0, 1.5, 3.0), (1.0, 63 / 64)])
def test_a_chain_of_loops_that_are_nearly_alike_is_no_class(ratios: tuple[float, ...]) -> None:
    # neighbours miss their ratio by 9e-10, which is allowed; the first and the last by 3.6e-7
    durations_s = np.array([20 * ratios[k % len(ratios)] * (1 + 9e-10 * k) for k in range(401)])
    classes, parts, _ = commensurable_classes(durations_s)
    of_one_part_s = durations_s / parts
    for one in np.unique(classes):
        inside = of_one_part_s[classes == one]
        assert inside.max() - inside.min() <= 1.001e-9 * inside.min()
    assert classes[0] == classes[1]  # unlike what lies further apart
    assert classes[0] != classes[-1]


def test_loops_of_whole_steps_share_a_period_whatever_their_ratio() -> None:
    step_s = 0.3 * math.sqrt(2) / 0.3
    steps = np.array([84, 0, 25, 62])
    classes, parts, units = classes_in_step(steps * step_s, steps * step_s)
    assert classes[[0, 2, 3]].tolist() == [0, 0, 0]
    assert classes[1] != 0
    assert parts[[0, 2, 3]].tolist() == [84, 25, 62]
    assert units[0] == pytest.approx(step_s, rel=1e-15)
    # a way of 1e6 s to a loop rounds its times: 1e6 s * 2e-16 is more than 1e-14 of 35 s
    rounded = np.array([1e6 + 84 * step_s - 1e6, 25 * step_s])
    assert classes_in_step(rounded, np.array([1e6, 25 * step_s]))[0].tolist() == [0, 0]
    # what is off by more than rounding would meet in every phase some day
    off = np.array([6501 * step_s * (1 + 1e-12), 2500 * step_s])
    assert classes_in_step(off, off)[0].tolist() == [0, 1]
    fine = np.array([6501, 2500]) * step_s
    assert classes_in_step(fine, fine)[0].tolist() == [0, 0]


def test_visits_count_the_border_of_the_zone() -> None:
    zone = box(2, 0, 4, 2)
    m = mission(DiscSensor(radius_m=1.0))
    through = routes_of(plan(m, route([(0, 1), (10, 1), (0, 1)])))
    inside = visits(through.legs_m, zone, 1e-9)
    assert inside == [(0, 0.2, 0.4), (1, 0.6, 0.8)]
    assert loop_gap(through, inside)[0] == pytest.approx(12.0)
    along = routes_of(plan(m, route([(0, 2), (10, 2), (0, 2)])))
    assert loop_gap(along, visits(along.legs_m, zone, 1e-9))[0] == pytest.approx(12.0)
    corner = routes_of(plan(m, route([(0, 4), (6, -2), (0, 4)])))
    assert loop_gap(corner, visits(corner.legs_m, box(2, -1, 2.5, 2), 1e-9))[0] <= corner.durations_s[0]
    touch = routes_of(plan(m, route([(1, 3), (3, 1), (1, 3)])))
    assert loop_gap(touch, visits(touch.legs_m, box(0, 0, 2, 2), 1e-9))[0] == pytest.approx(2 * math.sqrt(2))
    past = routes_of(plan(m, route([(0, 2.001), (10, 2.001), (0, 2.001)])))
    assert loop_gap(past, visits(past.legs_m, zone, 1e-9))[0] == math.inf
    stay = routes_of(plan(m, hold(2.0, 0.0)))
    assert loop_gap(stay, visits(stay.legs_m, zone, 1e-9))[0] == 0.0


@pytest.mark.parametrize("size", [0.3, 0.7, 5.0])
def test_pieces_tile_the_region_exactly_and_so_do_their_quarters(size: float) -> None:
    region = (
        box(0, 0, 7, 5).difference(Polygon([(1, 1), (3, 1.5), (2.2, 2), (3, 4), (1, 3.5)])).difference(box(5, 2, 6, 3))
    )
    pieces = convex_pieces(region, size, 1e-9)
    assert pieces.areas_m2().sum() == pytest.approx(region.area, rel=1e-12)
    shapes = [Polygon(pieces.choose(np.array([k])).corners_m) for k in range(len(pieces))]
    assert all(s.convex_hull.area == pytest.approx(s.area, rel=1e-9) for s in shapes)
    assert sum(s.difference(region.buffer(1e-9)).area for s in shapes) < 1e-9
    cuts = np.full((len(pieces), 3), np.nan)
    cuts[::3] = [0.6, 0.8, 0.0]
    cuts[::3, 2] = pieces.centres_m()[::3] @ [0.6, 0.8]
    parts, parents = quarter(pieces, cuts, 1e-9)
    assert parts.areas_m2().sum() == pytest.approx(region.area, rel=1e-9)
    np.testing.assert_allclose(np.bincount(parents, parts.areas_m2()), pieces.areas_m2(), rtol=1e-6)
    both = join([pieces, parts])
    assert len(both) == len(pieces) + len(parts)
    assert both.areas_m2().sum() == pytest.approx(2 * region.area, rel=1e-9)
