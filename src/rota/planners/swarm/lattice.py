"""Starts where random places do not all fit: a lattice of them, shaken by what room it leaves."""

from __future__ import annotations

import math

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from rota.model.arrays import Flags, Floats

MOST_PLACES = 1_000_000
LOOSENINGS = 40  # halvings of what the spacing may still be
ON_THE_BORDER_M = 1e-9


def lattice_starts(
    room: BaseGeometry, taken_m: Floats, taken_radii_m: Floats, *, count: int, radius_m: float, rng: np.random.Generator
) -> tuple[Floats, int]:
    """Places (count, 2) in a room for bodies of one radius that touch nothing, or none; and how many bodies fit.

    room: where centres may be. taken_m, taken_radii_m: (k, 2) and (k,) bodies that stand there already. The lattices
    are triangular, in both directions, and square. The widest spacing that holds enough is taken. Places are drawn from
    it, and each is shaken by no more than half of the room between neighbours.
    """
    shapely.prepare(room)  # it is asked for every place of every lattice
    x0, y0, x1, y1 = room.bounds
    # tiny bodies in a huge room have more places than anybody needs
    fine_m = max(math.sqrt((x1 - x0) * (y1 - y0) / MOST_PLACES), (x1 - x0 + y1 - y0) / MOST_PLACES)
    least_m = max(2 * radius_m, 1e-6, fine_m) * (1 + 1e-12)

    def fitting(spacing_m: float) -> Floats:
        """The most places with this spacing."""
        return max((_places(room, taken_m, taken_radii_m + radius_m, spacing_m, k) for k in range(3)), key=len)

    tight = fitting(least_m)
    if len(tight) < count:
        return np.empty((0, 2)), len(tight)
    low_m, high_m, best = least_m, least_m + math.hypot(x1 - x0, y1 - y0), tight
    for _ in range(LOOSENINGS):
        middle_m = (low_m + high_m) / 2
        lattice = fitting(middle_m)
        if len(lattice) >= count:
            low_m, best = middle_m, lattice
        else:
            high_m = middle_m
    places = best[np.sort(rng.permutation(len(best))[:count])]
    angle, away = rng.uniform(0, 2 * math.pi, count), (low_m / 2 - radius_m) * np.sqrt(rng.uniform(0, 1, count))
    shaken = places + away[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ok = _clear(room, taken_m, taken_radii_m + radius_m, shaken)
    return rng.permutation(np.where(ok[:, None], shaken, places)), len(tight)


def _places(room: BaseGeometry, taken_m: Floats, apart_m: Floats, spacing_m: float, kind: int) -> Floats:
    """Points (p, 2) of a lattice from the room's lower left; kind 0: rows shifted by halves, 1: columns, 2: square."""
    x0, y0, x1, y1 = room.bounds
    width, height = (y1 - y0, x1 - x0) if kind == 1 else (x1 - x0, y1 - y0)
    rise_m = spacing_m * (1.0 if kind == 2 else math.sqrt(3) / 2 * (1 + 1e-12))
    columns, rows = (int(length / step + 1e-9) + 1 for length, step in ((width, spacing_m), (height, rise_m)))
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    u, v = spacing_m * (i + (0.0 if kind == 2 else 0.5) * (j % 2)), rise_m * j
    points = np.stack([v, u] if kind == 1 else [u, v], axis=-1).reshape(-1, 2) + np.array([x0, y0])
    return np.asarray(points[_clear(room, taken_m, apart_m, points)])


def _clear(room: BaseGeometry, taken_m: Floats, apart_m: Floats, points_m: Floats) -> Flags:
    """Which points (n, 2) lie in the room and as far from each taken place (k, 2) as asked, (k,)."""
    ok = np.asarray(shapely.dwithin(room, shapely.points(points_m), ON_THE_BORDER_M))
    for place, least_m in zip(taken_m, apart_m, strict=True):
        ok &= np.hypot(*(points_m - place).T) >= least_m
    return ok
