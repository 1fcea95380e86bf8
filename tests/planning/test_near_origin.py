"""Plans do not depend on where the map's origin lies."""

from __future__ import annotations

import importlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from shapely import box
from tests.stand_in import standing_in

import rota
from rota import (
    CheckpointError,
    DiscSensor,
    Fleet,
    Mission,
    MissionError,
    MotionLimits,
    NoPlanFound,
    Obstacle,
    PatrolSettings,
    Plan,
    Robot,
    SwarmSettings,
    Trajectory,
    Zone,
    check_plan,
    make_plan,
    replan,
    search_plan,
)
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, Lane, StartBox
from rota.planning.near_origin import _Way

MODULE = importlib.import_module("rota.planning.make_plan")
UTM_M = np.array([532_000.0, 5_941_000.0])
TO_UTM = _Way((-UTM_M[0], -UTM_M[1]))
FLEET = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=4))
YARD = Mission(
    name="yard", area=box(0, 0, 30, 20), period_s=60, fleet=FLEET, planning=PatrolSettings(effort="quick"),
    zones=(Zone(name="gate", period_s=20, shape=box(20.5, 0, 30, 9.25)),),
)  # fmt: skip
MISSIONS = {
    "zone": YARD,
    "mass": replace(YARD, zones=(), fleet=replace(FLEET, motion=MotionLimits(acceleration_m_s2=1.0))),
    "radius": replace(
        YARD, zones=(), area=box(0, 0, 24, 16), fleet=replace(FLEET, sensor=DiscSensor(radius_m=6), turn_radius_m=1.0)
    ),
    "swarm": replace(
        YARD, zones=(), period_s=None, planning=SwarmSettings(),
        fleet=replace(FLEET, robots=6, body_radius_m=0.2, start=StartBox(low_m=(1, 1), high_m=(4, 4))),
    ),
}  # fmt: skip


def apart_m(plan: Plan, far: Plan) -> float:
    """How far the places of two plans are apart, where one is moved to the other."""
    assert [one.robot for one in plan] == [one.robot for one in far]
    moved = zip(plan, far, strict=True)
    return max(float(np.abs(one.positions_m + UTM_M - other.positions_m).max()) for one, other in moved)


@pytest.mark.parametrize("name", MISSIONS)
def test_the_same_plan_is_found_at_utm_coordinates(name: str) -> None:
    plan, far = make_plan(MISSIONS[name]), make_plan(TO_UTM.here(MISSIONS[name]))
    assert apart_m(plan, far) < 1e-6
    assert far.mission == TO_UTM.here(MISSIONS[name])
    assert check_plan(far).verdict == "met"


def test_robots_that_take_over_do_so_anywhere_alike() -> None:
    ring = [Trajectory(robot=f"robot-{k}", times_s=[0, 15, 30], positions_m=[[5, k], [25, k], [5, k]]) for k in (5, 15)]
    plan = Plan(mission=YARD, trajectories=tuple(ring))
    found = [replan(each, at_s=7, lost=["robot-5"], should_stop=lambda: True) for each in (plan, TO_UTM.here(plan))]
    assert apart_m(found[0].plan, found[1].plan) < 1e-6
    assert found[0].kept == found[1].kept
    driven = [each.plan.seam.driven for each in found if each.plan.seam]
    assert all(np.array_equal(a.positions_m + UTM_M, b.positions_m) for a, b in zip(*driven, strict=True))


def test_a_swarm_stopped_far_away_goes_on_bit_for_bit_and_one_that_an_earlier_rota_stopped_begins_anew() -> None:
    far = TO_UTM.here(MISSIONS["swarm"])
    few = replace(far, planning=SwarmSettings(most_steps=9))
    run = search_plan(few, seed=1).checkpoint
    assert run is not None
    assert run.mission == few
    resumed, whole = search_plan(far, seed=1, resume=run).plan, make_plan(far, seed=1)
    assert [one.positions_m.tolist() for one in resumed] == [one.positions_m.tolist() for one in whole]
    earlier = replace(run, places_m=run.places_m + UTM_M, recent_m=run.recent_m + UTM_M)
    with pytest.raises(CheckpointError, match="begin anew"):
        search_plan(far, seed=1, resume=earlier)
    with pytest.raises(CheckpointError, match="another mission: area differs"):
        search_plan(replace(far, area=far.area.buffer(1)), seed=1, resume=run)


def test_a_swarm_that_charges_keeps_its_speed_far_away() -> None:
    swarm = MISSIONS["swarm"]
    fleet = replace(
        swarm.fleet, robots=5, speed_m_s=0.3, sensor=DiscSensor(radius_m=5),
        battery=BatteryLimits(endurance_s=1200, recharge_s=300),
    )  # fmt: skip
    pad = Charger(name="pad", at=(33.37, 21.2), places=3)
    near = replace(swarm, area=box(0, 0, 60, 50), fleet=fleet, chargers=(pad,))
    assert check_plan(make_plan(TO_UTM.here(near), seed=0)).verdict == "met"


def everywhere() -> Mission:
    """A mission with a place in every field that has some."""
    fleet = replace(
        FLEET, entrances=((1, 1),), rally_points=((2, 3),),
        battery=BatteryLimits(endurance_s=90, recharge_s=20),
    )  # fmt: skip
    return replace(
        YARD, fleet=fleet, obstacles=(Obstacle(shape=box(3, 4, 5, 6)),), chargers=(Charger(name="pad", at=(1, 1)),)
    )


def planner_sees(monkeypatch: pytest.MonkeyPatch, mission: Mission) -> Mission:
    """What a planner is asked to plan."""
    seen: list[Mission] = []

    def planner(mission: Mission, **_: Any) -> Plan:
        seen.append(mission)
        raise NoPlanFound("nobody sees (1.50, 2) and (3e1, -4.25), a share of (2)")

    monkeypatch.setattr(MODULE, "planner_of", standing_in(planner))
    with pytest.raises(NoPlanFound):
        make_plan(mission)
    return seen[0]


def test_all_places_of_a_far_mission_are_moved_and_come_back(monkeypatch: pytest.MonkeyPatch) -> None:
    mission = everywhere()
    far = TO_UTM.here(mission)
    assert far.chargers[0].at == (532_001, 5_941_001)
    assert far.fleet.entrances == ((532_001, 5_941_001),)
    assert planner_sees(monkeypatch, far) == mission
    for start in ({"start": StartBox(low_m=(1, 1), high_m=(3, 2))}, {"robots": (Robot(name="a", start=(1.5, 2)),)}):
        begun = replace(YARD, fleet=replace(FLEET, **start))  # type: ignore[arg-type]
        assert planner_sees(monkeypatch, TO_UTM.here(begun)) == begun
    post = Zone(name="post", period_s=90, demand="visit", shape=box(1, 1, 2, 2))
    lanes = replace(YARD, period_s=None, zones=(post,), lanes=(Lane(line_m=((1, 1), (9, 5))),))
    assert planner_sees(monkeypatch, TO_UTM.here(lanes)) == lanes


@pytest.mark.parametrize("by_m", [0.0, 250.0])
def test_a_near_mission_comes_as_it_is(monkeypatch: pytest.MonkeyPatch, by_m: float) -> None:
    mission = _Way((-by_m, by_m)).here(YARD)
    assert planner_sees(monkeypatch, mission) is mission


def test_what_planners_say_and_are_told_of_places_is_where_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    ways = (Trajectory(robot="robot-1", times_s=[0.0], positions_m=[[4, 5]]),)

    def planner(mission: Mission, *, judge: Any, **_: Any) -> Plan:
        plan = Plan(mission=mission, trajectories=ways)
        told = judge(plan)
        assert told.verdict == "violated"
        places = [told.unmet_points_m, told.shown_unmet_m, [one.place_m for one in told.violations if one.place_m]]
        assert all(len(each) and np.all((np.array(each) >= 0) & (np.array(each) <= 30)) for each in places)
        raise NoPlanFound("nobody sees (1.50, 2) or (3e1, -4.25), twice (2)", best=plan)

    monkeypatch.setattr(MODULE, "planner_of", standing_in(planner))
    with pytest.raises(NoPlanFound) as failure:
        make_plan(TO_UTM.here(YARD))
    assert str(failure.value) == "nobody sees (532001.5, 5941002) or (532030, 5940995.75), twice (2)"
    assert isinstance(failure.value.best, Plan)
    assert failure.value.best["robot-1"].positions_m.tolist() == [[532_004, 5_941_005]]
    assert isinstance(failure.value.report, rota.Report)
    assert failure.value.report.unmet_points_m.min() > 500_000


def test_missions_that_planners_refuse_are_told_line_by_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def planner(mission: Mission, **_: Any) -> Plan:
        raise MissionError("at (1, 2) is a wall", "so it is", "start: [1, 2]", "box: [[0, 0], [2.5, 3]] is full")

    monkeypatch.setattr(MODULE, "planner_of", standing_in(planner))
    with pytest.raises(MissionError) as failure:
        make_plan(TO_UTM.here(YARD))
    assert failure.value.faults == (
        "at (532001, 5941002) is a wall", "so it is", "start: [532001, 5941002]",
        "box: [[532000, 5941000], [532002.5, 5941003]] is full",
    )  # fmt: skip


def test_plans_with_legs_from_rest_may_be_moved_to_the_origin_again() -> None:
    rng = np.random.default_rng(5)
    legs_m = rng.uniform(1e-4, 1e-2, (200, 2))
    places_m = np.cumsum(np.vstack([np.zeros(2), legs_m, -legs_m.sum(axis=0)]), axis=0)
    places_m[-1] = places_m[0]
    times_s = np.concatenate([[0.0], np.cumsum(rng.uniform(0.5, 2.0, 201))])
    from_rest = 2 * np.hypot(*np.diff(places_m, axis=0).T) / np.diff(times_s) ** 2
    one = Trajectory(robot="r", times_s=times_s, positions_m=places_m, accelerations_m_s2=from_rest)
    far = _Way((UTM_M[0], UTM_M[1])).there(one)  # where rounding makes legs shorter
    way = _Way((UTM_M[0], UTM_M[1]))
    near = way.here(far)
    assert near.accelerations_m_s2 == pytest.approx(from_rest, rel=1e-4)
    assert way.there(near) is far
