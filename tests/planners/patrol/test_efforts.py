"""More effort begins with what the lesser efforts find, on a coarser lattice, and never takes more robots."""

from __future__ import annotations

from dataclasses import replace

import pytest
from shapely import MultiPolygon, box

from rota.check import check_plan
from rota.mission import DiscSensor, Fleet, Mission, Obstacle, PatrolSettings
from rota.planners.patrol import tours
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
