"""What is asked of robots that run as processes of their own, and what was recorded of them."""

from __future__ import annotations

import ipaddress
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Protocol

from rota.errors import MissionError
from rota.model.plan import Plan

TRANSPORTS = ("udp", "ros2")
FIRST_PORT, LAST_PORT = 47600, 65535
LOOPBACK = "127.0.0.1"

HeightAt = Callable[[float, float], float]


def is_loopback(host: str) -> bool:
    """Whether a host is this machine, and can be reached from nowhere else."""
    with suppress(ValueError):
        return ipaddress.ip_address(host).is_loopback
    return host.lower() == "localhost"


def level(_x: float, _y: float) -> float:
    """The height of level ground."""
    return 0.0


@dataclass(frozen=True, kw_only=True)
class ProcessSettings:
    """How robots' processes run and reach each other.

    seed: for starts that the mission leaves open. transport: "udp", or "ros2" for a topic of ROS 2. port, hosts: of udp
    only; the port of the fleet's first robot, the others' follow, and last comes the recorder's; a host for each robot,
    then the recorder's, or a single one for all. rate_hz: how often a robot decides (None: every time step of the
    mission). silent_s: one that tells nothing for so long is forgotten (None: five time steps). clock_error_s: by which
    the clocks of several hosts may differ. own_clocks: clocks have nothing to do with each other, and clock_error_s is
    how late the promptest news of a robot are. radio_range_m: messages from farther away count as not received (None:
    none are). ground_m: the height of the ground at (x, y) in metres, over which robots
    fly at the fleet's altitude.

    Raises MissionError for other transports, ports out of range and times that are none.
    """

    seed: int = 0
    transport: str = "udp"
    port: int = FIRST_PORT
    hosts: tuple[str, ...] = (LOOPBACK,)
    rate_hz: float | None = None
    silent_s: float | None = None
    clock_error_s: float = 0.0
    own_clocks: bool = False
    radio_range_m: float | None = None
    ground_m: HeightAt = field(default=level)

    def __post_init__(self) -> None:
        if self.transport not in TRANSPORTS:
            raise MissionError(f"transport: {self.transport!r} is not allowed; {' or '.join(TRANSPORTS)} is needed")
        if self.transport != "udp" and (self.port, self.hosts) != (FIRST_PORT, (LOOPBACK,)):
            raise MissionError("port, hosts: not allowed with transport ros2, whose robots find each other")
        if not 1 <= self.port <= LAST_PORT:
            raise MissionError(f"port: {self.port} is not allowed; 1 to {LAST_PORT} is needed")
        if self.rate_hz is not None and not 0.1 <= self.rate_hz <= 1000:
            raise MissionError(f"rate: {self.rate_hz:.6g} Hz is not allowed; 0.1 to 1000 Hz are needed")


@dataclass(frozen=True, kw_only=True)
class RobotRecord:
    """What its tellings say of one robot's process.

    ticks: tellings recorded; lost: those that never came; dropped: datagrams that it could not read. rate_hz: ticks in
    a second. busy_ms: processor time of its ticks in milliseconds, all of them. end: "runs", "left" or "silent".
    """

    robot: str
    ticks: int
    lost: int
    dropped: int
    rate_hz: float
    busy_ms: tuple[float, ...]
    end: str


@dataclass(frozen=True, kw_only=True)
class SwarmRecord:
    """A plan of what robots did; coverage, rows (seconds since the begin, share covered, robots taking part)."""

    plan: Plan
    coverage: tuple[tuple[float, float, int], ...]
    robots: tuple[RobotRecord, ...]
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Launch:
    """What is asked of a launch of robots' processes, and who is told of it.

    robots: the numbers of those to start; None: all. time_limit_s: how long they run after the begin; None: until they
    are at rest. ends_at_rest: with a limit, too, once nobody is to join or leave any more. should_stop: polled often;
    once True the record ends. started: called with the processes' ids by the robots' numbers. measured: called every
    second with seconds since the begin, the share covered and how many take part.
    """

    robots: Sequence[int] | None = None
    time_limit_s: float | None = None
    ends_at_rest: bool = False
    should_stop: Callable[[], bool] = lambda: False
    started: Callable[[dict[int, int]], None] = lambda _pids: None
    measured: Callable[[float, float, int], None] = lambda _time_s, _share, _robots: None


EVERYTHING = Launch()


class RobotProcesses(Protocol):
    """The robots of a mission as processes of their own."""

    def run_robot(self, robot: int, should_stop: Callable[[], bool]) -> int:
        """Be the robot of this number in the fleet until it has left; returns how many datagrams it could not read.

        Raises LinkError where its port is taken, MissionError for a number or a rate that is not allowed.
        """

    def run_all(self, launch: Launch) -> SwarmRecord:
        """Start a process for each robot, record what they tell, end them, and return the record.

        Raises LinkError where a port is taken, where a process does not start, and where nobody was heard; RotaError
        where ROS 2 is asked for and missing.
        """
