"""What every link to robots does, and what goes over it.

All places are in the mission's own metres and all times in seconds since the plan's start; a link translates to and
from what its robots speak.
"""

from __future__ import annotations

from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import Literal, Protocol

from rota.route import Route

Mode = Literal["idle", "ready", "running", "paused", "returning", "failed"]


@dataclass(frozen=True, kw_only=True)
class Report:
    """What one robot said of itself: where it was at ``time_s``, as its own clock or the link's arrival time tells.

    position_m: (x, y, height) in metres. battery: 0 (empty) to 1 (full), None where the robot does not say.
    """

    robot: str
    time_s: float
    position_m: tuple[float, float, float]
    battery: float | None = None
    mode: Mode | None = None


class Link(Protocol):
    """A connection to a fleet. Every method raises LinkError, which names the robot, where it fails or takes too long.

    Links listen and connect on loopback unless their settings name another place. What arrives is validated before it
    becomes a Report; what is malformed is counted in ``rejected`` and dropped.
    """

    @property
    def robots(self) -> tuple[str, ...]:
        """The names of the robots that it reaches."""

    @property
    def rejected(self) -> int:
        """How many messages were dropped because they were malformed, unknown or out of range."""

    async def open(self) -> None:
        """Connect, and wait until every robot has been heard and is of the type that the route needs."""

    async def send_route(self, route: Route) -> None:
        """Give a robot its route; it has all of it afterwards or, on errors, nothing of it."""

    async def read_route(self, robot: str) -> Route:
        """The route that the robot holds, read back from it."""

    async def clear_route(self, robot: str) -> None:
        """Take the robot's route away; no error where it has none."""

    async def start(self, robot: str) -> None:
        """Let the robot drive its route."""

    async def pause(self, robot: str) -> None:
        """Let the robot stop where it is; ``start`` goes on from there."""

    async def come_home(self, robot: str) -> None:
        """Let the robot give up its route and return to where it began."""

    def reports(self) -> AsyncIterator[Report]:
        """All reports of all robots as they arrive, until the link is closed."""

    async def close(self) -> None:
        """Let go of the connection; robots go on with what they do."""
