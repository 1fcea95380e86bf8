"""How much of the ground's importance robots have in range where they hold; only told, not judged."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from rota.model.mission import ImportanceMap, Mission

PLACES = 2**19  # at which the ground is asked


def importance_in_range(mission: Mission, ground: BaseGeometry, in_range: BaseGeometry) -> float | None:
    """The share of a ground's importance that lies in a shape, by places of a lattice; None where none is stated.

    A zone's importance replaces the ground's, a number or a map that goes straight between its places; of several
    zones the largest counts. 0 where nothing is worth anything.
    """
    zones = [(zone.importance, zone.shape) for zone in mission.zones if zone.importance is not None]
    if mission.importance is None and not zones:
        return None
    left, bottom, right, top = shapely.bounds(ground)
    step_m = max(np.sqrt((right - left) * (top - bottom) / PLACES), max(right - left, top - bottom) / PLACES)
    x, y = (
        part.ravel()
        for part in np.meshgrid(
            np.arange(left + step_m / 2, right, step_m), np.arange(bottom + step_m / 2, top, step_m)
        )
    )
    shapely.prepare([ground, in_range, *(shape for _, shape in zones)])
    there = shapely.contains_xy(ground, x, y)
    x, y = x[there], y[there]
    worth, told = np.ones(len(x)), mission.importance
    if isinstance(told, ImportanceMap):
        (x0, y0), (across, up), (rows, columns) = told.low_m, told.step_m, told.values.shape
        i, j = np.clip((x - x0) / across, 0, columns - 1), np.clip((y - y0) / up, 0, rows - 1)
        west, south = np.floor(i).astype(int), np.floor(j).astype(int)
        east, north = np.ceil(i).astype(int), np.ceil(j).astype(int)
        below = told.values[south, west] + (i - west) * (told.values[south, east] - told.values[south, west])
        above = told.values[north, west] + (i - west) * (told.values[north, east] - told.values[north, west])
        worth = below + (j - south) * (above - below)
    elif told is not None:
        worth *= told
    if zones:
        largest = np.max([np.where(shapely.contains_xy(shape, x, y), value, -1.0) for value, shape in zones], axis=0)
        worth = np.where(largest >= 0, largest, worth)
    whole = float(worth.sum())
    return float(worth[shapely.contains_xy(in_range, x, y)].sum()) / whole if whole > 0 else 0.0
