"""What one robot more or less brings, beside closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapely import box

from rota.check import check_plan, margins_of
from rota.model.mission import Fleet, Mission, SquareSensor
from rota.model.plan import Plan, Trajectory
from rota.planning.one_robot_more import one_robot_sentence, with_one_more
from rota.routes.distinct_loops import shared_loops

SIDE_M, WIDTH_M, ROUND_S = 40.0, 0.05, 160.0
RING_M = np.array([[0, 0], [SIDE_M, 0], [SIDE_M, SIDE_M], [0, SIDE_M], [0, 0]])


def ring(robots: int = 2, bound: int | None = None, *, named: bool = False) -> Plan:
    """Robots spread evenly over a ring of 160 m at 1 m/s, all of whose ground they see for 10 m before and behind."""
    sensor = SquareSensor(side_m=20.0)
    fleet = Fleet(speed_m_s=1.0, sensor=sensor, robots=robots if named else None)
    outer_m, inner_m = SIDE_M + WIDTH_M, SIDE_M - WIDTH_M
    area = box(-WIDTH_M, -WIDTH_M, outer_m, outer_m).difference(box(WIDTH_M, WIDTH_M, inner_m, inner_m))
    mission = Mission(name="ring", area=area, period_s=100.0, fleet=fleet)
    times_s = np.linspace(0, ROUND_S, 5)
    ways = [
        Trajectory(robot=f"robot-{k + 1}", times_s=times_s, positions_m=np.vstack([turned, turned[:1]]))
        for k, turned in enumerate(np.roll(RING_M[:-1], -2 * k, axis=0) for k in range(robots))
    ]
    return Plan(mission=mission, trajectories=tuple(ways), lower_bound_robots=bound)


def sentence(plan: Plan) -> str | None:
    report = check_plan(plan)
    return one_robot_sentence(plan, replace(report, margins=margins_of(plan, report)))


@pytest.mark.parametrize("named", [False, True])
def test_one_more_is_spread_evenly_with_the_others(named: bool) -> None:
    """Two pass a place every 80 s and see it for 20 s, three every 160 / 3 s: gaps of 60 s and a third of 100 s."""
    plan = ring(named=named)
    assert check_plan(plan).worst_ratio_at_least == pytest.approx(0.6, abs=0.01)
    (loop,) = shared_loops(plan)
    more = with_one_more(plan, loop)
    assert len(more) == 3
    report = check_plan(more)
    assert (report.verdict, report.violations) == ("met", ())
    assert report.worst_ratio_at_least == pytest.approx(1 / 3, abs=0.01)
    told = sentence(plan)
    assert told is not None
    assert told.startswith(
        "One robot more on the loop of robot-1 and robot-2 would leave 66.6 % of each period instead of 39.9 %,"
    )


def test_of_one_less_it_is_said_what_is_proved() -> None:
    less = {bound: (sentence(ring(bound=bound)) or "").split(". ")[1] for bound in (None, 1, 2)}
    assert less[2] == "One robot less cannot do it, proved."
    assert less[1] == less[None] == "With one robot less no plan was found, and none is ruled out."
    assert "was not searched" in (sentence(ring(named=True)) or "")


def test_loops_with_accelerations_keep_them() -> None:
    way = Trajectory(
        robot="robot-1", times_s=[0, 4, 8, 12, 16], positions_m=[[2, 2], [8, 2], [14, 2], [8, 2], [2, 2]],
        accelerations_m_s2=[0.75, -0.75, 0.75, -0.75],
    )  # fmt: skip
    mission = Mission(
        name="way", area=box(0, 0, 16, 4), period_s=30.0, fleet=Fleet(speed_m_s=4.0, sensor=SquareSensor(side_m=6.0))
    )
    more = with_one_more(Plan(mission=mission, trajectories=(way,)), [way])
    later = more.trajectories[1]
    assert later.loop_start_s == 8.0
    times_s = np.linspace(20, 40, 50)
    assert later.at(times_s) == pytest.approx(way.at(times_s - 8.0))


def test_of_what_is_not_met_nothing_is_said() -> None:
    plan = ring(robots=1)
    assert sentence(plan) is None
