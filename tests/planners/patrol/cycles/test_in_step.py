"""Robots that share places on rounds of equal time."""

from __future__ import annotations

import numpy as np
import shapely
from benchmarks.cyclic_visits import random_places
from tests.planners.patrol.cycles.test_one_robot import Floats, legs, some_places
from tests.planners.patrol.cycles.test_teams import fewest_of_all_ways

from rota import check_plan, make_plan
from rota.planners.patrol.cycles.in_step import serve_in_step, with_one_less
from rota.planners.patrol.cycles.teams import Share, share_places, worth


def are_kept(shares: list[Share], leg_s: Floats, period_s: Floats) -> bool:
    """Whether every place is come to in time, and every way takes as long as its leg, for ever."""
    for share in shares:
        assert share.times_s is not None
        ways_s = np.diff(np.append(share.times_s, share.times_s[0] + share.round_s))
        if (ways_s < leg_s[share.order, np.roll(share.order, -1)] * (1 - 1e-9)).any():
            return False
    round_s = shares[0].round_s
    for place in range(len(period_s)):
        times_s = np.sort(np.concatenate([share.times_s[share.order == place] for share in shares]))  # type: ignore[index]
        if not len(times_s) or np.diff(np.append(times_s, times_s[0] + round_s)).max() > period_s[place] * (1 + 1e-9):
            return False
    return all(share.round_s == round_s for share in shares)


def places_of(seed: int) -> tuple[Floats, Floats]:
    """The legs and the periods of a mission of the benchmark."""
    zones = random_places(seed, "latencies").zones
    places_m = np.array([shapely.get_coordinates(zone.shape.centroid)[0] for zone in zones])
    return legs(places_m), np.array([zone.period_s for zone in zones], dtype=np.float64)


def test_two_robots_share_what_takes_three_with_places_of_their_own() -> None:
    leg_s, period_s = places_of(38)
    assert fewest_of_all_ways(leg_s, period_s) == 3
    shares = serve_in_step(leg_s, period_s, 2, most_states=20_000)
    assert len(shares) == 2
    assert are_kept(shares, leg_s, period_s)


def test_a_robot_is_spared_by_some_that_share_and_others_that_do_not() -> None:
    for seed in (13, 51, 62):
        leg_s, period_s = places_of(seed)
        team = share_places(leg_s, period_s, most_states=20_000, rounds=0, seed=0)
        fewer = with_one_less(team, leg_s, period_s, most_states=300_000, enough=2)
        in_step = [share for share in fewer if share.times_s is not None]
        own = np.unique(np.concatenate([share.order for share in in_step]))
        told = [share._replace(order=np.searchsorted(own, share.order)) for share in in_step]
        assert worth(fewer)[0] == worth(team)[0] - 1
        assert are_kept(told, leg_s[np.ix_(own, own)], period_s[own])


def test_no_robot_is_given_up_below_what_is_enough() -> None:
    for seed in range(10):
        leg_s, period_s = some_places(seed, 6)
        team = share_places(leg_s, period_s, most_states=2_000, rounds=0, seed=0)
        fewer = with_one_less(team, leg_s, period_s, most_states=2_000, enough=3)
        assert worth(fewer)[0] >= min(3, worth(team)[0])
        assert sorted({int(k) for share in fewer for k in share.order}) == list(range(6))


def test_one_robot_or_places_in_two_parts_are_left_alone() -> None:
    leg_s, period_s = some_places(1, 3)
    assert serve_in_step(leg_s, period_s, 1, most_states=100) == []
    apart_s = np.where(np.eye(3, dtype=bool), 0.0, np.inf)
    assert serve_in_step(apart_s, period_s, 2, most_states=100) == []


def test_the_check_passes_robots_that_come_to_places_in_turn() -> None:
    plan = make_plan(random_places(38, "latencies"), seed=0)
    assert check_plan(plan).verdict == "met"
    assert len({round(trajectory.loop_duration_s, 6) for trajectory in plan}) == 1
    assert len(plan) == plan.lower_bound_robots == 2
