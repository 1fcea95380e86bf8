"""Random missions through plan, replan and check: whatever is lost, joins or is late, the answer can be driven."""

from __future__ import annotations

import numpy as np
import shapely
from hypothesis import given, settings, strategies as st

from rota import (
    DiscSensor,
    Fleet,
    Mission,
    NoPlanFound,
    Obstacle,
    PatrolSettings,
    Plan,
    Zone,
    check_plan,
    make_plan,
    replan,
)
from rota.files.plan_file import plan_from_text, plan_text

WIDE_M, HIGH_M = 20.0, 14.0


@st.composite
def missions(draw: st.DrawFn) -> Mission:
    """A yard for one to three robots, with or without a block, a zone and bodies."""
    inner = st.floats(3, 9).map(lambda value: round(value, 1))
    block = shapely.box(8, 6, 8 + draw(inner), 6 + draw(inner) / 2)
    zone = Zone(
        name="zone", shape=shapely.box(1, 1, draw(inner), draw(inner)), importance=draw(st.sampled_from([None, 3])),
        period_s=draw(st.integers(10, 30)),
    )  # fmt: skip
    sensor = DiscSensor(radius_m=5)
    body_m = draw(st.sampled_from([0.0, 0.0, 0.25]))
    return Mission(
        name="any",
        area=shapely.MultiPolygon([shapely.box(0, 0, WIDE_M, HIGH_M)]),
        obstacles=(Obstacle(shape=block),) if draw(st.booleans()) else (),
        zones=(zone,) if draw(st.booleans()) else (),
        period_s=draw(st.integers(15, 30)),
        fleet=Fleet(speed_m_s=2, sensor=sensor, body_radius_m=body_m),
        planning=PatrolSettings(effort="quick", method=draw(st.sampled_from(["tours", "parallel"]))),
    )


@st.composite
def changes(draw: st.DrawFn, names: tuple[str, ...]) -> dict[str, object]:
    """A moment and who is lost, joins or is late then; somebody remains."""
    lost = draw(st.lists(st.sampled_from(names), max_size=len(names), unique=True))
    remain = [name for name in names if name not in lost]
    joined = {"new": (1.5, HIGH_M - 1.5)} if not remain or draw(st.booleans()) else {}
    late = {remain[0]: draw(st.floats(0, 20))} if remain and draw(st.booleans()) else {}
    return {"at_s": draw(st.floats(0, 500)), "lost": lost, "joined": joined, "late": late}


@settings(max_examples=6, deadline=None, derandomize=True, database=None)
@given(st.data())
def test_whatever_changes_the_answer_can_be_driven_from_where_robots_are(data: st.DataObject) -> None:
    mission = data.draw(missions())
    try:
        plan: Plan = make_plan(mission, seed=0)
    except NoPlanFound as failure:
        plan = failure.best  # type: ignore[assignment]
    names = tuple(line.robot for line in plan)
    change = data.draw(changes(names))
    try:
        found = replan(plan, should_stop=lambda: True, **change)  # type: ignore[arg-type]
    except NoPlanFound:
        assert mission.fleet.body_radius_m > 0, "points are in nobody's way"
        return
    again = plan_from_text(plan_text(found.plan), "it")
    report = check_plan(again)
    assert report.verdict == found.report.verdict
    assert {one.kind for one in report.violations} <= {"gap", "unseeable"}
    late, at_s = dict(change["late"]), float(change["at_s"])  # type: ignore[call-overload, arg-type]
    remain = [name for name in names if name not in change["lost"]]  # type: ignore[operator]
    assert {line.robot for line in again} == {*remain, *change["joined"]}  # type: ignore[misc]
    for name in remain:
        was = plan[name].at([max(0.0, at_s - late.get(name, 0.0))])[0]
        assert np.hypot(*(again[name].positions_m[0, :2] - was[:2])) < 1e-6
    lateness = report.lateness
    assert lateness is not None
    assert lateness.lost == tuple(change["lost"])  # type: ignore[arg-type]
    if found.meets_demand and lateness.holds_again_s is not None:
        assert lateness.holds_again_s <= again_by(again)
    for demand in lateness.demands:
        assert 0 <= demand.worst_at_least_s <= demand.worst_s


def again_by(plan: Plan) -> float:
    """When all have been round their loops once and every period has gone by, all must hold again."""
    periods_s = [plan.mission.period_s or 0.0, *(zone.period_s or 0.0 for zone in plan.mission.zones)]
    return max(float(line.times_s[-1]) for line in plan) + max(periods_s)
