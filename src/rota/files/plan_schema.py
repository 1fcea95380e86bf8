"""The shape of a plan file: what each field may hold. Read by ``plan_file`` and published as JSON Schema."""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, create_model, model_validator

from rota.files.settings_schema import settings_field
from rota.model.importance import MOST_IMPORTANCE
from rota.model.limits import LARGEST_M, LONGEST_S
from rota.model.mission import Asks, Blocks, Demand, Unseeable
from rota.model.plan import EndReason
from rota.model.planner_registry import PLANNERS, planner_names
from rota.model.refusals import inner
from rota.planning.planner import loadable_planners, planner_named

PLAN_VERSION = 1

Coordinate = Annotated[float, Field(ge=-LARGEST_M, le=LARGEST_M)]
Point = Annotated[list[Coordinate], Field(min_length=2, max_length=2)]
Position = Annotated[list[Coordinate], Field(min_length=2, max_length=3)]
Ring = Annotated[list[Point], Field(min_length=3, description="[x, y] in metres; the first point is not repeated")]
Polygons = Annotated[
    list[Annotated[list[Ring], Field(min_length=1, description="outer ring, then holes")]], Field(min_length=1)
]
Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Length = Annotated[float, Field(gt=0, le=LARGEST_M)]
Radius = Annotated[float, Field(ge=0, le=LARGEST_M)]
Time = Annotated[float, Field(ge=0, le=LONGEST_S)]
Period = Annotated[float, Field(gt=0, le=LONGEST_S)]
Importance = Annotated[float, Field(ge=0, le=MOST_IMPORTANCE)]
Name = Annotated[str, Field(min_length=1)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, defer_build=True)


class DiscSensorFields(_Strict):
    """A disc of this radius round the robot, or one that grows with height, height x tan(half angle), up to it."""

    shape: Literal["disc"]
    radius_m: Length
    half_angle_deg: Annotated[float, Field(gt=0, lt=90)] | None = None


class SquareSensorFields(_Strict):
    """A square of this side round the robot, along the axes."""

    shape: Literal["square"]
    side_m: Length


SensorFields = Annotated[DiscSensorFields | SquareSensorFields, Field(discriminator="shape")]


class MotionFields(_Strict):
    """Limits of motion of a robot, or of all that have no others; absent: none."""

    vehicle: Annotated[str, Field(min_length=1, description="whose presets these are")] | None = None
    acceleration_m_s2: Positive | None = None
    corner_acceleration_m_s2: Positive | None = None
    jerk_m_s3: Positive | None = None
    corner_m: Radius = 0.0
    climb_m_s: Positive | None = None
    descend_m_s: Positive | None = None
    top_airspeed_m_s: Positive | None = None
    wind_m_s: NotNegative = 0.0


class RobotFields(MotionFields):
    """One robot of the fleet."""

    name: Name
    speed_m_s: Positive
    sensor: SensorFields
    body_radius_m: Radius
    turn_rate_rad_s: Positive | None
    turn_radius_m: Radius = 0.0
    start: Point | None
    joins_s: Time = 0.0
    leaves_s: Period | None = None


RobotList = Annotated[list[RobotFields], Field(min_length=1)]


def _robots_tag(value: object) -> str:
    return "fewest" if isinstance(value, str) else "list"


class StartFields(_Strict):
    """Where robots start that have no start of their own: in a box, or at points."""

    box: Annotated[list[Point], Field(min_length=2, max_length=2, description="two opposite corners")] | None = None
    points: Annotated[list[Point], Field(min_length=1)] | None = None

    @model_validator(mode="after")
    def _one_of_them(self) -> Self:
        if (self.box is None) == (self.points is None):
            raise ValueError("exactly one of box and points is needed")
        return self


class FleetFields(MotionFields):
    """The robots at hand; ``robots`` "fewest" means as few equal ones as possible."""

    # the tag makes errors speak of the one form that was meant
    robots: Annotated[
        Annotated[Literal["fewest"], Tag("fewest")] | Annotated[RobotList, Tag("list")], Discriminator(_robots_tag)
    ]
    speed_m_s: Positive
    sensor: SensorFields
    body_radius_m: Radius
    turn_rate_rad_s: Positive | None
    turn_radius_m: Radius = 0.0
    altitude_m: Length
    start: StartFields | None = None
    entrances: Annotated[list[Point], Field(min_length=1)] | None = None
    rally_points: list[Point] = []


class ObstacleFields(_Strict):
    """A shape that blocks motion, sight, or both."""

    shape: Polygons
    blocks: Blocks
    asks: Asks = "all"


class ZoneFields(_Strict):
    """Part of the area with its own period."""

    name: Name
    period_s: Period | None
    demand: Demand
    shape: Polygons
    importance: Importance | None = None


class ImportanceMapFields(_Strict):
    """What a square metre is worth at the places of a grid, row by row from the south; straight between places."""

    low_m: Annotated[Point, Field(description="x, y of the first place of the first row")]
    step_m: Annotated[list[Length], Field(min_length=2, max_length=2, description="x, y between places")]
    values: Annotated[list[Annotated[list[Importance], Field(min_length=1)]], Field(min_length=1)]


def _importance_tag(value: object) -> str:
    return "map" if isinstance(value, dict | ImportanceMapFields) else "number"


GroundImportance = Annotated[
    Annotated[ImportanceMapFields, Tag("map")] | Annotated[Importance, Tag("number")], Discriminator(_importance_tag)
]


class OriginFields(_Strict):
    """Where the local metres (x east, y north) have their zero, WGS84 degrees."""

    lat: Annotated[float, Field(ge=-90, le=90)]
    lon: Annotated[float, Field(ge=-180, le=180)]


class MovingObstacleFields(_Strict):
    """A disc that moves along timed points."""

    radius_m: Length
    times_s: Annotated[list[Annotated[float, Field(ge=-LONGEST_S, le=LONGEST_S)]], Field(min_length=1)]
    positions_m: Annotated[list[Point], Field(min_length=1)]


class MissionFields(_Strict):
    """The mission, all defaults filled in and all shapes resolved to rings in local metres."""

    name: Name
    area: Polygons
    obstacles: list[ObstacleFields]
    zones: list[ZoneFields]
    importance: GroundImportance | None = None
    period_s: Period | None
    unseeable: Unseeable
    holds_within_s: Time | None = None
    origin: OriginFields | None
    fleet: FleetFields
    moving_obstacles: list[MovingObstacleFields] = []
    planner: str

    @property
    def settings(self) -> dict[str, Any]:
        """The values of the planner's settings."""
        return getattr(self, self.planner) or {}

    @model_validator(mode="after")
    def _settings_of_its_planner(self) -> Self:
        given = [name for name in planner_names() if getattr(self, name, None) is not None]
        if given != [self.planner]:
            raise ValueError(f"planner is {self.planner}; its settings and no others are needed")
        return self


class WaypointsFields(_Strict):
    """What an autopilot that cuts corners by itself is told of a loop, instead of its legs."""

    places_m: Annotated[list[Point], Field(min_length=2, description="the robot begins at the first")]
    times_s: Annotated[
        list[Time], Field(min_length=3, description="left at the first, nearest to the others, then to it")
    ]
    speed_m_s: Annotated[Positive, Field(description="told for every leg")]


class TrajectoryFields(_Strict):
    """One robot's timed points: straight legs, each at a constant acceleration, repeated from ``loop_start_s`` on."""

    name: Name
    loop_start_s: Time
    times_s: Annotated[list[Time], Field(min_length=1)]
    positions_m: Annotated[list[Position], Field(min_length=1)]
    headings_rad: list[float] | None
    waypoints: WaypointsFields | None = None
    accelerations_m_s2: Annotated[
        list[float] | None, Field(description="along each leg; absent: all legs are driven at constant speeds")
    ] = None


class RunEndFields(_Strict):
    """How the run of a swarm ended: at rest, with blocked robots, or cut off by swarm.most_steps or when stopped."""

    at_rest: bool
    steps: Annotated[int, Field(ge=0)]
    reason: EndReason
    blocked: Annotated[list[Name], Field(description="robots that want to move on and cannot")] = []


class PlanFields(_Strict):
    """A Rota plan: a mission and one timed trajectory per robot. It stands alone."""

    rota_plan: Literal[1]
    seed: int
    mission_sha256: Annotated[
        str | None,
        Field(
            pattern="^[0-9a-f]{64}$",
            description="of the mission as JSON with sorted keys, no white space, all numbers as floats; absent: open",
        ),
    ] = None
    lower_bound_robots: Annotated[int, Field(ge=0)] | None
    lower_bound_reason: Annotated[
        str | None, Field(min_length=1, description="why no plan has fewer robots; absent: not told")
    ] = None
    meets_demand: Annotated[
        bool | None, Field(description="false: written with --best although the check does not pass; else absent")
    ] = None
    mission_changes: Annotated[
        list[str] | None,
        Field(description="what has changed in its mission since, as the page told; absent: not told"),
    ] = None
    run_end: Annotated[
        RunEndFields | None, Field(description="of a swarm: whether its robots were at rest; absent: not told")
    ] = None
    mission: MissionFields
    robots: list[TrajectoryFields]


def plan_fields_type(document: object = None) -> type[PlanFields]:
    """The model of a plan file, with settings for each planner of this package and for the one that it names.

    document: a file as it was read; None: all planners have theirs.
    """
    named = (inner(document, "mission", "planner"),) if document is not None else loadable_planners()
    return _plan_fields_type(tuple(name for name in planner_names() if name in PLANNERS or name in named))


@cache
def _plan_fields_type(names: tuple[str, ...]) -> type[PlanFields]:
    blocks = {name: settings_field(planner_named(name).settings, in_mission_file=False) for name in names}
    fields: dict[str, Any] = {name: (block, None) for name, block in blocks.items()}
    chosen: Any = Literal[planner_names()]
    mission = create_model("MissionFields", __base__=MissionFields, planner=(chosen, ...), **fields)
    return create_model("PlanFields", __base__=PlanFields, mission=(mission, ...))


def plan_schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of the plan file."""
    schema = plan_fields_type().model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "Rota plan, version 1"}
