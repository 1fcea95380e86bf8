"""The plan with which a search begins: it passes soon, with few robots, and never with a crowd."""

from __future__ import annotations

from dataclasses import replace

import pytest
from benchmarks.random_missions import random_mission
from shapely import MultiPolygon, Point, box
from tests.planners.patrol.searching import YARD, search_on

from rota.check import check_plan
from rota.model.mission import Obstacle, Zone
from rota.model.plan import Plan
from rota.planners.patrol.efforts import EARLY
from rota.planners.patrol.methods.sweeping import first_plan, methods
from rota.planners.patrol.methods.sweeping.first_plan import apart_m, sweep
from rota.planners.patrol.verdict import Verdict


def test_robots_that_repairs_ask_for_are_tried_without_afterwards(monkeypatch: pytest.MonkeyPatch) -> None:
    judged: list[Plan] = []

    def judge(plan: Plan) -> object:
        judged.append(plan)
        return check_plan(plan)

    context = replace(search_on(random_mission(27)), judge=judge)  # type: ignore[arg-type]
    lanes = sweep(context, EARLY)
    assert lanes is not None
    assert lanes.met
    verdicts = [(len(plan.trajectories), check_plan(plan).verdict) for plan in judged]
    first = next(robots for robots, verdict in verdicts if verdict == "met")
    assert lanes.robots < first
    late = sweep(replace(context, should_stop=lambda: True), EARLY)
    assert late is not None
    assert late.robots == first  # who was stopped before takes the first plan
    monkeypatch.setattr(first_plan, "with_robots_of", lambda _proposal, _context, lanes: lanes)
    sure = sweep(context, EARLY)
    assert sure is not None
    assert sure.met
    assert sure.robots == first


def test_no_ground_gets_lanes_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    zone = Zone(name="gate", period_s=30, shape=MultiPolygon([box(20, 10, 28, 18)]))
    asked: list[float] = []
    best_route = methods.best_route

    def noted(*args: object, **kwargs: object) -> object:
        asked.append(args[2].area)  # type: ignore[attr-defined]
        return best_route(*args, **kwargs)  # type: ignore[arg-type]

    monkeypatch.setattr(methods, "best_route", noted)
    lanes = sweep(search_on(replace(YARD, zones=(zone,))), EARLY)
    assert lanes is not None
    assert lanes.met
    assert len(asked) == len(set(asked))


def test_an_urgent_zone_has_robots_that_hardly_move_and_the_rest_lanes() -> None:
    zone = Zone(name="gate", period_s=0.9, shape=MultiPolygon([box(20, 10, 22, 12)]))
    lanes = sweep(search_on(replace(YARD, zones=(zone,))), EARLY)
    assert lanes is not None
    assert lanes.met
    assert min(tour.period_s for tour in lanes.tours) == 0.9


def test_a_crowd_is_no_first_plan() -> None:
    hurried = replace(YARD, period_s=0.1)
    assert sweep(search_on(hurried), EARLY) is None
    calm = sweep(search_on(YARD), EARLY)
    assert calm is not None
    assert all(apart_m(tour) > 0.25 * 2 for tour in calm.tours if tour.robots > 1)


def test_lanes_go_round_many_trunks_in_few_rounds() -> None:
    circles = [Point(x, y).buffer(0.2, quad_segs=16) for x in (5, 15, 25) for y in (4, 11, 17)]
    trunks = [Obstacle(shape=MultiPolygon([circle])) for circle in circles]
    judged: list[Plan] = []
    context = search_on(replace(YARD, obstacles=tuple(trunks)))

    def judge(plan: Plan) -> Verdict:
        judged.append(plan)
        return check_plan(plan)

    assert context.problem.lanes_overlap_m > 0
    lanes = sweep(replace(context, judge=judge), EARLY)
    assert lanes is not None
    assert lanes.met
    assert len(judged) <= 4  # eight without points behind the trunks
