"""The smallest worst ratio of gap to period that a fixed number of robots reaches, against closed forms."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shapely import MultiPolygon, box
from shapely.geometry.base import BaseGeometry
from typer.testing import CliRunner

import rota
from rota.check import check_plan
from rota.command.cli import app
from rota.files.plan_file import read_plan
from rota.model.mission import DiscSensor, Fleet, Mission, Zone
from rota.planners.patrol.ground.problem import Problem, set_up_problem, stretch_periods
from rota.planners.patrol.methods.fixed_team.proved_ratio import proved_ratio
from rota.planners.patrol.methods.fixed_team.team_tours import with_bystanders
from rota.planners.patrol.planner_settings import Method, PatrolSettings
from rota.planners.patrol.tours.tour import Tour
from rota.planning.plan_summary import ratio_sentence

REACH_M = 5.0
# both corners of an end of a corridor 4 m wide are in range from its middle line this far from the end
END_M = math.sqrt(REACH_M**2 - 2**2)


def guarded(*ground: BaseGeometry, robots: int, period_s: float, body_radius_m: float = 0.0) -> Mission:
    """A mission with so many robots at 1 m/s."""
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=REACH_M), body_radius_m=body_radius_m)
    named = tuple(fleet.equal_robot(f"guard-{k}") for k in range(robots))
    return Mission(
        name="ground",
        area=MultiPolygon(list(ground)),
        period_s=period_s,
        fleet=replace(fleet, robots=named),
        planning=PatrolSettings(effort="quick"),
    )


def worst_gap_s(plan: rota.Plan) -> float:
    """What the check proves of a plan that meets its demand."""
    report = check_plan(plan)
    assert report.verdict == "met"
    return max(demand.worst_gap_s for demand in report.demands)


def test_two_robots_in_a_corridor_take_a_half_each_and_the_same_seed_gives_the_same_plan() -> None:
    corridor = guarded(box(0, 0, 30, 4), robots=2, period_s=60)
    plan, again = rota.make_plan(corridor, seed=3), rota.make_plan(corridor, seed=3)
    assert [trajectory.robot for trajectory in plan] == ["guard-0", "guard-1"]
    # to and fro in 15 m; to look into the middle from both sides could save a little, but not much
    shortest_s = 2 * (15 - 2 * END_M)
    assert 0.9 * shortest_s < worst_gap_s(plan) < 1.05 * shortest_s
    for one, two in zip(plan, again, strict=True):
        np.testing.assert_array_equal(one.positions_m, two.positions_m)
        np.testing.assert_array_equal(one.times_s, two.times_s)


def test_half_the_robots_on_a_ring_take_twice_as_long() -> None:
    ring = box(0, 0, 24, 24).difference(box(4, 4, 20, 20))
    round_s = {robots: worst_gap_s(rota.make_plan(guarded(ring, robots=robots, period_s=90))) for robots in (1, 2)}
    # by symmetry and convexity the shortest loop within reach of all outer corners is the square between the four discs
    least_s = 4 * (24 - 2 * REACH_M / math.sqrt(2))
    assert least_s - 1e-6 < round_s[1] < 1.1 * least_s
    assert round_s[1] / round_s[2] == pytest.approx(2, rel=0.05)


def test_a_search_that_is_stopped_at_once_leaves_the_first_tours() -> None:
    rooms = (box(0, 0, 4, 4), box(20, 0, 50, 4))
    with pytest.raises(rota.NoPlanFound, match="stopped early") as caught:
        rota.make_plan(guarded(*rooms, robots=3, period_s=1), should_stop=lambda: True)
    best = caught.value.best
    assert isinstance(best, rota.Plan)
    assert [trajectory.robot for trajectory in best] == ["guard-0", "guard-1", "guard-2"]
    assert {bool(trajectory.positions_m[0, 0] > 10) for trajectory in best} == {False, True}


@pytest.mark.parametrize("method", ["parallel", "sequential"])
def test_traditional_methods_keep_to_their_lanes_at_the_smallest_ratio(method: Method) -> None:
    mission = guarded(box(0, 0, 30, 4), robots=1, period_s=32)
    mission = replace(mission, planning=PatrolSettings(effort="quick", method=method))
    with pytest.raises(rota.NoPlanFound, match=r"1 robot .* the worst gap is .* times its period; proved:") as caught:
        rota.make_plan(mission)
    told = float(str(caught.value).split(" times its period")[0].split()[-1])
    assert 2 * (30 - 2 * END_M) / 32 - 5e-4 < told < 1.1 * 2 * (30 - 2 * END_M) / 32
    best = caught.value.best
    assert isinstance(best, rota.Plan)
    (trajectory,) = best
    # one lane, there and back
    assert np.ptp(trajectory.positions_m[:, 1]) < 0.1


def test_robots_that_are_not_needed_for_a_visit_stand_by() -> None:
    mission = guarded(box(0, 0, 20, 20), robots=3, period_s=20)
    den = Zone(name="den", shape=MultiPolygon([box(2, 2, 4, 4)]), period_s=20, demand="visit")
    plan = rota.make_plan(replace(mission, period_s=None, zones=(den,)))
    assert len(plan.trajectories) == 3
    assert worst_gap_s(plan) == 0


def test_robots_better_than_their_fleet_says_are_planned_for_as_they_are() -> None:
    mission = guarded(box(0, 0, 8, 4), robots=1, period_s=20)
    fleet = replace(mission.fleet, sensor=DiscSensor(radius_m=2.5), speed_m_s=0.1)
    # from the middle the guard has all corners in range, as a robot like the fleet's would not
    plan = rota.make_plan(replace(mission, fleet=fleet))
    assert worst_gap_s(plan) == 0


CORRIDOR = """\
rota: 1
name: corridor
coordinates: metres
area: [[0, 0], [30, 0], [30, 4], [0, 4]]
period_s: 32
fleet: {robots: 1, speed_m_s: 1, sensor: {shape: disc, radius_m: 5}}
planner: patrol
patrol: {effort: quick}
"""


def test_too_few_robots_exit_with_3_and_the_ratio_that_the_check_of_the_best_plan_shows(tmp_path: Path) -> None:
    mission, answer = tmp_path / "corridor.yaml", tmp_path / "corridor.rota.json"
    mission.write_text(CORRIDOR)
    outcome = CliRunner().invoke(app, ["plan", str(mission), "--best", "-o", str(answer)])
    assert outcome.exit_code == 3
    told = float(outcome.output.split("no plan: ")[1].split(" times its period")[0].split()[-1])
    shortest = 2 * (30 - 2 * END_M) / 32
    assert shortest - 5e-4 <= told <= 1.05 * shortest
    plan = read_plan(answer)
    report = check_plan(plan)
    assert report.verdict == "violated"
    # the points that the check looks at do not lie quite in the corners
    assert 0.95 * told < report.worst_ratio_at_least <= told + 5e-4
    assert f"Worst gap: at least {report.worst_ratio_at_least:.3f} times its period." in outcome.output
    assert json.loads(answer.read_text())["meets_demand"] is False
    # the same routes, asked for no more than what was told; the bound was that of the shorter period
    eased = replace(plan, mission=replace(plan.mission, period_s=32 * (told + 5e-4)))
    assert [wrong.kind for wrong in check_plan(eased).violations] == ["claims that fewer robots cannot do"]
    assert check_plan(replace(eased, lower_bound_robots=None, lower_bound_reason=None)).verdict == "met"
    assert CliRunner().invoke(app, ["check", str(answer)]).exit_code == 1


@pytest.mark.parametrize("robots", [2, 4])
def test_robots_too_many_to_move_stand_where_there_is_room(robots: int) -> None:
    # any one of them sees all of it from anywhere
    plan = rota.make_plan(guarded(box(0, 0, 3, 3), robots=robots, period_s=20, body_radius_m=0.5))
    assert len(plan.trajectories) == robots
    assert worst_gap_s(plan) == 0


def test_a_spare_robot_goes_to_the_larger_part() -> None:
    rooms = (box(0, 0, 4, 4), box(20, 0, 50, 4))
    plan = rota.make_plan(guarded(*rooms, robots=3, period_s=60))
    at = [box(0, 0, 4, 4).buffer(1e-9).contains(MultiPolygon([box(*p, *(p + 1e-9))])) for p in firsts(plan)]
    assert sorted(at) == [False, False, True]
    assert worst_gap_s(plan) < 1.05 * 2 * (15 - 2 * END_M)


def firsts(plan: rota.Plan) -> list[np.ndarray]:
    return [trajectory.positions_m[0] for trajectory in plan]


@pytest.fixture(scope="module")
def hall() -> Problem:
    return set_up_problem(guarded(box(0, 0, 30, 20), robots=1, period_s=10, body_radius_m=0.5))


def test_the_proved_ratio_is_that_of_sweeping(hall: Problem) -> None:
    # 600 / (2 r V s T + pi r^2) robots for s times the period
    for robots in (1, 3):
        exact = (600 / robots - math.pi * REACH_M**2) / (2 * REACH_M * 10)
        assert proved_ratio(hall, robots) == pytest.approx(exact, rel=2e-3)
        assert proved_ratio(hall, robots) <= exact
    assert proved_ratio(hall, 8) == 0  # standing, they have all in range


def test_stretched_periods_are_stretched_everywhere() -> None:
    mission = guarded(box(0, 0, 30, 20), robots=1, period_s=10)
    zones = (
        Zone(name="quick", shape=MultiPolygon([box(0, 0, 5, 5)]), period_s=4),
        Zone(name="spare", shape=MultiPolygon([box(9, 9, 12, 12)]), period_s=None),
    )
    longer = stretch_periods(set_up_problem(replace(mission, zones=zones)), 1.5)
    assert longer.periods_s == (6, 15)
    assert [region.period_s for region in longer.regions] == [6, 15]
    assert [zone.period_s for zone in longer.mission.zones] == [6, None]
    assert longer.mission.period_s == 15
    assert longer.samples is not None


def test_robots_stand_aside_only_where_bodies_do_not_touch(hall: Problem) -> None:
    ring = np.array([[2.0, 2.0], [28.0, 2.0], [28.0, 18.0], [2.0, 18.0]])
    tour = Tour(vertices_m=ring, period_class=0, period_s=10.0, robots=1, robot=hall.robot, component=0)
    tours = with_bystanders(hall, [tour], 6)
    assert tours is not None
    stands_m = np.vstack([one.vertices_m for one in tours[1:]])
    assert len(stands_m) == 5
    assert ((stands_m > 3) & (stands_m < (27, 17))).all()
    apart_m = np.hypot(*(stands_m[:, None] - stands_m[None]).transpose(2, 0, 1))
    assert apart_m[np.triu_indices(5, 1)].min() > 1
    assert with_bystanders(hall, [tour], 1000) is None


def test_the_ratio_is_told_for_fleets_of_a_given_number() -> None:
    plan = rota.make_plan(guarded(box(0, 0, 4, 4), robots=1, period_s=9))
    report = check_plan(plan)
    assert ratio_sentence(plan, report) == "Worst gap: 0.000 of its period."
    one = replace(report.demands[0], worst_gap_s=12.0, worst_gap_at_least_s=11.7)
    assert ratio_sentence(plan, replace(report, demands=(one,))) == "Worst gap: 1.333 of its period."
    missed = replace(report, verdict="violated", demands=(one,))
    assert ratio_sentence(plan, missed) == "Worst gap: at least 1.300 times its period."
    never = replace(missed, demands=(replace(one, worst_gap_at_least_s=math.inf),))
    assert ratio_sentence(plan, never) == "Worst gap: some of what is asked is never seen."
    free = replace(plan, mission=replace(plan.mission, fleet=replace(plan.mission.fleet, robots=None)))
    assert ratio_sentence(free, report) is None
