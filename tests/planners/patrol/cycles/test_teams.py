"""Teams for places with periods, beside all ways to share them."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from tests.planners.patrol.cycles.test_one_robot import Floats, keeps, legs, some_places
from tests.seeds import seeds

from rota.planners.patrol.cycles.one_robot import visit_for_ever
from rota.planners.patrol.cycles.teams import share_places, worth


def shortest_trip_s(leg_s: Floats) -> float:
    rest = range(1, len(leg_s))
    return min(leg_s[[0, *order], [*order, 0]].sum() for order in itertools.permutations(rest))


def fewest_of_all_ways(leg_s: Floats, period_s: Floats) -> int:
    """The fewest robots over all labels of the places with a part."""
    n, best = len(period_s), len(period_s)
    for labels in itertools.product(range(n), repeat=n):
        robots = 0
        for part in set(labels):
            own = np.flatnonzero(np.array(labels) == part)
            legs_s, periods_s = leg_s[np.ix_(own, own)], period_s[own]
            alone = visit_for_ever(legs_s, periods_s, most_states=20_000).order is not None
            robots += 1 if alone else math.ceil(shortest_trip_s(legs_s) / periods_s.min())
        best = min(best, robots)
    return best


@pytest.mark.parametrize("seed", seeds(8, at_once=3))
def test_no_other_way_to_share_few_places_takes_fewer_robots(seed: int) -> None:
    leg_s, period_s = some_places(seed, 5)
    period_s = period_s / (1 + seed % 3)
    team = share_places(leg_s, period_s, most_states=20_000, rounds=0, seed=0)
    assert worth(team)[0] == fewest_of_all_ways(leg_s, period_s)
    assert sorted(place for share in team for place in set(share.order.tolist())) == list(range(5))


def test_rounds_come_to_their_places_in_time_and_may_be_stretched() -> None:
    revisiting = 0
    for seed in range(20):
        leg_s, period_s = some_places(seed, 9)
        for share in share_places(leg_s, period_s, most_states=20_000, rounds=0, seed=0):
            own = np.unique(share.order)
            order = np.searchsorted(own, share.order)
            legs_s, stretch = leg_s[np.ix_(own, own)], share.robots * share.headway_s / max(share.round_s, 1e-9)
            assert stretch >= 1
            if len(own) > 1:
                assert keeps(order, legs_s * stretch / share.robots, period_s[own])
            revisiting += not share.is_plain
    assert revisiting > 3


def test_many_places_are_shared_again_in_parts() -> None:
    random = np.random.default_rng(0)
    leg_s, period_s = legs(random.uniform(0, 100, (30, 2))), random.uniform(120, 400, 30)
    begun, later = (share_places(leg_s, period_s, most_states=500, rounds=rounds, seed=1) for rounds in (0, 6))
    assert sorted(place for share in later for place in set(share.order.tolist())) == list(range(30))
    assert worth(later) <= worth(begun)


def test_places_without_a_way_between_them_have_robots_of_their_own() -> None:
    leg_s = np.array([[0.0, np.inf, 5], [np.inf, 0, np.inf], [5, np.inf, 0]])
    team = share_places(leg_s, np.array([60.0, 60, 60]), most_states=100, rounds=0, seed=0)
    assert sorted(sorted(share.order.tolist()) for share in team) == [[0, 2], [1]]
