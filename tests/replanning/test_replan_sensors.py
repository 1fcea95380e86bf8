"""Zones that name sensors where a robot is lost: who counts for them takes over, if any is left."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from rota import (
    DiscSensor,
    Fleet,
    Mission,
    PatrolSettings,
    Plan,
    Robot,
    Trajectory,
    Zone,
    check_plan,
    make_plan,
    replan,
)
from rota.errors import NoPlanFound
from rota.model.plan import Floats

HEAT = DiscSensor(radius_m=8, name="thermal")
SPEEDS_M_S = {"a": 1.0, "b": 1.0, "c": 1.0}


def squares(sensors: tuple[str, ...], speeds_m_s: dict[str, float] | None = None) -> Plan:
    """Three squares of 40 m, 15 m apart, with a robot on each: a and c see heat, b between them does not."""
    speeds_m_s = SPEEDS_M_S | (speeds_m_s or {})
    robots = [
        Robot(name=name, speed_m_s=speeds_m_s[name], sensor=DiscSensor(radius_m=8) if name == "b" else HEAT)
        for name in "abc"
    ]
    zones = [Zone(name=f"at {x}", period_s=200, shape=shapely.box(x, 0, x + 10, 10)) for x in (0, 25, 50)]
    zones[0] = replace(zones[0], name="hot", sensors=sensors)
    mission = Mission(
        name="squares", area=shapely.box(-5, -5, 65, 15), zones=tuple(zones), period_s=None,
        fleet=Fleet(speed_m_s=1, sensor=HEAT, robots=robots), planning=PatrolSettings(effort="quick"),
    )  # fmt: skip
    corners = np.array([[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]], float)
    ways = [
        Trajectory(
            robot=name, times_s=np.arange(0, 50, 10) / speeds_m_s[name], positions_m=corners + np.array([25 * k, 0])
        )
        for k, name in enumerate("abc")
    ]
    return Plan(mission=mission, trajectories=tuple(ways))


def reached_m(way: Trajectory) -> Floats:
    """The least and the greatest x of a robot's loop."""
    x = way.positions_m[way.loop_index :, 0]
    return np.array([x.min(), x.max()])


@pytest.mark.parametrize(("sensors", "taken_by"), [(("thermal",), "c"), ((), "b")])
def test_a_hot_zone_goes_to_who_counts_for_it_and_any_other_to_who_is_near(
    sensors: tuple[str, ...], taken_by: str
) -> None:
    found = replan(squares(sensors), at_s=5, lost=["a"], should_stop=lambda: True)
    assert found.report.verdict == "met"
    reached = {way.robot: reached_m(way) for way in found.plan}
    assert taken_by in [name for name, x in reached.items() if x[0] < 5]
    # of those that count for it alone the hot zone is seen in time, by the check
    counting = replace(found.plan, trajectories=tuple(one for one in found.plan if one.robot == taken_by), seam=None)
    assert next(one for one in check_plan(counting).demands if one.name == "hot").outcome == "met"


def test_where_nobody_counts_any_more_it_is_told_and_all_others_go_on() -> None:
    found = replan(squares(("thermal",)), at_s=5, lost=["a", "c"], should_stop=lambda: True)
    hot = next(one for one in found.report.demands if one.name == "hot")
    assert (found.report.verdict, hot.outcome) == ("violated", "violated")
    assert hot.unseen_area_m2 == pytest.approx(100)
    with pytest.raises(NoPlanFound, match="zone hot: no robot has a sensor that counts: thermal"):
        make_plan(found.plan.mission)


def test_a_slow_robot_drives_a_fast_ones_round_at_its_own_speed() -> None:
    found = replan(squares((), {"a": 4.0}), at_s=5, lost=["b", "c"], joined={"d": (0.0, 5.0)}, should_stop=lambda: True)
    assert found.report.verdict == "met"
    joined = replan(squares((), {"a": 4.0}), at_s=5, lost=["a"], joined={"d": (0.0, 5.0)}, should_stop=lambda: True)
    assert joined.report.verdict == "met"
    assert joined.plan["d"].loop_duration_s == pytest.approx(40, abs=0.1)
    assert set(joined.kept) == {"b", "c"}
