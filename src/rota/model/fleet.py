"""Robots, what they see with, and the fleet that they make up. SI units, frozen."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace
from functools import cached_property

from rota.errors import MissionError
from rota.model.limits import LARGEST_M, LONGEST_S
from rota.model.motion_limits import AT_ONCE, MotionLimits, driving_faults
from rota.model.refusals import require, require_positive, require_text

Place = tuple[float, float]

TURNS_ONE_WAY = "must be 0 where turn_rate_rad_s is given: a robot turns on the spot or on arcs"
COORDINATES = f"coordinates must be within {LARGEST_M:g} m of 0"


@dataclass(frozen=True, kw_only=True)
class DiscSensor:
    """Sees everything within ``radius_m`` that no obstacle hides.

    ``half_angle_deg``: a cone that looks straight down, for robots in a band of altitudes. From a height it has the
    ground in range that lies within height * tan(half angle), and never more than ``radius_m``. None: at any height
    all within ``radius_m``.
    """

    radius_m: float
    half_angle_deg: float | None = None

    def __post_init__(self) -> None:
        require_positive("sensor.radius_m", self.radius_m, LARGEST_M)
        angle = self.half_angle_deg
        ok = angle is None or 0 < angle < 90
        require(ok, "sensor.half_angle_deg", angle, "must be more than 0 and less than 90 degrees")

    def radius_at_m(self, height_m: float) -> float:
        """Radius in metres of the disc on the ground that is in range from a height in metres."""
        if self.half_angle_deg is None:
            return self.radius_m
        return min(self.radius_m, max(height_m, 0.0) * math.tan(math.radians(self.half_angle_deg)))

    @property
    def full_height_m(self) -> float:
        """Height in metres from which on its footprint grows no more; -inf where it never does."""
        if self.half_angle_deg is None:
            return -math.inf
        return self.radius_m / math.tan(math.radians(self.half_angle_deg))

    @property
    def reach_m(self) -> float:
        """Farthest distance at which anything can be seen."""
        return self.radius_m


@dataclass(frozen=True, kw_only=True)
class SquareSensor:
    """Sees a square of ``side_m`` by ``side_m`` round the robot, along the axes of the plane whatever the heading."""

    side_m: float

    def __post_init__(self) -> None:
        require_positive("sensor.side_m", self.side_m, LARGEST_M)
        require(self.side_m / 2 > 0, "sensor.side_m", self.side_m, "half of it must be greater than 0, too")

    @property
    def reach_m(self) -> float:
        """Farthest distance at which anything can be seen: half the diagonal."""
        return self.side_m / math.sqrt(2)


Sensor = DiscSensor | SquareSensor


def inner_reach_m(sensor: Sensor) -> float:
    """How far a sensor sees in every direction: a disc's radius, half a square's side."""
    return sensor.radius_m if isinstance(sensor, DiscSensor) else sensor.side_m / 2


@dataclass(frozen=True, kw_only=True)
class Robot:
    """One robot. ``turn_rate_rad_s`` None: it turns in no time. ``start``: (x, y) in metres, or None for anywhere.

    ``turn_radius_m``: it turns on arcs of this radius or more, never on the spot; 0: it turns where it stands.
    ``motion``: how fast it changes its speed and passes corners.

    It takes part from ``joins_s`` on until ``leaves_s`` (None: for ever). Before, it stands at its start, and after
    that where it is: it neither moves nor sees, but its body is there.
    """

    name: str
    speed_m_s: float
    sensor: Sensor
    body_radius_m: float = 0.0
    turn_rate_rad_s: float | None = None
    turn_radius_m: float = 0.0
    motion: MotionLimits = AT_ONCE
    start: Place | None = None
    joins_s: float = 0.0
    leaves_s: float | None = None

    def __post_init__(self) -> None:
        require_text("robot.name", self.name)
        require_positive(f"robot {self.name}: speed_m_s", self.speed_m_s)
        allowed = f"must be 0 to {LARGEST_M:g}"
        require(0 <= self.body_radius_m <= LARGEST_M, f"robot {self.name}: body_radius_m", self.body_radius_m, allowed)
        if self.turn_rate_rad_s is not None:
            require_positive(f"robot {self.name}: turn_rate_rad_s", self.turn_rate_rad_s)
        require(0 <= self.turn_radius_m <= LARGEST_M, f"robot {self.name}: turn_radius_m", self.turn_radius_m, allowed)
        ok = self.turn_radius_m == 0 or self.turn_rate_rad_s is None
        require(ok, f"robot {self.name}: turn_radius_m", self.turn_radius_m, TURNS_ONE_WAY)
        driven = vars(self.motion) | vars(self)
        for name, allowed in driving_faults(driven):
            require(False, f"robot {self.name}: {name}", driven[name], allowed)
        ok = 0 <= self.joins_s <= LONGEST_S
        require(ok, f"robot {self.name}: joins_s", self.joins_s, f"must be 0 to {LONGEST_S:g}")
        ok = self.leaves_s is None or self.joins_s < self.leaves_s <= LONGEST_S
        allowed = f"must come after joins_s, {self.joins_s:.6g}, and by {LONGEST_S:g}"
        require(ok, f"robot {self.name}: leaves_s", self.leaves_s, allowed)

    @property
    def turns_at_once(self) -> bool:
        """Whether it turns on the spot and in no time."""
        return self.turn_rate_rad_s is None and self.turn_radius_m == 0 and not self.motion.has_mass

    @property
    def stays(self) -> bool:
        """Whether it takes part from the beginning and for ever."""
        return self.joins_s == 0 and self.leaves_s is None


@dataclass(frozen=True, kw_only=True)
class StartBox:
    """Robots start anywhere in the box between two opposite corners, (x, y) in metres; it may have no width."""

    low_m: Place
    high_m: Place

    def __post_init__(self) -> None:
        ends = (self.low_m, self.high_m)
        ok = all(abs(value) <= LARGEST_M for end in ends for value in end)
        require(ok, "fleet.start.box", ends, COORDINATES)
        (x0, y0), (x1, y1) = ends
        object.__setattr__(self, "low_m", (float(min(x0, x1)), float(min(y0, y1))))
        object.__setattr__(self, "high_m", (float(max(x0, x1)), float(max(y0, y1))))


@dataclass(frozen=True, kw_only=True)
class StartPoints:
    """Robots start at these points, (x, y) in metres, one at each; the planner chooses who starts where."""

    points_m: tuple[Place, ...]

    def __post_init__(self) -> None:
        require(len(self.points_m) > 0, "fleet.start.points", self.points_m, "must be at least one point")
        for k, point in enumerate(self.points_m):
            ok = all(abs(value) <= LARGEST_M for value in point)
            require(ok, f"fleet.start.points[{k}]", point, COORDINATES)
        object.__setattr__(self, "points_m", tuple((float(x), float(y)) for x, y in self.points_m))


@dataclass(frozen=True, kw_only=True)
class Fleet:
    """The robots at hand: ``robots`` None means as few equal ones as possible, otherwise exactly those named.

    The other fields are the common values; a robot made without overrides has them. Names are unique. ``start``: where
    robots without a start of their own begin; points only where ``robots`` is None (named robots have their own).
    ``entrances``: places, (x, y) in metres, one at least. Robots can be only where their bodies can be driven to from
    one of these; what nobody sees from there is unseeable. None: robots can be wherever a body fits. ``rally_points``:
    places, (x, y) in metres, at which one that flies may land instead of at home, where it returns by itself.
    """

    speed_m_s: float
    sensor: Sensor
    robots: tuple[Robot, ...] | None = None
    body_radius_m: float = 0.0
    turn_rate_rad_s: float | None = None
    turn_radius_m: float = 0.0
    motion: MotionLimits = AT_ONCE
    altitude_m: float = 30.0
    start: StartBox | StartPoints | None = None
    entrances: tuple[Place, ...] | None = None
    rally_points: tuple[Place, ...] = ()

    def __post_init__(self) -> None:
        self.equal_robot("robot-1")  # checks the common values
        ok = self.robots is None or not isinstance(self.start, StartPoints)
        require(
            ok, "fleet.start", self.start, "points are for as few robots as possible; give named robots each its own"
        )
        require_positive("fleet.altitude_m", self.altitude_m, LARGEST_M)
        if self.entrances is not None:
            require(len(self.entrances) > 0, "fleet.entrances", self.entrances, "must be at least one place")
            object.__setattr__(self, "entrances", tuple((float(x), float(y)) for x, y in self.entrances))
        object.__setattr__(self, "rally_points", tuple((float(x), float(y)) for x, y in self.rally_points))
        if self.robots is not None:
            object.__setattr__(self, "robots", tuple(self.robots))  # fleets are hashed, and lists are not
            require(len(self.robots) > 0, "fleet.robots", 0, "must be at least one robot, or 'fewest'")
            counted = Counter(robot.name for robot in self.robots)
            for name, count in counted.items():
                require(count == 1, "fleet.robots", name, "names must be unique")

    def equal_robot(self, name: str) -> Robot:
        """A robot of this name with the fleet's common values."""
        return Robot(
            name=name,
            speed_m_s=self.speed_m_s,
            sensor=self.sensor,
            body_radius_m=self.body_radius_m,
            turn_rate_rad_s=self.turn_rate_rad_s,
            turn_radius_m=self.turn_radius_m,
            motion=self.motion,
        )

    def changing_speed_at_once(self) -> Fleet:
        """The same fleet without limits of motion."""
        robots = self.robots and tuple(replace(robot, motion=AT_ONCE) for robot in self.robots)
        return replace(self, motion=AT_ONCE, robots=robots)

    def robot(self, name: str) -> Robot:
        """The robot of this name; in a fleet of as few as possible any name is one of the equals.

        Raises MissionError when the fleet is a list and the name is not in it.
        """
        if self.robots is None:
            return self.equal_robot(name)
        if name in self._by_name:
            return self._by_name[name]
        raise MissionError(f"robot {name!r} is not in the fleet: {', '.join(r.name for r in self.robots)}")

    @cached_property
    def _by_name(self) -> dict[str, Robot]:
        return {robot.name: robot for robot in self.robots or ()}
