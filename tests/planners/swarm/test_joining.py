"""Robots that join and leave during a run: nobody touches anybody, and who is far away is not concerned."""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.distance import pdist
from shapely import MultiPolygon, box
from tests.planners.swarm.conftest import PAPER, box_walls, in_box, scattered

from rota.check import check_plan
from rota.errors import MissionError, NoPlanFound
from rota.files.plan_file import plan_from_text, plan_text
from rota.model.mission import DiscSensor, Fleet, Mission, Robot, StartBox
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.swarm.metrics import Observer
from rota.planners.swarm.planner import ALL_NEIGHBOURS, DECIDE, run_mission
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.state import Hearing
from rota.planning.make_plan import search_plan

ALL = PAPER._replace(neighbours=ALL_NEIGHBOURS)


@pytest.mark.parametrize("hearing", [None, Hearing(delay_steps=1, lost=0.1)], ids=["exact", "late and lossy"])
@pytest.mark.parametrize("decide", DECIDE.values(), ids=DECIDE)
def test_bodies_stay_apart_while_robots_come_and_go(decide, hearing) -> None:
    rng = np.random.default_rng(5)
    swarm = in_box(scattered(60, 1, 40, 1.05, seed=5), (60, 60), rule=ALL, decide=decide, hearing=hearing)
    for _ in range(80):
        present = swarm.present
        going = rng.choice(np.flatnonzero(present), 3, replace=False)
        swarm.leave(going)
        coming = rng.choice(np.flatnonzero(~present), min(3, int((~present).sum())), replace=False)
        swarm.join(coming)
        before = swarm.places_m
        swarm.step()
        for part in np.linspace(0, 1, 4):
            assert pdist(before + part * (swarm.places_m - before)).min() >= 1 - 1e-12
        assert (np.minimum(swarm.places_m, 60 - swarm.places_m) >= 0.5 - 1e-12).all()
        away = ~swarm.present
        assert (swarm.places_m[away] == before[away]).all()
        assert (swarm.velocities_m_s[away] == 0).all()


@pytest.mark.parametrize("decide", DECIDE.values(), ids=DECIDE)
def test_robots_whose_bodies_vanish_leave_a_swarm_of_the_others(decide) -> None:
    places = scattered(30, 5, 90, 1.2, seed=2)
    some = in_box(places, rule=ALL, decide=decide)
    some.leave(np.arange(20, 30), bodies_stay=False)
    fewer = in_box(places[:20], rule=ALL, decide=decide)
    for _ in range(40):
        some.step()
        fewer.step()
    assert some.places_m[:20] == pytest.approx(fewer.places_m, abs=1e-9)
    assert (some.places_m[20:] == places[20:]).all()


@pytest.mark.parametrize("decide", DECIDE.values(), ids=DECIDE)
def test_robots_far_away_are_not_concerned(decide) -> None:
    near, far = scattered(12, 5, 60, 1.2, seed=1), scattered(12, 700, 760, 1.2, seed=2)
    runs = []
    for leaving in (False, True):
        swarm = in_box(np.vstack([near, far]), (800, 800), rule=ALL, decide=decide)
        for step in range(30):
            if leaving and step == 10:
                swarm.leave([0, 5])
            if leaving and step == 20:
                swarm.join([5])
            swarm.step()
        runs.append(swarm.places_m)
    assert (runs[0][12:] == runs[1][12:]).all()
    assert (runs[0][:12] != runs[1][:12]).any()


@pytest.mark.parametrize("decide", DECIDE.values(), ids=DECIDE)
def test_permuting_the_robots_permutes_who_comes_and_goes(decide) -> None:
    places, order = scattered(25, 5, 90, 1.2, seed=4), np.random.default_rng(0).permutation(25)
    place_of = np.argsort(order)
    plain, mixed = (in_box(at, rule=ALL, decide=decide) for at in (places, places[order]))
    for step in range(30):
        if step == 8:
            plain.leave([3, 7])
            mixed.leave(place_of[[3, 7]])
        if step == 16:
            plain.join([7])
            mixed.join(place_of[[7]])
        plain.step()
        mixed.step()
    assert mixed.places_m == pytest.approx(plain.places_m[order], abs=1e-6)


def test_the_others_cover_what_a_robot_leaves_behind() -> None:
    swarm = in_box([[30, 50], [70, 50]], (100, 100), rule=ALL, decide=DECIDE["settle"], neighbour_range_m=50)
    observer = Observer(swarm, MultiPolygon([box(0, 0, 100, 100)]), 1e-5)
    for _ in range(300):
        swarm.step()
        observer.note(0.0)
    both = swarm.places_m
    swarm.leave([1])
    swarm.step()
    observer.note(0.0)
    covered = observer.history().coverage
    assert covered[-1] == pytest.approx(np.pi * 25**2 / 100**2, abs=2e-3)  # one disc
    assert covered[-2] > 1.9 * covered[-1]
    assert pdist(both)[0] > 49.9


def test_a_join_without_room_is_refused_and_nobody_joins() -> None:
    swarm = in_box([[10, 10], [20, 20], [30, 30]])
    swarm.leave([0, 1], bodies_stay=False)
    with pytest.raises(
        MissionError, match=r"robot 1 at \[30.4, 30\]: there is no room to join.*overlaps another one by 0.6 m"
    ):
        swarm.join([0, 1], [[10, 10], [30.4, 30]])
    with pytest.raises(MissionError, match=r"robot 0 at \[40, 40\].*overlaps another one by 1 m"):
        swarm.join([0, 1], [[40, 40], [40, 40]])
    with pytest.raises(MissionError, match=r"robot 0 at .*outside the free space or in a wall"):
        swarm.join([0], [[0.4, 10]])
    with pytest.raises(MissionError, match=r"robot 0 at .*outside the free space"):
        swarm.join([0], [[-9, 10]])
    with pytest.raises(MissionError, match="must be finite"):
        swarm.join([0], [[np.nan, 10]])
    with pytest.raises(MissionError, match="robot 2: takes part already"):
        swarm.join([2])
    with pytest.raises(MissionError, match="different numbers from 0 to 2"):
        swarm.leave([3])
    assert swarm.present.tolist() == [False, False, True]
    swarm.join([0, 1], [[10, 10], [31, 30]])
    assert swarm.present.all()
    hole = np.vstack([box_walls(100, 100), box_walls(20, 20) + 40])
    holed = in_box([[10, 10]], walls=hole)
    holed.leave([0], bodies_stay=False)
    with pytest.raises(MissionError, match="outside the free space"):
        holed.join([0], [[50, 50]])


# ---------------------------------------------------------------- missions


def mission(times: dict[int, tuple[float, float | None]], robots: int = 12, **changed: Any) -> Mission:
    fleet = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=25), body_radius_m=0.5)
    listed = [fleet.equal_robot(f"r{k}") for k in range(robots)]
    for k, (joins, leaves) in times.items():
        listed[k] = dataclasses.replace(listed[k], joins_s=joins, leaves_s=leaves)
    start = StartBox(low_m=(1, 1), high_m=(40, 40))
    fleet = dataclasses.replace(fleet, robots=tuple(listed), start=start)
    area = MultiPolygon([box(0, 0, 150, 150)])
    return Mission(**{"name": "m", "area": area, "fleet": fleet, "planning": SwarmSettings()} | changed)


TIMES = {0: (10.1, None), 3: (0.0, 17.3), 4: (5.0, 40.0), 7: (150.0, None)}


@pytest.mark.parametrize("controller", ["settle", "reciprocal"])
def test_a_plan_in_which_robots_come_and_go_passes_the_check(controller: Any) -> None:
    found = search_plan(mission(TIMES, planning=SwarmSettings(controller=controller, most_steps=1500)), seed=1)
    assert found.report.violations == ()
    ways = {t.robot: t for t in found.plan}
    for name, (joins, leaves) in {f"r{k}": times for k, times in TIMES.items()}.items():
        t = ways[name]
        moving = np.flatnonzero((np.diff(t.positions_m, axis=0) != 0).any(axis=1))
        assert len(moving) or controller == "reciprocal"  # whose empty sets leave some where they are
        if not len(moving):
            continue
        assert t.times_s[moving[0]] >= joins
        assert leaves is None or t.times_s[moving[-1] + 1] <= leaves
        assert t.loop_start_s >= joins
    assert plan_from_text(plan_text(found.plan), "plan") == found.plan
    everybody = run_mission(mission({}, planning=SwarmSettings(controller=controller, most_steps=1500)), seed=1).plan
    assert plan_text(everybody) != plan_text(found.plan)
    assert "joins_s" not in plan_text(everybody)


def test_robots_that_join_after_the_last_step_hold_and_see_from_then_on() -> None:
    plan = run_mission(mission({2: (1000.0, None)}, planning=SwarmSettings(most_steps=20)), seed=1).plan
    assert plan.trajectories[2].loop_start_s == 1000
    assert check_plan(plan).violations == ()


def test_a_demand_that_only_a_leaver_could_meet_is_not_met() -> None:
    lone = mission({0: (0.0, 50.0)}, robots=1, period_s=10, area=MultiPolygon([box(0, 0, 30, 30)]))
    with pytest.raises(NoPlanFound, match="violated"):
        search_plan(lone)
    stays = mission({}, robots=1, period_s=10, area=MultiPolygon([box(0, 0, 30, 30)]))
    assert search_plan(stays).report.verdict == "met"


@cache
def text_without_a_stop() -> str:
    return plan_text(run_mission(mission(TIMES, planning=SwarmSettings(most_steps=700)), seed=3).plan)


@pytest.mark.parametrize("stop", [19, 20, 21, 40, 68, 69, 70, 160, 300])
def test_robots_come_and_go_after_a_stop_as_without_one(stop: int) -> None:
    asked = mission(TIMES, planning=SwarmSettings(most_steps=700))
    calls = iter(range(10**6))
    state = run_mission(asked, seed=3, should_stop=lambda: next(calls) >= stop).state
    assert state.steps == stop
    assert plan_text(run_mission(asked, seed=3, resume=state).plan) == text_without_a_stop()


def test_times_that_cannot_be_are_refused() -> None:
    like = {"name": "a", "speed_m_s": 2, "sensor": DiscSensor(radius_m=25)}
    with pytest.raises(MissionError, match=r"robot a: joins_s: -1"):
        Robot(**like, joins_s=-1)
    with pytest.raises(MissionError, match=r"robot a: leaves_s: 5.*must come after joins_s, 5"):
        Robot(**like, joins_s=5, leaves_s=5)
    with pytest.raises(MissionError, match="only robots of a swarm join or leave"):
        mission({0: (3.0, None)}, planning=PatrolSettings(), period_s=100)
