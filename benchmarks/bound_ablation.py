"""Which proofs the lower bound needs: ``python -m benchmarks.bound_ablation``.

Lays out missions of five kinds, and proves the bound of each with all proofs and without each, one at a time. A proof
decides where the bound falls without it. Prints a table: kinds of missions, and where each proof decides.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from multiprocessing import get_context
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from shapely import MultiPolygon, box

from benchmarks.cyclic_visits import random_places
from benchmarks.known_plans import known_plan
from benchmarks.missions import example_missions
from benchmarks.plan_hashes import mission_of
from benchmarks.random_missions import random_mission
from benchmarks.sun_cases import CASES, FIGURE_16
from rota.errors import NoPlanFound
from rota.model.anywhere import without_starts
from rota.model.mission import Demand, DiscSensor, Fleet, Mission, Zone
from rota.planners.patrol.bounds import best_bound
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.ground.problem import set_up_problem

NOTHING = ProvedBound(robots=0, reason="left out")
PROOFS: dict[str, tuple[str, Any]] = {
    "rates, disc by disc": ("area_rate", (0.0, 0.0)),
    "rates, with borders": ("swept_robots", (0.0, 0.0)),
    "straight chains": ("straight_chain_bound", NOTHING),
    "chains": ("chain_bound", NOTHING),
    "forests": ("forest_bound", NOTHING),
    "components": ("_by_components", NOTHING),
    "visits": ("visits_bound", ()),
    "tours": ("tour_bound", NOTHING),
}


def scattered_zones(seed: int, *, few: bool) -> Mission:
    """Zones on wide open ground: two to six large ones far apart, or 12 to 60 small ones, most of them to visit."""
    rng = np.random.default_rng(seed)
    wide_m, high_m, reach_m, speed_m_s = rng.uniform((100, 40, 4, 1), (600, 300, 10, 8))
    count = int(rng.integers(2, 7) if few else rng.integers(12, 60))
    # what a shortest closed way past so many places is about
    tour_m, team = 0.7 * math.sqrt(count * wide_m * high_m), rng.uniform(2, 5)
    zones: list[Zone] = []
    for k in range(count):
        across_m = rng.uniform(10, 60, 2) if few else np.full(2, 2.0)
        at_m = rng.uniform(0, np.maximum(1.0, np.array([wide_m, high_m]) - across_m))
        shape = MultiPolygon([box(*at_m, *np.minimum(at_m + across_m, [wide_m, high_m]))])
        if any(zone.shape.intersects(shape) for zone in zones):
            continue
        period_s = (shape.area / (2 * reach_m * rng.uniform(0.3, 2.2)) if few else tour_m / team) / speed_m_s
        demand: Demand = "visit" if rng.random() < (0.15 if few else 0.7) else "every_point"
        zones.append(Zone(name=f"z{k}", shape=shape, period_s=float(period_s), demand=demand))
    fleet = Fleet(speed_m_s=float(speed_m_s), sensor=DiscSensor(radius_m=float(reach_m)))
    area = MultiPolygon([box(0, 0, wide_m, high_m)])
    return Mission(name=f"scattered-{seed}", area=area, zones=tuple(zones), fleet=fleet)


def example_mission(name: str) -> Mission:
    """An example or a published case by its name."""
    with tempfile.TemporaryDirectory() as folder:
        return mission_of(name, Path(folder))


KINDS: dict[str, tuple[Callable[[Any], Mission], list[Any]]] = {
    "random": (random_mission, list(range(100))),
    "cases and examples": (
        example_mission,
        [*(f"case/{case.name}" for case in (*CASES, FIGURE_16)), *(f"examples/{p.name}" for p in example_missions())],
    ),
    "round known plans": (lambda seed: known_plan(seed).mission, list(range(150))),
    "few zones far apart": (lambda seed: scattered_zones(seed, few=True), list(range(60))),
    "places to visit": (lambda seed: random_places(seed, ("deadlines", "latencies")[seed % 2]), list(range(100))),
    "many small zones": (lambda seed: scattered_zones(seed, few=False), list(range(60))),
}


def deciding(task: tuple[str, Any]) -> tuple[str, list[str] | None]:
    """The kind, and the proofs without which the bound falls; None for a mission that no tours are planned for."""
    kind, which = task
    mission = KINDS[kind][0](which)
    if mission.planning.planner != "patrol":
        return kind, None
    try:
        problem = set_up_problem(without_starts(mission))
    except NoPlanFound:
        return kind, None
    whole = best_bound.prove_bound(problem).robots
    proofs = []
    for name, (function, nothing) in PROOFS.items():
        with patch.object(best_bound, function, lambda *_, nothing=nothing, **__: nothing):
            if best_bound.prove_bound(problem).robots < whole:
                proofs.append(name)
    return kind, proofs


def tasks() -> Iterator[tuple[str, Any]]:
    """All missions."""
    for kind, (_, which) in KINDS.items():
        yield from ((kind, each) for each in which)


def main(arguments: list[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.bound_ablation", description=__doc__.splitlines()[0])
    parser.add_argument("kinds", nargs="*", metavar="KIND", help="some kinds of missions only")
    parser.add_argument("--processes", type=int, default=os.cpu_count(), metavar="N")
    chosen = parser.parse_args(arguments)
    missions: Counter[str] = Counter()
    decides: Counter[tuple[str, str]] = Counter()
    with get_context("fork").Pool(chosen.processes) as pool:
        for kind, proofs in pool.imap_unordered(
            deciding, [task for task in tasks() if not chosen.kinds or task[0] in chosen.kinds]
        ):
            missions[kind] += proofs is not None
            decides.update((name, kind) for name in proofs or ())
    print("| proof | " + " | ".join(KINDS) + " |")
    print("|---|" + "---:|" * len(KINDS))
    print("| missions | " + " | ".join(str(missions[kind]) for kind in KINDS) + " |")
    for name in PROOFS:
        print(f"| {name} | " + " | ".join(str(decides[name, kind]) for kind in KINDS) + " |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
