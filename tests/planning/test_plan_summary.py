"""The table that ends every plan."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from shapely import box
from tests import driven_with_mass

from rota.model.mission import DiscSensor, Fleet, Mission, Robot, SquareSensor, Zone
from rota.model.plan import Plan, Trajectory
from rota.planning.plan_summary import (
    bound_sentence,
    robot_rows,
    robots_sentence,
    robots_table,
    round_off,
)

MISSION = Mission(
    name="yard",
    area=box(0, 0, 100, 100),
    zones=(
        Zone(name="gate", shape=box(0, 0, 10, 10), period_s=20),
        Zone(name="tank", shape=box(50, 0, 60, 10), period_s=50),
        Zone(name="door", shape=box(90, 90, 100, 100), period_s=30, demand="visit"),
        Zone(name="pond", shape=box(0, 50, 10, 60), period_s=None),
    ),
    period_s=200,
    fleet=Fleet(speed_m_s=10, sensor=DiscSensor(radius_m=5)),
)


def there_and_back(x0: float, y0: float, x1: float, y1: float, loop_s: float = 10) -> Trajectory:
    return Trajectory(
        robot="r", times_s=[0, 1, 1 + loop_s / 2, 1 + loop_s], positions_m=[[1, 1], [x0, y0], [x1, y1], [x0, y0]],
        loop_start_s=1,
    )  # fmt: skip


def served(trajectory: Trajectory, mission: Mission = MISSION) -> tuple[str, ...]:
    (row,) = robot_rows(Plan(mission=mission, trajectories=(trajectory,)))
    return row.zones


def test_a_zone_within_reach_of_the_loop_is_served_and_the_approach_does_not_count() -> None:
    assert served(there_and_back(2, 2, 8, 8)) == ("gate", "area")
    assert served(there_and_back(14.9, 5, 20, 5)) == ("gate", "area")
    assert served(there_and_back(15.0, 5, 20, 5)) == ("area",)
    # within reach by the corner of a square, which is farther than its side's half
    square = dataclasses.replace(MISSION.fleet, sensor=SquareSensor(side_m=10))
    assert served(there_and_back(17, 5, 20, 5), dataclasses.replace(MISSION, fleet=square)) == ("gate", "area")


def test_a_visit_needs_the_loop_inside() -> None:
    assert served(there_and_back(88, 95, 80, 95)) == ("area",)
    assert served(there_and_back(91, 95, 80, 95)) == ("door", "area")


def test_a_loop_longer_than_a_period_does_not_serve_that_zone_alone() -> None:
    assert served(there_and_back(5, 5, 55, 5, loop_s=40)) == ("tank", "area")
    row = robot_rows(Plan(mission=MISSION, trajectories=(there_and_back(5, 5, 55, 5, loop_s=40),)))[0]
    assert row.slack == pytest.approx(1 - 40 / 50)
    assert row.loop_length_m == pytest.approx(100)
    assert row.loop_time_s == 40


def test_robots_that_share_have_no_slack_of_their_own() -> None:
    row = robot_rows(Plan(mission=MISSION, trajectories=(there_and_back(5, 5, 55, 5, loop_s=300),)))[0]
    assert row.zones == ("gate", "tank", "area")
    assert row.slack is None


def test_a_loop_in_rounds_serves_what_it_passes_on_each_of_them() -> None:
    # from (12, 5), past the gate every time: to the tank and back in 16 s, along the gate and back in 12 s
    loop = Trajectory(
        robot="r", times_s=[0, 2, 8, 14, 16, 22, 28],
        positions_m=[[9, 9], [12, 5], [55, 5], [9, 9], [12, 5], [5, 5], [9, 9]], loop_start_s=0,
    )  # fmt: skip
    row = robot_rows(Plan(mission=MISSION, trajectories=(loop,)))[0]
    assert row.zones == ("gate", "tank", "area")
    assert row.slack == pytest.approx(1 - 14 / 20)
    # begun elsewhere it is the same loop
    later = Trajectory(
        robot="r", times_s=[0, 6, 8, 14, 20, 22, 28],
        positions_m=[[55, 5], [9, 9], [12, 5], [5, 5], [9, 9], [12, 5], [55, 5]], loop_start_s=0,
    )  # fmt: skip
    assert robot_rows(Plan(mission=MISSION, trajectories=(later,)))[0].slack == pytest.approx(row.slack)


def test_a_place_that_is_passed_by_curves_ends_rounds_all_the_same() -> None:
    hub = np.array([14.0, 12.0])
    corners = np.array([[14, 30], hub, [50, 12], [50, 30], hub, [5, 8], [5, 30]])
    loop = driven_with_mass.rounded(corners, np.array([0, 1.2, 2, 2, 1.2, 1, 1]), np.zeros(7), top=6, a=2)
    moments = np.arange(0, loop.loop_duration_s, 0.01)
    off_m = np.linalg.norm(loop.at(moments) - hub, axis=1)
    passed_s = moments[1:-1][(off_m[1:-1] < off_m[:-2]) & (off_m[1:-1] < off_m[2:]) & (off_m[1:-1] < 2)]
    assert len(passed_s) == 2
    longest_s = max(passed_s[1] - passed_s[0], loop.loop_duration_s - passed_s[1] + passed_s[0])
    gate = dataclasses.replace(MISSION.zones[0], period_s=25)
    mission = dataclasses.replace(MISSION, zones=(gate,))
    row = robot_rows(Plan(mission=mission, trajectories=(dataclasses.replace(loop, robot="r"),)))[0]
    assert row.zones == ("gate", "area")
    assert row.slack == pytest.approx(1 - longest_s / 25, abs=1e-3)


def test_a_robot_that_stays_has_all_its_period_left() -> None:
    stay = Trajectory(robot="r", times_s=[0.0], positions_m=[[5, 5]])
    row = robot_rows(Plan(mission=MISSION, trajectories=(stay,)))[0]
    assert (row.loop_length_m, row.loop_time_s, row.slack) == (0, 0, 1)
    assert row.zones == ("gate",)


def test_no_area_row_where_nothing_is_asked_outside_zones() -> None:
    zones_only = dataclasses.replace(MISSION, period_s=None)
    assert served(there_and_back(30, 30, 35, 35), zones_only) == ()
    covered = dataclasses.replace(MISSION, zones=(Zone(name="all", shape=box(-5, -5, 105, 105), period_s=9),))
    assert served(there_and_back(30, 30, 35, 35, loop_s=5), covered) == ("all",)


@pytest.mark.parametrize(
    ("robots", "bound", "sentence"),
    [
        (1, 1, "1 robot: no plan needs fewer, proved."),
        (1, 5, "1 robot; meeting the demand takes at least 5, proved."),
        (2, 1, "2 robots; that one robot cannot do it is not proved."),
        (4, 3, "4 robots; no plan with fewer than 3 exists, proved."),
        (2, None, "2 robots; no lower bound is known."),
    ],
)
def test_the_sentence_on_robots(robots: int, bound: int | None, sentence: str) -> None:
    fleet = tuple(Robot(name=f"r{k}", speed_m_s=1, sensor=DiscSensor(radius_m=1)) for k in range(robots))
    mission = dataclasses.replace(MISSION, fleet=dataclasses.replace(MISSION.fleet, robots=fleet))
    stays = tuple(Trajectory(robot=robot.name, times_s=[0.0], positions_m=[[5, 5]]) for robot in fleet)
    plan = Plan(mission=mission, trajectories=stays, lower_bound_robots=bound)
    assert robots_sentence(plan) == sentence
    assert bound_sentence(plan) is None
    if bound is not None:
        count = "1 robot" if bound == 1 else f"{bound} robots"
        told = bound_sentence(dataclasses.replace(plan, lower_bound_reason="the places are far apart"))
        assert told == f"{count} at least: the places are far apart."


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (0, "0.0"),
        (9.285, "9.3"),
        (3761.49, "3761.5"),
        (1.0, "1.0"),
        (0.998, "1"),
        (0.0123, "0.012"),
        (58_012.3, "58012.3"),
    ],
)
def test_lengths_and_times_have_one_decimal_or_two_digits(value: float, told: str) -> None:
    assert round_off(value) == told


def test_the_table_is_aligned_and_never_wrapped() -> None:
    zones = tuple(dataclasses.replace(MISSION.zones[0], name=f"a zone with a long name {k}") for k in range(9))
    shared = there_and_back(2, 2, 8, 8, loop_s=900)
    plan = Plan(
        mission=dataclasses.replace(MISSION, zones=zones),
        trajectories=(there_and_back(2, 2, 8, 8), dataclasses.replace(shared, robot="the longest")),
    )
    names = ", ".join([*(zone.name for zone in zones), "area"])
    assert robots_table(plan).splitlines() == [
        "robot        loop m  loop s   slack  serves",
        f"r              17.0    10.0     50%  {names}",
        f"the longest    17.0   900.0  shared  {names}",
    ]
