"""What every link to robots does, and what goes over it.

All places are in the mission's own metres and all times in seconds since the plan's start; a link translates to and
from what its robots speak.
"""

from __future__ import annotations

from collections.abc import AsyncGenerator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol, get_args

from rota.routes.route import Place3, Route

Mode = Literal["idle", "ready", "running", "paused", "returning", "failed"]
Fault = Literal[
    "malformed", "unknown robot", "not a number", "from the future", "out of order", "out of range", "too many",
]  # fmt: skip
FAULTS: tuple[Fault, ...] = get_args(Fault)


class Rejections(NamedTuple):
    """How many messages were dropped for one fault, and what the last of them held, in some words."""

    messages: int
    example: str


@dataclass(frozen=True, kw_only=True)
class Report:
    """What one robot said of itself: where it was at ``time_s``, as its own clock or the link's arrival time tells.

    position_m: (x, y, height) in metres. battery: 0 (empty) to 1 (full), None where the robot does not say.
    """

    robot: str
    time_s: float
    position_m: Place3
    battery: float | None = None
    mode: Mode | None = None


@dataclass(frozen=True, kw_only=True)
class Dock:
    """What a robot on its charger is to do: to stay there, or to leave it, for what its plan has from plan_s on."""

    leaves: bool
    plan_s: float


@dataclass(frozen=True, kw_only=True)
class Order:
    """How a robot on its route is to keep to the clock of all robots, whose time is that of the plan while all keep up.

    late_s: how far it is behind that clock; below 0: ahead of it. behind_s: how far the clock is behind the link's
    time. rate: the pace, as a share of the plan's, at which the robot is to go on; 0: it holds where it is. dock: of
    one that is on its charger, and late_s then how far the clock of all is past its leaving.
    """

    robot: str
    late_s: float
    behind_s: float
    rate: float
    dock: Dock | None = None


class Link(Protocol):
    """A connection to a fleet. Every method raises LinkError, which names the robot, where it fails or takes too long.

    Links listen and connect on loopback unless their settings name another place. What arrives is validated before it
    becomes a Report; what is none is counted in ``rejections`` and dropped.
    """

    @property
    def robots(self) -> tuple[str, ...]:
        """The names of the robots that it reaches."""

    @property
    def rejections(self) -> Mapping[Fault, Rejections]:
        """The messages that were dropped so far, by fault; ``too many``: good ones that nobody took in time."""

    @property
    def trouble(self) -> str:
        """What keeps it from its robots now, while it tries again; empty if nothing does."""

    @property
    def time_s(self) -> float:
        """Seconds since the plan's start."""

    @property
    def begun_s(self) -> float:
        """The plan's start in seconds since 1970, by the clock that its robots' stamps are of."""

    @property
    def in_process(self) -> bool:
        """Whether its robots are simulated in this process: whoever opens it has to start them."""

    @property
    def heard_by_one(self) -> bool:
        """Whether nobody else can hear its robots while it is open."""

    @property
    def takes_fences(self) -> bool:
        """Whether its robots keep the fence of a route by themselves."""

    @property
    def drives_along(self) -> bool:
        """Whether robots drive on only while this link is open and its ``reports`` are being taken."""

    @property
    def keeps_phase(self) -> bool:
        """Whether ``keep`` lets its robots gain and lose time."""

    @property
    def relieves(self) -> bool:
        """Whether ``keep`` lets its robots hold where they are, stay on chargers and leave them."""

    @property
    def lead_s(self) -> float:
        """How long before it leaves its charger a robot has to be told, since it takes off first."""

    @property
    def flies(self) -> bool:
        """Whether its robots take off: ``climb``, ``go``, ``land`` and ``home_m`` are for those alone."""

    async def open(self) -> None:
        """Connect, and wait until every robot has been heard and is of the type that the settings ask for."""

    async def send_route(self, route: Route) -> None:
        """Give a robot its route; on errors it may hold a part of it, which ``clear_route`` takes away."""

    async def differences(self, route: Route) -> tuple[str, ...]:
        """Read back what the robot holds and compare it item by item: a sentence for each difference from ``route``."""

    async def clear_route(self, robot: str) -> None:
        """Take the robot's route and fence away; no error where it has none."""

    async def by_itself(self, robot: str) -> tuple[str, ...]:
        """Sentences on what it does by itself where the link is lost or it leaves its fence, and on what it lacks."""

    def is_in_air(self, robot: str) -> bool:
        """Whether it flies, as far as is known."""

    def home_m(self, robot: str) -> Place3 | None:
        """Where it took off or will; None where it has not said so."""

    async def climb(self, robot: str, height_m: float) -> None:
        """Let it take off, or rise or sink where it is, and wait until it hovers at that height."""

    async def go(self, robot: str, places_m: Sequence[Place3]) -> None:
        """Let it fly straight to each place in turn, and wait until it hovers at the last one."""

    async def land(self, robot: str) -> None:
        """Let it land where it is, and wait until it stands."""

    def begin(self) -> None:
        """Let the plan's time start now, just before its robots do, unless settings say when it started."""

    async def start(self, robot: str) -> None:
        """Let the robot drive its route, or go on after ``pause``."""

    async def keep(self, order: Order) -> None:
        """Let a robot on its route keep to the clock of all.

        Called about once a second for each robot, with what is late then. The link does what its robots can, by their
        speeds and waits, no faster than they may drive; what they cannot make up shows in the next call.
        """

    def most_pace(self, robot: str) -> float:
        """The share of the plan's pace that it can be driven at by all that is known before; inf: nothing is known."""

    def room_s(self, robot: str) -> float:
        """How late a robot may be that makes it up by itself within a round; 0 where that is not known."""

    def expected_s(self, robot: str, plan_s: float) -> float:
        """How late it is where the plan has it at this time, while all goes well; 0 where nothing is known."""

    async def pause(self, robot: str) -> None:
        """Let the robot stop where it is; ``start`` goes on from there."""

    async def come_home(self, robot: str) -> None:
        """Let the robot give up its route and return to where it began."""

    def latest(self, robot: str) -> Report | None:
        """The robot's last report, None before the first."""

    def reports(self) -> AsyncGenerator[Report, None]:
        """All reports of all robots as they arrive, until the link is closed; for one reader at a time."""

    async def close(self) -> None:
        """Let go of the connection; robots go on with what they do, or stop where they need the link."""
