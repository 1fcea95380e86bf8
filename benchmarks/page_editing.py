"""How smoothly a mission of many shapes is edited: frames a second while a corner is dragged, in Debian's chromium."""

from __future__ import annotations

import json
import math
import os
import shutil
import statistics
import urllib.request
from collections.abc import Iterator
from typing import Any

import numpy as np

from benchmarks.page_server import page_server
from benchmarks.row import Options, Row

OBSTACLES = 300
CORNERS = 8
APART_M = 10.0
LEAST_PER_SECOND = 30.0
DRAGGED_FRAMES = 120
DROPS = 5
SIZE: Any = {"width": 1280, "height": 800}

# a hand that drags a corner moves it in every frame; then it lets go, and the next frame shows the mission as it is now
DRAG = """async ([x, y, frames]) => {
  const frame = () => new Promise(requestAnimationFrame);
  const corner = document.elementFromPoint(x, y);
  const between = [];
  let [script, last] = [0, await frame()];
  for (let k = 0; k < frames; k += 1) {
    const began = performance.now();
    const place = { clientX: x + 6 * Math.sin(k / 9) + 8, clientY: y + 6 * Math.cos(k / 9) + 8 };
    corner.dispatchEvent(new MouseEvent("mousemove", { ...place, bubbles: true, buttons: 1, view: window }));
    script += performance.now() - began;
    const now = await frame();
    between.push(now - last);
    last = now;
  }
  window.dropped = new Promise((resolve) => document.addEventListener("mouseup", async () => {
    const began = performance.now();
    await frame();
    await frame();
    resolve(performance.now() - began);
  }, { once: true, capture: true }));
  return [between, script / frames];
}"""
CORNER = """() => {
  const corner = document.querySelector(".marker-icon:not(.marker-icon-middle)");
  const box = corner.getBoundingClientRect();
  return [box.x + box.width / 2, box.y + box.height / 2];
}"""


def page_editing(options: Options) -> Iterator[Row]:
    """Frames a second while a corner of one of many obstacles is dragged, and how long letting it go takes."""
    name = f"page: a corner dragged among {OBSTACLES} obstacles, without a GPU"
    found = shutil.which("chromium")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        found = None
    if found is None:
        yield Row(name, "chromium and playwright", "not installed", None)
        return
    with page_server(options.folder / "data") as (port, _), sync_playwright() as playwright:
        url = f"http://127.0.0.1:{port}"
        body = json.dumps({"document": many_obstacles()}).encode()
        request = urllib.request.Request(f"{url}/api/missions", body, {"Content-Type": "application/json"})
        with urllib.request.urlopen(request) as answer:
            mission = json.load(answer)["id"]
        browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        page = browser.new_page(viewport=SIZE, reduced_motion="reduce")
        page.on("pageerror", lambda e: print("E", e.stack))
        page.goto(f"{url}/#mission={mission}")
        page.locator("body[data-ready=true]").wait_for()
        page.locator("path.shape-obstacle").nth(OBSTACLES // 2).click(force=True)
        runs = []
        for _ in range(DROPS):
            page.locator(".marker-icon").first.wait_for()
            x, y = page.evaluate(CORNER)
            page.mouse.move(x, y)
            page.mouse.down()
            between, script = page.evaluate(DRAG, [x, y, DRAGGED_FRAMES])
            page.mouse.move(x + 8, y + 8)
            page.mouse.up()
            runs.append((between, script, page.evaluate("window.dropped")))
            page.wait_for_timeout(300)
        edited = page.locator("#undo").is_enabled()
        browser.close()
    if not edited:
        raise RuntimeError("the corner was not dragged")
    between_ms = [gap for run in runs for gap in run[0]]
    per_second = 1000.0 / statistics.mean(between_ms)
    script_ms, drop_ms = (statistics.median(run[k] for run in runs) for k in (1, 2))
    load = f"at a load of {os.getloadavg()[0]:.0f} on {os.cpu_count()} cores"
    slow = 1000.0 / float(np.percentile(between_ms, 95))
    measured = f"{per_second:.0f} frames/s {load}, 95 % above {slow:.0f}; {script_ms:.1f} ms of script a frame"
    yield Row(name, f"{LEAST_PER_SECOND:.0f} frames/s", measured, round(per_second) >= LEAST_PER_SECOND)
    yield Row(f"page: letting go of it, among {OBSTACLES} obstacles", "", f"{drop_ms:.0f} ms {load}", None)


def many_obstacles() -> dict[str, Any]:
    """A field with obstacles of several corners in rows."""
    columns = math.ceil(math.sqrt(OBSTACLES))
    rows = math.ceil(OBSTACLES / columns)
    obstacles = []
    for k in range(OBSTACLES):
        x, y = ((k % columns + 0.5) * APART_M, (k // columns + 0.5) * APART_M)
        turns = [2 * math.pi * corner / CORNERS for corner in range(CORNERS)]
        ring = [[round(x + 3 * math.cos(turn), 3), round(y + 3 * math.sin(turn), 3)] for turn in turns]
        obstacles.append({"name": f"hut {k + 1}", "ring": ring})
    wide, high = columns * APART_M, rows * APART_M
    return {
        "rota": 1,
        "name": "huts",
        "area": [[0, 0], [wide, 0], [wide, high], [0, high]],
        "obstacles": obstacles,
        "period_s": 300,
        "fleet": {"robots": "fewest", "speed_m_s": 5, "sensor": {"shape": "disc", "radius_m": 15}},
    }
