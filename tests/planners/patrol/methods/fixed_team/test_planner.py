"""What a search for a fixed team's least ratio does with each ratio that it tries."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from shapely import MultiPolygon, box
from tests.planners.patrol.searching import YARD, search_on

from rota.check import check_plan
from rota.errors import NoPlanFound
from rota.model.mission import DiscSensor, Fleet, Mission, Robot
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.annealing.schedule import share_of_moves
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.initial.allocation import period_groupings
from rota.planners.patrol.methods.fixed_team import planner
from rota.planners.patrol.methods.fixed_team.least_ratio import Reached, reach_of, with_shorter_loops
from rota.planners.patrol.methods.fixed_team.planner import plan_fixed_team, searching_longer_periods
from rota.planners.patrol.methods.tours import fewest_robots_anywhere
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.repair import Repaired, plan_of
from rota.planners.patrol.tours.tour import Tour
from rota.planning.make_plan import search_plan


def test_each_ratio_is_tried_once_with_all_moves() -> None:
    usual = search_on(YARD)
    tours = period_groupings(usual.problem, 1)[0].tours
    longer = searching_longer_periods(usual)
    assert share_of_moves(longer, tours) == 1.0 > share_of_moves(usual, tours)
    assert longer.settings.screening.allocations == usual.settings.fixed_team.screened


FIELD = Mission(
    name="field", area=MultiPolygon([box(0, 0, 24, 18)]), period_s=80,
    fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=2.5)), planning=PatrolSettings(effort="quick"),
)  # fmt: skip


@pytest.fixture(scope="module")
def lanes() -> Reached:
    """One robot on lanes that are too narrow, with one and a half times the period."""
    search = search_on(replace(FIELD, period_s=120))
    places = [(x, y) for i, x in enumerate(range(2, 23, 3)) for y in ((4.0, 17.0), (17.0, 4.0))[i % 2]]
    vertices = np.array([*places, (22.5, 4.0), (22.5, 1.5), (1.5, 1.5)], dtype=np.float64)
    tours = [Tour(vertices_m=vertices, period_class=0, period_s=120.0, robots=1, robot=search.problem.robot)]
    plan = plan_of(search.problem, tours, seed=0)
    return reach_of(Repaired(tours=tours, plan=plan, verdict=check_plan(plan), extra=no_points()), 1.5)


def test_shorter_loops_see_everything_sooner(lanes: Reached) -> None:
    told: list[str] = []
    search = replace(search_on(FIELD), progress=lambda _share, what: told.append(what))
    shorter = with_shorter_loops(search, lanes)
    assert not told  # the search for the least ratio tells how far it is
    assert shorter.repaired.met
    assert shorter.stretch == lanes.stretch
    assert shorter.ratio < 0.85 * lanes.ratio
    worst_s = max(demand.worst_gap_s for demand in check_plan(shorter.repaired.plan).demands)
    assert shorter.ratio * 80 == pytest.approx(worst_s)


def test_nested_loops_and_lanes_asked_for_stay(lanes: Reached) -> None:
    search = search_on(FIELD)
    tours = [replace(tour, nest=0) for tour in lanes.repaired.tours]
    nested = replace(lanes, repaired=replace(lanes.repaired, tours=tours))
    assert with_shorter_loops(search, nested) is nested
    by_lanes = search_on(replace(FIELD, planning=PatrolSettings(effort="quick", method="parallel")))
    assert with_shorter_loops(by_lanes, lanes) is lanes


@pytest.mark.parametrize(
    ("ratios", "kept"),
    [
        ({"quick": 0.9, "normal": 0.8}, "normal"),
        ({"quick": 0.8, "normal": 0.9}, "quick"),
        ({"quick": 0.9}, "quick"),
        ({"normal": 0.9}, "normal"),
        ({}, None),
    ],
    ids=["normal is better", "quick is better", "quick alone", "normal alone", "neither"],
)
def test_more_effort_never_gives_a_greater_ratio(
    monkeypatch: pytest.MonkeyPatch, ratios: dict[str, float], kept: str | None
) -> None:
    """A robot that stays sees all of its ground at once: how long its demand's worst gap is, is told by the judge."""
    normal = replace(FIELD, planning=PatrolSettings(effort="normal"))
    team = replace(normal, fleet=replace(FIELD.fleet, robots=(FIELD.fleet.equal_robot("ann"),)))
    found: dict[str, Plan] = {}

    def planned(context: Context, _asked: Mission, _method: object) -> Plan:
        effort = PatrolSettings.of(context.problem.mission).effort
        if effort not in ratios:
            raise NoPlanFound(effort)
        stay = Trajectory(robot="ann", times_s=np.zeros(1), positions_m=np.array([[12.0, ratios[effort]]]))
        found[effort] = Plan(mission=context.problem.mission, trajectories=(stay,))
        return found[effort]

    def judge(plan: Plan) -> Any:
        gap_s = 80 * float(plan.trajectories[0].positions_m[0, 1])
        return SimpleNamespace(demands=[SimpleNamespace(period_s=80.0, worst_gap_s=gap_s)], verdict="met")

    monkeypatch.setattr(planner, "plan_with_effort", planned)
    monkeypatch.setattr(planner, "lanes_of_team", lambda *_: None)
    search = replace(search_on(team), judge=judge)
    if kept is None:
        with pytest.raises(NoPlanFound, match="normal"):
            plan_fixed_team(search, team, fewest_robots_anywhere)
        return
    plan = plan_fixed_team(search, team, fewest_robots_anywhere)
    assert plan.trajectories == found[kept].trajectories
    assert plan.mission is search.problem.mission


@pytest.mark.slow  # a whole search
def test_the_first_plan_of_a_team_with_time_to_spare_is_lanes_from_its_starts() -> None:
    starts = [(1.0, 1.0), (3.0, 1.0)]
    robots = [Robot(name=name, start=start) for name, start in zip(("ann", "bob"), starts, strict=True)]
    fleet = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=2.5), body_radius_m=0.2, robots=robots)
    mission = replace(FIELD, period_s=200, fleet=fleet)
    doing, told = [""], list[tuple[str, Plan]]()
    search_plan(
        mission,
        progress=lambda _share, what: doing.__setitem__(0, what),
        on_better=lambda plan, report: told.append((doing[0], plan)) if report.verdict == "met" else None,
    )
    first_doing, first = told[0]
    assert first_doing == "sweeping in lanes"
    assert first.mission == mission
    assert {tuple(one.positions_m[0].tolist()) for one in first} == set(starts)


def test_a_team_that_has_a_plan_of_lanes_looks_no_further_once_it_is_to_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    mission = replace(FIELD, period_s=200, fleet=replace(FIELD.fleet, robots=2))

    def searched_on(*_: object) -> Plan:
        raise AssertionError("searched on after the stop")

    monkeypatch.setattr(planner, "plan_with_effort", searched_on)
    passed = list[Plan]()
    plan = search_plan(
        mission,
        on_better=lambda plan, report: passed.append(plan) if report.verdict == "met" else None,
        should_stop=lambda: bool(passed),
    ).plan
    assert check_plan(plan).verdict == "met"
    assert plan.lower_bound_robots == 1
