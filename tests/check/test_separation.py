"""Bodies kept apart: closed forms, tolerances, phases, and brute force over the hyperperiod."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from shapely import MultiPolygon, box
from tests.check.accelerated import accelerated
from tests.seeds import seeds

from rota import PatrolSettings, SwarmSettings
from rota.check.report import Violation
from rota.check.separation import separation_violations
from rota.model.mission import DiscSensor, Fleet, Mission
from rota.model.plan import Plan, Trajectory


def violations(*trajectories: Trajectory, body: float = 0.5) -> list[Violation]:
    fleet = Fleet(speed_m_s=10.0, sensor=DiscSensor(radius_m=1.0), body_radius_m=body)
    flying = any(trajectory.positions_m.shape[1] == 3 for trajectory in trajectories)
    swarm = SwarmSettings(controller="reciprocal", altitudes_m=(1, 2))
    mission = Mission(
        name="m",
        area=MultiPolygon([box(-100, -100, 100, 100)]),
        fleet=replace(fleet, robots=tuple(fleet.equal_robot(t.robot) for t in trajectories)) if flying else fleet,
        period_s=None if flying else 1.0,
        planning=swarm if flying else PatrolSettings(),
    )
    return separation_violations(Plan(mission=mission, trajectories=trajectories))


def track(robot: str, times: object, xy: object, loop_start: float = 0.0) -> Trajectory:
    return Trajectory(robot=robot, times_s=times, positions_m=xy, loop_start_s=loop_start)


def shuttle(robot: str, y: float, period: float, lead: float = 0.0, x0: float = 0.0) -> Trajectory:
    """Along y from x0 to x0 + 10 and back in ``period`` seconds, after waiting ``lead`` seconds at x0."""
    half = period / 2
    if lead:
        return track(robot, [0, lead, lead + half, lead + period], [(x0, y), (x0, y), (x0 + 10, y), (x0, y)], lead)
    return track(robot, [0, half, period], [(x0, y), (x0 + 10, y), (x0, y)])


@pytest.mark.parametrize(("gap", "wrong"), [(1.0, False), (1 - 0.9e-6, False), (1 - 1.1e-6, True), (0.5, True)])
def test_passing_robots_may_touch_within_the_tolerance(gap: float, wrong: bool) -> None:
    one = track("a", [0, 10, 20], [(0, 0), (10, 0), (0, 0)])
    two = track("b", [0, 10, 20], [(10, gap), (0, gap), (10, gap)])
    found = violations(one, two)
    assert [v.kind for v in found] == (["bodies touch"] if wrong else [])
    if wrong:
        assert found[0].who == "a, b"
        assert found[0].value == pytest.approx(gap, abs=1e-12)
        assert found[0].limit == 1.0
        assert found[0].place_m == pytest.approx((5, gap / 2))
        assert found[0].time_s == pytest.approx(5.0)
    assert violations(one, two, body=0.0) == []


def test_same_loop_half_a_turn_apart_is_fine_and_a_late_start_is_not() -> None:
    ring = [(0, 0), (8, 0), (8, 8), (0, 8), (0, 0)]
    other = [(8, 8), (0, 8), (0, 0), (8, 0), (8, 8)]
    times = np.arange(5) * 8.0
    assert violations(track("a", times, ring), track("b", times, other)) == []
    # 15.5 s late: b waits at (8, 8) until it starts, and drives off as a comes
    late = track("b", np.concatenate([[0], times + 15.5]), [other[0], *other], 15.5)
    (found,) = violations(track("a", times, ring), late)
    assert found.value == pytest.approx(math.sqrt(0.125))
    assert found.time_s is not None
    assert found.time_s % 8 == pytest.approx(7.75)  # so again at every corner


def test_crossing_roads_in_equal_periods_depend_on_the_phase_alone() -> None:
    one = track("a", [0, 10, 20], [(-5, 0), (5, 0), (-5, 0)])
    two = track("b", [0, 10, 20], [(0, -5), (0, 5), (0, -5)])
    (found,) = violations(one, two)
    assert found.value == pytest.approx(0.0, abs=1e-9)
    assert found.time_s == pytest.approx(5.0)
    late = track("b", [0, 5, 15, 25], [(0, -5), (0, -5), (0, 5), (0, -5)], 5)
    assert violations(one, late) == []


def test_period_in_ratio_two_to_three_meets_in_all_its_shifts() -> None:
    # a is at x = 0 at 5 + 20 i (and 15 + 20 i), b at y = 0 at s + 7.5 + 30 j (and s + 22.5 + 30 j)
    one = track("a", [0, 10, 20], [(-5, 0), (5, 0), (-5, 0)])
    for start, clear in [(2.5, False), (0.0, True)]:
        xy = [(0, -7.5), (0, -7.5), (0, 7.5), (0, -7.5)]
        two = track("b", [0, start, start + 15, start + 30], xy, start) if start else track("b", [0, 15, 30], xy[1:])
        found = violations(one, two)
        assert (found == []) == clear
        if not clear:
            assert found[0].time_s is not None
            assert found[0].time_s % 10 == pytest.approx(5.0)
            assert found[0].value == pytest.approx(0.0, abs=1e-9)


def test_independent_periods_meet_wherever_the_lines_do() -> None:
    one = shuttle("a", 0.0, 20.0)
    (found,) = violations(one, shuttle("b", 0.9, 20.0 * math.sqrt(2)))
    assert found.value == pytest.approx(0.9)
    assert found.time_s is None
    assert violations(one, shuttle("b", 1.1, 20.0 * math.sqrt(2))) == []


def test_robot_that_stays_is_met_by_a_loop_and_by_a_passage_before_it() -> None:
    stay = track("s", [0.0], [(5, 0.2)], 0.0)
    (found,) = violations(shuttle("a", 0.0, 20.0), stay)
    assert found.value == pytest.approx(0.2)
    passing = track("a", [0, 10, 20, 30], [(0, 0), (10, 0), (10, 10), (10, 0)], 10)
    (found,) = violations(passing, stay)
    assert found.time_s == pytest.approx(5.0)
    later = track("s", [0, 6, 8], [(5, 8), (5, 8), (5, 0.2)], 8.0)
    assert violations(passing, later) == []
    assert violations(track("x", [0.0], [(5, 0.9)]), stay) != []


def test_loop_that_turns_many_times_before_the_other_begins() -> None:
    # b drives through a's place at t = 1005, long after a's first turns
    one = shuttle("a", 0.0, 20.0)
    two = track("b", [0, 1000, 1010, 1020, 1030], [(5, 5), (5, 5), (5, -5), (5, -20), (5, -5)], 1010)
    (found,) = violations(one, two)
    assert found.time_s == pytest.approx(1005.0)
    (found,) = violations(two, one)
    assert found.time_s == pytest.approx(1005.0)
    shifted = track("b", [0, 995, 1005, 1020, 1035], [(5, 5), (5, 5), (5, -5), (5, -20), (5, -5)], 1005)
    assert violations(one, shifted) == []


@pytest.mark.parametrize("bent", [False, True])
@pytest.mark.parametrize("seed", seeds(25, at_once=8))
def test_matches_sampled_times(seed: int, bent: bool) -> None:
    rng = np.random.default_rng(seed)
    trajectories = []
    for robot in "ab":
        period = float(rng.choice([8.0, 12.0, 18.0]))
        n, lead = int(rng.integers(2, 5)), int(rng.integers(0, 3))
        xy = rng.uniform(0, 6, (lead + n, 2))
        xy = np.vstack([xy, xy[lead : lead + 1]])
        times = np.concatenate([np.arange(lead) * 3.0, lead * 3.0 + np.linspace(0, period, n + 1)])
        way = track(robot, times, xy, lead * 3.0)
        trajectories.append(accelerated(way, rng) if bent else way)
    end = max(t.loop_start_s for t in trajectories) + math.lcm(*(round(t.loop_duration_s) for t in trajectories))
    t = np.arange(0, end, 1e-3)
    away = np.hypot(*(trajectories[0].at(t) - trajectories[1].at(t)).T)
    closest = float(away.min())
    # bodies a little larger and a little smaller than half the sampled distance
    (found,) = violations(*trajectories, body=closest / 2 + 0.01)
    assert found.value == pytest.approx(closest, abs=5e-3)
    assert found.time_s is not None
    places = [each.at(found.time_s) for each in trajectories]
    at = math.dist(*places)
    assert found.place_m == pytest.approx((places[0] + places[1]) / 2, abs=1e-6)
    assert at == pytest.approx(found.value, abs=1e-6)
    if closest > 0.05:
        assert violations(*trajectories, body=closest / 2 - 0.01) == []


# ---------------------------------------------------------------- in space


def test_a_robot_above_another_touches_it_only_within_two_radii() -> None:
    # crossing under one that holds, 1 m apart in height with bodies of 0.5 m, and then 0.9 m
    for height, wrong in ((1.0, False), (0.9, True)):
        stays = track("a", [0], [(5, 0, height)])
        passes = track("b", [0, 1], [(0, 0, 0), (10, 0, 0)], 1)
        found = violations(stays, passes)
        assert bool(found) == wrong
        if found:
            assert (found[0].value, found[0].place_m) == (pytest.approx(0.9), pytest.approx((5, 0)))
            assert found[0].time_s == pytest.approx(0.5)


def test_robots_that_hold_above_each_other_touch_by_their_distance_in_space() -> None:
    # 3-4-5: 0.6 m along x and 0.8 m up is 1 m
    assert not violations(track("a", [0], [(0, 0, 0)]), track("b", [0], [(0.6, 0, 0.8)]))
    found = violations(track("a", [0], [(0, 0, 0)]), track("b", [0], [(0.6, 0, 0.7)]))
    assert [v.value for v in found] == [pytest.approx(math.hypot(0.6, 0.7))]


def test_a_robot_without_a_height_is_judged_as_if_at_the_other_s() -> None:
    assert violations(track("a", [0], [(0, 0)]), track("b", [0], [(0.6, 0, 50)]))


def test_loops_that_share_no_period_meet_by_their_lines_in_space() -> None:
    # askew: one along x at height 0, the other along y at height h, with periods that have no common measure
    along_x = track("a", [0, 1, 2], [(-5, 0, 0), (5, 0, 0), (-5, 0, 0)])
    for height, wrong in ((1.5, False), (0.7, True)):
        time = math.sqrt(2)
        along_y = track("b", [0, time, 2 * time], [(0, -5, height), (0, 5, height), (0, -5, height)])
        found = violations(along_x, along_y)
        assert bool(found) == wrong
        assert not found or found[0].value == pytest.approx(0.7)


@pytest.mark.parametrize("bent", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_contact_in_space_is_that_of_brute_force_in_time(seed: int, bent: bool) -> None:
    rng = np.random.default_rng(seed)
    ways, times = (
        [track(name, np.arange(5.0), rng.uniform(-3, 3, (5, 3)), 4) for name in "ab"],
        np.linspace(0, 4, 40_001),
    )
    ways = [accelerated(way, rng) for way in ways] if bent else ways
    least = float(np.linalg.norm(ways[0].at(times) - ways[1].at(times), axis=1).min())
    found = violations(*ways, body=3.0)
    assert found[0].value == pytest.approx(least, abs=1e-3)


# ---------------------------------------------------------------- with accelerations


def test_robots_that_pass_as_one_of_them_starts_are_nearest_where_they_are_abreast() -> None:
    """a from rest at 2 m/s2 in 4 s to x = 16; b comes from x = 20 at 4 m/s, 0.5 m beside: t^2 = 20 - 4 t."""
    starts = replace(track("a", [0, 4], [(0, 0), (16, 0)], 4), accelerations_m_s2=[2])
    comes = track("b", [0, 5], [(20, 0.5), (0, 0.5)], 5)
    (found,) = violations(starts, comes)
    abreast_s = math.sqrt(24) - 2
    assert (found.value, found.time_s) == pytest.approx((0.5, abreast_s), abs=1e-9)
    assert found.place_m == pytest.approx((abreast_s**2, 0.25))
    # driven evenly, a is at x = 10 after 2.5 s, as b is
    assert violations(replace(starts, accelerations_m_s2=None), comes)[0].time_s == pytest.approx(2.5)


@pytest.mark.parametrize(("late_m", "wrong"), [(1.0, False), (1 - 0.9e-6, False), (1 - 1.1e-6, True)])
def test_followers_that_stop_one_after_the_other_may_touch_within_the_tolerance(late_m: float, wrong: bool) -> None:
    """Both stop from 4 m/s in 4 s, the second one a little behind: at rest they are as far apart as ever."""
    first = replace(track("a", [0, 4], [(0, 0), (8, 0)], 4), accelerations_m_s2=[-1])
    second = replace(track("b", [0, 4], [(-late_m, 0), (8 - late_m, 0)], 4), accelerations_m_s2=[-1])
    assert bool(violations(first, second)) == wrong
