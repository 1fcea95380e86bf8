"""Fewer robots than the best plan so far has, begun with its tours."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tests.planners.patrol.searching import YARD, search_on

from rota.planners.patrol.efforts import EARLY
from rota.planners.patrol.methods.fewest.one_fewer import (
    give_up_robots,
    leave_out_needless_robots,
    tours_with_fewer,
    with_few_robots,
)
from rota.planners.patrol.methods.sweeping.first_plan import sweep
from rota.planners.patrol.repair.repair import Repaired
from rota.planners.patrol.tours.tour import tour_length_m


@pytest.fixture(scope="module")
def lanes() -> Repaired:
    """A plan of lanes."""
    plan = sweep(search_on(YARD), EARLY)
    assert plan is not None
    return plan


def test_every_shared_tour_may_give_up_a_robot(lanes: Repaired) -> None:
    (tour,) = lanes.tours
    team = [replace(tour, robots=robots) for robots in (3, 1, 2)]
    assert [[t.robots for t in tours] for tours in tours_with_fewer(team, 1)] == [[2, 1, 2], [3, 1, 1]]


def test_the_least_loaded_tours_give_up_the_other_robots(lanes: Repaired) -> None:
    (tour,) = lanes.tours
    team = [replace(tour, robots=robots) for robots in (4, 1, 2)]
    assert [[t.robots for t in tours] for tours in tours_with_fewer(team, 3)] == [[1, 1, 2], [2, 1, 1]]
    assert not list(tours_with_fewer(team, 5))


def test_tours_of_lanes_become_those_of_one_robot_less(lanes: Repaired) -> None:
    for fewer in (1, 3):
        more = replace(lanes, tours=[replace(lanes.tours[0], robots=lanes.robots + fewer)])
        found = give_up_robots(search_on(YARD), more, fewer)
        assert found is not None
        assert (found.robots, found.met) == (lanes.robots, True)


def test_tours_that_cannot_become_so_short_are_given_up(lanes: Repaired) -> None:
    hurried = replace(YARD, period_s=YARD.period_s / 4)
    assert give_up_robots(search_on(hurried), lanes) is None


def test_loops_keep_as_few_robots_as_go_round_them_in_time(lanes: Repaired) -> None:
    (tour,) = lanes.tours
    fewest = with_few_robots(replace(tour, robots=100)).robots
    assert tour_length_m(tour) <= replace(tour, robots=fewest).budget_m
    assert tour_length_m(tour) > replace(tour, robots=fewest - 1).budget_m
    assert with_few_robots(replace(tour, robots=1)).robots == 1  # late as it may be
    assert with_few_robots(replace(tour, robots=100, nest=3)).robots == 100


def test_a_plan_is_thinned_and_passes(lanes: Repaired) -> None:
    (tour,) = lanes.tours
    context = search_on(YARD)
    many = replace(lanes, tours=[replace(tour, robots=lanes.robots + 3)])
    found = leave_out_needless_robots(context, many)
    assert (found.robots, found.met) == (with_few_robots(tour).robots, True)
    assert leave_out_needless_robots(context, found) is found
