"""Plan files made wrong at random are refused or judged, and nothing else; benchmarks/plan_fuzz.py does thousands.

A refusal names its place, a report can be told, and what it says is met is seen by a simulation, too.
"""

from __future__ import annotations

import copy
import json
import random
import re
from typing import Any

import jsonschema
import numpy as np
import pytest
import shapely
from benchmarks.plan_mutations import mutated
from benchmarks.small_plans import small_plans
from hypothesis import given, settings, strategies as st
from shapely import union_all
from shapely.geometry.base import BaseGeometry
from tests.seeds import seeds

from rota.check import DemandVerdict, check_plan, report_schema, report_table, report_to_json
from rota.errors import PlanError
from rota.files.plan_file import plan_from_text, plan_to_json
from rota.model.limits import LARGEST_M
from rota.model.mission import Mission
from rota.model.plan import Plan

# without the digest of the mission, which would refuse most mutations at once
DOCUMENTS = [
    {key: value for key, value in plan_to_json(plan).items() if key != "mission_sha256"} for plan in small_plans()
]
SCHEMA = jsonschema.Draft202012Validator(report_schema())
LARGEST_AREA_M2 = 1e5  # that these tests let the check look at, since larger ground takes it minutes
# line and column, the field, the byte, or that it is the whole file, or brackets without end
PLACED = re.compile(
    r"mutated(:\d+:\d+: |: (.+?: |byte \d+ |and \d+ more faults|-?Infinity is|NaN is|brackets nested|not a plan file))"
)
POINTS, WINDOWS, STEPS = 40, 5, 200  # of the simulation


def assert_refused_or_truly_judged(text: bytes) -> str:
    """Refused with a place, or a verdict with a report that can be told and is true; all else is raised."""
    try:
        plan = plan_from_text(text, "mutated")
    except PlanError as error:
        for line in str(error).splitlines():
            assert PLACED.match(line), line
        return "refused"
    sensors = [plan.mission.fleet.robot(way.robot).sensor.reach_m for way in plan]
    if plan.mission.area.area > LARGEST_AREA_M2 or min(sensors, default=1) < 0.05:
        return "large"
    report = check_plan(plan, finest_m=0.05)
    SCHEMA.validate(json.loads(json.dumps(report_to_json(report), allow_nan=False)))
    assert report_table(report).startswith(f"verdict: {report.verdict}")
    if report.verdict == "met":
        assert not report.violations
        for demand in report.demands:
            assert demand.outcome == "met"
            assert demand.worst_gap_s <= demand.period_s
            assert_somebody_comes(plan, demand)
    return report.verdict


def ground_of(mission: Mission, name: str) -> BaseGeometry:
    """What a demand asks for, without what other demands may share with it, and without obstacles."""
    others = [zone.shape for zone in mission.zones if zone.name != name]
    whole = next((zone.shape for zone in mission.zones if zone.name == name), mission.area)
    return mission.area.intersection(whole).difference(union_all([*others, *(o.shape for o in mission.obstacles)]))


def assert_somebody_comes(plan: Plan, demand: DemandVerdict) -> None:
    """What any demand that is met needs: in some windows of its period a robot is in range of points, or in the zone.

    Simulated by steps of time, and so with the way that a robot goes in a step to spare; walls are left out.
    """
    ground = ground_of(plan.mission, demand.name)
    if demand.excluded_area_m2 > 0 or ground.area == 0:
        return
    rng = np.random.default_rng(0)
    low, high = np.array(ground.bounds).reshape(2, 2)
    points = shapely.points(rng.uniform(low, high, (POINTS, 2)))
    points = points[shapely.contains(ground, points)]
    step_s = demand.period_s / STEPS
    for begin_s in max(way.loop_start_s for way in plan) + rng.uniform(0, 3 * demand.period_s, WINDOWS):
        times_s = begin_s + step_s * np.arange(STEPS + 1)
        seen = np.zeros(len(points), dtype=bool)
        entered = False
        for way in plan:
            robot = plan.mission.fleet.robot(way.robot)
            spare_m = robot.speed_m_s * step_s + 1e-6
            x, y = way.at(times_s).T[:2]
            seen |= shapely.dwithin(
                points, shapely.multipoints(np.column_stack([x, y])), robot.sensor.reach_m + spare_m
            )
            zone = next((zone.shape for zone in plan.mission.zones if zone.name == demand.name), plan.mission.area)
            entered = entered or bool(shapely.dwithin(zone, shapely.points(x, y), spare_m).any())
        assert entered if demand.demand == "visit" else seen.all()


def places(node: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    keys = node.keys() if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else ()
    return [found for key in keys for found in ((*path, key), *places(node[key], (*path, key)))]


numbers = st.floats() | st.integers() | st.floats(-LARGEST_M, LARGEST_M) | st.sampled_from([0, -1, 1e-9, 1e6, 1e300])
values = st.recursive(
    st.none() | st.booleans() | numbers | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
    max_leaves=5,
)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.data())
def test_one_or_two_fields_changed(data: st.DataObject) -> None:
    document = copy.deepcopy(data.draw(st.sampled_from(DOCUMENTS)))
    for _ in range(data.draw(st.integers(1, 2))):
        *path, last = data.draw(st.sampled_from(places(document)))
        holder = document
        for key in path:
            holder = holder[key]
        was = holder[last]
        nearby = (
            st.just(was) if not isinstance(was, float) else st.floats(was - 2, was + 2) | st.floats(0, 2 * abs(was))
        )
        holder[last] = data.draw(nearby | numbers if isinstance(was, int | float) else values)
    assert_refused_or_truly_judged(json.dumps(document).encode("utf-8", "surrogatepass"))


@pytest.mark.parametrize("block", seeds(4, at_once=1))
def test_own_mutations(block: int) -> None:
    outcomes = set()
    for case in range(40 * block, 40 * block + 40):
        outcomes.add(assert_refused_or_truly_judged(mutated(DOCUMENTS[case % len(DOCUMENTS)], random.Random(case))))
    assert {"refused", "violated"} <= outcomes  # neither reader nor check has everything


def test_the_plans_themselves_are_judged() -> None:
    assert [assert_refused_or_truly_judged(json.dumps(document).encode()) for document in DOCUMENTS] == [
        "met",
        "violated",
        "met",
        "violated",
        "met",
        "met",
        "met",
        "met",
    ]


BREAKS = {
    "speed": lambda way, fleet: fleet.update(speed_m_s=3.9),
    "acceleration": lambda way, fleet: way["accelerations_m_s2"].__setitem__(1, 1.2),
    "corner acceleration": lambda way, fleet: way["positions_m"].__setitem__(2, [6, 2.9]),
    "jerk": lambda way, fleet: fleet.update(jerk_m_s3=0.9),
}


@pytest.mark.parametrize("kind", BREAKS)
def test_broken_accelerations_are_caught(kind: str) -> None:
    """One field of a plan that is met: its speed, an acceleration that leaves speeds to jump, a point, its jerk."""
    document = copy.deepcopy(DOCUMENTS[2])
    way, fleet = document["robots"][0], document["mission"]["fleet"]
    BREAKS[kind](way, fleet["robots"][0])
    report = check_plan(plan_from_text(json.dumps(document).encode(), "broken"))
    assert report.verdict == "violated"
    assert kind in {violation.kind for violation in report.violations}
