"""What is asked: area, obstacles, zones with revisit periods, and the fleet. SI units, local metres, frozen."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon

from rota.errors import MissionError
from rota.model.corner_faults import corner_faults as corner_faults
from rota.model.fleet import (
    COORDINATES,
    DiscSensor as DiscSensor,
    Fleet as Fleet,
    Place as Place,
    Robot as Robot,
    Sensor as Sensor,
    SquareSensor as SquareSensor,
    StartBox as StartBox,
    StartPoints as StartPoints,
    inner_reach_m as inner_reach_m,
)
from rota.model.importance import ALLOWED, MOST_IMPORTANCE, ImportanceMap as ImportanceMap, every_importance
from rota.model.limits import LARGEST_M, LONGEST_S
from rota.model.motion_limits import MOTION_FIELDS
from rota.model.planner_registry import DEFAULT, door_of
from rota.model.planner_settings import Bouncing as Bouncing, PlannerSettings as PlannerSettings, settings_of
from rota.model.refusals import (
    Where,
    every_change_of_presence,
    every_motion,
    fleet_blocks,
    inner,
    path_of,
    require,
    require_positive,
    require_text,
)
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

    lat: float
    lon: float

    def __post_init__(self) -> None:
        require(-90 <= self.lat <= 90, "lat", self.lat, "must lie in -90..90 degrees")
        require(-180 <= self.lon <= 180, "lon", self.lon, "must lie in -180..180 degrees")


@dataclass(frozen=True, kw_only=True)
class Obstacle:
    """A shape that blocks motion, sight, or both (a no-fly zone blocks motion only, a hedge sight only).

    ``asks`` "all": the ground under it is asked for as anywhere else; "nothing": it is not, whatever the area and the
    zones ask. Under what blocks sight nothing is asked for in any case.
    """

    shape: MultiPolygon
    blocks: Blocks = "both"
    asks: Asks = "all"

    def __post_init__(self) -> None:
        require(self.blocks in ("both", "motion", "sight"), "blocks", self.blocks, "both, motion or sight")
        require(self.asks in ("all", "nothing"), "asks", self.asks, "all or nothing")
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
    ``importance``: what a square metre of it is worth to a swarm, in place of ``Mission.importance``; None: as there.
    """

    name: str
    shape: MultiPolygon
    period_s: float | None
    demand: Demand = "every_point"
    importance: float | None = None

    def __post_init__(self) -> None:
        require_text("zone.name", self.name)
        ok = self.demand in ("every_point", "visit")
        require(ok, f"zone {self.name}: demand", self.demand, "every_point or visit")
        if self.period_s is not None:
            require_positive(f"zone {self.name}: period_s", self.period_s, LONGEST_S)
        if self.importance is not None:
            _require_importance(f"zone {self.name}: importance", self.importance)
        object.__setattr__(self, "shape", _as_multipolygon(f"zone {self.name}", self.shape))


def _require_importance(where: str, value: float) -> None:
    require(0 <= value <= MOST_IMPORTANCE, where, value, ALLOWED)


@dataclass(frozen=True, kw_only=True)
class MovingObstacle:
    """A disc that moves along timed points, straight between them; before the first and after the last it stands."""

    radius_m: float
    times_s: tuple[float, ...]
    positions_m: tuple[Place, ...]

    def __post_init__(self) -> None:
        require_positive("moving obstacle: radius_m", self.radius_m, LARGEST_M)
        object.__setattr__(self, "times_s", tuple(float(time) for time in self.times_s))
        object.__setattr__(self, "positions_m", tuple((float(x), float(y)) for x, y in self.positions_m))
        count = len(self.times_s)
        ok = count > 0 and all(a < b for a, b in itertools.pairwise(self.times_s))
        ok = ok and all(abs(time) <= LONGEST_S for time in self.times_s)
        require(ok, "moving obstacle: times_s", self.times_s, f"must rise, at most to {LONGEST_S:g}")
        ok = len(self.positions_m) == count and all(abs(value) <= LARGEST_M for at in self.positions_m for value in at)
        require(ok, "moving obstacle: positions_m", self.positions_m, f"one for each time; {COORDINATES}")

    def at(self, time_s: float) -> Place:
        """Where its centre is."""
        x, y = (float(np.interp(time_s, self.times_s, [at[axis] for at in self.positions_m])) for axis in (0, 1))
        return x, y


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
    a swarm outside zones with an importance of their own, a number or a map; None: 1.
    """

    name: str
    area: MultiPolygon
    fleet: Fleet
    obstacles: tuple[Obstacle, ...] = ()
    zones: tuple[Zone, ...] = ()
    period_s: float | None = None
    origin: GeoPoint | None = None
    unseeable: Unseeable = "exclude"
    holds_within_s: float | None = None
    planning: PlannerSettings = field(default_factory=_default_settings)
    moving_obstacles: tuple[MovingObstacle, ...] = ()
    importance: float | ImportanceMap | None = None

    def __post_init__(self) -> None:
        require_text("name", self.name)
        for name in ("obstacles", "zones", "moving_obstacles"):
            object.__setattr__(self, name, tuple(getattr(self, name)))  # missions are hashed, and lists are not
        object.__setattr__(self, "area", _as_multipolygon("area", self.area))
        if self.period_s is not None:
            require_positive("period_s", self.period_s, LONGEST_S)
        if self.holds_within_s is not None:
            ok = 0 <= self.holds_within_s <= LONGEST_S
            require(ok, "holds_within_s", self.holds_within_s, f"must be 0 to {LONGEST_S:g}, or None")
        require(self.unseeable in ("exclude", "refuse"), "unseeable", self.unseeable, "exclude or refuse")
        if self.importance is not None and not isinstance(self.importance, ImportanceMap):
            _require_importance("importance", self.importance)
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
        if faults:
            raise MissionError(*(f"{where}: {message}" for where, message in faults))
        data = _as_written(self)
        refused = list(all_refused(type(self.planning), data))
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


def all_refused(kind: type[PlannerSettings] | None, data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """What is wrong with a mission as written: what its planner refuses, and what it must say that it has a use for.

    kind: the type of the planner's settings; None: the planner is not known.
    """
    if kind is not None:
        yield from kind.refused(data)
        if data.get("moving_obstacles") and not kind.heeds_moving_obstacles:
            yield ("moving_obstacles",), f"the {kind.planner} planner has no use for moving_obstacles: remove them"
        if inner(data, "fleet", "entrances") is not None and not kind.heeds_entrances:
            yield ("fleet", "entrances"), f"the {kind.planner} planner has no use for entrances: remove them"
        if not kind.heeds_importance:
            yield from every_importance(data, f"the {kind.planner} planner has no use for importance: remove it")
        if not kind.heeds_motion:
            yield from every_motion(data, MOTION_FIELDS, f"the {kind.planner} planner does not heed it: remove it")
        if not kind.robots_come_and_go:
            yield from every_change_of_presence(data, "only robots of a swarm join or leave: remove it")
    if kind is None or inner(data, kind.planner, "altitudes_m") is None:
        for where, block in fleet_blocks(data):
            if inner(block, "sensor", "half_angle_deg") is not None:
                yield (*where, "sensor", "half_angle_deg"), "is for a swarm with altitudes_m only: remove it"


def _as_written(mission: Mission) -> dict[str, Any]:
    """The mission as a file would have it, without shapes: what planners look at to refuse it."""
    fleet, start = mission.fleet, mission.fleet.start
    return {
        "period_s": mission.period_s,
        "importance": mission.importance,
        "zones": [
            {"name": zone.name, "period_s": zone.period_s, "demand": zone.demand, "importance": zone.importance}
            for zone in mission.zones
        ],
        "moving_obstacles": list(mission.moving_obstacles),
        "fleet": {
            "robots": "fewest" if fleet.robots is None else [_robot_as_written(robot, fleet) for robot in fleet.robots],
            "sensor": _sensor_as_written(fleet.sensor),
            "turn_rate_rad_s": fleet.turn_rate_rad_s,
            "turn_radius_m": fleet.turn_radius_m,
            **fleet.motion.told,
            "start": {"box": start.low_m} if isinstance(start, StartBox) else start and {"points": start.points_m},
            "entrances": fleet.entrances,
        },
        mission.planning.planner: vars(mission.planning),
    }


def _robot_as_written(robot: Robot, fleet: Fleet) -> dict[str, Any]:
    """One robot, with what differs from the fleet."""
    told: dict[str, Any] = {"start": robot.start, "joins_s": robot.joins_s, "leaves_s": robot.leaves_s}
    if robot.sensor != fleet.sensor:
        told["sensor"] = _sensor_as_written(robot.sensor)
    if robot.turn_rate_rad_s != fleet.turn_rate_rad_s:
        told["turn_rate_rad_s"] = robot.turn_rate_rad_s
    if robot.turn_radius_m != fleet.turn_radius_m:
        told["turn_radius_m"] = robot.turn_radius_m
    if robot.motion != fleet.motion:
        told |= robot.motion.told
    return told


def _sensor_as_written(sensor: Sensor) -> dict[str, Any]:
    if isinstance(sensor, DiscSensor):
        return {"shape": "disc", "radius_m": sensor.radius_m, "half_angle_deg": sensor.half_angle_deg}
    return {"shape": "square", "side_m": sensor.side_m}
