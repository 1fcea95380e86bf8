"""What one robot can do for ever, beside all rounds of a few visits."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from rota.planners.patrol.cycles.one_robot import is_hopeless, is_surely_too_much, stretch_of, visit_for_ever

Floats = NDArray[np.float64]
STAR = np.array([[0.0, 10, 10, 10], [10, 0, 20, 20], [10, 20, 0, 20], [10, 20, 20, 0]])


def legs(xy_m: Floats) -> Floats:
    return np.asarray(np.hypot(*(xy_m[:, None] - xy_m[None]).transpose(2, 0, 1)))


def some_places(seed: int, count: int) -> tuple[Floats, Floats]:
    random = np.random.default_rng(seed)
    return legs(random.uniform(0, 100, (count, 2))), random.uniform(120, 400, count)


def keeps(order: NDArray[np.int64], leg_s: Floats, period_s: Floats) -> bool:
    """Whether a round comes to all places, each within its period, by the clock of two rounds."""
    twice = np.concatenate([order, order])
    clock_s = np.concatenate([[0.0], np.cumsum(leg_s[twice[:-1], twice[1:]])])
    gaps = [np.diff(clock_s[twice == place]).max(initial=0.0) for place in range(len(period_s))]
    come = set(order.tolist()) == set(range(len(period_s)))
    return come and all(gap <= period * (1 + 1e-9) for gap, period in zip(gaps, period_s, strict=True))


def any_round_keeps(leg_s: Floats, period_s: Floats, most: int) -> bool:
    """Whether some round of at most so many visits does, all of them tried."""
    places = range(len(period_s))
    rounds = (order for m in range(len(period_s), most + 1) for order in itertools.product(places, repeat=m))
    return any(
        keeps(np.array(order), leg_s, period_s)
        for order in rounds
        if order[0] == 0 and all(a != b for a, b in zip(order, order[1:] + order[:1], strict=True))
    )


@pytest.mark.parametrize(("ends", "round_s"), [(2, 40.0), (3, 60.0)])
def test_a_hub_is_passed_between_all_ends(ends: int, round_s: float) -> None:
    leg_s, period_s = STAR[: ends + 1, : ends + 1], np.array([20.5] + ends * [20.5 * ends])
    order = visit_for_ever(leg_s, period_s, most_states=1000).order
    assert order is not None
    assert keeps(order, leg_s, period_s)
    assert stretch_of(order, leg_s, period_s) == pytest.approx((round_s, 20.5 / 20))


def test_what_no_round_of_a_few_visits_does_no_robot_does() -> None:
    settled = []
    for seed in range(40):
        leg_s, period_s = some_places(seed, 4)
        answer = visit_for_ever(leg_s, period_s, most_states=20_000)
        assert answer.is_settled
        settled.append(answer.order is not None)
        assert answer.order is None or keeps(answer.order, leg_s, period_s)
        assert is_hopeless(leg_s, period_s, most_states=20_000) is (answer.order is None)
        if answer.order is None:
            assert not any_round_keeps(leg_s, period_s, 7)
        else:
            assert not is_surely_too_much(leg_s, period_s)
    assert 5 < sum(settled) < 35


def test_little_work_leaves_it_open() -> None:
    leg_s, period_s = some_places(3, 8)
    answer = visit_for_ever(leg_s, 2.2 * period_s, most_states=3)
    assert (answer.order, answer.is_settled) == (None, False)
    assert not is_hopeless(leg_s, period_s / 2, most_states=3)


def test_places_too_near_each_other_prove_nothing() -> None:
    assert is_hopeless(np.array([[0.0, 3], [3, 0]]), np.array([4.0, 4]), most_states=100)
    assert not is_hopeless(np.array([[0.0, 1e-9], [1e-9, 0]]), np.array([4.0, 4]), most_states=100)
