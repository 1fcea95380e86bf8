"""Robots with a jerk cut corners on curves: where loops begin amid one, plans take over from them all the same."""

from __future__ import annotations

import pytest
import shapely

from rota import DiscSensor, Fleet, Mission, MotionLimits, PatrolSettings, make_plan, replan

AT_S = (0.0, 31.7, 95.2, 143.9, 1200.3)


@pytest.mark.parametrize(
    ("acceleration_m_s2", "jerk_m_s3", "period_s", "seed"),
    [(1, 1, 40, 0), pytest.param(3, 2, 30, 2, marks=pytest.mark.slow)],
)
def test_plans_take_over_from_loops_that_begin_amid_a_curve(
    acceleration_m_s2: float, jerk_m_s3: float, period_s: float, seed: int
) -> None:
    """The first robot's loop begins so; and what takes over is taken over from again."""
    motion = MotionLimits(acceleration_m_s2=acceleration_m_s2, jerk_m_s3=jerk_m_s3, corner_m=1.0)
    mission = Mission(
        name="yard",
        area=shapely.MultiPolygon([shapely.box(0, 0, 16, 10)]),
        period_s=period_s,
        fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=2), motion=motion),
        planning=PatrolSettings(effort="quick"),
    )
    plan = make_plan(mission, seed=seed)
    for at_s in AT_S:
        once = replan(plan, at_s=at_s, should_stop=lambda: True)
        again = replan(once.plan, at_s=17.3, should_stop=lambda: True)
        assert (once.report.verdict, again.report.verdict) == ("met", "met")
