"""What was driven until a moment and what is driven from then on are the trajectory itself, also with accelerations."""

from __future__ import annotations

import numpy as np
import pytest
from tests.relieved import FLIGHT_S, ROUND_S, TURN_S, WAY_S, relieved

from rota import DiscSensor, Trajectory
from rota.model.plan import Charge, Driven
from rota.routes.flights import on_charger
from rota.routes.moments import delay, flight_after, go_on, way_before

LOOPS = Trajectory(
    robot="a",
    times_s=np.array([0.0, 4, 6, 9, 11]),
    positions_m=np.array([[0.0, 0], [4, 0], [4, 3], [8, 3], [4, 0]]),
    accelerations_m_s2=np.array([0.5, 0.0, -0.3, 0.0]),
    loop_start_s=4.0,
)
STAYS = Trajectory(robot="b", times_s=np.array([0.0, 3]), positions_m=np.array([[0.0, 0], [3, 1]]), loop_start_s=3.0)


def place(driven: Driven, now_s: float) -> np.ndarray:
    """Where a robot was, by the bend of the leg that it was on."""
    leg = int(np.clip(np.searchsorted(driven.times_s, now_s, side="right") - 1, 0, len(driven.times_s) - 2))
    share = (now_s - driven.times_s[leg]) / (driven.times_s[leg + 1] - driven.times_s[leg])
    along = share + driven.bends[leg] * share * (share - 1)
    return np.asarray(driven.positions_m[leg] + along * (driven.positions_m[leg + 1] - driven.positions_m[leg]))


@pytest.mark.parametrize("trajectory", [LOOPS, STAYS])
@pytest.mark.parametrize("at_s", [0.0, 1.7, 3.0, 4.0, 9.0, 10.99, 11.0, 25.3, 1000.2])
def test_nothing_is_lost_at_the_seam(trajectory: Trajectory, at_s: float) -> None:
    after = go_on(trajectory, at_s)
    moments = np.linspace(0, 40, 501)
    assert np.abs(after.at(moments) - trajectory.at(at_s + moments)).max() < 1e-9 * max(1, at_s)
    assert after.loop_duration_s == pytest.approx(trajectory.loop_duration_s)
    before = way_before(trajectory, DiscSensor(radius_m=1), at_s, 20)
    assert before.times_s[0] == pytest.approx(-min(20, at_s))
    if at_s > 0:
        for now in np.linspace(before.times_s[0], 0, 101)[:-1]:
            assert np.abs(place(before, float(now)) - trajectory.at(at_s + now)).max() < 1e-9 * max(1, at_s)


TURNS = Trajectory(  # at 2 m/s, with a second at each corner for turning, and one at the beginning of the loop
    robot="c",
    times_s=np.array([0.0, 1, 2, 7, 8, 11, 12, 17, 18, 21]),
    positions_m=np.array(
        [[0.0, 2], [0, 0], [0, 0], [10, 0], [10, 0], [10, 6], [10, 6], [0, 6], [0, 6], [0, 0]], dtype=np.float64
    ),
    loop_start_s=1.0,
)


@pytest.mark.parametrize("off_s", [10.0**k for k in range(-11, -4)])
@pytest.mark.parametrize("trajectory", [TURNS, LOOPS, STAYS])
def test_a_moment_beside_a_corner_leaves_turns_their_time_and_no_leg_that_creeps(
    trajectory: Trajectory, off_s: float
) -> None:
    """A robot stays or drives as it did: no step to a corner and the turn there become one leg."""
    pace_m_s = np.hypot(*np.diff(trajectory.positions_m, axis=0).T) / np.diff(trajectory.times_s)
    rounds_s = [turn * trajectory.loop_duration_s for turn in (0, 1, 40)]
    beside = [row_s + turn_s + by_s for row_s in trajectory.times_s for turn_s in rounds_s for by_s in (-off_s, off_s)]
    for at_s in (moment_s for moment_s in beside if moment_s >= 0):
        after, before = go_on(trajectory, at_s), way_before(trajectory, DiscSensor(radius_m=1), at_s, 30)
        times_s = np.append(before.times_s[:-1], after.times_s)
        legs_m = np.hypot(*np.diff(np.vstack([before.positions_m[:-1], after.positions_m]), axis=0).T)
        told_s = np.diff(times_s)
        assert legs_m @ (legs_m / told_s > pace_m_s.max() * (1 + 1e-6)) == 0
        if trajectory.accelerations_m_s2 is None:
            longer = told_s > 1.01e-9 * max(1, at_s)
            off_m_s = np.abs((legs_m / told_s)[longer, None] - np.append(pace_m_s, 0.0)).min(axis=1)
            assert off_m_s.max(initial=0.0) < 1e-5, (at_s, times_s, legs_m)


@pytest.mark.parametrize("trajectory", [TURNS, LOOPS])
@pytest.mark.parametrize("off_s", [-3e-4, 3e-4])
def test_a_moment_beside_a_corner_after_many_rounds_moves_no_place(trajectory: Trajectory, off_s: float) -> None:
    """After eleven days as well: only times so far on are rounded, to 1e-10 s."""
    moments_s = np.linspace(0, 60, 601)
    for row_s in trajectory.times_s[trajectory.loop_index :]:
        at_s = float(row_s + 50_000 * trajectory.loop_duration_s + off_s)
        assert np.abs(go_on(trajectory, at_s).at(moments_s) - trajectory.at(at_s + moments_s)).max() < 2e-9
        before = way_before(trajectory, DiscSensor(radius_m=1), at_s, 60)
        assert before.times_s[0] == pytest.approx(-60)
        assert max(np.abs(place(before, -s) - trajectory.at(at_s - s)).max() for s in moments_s[1:]) < 2e-9


def test_a_late_robot_is_where_it_was_so_much_sooner() -> None:
    late = delay(LOOPS, 2.5)
    moments = np.linspace(0, 40, 301)
    assert np.abs(late.at(moments) - LOOPS.at(np.maximum(moments - 2.5, 0))).max() < 1e-9
    assert delay(LOOPS, 0) is LOOPS


def test_a_delay_leaves_stays_in_the_loop_that_begin_with_it() -> None:
    """It charges from 0 to 5 of each round of 20 s: 2.5 s late, it does so 2.5 s later in every round."""
    stay = Charge(charger="pad", from_s=0.0, until_s=5.0)
    way = Trajectory(robot="a", times_s=[0, 5, 12, 20], positions_m=[(0, 0), (0, 0), (7, 0), (0, 0)], charges=(stay,))
    late, moments_s = delay(way, 2.5), np.arange(0.25, 70, 0.5)
    assert (on_charger(late, moments_s + 2.5) == on_charger(way, moments_s)).all()
    assert on_charger(late, np.array([0.5, 2.0])).all()
    assert (on_charger(go_on(late, 25.0), moments_s) == on_charger(way, moments_s + 22.5)).all()


def test_a_flight_after_a_moment_ends_on_the_charger() -> None:
    way = relieved(3)["robot-1"]  # flies from 0 on, from 480 s on, and so on, and is on its charger from 180 s on
    for leaves_s in (0.0, 3 * TURN_S, 30 * TURN_S):
        flight = flight_after(way, leaves_s)
        assert flight is not None
        assert [one.from_s for one in flight.charges] == pytest.approx([FLIGHT_S])
        np.testing.assert_allclose(flight.positions_m[[0, -1]], [[0, 0], [0, 0]], atol=1e-9)
        moments_s = np.linspace(0, FLIGHT_S, 50)
        np.testing.assert_allclose(flight.at(moments_s), way.at(moments_s + leaves_s), atol=1e-6)
    under_way = flight_after(way, WAY_S + ROUND_S)
    assert under_way is not None
    assert under_way.charges[0].from_s == pytest.approx(ROUND_S + WAY_S)
    assert flight_after(way, FLIGHT_S + 1.0) is None
    assert flight_after(LOOPS, 5.0) == go_on(LOOPS, 5.0)
