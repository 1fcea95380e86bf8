"""Heights of the ground under a mission: a GeoTIFF, which says where it lies, or a PNG spread over the area."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rota.errors import MissionError
from rota.files.raster_map import Site, read_raster
from rota.model.arrays import Floats
from rota.model.mission import Mission

HIGHEST_M = 12_000.0  # from the deepest sea or to the highest mountain, and some more


@dataclass(frozen=True, eq=False)
class HeightMap:
    """Heights in metres at the places of a grid over a mission's area, (rows, columns), the southern row first.

    low_m: (x, y) of the first place; step_m: (x, y) between places. Calling it gives the height at (x, y), straight
    between the four places round it, and that of the rim beyond the rim.
    """

    heights_m: Floats
    low_m: tuple[float, float]
    step_m: tuple[float, float]

    def __call__(self, x: float, y: float) -> float:
        """Height in metres of the ground at a place."""
        rows, columns = self.heights_m.shape
        i = min(max((x - self.low_m[0]) / self.step_m[0], 0.0), columns - 1.0)
        j = min(max((y - self.low_m[1]) / self.step_m[1], 0.0), rows - 1.0)
        i0, j0 = min(int(i), columns - 2), min(int(j), rows - 2)
        a, b = i - i0, j - j0
        below, above = self.heights_m[j0, i0 : i0 + 2], self.heights_m[j0 + 1, i0 : i0 + 2]
        return float((1 - b) * ((1 - a) * below[0] + a * below[1]) + b * ((1 - a) * above[0] + a * above[1]))


def read_height_map(path: str, mission: Mission, heights: str | None = None) -> HeightMap:
    """The heights of the ground under a mission's area.

    heights: LOW,HIGH in metres, which black and white stand for; a PNG, whose picture is spread over the area's
    bounding box with north up, needs them. A GeoTIFF holds metres unless they are given; it lies in the reference
    system that it names, for which the mission needs an origin, or in the mission's metres where it names none. Raises
    MissionError for other files, for damaged ones, and where the area is not covered or heights are out of range.
    """
    scale = None if heights is None else _scale_of(heights)
    unscaled = "--heights LOW,HIGH is needed: a PNG does not say what black and white stand for"
    raster = read_raster(Path(path), Site(mission.area.bounds, mission.origin), scale, "heights", unscaled)
    if not (np.abs(raster.values) <= HIGHEST_M).all():
        raise MissionError(
            f"{path}: heights of up to {np.abs(raster.values).max():.6g} m; at most {HIGHEST_M:g} are allowed"
        )
    return HeightMap(*raster)


def _scale_of(heights: str) -> tuple[float, float]:
    """LOW,HIGH as numbers; MissionError for other text."""
    try:
        low, high = (float(part) for part in heights.split(","))
    except ValueError:
        low = high = math.nan
    if not (abs(low) <= HIGHEST_M and abs(high) <= HIGHEST_M):
        raise MissionError(
            f"--heights: {heights!r} is not allowed; LOW,HIGH in metres is needed, within {HIGHEST_M:g} of 0"
        )
    return low, high
