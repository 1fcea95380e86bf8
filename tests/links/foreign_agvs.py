"""Vehicles of Siemens' VDA 5050 library, each a process of node's; skipped where node or the library is missing."""

from __future__ import annotations

import asyncio
import json
import shutil
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from tests.links.fast_time import FastTime

FOLDER = Path(__file__).parent / "virtual_agv"


@dataclass
class ForeignAgv:
    """One vehicle; ``passed``: the sequence id of each node that it reached, with the Unix time of its own clock."""

    serial: str
    place_m: tuple[float, float]
    speed_m_s: float = 1.5
    version: str = "2.0.0"
    ticks: float = 5.0
    passed: list[tuple[int, float]] = field(default_factory=list)
    errors: list[dict[str, Any]] = field(default_factory=list)
    process: asyncio.subprocess.Process | None = None
    started: asyncio.Event = field(default_factory=asyncio.Event)

    async def run(self, port: int, clock: FastTime) -> None:
        given = {
            "port": port, "serial": self.serial, "version": self.version, "ticks": self.ticks, "speed": self.speed_m_s,
            "x": self.place_m[0], "y": self.place_m[1], "clock": clock.rate, "zero": clock.zero_s,
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
