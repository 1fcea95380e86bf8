"""Which tours are annealed and repaired again, told by what the judge is asked."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.planners.patrol.searching import YARD, search_on

from rota.check import check_plan
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planners.patrol.annealing.schedule import anneal_shape
from rota.planners.patrol.annealing.search import Annealed
from rota.planners.patrol.context import Context
from rota.planners.patrol.efforts import EFFORTS
from rota.planners.patrol.initial.allocation import period_groupings
from rota.planners.patrol.methods.anneal_and_repair import anneal_and_repair, excess_share, goes_on
from rota.planners.patrol.settings import AlternationSettings, Stage
from rota.planners.patrol.tours.tour import Tour
from rota.planners.patrol.verdict import Verdict


def begun(mission: Mission, *, robots: int) -> tuple[Context, Annealed]:
    """A search with few moves on the mission, and annealed tours of so many robots."""
    context = search_on(mission)
    settings = context.settings
    few = replace(settings, annealing=replace(settings.annealing, moves=40_000))
    few = replace(few, alternation=replace(few.alternation, annealings=2, moves=10_000))
    few = replace(few, repair=replace(few.repair, rounds=1, bending_steps=2))
    context = replace(context, settings=few)
    tours = period_groupings(context.problem, 1)[0].with_robots([robots]).tours
    return context, anneal_shape(context, tours, seed=1)


@pytest.fixture(scope="module")
def tight() -> tuple[Context, Annealed]:
    """Two robots, for whom there is no time."""
    return begun(replace(YARD, period_s=40), robots=2)


@pytest.fixture(scope="module")
def turning() -> tuple[Context, Annealed]:
    """The same of robots that take time to turn, whose tours linear programs do not bend."""
    return begun(replace(YARD, period_s=40, fleet=replace(YARD.fleet, turn_rate_rad_s=3.0)), robots=2)


def repairs(search: tuple[Context, Annealed], **limits: float) -> tuple[int, int]:
    """How many plans are judged, and how many repairs fail, with these limits of the alternation."""
    context, annealed = search
    judged: list[Plan] = []

    def judge(plan: Plan) -> Verdict:
        judged.append(plan)
        return check_plan(plan)

    wide = {"unseen_limit": 1.0, "over_budget_limit": 9.0}
    alternation = replace(context.settings.alternation, **(wide | limits))  # type: ignore[arg-type]
    context = replace(context, judge=judge, settings=replace(context.settings, alternation=alternation))
    failed = list(anneal_and_repair(context, annealed, seed=2))
    assert all(result is None for result in failed)
    return len(judged), len(failed)


def test_tours_without_hope_are_not_repaired(
    tight: tuple[Context, Annealed], turning: tuple[Context, Annealed]
) -> None:
    for search in (tight, turning):
        assert repairs(search) == (1, 1)
        assert repairs(search, unseen_limit=-1.0) == (0, 0)
        assert repairs(search, over_budget_limit=-1.0) == (0, 0)


def test_tours_that_come_close_have_more_attempts(tight: tuple[Context, Annealed]) -> None:
    # each repair that fails so narrowly is followed by another one, over samples that hardly overlap
    assert repairs(tight, attempts=3, near_budget_limit=9.0) == (6, 3)
    assert repairs(tight, attempts=3, near_budget_limit=0.0) == (1, 1)


def test_repairs_go_on_while_they_gain(tight: tuple[Context, Annealed]) -> None:
    assert repairs(tight, attempts=1, annealings=4, near_budget_limit=0.0) == (3, 3)


@pytest.mark.parametrize(
    ("excess", "least_excess", "expected"),
    [
        (0.02, math.inf, True),  # nothing to compare the first repair with
        (0.04, math.inf, False),
        (0.015, 0.02, True),
        (0.021, 0.02, False),  # it gains nothing
        (0.005, 0.004, True),  # so near that it need not gain
        (0.007, 0.004, False),
    ],
)
def test_when_another_annealing_is_worth_it(excess: float, least_excess: float, expected: bool) -> None:
    assert goes_on(excess, least_excess, EFFORTS["quick"].alternation) is expected


def test_annealings_begin_cooler_and_cooler() -> None:
    stages = EFFORTS["quick"].alternation.stages
    assert stages[:2] == list(AlternationSettings.first_stages)
    assert stages[2:] == [Stage(1 / 16, 6.0, 0.00375), Stage(1 / 32, 6.0, 0.001875), Stage(1 / 64, 6.0, 0.0009375)]
    assert len(EFFORTS["high"].alternation.stages) == 9


def test_what_short_tours_are_over_counts_as_a_share_of_many_reaches() -> None:
    context = search_on(YARD)  # sensors reach 2 m: 40 m is long
    robot = YARD.fleet.equal_robot("one")
    there_and_back_m = np.array([[0.0, 0.0], [6.0, 0.0]])
    for budget_m, expected in ((10.0, 2 / 40), (6.0, 6 / 40), (12.0, 0.0)):
        tour = Tour(
            vertices_m=there_and_back_m, period_class=0, period_s=budget_m / robot.speed_m_s, robots=1, robot=robot
        )
        assert excess_share(context, [tour]) == pytest.approx(expected, abs=1e-5)
    long_m = np.array([[0.0, 0.0], [51.0, 0.0]])
    long = Tour(vertices_m=long_m, period_class=0, period_s=100 / robot.speed_m_s, robots=1, robot=robot)
    assert excess_share(context, [long]) == pytest.approx(2 / 100, abs=1e-5)
