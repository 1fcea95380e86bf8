"""What an executor does for a search: the same plan, and an end as soon as one is asked for."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor, Future
from dataclasses import replace
from typing import Any

import pytest
from tests.planners.patrol.searching import YARD, hasty_search_on, search_on

from rota.check import Report, check_plan
from rota.engines.processes import LocalProcesses
from rota.files.plan_file import plan_text
from rota.model.plan import Plan
from rota.planners.patrol.annealing.schedule import anneal_all
from rota.planners.patrol.context import Context
from rota.planners.patrol.initial.allocation import period_groupings
from rota.planners.patrol.methods.fewest.team_size_plan import plan_with_team_size


@pytest.fixture(scope="module")
def process() -> Iterator[LocalProcesses]:
    """One, since each loads all compiled loops."""
    with LocalProcesses(1) as executor:
        yield executor


class Sleeper(Executor):
    """Takes calls and never does one."""

    def __init__(self) -> None:
        self.taken: list[Future[Any]] = []

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        self.taken.append(Future())
        return self.taken[-1]


class Judging:
    """The check, which notes what it judges in this process."""

    def __init__(self, told: list[Plan]) -> None:
        self._told = told

    def __call__(self, plan: Plan) -> Report:
        self._told.append(plan)
        return check_plan(plan)


def seeds_and_robots(context: Context, more: int, *, fewer: int) -> int:
    """What a function is given, wherever it is done."""
    assert context.executor is None or more > 10
    return context.seed + len(context.problem.points) + more - fewer


def test_a_process_finds_the_same_plan(process: LocalProcesses) -> None:
    told: list[Plan] = []
    context = replace(hasty_search_on(YARD), judge=Judging(told))
    groupings = period_groupings(context.problem, 4)
    alone = plan_with_team_size(context, groupings, 3, least_slack=1.0)
    judged_here = len(told)
    found = plan_with_team_size(replace(context, executor=process), groupings, 3, least_slack=1.0)
    assert alone is not None
    assert found is not None
    assert plan_text(found.plan) == plan_text(alone.plan)
    assert plan_text(alone.plan) in map(plan_text, told[judged_here:])  # whoever looks on is told of it here


def test_a_function_is_done_elsewhere_with_the_same_context(process: LocalProcesses) -> None:
    context = replace(search_on(YARD), seed=5)
    expected = 5 + len(context.problem.points) + 7 - 2
    assert context.run(seeds_and_robots, 7, fewer=2) == expected
    there = replace(context, executor=process)
    assert there.run(seeds_and_robots, 7, fewer=2) == expected
    with pytest.raises(TypeError):
        there.run(seeds_and_robots, "7", fewer=2)  # type: ignore[arg-type]


def test_a_search_that_is_stopped_does_not_wait_for_others() -> None:
    context = search_on(YARD)
    tours = period_groupings(context.problem, 1)[0].with_robots([2]).tours
    sleeper = Sleeper()
    stopped = replace(context, executor=sleeper, should_stop=lambda: len(sleeper.taken) == 2)
    searches = anneal_all(stopped, [tours, tours], moves=10**9, seed=0, coarse=False)
    assert [each.moves_made for each in searches] == [0, 0]
    assert all(call.cancelled() for call in sleeper.taken)
