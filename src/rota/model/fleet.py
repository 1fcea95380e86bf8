"""Robots, what they see with, and the fleet that they make up. SI units, frozen."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from rota.errors import MissionError
from rota.model.battery_limits import ENDLESS, BatteryLimits
from rota.model.field_values import check_fields
from rota.model.fields import AS_FLEET, REQUIRED, field_of
from rota.model.limits import COORDINATE, LARGEST_M, LENGTH, LENGTH_OR_ZERO, LONGEST_S, MOMENT, RATE
from rota.model.motion_limits import AT_ONCE, MotionLimits, driving_faults
from rota.model.refusals import require, require_text

Place = tuple[float, float]

TURNS_ONE_WAY = "must be 0 where turn_rate_rad_s is given: a robot turns on the spot or on arcs"
ROBOTS_NEEDED = "fewest, a whole number or a list of {name, ...} is needed"
COORDINATES = f"coordinates must be within {LARGEST_M:g} m of 0"


@dataclass(frozen=True, kw_only=True)
class DiscSensor:
    """Sees everything within ``radius_m`` that no obstacle hides.

    ``half_angle_deg``: a cone that looks straight down, for robots in a band of altitudes. From a height it has the
    ground in range that lies within height * tan(half angle), and never more than ``radius_m``. None: at any height
    all within ``radius_m``.
    """

    tag: ClassVar[tuple[str, str]] = ("shape", "disc")
    radius_m: float = field_of(meaning="how far it sees", above=0, most=LARGEST_M, written=LENGTH)
    half_angle_deg: float | None = field_of(
        None,
        "of a swarm with altitudes_m: the disc grows with height, height x tan, up to radius_m",
        above=0,
        below=90,
        newer=True,
        spared=True,
    )

    def __post_init__(self) -> None:
        check_fields(self, "sensor.")

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

    tag: ClassVar[tuple[str, str]] = ("shape", "square")
    side_m: float = field_of(meaning="from border to border", above=0, most=LARGEST_M, written=LENGTH)

    def __post_init__(self) -> None:
        check_fields(self, "sensor.")
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
class Abilities:
    """What robots can do: declared here for fleets and robots alike.

    Fleets have these in common. Of a subclass ``as_fleet`` a field that is not given is ``AS_FLEET``.
    """

    speed_m_s: float = field_of(meaning="required where no vehicle has one", above=0, written=RATE, preset=True)
    sensor: Sensor = field_of(meaning="what a robot sees round itself")
    body_radius_m: float = field_of(
        0.0, "how far robots keep from walls and from each other", least=0, most=LARGEST_M, written=LENGTH_OR_ZERO
    )
    turn_rate_rad_s: float | None = field_of(None, "null: turning takes no time", above=0, written=RATE)
    turn_radius_m: float = field_of(
        0.0,
        "robots turn on arcs of this radius or more; 0: on the spot",
        least=0,
        most=LARGEST_M,
        written=LENGTH_OR_ZERO,
        newer=True,
        spared=True,
    )
    motion: MotionLimits = field_of(AT_ONCE, flat=True)
    battery: BatteryLimits = field_of(ENDLESS, flat=True)

    def __init_subclass__(cls, *, as_fleet: bool = False) -> None:
        for item in dataclasses.fields(Abilities) if as_fleet else ():
            cls.__annotations__[item.name] = item.type
            usual = REQUIRED if item.default is dataclasses.MISSING else item.default
            told = {**item.metadata, "as_fleet": True, "default": usual}
            setattr(cls, item.name, dataclasses.field(default=AS_FLEET, metadata=told))


@dataclass(frozen=True, kw_only=True)
class Robot(Abilities, as_fleet=True):
    """One robot. What it can do and is not given it has from its fleet, which fills it in: ``AS_FLEET`` until then.

    A robot without a fleet is one of ``Fleet.equal_robot``.

    It takes part from ``joins_s`` on until ``leaves_s`` (None: for ever). Before, it stands at its start, and after
    that where it is: it neither moves nor sees, but its body is there. ``start``: (x, y) in metres, None: anywhere.
    """

    first: ClassVar[tuple[str, ...]] = ("name",)
    name: str = field_of(count=((1, None),))
    start: Place | None = field_of(
        None, "[x, y]; null: anywhere, or as fleet.start says", least=-LARGEST_M, most=LARGEST_M, written=COORDINATE
    )
    joins_s: float = field_of(
        0.0,
        "of a swarm: it stands at its start until then, and sees nothing",
        title="joins at",
        least=0,
        most=LONGEST_S,
        written=MOMENT,
        newer=True,
        spared=("joins_s", "leaves_s"),
    )
    leaves_s: float | None = field_of(
        None,
        "of a swarm: it stays where it is then, and sees nothing more",
        title="leaves at",
        above=0,
        most=LONGEST_S,
        written=MOMENT,
        newer=True,
        spared=("joins_s", "leaves_s"),
    )

    def __post_init__(self) -> None:
        check_fields(self, f"robot {self.name}: ")
        require_text("robot.name", self.name)
        turns: tuple[Any, ...] = (self.turn_radius_m, self.turn_rate_rad_s)
        ok = AS_FLEET in turns or not all(turns)
        require(ok, f"robot {self.name}: turn_radius_m", self.turn_radius_m, TURNS_ONE_WAY)
        if AS_FLEET not in vars(self).values():
            driven = vars(self.motion) | vars(self)
            for name, allowed in driving_faults(driven):
                require(False, f"robot {self.name}: {name}", driven[name], allowed)
        ok = self.leaves_s is None or self.joins_s < self.leaves_s
        allowed = f"must come after joins_s, {self.joins_s:.6g}"
        require(ok, f"robot {self.name}: leaves_s", self.leaves_s, allowed)

    def of(self, fleet: Abilities) -> Robot:
        """The robot with its fleet's values for all that it does not say."""
        said = {name: getattr(fleet, name) for name in ABILITIES if getattr(self, name) is AS_FLEET}
        return replace(self, **said) if said else self

    @property
    def ground_speed_m_s(self) -> float:
        """The speed that it keeps over the ground, wherever the wind blows from. Planners and bounds count with it."""
        top_m_s = self.motion.top_airspeed_m_s
        return self.speed_m_s if top_m_s is None else min(self.speed_m_s, top_m_s - self.motion.wind_m_s)

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

    low_m: Place = field_of(least=-LARGEST_M, most=LARGEST_M)
    high_m: Place = field_of(least=-LARGEST_M, most=LARGEST_M)

    def __post_init__(self) -> None:
        check_fields(self, "fleet.start.box.")
        (x0, y0), (x1, y1) = self.low_m, self.high_m
        object.__setattr__(self, "low_m", (float(min(x0, x1)), float(min(y0, y1))))
        object.__setattr__(self, "high_m", (float(max(x0, x1)), float(max(y0, y1))))

    @property
    def in_file(self) -> dict[str, Any]:
        """The box as files have it."""
        return {"box": [list(self.low_m), list(self.high_m)]}


@dataclass(frozen=True, kw_only=True)
class StartPoints:
    """Robots start at these points, (x, y) in metres, one at each; the planner chooses who starts where."""

    points_m: tuple[Place, ...] = field_of(least=-LARGEST_M, most=LARGEST_M, key="points")

    def __post_init__(self) -> None:
        check_fields(self, "fleet.start.")


@dataclass(frozen=True, kw_only=True)
class Start:
    """Where robots start in files: anywhere in a box, or at given points."""

    box: tuple[Place, Place] | None = field_of(
        None, "two opposite corners", least=-LARGEST_M, most=LARGEST_M, written=COORDINATE, newer=True
    )
    points: tuple[Place, ...] | None = field_of(
        None, "one for each robot", least=-LARGEST_M, most=LARGEST_M, written=COORDINATE, newer=True
    )


ABILITIES = tuple(item.name for item in dataclasses.fields(Abilities))

if TYPE_CHECKING:

    class _Robots:
        """What ``Fleet`` takes for its robots, and what it then has."""

        def __get__(self, fleet: object, kind: object = None) -> tuple[Robot, ...] | None: ...
        def __set__(self, fleet: object, robots: int | Literal["fewest"] | Iterable[Robot] | None) -> None: ...
else:
    _Robots = tuple[Robot, ...] | None


@dataclass(frozen=True, kw_only=True)
class Fleet(Abilities):
    """The robots at hand: ``robots`` None means as few equal ones as possible, otherwise exactly those named.

    It may be given as "fewest", as a number of equal robots, called robot-1, robot-2, ..., or as a list of robots,
    which have from the fleet what they do not say. Names are unique. ``start``: where
    robots without a start of their own begin; points only where ``robots`` is None (named robots have their own).
    ``entrances``: places, (x, y) in metres, one at least. Robots can be only where their bodies can be driven to from
    one of these; what nobody sees from there is unseeable. None: robots can be wherever a body fits. ``rally_points``:
    places, (x, y) in metres, at which one that flies may land instead of at home, where it returns by itself.
    """

    first: ClassVar[tuple[str, ...]] = ("robots",)
    robots: _Robots = field_of(
        None,
        "fewest, a number of them, or a list with what differs",
        form=Literal["fewest"] | tuple[Robot, ...],
        null_word="fewest",
    )
    altitude_m: float = field_of(30.0, "for exports", above=0, most=LARGEST_M, written=LENGTH)
    start: StartBox | StartPoints | None = field_of(
        None, "a box or points; null: anywhere", form=Start | None, newer=True
    )
    entrances: tuple[Place, ...] | None = field_of(
        None,
        "robots are only where their bodies can come to from one of these; null: anywhere; absent: anywhere, and on a"
        " ROS map where they can come to from inside or from their starts",
        least=-LARGEST_M,
        most=LARGEST_M,
        written=COORDINATE,
        newer=True,
        spared=True,
    )
    rally_points: tuple[Place, ...] = field_of(
        (),
        "where robots that fly may land instead of at home, when they return by themselves",
        count=((0, None),),
        least=-LARGEST_M,
        most=LARGEST_M,
        written=COORDINATE,
        newer=True,
        spared=True,
    )

    def __post_init__(self) -> None:
        given: Any = self.robots
        if isinstance(given, int) and not isinstance(given, bool):
            require(given >= 1, "fleet.robots", given, "must be at least 1")
            given = [self.equal_robot(f"robot-{k + 1}") for k in range(given)]
        ok = given is None or given == "fewest" or not isinstance(given, str | bool | float)
        require(ok, "fleet.robots", given, ROBOTS_NEEDED)
        object.__setattr__(self, "robots", None if isinstance(given, str) else given)
        check_fields(self, "fleet.")
        self.equal_robot("robot-1")
        ok = self.robots is None or not isinstance(self.start, StartPoints)
        require(
            ok, "fleet.start", self.start, "points are for as few robots as possible; give named robots each its own"
        )
        if self.robots is not None:
            object.__setattr__(self, "robots", tuple(robot.of(self) for robot in self.robots))
            counted = Counter(robot.name for robot in self.robots)
            for name, count in counted.items():
                require(count == 1, "fleet.robots", name, "names must be unique")

    def equal_robot(self, name: str) -> Robot:
        """A robot of this name with the fleet's common values."""
        return Robot(name=name, **{ability: getattr(self, ability) for ability in ABILITIES})

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
