"""Vehicles of Siemens' VDA 5050 library, each a process of node's; skipped where node or the library is missing."""

from __future__ import annotations

import asyncio
import json
import shutil
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest
from shapely import box
from tests.links.fast_time import FastTime
from tests.links.fleets import plan_of

from rota.links.link import Link
from rota.links.link_settings import make_link
from rota.links.sending import routes_for, send_all, start_all
from rota.model.mission import Zone
from rota.model.plan import Plan, Trajectory
from rota.routes.driven_route import from_start
from rota.routes.route import route_of

FOLDER = Path(__file__).parent / "virtual_agv"


ROUND_S, TOP_M_S = 28.0, 1.5
NAMES = "abc"


def start_m(robot: str) -> tuple[float, float]:
    return 12.0 * NAMES.index(robot), 0.0


def loop_of(robot: str) -> Trajectory:
    """8 m x 4 m at 1 m/s, with 2 s of waiting at two corners."""
    x, y = start_m(robot)
    places = [(x, y), (x + 8, y), (x + 8, y), (x + 8, y + 4), (x, y + 4), (x, y + 4), (x, y)]
    return Trajectory(robot=robot, times_s=[0, 8, 10, 14, 22, 24, 28], positions_m=places)


def plan() -> Plan:
    made = plan_of(*map(loop_of, NAMES))
    fleet = made.mission.fleet
    robots = tuple(replace(robot, speed_m_s=TOP_M_S) for robot in fleet.robots or ())
    lane = Zone(name="lane", shape=box(0, 0, 32, 4), period_s=60)
    fleet = replace(fleet, speed_m_s=TOP_M_S, robots=robots)
    return replace(made, mission=replace(made.mission, fleet=fleet, zones=(lane,)))


@dataclass
class ForeignAgv:
    """One vehicle; ``passed``: the sequence id of each node that it reached, with the Unix time of its own clock."""

    serial: str
    place_m: tuple[float, float]
    speed_m_s: float = 1.5
    version: str = "2.0.0"
    ticks: float = 5.0
    battery: float = 100.0
    fills_h: float = 1.0
    passed: list[tuple[int, float]] = field(default_factory=list)
    errors: list[dict[str, Any]] = field(default_factory=list)
    process: asyncio.subprocess.Process | None = None
    started: asyncio.Event = field(default_factory=asyncio.Event)

    async def run(self, port: int, clock: FastTime) -> None:
        given = {
            "port": port, "serial": self.serial, "version": self.version, "ticks": self.ticks, "speed": self.speed_m_s,
            "battery": self.battery, "fills": self.fills_h, "clock": clock.rate, "zero": clock.zero_s,
            "x": self.place_m[0], "y": self.place_m[1],
        }  # fmt: skip
        self.process = await asyncio.create_subprocess_exec(
            "node", FOLDER / "agv.js", json.dumps(given), stdout=asyncio.subprocess.PIPE
        )
        assert self.process.stdout is not None
        async for line in self.process.stdout:
            told = json.loads(line)
            if "sequence" in told:
                self.passed.append((told["sequence"], told["unix_s"]))
            for error in told.get("errors", ()):
                if error not in self.errors:
                    self.errors.append(error)
            if "started" in told:
                self.started.set()

    def kill(self) -> None:
        assert self.process is not None
        self.process.kill()


def require_node() -> None:
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    if not (FOLDER / "node_modules").exists():
        pytest.skip("vda-5050-lib is not installed: npm ci --prefix tests/links/virtual_agv")


@asynccontextmanager
async def foreign(port: int, agvs: Sequence[ForeignAgv], clock: FastTime) -> AsyncIterator[None]:
    """The vehicles at the broker until the block ends."""
    tasks = [asyncio.create_task(agv.run(port, clock)) for agv in agvs]
    try:
        async with asyncio.timeout(30 * clock.rate):
            await asyncio.gather(*(agv.started.wait() for agv in agvs))
        yield
    finally:
        for agv in agvs:
            if agv.process is not None and agv.process.returncode is None:
                agv.process.kill()
        await asyncio.gather(*tasks, return_exceptions=True)


@dataclass
class Shift:
    """A link to foreign vehicles that drive a plan, when they were started by their clocks, and what was told."""

    of: Plan
    link: Link
    agvs: dict[str, ForeignAgv]
    told: list[str] = field(default_factory=list)
    began_s: float = 0.0

    def late_s(self, robot: str) -> list[float]:
        """How late a vehicle came to the first stop of each round after the first, by its own clock."""
        way = next(way for way in self.of if way.robot == robot)
        route = route_of(way, 0.0)
        assert route.closing is not None
        first, a_round = len(from_start(route)) - 1, len(route.every_round)
        late = []
        for sequence, unix_s in self.agvs[robot].passed:
            rounds, part = divmod(sequence // 2 - first, a_round)
            if rounds > 0 and part == 0:
                arrives_s = way.loop_start_s + rounds * way.loop_duration_s - route.closing.hold_s
                late.append(unix_s - self.began_s - arrives_s)
        return late

    @property
    def errors(self) -> list[dict[str, Any]]:
        """What all vehicles reported as errors."""
        return [error for agv in self.agvs.values() for error in agv.errors]

    async def start(self, clock: FastTime) -> None:
        """Send all routes, and start all vehicles."""
        routes = routes_for(self.of, self.link)
        await send_all(self.link, routes)
        self.began_s = clock.unix_s()
        await start_all(self.link, routes)


def with_foreign(
    port: int,
    clock: FastTime,
    what: Callable[[Shift], Awaitable[None]],
    *given: str,
    of: Plan | None = None,
    version: str = "2.0.0",
    slow_m_s: Mapping[str, float] | None = None,
    batteries: Mapping[str, float] | None = None,
) -> Shift:
    """What comes of doing something with a link to a vehicle for each robot, which stands where its way begins.

    slow_m_s: the speeds of those that are slower than their robots. batteries: of those that are not full, in percent;
    these are filled in 0.2 h.
    """
    of = of or plan()

    async def run() -> Shift:
        agvs = {}
        for way in of:
            x, y = way.positions_m[0, :2].tolist()
            speed_m_s = (slow_m_s or {}).get(way.robot, of.mission.fleet.robot(way.robot).speed_m_s)
            battery = (batteries or {}).get(way.robot, 100.0)
            agvs[way.robot] = ForeignAgv(way.robot, (x, y), speed_m_s, version, battery=battery, fills_h=0.2)
        async with foreign(port, list(agvs.values()), clock):
            shift = Shift(of, make_link("vda5050", of, [f"port={port}", *given]), agvs)
            try:
                await shift.link.open()
                await what(shift)
            finally:
                await shift.link.close()
        return shift

    return clock.run(run())
