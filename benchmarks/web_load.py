"""The page's server under load: many who read, some who plan, and nothing may be lost or late."""

from __future__ import annotations

import asyncio
import json
import math
import statistics
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from benchmarks.page_server import Client, page_server
from benchmarks.row import Options, Row

READERS, PLANNERS, LOAD_S = 200, 20, 60.0
READ_EVERY_S, LOOK_EVERY_S = 1.0, 0.5  # pages look at what they show so often
MOST_MS = 100.0
FIRST_PLANS, MOST_FIRST_S, WARM_S = 5, 5.0, 60.0
TICKS_PER_S = 100
OVER = ("done", "no_plan", "failed", "stopped", "interrupted")
SQUARE = {
    "rota": 1,
    "name": "square",
    "area": [[0, 0], [6, 0], [6, 6], [0, 6]],
    "period_s": 60,
    "fleet": {"robots": "fewest", "speed_m_s": 2, "sensor": {"shape": "disc", "radius_m": 5}},
    "patrol": {"effort": "quick"},
}


class Load(NamedTuple):
    """Milliseconds of every read, the states of all jobs in the end, and how many there should be."""

    reads_ms: list[float]
    ended: list[str]
    started: int


def web_load(options: Options) -> Iterator[Row]:
    """200 clients that read once a second each and 20 that plan one job after another, for a minute on loopback."""
    with page_server(options.folder / "load", "--processes", "2") as (port, _):
        load = asyncio.run(_loaded(port))
    ordered = sorted(load.reads_ms)
    late_ms = ordered[int(0.99 * len(ordered))]
    kept = [load.ended.count(state) for state in ("done", "running", "queued")]
    lost = load.started - sum(kept)
    measured = (
        f"{late_ms:.0f} ms (median {statistics.median(ordered):.1f}, longest {ordered[-1]:.0f}) of"
        f" {len(ordered):,} reads; {lost} of {load.started} jobs lost,"
        f" {kept[0]} done"
    )
    yield Row(
        f"page: {READERS} clients read and {PLANNERS} plan for {LOAD_S:.0f} s, 99th percentile of reads",
        f"< {MOST_MS:g} ms, no job lost", measured, late_ms < MOST_MS and lost == 0,
    )  # fmt: skip


async def _loaded(port: int) -> Load:
    client = Client(port)
    mission = (await client.json("POST", "/api/missions", {"document": SQUARE}))["id"]
    first = await _planned(client, mission, 0)
    paths = ("/api/missions", f"/api/missions/{mission}", "/api/jobs", "/api/plans", f"/api/plans/{first['plan']}", "/")
    reads_ms: list[float] = []
    jobs: list[str] = []
    end_s = time.perf_counter() + LOAD_S
    readers = [_read(port, paths[k:] + paths[:k], k / READERS, end_s, reads_ms) for k in range(READERS)]
    planners = [_plan(port, mission, k, end_s, jobs) for k in range(PLANNERS)]
    await asyncio.gather(*readers, *planners)
    ended = [(await client.json("GET", f"/api/jobs/{job}"))["state"] for job in jobs]
    client.close()
    return Load(reads_ms, ended, len(jobs))


async def _read(port: int, paths: tuple[str, ...], after_s: float, end_s: float, reads_ms: list[float]) -> None:
    """Read one thing after another, each READ_EVERY_S, whatever the last read took."""
    client = Client(port)
    await asyncio.sleep(after_s * READ_EVERY_S)
    count = 0
    while (began_s := time.perf_counter()) < end_s:
        status, _ = await client.ask("GET", paths[count % len(paths)])
        reads_ms.append(1e3 * (time.perf_counter() - began_s))
        assert status == 200, status
        count += 1
        await asyncio.sleep(max(began_s + READ_EVERY_S - time.perf_counter(), 0))
    client.close()


async def _plan(port: int, mission: str, seed: int, end_s: float, jobs: list[str]) -> None:
    """Start one job after another, and look at it until it is over; the last ones go on after the load."""
    client = Client(port)
    while time.perf_counter() < end_s:
        job = await client.json("POST", "/api/jobs", {"mission": mission, "seed": seed})
        jobs.append(job["id"])
        await _over(client, job["id"], end_s)
    client.close()


async def _over(client: Client, job: str, until_s: float = math.inf) -> dict[str, str]:
    """A job once it is over, or as it is at some time."""
    while (shown := await client.json("GET", f"/api/jobs/{job}"))["state"] not in OVER:
        if time.perf_counter() > until_s:
            break
        await asyncio.sleep(LOOK_EVERY_S)
    ended: dict[str, str] = shown
    return ended


async def _planned(client: Client, mission: str, seed: int) -> dict[str, str]:
    job = await client.json("POST", "/api/jobs", {"mission": mission, "seed": seed})
    return await _over(client, job["id"])


def first_plan(options: Options) -> Iterator[Row]:
    """How long the harbour takes from POST /api/jobs to the first plan that the check passes, once warm."""
    with page_server(options.folder / "first", "--processes", "1") as (port, server):
        times = asyncio.run(_first_plans(port, server))
    valid_s, drawn_s = statistics.median(valid for valid, _ in times), statistics.median(any_ for _, any_ in times)
    measured = (
        f"{valid_s:.1f} s ({min(t for t, _ in times):.1f} to {max(t for t, _ in times):.1f}); a first plan to draw"
    )
    yield Row(
        "page: harbour, from Plan to the first plan that the check passes, warm", f"< {MOST_FIRST_S:g} s",
        f"{measured} after {drawn_s:.1f} s", valid_s < MOST_FIRST_S,
    )  # fmt: skip


async def _first_plans(port: int, server: int) -> list[tuple[float, float]]:
    """Of each run the seconds to the first plan that meets its demand, and to the first one of any kind."""
    client = Client(port)
    mission = (await client.json("POST", "/api/missions", {"example": "harbour"}))["id"]
    await _settled(server)
    times = []
    for seed in range(FIRST_PLANS):
        began_s = time.perf_counter()
        job = await client.json("POST", "/api/jobs", {"mission": mission, "seed": seed})
        drawn_s = None
        while True:
            shown = await client.json("GET", f"/api/jobs/{job['id']}")
            now_s = time.perf_counter() - began_s
            if shown["best"] is not None and drawn_s is None:
                drawn_s = now_s
            if shown["state"] in OVER or (shown["best"] is not None and shown["best"]["met"]):
                break
            await asyncio.sleep(0.02)
        assert shown["best"]["met"], json.dumps(shown)
        times.append((now_s, drawn_s or now_s))
        await client.ask("POST", f"/api/jobs/{job['id']}/stop")
        await _over(client, job["id"])
        await _settled(server)
    client.close()
    return times


async def _settled(server: int) -> None:
    """Wait until the server's process for the next job waits for it: it sleeps once it has loaded what it needs."""
    end_s = time.perf_counter() + WARM_S
    quiet, spent = 0, -1.0
    while quiet < 5 and time.perf_counter() < end_s:
        await asyncio.sleep(0.5)
        now = _cpu_s_of_planning_processes(server)
        quiet, spent = (quiet + 1, now) if now - spent < 0.02 else (0, now)


def _cpu_s_of_planning_processes(server: int) -> float:
    """CPU seconds of the processes that plan for a server; 0 where the system does not tell."""
    spent = 0.0
    for process in Path("/proc").glob("[0-9]*"):
        try:
            fields = (process / "stat").read_text().rsplit(")", 1)[1].split()
            if int(fields[1]) == server and b'"role": "planning"' in (process / "cmdline").read_bytes():
                spent += (int(fields[11]) + int(fields[12])) / TICKS_PER_S
        except OSError:
            continue
    return spent
