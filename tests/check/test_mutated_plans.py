"""Plan files made wrong at random are refused or judged, and nothing else; benchmarks/plan_fuzz.py does thousands."""

from __future__ import annotations

import copy
import json
import random
from typing import Any

import jsonschema
import pytest
from benchmarks.plan_mutations import mutated
from benchmarks.small_plans import small_plans
from hypothesis import given, settings, strategies as st

from rota.check import check_plan, report_schema, report_table, report_to_json
from rota.errors import PlanError
from rota.files.plan_file import plan_from_text, plan_to_json
from rota.limits import LARGEST_M

DOCUMENTS = [plan_to_json(plan) for plan in small_plans()]
SCHEMA = jsonschema.Draft202012Validator(report_schema())
LARGEST_AREA_M2 = 1e5  # that these tests let the check look at, since larger ground takes it minutes


def judge(text: bytes) -> str:
    """Refused, or a verdict with a report that can be told; all else is raised."""
    try:
        plan = plan_from_text(text, "mutated")
    except PlanError:
        return "refused"
    sensors = [plan.mission.fleet.robot(way.robot).sensor.reach_m for way in plan]
    if plan.mission.area.area > LARGEST_AREA_M2 or min(sensors, default=1) < 0.05:
        return "large"
    report = check_plan(plan, finest_m=0.05)
    SCHEMA.validate(json.loads(json.dumps(report_to_json(report), allow_nan=False)))
    assert report_table(report).startswith(f"verdict: {report.verdict}")
    return report.verdict


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
    judge(json.dumps(document).encode("utf-8", "surrogatepass"))


@pytest.mark.parametrize("block", range(4))
def test_own_mutations(block: int) -> None:
    outcomes = set()
    for case in range(40 * block, 40 * block + 40):
        outcomes.add(judge(mutated(DOCUMENTS[case % len(DOCUMENTS)], random.Random(case))))
    assert {"refused", "violated"} <= outcomes  # neither reader nor check has everything


def test_the_plans_themselves_are_judged() -> None:
    assert [judge(json.dumps(document).encode()) for document in DOCUMENTS] == [
        "met",
        "violated",
        "violated",
        "met",
        "met",
        "met",
    ]
