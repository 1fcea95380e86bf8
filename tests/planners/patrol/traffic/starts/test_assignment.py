"""The earliest latest arrival and the order of leaving: against brute force over all assignments and by hand."""

import itertools

import numpy as np
import pytest
from shapely import box

from rota.model.mission import DiscSensor, Fleet, StartBox
from rota.planners.patrol.driving.timed_line import steady
from rota.planners.patrol.traffic.starts.approaches import Approach, joined_trajectory, timed_approach
from rota.planners.patrol.traffic.starts.assignment import earliest_assignment
from rota.planners.patrol.traffic.starts.departures import apart, approaches_that_meet, departures_s, order_of_leaving
from rota.planners.patrol.traffic.starts.places import spread_in_box


@pytest.mark.parametrize("seed", range(20))
def test_the_latest_arrival_is_as_early_as_any_assignment_has_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    loops = int(rng.integers(1, 5))
    times = rng.integers(1, 12, (loops + int(rng.integers(0, 3)), loops)).astype(float)
    times[rng.random(times.shape) < 0.3] = np.inf
    every = list(itertools.permutations(range(len(times)), loops))
    best = min(
        (max(times[k, i] for i, k in enumerate(who)), sum(times[k, i] ** 2 for i, k in enumerate(who))) for who in every
    )
    found = earliest_assignment(times)
    if np.isinf(best[0]):
        assert found is None
        return
    assert found is not None
    chosen = times[found, np.arange(loops)]
    assert (chosen.max(), (chosen**2).sum()) == best
    assert len(set(found.tolist())) == loops


def way(*places: tuple[float, float], speed: float = 1.0) -> Approach:
    robot = Fleet(speed_m_s=speed, sensor=DiscSensor(radius_m=1)).equal_robot("r")
    return timed_approach(np.array(places, dtype=np.float64), robot)


def test_robots_in_a_row_leave_front_first() -> None:
    # all go east along one line: the front one must leave and go farthest
    ways = [way((k, 0), (10 + 2 * k, 0)) for k in range(3)]
    assert order_of_leaving(ways, [0.4] * 3, approaches_that_meet(ways, [0.4] * 3)) == [2, 1, 0]
    leaves = departures_s(ways, [0.4] * 3)
    assert leaves is not None
    for i, j in itertools.combinations(range(3), 2):
        assert apart(ways[i], ways[j], leaves[i], leaves[j], 0.8)


def test_two_who_must_change_places_in_a_corridor_cannot() -> None:
    assert departures_s([way((0, 0), (5, 0)), way((5, 0), (0, 0))], [0.4, 0.4]) is None
    assert departures_s([way((0, 0), (5, 0)), way((5, 0), (0, 0))], [0.0, 0.0]) is not None


def test_ways_that_cross_are_driven_one_after_the_other() -> None:
    # both would be in the middle at the same moment
    ways = [way((-5, 0), (5, 0)), way((0, -5), (0, 5))]
    assert not apart(ways[0], ways[1], 0, 0, 1.0)
    leaves = departures_s(ways, [0.5, 0.5])
    assert leaves is not None
    # crossing at right angles at one speed: sqrt(2) m on the way are 1 m apart
    assert abs(leaves[0] - leaves[1]) == pytest.approx(2**0.5, abs=0.05)
    assert apart(ways[0], ways[1], leaves[0], leaves[1], 1.0)


def test_a_box_is_filled_to_the_last_place() -> None:
    # centres of discs of radius 0.5 in 4 m by 4 m and a little more, standing space inset by the body
    room, free = StartBox(low_m=(0, 0), high_m=(4.01, 4.01)), box(0.5, 0.5, 20, 20)
    for robots in (1, 4, 16, 40):
        places = spread_in_box(room, free, robots, 0.5)
        # Oler 1961: no more than 2 / sqrt(3) of the area, half the border and one fit at distances of 1
        assert len(places) == robots or (robots == 40 and 16 <= len(places) <= 22)
        gaps = [np.hypot(*(a - b)) for a, b in itertools.combinations(places, 2)]
        assert min(gaps, default=9) >= 1.0
    assert len(spread_in_box(room, box(10, 10, 20, 20), 1, 0.5)) == 0
    # no body and no width: places of their own all the same
    line = spread_in_box(StartBox(low_m=(2, 1), high_m=(2, 4)), free, 5, 0.0)
    assert len({tuple(place) for place in line.tolist()}) == 5
    assert (line[:, 0] == 2).all()


def test_a_robot_waits_then_goes_then_waits_for_the_others() -> None:
    one_round = steady(np.array([0.0, 1, 2]), np.array([[3.0, 4], [4, 4], [3, 4]]))
    trajectory = joined_trajectory("r", way((0, 0), (3, 4)), 2.0, 10.0, one_round)
    assert trajectory.times_s == pytest.approx([0, 2, 7, 10, 11, 12], rel=2e-6)
    assert trajectory.loop_start_s == 10
    assert (trajectory.loop_length_m, trajectory.loop_duration_s) == (2, 2)
    # there already, and nobody to wait for
    still = joined_trajectory("r", way((3, 4)), 0.0, 0.0, one_round)
    assert still.loop_start_s == 0
    assert len(still.times_s) == 3


def test_a_way_that_ends_beside_its_loop_by_rounding_leaves_the_loop_closed() -> None:
    """As paths do: their last point may be off the place where the loop begins by the last bit of a number."""
    round_ = steady(
        np.array([0.0, 4, 8]), np.array([[22.8775, 3.987499999999999], [26.8775, 3.9875], [22.8775, 3.987499999999999]])
    )
    approach = Approach(line=steady(np.array([0.0, 2]), np.array([[20.8775, 3.9875], [22.8775, 3.9875]])))
    joined = joined_trajectory("a", approach, 0.0, 2.0, round_)
    assert (joined.positions_m[-1] == joined.positions_m[1]).all()
    assert joined.loop_duration_s == 8


@pytest.mark.parametrize("aside_m", [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3])
def test_hardly_any_turn_into_a_loop_takes_no_time_or_time_that_is_told_apart_later(aside_m: float) -> None:
    robot = Fleet(speed_m_s=1, turn_rate_rad_s=3, sensor=DiscSensor(radius_m=1)).equal_robot("r")
    approach = timed_approach(np.array([[0.0, 1], [2, 1]]), robot, onward_m=np.array([3.0, 1 + aside_m]))
    round_ = steady(np.array([0.0, 2, 4]), np.array([[2.0, 1], [3, 1 + aside_m], [2, 1]]))
    for leaves_s in (0.0, 0.46389066913645394, 1e5):
        joined = joined_trajectory("r", approach, leaves_s, leaves_s + approach.duration_s, round_)
        assert joined.loop_start_s == pytest.approx(leaves_s + 2 + aside_m / 3, rel=2e-6)
