"""Paths of coverage-path-planner: ``python peer_paths.py PROBLEM.json`` prints one for each of its settings, as JSON.

Runs in an environment of its own, in which that package is installed and Rota is not.
"""

from __future__ import annotations

import json
import sys
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import coverage_path_planner as peer


def path_for(problem: dict[str, Any], settings: dict[str, Any]) -> dict[str, Any]:
    """The waypoints for one choice of settings, and the seconds they took."""
    ground = peer.Environment(polygon(problem["area"]))
    for obstacle in problem["obstacles"]:
        ground.addObstacle(polygon(obstacle))
    chosen = peer.PathSettings()
    for name, value in settings.items():
        setattr(chosen, name, value)
    started_s = time.perf_counter()
    found = peer.PathService().computeFullTask(ground, chosen, peer.Point(*problem["start"]))
    seconds = time.perf_counter() - started_s
    return {"settings": settings, "seconds": seconds, "points": [(p.x, p.y) for p in found.path.getPoints()]}


def polygon(ring: list[list[float]]) -> peer.Polygon:
    """The peer's polygon."""
    return peer.Polygon([peer.Point(x, y) for x, y in ring])


if __name__ == "__main__":
    asked = json.loads(Path(sys.argv[1]).read_text())
    paths = [path_for(asked, settings) for settings in asked["settings"]]
    print(json.dumps({"version": version("coverage-path-planner"), "paths": paths}))
