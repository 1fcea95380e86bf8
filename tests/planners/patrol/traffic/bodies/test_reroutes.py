"""Routes led another way where no timing keeps bodies apart, against distances simulated in small steps."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from shapely import LineString, MultiPolygon, Polygon, box
from tests.planners.patrol.traffic.bodies.driving import BODY_M, closest_m, fastest_m_s, tour

from rota.geometry.shortest_path import ShortestPaths
from rota.planners.patrol.tours.tour import Tour, tour_length_m
from rota.planners.patrol.traffic.bodies.lanes import in_lanes, round_those_who_stay
from rota.planners.patrol.traffic.bodies.reroutes import change_over, cut_in_two, reroute
from rota.planners.patrol.traffic.bodies.timing import can_be_timed, timed_rounds

NARROW = box(-1, -0.6, 21, 0.6)  # robots of half a metre cannot pass each other
WIDE = box(-1, -1.2, 21, 1.2)  # here they can


def space_of(ground: Polygon) -> MultiPolygon:
    return MultiPolygon([ground.buffer(-BODY_M, join_style="mitre")])


def lead_apart(ground: Polygon, tours: Sequence[Tour], *, may_add: bool = False) -> list[Tour] | None:
    space = space_of(ground)
    return reroute(tours, BODY_M, space, ShortestPaths(space), may_add=may_add)


def assert_drivable(ground: Polygon, tours: Sequence[Tour]) -> None:
    space = space_of(ground).buffer(1e-9)
    for one in tours:
        assert tour_length_m(one) <= one.budget_m
        if len(one.vertices_m) > 1:
            assert space.covers(LineString(np.vstack([one.vertices_m, one.vertices_m[:1]])))
    rounds = timed_rounds(tours, BODY_M)
    assert closest_m(rounds, 8 * max(float(times[-1]) for times, *_ in rounds)) >= 2 * BODY_M
    assert fastest_m_s(rounds) <= 1


def test_a_loop_that_two_robots_share_there_and_back_becomes_two_lanes() -> None:
    # one behind the other on one line there and back: they meet head on, however they are timed
    shared = [tour([(0, 0), (20, 0)], 25.0, robots=2)]
    assert not can_be_timed(shared, BODY_M)
    found = lead_apart(WIDE, shared)
    assert found is not None
    assert [one.robots for one in found] == [2]
    assert_drivable(WIDE, found)
    # lanes two bodies apart, and a tenth more; each as long as the line, and the way across at either end
    across = 2 * BODY_M * 1.1
    assert np.abs(found[0].vertices_m[:, 1]).max() == pytest.approx(across / 2, abs=0.02)
    assert 40.0 < tour_length_m(found[0]) <= 40.0 + 2 * across


def test_lanes_bend_with_the_ground_and_keep_right() -> None:
    ground = box(-1.15, -1.15, 21.15, 1.15) | box(18.85, -1.15, 21.15, 15)
    space = space_of(ground)
    shared = [tour([(0, 0), (20, 0), (20, 14), (20, 0)], 40.0, robots=2)]
    (one,) = in_lanes(shared, BODY_M, space, ShortestPaths(space))
    assert_drivable(ground, [one])
    # out along the lower side and up along the right one, back on the left and above: the corner's lanes differ
    assert tour_length_m(one) == pytest.approx(68.0 + 2 * 1.1, abs=2.0)
    ends = np.vstack([one.vertices_m[1:], one.vertices_m[:1]])
    east = (ends - one.vertices_m)[:, 0] > 5
    west = (ends - one.vertices_m)[:, 0] < -5
    assert one.vertices_m[east, 1] == pytest.approx(-0.55, abs=0.02)
    assert one.vertices_m[west, 1] == pytest.approx(0.55, abs=0.02)
    assert east.any()
    assert west.any()


def test_two_robots_that_come_towards_each_other_get_a_lane_each() -> None:
    # each goes to and fro on the whole line without time to wait: only side by side can they pass
    tours = [tour([(0, 0), (20, 0)], 44.0), tour([(20, 0), (0, 0)], 44.0)]
    assert not can_be_timed(tours, BODY_M)
    found = lead_apart(WIDE, tours)
    assert found is not None
    assert [one.robots for one in found] == [1, 1]
    assert_drivable(WIDE, found)


def test_a_loop_that_robots_share_in_a_narrow_corridor_is_cut() -> None:
    for robots, period_s in ((2, 25.0), (3, 16.0), (4, 12.0)):
        found = lead_apart(NARROW, [tour([(0, 0), (20, 0)], period_s, robots=robots)])
        assert found is not None
        assert [one.robots for one in found] == [1] * robots
        assert_drivable(NARROW, found)
        # the pieces lie one behind the other, and together on all of the line
        ends = sorted((float(one.vertices_m[:, 0].min()), float(one.vertices_m[:, 0].max())) for one in found)
        assert ends[0][0] == 0
        assert ends[-1][1] == 20
        assert all(before[1] >= after[0] - 0.2 for before, after in pairwise(ends))


def test_a_cut_keeps_the_lines_and_the_budgets() -> None:
    paths = ShortestPaths(space_of(NARROW))
    shared = tour([(0, 0), (20, 0)], 15.0, robots=3)
    cuts = list(cut_in_two(shared, BODY_M, paths))
    assert cuts
    for one, other in cuts:
        assert one.robots + other.robots == 3
        assert tour_length_m(one) + tour_length_m(other) == pytest.approx(40.0, abs=2 * BODY_M)
        assert tour_length_m(one) <= one.robots * 15.0
        assert tour_length_m(other) <= other.robots * 15.0
    assert list(cut_in_two(tour([(0, 0), (20, 0)], 40.0), BODY_M, paths)) == []  # one robot is not two


def test_loops_that_run_through_each_other_change_over() -> None:
    # two rings that share a side, each with a tail into the other's ground along that side
    paths = ShortestPaths(space_of(box(-12, -6, 12, 6)))
    a = tour([(-10, -5), (2, -5), (2, 5), (-10, 5)], 60.0)
    b = tour([(-2, -5), (10, -5), (10, 5), (-2, 5)], 60.0)
    pairs = list(change_over(a, b, 2 * BODY_M, paths))
    assert pairs
    for one, other in pairs:
        assert (one.robots, other.robots) == (1, 1)
        assert tour_length_m(one) + tour_length_m(other) == pytest.approx(88.0, abs=6.0)
    assert list(change_over(a, tour([(30, 0), (40, 0)], 60.0), 2 * BODY_M, paths)) == []


def test_a_tour_goes_round_a_robot_that_stays() -> None:
    tours = [tour([(0, 0), (20, 0)], 44.0), tour([(10, 0)], 44.0)]
    ground = box(-1, -3, 21, 3)
    assert not can_be_timed(tours, BODY_M)
    found = lead_apart(ground, tours)
    assert found is not None
    assert [one.robots for one in found] == [1, 1]
    assert_drivable(ground, found)
    moved = next(one for one in found if len(one.vertices_m) > 1)
    # tangents to a disc of 1.1 m, and its arc, there and back: the shortest way round, but for the disc's corners
    radius = 1.1
    shortest = 2 * (2 * (10**2 - radius**2) ** 0.5 + 2 * radius * np.arcsin(radius / 10))
    assert shortest <= tour_length_m(moved) <= 1.1 * shortest


def test_a_robot_that_stays_in_a_corridor_parts_those_who_come_past() -> None:
    tours = [tour([(0, 0), (20, 0)], 44.0), tour([(10, 0)], 44.0)]
    assert lead_apart(NARROW, tours) is None  # with one robot on either side, that is one more
    found = lead_apart(NARROW, tours, may_add=True)
    assert found is not None
    assert sorted(one.robots for one in found) == [1, 1, 1]
    assert_drivable(NARROW, found)
    assert round_those_who_stay(tours[:1], BODY_M, space_of(NARROW)) is None


def test_there_is_no_other_way_for_robots_that_do_not_fit() -> None:
    crammed = [tour([(0, 0)], 40.0), tour([(0.5, 0)], 40.0), tour([(0, 0), (1, 0)], 40.0)]
    assert lead_apart(box(-0.6, -0.6, 1.6, 0.6), crammed, may_add=True) is None
