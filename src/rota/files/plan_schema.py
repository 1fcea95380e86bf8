"""The keys of a plan file and what they hold: the fields of the model, with shapes as rings, and what files add."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any, Literal

from shapely import MultiPolygon, Polygon

from rota.errors import PlanError
from rota.files.blocks import Block, block_of, field_in, fields_in, make
from rota.files.json_schema import file_schema
from rota.files.mission_schema import row_faults, start_faults
from rota.model.fields import Field, field_of, fields_of
from rota.model.fleet import Fleet, Kind, Place, Robot, Start, StartBox, StartPoints
from rota.model.importance import ImportanceMap
from rota.model.mission import Charger, GeoPoint, Lane, Mission, MovingObstacle, Obstacle, Zone
from rota.model.plan import Driven, Plan, RunEnd, Seam
from rota.model.planner_registry import PLANNERS, planner_names
from rota.model.refusals import Where, inner
from rota.model.trajectory import PLACES, Charge, Trajectory, Waypoints
from rota.planning.planner import loadable_planners, planner_named

PLAN_VERSION = 1
Rings = tuple[tuple[Place, ...], ...]


@dataclass(frozen=True, kw_only=True)
class PlanFile:
    """A Rota plan: a mission and one timed trajectory per robot. It stands alone."""

    rota_plan: Literal[1] = field_of()
    mission_sha256: str | None = field_of(
        None,
        "of the mission as JSON with sorted keys, no white space, all numbers as floats; absent: open",
        newer=True,
        says={"pattern": "^[0-9a-f]{64}$"},
    )
    meets_demand: bool | None = field_of(
        None, "false: written with --best although the check does not pass; else absent", newer=True
    )
    mission_changes: tuple[str, ...] | None = field_of(
        None,
        "what has changed in its mission since, as the page told; absent: not told",
        count=((0, None),),
        newer=True,
    )


@dataclass(frozen=True, kw_only=True)
class _Forms:
    """Of what files have in another form than the model."""

    shape: tuple[Rings, ...] = field_of(
        meaning="polygons: an outer ring, then holes, of [x, y] in metres; the first point is not repeated",
        count=((1, None), (1, None), (3, None)),
        **PLACES,
    )


# ---------------------------------------------------------------- what is made of them


def _shape(polygons: Iterable[Iterable[Iterable[Place]]]) -> MultiPolygon:
    """The shape of rings. Raises PlanError where they cross."""
    # the first point is repeated here and not by shapely, which leaves rings alone that look closed already
    closed = [[[*ring, ring[0]] for ring in map(list, polygon)] for polygon in polygons]
    shape = MultiPolygon([Polygon(rings[0], rings[1:]) for rings in closed])
    if not shape.is_valid:
        raise PlanError("an invalid shape; rings may not cross themselves or each other")
    return shape


def _start(box: Any = None, points: Any = None) -> StartBox | StartPoints:
    """Where the fleet begins: in a box, or at points."""
    return StartPoints(points_m=points) if box is None else StartBox(low_m=box[0], high_m=box[1])


def _fleet(robots: Any, **values: Any) -> Fleet:
    """The fleet; "fewest" is one of none that are named."""
    return make(Fleet, robots=None if robots == "fewest" else robots, **values)


def _mission(planner: str, **values: Any) -> Mission:
    """The mission with the settings of its planner."""
    given = {name: values.pop(name, None) for name in planner_names()}
    if [name for name, settings in given.items() if settings is not None] != [planner]:
        raise PlanError(f"planner is {planner}; its settings and no others are needed")
    return Mission(**values, planning=planner_named(planner).settings.from_file(given[planner] or {}, None))


def _trajectory_faults(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """Positions of two kinds, and lists that do not go together."""
    counted = {name: len(data[name]) for name in data if isinstance(data[name], list)}
    if "times_s" not in counted:
        return
    positions = data["positions_m"] if "positions_m" in counted else []
    if {len(place) for place in positions if isinstance(place, list)} == {2, 3}:
        yield ("positions_m",), "[x, y] and [x, y, z] mixed; all must have as many numbers"
    n = counted["times_s"]
    for name, needed, one in (
        ("positions_m", n, "time in times_s"),
        ("headings_rad", n, "time in times_s"),
        ("accelerations_m_s2", n - 1, "leg"),
    ):
        if counted.get(name, needed) != needed:
            yield (name,), f"{counted[name]} entries; {needed} are needed, one per {one}"


# ---------------------------------------------------------------- the blocks


@cache
def _known_blocks() -> dict[Any, Block | Field]:
    """The blocks and fields of the model's types."""
    known: dict[Any, Block | Field] = {
        MultiPolygon: replace(field_in(fields_of(_Forms)[0], "plan"), reads=_shape),
        ImportanceMap: block_of(ImportanceMap, "plan", makes=ImportanceMap, rules=row_faults),
        Start: block_of(Start, "plan", makes=_start, rules=start_faults),
        Trajectory: block_of(
            Trajectory, "plan", {kind: block_of(kind, "plan", makes=kind) for kind in (Waypoints, Charge)},
            makes=partial(make, Trajectory), rules=_trajectory_faults,
        ),
    }  # fmt: skip
    for kind, makes in (
        (GeoPoint, GeoPoint), (Lane, Lane), (Charger, Charger), (Charge, Charge),
        (MovingObstacle, MovingObstacle), (RunEnd, RunEnd),
        (Obstacle, Obstacle), (Zone, Zone), (Robot, partial(make, Robot)),
        (Kind, partial(make, Kind)), (Fleet, _fleet),
        (Driven, partial(make, Driven)), (Seam, Seam),
    ):  # fmt: skip
        known[kind] = block_of(kind, "plan", known, makes=makes)
    return known


def plan_block(document: object = None) -> Block:
    """The block of a plan file, with settings for each planner of this package and for the one that it names.

    document: a file as it was read; None: all planners have theirs.
    """
    named = (inner(document, "mission", "planner"),) if document is not None else loadable_planners()
    known = planner_names()
    return _plan_block(tuple(name for name in known if name in PLANNERS or name in named), known)


@cache
def _plan_block(names: tuple[str, ...], known: tuple[str, ...]) -> Block:
    """The same, with a block for planners of these names, of all that are known."""
    fields = [item for item in fields_in(Mission, "plan", _known_blocks()) if item.name != "planning"]
    fields.append(Field(name="planner", kind="option", options=known, needed=True))
    fields += [
        Field(
            name=name, kind="block", block=block_of(planner_named(name).settings, "plan"), optional=True, default=None
        )
        for name in names
    ]
    mission = Block(name="mission", meaning="The mission, with all its defaults.", fields=tuple(fields), makes=_mission)
    own = {item.name: item for item in fields_in(PlanFile, "plan")}
    plan = fields_in(Plan, "plan", {**_known_blocks(), Mission: mission})
    return replace(block_of(PlanFile, "plan"), fields=(*own.values(), *plan))


def plan_schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of the plan file."""
    return file_schema(plan_block(), "Rota plan, version 1")
