"""Each field of missions and plans is declared once: schemas, readers, writer and examples know it by that alone."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import pytest

from rota.files.blocks import Block, block_of, make, read_block
from rota.files.example_mission import example_mission_text
from rota.files.json_schema import block_schema
from rota.files.mission_file import mission_schema
from rota.files.mission_schema import mission_block
from rota.files.plan_schema import plan_block
from rota.files.shape_schema import Area
from rota.model.field_values import in_file_form
from rota.model.fields import field_of, fields_of, flat_fields_of
from rota.model.fleet import Abilities, DiscSensor, Fleet, Robot, SquareSensor, StartPoints
from rota.model.importance import ImportanceMap
from rota.model.limits import RATE
from rota.model.mission import GeoPoint, Mission, MovingObstacle, Obstacle, Zone
from rota.model.motion_limits import MotionLimits
from rota.model.plan import Driven, Plan, RunEnd, Seam, Trajectory, Waypoints

TYPES = [
    Abilities, DiscSensor, Driven, Fleet, GeoPoint, ImportanceMap, Mission, MotionLimits, MovingObstacle, Obstacle,
    Plan, Robot, RunEnd, Seam, SquareSensor, StartPoints, Trajectory, Waypoints, Zone,
]  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class BrakingFleet(Fleet):
    """A fleet with one field more."""

    braking_m_s2: float | None = field_of(None, "null: at once", above=0, written=RATE, newer=True, spared=True)


def test_a_field_that_is_declared_is_read_checked_published_and_written() -> None:
    sensor = {"shape": "disc", "radius_m": 4}
    for form in ("mission", "plan"):
        robots = next(item for item in fleet_block(form).fields if item.name == "robots")
        block = block_of(BrakingFleet, form, {"robots": robots})
        about = block_schema(block)["properties"]["braking_m_s2"]
        least = {"minimum": 1e-6, "maximum": 1e6} if form == "mission" else {"exclusiveMinimum": 0}
        assert about["anyOf"] == [{"type": "number", **least}, {"type": "null"}]
        assert about["description"] == "null: at once"
        document = {"robots": "fewest", "speed_m_s": 5, "sensor": sensor, "body_radius_m": 0, "altitude_m": 30}
        document |= {"turn_rate_rad_s": None, "braking_m_s2": -2}
        (fault,) = read_block(block, document)[1]
        assert (fault.place, fault.message.partition(";")[0]) == (("braking_m_s2",), "-2 is not allowed")
        values, faults = read_block(block, {**document, "braking_m_s2": 2})
        assert not faults
        fleet = make(BrakingFleet, **values)
        assert (fleet.braking_m_s2, in_file_form(fleet)["braking_m_s2"]) == (2, 2.0)
        assert "braking_m_s2" not in in_file_form(make(BrakingFleet, **values | {"braking_m_s2": None}))


def fleet_block(form: str) -> Block:
    block = mission_block() if form == "mission" else next(i for i in plan_block().fields if i.name == "mission").block
    found: Block = next(item for item in block.fields if item.name == "fleet").block
    return found


@pytest.mark.parametrize("kind", TYPES)
def test_every_field_is_declared(kind: type[Any]) -> None:
    assert {item.name for item in fields_of(kind)} == {item.name for item in fields(kind)}
    numbers = {item.name: item.unit for item in fields_of(kind) if item.kind == "number" and "_" in item.name}
    assert [name for name, unit in numbers.items() if not unit] in ([], ["lower_bound_cost"])  # as kinds have costs


def test_the_new_mission_names_every_field_and_what_it_means() -> None:
    text = example_mission_text()
    known = {item.name for kind in (Mission, Zone, Obstacle, MotionLimits, DiscSensor) for item in fields_of(kind)}
    known |= {item.name for kind in (Fleet, Robot, SquareSensor, Area) for item in flat_fields_of(kind)}
    assert [name for name in known - {"planning", "shape", "motion"} if f"{name}:" not in text] == []
    words = " ".join(text.replace("#", " ").split())
    assert [item.name for item in flat_fields_of(Fleet) if item.name != "robots" and item.meaning not in words] == []


@pytest.mark.parametrize("form", ["mission", "plan"])
def test_files_have_every_field_of_fleets_and_robots(form: str) -> None:
    fleet = fleet_block(form)
    by_data_sheet = {"battery"} if form == "mission" else set()
    assert {item.name for item in fleet.fields} == {item.name for item in flat_fields_of(Fleet)} | by_data_sheet
    robots = next(item for item in fleet.fields if item.name == "robots").choices[-1].item
    assert robots is not None
    assert {item.name for item in robots.block.fields} == {item.name for item in flat_fields_of(Robot)} | by_data_sheet


def test_the_page_has_from_the_schema_what_numbers_of_fleets_are_called_and_mean() -> None:
    published = mission_schema()["properties"]["fleet"]["properties"]
    for item in flat_fields_of(Fleet):
        assert published[item.name].get("description", "") == (
            item.meaning if item.name != "robots" else published["robots"]["description"]
        )
        assert published[item.name].get("title", "") == item.title
    motion = {name for name, about in published.items() if about.get("group") == "motion"}
    assert motion == {item.name for item in fields_of(MotionLimits)}
