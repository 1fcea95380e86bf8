"""More effort begins with what the lesser efforts find, on a coarser lattice, and never takes more robots."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota.check import check_plan
from rota.mission import DiscSensor, Effort, Fleet, Mission, Obstacle, PatrolSettings
from rota.planners.patrol import tours
from rota.planners.patrol.annealing.tour import Tour
from rota.planners.patrol.context import Context
from rota.planners.patrol.problem import set_up_problem
from rota.planners.patrol.repair import Settled

YARD = Mission(
    name="yard", area=MultiPolygon([box(0, 0, 30, 20)]), obstacles=(Obstacle(shape=MultiPolygon([box(8, 5, 12, 9)])),),
    period_s=60, fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=2)), planning=PatrolSettings(effort="normal"),
)  # fmt: skip


def context(mission: Mission) -> Context:
    return Context(
        problem=set_up_problem(mission), seed=0, judge=check_plan, progress=lambda _share, _what: None,
        should_stop=lambda: False,
    )  # fmt: skip


def test_less_effort_keeps_the_bound_and_lays_a_coarser_lattice() -> None:
    normal = context(YARD)
    normal = replace(normal, problem=replace(normal.problem, lower_bound=7, lower_bound_reason="so", enough_robots=9))
    quick = tours.with_less_effort(normal, "quick")
    assert quick.problem.spacing_m == pytest.approx(1.5 * normal.problem.spacing_m)
    assert quick.work.moves < normal.work.moves
    proved = (quick.problem.lower_bound, quick.problem.lower_bound_reason, quick.problem.enough_robots)
    assert proved == (7, "so", 9)


def test_more_effort_is_spent_only_while_fewer_robots_may_do(monkeypatch: pytest.MonkeyPatch) -> None:
    spent = []

    def recorded(here: Context, best: Settled | None) -> Settled:
        spent.append((here.problem.mission.patrol.effort, best))
        return with_fewer(here, best)

    with_fewer = tours.with_fewer
    monkeypatch.setattr(tours, "with_fewer", recorded)
    found = tours.fewest_robots(context(YARD))
    assert found.met
    assert found.plan.mission == YARD
    # two robots are the bound, and the least effort finds them
    assert (tours.robots_of(found), found.plan.lower_bound_robots) == (2, 2)
    assert spent == [("quick", None)]


def test_the_best_of_less_effort_is_kept_when_more_finds_no_better(monkeypatch: pytest.MonkeyPatch) -> None:
    quick = tours.fewest_robots(context(YARD.with_effort("quick")))
    monkeypatch.setattr(tours, "with_so_many", lambda *_args, **_kinds: None)
    here = context(YARD)
    here = replace(here, problem=replace(here.problem, enough_robots=1))
    assert tours.with_fewer(here, quick) is quick


class Shaped(NamedTuple):
    """What ``in_full`` reads of a search, and what it was asked for."""

    shortfall_m: float
    began: int
    seed: int
    dear: float


@pytest.mark.parametrize(
    ("effort", "begun", "expected"),
    [
        ("quick", 3, [(0, 5, 1), (1, 105, 1)]),  # one each of the two most promising, in their order
        ("quick", 1, [(0, 5, 1)]),
        ("quick", 0, []),
        # of each kind the three that lack least
        ("high", 4, [(0, 5, 1), (1, 105, 1), (3, 305, 1), (0, 405, 2), (2, 605, 2), (1, 505, 2)]),
        ("high", 1, [(0, 5, 1), (0, 105, 2), (0, 405, 1), (0, 305, 2), (0, 605, 1), (0, 505, 2)]),
    ],
)
def test_of_many_seeds_those_that_lack_least_go_on(
    monkeypatch: pytest.MonkeyPatch, effort: Effort, begun: int, expected: list[tuple[int, int, float]]
) -> None:
    lacks_m = {5: 5.0, 105: 9.0, 205: 47.0, 305: 3.0, 405: 4.0, 505: 8.0, 605: 2.0, 705: 46.0}

    def shaped(here: Context, given: list[Tour], *, seed: int) -> Shaped:
        return Shaped(shortfall_m=lacks_m.get(seed, 40.0), began=given[0].serves, seed=seed, dear=here.dear)

    monkeypatch.setattr(tours, "shaped", shaped)
    here = context(YARD.with_effort(effort))
    spot = Tour(vertices_m=np.zeros((1, 2)), serves=0, period_s=60, robots=1, robot=here.problem.robot)
    searches = tours.in_full(here, [[replace(spot, serves=k)] for k in range(begun)], seed=5)
    found = [(one.began, one.seed, one.dear) for one in searches if isinstance(one, Shaped)]
    assert len(found) == len(searches)
    assert sorted(found) == sorted(expected)
    assert [seed for _, seed, _ in found] == sorted(seed for _, seed, _ in found)  # in the order they began
