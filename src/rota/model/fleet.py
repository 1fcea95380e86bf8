"""Robots, kinds of them, and the fleet that they make up. SI units, frozen."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeVar

from rota.errors import MissionError
from rota.model.battery_limits import ENDLESS, BatteryLimits
from rota.model.field_values import check_fields
from rota.model.fields import AS_FLEET, REQUIRED, field_of
from rota.model.limits import COORDINATE, LARGEST_M, LENGTH, LENGTH_OR_ZERO, LONGEST_S, MOMENT, RATE
from rota.model.motion_limits import AT_ONCE, MotionLimits, driving_faults
from rota.model.refusals import require, require_text
from rota.model.sensors import (
    DiscSensor as DiscSensor,
    Sensor as Sensor,
    SquareSensor as SquareSensor,
    inner_reach_m as inner_reach_m,
)
from rota.model.starts import Place as Place, Start as Start, StartBox as StartBox, StartPoints as StartPoints

TURNS_ONE_WAY = "must be 0 where turn_rate_rad_s is given: a robot turns on the spot or on arcs"
ROBOTS_NEEDED = "fewest, a whole number or a list of {name, ...} is needed"
KINDS_NEED_FEWEST = "leave it out: kinds are for the cheapest fleet of as many robots as are needed"
NO_POINTS_FOR_KINDS = "points are for equal robots; give a box, or leave it out"
MOST_COST, MOST_OF_KIND = 1e12, 100_000
COORDINATES = f"coordinates must be within {LARGEST_M:g} m of 0"


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
        return _with_values_of(fleet, self)

    @property
    def ground_speed_m_s(self) -> float:
        """The speed that it keeps over the ground, wherever the wind blows from. Planners and bounds count with it."""
        top_m_s = self.motion.top_airspeed_m_s
        return self.speed_m_s if top_m_s is None else min(self.speed_m_s, top_m_s - self.motion.wind_m_s)

    @property
    def turns_at_once(self) -> bool:
        """Whether it turns on the spot, and changes its speed, in no time."""
        return self.turn_rate_rad_s is None and self.turn_radius_m == 0 and not self.motion.has_mass

    @property
    def stays(self) -> bool:
        """Whether it takes part from the beginning and for ever."""
        return self.joins_s == 0 and self.leaves_s is None


@dataclass(frozen=True, kw_only=True)
class Kind(Abilities, as_fleet=True):
    """Robots that one may have more or fewer of, at a cost each; what it is not given it has from its fleet.

    Its robots are called ``name``-1, ``name``-2, ...
    """

    first: ClassVar[tuple[str, ...]] = ("name",)
    name: str = field_of(meaning="its robots are called so, with -1, -2, ... behind", count=((1, None),))
    cost: float = field_of(meaning="of one robot, in any unit", above=0, most=MOST_COST)
    most: int | None = field_of(None, "robots of it at most; null: as many as are needed", least=1, most=MOST_OF_KIND)

    def __post_init__(self) -> None:
        check_fields(self, f"kind {self.name}: ")
        require_text("kind.name", self.name)

    def of(self, fleet: Abilities) -> Kind:
        """The kind with its fleet's values for all that it does not say."""
        return _with_values_of(fleet, self)

    def robot(self, name: str) -> Robot:
        """A robot of this kind and name."""
        return Robot(name=name, **{ability: getattr(self, ability) for ability in ABILITIES})


ABILITIES = tuple(item.name for item in dataclasses.fields(Abilities))
Able = TypeVar("Able", Robot, Kind)


def _with_values_of(fleet: Abilities, one: Able) -> Able:
    """A robot or a kind with its fleet's values for all that it does not say."""
    said = {name: getattr(fleet, name) for name in ABILITIES if getattr(one, name) is AS_FLEET}
    return replace(one, **said) if said else one


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

    With ``kinds`` it is the cheapest fleet of robots of these kinds, and ``robots`` is None.

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
    kinds: tuple[Kind, ...] = field_of(
        (),
        "of patrol: kinds of robots with what differs and what one costs; the cheapest fleet of them is planned",
        count=((0, None),),
        newer=True,
        spared=True,
    )
    altitude_m: float = field_of(
        30.0, "for exports, and for how long copters land and climb", above=0, most=LARGEST_M, written=LENGTH
    )
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
        if self.kinds:
            self._check_kinds()
        if self.robots is not None:
            object.__setattr__(self, "robots", tuple(robot.of(self) for robot in self.robots))
            counted = Counter(robot.name for robot in self.robots)
            for name, count in counted.items():
                require(count == 1, "fleet.robots", name, "names must be unique")

    def _check_kinds(self) -> None:
        """Fill the kinds in. MissionError for kinds beside a number of robots or starts at points, and equal names."""
        require(self.robots is None, "fleet.robots", self.robots and len(self.robots), KINDS_NEED_FEWEST)
        require(not isinstance(self.start, StartPoints), "fleet.start", "points", NO_POINTS_FOR_KINDS)
        object.__setattr__(self, "kinds", tuple(kind.of(self) for kind in self.kinds))
        for name, count in Counter(kind.name for kind in self.kinds).items():
            require(count == 1, "fleet.kinds", name, "names must be unique")
        for kind in self.kinds:
            kind.robot(f"{kind.name}-1")

    def equal_robot(self, name: str) -> Robot:
        """A robot of this name with the fleet's common values."""
        return Robot(name=name, **{ability: getattr(self, ability) for ability in ABILITIES})

    @property
    def unlike_robots(self) -> tuple[Robot, ...]:
        """The robots that are listed; else one of each kind; else one of the equals."""
        if self.kinds:
            return tuple(kind.robot(f"{kind.name}-1") for kind in self.kinds)
        return self.robots or (self.equal_robot("robot-1"),)

    def kind_of(self, name: str) -> Kind:
        """The kind of the robot of this name. Raises MissionError when there is none."""
        own, _, number = name.rpartition("-")
        found = next((kind for kind in self.kinds if kind.name == own and number.isdecimal() and int(number) > 0), None)
        if found is None:
            called = " or ".join(f"{kind.name}-1, {kind.name}-2, ..." for kind in self.kinds)
            theirs = f"theirs are called {called}" if called else "the fleet has no kinds"
            raise MissionError(f"fleet.kinds: robot {name!r} is of none of them; {theirs}")
        return found

    def changing_speed_at_once(self) -> Fleet:
        """The same fleet without limits of motion."""
        robots = self.robots and tuple(replace(robot, motion=AT_ONCE) for robot in self.robots)
        kinds = tuple(replace(kind, motion=AT_ONCE) for kind in self.kinds)
        return replace(self, motion=AT_ONCE, robots=robots, kinds=kinds)

    def robot(self, name: str) -> Robot:
        """The robot of this name; in a fleet of as few as possible any name is one of the equals.

        Raises MissionError when the fleet is a list and the name is not in it, or has kinds and it is of none.
        """
        if self.kinds:
            return self.kind_of(name).robot(name)
        if self.robots is None:
            return self.equal_robot(name)
        if name in self._by_name:
            return self._by_name[name]
        raise MissionError(f"robot {name!r} is not in the fleet: {', '.join(r.name for r in self.robots)}")

    @cached_property
    def _by_name(self) -> dict[str, Robot]:
        return {robot.name: robot for robot in self.robots or ()}
