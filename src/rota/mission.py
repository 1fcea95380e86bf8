"""What is asked: area, obstacles, zones with revisit periods, and the fleet. SI units, local metres, frozen."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon

from rota.errors import MissionError
from rota.fleet import (
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
from rota.limits import LARGEST_M, LONGEST_S
from rota.planner_settings import (
    HEADINGS as HEADINGS,
    METHODS as METHODS,
    BounceCells as BounceCells,
    BounceMethod as BounceMethod,
    BounceSettings as BounceSettings,
    BounceTask as BounceTask,
    Contact as Contact,
    ContactFree as ContactFree,
    Controller as Controller,
    Corners as Corners,
    DeploymentMethod as DeploymentMethod,
    Device as Device,
    Effort as Effort,
    FramePartition as FramePartition,
    FrameTour as FrameTour,
    Method as Method,
    PatrolSettings as PatrolSettings,
    Purpose as Purpose,
    SegmentRoutes as SegmentRoutes,
    SetBoundary as SetBoundary,
    Sun2019 as Sun2019,
    SwarmSettings as SwarmSettings,
    VelocityChoice as VelocityChoice,
    require,
    require_positive,
    require_text,
)
from rota.start_faults import TOUCH_M as TOUCH_M, start_faults as start_faults

Blocks = Literal["both", "motion", "sight"]
Demand = Literal["every_point", "visit"]
Unseeable = Literal["exclude", "refuse"]

AREA = "area"  # the name of the ground outside zones, wherever zones are told
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
    """A shape that blocks motion, sight, or both (a no-fly zone blocks motion only, a hedge sight only)."""

    shape: MultiPolygon
    blocks: Blocks = "both"

    def __post_init__(self) -> None:
        require(self.blocks in ("both", "motion", "sight"), "blocks", self.blocks, "both, motion or sight")
        object.__setattr__(self, "shape", _as_multipolygon("obstacle", self.shape))

    @property
    def blocks_motion(self) -> bool:
        """Whether robots must stay out."""
        return self.blocks != "sight"

    @property
    def blocks_sight(self) -> bool:
        """Whether nothing is seen through or in it."""
        return self.blocks != "motion"


@dataclass(frozen=True, kw_only=True)
class Zone:
    """Part of the area with its own period; None asks nothing there.

    ``demand`` "every_point": each point must be seen in every window of ``period_s``; "visit": a robot must be inside.
    """

    name: str
    shape: MultiPolygon
    period_s: float | None
    demand: Demand = "every_point"

    def __post_init__(self) -> None:
        require_text("zone.name", self.name)
        ok = self.demand in ("every_point", "visit")
        require(ok, f"zone {self.name}: demand", self.demand, "every_point or visit")
        if self.period_s is not None:
            require_positive(f"zone {self.name}: period_s", self.period_s, LONGEST_S)
        object.__setattr__(self, "shape", _as_multipolygon(f"zone {self.name}", self.shape))


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


@dataclass(frozen=True, kw_only=True)
class Mission:
    """All that a planner needs to know. Shapes in local metres; ``origin`` places them on the globe, if known.

    ``planning`` chooses the planner by its type. A swarm's fleet is a list of robots, and it may leave out all
    periods: nothing is asked then but to spread. Only it heeds moving obstacles.

    ``period_s`` is the period of the area outside zones (None: nothing is asked there). Zones have unique names other
    than ``AREA``, by which reports call that ground.
    """

    name: str
    area: MultiPolygon
    fleet: Fleet
    obstacles: tuple[Obstacle, ...] = ()
    zones: tuple[Zone, ...] = ()
    period_s: float | None = None
    origin: GeoPoint | None = None
    unseeable: Unseeable = "exclude"
    planning: PatrolSettings | SwarmSettings | BounceSettings = field(default_factory=PatrolSettings)
    moving_obstacles: tuple[MovingObstacle, ...] = ()

    def __post_init__(self) -> None:
        require_text("name", self.name)
        object.__setattr__(self, "area", _as_multipolygon("area", self.area))
        if self.period_s is not None:
            require_positive("period_s", self.period_s, LONGEST_S)
        require(self.unseeable in ("exclude", "refuse"), "unseeable", self.unseeable, "exclude or refuse")
        counted = Counter(zone.name for zone in self.zones)
        for zone in self.zones:
            require(zone.name != AREA, "zone.name", zone.name, AREA_IS_TAKEN)
            require(counted[zone.name] == 1, "zones", zone.name, "names must be unique")
            outside = not zone.shape.intersects(self.area) or zone.shape.intersection(self.area).area == 0
            require(not outside, f"zone {zone.name}", "a shape outside the area", "must overlap the area")
        faults = start_faults(
            self.area, [obstacle.shape for obstacle in self.obstacles if obstacle.blocks_motion], self.fleet
        )
        if faults:
            raise MissionError(*(f"{where}: {message}" for where, message in faults))
        space = isinstance(self.planning, SwarmSettings) and self.planning.altitudes_m is not None
        for sensor in (self.fleet.sensor, *(robot.sensor for robot in self.fleet.robots or ())):
            ok = space or not isinstance(sensor, DiscSensor) or sensor.half_angle_deg is None
            require(ok, "sensor.half_angle_deg", sensor, "only a swarm with altitudes_m has footprints that grow")
        if isinstance(self.planning, SwarmSettings):
            self._require_swarm()
            return
        require(not self.moving_obstacles, "moving_obstacles", len(self.moving_obstacles), "only a swarm heeds them")
        coming = [robot.name for robot in self.fleet.robots or () if not robot.stays]
        require(not coming, "fleet.robots", coming, "only robots of a swarm join or leave; leave out joins_s, leaves_s")
        if isinstance(self.planning, BounceSettings):
            self._require_bounce(self.planning)
        else:
            self._require_patrol(self.planning)

    def _require_patrol(self, settings: PatrolSettings) -> None:
        reach_m = min(inner_reach_m(r.sensor) for r in (self.fleet.equal_robot("r"), *(self.fleet.robots or ())))
        margin_m = settings.range_margin_m
        allowed = f"must be less than the {reach_m:.6g} m that every sensor reaches"
        require(margin_m < reach_m, "patrol.range_margin_m", margin_m, allowed)
        asked = self.period_s is not None or any(zone.period_s is not None for zone in self.zones)
        require(asked, "period_s", None, "the area or at least one zone needs a period")

    def _require_swarm(self) -> None:
        robots = self.fleet.robots
        require(robots is not None, "fleet.robots", "fewest", "a swarm needs a number of robots, or a list of them")
        for robot in robots or ():
            ok = isinstance(robot.sensor, DiscSensor) or self.swarm.altitudes_m is None
            require(ok, f"robot {robot.name}: sensor", "square", "a swarm with altitudes_m needs disc sensors")
            ok = robot.turn_rate_rad_s is None
            require(ok, f"robot {robot.name}: turn_rate_rad_s", robot.turn_rate_rad_s, "a swarm turns at once; null")
        if self.swarm.altitudes_m is not None:
            # footprints that grow with height are not what the check judges periods by
            periods = [self.period_s, *(zone.period_s for zone in self.zones)]
            asked = [period for period in periods if period is not None]
            require(not asked, "period_s", asked, "a swarm with altitudes_m is asked no periods; leave them out")
            require(not self.moving_obstacles, "moving_obstacles", len(self.moving_obstacles), "none with altitudes_m")
            coming = [robot.name for robot in robots or () if not robot.stays]
            require(not coming, "fleet.robots", coming, "with altitudes_m none may join or leave")

    def _require_bounce(self, settings: BounceSettings) -> None:
        require(not isinstance(self.fleet.start, StartBox), "fleet.start", "a box", "bouncing robots start at points")
        robots = self.fleet.robots
        ok = robots is not None or self.fleet.start is None
        require(ok, "fleet.start", "points", "robots as few as possible begin where the planner likes: remove it")
        ok = robots is not None or settings.task == "monitor"
        require(ok, "fleet.robots", "fewest", "a number of robots, or a list of them, is needed to cover an area")
        for name in ("bouncing_angles_deg", "start_headings_deg"):
            angles = getattr(settings, name)
            if angles is not None and len(angles) != 1 and (robots is None or len(angles) != len(robots)):
                allowed = f"one for all robots or one for each of {len(robots)}" if robots else "one for all robots"
                raise MissionError(f"bounce.{name}: {len(angles)} angles are not allowed; {allowed} is needed")
        if settings.cells == "none":
            starts = [robot.name for robot in robots or () if robot.start is not None]
            allowed = "with bounce.cells none robots begin where the planner likes; remove it"
            require(self.fleet.start is None and not starts, "start", starts or "points", allowed)
        if settings.task == "monitor":
            zones = [zone for zone in self.zones if zone.period_s is not None]
            require(self.period_s is None, "period_s", self.period_s, "bouncing robots monitor zones, not the area")
            require(bool(zones), "zones", [], "a zone with a period is needed to monitor")
            for zone in zones:
                ok = zone.demand == "visit"
                require(ok, f"zone {zone.name}: demand", zone.demand, "bouncing robots visit zones; visit")
        else:
            asked = [zone.name for zone in self.zones if zone.period_s is not None]
            ok = self.period_s is None and not asked
            require(ok, "period_s", self.period_s or asked, "covering happens once; give no periods, or task monitor")

    @property
    def patrol(self) -> PatrolSettings:
        """The settings of the planner ``patrol``; TypeError for a mission of another one."""
        if not isinstance(self.planning, PatrolSettings):
            raise TypeError(f"mission {self.name} is planned by {self.planning.planner}, not by patrol")
        return self.planning

    @property
    def swarm(self) -> SwarmSettings:
        """The settings of the planner ``swarm``; TypeError for a mission of another one."""
        if not isinstance(self.planning, SwarmSettings):
            raise TypeError(f"mission {self.name} is planned by {self.planning.planner}, not by swarm")
        return self.planning

    @property
    def grid_corner_m(self) -> Place:
        """The lower left corner of a bouncing robot's first cell: that of the area's bounds.

        Where the settings give another corner of a cell, it is up to a cell below and to the left of the bounds.
        """
        given, cell_m = self.bounce.cell_origin, self.bounce.cell_m
        x0, y0, _, _ = self.area.bounds
        if given is None:
            return x0, y0
        left, below = (math.ceil((given[k] - low) / cell_m - 1e-9) for k, low in enumerate((x0, y0)))
        return given[0] - left * cell_m, given[1] - below * cell_m

    @property
    def bounce(self) -> BounceSettings:
        """The settings of the planner ``bounce``; TypeError for a mission of another one."""
        if not isinstance(self.planning, BounceSettings):
            raise TypeError(f"mission {self.name} is planned by {self.planning.planner}, not by bounce")
        return self.planning

    @property
    def has_starts(self) -> bool:
        """Whether any robot must begin at a given place."""
        return self.fleet.start is not None or any(robot.start is not None for robot in self.fleet.robots or ())

    def with_effort(self, effort: Effort) -> Mission:
        """The same mission, planned with another effort."""
        ok = isinstance(self.planning, PatrolSettings)
        require(ok, "effort", effort, f"the {self.planning.planner} planner has none: leave it out")
        return replace(self, planning=replace(self.patrol, effort=effort))

    def with_method(self, method: Method) -> Mission:
        """The same mission, planned by another method."""
        ok = isinstance(self.planning, PatrolSettings)
        require(ok, "method", method, f"the {self.planning.planner} planner has none; methods are the patrol planner's")
        return replace(self, planning=replace(self.patrol, method=method))
