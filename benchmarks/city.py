"""A city made by chance: streets between lots, and on each lot a building, many of them round a courtyard."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.planning import Planned, plan_and_check, told
from benchmarks.row import Options, Row

SPEED_M_S, RADIUS_M, PERIOD_S = 10.0, 15.0, 600.0
WIDEST_STREET_M, NARROWEST_STREET_M = 30.0, 14.0  # avenues cut the city first, alleys last
NARROWER = 0.85  # each cut's street is so much as wide as the one before
WING_M = (12.0, 18.0)  # how deep the wings of a building are
GATE_M = 9.0  # the way into a courtyard
SETBACK_M = (1.0, 6.0)  # between a lot's border and its building
TURNED_DEG = 4.0  # a building stands at most so far askew

PATIENCE_S = 3600.0
MOST_S, MOST_BYTES, MOST_GROWTH = 600.0, 4e9, 1.2

Lot = tuple[float, float, float, float]  # x0, y0, x1, y1 in metres
Ring = list[tuple[float, float]]


@dataclass(frozen=True, kw_only=True)
class City:
    """How large a city is, twice as wide as high, and how many buildings stand in it."""

    area_km2: float
    buildings: int

    @property
    def name(self) -> str:
        """What files about it are called."""
        return f"city-{self.area_km2:g}-{self.buildings}"


LARGER = tuple(City(area_km2=area_km2, buildings=round(40 * area_km2)) for area_km2 in (1.25, 2.5, 5.0, 10.0))
DENSER = tuple(City(area_km2=5.0, buildings=buildings) for buildings in (50, 100, 200, 400))


def city(options: Options) -> Iterator[Row]:
    """Cities made by chance, and how the processor time of plan and check grows with area and with buildings."""
    found = {each: _planned(each, options) for each in dict.fromkeys([*LARGER, *DENSER])}
    largest = found[LARGER[-1]]
    measured = f"{told([largest])}; CPU {largest.cpu_s:.0f} s"
    reached = largest.met and largest.wall_s < MOST_S and largest.peak_bytes < MOST_BYTES
    yield Row("city of 10 km2 with 400 buildings, r = 15 m, quick", "met in < 600 s, < 4 GB", measured, reached)
    yield _growth("area, 1.25 to 10 km2 with 40 buildings each", [(c.area_km2, found[c]) for c in LARGER])
    yield _growth("buildings, 50 to 400 on 5 km2", [(c.buildings, found[c]) for c in DENSER])


def _planned(each: City, options: Options) -> Planned:
    return plan_and_check(write_city(each, 0, options.folder), options.folder, patience_s=PATIENCE_S)


def _growth(what: str, runs: Sequence[tuple[float, Planned]]) -> Row:
    """The slope of the straight line through the logarithms of size and processor time."""
    name, asked = f"growth with {what}, quick", f"exponent at most {MOST_GROWTH}"
    if not all(run.met for _, run in runs):
        return Row(name, asked, "not known: a plan is missing", False)
    sizes, seconds = [size for size, _ in runs], [run.cpu_s for _, run in runs]
    exponent = float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])
    measured = f"exponent {exponent:.2f} (CPU {', '.join(f'{each:.0f}' for each in seconds)} s)"
    return Row(name, asked, measured, exponent <= MOST_GROWTH)


def write_city(city: City, seed: int, folder: Path) -> Path:
    """Write the mission over such a city; its path.

    Any number of robots of 10 m/s, with discs of 15 m, for a period of 600 s; buildings block motion and sight.
    """
    high_m = math.sqrt(1e6 * city.area_km2 / 2)
    mission = {
        "rota": 1,
        "name": city.name,
        "area": [[0, 0], [2 * high_m, 0], [2 * high_m, high_m], [0, high_m]],
        "obstacles": drawn_buildings(2 * high_m, high_m, city.buildings, np.random.default_rng(seed)),
        "period_s": PERIOD_S,
        "fleet": {"speed_m_s": SPEED_M_S, "sensor": {"shape": "disc", "radius_m": RADIUS_M}},
    }
    path = folder / f"{city.name}.json"
    path.write_text(json.dumps(mission))
    return path


def drawn_buildings(wide_m: float, high_m: float, count: int, rng: np.random.Generator) -> list[Ring]:
    """The outlines of so many buildings in a city of that size, metres."""
    lots = _lots((0.0, 0.0, wide_m, high_m), count, WIDEST_STREET_M, rng)
    return [_building(lot, rng) for lot in lots]


def _lots(lot: Lot, count: int, street_m: float, rng: np.random.Generator) -> list[Lot]:
    """So many lots with streets between them, by cutting the longer side again and again."""
    if count == 1:
        return [lot]
    x0, y0, x1, y1 = lot
    first = count // 2
    share = first / count * rng.uniform(0.9, 1.1)
    narrower_m = max(NARROWEST_STREET_M, NARROWER * street_m)
    if x1 - x0 >= y1 - y0:
        at = x0 + share * (x1 - x0)
        halves: tuple[Lot, Lot] = (x0, y0, at - street_m / 2, y1), (at + street_m / 2, y0, x1, y1)
    else:
        at = y0 + share * (y1 - y0)
        halves = (x0, y0, x1, at - street_m / 2), (x0, at + street_m / 2, x1, y1)
    return [*_lots(halves[0], first, narrower_m, rng), *_lots(halves[1], count - first, narrower_m, rng)]


def _building(lot: Lot, rng: np.random.Generator) -> Ring:
    """A block, an L, a U or a courtyard with a gate, turned and a little askew, well inside its lot."""
    x0, y0, x1, y1 = lot
    back_m = rng.uniform(*SETBACK_M)
    half_x, half_y = (x1 - x0) / 2 - back_m, (y1 - y0) / 2 - back_m
    wing_m = min(rng.uniform(*WING_M), 0.6 * min(half_x, half_y))
    kind = rng.choice(["courtyard", "u", "l", "block"], p=[0.4, 0.2, 0.2, 0.2])
    turn = math.radians(rng.uniform(-TURNED_DEG, TURNED_DEG))
    shrink = 1 / (math.cos(turn) + math.sin(abs(turn)) * max(half_x / half_y, half_y / half_x))
    if kind == "block":
        half_x, half_y = half_x * rng.uniform(0.5, 1.0), half_y * rng.uniform(0.5, 1.0)
    ring = _outline(kind, half_x, half_y, wing_m)
    flip = rng.choice([-1, 1], 2)
    corners = shrink * flip * np.array(ring)
    spin = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    placed = corners @ spin + [(x0 + x1) / 2, (y0 + y1) / 2]
    return [(round(float(x), 3), round(float(y), 3)) for x, y in placed]


def _outline(kind: str, a: float, b: float, wing_m: float) -> Ring:
    """The outline of a building of half sides a and b round the origin."""
    if kind == "block":
        return [(-a, -b), (a, -b), (a, b), (-a, b)]
    if kind == "l":
        return [(-a, -b), (a, -b), (a, -b + wing_m), (-a + wing_m, -b + wing_m), (-a + wing_m, b), (-a, b)]
    c, d = a - wing_m, b - wing_m
    gate_m = GATE_M / 2 if kind == "courtyard" else c
    return [
        (-a, -b), (a, -b), (a, b), (gate_m, b), (gate_m, d), (c, d), (c, -d), (-c, -d), (-c, d), (-gate_m, d),
        (-gate_m, b), (-a, b),
    ] if kind == "courtyard" else [(-a, -b), (a, -b), (a, b), (c, b), (c, -d), (-c, -d), (-c, b), (-a, b)]  # fmt: skip
