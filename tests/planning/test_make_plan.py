"""make_plan joins planner, judge and stop rule; the planners here are stand-ins, the check is the real one."""

from __future__ import annotations

import importlib
import itertools
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from shapely import box
from tests.stand_in import standing_in

from rota.check import check_plan
from rota.errors import MissionError, NoPlanFound
from rota.model.mission import DiscSensor, Fleet, Mission
from rota.model.plan import Plan, Trajectory
from rota.planning.make_plan import PlanSearch, make_plan, search_plan
from rota.planning.progress import SearchState
from rota.planning.stopping import WorkLeftError

MODULE = importlib.import_module("rota.planning.make_plan")
MISSION = Mission(
    name="yard", area=box(0, 0, 10, 10), period_s=40, fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=20))
)
GOOD = Plan(
    mission=MISSION,
    trajectories=(Trajectory(robot="robot-1", times_s=[0, 4, 8], positions_m=[[3, 5], [7, 5], [3, 5]]),),
)
TOO_FAST = Plan(
    mission=MISSION,
    trajectories=(Trajectory(robot="robot-1", times_s=[0, 1, 2], positions_m=[[3, 5], [7, 5], [3, 5]]),),
)


def use(monkeypatch: pytest.MonkeyPatch, planner: Callable[..., Plan]) -> None:
    monkeypatch.setattr(MODULE, "planner_of", standing_in(planner))


def test_the_planner_gets_mission_seed_judge_and_stop_rule(monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[tuple[float, str]] = []

    def planner(mission: Mission, *, seed: int, judge: Any, progress: Any, should_stop: Any, watch: Any) -> Plan:
        assert (mission, seed, should_stop(), watch) == (MISSION, 7, False, None)
        assert judge(TOO_FAST).verdict == "violated"
        assert judge(GOOD).verdict == "met"
        progress(0.5, "touring")
        return GOOD

    use(monkeypatch, planner)
    found = search_plan(MISSION, seed=7, progress=lambda *what: shown.append(what))
    assert found.plan is GOOD
    assert found.report.verdict == "met"
    assert not found.stopped_early
    assert shown == [(0.5, "touring")]
    assert make_plan(MISSION, seed=7) is GOOD


def test_every_plan_that_is_judged_is_told_to_those_who_watch(monkeypatch: pytest.MonkeyPatch) -> None:
    still = Trajectory(robot="robot-1", times_s=[0], positions_m=[[40, 5]])
    two = (*GOOD.trajectories, replace(GOOD.trajectories[0], robot="robot-2"))

    def planner(_mission: Mission, *, judge: Any, watch: Any, **_: Any) -> Plan:
        watch(SearchState(stage="searched", robots=3, unseen_share=0.25, late_share=0.5))
        judge(replace(GOOD, trajectories=(still,)))
        judge(replace(GOOD, trajectories=two))
        return judge(GOOD) and GOOD

    use(monkeypatch, planner)
    told: list[SearchState] = []
    search_plan(MISSION, watch=told.append)
    assert [(s.stage, s.robots, s.unseen_share, s.late_share, s.met) for s in told] == [
        ("searched", 3, 0.25, 0.5, False),
        ("checked", 1, 1.0, 0.0, False),
        ("checked", 2, 0.0, 0.0, True),
        ("checked", 1, 0.0, 0.0, True),  # once, although the search judges its outcome again
    ]


def test_late_is_told_as_a_share_of_the_period(monkeypatch: pytest.MonkeyPatch) -> None:
    # from x = 1 to x = 9 and back in 16 s, seeing 3 m: an end is out of range for 16 - 2 x 2 s, where 8 s are asked
    short_sighted = replace(
        MISSION, area=box(0, 4.99, 10, 5.01), period_s=8, fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=3))
    )
    there_and_back = Trajectory(robot="robot-1", times_s=[0, 8, 16], positions_m=[[1, 5], [9, 5], [1, 5]])
    plan = Plan(mission=short_sighted, trajectories=(there_and_back,))
    use(monkeypatch, lambda _mission, **_: plan)
    told: list[SearchState] = []
    with pytest.raises(NoPlanFound):
        search_plan(short_sighted, watch=told.append)
    (state,) = told
    assert (state.stage, state.met, state.unseen_share) == ("checked", False, 0.0)
    # told from below, by the middle of a piece at the end: somewhat less than at the end itself
    assert 0.45 < state.late_share <= (16 - 2 * 2) / 8 - 1


def test_the_plan_judged_last_is_not_judged_again(monkeypatch: pytest.MonkeyPatch) -> None:
    checked: list[Plan] = []

    def check(plan: Plan, **_: Any) -> Any:
        checked.append(plan)
        return SimpleNamespace(verdict="met")

    monkeypatch.setattr("rota.check.check_plan", check)

    def planner(_mission: Mission, *, judge: Any, **_: Any) -> Plan:
        judge(TOO_FAST)
        judge(GOOD)
        return GOOD

    use(monkeypatch, planner)
    search_plan(MISSION)
    assert checked == [TOO_FAST, GOOD]


def test_the_first_check_waits_until_its_own_work_on_the_mission_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    begun, done = threading.Event(), threading.Event()
    ready_when_checked: list[bool] = []

    def get_ready(_mission: Mission) -> None:
        begun.set()
        time.sleep(0.2)
        done.set()
        raise ValueError("what is wrong with a mission, the check tells")

    def check(_plan: Plan, **_: Any) -> Any:
        ready_when_checked.append(done.is_set())
        return SimpleNamespace(verdict="met")

    def planner(_mission: Mission, *, judge: Any, **_: Any) -> Plan:
        assert begun.wait(5)  # beside the planner
        judge(GOOD)
        return GOOD

    monkeypatch.setattr("rota.check.get_ready", get_ready)
    monkeypatch.setattr("rota.check.check_plan", check)
    use(monkeypatch, planner)
    assert search_plan(MISSION).plan is GOOD
    assert ready_when_checked == [True]


LOADED = """
import sys
import rota.check
from tests.planning import test_make_plan as here
loaded = []
rota.check.get_ready = lambda mission: None
with here.pytest.MonkeyPatch.context() as patch:
    here.use(patch, lambda *_, **__: loaded.append("rota.check.judge" in sys.modules) or here.GOOD)
    here.search_plan(here.MISSION)
assert loaded == [True]
"""


def test_the_check_is_loaded_before_the_planner_loads_beside_it() -> None:
    subprocess.run([sys.executable, "-c", LOADED], check=True, cwd=Path(__file__).parents[2])


def test_a_plan_that_the_check_does_not_pass_is_no_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    use(monkeypatch, lambda *_, **__: TOO_FAST)
    with pytest.raises(NoPlanFound, match="the check says 'violated'") as caught:
        make_plan(MISSION)
    assert caught.value.best is TOO_FAST
    # what is wrong is said, not only that something is
    assert f"({check_plan(TOO_FAST).violations[0].text()}" in str(caught.value)


def looping(_mission: Mission, *, should_stop: Callable[[], bool], **_: Any) -> Plan:
    for _round in itertools.count():
        if should_stop():
            return GOOD
    raise AssertionError


def test_a_time_limit_stops_early_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    use(monkeypatch, looping)
    found = search_plan(MISSION, time_limit_s=0.01)
    assert isinstance(found, PlanSearch)
    assert found.stopped_early


def test_the_caller_stops_early_once_for_all(monkeypatch: pytest.MonkeyPatch) -> None:
    answers = iter([False, False, True, False, False])

    def planner(_mission: Mission, *, should_stop: Callable[[], bool], **_: Any) -> Plan:
        assert [should_stop() for _ in range(5)] == [False, False, True, True, True]
        return GOOD

    use(monkeypatch, planner)
    assert search_plan(MISSION, should_stop=lambda: next(answers)).stopped_early


def test_a_failure_after_stopping_early_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def planner(_mission: Mission, *, should_stop: Callable[[], bool], **_: Any) -> Plan:
        should_stop()
        raise NoPlanFound("two zones are too far apart", best=TOO_FAST)

    use(monkeypatch, planner)
    with pytest.raises(NoPlanFound, match=r"^two zones are too far apart$"):
        make_plan(MISSION)
    with pytest.raises(NoPlanFound, match=r"^two zones are too far apart \(stopped early\)$") as caught:
        make_plan(MISSION, should_stop=lambda: True)
    assert caught.value.best is TOO_FAST


@pytest.mark.parametrize("limit_s", [0, -1, float("nan")])
def test_a_time_limit_is_greater_than_zero(limit_s: float) -> None:
    with pytest.raises(MissionError, match=r"time_limit_s: .* must be greater than 0"):
        make_plan(MISSION, time_limit_s=limit_s)


def test_each_better_plan_is_told_once_as_it_is_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    two = replace(GOOD, trajectories=(*GOOD.trajectories, replace(GOOD.trajectories[0], robot="robot-2")))
    three = replace(two, trajectories=(*two.trajectories, replace(GOOD.trajectories[0], robot="robot-3")))

    def planner(_mission: Mission, *, judge: Any, **_: Any) -> Plan:
        for plan in (TOO_FAST, two, three, TOO_FAST, GOOD):
            judge(plan)
        return GOOD

    use(monkeypatch, planner)
    told: list[tuple[Plan, str]] = []
    search_plan(MISSION, on_better=lambda plan, report: told.append((plan, report.verdict)))
    assert told == [(TOO_FAST, "violated"), (two, "met"), (GOOD, "met")]


def test_better_plans_of_equal_robots_are_told_as_those_of_the_robots_that_a_fleet_names(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fleet = MISSION.fleet
    asked = replace(MISSION, fleet=replace(fleet, robots=tuple(fleet.equal_robot(name) for name in ("ann", "bob"))))
    two = replace(GOOD, trajectories=(*GOOD.trajectories, replace(GOOD.trajectories[0], robot="robot-2")))
    three = replace(two, trajectories=(*two.trajectories, replace(GOOD.trajectories[0], robot="robot-3")))
    own = tuple(replace(one, robot=name) for one, name in zip(two.trajectories, ("ann", "bob"), strict=True))

    def planner(_mission: Mission, *, judge: Any, **_: Any) -> Plan:
        judge(three)
        judge(two)
        return replace(two, mission=asked, trajectories=own)

    use(monkeypatch, planner)
    told: list[tuple[Any, str]] = []
    search_plan(asked, on_better=lambda plan, report: told.append((plan.trajectories, report.verdict)))
    assert told == [(own, "met")]


def test_better_plans_are_told_for_the_mission_as_it_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    slack = replace(MISSION, period_s=400)
    slow = Trajectory(robot="robot-1", times_s=[0, 40, 80], positions_m=[[3, 5], [7, 5], [3, 5]])
    near_sighted = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=6))
    asked = replace(MISSION, fleet=near_sighted)
    part = replace(MISSION, area=box(0, 0, 5, 5))

    def planner(_mission: Mission, *, judge: Any, **_: Any) -> Plan:
        assert judge(Plan(mission=replace(slack, fleet=near_sighted), trajectories=(slow,))).verdict == "met"
        judge(replace(GOOD, mission=part))
        return replace(GOOD, mission=asked)

    use(monkeypatch, planner)
    told: list[tuple[Mission, str]] = []
    search_plan(asked, on_better=lambda plan, report: told.append((plan.mission, report.verdict)))
    assert told == [(asked, "violated"), (asked, "met")]


def test_a_check_ends_with_the_search_that_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    ends = threading.Event()
    checked: list[str] = []

    def planner(_mission: Mission, *, judge: Any, should_stop: Any, progress: Any, **_: Any) -> Plan:
        should_stop.stop()
        try:
            while True:
                progress(0.5, "touring")
        except WorkLeftError:
            checked.append(judge(GOOD).verdict)
        finally:
            ends.set()
        return GOOD

    use(monkeypatch, planner)
    monkeypatch.setattr("rota.planning.stopping.GRACE_S", 0.0)
    with pytest.raises(NoPlanFound, match=r"did not come to an end in time after it was to stop \(stopped early\)$"):
        search_plan(MISSION)
    assert ends.wait(60)
    assert checked == []
