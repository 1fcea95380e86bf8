"""Routes of stops, speeds and waits beside the trajectories that they stand for."""

from __future__ import annotations

import numpy as np
import pytest
from tests.files.two_robots import two_robots, with_heights

from rota.errors import PlanError
from rota.model.plan import Plan, Trajectory
from rota.routes.driven_route import from_start, trajectory_of
from rota.routes.route import Route, RouteStop, route_of


def place_at(trajectory: Trajectory, time_s: float) -> np.ndarray:
    """Where the robot is, by interpolation written for this test."""
    start, duration = trajectory.loop_start_s, trajectory.loop_duration_s
    if time_s > start:
        time_s = start + (time_s - start) % duration if duration else start
    return np.array([np.interp(time_s, trajectory.times_s, column) for column in trajectory.positions_m.T])


@pytest.mark.parametrize("plan", [two_robots(), with_heights()], ids=["flat", "with heights"])
def test_a_route_driven_exactly_is_the_trajectory(plan: Plan) -> None:
    for trajectory in plan:
        driven = trajectory_of(route_of(trajectory, 25), flat=trajectory.positions_m.shape[1] == 2)
        assert driven.robot == trajectory.robot
        assert driven.loop_duration_s == pytest.approx(trajectory.loop_duration_s, rel=1e-12)
        for time_s in np.linspace(0, 300, 997):
            np.testing.assert_allclose(place_at(driven, time_s), place_at(trajectory, time_s), atol=1e-9)


def test_waits_where_the_loop_begins_belong_to_every_round() -> None:
    waiting = Trajectory(
        robot="a",
        times_s=[0, 7, 9, 19, 29, 32],
        positions_m=[[0, 0], [0, 0], [0, 0], [50, 0], [0, 0], [0, 0]],
        loop_start_s=7,
    )
    route = route_of(waiting, 25)
    assert [(stop.place_m, stop.speed_m_s, stop.hold_s) for stop in from_start(route)] == [
        ((0, 0, 25), None, 9),
    ]
    assert [(stop.place_m, stop.speed_m_s, stop.hold_s) for stop in route.every_round] == [
        ((50, 0, 25), 5, 0),
        ((0, 0, 25), 5, 5),
    ]
    driven = trajectory_of(route, flat=True)
    assert (driven.loop_start_s, driven.loop_duration_s) == (9, 25)
    for time_s in np.linspace(0, 100, 401):
        np.testing.assert_allclose(place_at(driven, time_s), place_at(waiting, time_s), atol=1e-9)


def test_a_robot_that_stays_has_no_rounds() -> None:
    for times_s, positions_m in (([0.0], [[5, 5]]), ([0, 9], [[5, 5], [5, 5]]), ([0, 4], [[0, 0], [5, 5]])):
        staying = Trajectory(robot="a", times_s=times_s, positions_m=positions_m, loop_start_s=times_s[-1])
        route = route_of(staying, 25)
        assert route.every_round == ()
        assert from_start(route)[-1].place_m == (5, 5, 25)
        driven = trajectory_of(route, flat=True)
        assert driven.loop_duration_s == 0
        assert driven.positions_m[-1].tolist() == [5, 5]


def test_a_loop_without_length_cannot_be_driven() -> None:
    stop = RouteStop(place_m=(0, 0, 0), speed_m_s=1)
    route = Route(robot="a", start_m=(0, 0, 0), approach=(), loop=(stop,), closing=stop)
    with pytest.raises(PlanError, match=r"robot a: its loop takes 0 s, too short"):
        trajectory_of(route, flat=True)
