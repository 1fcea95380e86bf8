"""Missions as an ArduCopter flies them: beside recorded flights, and where there is nothing to look up."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from tests.vehicles.recorded import copter, loop_way, recorded_corners, recorded_flights, recorded_tracks

from rota.errors import RotaError
from rota.routes.route import RouteStop
from rota.vehicles.ardupilot_auto import ArduPilotAuto
from rota.vehicles.facts import Vehicle
from rota.vehicles.motion import Motion, Way, Wind

FLIGHTS = recorded_flights()
SQUARE = [(0.0, 0.0), (60.0, 0.0), (60.0, 60.0), (0.0, 60.0)]
STILL = Wind()


def stop(x: float, y: float, height_m: float = 25.0, speed_m_s: float | None = 8.0, hold_s: float = 0.0) -> RouteStop:
    return RouteStop(place_m=(x, y, height_m), speed_m_s=speed_m_s, hold_s=hold_s)


def once(*stops: RouteStop, vehicle: Vehicle | None = None) -> Motion:
    return ArduPilotAuto(vehicle or copter()).drive(Way(robot="copter", once=stops, every_round=()), STILL)


@pytest.mark.parametrize(("windy", "median", "worst"), [(False, 0.002, 0.0125), (True, 0.002, 0.006)])
def test_rounds_take_as_long_as_recorded_ones(windy: bool, median: float, worst: float) -> None:
    flights = [flight for flight in FLIGHTS if (flight.wind.speed_m_s > 0) == windy]
    errors = [abs(flight.driven().round_s / flight.round_s - 1) for flight in flights]
    assert len(errors) == (9 if windy else 21)
    assert np.median(errors) < median
    assert max(errors) < worst


def test_the_closed_form_comes_near_to_recorded_rounds() -> None:
    flights = [flight for flight in FLIGHTS if not flight.wind.speed_m_s]
    errors = [abs(ArduPilotAuto(flight.vehicle).round_s(flight.way) / flight.round_s - 1) for flight in flights]
    assert np.median(errors) < 0.005
    assert max(errors) < 0.03


@pytest.mark.parametrize(("fast", "number", "median", "worst"), [(False, 48, 0.003, 0.02), (True, 15, 0.005, 0.02)])
def test_corners_take_as_long_as_recorded_ones(fast: bool, number: int, median: float, worst: float) -> None:
    # at 15 m/s the copter is at its top airspeed of 10 m/s all along
    errors = []
    for told, way, vehicle in recorded_corners():
        if (told["speed_m_s"] == 15) == fast:
            legs_s = ArduPilotAuto(vehicle).drive(way, STILL).legs_s
            errors.append(abs(legs_s[1:].sum() / told["whole_s"] - 1))
    assert len(errors) == number
    assert np.median(errors) < median
    assert max(errors) < worst


def test_tracks_are_where_recorded_ones_are() -> None:
    tracks = recorded_tracks()
    assert len(tracks) == 3
    for flight in FLIGHTS:
        if flight.name in tracks:
            times_s, *places = tracks[flight.name].T
            motion = flight.driven()
            there = motion.at(motion.loop_start_s + times_s)[:, :2]
            off_m = np.hypot(*(there - np.column_stack(places)).T)
            assert np.median(off_m) < 0.35, flight.name
            assert off_m.max() < 1.3, flight.name
            line = shapely.linestrings(motion.positions_m[motion.times_s >= motion.loop_start_s][:, :2])
            assert shapely.distance(shapely.points(*places), line).max() < 0.35, flight.name


def test_a_leg_between_rests_takes_what_its_ramps_take() -> None:
    # 2.5 m/s2 are not reached by a jerk of 1 m/s3 within 20 m, so one formula holds: a (a/J + 2 tc)^2 = L/2
    a = min(a for a in np.linspace(0, 2.5, 100_001) if a * (a + 0.3) ** 2 >= 10)
    motion = once(stop(0, 0, speed_m_s=None), stop(20, 0))
    # the target waits for the copter where that falls behind
    assert 4 * (a + 0.3) < motion.loop_start_s < 1.08 * 4 * (a + 0.3)
    assert math.dist(motion.positions_m[-1], (20, 0, 25)) <= 2
    assert motion.round_s == 0


def test_a_copter_stops_where_it_waits_and_cuts_corners_elsewhere() -> None:
    waits = Way(
        robot="copter",
        once=(stop(0, 0),),
        every_round=tuple(stop(x, y, hold_s=10.0 if (x, y) == (60, 60) else 0.0) for x, y in [*SQUARE[1:], SQUARE[0]]),
    )
    model = ArduPilotAuto(copter())
    passing, waiting = model.drive(loop_way(SQUARE), STILL), model.drive(waits, STILL)
    assert 0.5 < passing.cut_m[1] < 2.0
    assert waiting.cut_m[1] < 0.05
    assert waiting.cut_m[0] == pytest.approx(passing.cut_m[0], abs=0.05)
    assert waiting.round_s > passing.round_s + 10
    assert model.round_s(waits) == pytest.approx(waiting.round_s, rel=0.03)
    # it stands there for nearly as long as it waits
    standing = np.ptp(waiting.positions_m, axis=0).max() > 50
    near = np.hypot(*(waiting.positions_m[:, :2] - (60, 60)).T) < 0.1
    assert standing
    assert np.diff(waiting.times_s)[near[:-1]].sum() > 9


def test_rounds_repeat_without_a_jump() -> None:
    motion = ArduPilotAuto(copter()).drive(loop_way(SQUARE), Wind(speed_m_s=4, from_deg=30))
    first = int(np.searchsorted(motion.times_s, motion.loop_start_s))
    assert motion.positions_m[first].tolist() == motion.positions_m[-1].tolist()
    assert motion.legs_s.sum() == pytest.approx(motion.round_s)
    later = motion.at(np.array([motion.loop_start_s + 5, motion.loop_start_s + 5 + 3 * motion.round_s]))
    np.testing.assert_allclose(later[0], later[1], atol=1e-9)


def test_climbing_and_descending_are_slower_than_flying_level() -> None:
    up, down = once(stop(0, 0, 10, None), stop(0, 0, 60)), once(stop(0, 0, 60, None), stop(0, 0, 10))
    assert up.loop_start_s == pytest.approx(50 / 2.5 + 4, abs=2)
    assert down.loop_start_s == pytest.approx(50 / 1.5 + 3, abs=2)
    steep, level = once(stop(0, 0, 10, None), stop(50, 0, 60)), once(stop(0, 0, 10, None), stop(70, 0, 10))
    assert steep.loop_start_s > level.loop_start_s + 5


def test_one_that_never_moves_stays() -> None:
    motion = once(stop(3, 4, speed_m_s=None))
    assert (motion.round_s, motion.positions_m.tolist()) == (0, [[3, 4, 25]])
    assert ArduPilotAuto(copter()).round_s(Way(robot="copter", once=(stop(3, 4),), every_round=())) == 0


def test_stops_at_one_place_are_one_with_all_their_waits() -> None:
    twice = once(stop(0, 0, speed_m_s=None), stop(40, 0, hold_s=3), stop(40, 0, hold_s=4), stop(80, 0))
    at_once = once(stop(0, 0, speed_m_s=None), stop(40, 0, hold_s=7), stop(80, 0))
    assert twice.loop_start_s == at_once.loop_start_s


def test_long_waits_are_not_flown_through_and_endless_flights_are_refused() -> None:
    def way(hold_s: float) -> Way:
        stops = [stop(x, y, hold_s=hold_s if (x, y) == (60, 60) else 0.0) for x, y in [*SQUARE[1:], SQUARE[0]]]
        return Way(robot="copter", once=(stop(0, 0),), every_round=tuple(stops))

    model = ArduPilotAuto(copter())
    short, long = model.drive(way(50), STILL), model.drive(way(65_000), STILL)
    assert long.round_s == pytest.approx(short.round_s + 64_950, abs=0.02)
    assert len(long.times_s) < len(short.times_s) + 500
    assert long.legs_s == pytest.approx([*short.legs_s[:2], short.legs_s[2] + 64_950, short.legs_s[3]], abs=0.02)
    late_s = np.array([1.0, 10.0, 20.0])
    np.testing.assert_allclose(
        long.at(long.loop_start_s + long.round_s - late_s),
        short.at(short.loop_start_s + short.round_s - late_s),
        atol=0.05,
    )
    far = loop_way([(0.0, 0.0), (1e5, 0.0)])
    with pytest.raises(RotaError, match=r"robot copter: its approach .* motion is worked out for 20000 s at most"):
        model.drive(far, STILL)


def test_wind_that_is_too_strong_is_told_with_its_leg() -> None:
    model = ArduPilotAuto(copter())
    assert model.top_airspeed_m_s == pytest.approx(10.0, abs=0.15)
    with pytest.raises(
        RotaError, match=r"robot copter: wind of 12 m/s from 0 degrees: .* cannot fly the leg to \(60.0"
    ):
        model.drive(loop_way(SQUARE), Wind(speed_m_s=12, from_deg=0))
    against, with_it = (model.drive(loop_way(SQUARE), Wind(speed_m_s=7, from_deg=angle)) for angle in (0, 90))
    assert against.round_s == pytest.approx(with_it.round_s, rel=0.01)  # the same square, turned
    assert against.round_s > 1.1 * model.drive(loop_way(SQUARE), STILL).round_s
    for bad in ({"speed_m_s": -1.0}, {"speed_m_s": math.inf}, {"from_deg": math.nan}):
        with pytest.raises(RotaError, match="is not allowed"):
            Wind(**bad)
