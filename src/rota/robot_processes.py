"""What is asked of robots that run as processes of their own, and what was recorded of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from rota.errors import MissionError
from rota.plan import Plan

FIRST_PORT, LAST_PORT = 47600, 65535
LOOPBACK = "127.0.0.1"

HeightAt = Callable[[float, float], float]


def level(_x: float, _y: float) -> float:
    """The height of level ground."""
    return 0.0


@dataclass(frozen=True, kw_only=True)
class ProcessSettings:
    """How robots' processes run and reach each other.

    seed: for starts that the mission leaves open. port: that of the fleet's first robot; the others' follow, and last
    comes the recorder's. hosts: one for each robot, then the recorder's; or a single one for all. rate_hz: how often a
    robot decides (None: every time step of the mission). silent_s: one that tells nothing for so long is forgotten
    (None: five time steps). clock_error_s: by which the clocks of several hosts may differ. ground_m: the height of the
    ground at (x, y) in metres, over which robots fly at the fleet's altitude.

    Raises MissionError for ports out of range and times that are none.
    """

    seed: int = 0
    port: int = FIRST_PORT
    hosts: tuple[str, ...] = (LOOPBACK,)
    rate_hz: float | None = None
    silent_s: float | None = None
    clock_error_s: float = 0.0
    ground_m: HeightAt = field(default=level)

    def __post_init__(self) -> None:
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


class RobotProcesses(Protocol):
    """The robots of a mission as processes of their own."""

    def run_robot(self, robot: int, should_stop: Callable[[], bool]) -> int:
        """Be the robot of this number in the fleet until it has left; returns how many datagrams it could not read.

        Raises LinkError where its port is taken, MissionError for a number or a rate that is not allowed.
        """

    def run_all(
        self,
        *,
        robots: Sequence[int] | None,
        time_limit_s: float | None,
        should_stop: Callable[[], bool],
        started: Callable[[dict[int, int]], None],
        measured: Callable[[float, float, int], None],
    ) -> SwarmRecord:
        """Start a process for each robot, record what they tell, end them, and return the record.

        robots: the numbers of those to start; None: all. time_limit_s: how long they run after the begin; None: until
        they are at rest. started: called with the processes' ids by the robots' numbers. measured: called every second
        with seconds since the begin, the share covered and how many take part. Raises LinkError where a port is taken,
        where a process does not start, and where nobody was heard.
        """
