"""How vehicles that lose time are led: each is simulated in steps of a tenth of a second, whatever it is told."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, replace

import pytest

from rota.files.vda5050_orders import NumberedStops, Window
from rota.links.vda5050_pace import AHEAD_S, MOST_ROOM_S, Leg, LegTimes, Pace
from rota.model.plan import Trajectory
from rota.routes.route import Route, RouteStop, route_of

STEP_S = 0.1
ZERO_S = 1000.0  # of the clock, when the plan starts


def route(*, speed_m_s: float, holds_s: tuple[float, ...]) -> Route:
    """A square of 10 m, with so long holds at its corners after the first."""
    corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]
    loop = [
        RouteStop(place_m=(x, y, 0.0), speed_m_s=speed_m_s, hold_s=hold_s)
        for (x, y), hold_s in zip(corners, (0.0, *holds_s), strict=True)
    ]
    loop[0] = replace(loop[0], speed_m_s=None)
    closing = RouteStop(place_m=(0.0, 0.0, 0.0), speed_m_s=speed_m_s)
    return Route(robot="a", start_m=(0.0, 0.0, 0.0), approach=(), loop=tuple(loop), closing=closing)


@dataclass
class Vehicle:
    """What a vehicle takes: its pace as a share of what it is told, what it loses, and how it turns."""

    share: float = 1.0
    noise_s: float = 0.0
    turns: float = 0.0
    blocked_s: float = 0.0
    loses_s: float = 0.0

    def leg_s(self, pace: Pace, number: int, rng: random.Random) -> float:
        length_m = math.dist(pace.stops.stop(number - 1).place_m, pace.stops.stop(number).place_m)
        turn_s = self.turns * pace.stops.stop(number - 1).turn_s
        blocked_s = self.blocked_s if number == 10 else 0.0
        speed_m_s = self.share * (pace.told(number).speed_m_s or math.inf)
        return turn_s + self.loses_s + length_m / speed_m_s + abs(rng.gauss(0, self.noise_s)) + blocked_s


def late_s(pace: Pace, vehicle: Vehicle, rounds: int, *, seed: int = 0, with_waits: bool = False) -> list[float]:
    """How late a vehicle is at each stop of so many rounds."""
    rng, window = random.Random(seed), Window(released=2, announced=3)
    pace.release(pace.span(window, with_waits=with_waits).released, ZERO_S - 5, with_waits=with_waits)
    pace.begin(ZERO_S)
    last, since_s, arrives_s, late, now_s = 0, ZERO_S, math.inf, [], ZERO_S
    while last < 4 * rounds:
        now_s += STEP_S
        if now_s >= arrives_s:
            last, since_s, arrives_s = last + 1, now_s, math.inf
            pace.heard(last, now_s)
            late.append(now_s - ZERO_S - pace.arrives_s(last))
        if arrives_s == math.inf and last < pace.end and now_s >= since_s + pace.told(last).wait_s:
            arrives_s = now_s + vehicle.leg_s(pace, last + 1, rng)
        if pace.is_due(last, window, now_s):
            pace.release(pace.span(window, with_waits=with_waits).released, now_s, with_waits=with_waits)
    return late


@pytest.mark.parametrize("with_waits", [False, True], ids=["release", "waits"])
@pytest.mark.parametrize("seed", range(3))
def test_vehicles_that_are_slower_and_lose_time_at_stops_keep_their_phase(seed: int, with_waits: bool) -> None:
    slow = Vehicle(share=0.95, noise_s=0.3)
    for given in (route(speed_m_s=1.0, holds_s=(2.0, 0.0, 2.0)), route(speed_m_s=1.0, holds_s=(0.0, 0.0, 0.0))):
        late = late_s(Pace(NumberedStops(given), 1.5), slow, 10, seed=seed, with_waits=with_waits)
        firsts = sorted(map(abs, late[3::4]))  # the first stop of each round
        assert abs(late[-1]) < 1.0
        # what is lost at the stops that are released already, nobody can foresee
        assert firsts[-2] < 1.0
        assert firsts[-1] < 1.5
    # led by nobody it would be this late: 0.5 s a leg, and 0.24 s a stop
    assert 40 * (10 / 0.95 - 10 + 0.3 * math.sqrt(2 / math.pi)) > 30


@pytest.mark.parametrize("turns", [0.0, 1.0, 2.0])
def test_vehicles_that_turn_in_another_time_than_planned_keep_their_phase(turns: float) -> None:
    stops = NumberedStops(route(speed_m_s=1.0, holds_s=(2.0, 2.0, 2.0)), turn_rate_rad_s=math.pi / 2)
    assert [stop.turn_s for stop in stops.every_round] == [1.0, 1.0, 1.0, 0.0]
    late = late_s(Pace(stops, 1.5), Vehicle(turns=turns), 10)
    assert max(map(abs, late[7::4])) < 0.5


def test_what_cannot_be_made_up_stays_late_and_is_told_to_leave_no_room() -> None:
    pace = Pace(NumberedStops(route(speed_m_s=1.0, holds_s=(0.0, 0.0, 0.0))), 1.0)
    late = late_s(pace, Vehicle(share=0.95), 10)
    assert late[-1] == pytest.approx(40 * (10 / 0.95 - 10), abs=40 * STEP_S)
    assert pace.room_s() == 0.0
    assert Pace(NumberedStops(route(speed_m_s=1.0, holds_s=(2.0, 0.0, 2.0))), 1.25).room_s() == MOST_ROOM_S
    assert Pace(NumberedStops(route(speed_m_s=1.0, holds_s=(0.2, 0.0, 0.3))), 1.0).room_s() == pytest.approx(0.5)


def test_a_vehicle_that_speeds_up_and_brakes_as_planned_is_told_the_plan_s_speeds() -> None:
    given = route(speed_m_s=1.0, holds_s=(0.0, 0.0, 0.0))
    slow = [replace(stop, planned_s=12.0) for stop in (*given.loop, given.closing) if stop is not None]
    pace = Pace(NumberedStops(replace(given, loop=tuple(slow[:-1]), closing=slow[-1])), 1.5)
    late = late_s(pace, Vehicle(loses_s=2.0), 3)
    assert max(map(abs, late)) < 0.3
    assert pace.told(pace.end).speed_m_s == pytest.approx(1.0, abs=0.05)


def test_the_times_of_stops_are_those_of_the_plan_round_after_round() -> None:
    # it waits at the end of its approach for 1 s, and for 3 s more at the end of every round
    way = Trajectory(
        robot="a",
        times_s=[0, 5, 6, 16, 26, 36, 46, 49],
        positions_m=[[-5, 0], [0, 0], [0, 0], [10, 0], [10, 10], [0, 10], [0, 0], [0, 0]],
        loop_start_s=5,
    )
    pace = Pace(NumberedStops(route_of(way, 0.0)), 1.0)
    for number, arrives_s in ((0, 0), (1, 5), (2, 16), (5, 46), (6, 60), (9, 90), (10, 104), (41, 46 + 9 * 44)):
        assert pace.arrives_s(number) == pytest.approx(arrives_s)


def test_the_clock_of_all_may_go_more_slowly() -> None:
    pace = Pace(NumberedStops(route(speed_m_s=1.0, holds_s=(2.0, 0.0, 2.0))), 1.0)
    pace.begin(0.0)
    before = pace.goes_on_s(5)
    pace.behind_s = 1.0
    assert pace.goes_on_s(5) - before == pytest.approx(1.0)


def test_a_vehicle_that_was_blocked_makes_it_up_and_is_not_taken_for_a_slow_one() -> None:
    late = late_s(Pace(NumberedStops(route(speed_m_s=1.0, holds_s=(2.0, 0.0, 2.0))), 1.5), Vehicle(blocked_s=8.0), 6)
    assert late[9] > 7
    assert max(map(abs, late[15:])) < 0.5


def test_what_is_released_ends_where_vehicles_wait_and_lasts_for_some_time() -> None:
    window = Window(released=3, announced=2)
    pace = Pace(NumberedStops(route(speed_m_s=1.0, holds_s=(0.0, 2.0, 0.0))), 1.0)
    # one by one, until something is known of the vehicle
    first = pace.span(window, with_waits=False)
    assert (first.first, first.released, first.last) == (0, 1, 3)
    pace.release(1, 0.0, with_waits=False)
    pace.begin(0.0)
    for number in range(1, 5):
        pace.release(number + 1, 10.0 * number, with_waits=False)
        pace.heard(number, 10.0 * number)
    assert pace.end == 5
    assert pace.span(window, with_waits=False).released == 6  # where it waits
    assert pace.span(window, with_waits=True).released == 8
    quick = Pace(NumberedStops(route(speed_m_s=50.0, holds_s=(0.0, 0.0, 0.0))), 50.0)
    assert quick.arrives_s(quick.span(window, with_waits=False).released) < AHEAD_S
    assert quick.span(window, with_waits=False).released == 4  # a round, more is never in a message


def test_a_vehicle_that_is_early_waits_for_what_comes_next() -> None:
    window = Window(released=1, announced=0)
    pace = Pace(NumberedStops(route(speed_m_s=1.0, holds_s=(0.0, 0.0, 0.0))), 1.0)
    pace.release(1, 0.0, with_waits=False)
    pace.begin(0.0)
    pace.heard(1, 7.0)
    assert not pace.is_due(1, window, 7.0)
    assert not pace.is_due(1, window, 9.0)
    assert pace.is_due(1, window, 10.0)


def test_leg_times_are_learned_as_they_are() -> None:
    rng, times = random.Random(0), LegTimes()
    for _ in range(400):
        leg = Leg(turn_s=rng.choice([0.0, 0.5, 2.0]), drive_s=rng.uniform(1, 20), waits=rng.random() < 0.5)
        times.learn([leg], 0.25 + 1.4 * leg.turn_s + 1.06 * leg.drive_s + 0.4 * leg.waits + rng.gauss(0, 0.1))
    for leg in (Leg(turn_s=0.0, drive_s=10.0, waits=False), Leg(turn_s=2.0, drive_s=3.0, waits=True)):
        told = 0.25 + 1.4 * leg.turn_s + 1.06 * leg.drive_s + 0.4 * leg.waits
        assert times.expected_s(leg) == pytest.approx(told, abs=0.15)
        assert times.drive_s(told, leg.turn_s, leg.waits) == pytest.approx(leg.drive_s, abs=0.15)
