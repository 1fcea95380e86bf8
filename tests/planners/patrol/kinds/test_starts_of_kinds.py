"""Unlike robots with bodies set out together, wherever the ground of each lies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapely import box

from rota import DiscSensor, Fleet, Mission, NoPlanFound, PatrolSettings, Plan, Robot, Trajectory, check_plan, make_plan
from rota.model.battery_limits import BatteryLimits
from rota.model.fleet import Kind
from rota.model.mission import Charger, StartBox
from rota.planners.patrol.kinds.starts import lead_groups

SENSOR = DiscSensor(radius_m=4)
YARD = Mission(
    name="yard", area=box(0, 0, 40, 20), period_s=60, planning=PatrolSettings(effort="quick"),
    fleet=Fleet(
        speed_m_s=1, sensor=SENSOR, body_radius_m=0.3, start=StartBox(low_m=(1, 1), high_m=(5, 5)),
        kinds=(
            Kind(name="slow", cost=1, most=1, body_radius_m=0.3),
            Kind(name="fast", cost=1.2, most=1, speed_m_s=1.5, body_radius_m=0.3),
        ),
    ),
)  # fmt: skip


@pytest.mark.parametrize("charges", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_kinds_set_out_from_one_box(charges: bool) -> None:
    mission = YARD
    if charges:
        battery = BatteryLimits(endurance_s=900, recharge_s=60)
        pads = tuple(
            Charger(name=name, at=at, places=2) for name, at in (("west", (2.0, 18.0)), ("east", (38.0, 18.0)))
        )
        kinds = tuple(replace(kind, most=2, battery=battery) for kind in YARD.fleet.kinds)
        mission = replace(YARD, fleet=replace(YARD.fleet, battery=battery, kinds=kinds), chargers=pads)
    plan = make_plan(mission, seed=0)
    assert plan.mission == mission
    assert {one.robot.rpartition("-")[0] for one in plan} == {"slow", "fast"}
    assert check_plan(plan).verdict == "met"
    places_m = np.array([one.positions_m[0] for one in plan])
    assert ((places_m >= 1) & (places_m <= 5)).all()
    assert np.hypot(*(places_m[0] - places_m[1])) > 2 * 0.3


def crossing() -> tuple[Plan, Mission]:
    """Two unlike robots whose straight ways from their starts cross in the middle at the same moment."""
    robots = (
        Robot(name="a", start=(2, 10), speed_m_s=1, sensor=SENSOR, body_radius_m=0.5),
        Robot(name="b", start=(12, 0.5), speed_m_s=1, sensor=DiscSensor(radius_m=5), body_radius_m=0.5),
    )
    mission = replace(YARD, fleet=replace(YARD.fleet, start=None, kinds=(), robots=robots), period_s=500)
    shuttles = (
        Trajectory(robot="a", times_s=[0, 1, 2], positions_m=[[22, 10], [22, 9], [22, 10]], loop_start_s=0),
        Trajectory(robot="b", times_s=[0, 1, 2], positions_m=[[12, 19], [13, 19], [12, 19]], loop_start_s=0),
    )
    return Plan(mission=mission, trajectories=shuttles), mission


def test_groups_set_out_one_after_the_other_where_bodies_would_touch() -> None:
    plan, mission = crossing()
    tried: list[list[float]] = []

    class Judged:
        def __init__(self, verdict: str) -> None:
            self.verdict, self.demands, self.violations = verdict, (), check_plan(plan).violations

    def judge(led: Plan) -> Judged:
        tried.append([one.loop_start_s for one in led])
        touching = [one for one in check_plan(led).violations if "bodies" in one.kind or "touch" in one.kind]
        return Judged("violated" if touching else "met")

    led = lead_groups(plan, mission, judge)  # type: ignore[arg-type]
    assert [one.positions_m[0].tolist() for one in led] == [[2, 10], [12, 0.5]]
    assert len(tried) == 2
    # 20 m for one and 18.5 m for the other; whoever waits does so for two steps of 2 s at most
    assert sorted(tried[0]) == pytest.approx([18.5, 20.0], abs=0.01)
    assert 1.9 < led["a"].loop_start_s + led["b"].loop_start_s - 38.5 < 4.1


def test_ways_that_no_order_makes_pass_are_told_with_what_is_wrong() -> None:
    plan, mission = crossing()
    with pytest.raises(NoPlanFound, match="with the ways from the starts the plan does not pass the check") as found:
        lead_groups(plan, mission, check_plan)  # two shuttles see little of the yard
    assert isinstance(found.value.best, Plan)
