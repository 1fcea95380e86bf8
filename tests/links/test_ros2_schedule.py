"""When robots on ROS 2 are to be where, worked out by hand."""

from __future__ import annotations

import pytest
from tests.links.fleets import ALTITUDE_M, loop_of, plan_of, routes_of, staying

from rota.links.link import Order
from rota.links.ros2_route import TimedPath, timed_path
from rota.links.ros2_schedule import Schedule

# 10 m until 2 s, then every 43 s: 60 m until 17 s, there until 20 s, 20 m until 25 s, 60 m until 40 s, 20 m until 45 s
LOOP = timed_path(routes_of(plan_of(loop_of("a", 0.0)))[0])
ZERO_S = 1000.0
ON_FOR_30_S = [(32, 0), (60, 0), (60, 0), (60, 20), (0, 20)]


def told(
    time_s: float,
    *,
    late_s: float = 0.0,
    behind_s: float = 0.0,
    rate: float = 1.0,
    top_m_s: float | None = 8.0,
    path: TimedPath = LOOP,
) -> tuple[list[tuple[float, float]], list[float], float]:
    """Places, instants and the start that the schedule has, less ``ZERO_S``."""
    order = Order(robot="a", late_s=late_s, behind_s=behind_s, rate=rate)
    ahead = Schedule(path, top_m_s).ahead(order, time_s, ZERO_S)
    assert {place[2] for place in ahead.places_m} == {ALTITUDE_M}
    places = [(round(x, 6), round(y, 6)) for x, y, _ in ahead.places_m]
    return places, [time_ns / 1e9 - ZERO_S for time_ns in ahead.times_ns], ahead.loop_ns / 1e9 - ZERO_S


@pytest.mark.parametrize(("rounds", "behind_s"), [(0, 0.0), (1, 0.0), (3, 2.5)])
def test_a_robot_in_time_is_told_the_plans_times_in_any_round(rounds: int, behind_s: float) -> None:
    now_s = 10 + 43 * rounds + behind_s
    places, times_s, start_s = told(now_s, behind_s=behind_s)
    assert places == ON_FOR_30_S
    assert times_s == pytest.approx([now_s, now_s + 7, now_s + 10, now_s + 15, now_s + 30])
    assert start_s == pytest.approx(behind_s)


def test_stamps_are_farther_apart_where_all_go_more_slowly() -> None:
    places, times_s, start_s = told(10, rate=0.8)
    assert places == ON_FOR_30_S
    assert times_s == pytest.approx([10, 18.75, 22.5, 28.75, 47.5])
    assert start_s == pytest.approx(7.5)


def test_one_that_is_late_hurries_as_far_as_it_can_and_does_not_wait() -> None:
    places, times_s, start_s = told(14, late_s=10)
    assert places == [(8, 0), (60, 0), (60, 0), (60, 20), (0, 20), (0, 4)]
    # 52 m at 8 m/s, no wait, and with the 20 m after it it is in time again
    assert times_s == pytest.approx([14, 20.5, 20.5, 25, 40, 44])
    assert start_s == pytest.approx(0)


def test_one_with_mass_drives_as_planned_and_makes_up_its_wait_alone() -> None:
    _, times_s, start_s = told(14, late_s=10, top_m_s=None)
    assert times_s == pytest.approx([14, 27, 27, 32, 47, 51])
    assert start_s == pytest.approx(7)


def test_one_that_is_early_takes_until_its_next_point_is_due() -> None:
    places, times_s, _ = told(10, late_s=-3)
    assert places[:2] == [(44, 0), (60, 0)]
    assert times_s[:2] == pytest.approx([10, 17])


def test_a_robot_that_stays_is_told_to_stay() -> None:
    path = timed_path(routes_of(plan_of(staying("a")))[0])
    assert told(1, path=path)[:2] == ([(5, 60), (20, 60)], pytest.approx([1, 4]))
    places, times_s, _ = told(50, path=path)
    assert (places, times_s) == ([(20, 60)], [50])


def test_one_that_holds_is_told_to_be_where_it_was_first_and_to_go_on_from_there_later() -> None:
    """It hears nothing any more where this program has gone: 30 s later it drives on by its route."""
    schedule = Schedule(LOOP, 8.0)
    for time_s, late_s in ((12.0, 0.0), (13.0, 0.3), (14.0, -0.7)):  # its reports lag, and places are told wrong
        holds = schedule.ahead(Order(robot="a", late_s=late_s, behind_s=time_s - 12.0, rate=0.0), time_s, ZERO_S)
        assert holds.places_m == ((40.0, 0.0, ALTITUDE_M),) * 2
        assert [time_ns / 1e9 - ZERO_S for time_ns in holds.times_ns] == pytest.approx([time_s, time_s + 30])
        assert holds.loop_ns / 1e9 - ZERO_S == pytest.approx(time_s + 30 - 12)
    goes_on = schedule.ahead(Order(robot="a", late_s=0.0, behind_s=3.0, rate=1.0), 15.0, ZERO_S)
    assert goes_on.places_m[:2] == ((40.0, 0.0, ALTITUDE_M), (60.0, 0.0, ALTITUDE_M))
    assert [time_ns / 1e9 - ZERO_S for time_ns in goes_on.times_ns[:2]] == pytest.approx([15, 20])


def test_the_clock_of_a_flight_begins_with_it() -> None:
    """The same route as a flight that begins when the plan is 500 s old, and all are 4 s behind by then."""
    ahead = Schedule(LOOP, 8.0, 500.0).ahead(Order(robot="a", late_s=0.0, behind_s=4.0, rate=1.0), 514.0, ZERO_S)
    assert ahead.places_m[:2] == ((32.0, 0.0, ALTITUDE_M), (60.0, 0.0, ALTITUDE_M))
    assert [time_ns / 1e9 - ZERO_S for time_ns in ahead.times_ns[:2]] == pytest.approx([514, 521])
    assert ahead.loop_ns / 1e9 - ZERO_S == pytest.approx(504)
