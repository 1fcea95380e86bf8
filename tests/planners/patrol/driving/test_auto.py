"""Rounds for ArduPilot's missions: times as its model has them, starts in phase, and what it makes of the waypoints."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from shapely import LineString, distance, points

from rota.check.accelerations import acceleration_violations
from rota.model.mission import DiscSensor, Fleet, Robot
from rota.model.motion_limits import MotionLimits
from rota.planners.patrol.driving.auto import Auto
from rota.planners.patrol.driving.driving import driving_of
from rota.routes.route import RouteStop, route_of
from rota.vehicles.motion import Way, Wind
from rota.vehicles.presets import VEHICLES

Floats = NDArray[np.float64]


def copter(name: str) -> Robot:
    """A copter of this name at 8 m/s with what its mission file gets from the presets."""
    preset = VEHICLES[name].preset(("acceleration_m_s2", "corner_acceleration_m_s2", "corner_m"))
    motion = MotionLimits(vehicle=name, **preset)
    return Fleet(speed_m_s=8, sensor=DiscSensor(radius_m=15), motion=motion).equal_robot("robot-1")


def driving(name: str) -> Auto:
    made = driving_of(copter(name))
    assert isinstance(made, Auto)
    return made


def rings(count: int) -> list[Floats]:
    rng = np.random.default_rng(0)
    return [rng.uniform(0, rng.choice([40.0, 150.0]), (int(rng.integers(3, 10)), 2)) for _ in range(count)]


def way_round(ring: Floats) -> Way:
    stops = [RouteStop(place_m=(x, y, 25.0), speed_m_s=8.0) for x, y in ring.tolist()]
    return Way(robot="robot-1", once=(stops[0],), every_round=(*stops[1:], stops[0]))


@pytest.mark.parametrize("name", ["arducopter", "arducopter-tuned"])
def test_rounds_take_as_long_as_the_model_says(name: str) -> None:
    made = driving(name)
    for ring in rings(20):
        round_s = made.round_m(ring) / made.pace_m_s
        assert round_s == pytest.approx(made.model.round_s(way_round(ring)), rel=1e-9)
        assert made.timed(ring).duration_s == pytest.approx(round_s, rel=1e-12)


@pytest.mark.parametrize("name", ["arducopter", "arducopter-tuned"])
def test_a_start_at_a_corner_is_in_phase_and_keeps_the_limits(name: str) -> None:
    made, rng = driving(name), np.random.default_rng(1)
    for ring in rings(20):
        line = made.timed(ring)
        phase_s = float(rng.uniform(0, line.duration_s))
        begun = made.begin_at_a_corner("robot-1", ring, phase_s)
        assert begun is not None
        assert acceleration_violations(begun, copter(name)) == []
        # from the first corner on it is where a robot is that was under way all the time
        at_s = begun.loop_start_s + rng.uniform(0, 2 * line.duration_s, 50)
        expected = line.at((phase_s + at_s) % line.duration_s)
        assert np.abs(begun.at(at_s) - expected).max() < 0.2
        assert begun.positions_m[0].tolist() == begun.waypoints.places_m[0].tolist()  # type: ignore[union-attr]
        assert begun.loop_duration_s == pytest.approx(line.duration_s)


def test_what_is_flown_is_what_is_planned() -> None:
    # rounds as long as flights of the model have them, see docs/benchmarks.md, and less off than a corner may be cut
    for name in ("arducopter", "arducopter-tuned"):
        made = driving(name)
        for ring in rings(6):
            begun = made.begin_at_a_corner("robot-1", ring, 0.0)
            assert begun is not None
            route = route_of(begun, 25.0)
            motion = made.model.drive(Way(robot="robot-1", once=route.once, every_round=route.every_round), Wind())
            assert motion.round_s == pytest.approx(begun.loop_duration_s, rel=0.03)
            at_s = motion.loop_start_s + np.linspace(0, motion.round_s, 1000)
            planned = LineString(begun.positions_m[begun.loop_index :])
            assert distance(points(motion.at(at_s)[:, :2]), planned).max() < 2


def test_the_route_is_the_corners_in_turn_after_one_wait() -> None:
    ring = np.array([[0.0, 0], [60, 0], [60, 40], [30, 20], [0, 40]])
    made = driving("arducopter-tuned")
    begun = made.begin_at_a_corner("robot-1", ring, made.timed(ring).duration_s / 2)
    assert begun is not None
    route = route_of(begun, 25.0)
    places = [stop.place_m[:2] for stop in (*route.once, *route.every_round)]
    told = begun.waypoints.places_m.tolist()  # type: ignore[union-attr]
    assert [list(place) for place in places[: 2 + len(told)]] == [told[0], *told[1:], told[0], told[1]]
    assert route.approach[0].hold_s == begun.waypoints.times_s[0]  # type: ignore[union-attr]
    assert {stop.speed_m_s for stop in route.every_round} == {8.0}
    assert sum(stop.planned_s or 0.0 for stop in route.every_round) == pytest.approx(begun.loop_duration_s)


@pytest.mark.parametrize("name", ["arducopter", "arducopter-tuned"])
def test_blends_that_nearly_meet_leave_no_leg_too_short_for_its_windows(name: str) -> None:
    # legs of nearly the length at which one blend ends as the next begins, as annealed tours have them
    made, rng = driving(name), np.random.default_rng(2)
    for leg_m in np.linspace(4, 16, 60):
        turns = np.cumsum(rng.uniform(-0.5, 0.7, 40))
        legs_m = leg_m * rng.uniform(0.9, 1.1, (40, 1))
        ring = np.cumsum(legs_m * np.column_stack([np.cos(turns), np.sin(turns)]), axis=0)
        for phase_s in (0.0, float(rng.uniform(0, 100))):
            begun = made.begin_at_a_corner("robot-1", ring, phase_s)
            assert begun is not None
            assert acceleration_violations(begun, copter(name)) == []
