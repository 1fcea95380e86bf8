"""Robots that know each other from late messages, some of them lost: bodies stay apart all the same."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.swarm_adversarial import LATE_AND_LOSSY, dense_states, lattice_states, swarm_of, worst_of
from hypothesis import given, settings, strategies as st
from tests.planners.swarm.conftest import PAPER, in_box, scattered
from tests.planners.swarm.test_last_filter import apart, packed, wishing

from rota.planners.swarm.delayed_news_kernels import MOST_LOST_IN_ROW, MOST_SPEED_GAIN, age_of, gone_m
from rota.planners.swarm.planner import DECIDE
from rota.planners.swarm.state import Hearing


# 10,000 are the figure that is promised; the first thousand show what would break it
@pytest.mark.parametrize("count", [1000, pytest.param(10_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("hearing", [None, LATE_AND_LOSSY], ids=["exact", "late and lossy"])
@pytest.mark.parametrize("controller", DECIDE)
def test_from_dense_states_with_random_velocities_bodies_never_touch(controller: str, hearing, count: int) -> None:
    states = dense_states(count, 5, np.random.default_rng(7))
    worst = worst_of(states, controller, 4, hearing)
    assert worst.faultless
    assert worst.way_m > 1e-4  # they do move


@pytest.mark.parametrize("hearing", [None, LATE_AND_LOSSY], ids=["exact", "late and lossy"])
@pytest.mark.parametrize("controller", DECIDE)
def test_from_lattices_that_touch_exactly_nobody_is_too_fast_or_touches_at_any_moment(controller: str, hearing) -> None:
    worst = worst_of(lattice_states(400, np.random.default_rng(3)), controller, 12, hearing)
    assert worst.faultless
    assert worst.between_m >= -1e-12
    assert worst.beside_m >= -1e-12
    assert worst.way_m > 1e-3


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(2, 25),
    speed=st.floats(0.1, 20),
    delay=st.integers(0, 3),
    lost=st.sampled_from([0.0, 0.1, 0.6]),
)
def test_whatever_robots_wish_for_old_news_keep_them_apart(
    seed: int, count: int, speed: float, delay: int, lost: float
) -> None:
    """Wishes lead to and fro between the bodies and away, so that old places are far from the true ones."""
    rng = np.random.default_rng(seed)
    side = 14.0
    places, bodies = packed(rng, count, side, 1.0)
    speeds = speed * rng.uniform(0.2, 1.0, len(places))
    wish = np.empty((len(places), 2))
    like = {"body_m": bodies, "speed_m_s": speeds, "sensor_m": 5, "neighbour_range_m": 10, "wall_range_m": 5}
    rule = PAPER._replace(seed=seed)
    hearing = Hearing(delay_steps=delay, lost=lost)
    swarm = in_box(places, (side, side), rule=rule, decide=wishing(wish), hearing=hearing, **like)
    for step in range(25):
        before = swarm.places_m
        wish[:] = (side / 2 - before) * (1 if step % 8 < 4 else -1) + rng.normal(size=wish.shape)
        wish *= (speeds / np.maximum(np.hypot(*wish.T), 1e-9))[:, None]
        slow = np.hypot(*swarm.velocities_m_s.T)
        swarm.step()
        if delay > 0 or lost > 0:  # what the others count on
            assert (np.hypot(*swarm.velocities_m_s.T) <= slow + MOST_SPEED_GAIN * speeds + 1e-12).all()
        for part in np.linspace(0, 1, 5):  # bodies stay apart at every moment of the step
            between = before + part * (swarm.places_m - before)
            assert len(bodies) < 2 or apart(between, bodies) > -1e-12
            assert (np.minimum(between, side - between) >= bodies[:, None] - 1e-12).all()


@pytest.mark.slow  # a thousand robots
def test_without_the_widening_old_news_let_them_touch() -> None:
    swarm = swarm_of(dense_states(1000, 5, np.random.default_rng(7)), "settle", LATE_AND_LOSSY, seed=1)
    assert swarm._messages is not None
    swarm._messages.step_m[:] = 0.0
    bodies = dense_states(1000, 5, np.random.default_rng(7)).bodies_m
    nearest = np.inf
    for _ in range(12):
        swarm.step()
        at = swarm.places_m.reshape(1000, 5, 2)
        nearest = min(nearest, *(apart(at[k], bodies[k]) for k in range(1000)))
    assert nearest < -1e-3


def test_a_message_is_as_old_as_its_delay_and_the_losses_since() -> None:
    ages = np.array([age_of(5, 3, 8, step, Hearing(1, 0.1)) for step in range(20_000)])
    assert ages.min() == 1
    for extra in range(3):  # losses are independent: a share 0.1^k of k in a row
        assert np.mean(ages > 1 + extra) == pytest.approx(0.1 ** (extra + 1), abs=0.007)
    assert (np.diff(ages) <= 1).all()  # a robot that hears nothing knows what it knew
    assert max(age_of(5, 3, 8, step, Hearing(2, 0.999)) for step in range(500)) == 2 + MOST_LOST_IN_ROW
    assert age_of(5, 3, 8, 7, Hearing(0, 0.0)) == 0


def test_news_without_delay_and_loss_are_the_truth() -> None:
    places = scattered(40, 5, 60, 1.2, seed=3)
    for decide in DECIDE.values():
        known = in_box(places, decide=decide, hearing=Hearing(delay_steps=0, lost=0.0))
        exact = in_box(places, decide=decide)
        for _ in range(30):
            known.step()
            exact.step()
        # the order in which half-planes are cut may differ, by rounding
        assert known.places_m == pytest.approx(exact.places_m, abs=1e-6)


def test_the_way_gone_since_a_message_is_that_of_gaining_all_the_time() -> None:
    most, told, gained = 0.5, 0.1, MOST_SPEED_GAIN * 0.5
    assert gone_m(0, told, most) == 0
    assert gone_m(2, told, most) == pytest.approx(2 * told + 3 * gained)
    assert gone_m(2, told, most) < 2 * most
    assert gone_m(40, told, most) == pytest.approx(sum(min(most, told + k * gained) for k in range(1, 41)))
    assert gone_m(3, most, most) == pytest.approx(3 * most)


def test_a_robot_heeds_what_the_other_one_told_a_step_before() -> None:
    late = in_box([[100, 100], [110, 100]], safe=False, hearing=Hearing(delay_steps=1, lost=0.0))
    late.step()
    away = 2 * 4 / (3 * np.pi)  # the centroid of half the disc of speeds
    assert late.velocities_m_s == pytest.approx(np.array([[-away, 0], [away, 0]]))
    late.step()
    # each moves at v and believes the other at rest: its set ends at v . e <= v_A . e / 2 = -away / 2, and not at
    # (v_A + v_B) . e / 2 = 0; the centroid of what is beyond h of a disc of radius r: 2/3 (r^2 - h^2)^1.5 / area
    h, r = away / 2, 2.0
    area = r * r * np.arccos(h / r) - h * np.sqrt(r * r - h * h)
    assert late.velocities_m_s[0] == pytest.approx([-2 / 3 * (r * r - h * h) ** 1.5 / area, 0])


def test_with_the_last_filter_robots_heed_late_news_as_fast_as_they_may_gain_speed() -> None:
    late = in_box([[100, 100], [110, 100]], hearing=Hearing(delay_steps=1, lost=0.0))
    top, away = 2.0, 2 * 4 / (3 * np.pi)  # which the first step of the test before comes to
    assert 2 * MOST_SPEED_GAIN * top < away
    for gained in (1, 2, 3):
        late.step()
        speed = gained * MOST_SPEED_GAIN * top
        assert late.velocities_m_s == pytest.approx(np.array([[-speed, 0], [speed, 0]]))
    late.step()
    # now nothing holds them back: each believes the other as slow as it was told a step before
    h = (3 - 2) * MOST_SPEED_GAIN * top / 2
    area = top * top * np.arccos(h / top) - h * np.sqrt(top * top - h * h)
    assert late.velocities_m_s[0] == pytest.approx([-2 / 3 * (top * top - h * h) ** 1.5 / area, 0])


@pytest.mark.parametrize("decide", DECIDE.values(), ids=DECIDE)
def test_threads_do_not_change_what_is_heard(decide) -> None:
    places = scattered(600, 5, 900, 1.2, seed=1)
    runs = []
    for threads in (1, 2):
        swarm = in_box(places, (910, 910), decide=decide, hearing=LATE_AND_LOSSY, threads=threads)
        for _ in range(12):
            swarm.step()
        runs.append(swarm.places_m)
    assert (runs[0] == runs[1]).all()
    other = in_box(places, (910, 910), rule=PAPER._replace(seed=9), decide=decide, hearing=LATE_AND_LOSSY)
    for _ in range(12):
        other.step()
    assert (runs[0] != other.places_m).any()  # other messages are lost
