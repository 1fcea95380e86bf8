"""How fast a plan is shown and played: first paint, frames a second and the size of a page, in Debian's chromium."""

from __future__ import annotations

import os
import shutil
import statistics
from base64 import b64encode
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from shapely import box

from benchmarks.row import Options, Row
from rota import SwarmSettings, check_plan
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot, Zone
from rota.model.plan import Plan, Trajectory
from rota.playback.page import page_text
from rota.playback.playback import playback_of

FEW, MANY, SWARM = 10, 50, 1000
CELLS = 62_000  # of the bounding box, of which some are walls
FIELD_M, LANES, SPEED_M_S, REACH_M = 100.0, 8, 8.0, 10.0
RUN_S, SWARM_STEP_S = 300.0, 1.0
PLAYED_S, RUNS = 3.0, 5
MOST_PAINT_S, MOST_BYTES = 1.0, 2_000_000
SIZE = {"width": 1400, "height": 900}
PLAY = """async ([text, speed, milliseconds]) => {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const { Playback } = await import("rota/playback.js");
  rotaPlayer.replace(Playback.decode(bytes.buffer));
  const [x0, y0, x1, y1] = rotaPlayer.playback.header.bounds_m;
  rotaPlayer.map.fitBounds([[y0, x0], [y1, x1]], { animate: false });
  rotaPlayer.seek(30);
  rotaPlayer.setSpeed(speed);
  await new Promise((resolve) => setTimeout(resolve, 500));
  rotaPlayer.toggle();
  rotaPlayer.frameCosts.length = 0;
  const deltas = [];
  let last = performance.now();
  const end = last + milliseconds;
  await new Promise((resolve) => {
    const step = (now) => {
      deltas.push(now - last);
      last = now;
      if (now < end) requestAnimationFrame(step);
      else resolve();
    };
    requestAnimationFrame(step);
  });
  if (!rotaPlayer.clock.playing) throw new Error("it did not play");
  rotaPlayer.toggle();
  return [deltas.slice(2), [...rotaPlayer.frameCosts], rotaPlayer.playback.entries];
}"""
PAINTED = """() => [performance.getEntriesByName("first-contentful-paint")[0]?.startTime,
  Boolean(window.rotaPlayer?.frameCosts.length) && performance.now()]"""


class Played(NamedTuple):
    """Milliseconds between frames and of script in each, and how many cells there were."""

    between_ms: list[float]
    script_ms: list[float]
    cells: int

    @property
    def per_second(self) -> float:
        """Frames a second, by the mean time between two."""
        return 1000.0 / statistics.mean(self.between_ms)

    def text(self) -> str:
        """Frames and script, the usual and the slow ones."""
        slow = np.percentile(self.script_ms, 95)
        usual = statistics.median(self.script_ms)
        load = f"at a load of {os.getloadavg()[0]:.0f} on {os.cpu_count()} cores"
        return f"{self.per_second:.0f} frames/s {load}; {usual:.1f} ms of script a frame, 95 % under {slow:.1f} ms"


def player(options: Options) -> Iterator[Row]:
    """First paint and size of a page of 10 robots, then frames with many cells and with many robots."""
    found = shutil.which("chromium")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        found = None
    if found is None:
        yield Row("a plan played in a browser", "chromium and playwright", "not installed", None)
        return
    few = field_of_mowers(FEW)
    text = page_text(few, check_plan(few))
    file = options.folder / "plan.html"
    file.write_text(text, encoding="utf-8")
    size = len(text.encode())
    yield Row(f"page of a plan of {FEW} robots", "< 2 MB", f"{size / 1e6:.2f} MB", size < MOST_BYTES)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        paints = [_painted_s(browser, file.as_uri()) for _ in range(5)]
        first, shown = (statistics.median(paint[k] for paint in paints) for k in (0, 1))
        yield Row(
            f"first paint of a plan of {FEW} robots", f"< {MOST_PAINT_S:g} s",
            f"{shown:.2f} s until the map is drawn, {first:.2f} s until text is", shown < MOST_PAINT_S,
        )  # fmt: skip
        # with less motion nothing plays before it is told to
        page = browser.new_page(viewport=SIZE, reduced_motion="reduce")
        page.goto(file.as_uri())
        many, swarm = field_of_mowers(MANY), spreading_swarm()
        played = _played(page, playback_of(many, check_plan(many), CELLS), 10.0)
        name = f"{MANY} robots and {played.cells:,} cells played, without a GPU"
        yield Row(name, "60 frames/s", played.text(), round(played.per_second) >= 60)
        played = _played(page, playback_of(swarm, check_plan(swarm)), 10.0)
        name = f"{SWARM:,} robots of a swarm played, without a GPU"
        yield Row(name, "30 frames/s", played.text(), round(played.per_second) >= 30)
        browser.close()


def _painted_s(browser: Any, address: str) -> tuple[float, float]:
    """Seconds from opening a page until its text is painted, and until the map is drawn."""
    page = browser.new_page(viewport=SIZE)
    page.goto(address)
    while True:
        text_ms, shown_ms = page.evaluate(PAINTED)
        if text_ms and shown_ms:
            page.close()
            return text_ms / 1000, shown_ms / 1000


def _played(page: Any, playback: bytes, speed: float) -> Played:
    """A playback in the place of a page's own, played for some seconds; of several times the middle one."""
    asked = [b64encode(playback).decode(), speed, 1000 * PLAYED_S]
    runs = sorted((Played(*page.evaluate(PLAY, asked)) for _ in range(RUNS)), key=lambda run: run.per_second)
    return runs[RUNS // 2]


def field_of_mowers(robots: int) -> Plan:
    """Each robot mows a field of 100 m by 100 m round a shed, in lanes; a zone in each fifth."""
    columns = 10
    ways, sheds, zones = [], [], []
    for k in range(robots):
        x, y = (k % columns) * FIELD_M, (k // columns) * FIELD_M
        rows = y + REACH_M / 2 + (FIELD_M - REACH_M) * np.arange(LANES) / (LANES - 1)
        left, right = x + REACH_M / 2, x + FIELD_M - REACH_M / 2
        corners = [(side, row) for n, row in enumerate(rows) for side in ((left, right) if n % 2 else (right, left))]
        places = np.array([*corners, corners[0]])
        times = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))]) / SPEED_M_S
        ways.append(Trajectory(robot=f"robot-{k + 1}", times_s=times, positions_m=places))
        middle = (rows[3] + rows[4]) / 2
        sheds.append(Obstacle(shape=box(x + 40, middle - 2, x + 60, middle + 2)))
        if k % 5 == 0:
            zones.append(Zone(name=f"zone {k + 1}", shape=box(x + 20, y + 20, x + 45, y + 40), period_s=150.0))
    mission = Mission(
        name="field", area=box(0, 0, min(robots, columns) * FIELD_M, -(-robots // columns) * FIELD_M),
        obstacles=tuple(sheds), zones=tuple(zones), period_s=120.0,
        fleet=Fleet(speed_m_s=SPEED_M_S, sensor=DiscSensor(radius_m=REACH_M)),
    )  # fmt: skip
    return Plan(mission=mission, trajectories=tuple(ways), lower_bound_robots=1)


def spreading_swarm() -> Plan:
    """1,000 robots on winding ways of 300 s from a heap to a lattice, a corner every second."""
    random = np.random.default_rng(0)
    side, apart_m = 32, 15.0
    ends = apart_m * np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2)[:SWARM] + apart_m
    starts = side * apart_m / 2 + random.uniform(-40, 40, (SWARM, 2))
    times = np.arange(0.0, RUN_S + SWARM_STEP_S, SWARM_STEP_S)
    share = (1 - np.cos(np.pi * times / RUN_S)) / 2
    sensor = DiscSensor(radius_m=8.0)
    robots, ways = [], []
    for k in range(SWARM):
        wobble = np.cumsum(random.normal(0, 0.5, (len(times), 2)), axis=0)
        wobble -= share[:, None] * wobble[-1]
        places = np.clip(starts[k] + share[:, None] * (ends[k] - starts[k]) + wobble, 1.0, (side + 1) * apart_m)
        robots.append(Robot(name=f"robot-{k + 1}", speed_m_s=5.0, sensor=sensor))
        ways.append(Trajectory(robot=robots[-1].name, times_s=times, positions_m=places, loop_start_s=times[-1]))
    mission = Mission(
        name="swarm", area=box(0, 0, (side + 2) * apart_m, (side + 2) * apart_m), planning=SwarmSettings(),
        fleet=Fleet(speed_m_s=5.0, sensor=sensor, robots=tuple(robots)),
    )  # fmt: skip
    return Plan(mission=mission, trajectories=tuple(ways))
