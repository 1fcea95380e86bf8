"""Plans that take over: closed forms on a ring, beside time sampling, and changes that cannot be."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from benchmarks.time_sampling import Sampled, lattice
from tests.replanning.relays import relay
from tests.replanning.rings import ROUND_S, ring_mission, ring_plan
from tests.seeds import seeds

import rota
from rota import (
    DiscSensor,
    Fleet,
    Mission,
    MissionError,
    NoPlanFound,
    Obstacle,
    PatrolSettings,
    Plan,
    Replanned,
    Trajectory,
    Zone,
    check_plan,
    make_plan,
    replan,
)
from rota.model.mission import Lane
from rota.replanning.replan import first_plan

PAIR = ring_plan(30, {"a": 0.0, "b": 20.0})


MASS = rota.MotionLimits(acceleration_m_s2=1000.0, corner_acceleration_m_s2=1000.0)


def first_answer(plan: Plan, **change: object) -> Replanned:
    """The first plan that takes over."""
    return replan(plan, should_stop=lambda: True, **change)  # type: ignore[arg-type]


def test_where_nothing_changes_all_go_on() -> None:
    found = replan(PAIR, at_s=1003.5)
    assert (found.kept, found.report.verdict, found.stopped_early) == (("a", "b"), "met", False)
    assert found.report.lateness is not None
    assert (found.report.lateness.worst.worst_s, found.report.lateness.holds_again_s) == (0, 0)  # type: ignore[union-attr]
    for name in ("a", "b"):
        moments = np.linspace(0, 100, 777)
        assert np.abs(found.plan[name].at(moments) - PAIR[name].at(1003.5 + moments)).max() < 1e-9


def test_one_of_two_is_not_enough_and_the_rest_goes_on() -> None:
    # one robot comes round in 40 s; of a place 0.3 m off its way it sees each half sqrt(1.2^2 - 0.3^2) m of it at least
    found = first_answer(PAIR, at_s=100, lost=["b"])
    assert found.report.verdict == "violated"
    assert found.plan["a"].loop_duration_s == pytest.approx(ROUND_S, rel=1e-9)
    assert found.report.worst_ratio_at_least == pytest.approx((ROUND_S - 2 * (1.2 - 0.3)) / 30, abs=0.06)
    assert found.plan.seam is not None
    assert (found.plan.seam.lost, found.plan.seam.at_s) == (("b",), 100)


def test_one_of_two_is_enough_where_the_period_is_long() -> None:
    found = replan(replace(PAIR, mission=ring_mission(45, ("a", "b"))), at_s=100, lost=["b"])
    assert (found.report.verdict, found.kept) == ("met", ("a",))
    assert found.report.lateness is not None
    assert found.report.lateness.late_m2_s == 0


def test_two_of_three_spread_evenly_and_are_late_as_little_as_can_be() -> None:
    # at thirds of a round the gaps left are 13.3 and 26.7 s, less what is seen ahead and behind: 26.7 is too long for
    # ever. Who waits 6.7 s behind the gap is right; meanwhile that one place waits 13.3 + 6.7 s: nobody need be late
    plan = ring_plan(24, {"a": 0.0, "b": 40 / 3, "c": 80 / 3})
    found = replan(plan, at_s=57, lost=["b"])
    assert found.report.verdict == "met"
    sampled = Sampled(found.plan, lattice(found.plan.mission, 0.3), 0.1, 120.0)
    assert found.report.lateness is not None
    assert found.report.lateness.worst is not None
    assert sampled.worst_s - 0.2 <= found.report.lateness.worst.worst_s <= sampled.worst_s + 0.5
    # what b would have seen next waits 13.3 s for the one behind, and until then it was seen 13.3 s ago
    assert found.report.lateness.worst.worst_s <= 80 / 3 - 24
    assert found.report.lateness.holds_again_s is not None
    assert found.report.lateness.holds_again_s <= 2 * 24


def test_a_new_robot_takes_the_place_of_a_lost_one() -> None:
    # it stands 5 m ahead of where the lost one would be: who waits a little for the other closes the gap in time
    found = replan(PAIR, at_s=70, lost=["b"], joined={"c": (10.0, 5.0)}, time_limit_s=5)
    assert found.report.verdict == "met"
    assert found.report.lateness is not None
    assert found.report.lateness.holds_again_s == 0
    assert Sampled(found.plan, lattice(found.plan.mission, 0.3), 0.1, 120.0, more_m=0.05).worst_s == 0
    assert tuple(found.plan["c"].positions_m[0]) == (10.0, 5.0)


def test_a_late_robot_goes_on_late() -> None:
    found = first_answer(PAIR, at_s=50, late={"b": 4.0})
    assert found.plan.seam is not None
    was = {driven.robot: driven for driven in found.plan.seam.driven}["b"]
    for back in (0.0, 3.3, 17.0):
        place = [np.interp(-back, was.times_s, was.positions_m[:, axis]) for axis in (0, 1)]
        assert np.abs(PAIR["b"].at(50 - 4 - back) - place).max() < 1e-9
    assert np.abs(found.plan["b"].positions_m[0] - PAIR["b"].at(46)).max() < 1e-9


def test_a_shorter_period_is_asked_from_the_change_on() -> None:
    zone = Zone(name="gate", period_s=22, demand="visit", shape=shapely.MultiPolygon([shapely.box(4, -0.3, 6, 0.3)]))
    changed = replace(PAIR.mission, zones=(zone,))
    found = replan(PAIR, at_s=33, mission=changed)
    assert found.report.verdict == "met"
    assert [demand.name for demand in found.report.demands] == ["gate", "area"]


def test_bodies_stay_apart_on_the_way() -> None:
    plan = ring_plan(24, {"a": 0.0, "b": 40 / 3, "c": 80 / 3}, body_radius_m=0.25)
    found = replan(plan, at_s=57, lost=["b"], time_limit_s=10)
    sampled = Sampled(found.plan, np.zeros((0, 2)), 0.05, 120.0)
    assert sampled.nearest_m >= 2 * 0.25
    assert found.report.verdict == "met"


YARD = Mission(
    name="yard", area=shapely.MultiPolygon([shapely.box(0, 0, 24, 16)]), period_s=40,
    obstacles=(Obstacle(shape=shapely.MultiPolygon([shapely.box(8, 5, 12, 9)])),),
    fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=2)), planning=PatrolSettings(effort="quick"),
)  # fmt: skip


@pytest.fixture(scope="module")
def yard() -> Plan:
    return make_plan(YARD, seed=1)


@pytest.mark.parametrize("seed", seeds(4, at_once=1))
def test_random_losses_beside_time_sampling(yard: Plan, seed: int) -> None:
    random = np.random.default_rng(seed)
    names = [one.robot for one in yard]
    lost = [names[random.integers(len(names))]] if seed < 3 else []
    hole = shapely.MultiPolygon([shapely.box(17, 1, 19, 3)])
    changed = replace(YARD, obstacles=(*YARD.obstacles, Obstacle(shape=hole, blocks="motion"))) if seed == 3 else None
    found = first_answer(yard, at_s=float(random.uniform(0, 200)), lost=lost, mission=changed)
    report = check_plan(found.plan)
    lateness = report.lateness
    assert lateness is not None
    assert lateness.worst is not None
    assert [one.kind for one in report.violations if one.kind != "gap"] == []
    until_s = max(one.times_s[-1] for one in found.plan) + 100
    # a step is 0.2 m long: what is in reach for a moment only may be missed but for so much more of it
    sampled = Sampled(found.plan, lattice(found.plan.mission, 0.5), 0.1, until_s, more_m=0.11)
    assert sampled.worst_s <= lateness.worst.worst_s + 0.2
    if lateness.worst.place_m is not None and math.isfinite(lateness.worst.worst_at_least_s):
        place = np.array([lateness.worst.place_m])
        less, more = (Sampled(found.plan, place, 0.05, until_s, more_m=by).worst_s for by in (0.06, -0.06))
        assert less - 0.2 <= lateness.worst.worst_at_least_s
        assert report.verdict == "violated" or lateness.worst.worst_at_least_s <= more + 0.2
    if report.verdict == "met":
        assert lateness.holds_again_s is not None
        assert sampled.last_s <= lateness.holds_again_s + 0.2


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"at_s": math.nan}, "at_s: nan is not allowed"),
        ({"at_s": -1}, "at_s: -1.0 is not allowed"),
        ({"at_s": 5, "lost": ["d"]}, "lost: robot 'd' is not in the plan; the plan has a, b"),
        ({"at_s": 5, "lost": ["a", "b"]}, "no robot remains"),
        ({"at_s": 5, "joined": {"a": (0, 0)}}, "joined: robot 'a' is in the plan already"),
        ({"at_s": 5, "joined": {"c": (math.nan, 0)}}, "joined: c=nan,0 is not allowed"),
        ({"at_s": 5, "joined": {"c": (5, 5)}}, r"robot c: at t = 5 s it is at \(5.00, 5.00\).* it can go to"),
        ({"at_s": 5, "late": {"c": 1}}, "late: robot 'c' is not in the plan"),
        ({"at_s": 5, "late": {"a": math.inf}}, "late: a=inf is not allowed"),
        ({"at_s": 5, "time_limit_s": 0}, "time_limit_s: 0 is not allowed"),
        ({"at_s": 5, "mission": ring_mission(30, ("a",))}, "'b' is not among those of the changed mission"),
        ({"at_s": 5, "mission": ring_mission(30, ("a", "b", "z"))}, "'z' of the changed mission is not in the plan"),
    ],
)
def test_changes_that_cannot_be_are_told(change: dict[str, object], message: str) -> None:
    with pytest.raises(MissionError, match=message):
        replan(PAIR, **change)  # type: ignore[arg-type]


def test_a_robot_where_an_obstacle_is_now_is_told_with_the_way_out() -> None:
    # b is at (10, 10) at the beginning; from 9.7 on a new wall fills that corner
    wall = Obstacle(shape=shapely.MultiPolygon([shapely.box(9, 9, 11, 11)]), blocks="motion")
    changed = replace(PAIR.mission, obstacles=(*PAIR.mission.obstacles, wall))
    with pytest.raises(MissionError, match=r"robot b: at t = 0 s it is at \(10.00, 10.00\).*1.00 m away") as told:
        replan(PAIR, at_s=0, mission=changed)
    where = str(told.value).rpartition("joined at ")[2]
    x, y = map(float, where.split(","))
    found = first_answer(PAIR, at_s=0, mission=changed, lost=["b"], joined={"b": (x, y)})
    assert {one.robot for one in found.plan} == {"a", "b"}


def test_a_place_told_to_a_new_robot_is_one_where_it_can_join() -> None:
    area = shapely.MultiPolygon([shapely.Polygon([(-0.004, -0.004), (10.004, -0.004), (10.004, 10.009), (-0.004, 10)])])
    plan = replace(PAIR, mission=replace(PAIR.mission, area=area))
    for at_m in ((30.0, 30.0), (5.0, 40.0), (5.0, 5.0)):
        with pytest.raises(MissionError, match=r"m away: give it as joined at") as told:
            replan(plan, at_s=0, joined={"c": at_m})
        x, y = map(float, str(told.value).rpartition("joined at ")[2].split(","))
        assert {one.robot for one in first_answer(plan, at_s=0, joined={"c": (x, y)}).plan} == {"a", "b", "c"}


def test_robots_that_drive_along_a_slanting_border_are_on_the_ground() -> None:
    """Places between two corners of the border are off it by rounding."""
    corners_m = np.array([[0.0, 0], [7.1, 2.3], [3.3, 9.7], [0, 0]])
    mission = Mission(
        name="slanting", area=shapely.MultiPolygon([shapely.Polygon(corners_m)]), period_s=60,
        fleet=Fleet(robots=1, speed_m_s=1, sensor=DiscSensor(radius_m=9)),
    )  # fmt: skip
    line = Trajectory(robot="robot-1", times_s=[0, 8, 17, 28], positions_m=corners_m)
    for at_s in np.linspace(0.1, 27.9, 12):
        assert replan(Plan(mission=mission, trajectories=(line,)), at_s=float(at_s)).kept == ("robot-1",)


def test_a_plan_that_took_over_can_be_taken_over() -> None:
    once = first_answer(replace(PAIR, mission=ring_mission(45, ("a", "b"))), at_s=100, lost=["b"])
    twice = replan(once.plan, at_s=12, joined={"c": (0.0, 5.0)})
    assert twice.report.verdict == "met"
    assert rota.check_plan(twice.plan).lateness is not None


def test_a_robot_that_stays_goes_on_staying() -> None:
    mission = Mission(
        name="post", area=shapely.MultiPolygon([shapely.box(0, 0, 2, 2)]), period_s=5,
        fleet=Fleet(robots=1, speed_m_s=1, sensor=DiscSensor(radius_m=2)),
    )  # fmt: skip
    stays = Trajectory(robot="robot-1", times_s=np.zeros(1), positions_m=np.ones((1, 2)))
    found = replan(Plan(mission=mission, trajectories=(stays,)), at_s=7.5)
    assert (found.report.verdict, found.kept) == ("met", ("robot-1",))


def test_robots_that_turn_slowly_take_over() -> None:
    plan = ring_plan(70, {"a": 0.0, "b": 20.0}, sensor=DiscSensor(radius_m=1.6), turn_rate_rad_s=1.0)
    turning = np.array([0.0, 10, 11.6, 21.6, 23.2, 33.2, 34.8, 44.8, 46.4])
    corners = np.array([[0, 0], [10, 0], [10, 0], [10, 10], [10, 10], [0, 10], [0, 10], [0, 0], [0, 0]], float)
    loops = tuple(
        Trajectory(robot=name, times_s=turning, positions_m=corners if name == "a" else 10 - corners)
        for name in ("a", "b")
    )
    plan = replace(plan, trajectories=loops)
    found = replan(plan, at_s=14, lost=["b"], joined={"c": (5.0, 10.0)}, time_limit_s=5)
    assert found.report.verdict == "met"


def test_robots_with_mass_go_on() -> None:
    plan = ring_plan(45, {"a": 0.0, "b": 20.0}, motion=MASS)
    found = replan(plan, at_s=33.3, lost=["b"], time_limit_s=2)
    assert (found.kept, found.report.verdict) == (("a",), "met")


def test_robots_on_lanes_share_the_places_anew() -> None:
    # a square of one-way lanes: who comes from one corner to the next goes round; two robots are half a round apart
    corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]
    lanes = tuple(Lane(line_m=(corners[k], corners[(k + 1) % 4]), one_way=True) for k in range(4))
    zones = tuple(
        Zone(name=f"corner {k}", period_s=period_s, demand="visit", shape=shapely.Point(at).buffer(0.5))
        for k, (at, period_s) in enumerate(zip(corners, (45, 45, 45, 45), strict=True))
    )
    mission = Mission(
        name="one way", area=shapely.MultiPolygon([shapely.box(-1, -1, 11, 11)]), zones=zones, lanes=lanes,
        fleet=Fleet(robots=2, speed_m_s=1, sensor=DiscSensor(radius_m=1)), planning=PatrolSettings(effort="quick"),
    )  # fmt: skip
    stops = np.arange(0, 50, 10.0)
    ring = np.array([*corners, corners[0]])
    # the first robot keeps all corners, the other one stands at a corner and goes round as well
    loops = (
        Trajectory(robot="robot-1", times_s=stops, positions_m=ring),
        Trajectory(robot="robot-2", times_s=stops, positions_m=np.roll(ring[:4], -2, axis=0)[[0, 1, 2, 3, 0]]),
    )
    plan = Plan(mission=mission, trajectories=loops)
    found = replan(plan, at_s=13.0, lost=["robot-1"])
    assert found.report.verdict == "met"
    assert found.report.lateness is not None
    # 40 s for a round, each corner seen for 0.5 m before and behind it
    assert found.report.lateness.late_m2_s == 0
    both = replan(plan, at_s=13.0, lost=["robot-1"], joined={"robot-3": (10.0, 0.0)}, time_limit_s=5)
    assert both.report.verdict == "met"
    assert [one.kind for one in check_plan(both.plan).violations] == []


def test_a_plan_that_took_over_is_replanned_with_all_that_was_driven_before() -> None:
    ring = ring_plan(45, {"a": 0.0, "b": 20.0, "c": 30.0})
    second = first_answer(first_answer(ring, at_s=100, lost=["b"]).plan, at_s=7, lost=["c"])
    seam = second.plan.seam
    assert seam is not None
    assert seam.lost == ("c", "b")
    moments = np.linspace(-60, 0, 121)
    for driven in seam.driven:
        until_s = -7.0 if driven.robot == "b" else 0.0
        assert driven.times_s[-1] == until_s
        assert driven.times_s[0] <= -60
        told = [np.interp(moments, driven.times_s, axis) for axis in driven.positions_m.T]
        was = ring[driven.robot].at(107 + np.minimum(moments, until_s))
        assert np.abs(np.column_stack(told) - was).max() < 1e-9
    # a alone comes round in 40 s: nothing is late, which is known only with what was seen before the first change
    assert second.report.lateness is not None
    assert (second.report.verdict, second.report.lateness.holds_again_s) == ("met", 0)
    tighter = first_answer(
        first_answer(ring_plan(20, {"a": 0.0, "b": 20.0}), at_s=100, lost=["b"]).plan, at_s=1, joined={"d": (0.0, 10.0)}
    )
    assert tighter.plan.seam is not None
    points = lattice(tighter.plan.mission, 0.5)
    sampled = Sampled(tighter.plan, points, 0.02, 200.0, more_m=0.01)
    assert tighter.report.lateness is not None
    worst = tighter.report.lateness.worst
    assert worst is not None
    assert sampled.worst_s == pytest.approx(worst.worst_at_least_s, abs=0.15)


def test_who_goes_on_was_driven_until_the_change() -> None:
    found = first_answer(ring_plan(45, {"a": 0.0, "b": 20.0}), at_s=100, lost=["b"])
    assert found.plan.seam is not None
    driven = tuple(replace(one, times_s=one.times_s - 1) for one in found.plan.seam.driven)
    with pytest.raises(rota.PlanError, match="robot a: times_s ends at -1"):
        replace(found.plan.seam, driven=driven)
    with pytest.raises(rota.PlanError, match=r"times_s ends at 1\.0"):
        replace(driven[0], times_s=driven[0].times_s + 2)


@pytest.mark.parametrize("plan", [PAIR, relay(spare=True)])
@pytest.mark.parametrize("lost", ["a", "b"])
def test_the_first_plan_alone_is_the_first_that_replanning_tells(plan: Plan, lost: str) -> None:
    change = {"at_s": 53.0, "lost": [lost], "late": {"b" if lost == "a" else "a": 2.0}}
    assert first_plan(plan, **change) == first_answer(plan, **change).plan


def test_the_first_plan_alone_is_one_that_can_be_driven(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the check finds wrong with how robots drive it rules out, and where that is all, tells why."""
    wrong = check_plan(replace(PAIR, trajectories=(replace(PAIR["a"], times_s=PAIR["a"].times_s / 2),)))
    (found,) = [one for one in wrong.violations if one.kind == "speed"][:1]
    looked: list[Plan] = []
    monkeypatch.setattr(
        "rota.check.violations_on_the_way", lambda plan: looked.append(plan) or [found] * (len(looked) < 3)
    )
    assert first_plan(PAIR, at_s=53.0, lost=["a"]) is looked[2]
    # of the plan that comes nearest, neither of the first nor of the last one
    others, nearest = [replace(found, who=f"the {name}") for name in ("first", "last")], replace(found, who="nearest")
    tried: list[Plan] = []
    monkeypatch.setattr(
        "rota.check.violations_on_the_way",
        lambda plan: tried.append(plan) or ([nearest, found] if len(tried) == 2 else [others[len(tried) > 1]] * 3),
    )
    with pytest.raises(NoPlanFound, match=r"no plan takes over at t = 53 s: nearest: speed .*; 1 more"):
        first_plan(PAIR, at_s=53.0, lost=["a"])
    assert len(tried) > 2


def test_robots_with_mass_that_cannot_go_on_are_told_with_what_is_in_their_way() -> None:
    plan = ring_plan(45, {"a": 0.0}, motion=MASS)
    wall = Obstacle(shape=shapely.MultiPolygon([shapely.box(9, 9, 11, 11)]), blocks="motion")
    changed = replace(plan.mission, obstacles=(*plan.mission.obstacles, wall))
    with pytest.raises(NoPlanFound, match=r"at t = 3 s: a: obstacle at \(10\.000, \d+\.\d+\), t = ") as told:
        first_answer(plan, at_s=3, mission=changed)
    assert "no robot has" not in str(told.value)


def test_a_new_robot_with_mass_for_all_that_are_lost_is_answered() -> None:
    """It stays where it is, which misses nearly all, where nothing better is found in time."""
    plan = ring_plan(45, {"a": 0.0}, motion=MASS)
    found = first_answer(plan, at_s=3, lost=["a"], joined={"c": (5.0, 0.0)})
    assert found.report.verdict == "violated"
    assert {one.kind for one in found.report.violations} <= {"gap", "unseeable"}
