"""Tours of fast-tsp: ``python peer_tours.py PROBLEM.json`` prints one for each set of points, as JSON.

Runs in an environment of its own, in which that package is installed and Rota is not.
"""

from __future__ import annotations

import json
import math
import sys
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import fast_tsp as peer

LARGEST = 65_535  # the peer's distances are whole numbers of 16 bits


def tour_through(points: list[list[float]], seconds: float) -> dict[str, Any]:
    """The peer's closed tour, and the seconds it took; it works until those it is given are over."""
    apart = [[math.dist(a, b) for b in points] for a in points]
    scale = LARGEST / max(map(max, apart))
    whole = [[int(scale * distance) for distance in row] for row in apart]
    started_s = time.perf_counter()
    order = peer.find_tour(whole, duration_seconds=seconds)
    taken_s = time.perf_counter() - started_s
    return {"order": [int(place) for place in order], "seconds": taken_s}


if __name__ == "__main__":
    asked = json.loads(Path(sys.argv[1]).read_text())
    tours = [tour_through(points, asked["seconds"]) for points in asked["points"]]
    print(json.dumps({"version": version("fast-tsp"), "tours": tours}))
