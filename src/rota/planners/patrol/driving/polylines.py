"""Closed polylines: their turns, and what of them can be timed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SHORTEST_LEG_M = 1e-6  # shorter legs are left out: they would be timed to fewer digits than the check asks


def turns_rad(vertices_m: Floats) -> Floats:
    """Angle (n,) by which the direction changes at each vertex of a closed polyline; 0 for one vertex."""
    if len(vertices_m) < 2:
        return np.zeros(len(vertices_m))
    after = np.roll(vertices_m, -1, axis=0) - vertices_m
    before = np.roll(after, 1, axis=0)
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.asarray(np.abs(np.arctan2(cross, (before * after).sum(axis=1))))


def without_repeats(vertices_m: Floats) -> Floats:
    """The closed polyline without vertices that repeat the one before; at least one vertex stays."""
    keep = (np.roll(vertices_m, 1, axis=0) != vertices_m).any(axis=1)
    if not keep[0]:  # the first vertex stays what it is: it may be where a nest's tours meet
        keep[np.flatnonzero(keep)[-1:]] = False
        keep[0] = True
    return np.asarray(vertices_m[keep])


def split_legs(vertices_m: Floats, longest_m: float) -> Floats:
    """The closed polyline with legs longer than ``longest_m`` cut into equal pieces."""
    ends = np.roll(vertices_m, -1, axis=0)
    legs = np.hypot(*(ends - vertices_m).T)
    pieces = np.maximum(1, np.ceil(legs / (longest_m * (1 - 1e-9)))).astype(np.int64)
    which = np.repeat(np.arange(len(vertices_m)), pieces)
    step = (np.arange(len(which)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[which]
    return np.asarray(vertices_m[which] + step[:, None] * (ends - vertices_m)[which])


def timeable(vertices_m: Floats) -> Floats:
    """The closed polyline without repeats and without legs too short to be timed; the first vertex stays."""
    vertices_m = without_repeats(vertices_m)
    keep = far_enough(vertices_m)
    while len(keep) > 1 and np.hypot(*(vertices_m[keep[-1]] - vertices_m[0])) < SHORTEST_LEG_M:
        keep.pop()
    return vertices_m[keep]


def far_enough(points_m: Floats) -> list[int]:
    """The numbers of the points (n, 2), from the first on, that end legs long enough to be timed."""
    keep = [0]
    for i in range(1, len(points_m)):
        if np.hypot(*(points_m[i] - points_m[keep[-1]])) >= SHORTEST_LEG_M:
            keep.append(i)
    return keep


def thinned(vertices_m: Floats) -> Floats:
    """The closed polyline as it can be timed, without vertices along straights."""
    vertices_m = timeable(vertices_m)
    bends = turns_rad(vertices_m) > 1e-12
    return vertices_m[bends] if bends.sum() >= 2 else vertices_m
