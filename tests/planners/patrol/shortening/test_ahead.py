"""Loops looked for ahead are those that are found when asked for; those of plans overtaken are given up."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from dataclasses import replace

import pytest
from tests.planners.patrol.searching import YARD, search_on

from rota.check import check_plan
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.repair.repair import Repaired, plan_of
from rota.planners.patrol.shortening import ahead
from rota.planners.patrol.shortening.ahead import LoopsAhead

Improve = Callable[[Context, Repaired], Repaired]


@pytest.fixture(scope="module")
def context() -> Context:
    return search_on(YARD)


@pytest.fixture
def plan(context: Context) -> Repaired:
    """What counts as a plan that passes; its loops are not looked at here."""
    plan = plan_of(context.problem, [], seed=0)
    return Repaired(tours=[], plan=plan, verdict=replace(check_plan(plan), verdict="met"), extra=no_points())


@pytest.fixture(autouse=True)
def _two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: 2)


def instead(monkeypatch: pytest.MonkeyPatch, improve: Improve) -> list[Repaired]:
    """Let this look for better loops; returns the plans for which it is called, in their order."""
    asked: list[Repaired] = []

    def noted(context: Context, plan: Repaired) -> Repaired:
        asked.append(plan)
        return improve(context, plan)

    monkeypatch.setattr(ahead, "with_better_loops", noted)
    return asked


def test_what_was_begun_is_given_without_a_second_search(
    context: Context, plan: Repaired, monkeypatch: pytest.MonkeyPatch
) -> None:
    better = replace(plan)
    asked = instead(monkeypatch, lambda _context, _plan: better)
    with LoopsAhead() as loops:
        loops.begin(context, plan)
        loops.begin(context, plan)
        assert loops.of(context, plan) is better
    assert len(asked) == 1


def test_a_plan_that_was_not_begun_is_looked_at_when_asked(
    context: Context, plan: Repaired, monkeypatch: pytest.MonkeyPatch
) -> None:
    better = replace(plan)
    instead(monkeypatch, lambda _context, _plan: better)
    with LoopsAhead() as loops:
        assert loops.of(context, plan) is better


def test_loops_of_a_plan_overtaken_are_given_up(
    context: Context, plan: Repaired, monkeypatch: pytest.MonkeyPatch
) -> None:
    fewer, begun = replace(plan, tours=[]), threading.Event()

    def improve(own: Context, given: Repaired) -> Repaired:
        begun.set()
        while given is plan and not own.should_stop():
            pass
        return given

    asked = instead(monkeypatch, improve)
    with LoopsAhead() as loops:
        loops.begin(context, plan)
        assert begun.wait(10)
        loops.begin(context, fewer)
        assert loops.of(context, fewer) is fewer
    assert asked == [plan, fewer]


def test_a_plan_of_other_effort_keeps_its_mission(
    context: Context, plan: Repaired, monkeypatch: pytest.MonkeyPatch
) -> None:
    as_asked = replace(plan, plan=replace(plan.plan, mission=YARD.with_effort("high")))
    asked = instead(monkeypatch, lambda _context, given: given)
    with LoopsAhead() as loops:
        loops.begin(context, plan)
        assert loops.of(context, as_asked) is as_asked
    assert len(asked) == 1


def test_nothing_is_begun_for_plans_that_fail_or_on_one_core(
    context: Context, plan: Repaired, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = instead(monkeypatch, lambda _context, given: given)
    with LoopsAhead() as loops:
        loops.begin(context, replace(plan, verdict=replace(plan.verdict, verdict="violated")))
        monkeypatch.setattr(os, "cpu_count", lambda: 1)
        loops.begin(context, plan)
    assert asked == []


def test_an_error_on_the_way_is_raised_where_the_loops_are_asked_for(
    context: Context, plan: Repaired, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_context: Context, _plan: Repaired) -> Repaired:
        raise ArithmeticError("told")

    instead(monkeypatch, fail)
    with LoopsAhead() as loops:
        loops.begin(context, plan)
        with pytest.raises(ArithmeticError, match="told"):
            loops.of(context, plan)
