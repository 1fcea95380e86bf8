"""Plans for one tile of a square kilometre with four blocks, and for five by two of them: cost against area."""

from __future__ import annotations

import functools
import json
import math
from collections.abc import Iterator
from pathlib import Path

from benchmarks.planning import Planned, plan_and_check, told
from benchmarks.row import Options, Row
from benchmarks.warm_cache import measured_warm

TILE_M = 1000.0
CORNERS = ((0.2, 0.2), (0.7, 0.2), (0.2, 0.7), (0.7, 0.7))  # lower left corners of the blocks, of a tile's side
BLOCK = 0.08  # side of a block, of a tile's side
RADIUS_M, SPEED_M_S, PERIOD_S = 10.0, 15.0, 600.0
COLUMNS, ROWS = 5, 2
PATIENCE_S = 2 * 3600.0
MOST_GROWTH = 1.2
# robots, seconds, bytes asked for
ONE, TEN = (7, 120.0, 2e9), (70, 900.0, 4e9)


def write_tiles(columns: int, rows: int, tile_m: float, folder: Path) -> Path:
    """Write the mission over so many tiles side by side and one above the other."""
    wide_m, high_m = columns * tile_m, rows * tile_m
    mission = {
        "rota": 1,
        "name": f"tiles-{columns}x{rows}",
        "area": [[0, 0], [wide_m, 0], [wide_m, high_m], [0, high_m]],
        "obstacles": [
            block_ring(column + x, row + y, tile_m)
            for column in range(columns)
            for row in range(rows)
            for x, y in CORNERS
        ],
        "period_s": PERIOD_S,
        "fleet": {"speed_m_s": SPEED_M_S, "sensor": {"shape": "disc", "radius_m": RADIUS_M}},
    }
    path = folder / f"tiles-{columns}x{rows}-{tile_m:g}.json"
    path.write_text(json.dumps(mission))
    return path


def block_ring(x: float, y: float, tile_m: float) -> list[list[float]]:
    """The ring of the block whose lower left corner is (x, y), in tiles; metres."""
    left_m, bottom_m = round(x * tile_m, 6), round(y * tile_m, 6)
    right_m, top_m = round((x + BLOCK) * tile_m, 6), round((y + BLOCK) * tile_m, 6)
    return [[left_m, bottom_m], [right_m, bottom_m], [right_m, top_m], [left_m, top_m]]


def one_tile(options: Options) -> Iterator[Row]:
    """One square kilometre."""
    yield _row(planned(1, 1, options), 1, options, ONE)


def ten_tiles(options: Options) -> Iterator[Row]:
    """Ten square kilometres, and how the planner's time grew with the area."""
    large = planned(COLUMNS, ROWS, options)
    yield _row(large, COLUMNS * ROWS, options, TEN)
    yield growth_row(planned(1, 1, options), large, options)


@functools.cache
def planned(columns: int, rows: int, options: Options) -> Planned:
    """Plan and check so many tiles; measured once, although two figures may ask for it."""
    mission = write_tiles(columns, rows, options.tile_m, options.folder)
    (found,) = measured_warm(
        lambda: plan_and_check(mission, options.folder, effort=options.effort, patience_s=PATIENCE_S),
        lambda run: run.wall_s,
        repeats=1,
    )
    return found


def _row(found: Planned, tiles: int, options: Options, goal: tuple[int, float, float]) -> Row:
    robots, seconds, size = goal
    measured = f"{told([found])}; CPU {found.cpu_s:.0f} s"
    name = f"{tiles} km2 with {4 * tiles} blocks, r = 10 m, {options.effort}"
    if options.tile_m != TILE_M:  # for a quick look: nothing is asked of other tiles
        name = f"{tiles} tiles of {options.tile_m:g} m, r = 10 m, {options.effort}"
        return Row(name, "met", measured, found.met)
    asked = f"met, at most {robots} robots, < {seconds:.0f} s, < {size / 1e9:.0f} GB"
    reached = found.met and found.report["robots"] <= robots and found.plan.wall_s < seconds and found.peak_bytes < size
    return Row(name, asked, measured, reached)


def growth_row(small: Planned, large: Planned, options: Options) -> Row:
    """The exponent by which planning time grows with area: log of the ratio of times over that of areas."""
    tiles = COLUMNS * ROWS
    name = f"growth of planning time from 1 to {tiles} tiles of {options.tile_m:g} m, {options.effort}"
    asked = f"exponent at most {MOST_GROWTH}"
    if not (small.met and large.met):
        return Row(name, asked, "not known: a plan is missing", False)
    exponent = math.log(large.plan.wall_s / small.plan.wall_s) / math.log(tiles)
    measured = f"exponent {exponent:.2f} ({small.plan.wall_s:.1f} s to {large.plan.wall_s:.1f} s)"
    return Row(name, asked, measured, exponent <= MOST_GROWTH)
