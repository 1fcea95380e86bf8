"""What is asked: area, obstacles, zones with revisit periods, and the fleet. SI units, local metres, frozen."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon

from rota.errors import MissionError
from rota.model.batteries import Charger as Charger, charger_faults as charger_faults
from rota.model.battery_limits import BATTERY_KEYS
from rota.model.corner_faults import corner_faults as corner_faults
from rota.model.field_values import check_fields, in_file_form
from rota.model.fields import field_of, fields_of, flat_fields_of
from rota.model.fleet import (
    COORDINATES,
    Abilities,
    DiscSensor as DiscSensor,
    Fleet as Fleet,
    Kind as Kind,
    Place as Place,
    Robot as Robot,
    Sensor as Sensor,
    SquareSensor as SquareSensor,
    StartBox as StartBox,
    StartPoints as StartPoints,
    inner_reach_m as inner_reach_m,
)
from rota.model.importance import IMPORTANCE, ImportanceMap as ImportanceMap
from rota.model.lanes import Lane as Lane, lane_faults as lane_faults
from rota.model.limits import DURATION, LARGEST_M, LONGEST_S, MOMENT
from rota.model.motion_limits import MOTION_FIELDS
from rota.model.moving import MovingObstacle as MovingObstacle
from rota.model.planner_registry import DEFAULT, door_of
from rota.model.planner_settings import Bouncing as Bouncing, PlannerSettings as PlannerSettings, settings_of
from rota.model.refusals import (
    Where,
    every_change_of_presence,
    every_choice_of_robots,
    every_motion,
    every_stated,
    fleet_blocks,
    inner,
    path_of,
    require,
    require_text,
)
from rota.model.sensor_faults import sensor_faults as sensor_faults
from rota.model.start_faults import TOUCH_M as TOUCH_M, start_faults as start_faults

Blocks = Literal["both", "motion", "sight"]
Asks = Literal["all", "nothing"]
Demand = Literal["every_point", "visit"]
Unseeable = Literal["exclude", "refuse"]

AREA = "area"  # the name of the ground outside zones, wherever zones are told
NO_PERIOD = "is missing; give seconds for the area, or a zone with a period_s"
NOTHING_MATTERS = "0 is not allowed; give the ground, or a zone, an importance above 0"
AREA_IS_TAKEN = "it stands for the ground outside zones; give the zone another name"


def _as_multipolygon(where: str, shape: Polygon | MultiPolygon) -> MultiPolygon:
    """A valid shape as a multipolygon. Raises MissionError for others, which says ``where`` it was given."""
    if isinstance(shape, Polygon):
        shape = MultiPolygon([shape] if not shape.is_empty else [])
    require(isinstance(shape, MultiPolygon), where, type(shape).__name__, "must be a polygon or a multipolygon")
    require(not shape.is_empty, where, "an empty shape", "must have an area")
    bounds = np.array(shape.bounds)
    far = bounds[~(np.abs(bounds) <= LARGEST_M)]
    require(not len(far), where, far.tolist(), COORDINATES)
    require(shape.is_valid, where, "an invalid shape", "rings may not cross themselves or each other")
    # a shape on a grid would round all that is made from it to that grid
    return shape if shapely.get_precision(shape) == 0 else shapely.set_precision(shape, 0.0)


@dataclass(frozen=True, kw_only=True)
class GeoPoint:
    """A place on the globe, WGS84 degrees; the origin of a mission's local metres (x east, y north)."""

    lat: float = field_of(meaning="degrees north", least=-90, most=90)
    lon: float = field_of(meaning="degrees east", least=-180, most=180)

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, kw_only=True)
class Obstacle:
    """A shape that blocks motion, sight, or both (a no-fly zone blocks motion only, a hedge sight only).

    ``asks`` "all": the ground under it is asked for as anywhere else; "nothing": it is not, whatever the area and the
    zones ask. Under what blocks sight nothing is asked for in any case.
    """

    shape: MultiPolygon = field_of()
    blocks: Blocks = field_of("both", "motion (a no-fly zone, which one can look into), sight (a hedge) or both")
    asks: Asks = field_of(
        "all",
        "all: the ground under blocks: motion is asked for as anywhere else; nothing: it is not",
        newer=True,
        spared=True,
    )

    def __post_init__(self) -> None:
        check_fields(self)
        object.__setattr__(self, "shape", _as_multipolygon("obstacle", self.shape))

    @property
    def blocks_motion(self) -> bool:
        """Whether robots must stay out."""
        return self.blocks != "sight"

    @property
    def blocks_sight(self) -> bool:
        """Whether nothing is seen through or in it."""
        return self.blocks != "motion"

    @property
    def hides_demand(self) -> bool:
        """Whether nothing is asked for of the ground under it."""
        return self.blocks_sight or self.asks == "nothing"


@dataclass(frozen=True, kw_only=True)
class Zone:
    """Part of the area with its own period; None asks nothing there.

    ``demand`` "every_point": each point must be seen in every window of ``period_s``; "visit": a robot must be inside.
    ``importance``: what a square metre of it is worth to a swarm, and which zones come first in a patrol whose robots
    are too few when it is replanned, in place of ``Mission.importance``; None: as there. ``sensors``: only robots whose
    sensor has one of these names count for the demand; none named: all do.
    """

    name: str = field_of(count=((1, None),))
    period_s: float | None = field_of(
        meaning="seconds; null: nothing is asked there", above=0, most=LONGEST_S, written=DURATION
    )
    demand: Demand = field_of("every_point", "every_point of it is to be seen; visit: a robot in it is enough")
    shape: MultiPolygon = field_of()
    importance: float | None = field_of(
        None,
        "what it is worth to a swarm, or to a patrol that is replanned with too few robots; null: as outside zones",
        **IMPORTANCE,
        newer=True,
        spared=True,
    )
    sensors: tuple[str, ...] = field_of(
        (), "names of the sensors that count for its demand; absent: all do",
        count=((0, None), (1, None)), newer=True, spared=True,
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_fields(self, f"zone {self.name}: ")
        require_text("zone.name", self.name)
        object.__setattr__(self, "shape", _as_multipolygon(f"zone {self.name}", self.shape))


def _default_settings() -> PlannerSettings:
    settings: PlannerSettings = door_of(DEFAULT).settings()
    return settings


@dataclass(frozen=True, kw_only=True, repr=False)
class Mission:
    """All that a planner needs to know. Shapes in local metres; ``origin`` places them on the globe, if known.

    ``planning`` chooses the planner by its type, which also says what of a mission it refuses.

    ``period_s`` is the period of the area outside zones (None: nothing is asked there). Zones have unique names other
    than ``AREA``, by which reports call that ground. ``holds_within_s``: all robots are in their loops, from when on
    periods hold, within so many seconds (None: at any time). ``importance``: what a square metre of ground is worth to
    a swarm outside zones with an importance of their own, a number or a map, and to a patrol that is replanned with too
    few robots, a number; None: 1. ``lanes``: where there are some,
    robots keep to them. ``chargers``: where robots charge whose batteries run low.
    """

    name: str = field_of(count=((1, None),))
    area: MultiPolygon = field_of(meaning="where robots may be and must look")
    obstacles: tuple[Obstacle, ...] = field_of((), "neither entered nor seen through", count=((0, None),))
    zones: tuple[Zone, ...] = field_of(
        (), "parts with a period of their own; where zones overlap the smallest period rules", count=((0, None),)
    )
    importance: float | ImportanceMap | None = field_of(
        None,
        "what a square metre outside zones with an importance is worth, or for a swarm a map; null: 1",
        **IMPORTANCE,
        needs="a number from 0 on or {map: FILE, black: ..., white: ...} is needed",
        newer=True,
        spared=True,
    )
    period_s: float | None = field_of(
        None,
        "for the area outside zones; null: nothing is asked there",
        above=0,
        most=LONGEST_S,
        written=DURATION,
    )
    unseeable: Unseeable = field_of(
        "exclude", "what nobody can see from anywhere a robot can stand: exclude it and say so, or refuse the mission"
    )
    holds_within_s: float | None = field_of(
        None,
        "robots are in their loops, from when on periods hold, within so many seconds; null: any time",
        least=0,
        most=LONGEST_S,
        written=MOMENT,
        newer=True,
        spared=True,
    )
    origin: GeoPoint | None = field_of(None, "where on the globe the local (0, 0) lies, for exports")
    fleet: Fleet = field_of()
    moving_obstacles: tuple[MovingObstacle, ...] = field_of(
        (), "of a swarm: discs that move along timed points", count=((0, None),), newer=True
    )
    lanes: tuple[Lane, ...] = field_of(
        (),
        "of patrol: lines that robots keep to, from end to end; absent: they drive anywhere",
        count=((0, None),),
        newer=True,
        spared=True,
    )
    chargers: tuple[Charger, ...] = field_of(
        (),
        "of patrol and swarm: where robots with an endurance_s charge",
        count=((0, None),),
        newer=True,
        spared=True,
    )
    planning: PlannerSettings = field_of(_default_settings)

    def __post_init__(self) -> None:
        check_fields(self)
        require_text("name", self.name)
        object.__setattr__(self, "area", _as_multipolygon("area", self.area))
        if self.importance == 0 and not any(zone.importance for zone in self.zones):
            raise MissionError(f"importance: {NOTHING_MATTERS}")
        counted = Counter(zone.name for zone in self.zones)
        for zone in self.zones:
            require(zone.name != AREA, "zone.name", zone.name, AREA_IS_TAKEN)
            require(counted[zone.name] == 1, "zones", zone.name, "names must be unique")
            outside = not zone.shape.intersects(self.area) or zone.shape.intersection(self.area).area == 0
            require(not outside, f"zone {zone.name}", "a shape outside the area", "must overlap the area")
        blocking = [obstacle.shape for obstacle in self.obstacles if obstacle.blocks_motion]
        faults = start_faults(self.area, blocking, self.fleet) + corner_faults(self.area, blocking, self.fleet)
        faults += lane_faults(self.area, blocking, self.fleet, self.lanes)
        faults += charger_faults(self.area, blocking, self.fleet, self.chargers)
        faults += sensor_faults(self.zones, self.fleet)
        if faults:
            raise MissionError(*(f"{where}: {message}" for where, message in faults))
        data = _as_file_has_it(self)
        refused = list(all_refusals(type(self.planning), data))
        if self.planning.asks_periods and not (self.period_s or any(zone.period_s for zone in self.zones)):
            refused.append((("period_s",), NO_PERIOD))
        if refused:
            raise MissionError(*(f"{path_of(place)}: {message}" for place, message in refused))

    @property
    def bouncing(self) -> Bouncing:
        """The rules by which robots bounce; TypeError for a mission whose robots do not."""
        if (rules := self.planning.bouncing) is None:
            raise TypeError(f"mission {self.name} is planned by {self.planning.planner}: its robots do not bounce")
        return rules

    @property
    def grid_corner_m(self) -> Place:
        """The lower left corner of a bouncing robot's first cell."""
        return self.bouncing.first_corner_m(self.area.bounds)

    @property
    def has_starts(self) -> bool:
        """Whether any robot must begin at a given place."""
        return self.fleet.start is not None or any(robot.start is not None for robot in self.fleet.robots or ())

    def __repr__(self) -> str:
        held = (("zone", self.zones), ("obstacle", self.obstacles), ("robot", self.fleet.robots or ()))
        parts = [f"{len(items)} {noun}{'' if len(items) == 1 else 's'}" for noun, items in held if items]
        if self.fleet.robots is None:
            parts.append("as few robots as possible")
        return f"<Mission {self.name!r} for {self.planning.planner}: {self.area.area:,.6g} m2, {', '.join(parts)}>"

    def _repr_html_(self) -> str:
        from rota.model.html import mission_html

        return mission_html(self)

    def with_effort(self, effort: str) -> Mission:
        """The same mission, planned with another effort; MissionError for a planner that has none."""
        self._require_setting("effort", effort)
        return replace(self, planning=replace(self.planning, **{"effort": effort}))

    def with_method(self, method: str) -> Mission:
        """The same mission, planned by another method of its planner; MissionError for a planner that has none."""
        self._require_setting("method", method)
        return replace(self, planning=self.planning.with_method(method))

    def _require_setting(self, name: str, value: str) -> None:
        known = any(item.name == name for item in settings_of(type(self.planning)))
        require(known, name, value, f"the {self.planning.planner} planner has no {name}: leave it out")


def all_refusals(kind: type[PlannerSettings] | None, data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """What is wrong with a mission as written: what its planner refuses, and what it must say that it has a use for.

    kind: the type of the planner's settings; None: the planner is not known.
    """
    if kind is not None:
        yield from kind.refusals(data)
        useless = f"the {kind.planner} planner has no use for "
        for key, heeded in (("moving_obstacles", kind.heeds_moving_obstacles), ("lanes", kind.heeds_lanes)):
            if data.get(key) and not heeded:
                yield (key,), f"{useless}{key}: remove them"
        if inner(data, "fleet", "entrances") is not None and not kind.heeds_entrances:
            yield ("fleet", "entrances"), f"{useless}entrances: remove them"
        if not kind.heeds_importance:
            yield from every_stated(data, "importance", f"{useless}importance: remove it")
        if not kind.heeds_motion:
            yield from every_motion(data, MOTION_FIELDS, f"the {kind.planner} planner does not heed it: remove it")
        if not kind.heeds_batteries:
            yield from every_motion(data, BATTERY_KEYS, f"the {kind.planner} planner plans no charging: remove it")
            if data.get("chargers"):
                yield ("chargers",), f"{useless}chargers: remove them"
        if not kind.heeds_kinds:
            yield from every_choice_of_robots(data, f"the {kind.planner} planner has no use for it: remove it")
        if not kind.robots_come_and_go:
            yield from every_change_of_presence(data, "only robots of a swarm join or leave: remove it")
    if kind is None or inner(data, kind.planner, "altitudes_m") is None:
        for where, block in fleet_blocks(data):
            if inner(block, "sensor", "half_angle_deg") is not None:
                yield (*where, "sensor", "half_angle_deg"), "is for a swarm with altitudes_m only: remove it"


def _as_file_has_it(mission: Mission) -> dict[str, Any]:
    """The mission as a file would have it, without shapes: what planners look at to refuse it."""
    fleet = in_file_form(mission.fleet)
    like = {name: fleet.get(name) for name in (item.name for item in flat_fields_of(Abilities))}
    robots = [
        {name: value for name, value in in_file_form(robot).items() if name not in like or value != like[name]}
        for robot in mission.fleet.robots or ()
    ]
    return {
        **{item.name: getattr(mission, item.name) for item in fields_of(Mission)},
        "zones": [in_file_form(zone) for zone in mission.zones],
        "fleet": {**fleet, "robots": robots or "fewest"},
        mission.planning.planner: vars(mission.planning),
    }
