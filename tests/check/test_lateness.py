"""How late places are where a plan takes over from another one, beside dense sampling of time and closed forms."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import jsonschema
import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from tests.seeds import seeds

from rota import (
    DiscSensor,
    Fleet,
    Mission,
    MotionLimits,
    Obstacle,
    Plan,
    PlanError,
    Robot,
    Trajectory,
    Zone,
    check_plan,
)
from rota.check import report_schema, report_table, report_to_json, sample_lateness
from rota.check.late_report import LateDemand, LateSample
from rota.files.plan_file import plan_from_text, plan_text
from rota.model.mission import Demand
from rota.model.plan import Driven, Seam

Floats = NDArray[np.float64]

REACH_M = 1.2
SENSOR = DiscSensor(radius_m=REACH_M)
RING = np.array([[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]], float)
ROUND_S = np.arange(0.0, 41.0, 10.0)


def mission(period_s: float | None, names: tuple[str, ...] = ("a",), **more: object) -> Mission:
    """A ring 0.6 m wide round a block, at the speed of 1 m/s."""
    fleet = Fleet(robots=[Robot(name=name) for name in names], speed_m_s=1, sensor=SENSOR)
    block = Obstacle(shape=shapely.MultiPolygon([shapely.box(0.3, 0.3, 9.7, 9.7)]), blocks="both")
    area = shapely.MultiPolygon([shapely.box(-0.3, -0.3, 10.3, 10.3)])
    told = {"name": "ring", "area": area, "obstacles": (block,), "period_s": period_s, "fleet": fleet, **more}
    return Mission(**told)  # type: ignore[arg-type]


def driven(name: str, first: int = 0, **more: object) -> Driven:
    """A round before the change, from one of the corners on."""
    corners = np.vstack([np.roll(RING[:4], -first, axis=0), RING[first]])
    return Driven(robot=name, sensor=SENSOR, times_s=ROUND_S - 40, positions_m=corners, **more)  # type: ignore[arg-type]


def trajectory(name: str, first: int = 0) -> Trajectory:
    corners = np.vstack([np.roll(RING[:4], -first, axis=0), RING[first]])
    return Trajectory(robot=name, times_s=ROUND_S, positions_m=corners)


SEAM = Seam(at_s=100, lost=("b",), driven=(driven("a"), driven("b", 2)))


def test_one_of_two_robots_on_a_ring_is_lost() -> None:
    # b was half a round ahead; what it saw last, at (10, 10) when it was lost, a sees 20 s later on its way
    zone = Zone(name="post", period_s=25, demand="visit", shape=shapely.MultiPolygon([shapely.box(-0.3, 4, 0.3, 6)]))
    plan = Plan(mission=mission(60, zones=(zone,)), trajectories=(trajectory("a"),), seam=SEAM)
    report = check_plan(plan)
    lateness = report.lateness
    assert lateness is not None
    by_name = {one.name: one for one in lateness.demands}
    assert by_name["area"].worst_s == 0
    # a leaves the post at -4, b is there no more before a comes again at 34: 38 s, for ever
    assert by_name["post"].worst_s == pytest.approx(13, abs=1e-6)
    assert by_name["post"].worst_at_least_s == pytest.approx(13, abs=1e-6)
    assert (lateness.holds_again_s, lateness.late_m2_s) == (None, math.inf)
    assert report.verdict == "violated"


@pytest.mark.parametrize("period_s", [36.0, 25.0])
def test_a_second_robot_comes_in_and_periods_hold_again(period_s: float) -> None:
    # a goes on, c begins beside the way at (10, 10), half a round ahead; nobody but a was there before
    names = ("a", "c")
    plan = Plan(
        mission=mission(period_s, names),
        trajectories=(trajectory("a"), trajectory("c", 2)),
        seam=Seam(at_s=7, driven=(driven("a"),)),
    )
    report = check_plan(plan)
    lateness = report.lateness
    assert report.verdict == "met"
    assert lateness is not None
    assert lateness.holds_again_s is not None
    # of a place at s metres along the ring and 0.3 m off it, each sight begins h before the robot is beside it, and
    # ends h after; corners hide some of it. Before (10, 10) a was 20 s ago; c drives on from there at once, so that
    # the longest wait is that of the place just behind c: a was there 20 s ago and is there again in 20 s
    half_s = math.sqrt(REACH_M**2 - 0.3**2)
    lower = brute_force(plan, 0.1, 0.3, lateness.demands[0].place_m)
    assert lateness.demands[0].worst_s == pytest.approx(lower.worst_s, abs=0.25)
    assert lateness.demands[0].worst_s >= lower.worst_s - 0.05
    assert lateness.holds_again_s == pytest.approx(lower.last_s, abs=0.4)
    if period_s == 36.0:
        assert lateness.demands[0].worst_s <= max(0.0, 40 - 2 * half_s - 36 + 2.4)


class Brute:
    """What time sampling says: the worst lateness after the change, and the last late moment."""

    def __init__(self, worst_s: float, last_s: float, share: float) -> None:
        self.worst_s, self.last_s, self.late_m2_s = worst_s, last_s, share


def brute_force(plan: Plan, step_s: float, spacing_m: float, also_m: object = None, hidden: bool = True) -> Brute:
    """Robots looked at every so often, ground every so far, borders and a place of one's own included."""
    assert plan.seam is not None
    ground = shapely.difference(plan.mission.area, shapely.union_all([o.shape for o in plan.mission.obstacles]))
    x0, y0, x1, y1 = ground.bounds
    counts = [round((high - low) / spacing_m) for low, high in ((x0, x1), (y0, y1))]
    nodes = lattice(np.linspace(x0, x1, counts[0] + 1), np.linspace(y0, y1, counts[1] + 1))
    middles = lattice(x0 + (np.arange(counts[0]) + 0.5) * spacing_m, y0 + (np.arange(counts[1]) + 0.5) * spacing_m)
    grid = np.vstack([middles, nodes])
    counted = (np.arange(len(grid)) < len(middles))[shapely.intersects_xy(ground, *grid.T)]
    grid = grid[shapely.intersects_xy(ground, *grid.T)]
    if also_m is not None:
        grid, counted = np.vstack([grid, also_m]), np.append(counted, False)
    walls = shapely.union_all([o.shape for o in plan.mission.obstacles]) if hidden else None
    since_s = plan.seam.since_s
    times = np.arange(since_s, 90.0, step_s)
    covered, period = np.full(len(grid), since_s), plan.mission.period_s or 0.0
    worst, last, late = 0.0, 0.0, 0.0
    for now in times:
        places = places_at(plan, float(now))
        seen = np.zeros(len(grid), bool)
        for place in places:
            near = np.flatnonzero(np.hypot(*(grid - place).T) <= REACH_M)
            if walls is not None and len(near):
                lines = shapely.linestrings(np.stack([np.broadcast_to(place, (len(near), 2)), grid[near]], axis=1))
                near = near[~shapely.crosses(lines, walls) & ~shapely.within(lines, walls)]
            seen[near] = True
        covered[seen] = now
        if now >= 0:
            over = now - covered - period
            worst = max(worst, float(over.max()))
            if (over > 0).any():
                last = float(now)
                late += float((over > 0)[counted].sum()) * spacing_m**2 * step_s
    return Brute(worst, last, late)


def lattice(x: Floats, y: Floats) -> Floats:
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def places_at(plan: Plan, now_s: float) -> list[Floats]:
    assert plan.seam is not None
    if now_s < 0:
        return [
            np.array([np.interp(now_s, one.times_s, one.positions_m[:, axis]) for axis in (0, 1)])
            for one in plan.seam.driven
            if now_s >= one.times_s[0]
        ]
    found = []
    for one in plan:
        if one.loop_duration_s > 0 and now_s > one.loop_start_s:
            now = one.loop_start_s + (now_s - one.loop_start_s) % one.loop_duration_s
        else:
            now = now_s
        found.append(np.array([np.interp(now, one.times_s, one.positions_m[:, axis]) for axis in (0, 1)]))
    return found


@pytest.mark.parametrize("seed", seeds(5, at_once=2))
def test_beside_dense_sampling(seed: int) -> None:
    random = np.random.default_rng(seed)

    def way(places: Floats, pace_m_s: float = 1.0) -> Floats:
        return np.append(0.0, np.cumsum(np.hypot(*np.diff(places, axis=0).T) / pace_m_s))

    area = shapely.MultiPolygon([shapely.box(0, 0, 4, 3)])
    before, after = [], []
    for name in ("a", "b"):
        places = random.uniform((0.3, 0.3), (3.7, 2.7), (9, 2))
        times = way(places)
        before.append(Driven(robot=name, sensor=SENSOR, times_s=times - times[-1], positions_m=places))
        if name == "b" and seed % 2:
            continue
        lanes = np.array([[0.8, 0.8], [3.2, 0.8], [3.2, 2.2], [0.8, 2.2], [0.8, 0.8]])[:: 1 if name == "a" else -1]
        line = np.vstack([places[-1], lanes])
        after.append(Trajectory(robot=name, times_s=way(line), positions_m=line, loop_start_s=way(line)[1]))
    # the last times are 0 but for rounding, which the model does not take
    before = [replace(one, times_s=np.append(one.times_s[:-1], 0.0)) for one in before]
    fleet = Fleet(robots=[Robot(name=one.robot) for one in after], speed_m_s=1, sensor=SENSOR)
    asked = Mission(name="yard", area=area, period_s=7.6, fleet=fleet)
    lost = ("b",) if seed % 2 else ()
    plan = Plan(mission=asked, trajectories=tuple(after), seam=Seam(at_s=20, lost=lost, driven=tuple(before)))
    report = check_plan(plan)
    lateness = report.lateness
    assert lateness is not None
    found = brute_force(plan, 0.04, 0.2, lateness.demands[0].place_m, hidden=False)
    (area_late,) = lateness.demands
    # between sample points a lattice misses some, and a step of time adds up to itself on either side
    assert found.worst_s - 0.05 <= area_late.worst_s <= found.worst_s + 0.4
    assert area_late.worst_at_least_s <= area_late.worst_s + 1e-9
    if report.verdict == "met":
        assert lateness.holds_again_s is not None
        assert found.last_s - 0.05 <= lateness.holds_again_s <= found.last_s + 0.4
        assert lateness.late_m2_s == pytest.approx(found.late_m2_s, rel=0.12, abs=0.5)


@pytest.mark.parametrize("demand", ["every_point", "visit"])
def test_a_zone_that_names_a_sensor_is_as_late_as_without_all_others(demand: Demand) -> None:
    """b and c see heat, half a round apart; b is lost, and for the hot zone a counts as if it were not there."""
    hot = DiscSensor(radius_m=REACH_M, name="thermal")
    zone = Zone(name="hot", period_s=25, demand=demand, shape=shapely.MultiPolygon([shapely.box(-0.3, 4, 0.3, 6)]))
    seen_by = {"a": SENSOR, "b": hot, "c": hot}

    def judged(names: str, sensors: tuple[str, ...]) -> tuple[LateDemand, LateSample, str]:
        """How late the zone is with those of the robots, what sample points say, and what is said of it for ever."""
        left = [name for name in names if name != "b"]
        fleet = Fleet(robots=[Robot(name=name, sensor=seen_by[name]) for name in left], speed_m_s=1, sensor=SENSOR)
        before = tuple(replace(driven(name, "bac".index(name)), sensor=seen_by[name]) for name in names)
        plan = Plan(
            mission=mission(None, zones=(replace(zone, sensors=sensors),), fleet=fleet),
            trajectories=tuple(trajectory(name, "bac".index(name)) for name in left),
            seam=Seam(at_s=100, lost=("b",), driven=before),
        )
        report = check_plan(plan)
        assert report.lateness is not None
        (late,) = report.lateness.demands
        return late, sample_lateness(plan, 100), report.demands[0].outcome

    counting, alone = judged("abc", ("thermal",)), judged("bc", ())
    assert counting == alone
    assert counting[0].worst_s > judged("abc", ())[0].worst_s + 3
    assert counting[2] == "violated"


def test_the_seam_is_in_the_plan_file_and_the_report() -> None:
    plan = Plan(mission=mission(45), trajectories=(trajectory("a"),), seam=SEAM)
    again = plan_from_text(plan_text(plan), "plan")
    assert (again, again.seam) == (plan, SEAM)
    report = check_plan(again)
    document = json.loads(json.dumps(report_to_json(report), allow_nan=False))
    jsonschema.Draft202012Validator(report_schema()).validate(document)
    assert document["lateness"]["lost"] == ["b"]
    assert "b lost): nothing is late" in report_table(report)
    assert report_to_json(check_plan(replace(plan, seam=None)))["lateness"] is None


def test_walls_that_stood_before_hide_what_was_driven_then() -> None:
    # before the change a wall stood in the way of sight: of what a saw then the far side counts as never seen
    asked = Mission(
        name="two rows", area=shapely.MultiPolygon([shapely.box(0, 0, 10, 2)]), period_s=30,
        fleet=Fleet(robots=[Robot(name="a")], speed_m_s=1, sensor=DiscSensor(radius_m=3)),
    )  # fmt: skip
    line = np.array([[0, 0.5], [10, 0.5], [0, 0.5]])
    robot = Trajectory(robot="a", times_s=np.array([0.0, 10, 20]), positions_m=line)
    was = Driven(robot="a", sensor=DiscSensor(radius_m=3), times_s=np.array([-20.0, -10, 0]), positions_m=line)
    wall = Obstacle(shape=shapely.MultiPolygon([shapely.box(-1, 0.9, 11, 1.1)]), blocks="sight")
    seen = check_plan(Plan(mission=asked, trajectories=(robot,), seam=Seam(at_s=50, driven=(was,))))
    unseen = check_plan(
        Plan(mission=asked, trajectories=(robot,), seam=Seam(at_s=50, driven=(was,), obstacles=(wall,)))
    )
    assert seen.lateness is not None
    assert unseen.lateness is not None
    assert seen.lateness.demands[0].worst_s == 0
    # behind the wall nothing was seen since -20: (10, 2) is seen when a is at 10 - sqrt(9 - 2.25)
    assert unseen.lateness.demands[0].worst_s == 0
    shorter = replace(asked, period_s=21)
    unseen = check_plan(
        Plan(mission=shorter, trajectories=(robot,), seam=Seam(at_s=50, driven=(was,), obstacles=(wall,)))
    )
    assert unseen.lateness is not None
    assert unseen.lateness.demands[0].worst_s == pytest.approx(20 + 10 - math.sqrt(6.75) - 21, abs=0.1)


def test_robots_begin_where_they_were_and_none_is_left_out() -> None:
    kinds = [
        (found.kind, found.who)
        for found in check_plan(
            Plan(
                mission=mission(45, ("a", "c")),
                trajectories=(trajectory("a", 1), trajectory("c", 2)),
                seam=Seam(at_s=3, driven=(driven("a"), driven("d"))),
            )
        ).violations
    ]
    assert ("start", "a") in kinds
    assert ("no trajectory", "d") in kinds


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"times_s": ROUND_S - 39}, "the last must be 0"),
        ({"times_s": np.array([-3.0, -5, -2, -1, 0])}, "must rise"),
        ({"times_s": np.array([-3.0, math.nan, -2, -1, 0])}, "must be finite"),
        ({"positions_m": RING[:3]}, "are needed"),
        ({"accelerations_m_s2": np.zeros(2)}, "not \\(4,\\)"),
    ],
)
def test_what_was_driven_must_be_told_rightly(changes: dict[str, object], message: str) -> None:
    with pytest.raises(PlanError, match=message):
        driven("a", **changes) if "accelerations_m_s2" in changes else replace(driven("a"), **changes)  # type: ignore[arg-type]


def test_nobody_drives_twice_or_comes_back() -> None:
    with pytest.raises(PlanError, match="robot a has driven twice"):
        Seam(at_s=0, driven=(driven("a"), driven("a")))
    with pytest.raises(PlanError, match="robot a is lost"):
        Plan(mission=mission(45), trajectories=(trajectory("a"),), seam=replace(SEAM, lost=("a",)))


def across(headings: tuple[float, float], pause_s: float, **of_fleet: object) -> list[str]:
    """What is wrong where a robot drove one way until the change, and another from then on after a pause."""
    before, after = (np.array([math.cos(a), math.sin(a)]) for a in headings)
    fleet = Fleet(robots=[Robot(name="a")], speed_m_s=1, sensor=DiscSensor(radius_m=9), **of_fleet)  # type: ignore[arg-type]
    asked = Mission(name="open", area=shapely.MultiPolygon([shapely.box(-9, -9, 9, 9)]), period_s=99, fleet=fleet)
    was = Driven(
        robot="a", sensor=DiscSensor(radius_m=9), times_s=np.array([-4.0, 0]), positions_m=[-4 * before, 0 * before]
    )
    times = [0.0, pause_s, pause_s + 4, pause_s + 8] if pause_s else [0.0, 4, 8]
    places = [0 * after, 0 * after, 4 * after, 8 * after][0 if pause_s else 1 :]
    goes = Trajectory(robot="a", times_s=np.array(times), positions_m=np.array(places), loop_start_s=times[-1])
    plan = Plan(mission=asked, trajectories=(goes,), seam=Seam(at_s=50, driven=(was,)))
    return [found.kind for found in check_plan(plan).violations if found.time_s == 0]


def test_robots_turn_and_brake_at_the_change_as_they_can() -> None:
    # a quarter turn at 0.5 rad/s takes 3.14 s
    assert across((0, math.pi / 2), 3.0, turn_rate_rad_s=0.5) == ["turn"]
    assert across((0, math.pi / 2), 3.2, turn_rate_rad_s=0.5) == []
    assert across((0, math.pi / 2), 0, turn_radius_m=1.0) == ["turn radius"]
    assert across((0, 0), 0, turn_radius_m=1.0) == []
    # who stands for 3 s was under way at 1 m/s just before
    assert "acceleration" in across((0, 0), 3.0, motion=MotionLimits(acceleration_m_s2=0.5))
    assert across((0, 0), 0, motion=MotionLimits(acceleration_m_s2=0.5)) == []
    assert across((0, 2), 0) == []
