"""Single flights and the loops that they serve, beside plans by hand."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from tests.relieved import FLIGHT_S, SQUARE_M, TURN_S, relieved

from rota.check import check_plan
from rota.errors import PlanError
from rota.model.plan import Charge, Plan, Trajectory
from rota.routes.flights import ends_on_charger, flights_of, plan_of_flights
from rota.routes.moments import go_on
from rota.routes.served_loops import service_of


def open_flight(places: list[tuple[float, float]], round_s: float = 1000) -> Trajectory:
    """From the first place at 1 m/s through the others, for 300 s where one comes twice; then on the charger."""
    steps_s = [float(np.hypot(b[0] - a[0], b[1] - a[1])) or 300.0 for a, b in itertools.pairwise(places)]
    times_s = [0.0, *np.cumsum(steps_s).tolist(), round_s]
    stay = Charge(charger="pad", from_s=times_s[-2], until_s=round_s)
    return Trajectory(robot="robot-1", times_s=times_s, positions_m=[*places, places[0]], charges=(stay,))


def loops(*robots: Trajectory) -> list[list[tuple[float, float]]]:
    service = service_of([flight for robot in robots for flight in flights_of(robot)])
    return [[(round(x, 9), round(y, 9)) for x, y in loop.line_m.tolist()] for loop in service.loops]


def test_flights_begin_and_end_where_the_plan_says() -> None:
    plan = relieved(3)
    assert check_plan(plan).verdict == "met"
    for k, trajectory in enumerate(plan):
        (flight,) = flights_of(trajectory)
        # the third one has taken off before time 0
        assert flight.starts_s == pytest.approx([0, TURN_S, -TURN_S][k])
        assert (flight.lasts_s, flight.every_s, flight.charges_s) == pytest.approx((FLIGHT_S, 480, 300))
        assert (flight.from_charger, flight.charger, flight.number) == ("pad", "pad", 1)
        # the loop's seam is no point of it
        assert len(flight.times_s) == 11
        np.testing.assert_allclose(flight.positions_m[[0, 1, -1]], [(0, 0), SQUARE_M[0], (0, 0)], atol=1e-9)


@pytest.mark.parametrize("at_s", [33.0, 45.0, 52.0])  # while it speeds up, at full speed, and while it brakes
def test_a_loop_that_begins_on_a_leg_with_an_acceleration_has_the_same_flight(at_s: float) -> None:
    out = Trajectory(
        robot="a", times_s=[0, 30, 40, 50, 60], positions_m=[(0, 0), (0, 0), (10, 0), (10, 20), (0, 0)],
        accelerations_m_s2=[0, 0.2, 0, -0.1], charges=(Charge(charger="pad", from_s=0, until_s=30),),
    )  # fmt: skip
    (whole,), (cut,) = flights_of(out, accelerated=True), flights_of(go_on(out, at_s), accelerated=True)
    np.testing.assert_allclose(cut.times_s, whole.times_s, atol=1e-9)
    np.testing.assert_allclose(cut.positions_m, whole.positions_m, atol=1e-9)
    np.testing.assert_allclose(cut.accelerations_m_s2, whole.accelerations_m_s2, atol=1e-9)


def test_what_is_flown_before_the_loop_is_flown_once() -> None:
    times_s = [0, 10, 20, 50, 60, 70, 100]
    places = [(5, 0), (5, 10), (0, 0), (0, 0), (10, 0), (0, 0), (0, 0)]
    charges = (Charge(charger="pad", from_s=20, until_s=50), Charge(charger="pad", from_s=70, until_s=100))
    one = Trajectory(robot="a", times_s=times_s, positions_m=places, charges=charges, loop_start_s=20)
    first, second = flights_of(one)
    assert (first.starts_s, first.every_s, first.lasts_s, first.from_charger) == (0, 0, 20, None)
    assert (second.starts_s, second.every_s, second.lasts_s, second.from_charger) == (50, 80, 20, "pad")
    assert (first.charges_s, second.charges_s) == (30, 60)


def test_a_robot_that_comes_to_no_charger_has_no_flights() -> None:
    times_s, places = [0, 30, 40, 50], [(0, 0), (0, 0), (10, 0), (0, 0)]
    once = Charge(charger="pad", from_s=0, until_s=30)
    gone = Trajectory(robot="a", times_s=times_s, positions_m=places, charges=(once,), loop_start_s=30)
    with pytest.raises(PlanError, match="robot a: from 30 s on it comes to no charger; it has no single flights"):
        flights_of(gone)
    rests = Trajectory(robot="a", times_s=[0, 9], positions_m=[(0, 0)] * 2, charges=(replace(once, until_s=9),))
    assert flights_of(rests) == ()


def test_a_plan_of_flights_is_a_plan_whose_robots_land_and_stay() -> None:
    plan = relieved(3)
    listed = replace(plan.mission.fleet, robots=3)
    for mission in (plan.mission, replace(plan.mission, fleet=listed)):
        made, flights = plan_of_flights(replace(plan, mission=mission))
        assert [one.robot for one in made] == ["robot-1.1", "robot-2.1", "robot-3.1"]
        assert all(ends_on_charger(one) for one in made)
        assert made.mission.fleet.robot("robot-2.1").battery.endurance_s == 400
        assert [flight.robot for flight in flights] == ["robot-1", "robot-2", "robot-3"]


def test_whole_rounds_are_told_from_the_ways_and_counted_once() -> None:
    service = service_of([flight for one in relieved(3) for flight in flights_of(one)])
    (loop,) = service.loops
    np.testing.assert_allclose(loop.line_m, SQUARE_M, atol=1e-9)
    assert loop.round_s == pytest.approx(80)
    assert service.serves == (0, 0, 0)
    assert [way.tolist() for way in service.ways_m] == [[[0, 0], [10, 0]]]


def test_parts_of_a_round_that_robots_share_out_make_one_loop() -> None:
    # from corner to corner of a square round the charger: each goes on where another one ends
    one = open_flight([(0, 0), (10, 10), (-10, 10), (-10, -10), (0, 0)])
    other = replace(open_flight([(0, 0), (-10, -10), (10, -10), (10, 10), (0, 0)]), robot="robot-2")
    assert loops(one, other) == [[(10, 10), (-10, 10), (-10, -10), (10, -10), (10, 10)]]


def test_loops_to_and_fro_and_places_where_robots_stand_are_served_too() -> None:
    assert loops(open_flight([(0, 0), (10, 0), (10, 50), (10, 0), (0, 0)])) == [[(10, 0), (10, 50), (10, 0)]]
    assert loops(open_flight([(0, 0), (10, 0), (10, 0), (0, 0)])) == [[(10, 0)]]
    assert loops(open_flight([(0, 0), (10, 50), (0, 0)])) == [[(0, 0), (10, 50), (0, 0)]]


def test_the_same_loop_is_one_wherever_robots_come_to_it() -> None:
    ring = [(10, 0), (30, 0), (30, 20), (10, 20)]
    turned = [*ring[2:], *ring[:2], ring[2]]
    one = open_flight([(0, 0), *ring, ring[0], (0, 0)])
    other = replace(open_flight([(0, 0), *turned, (0, 0)]), robot="robot-2")
    assert len(loops(one, other)) == 1
    flights = Plan(mission=relieved(3).mission, trajectories=(one, other))
    (loop,) = service_of([flight for robot in flights for flight in flights_of(robot)]).loops
    assert loop.handovers_m.tolist() == [[10, 0], [30, 20]]
    assert loop.robots == ("robot-1", "robot-2")
