"""How far segments are from each other, and from points."""

from __future__ import annotations

import numpy as np

from rota.check.arrays import Floats


def segment_distances(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """Distance of segments a and b (n, 4), row by row, and where along a it is reached, in 0..1; 0 if they cross."""
    p, d = a[:, :2], a[:, 2:] - a[:, :2]
    q, e = b[:, :2], b[:, 2:] - b[:, :2]
    best, where = np.full(len(a), np.inf), np.zeros(len(a))
    for point, at in ((p, 0.0), (a[:, 2:], 1.0)):
        gap = point_distances(point, q, e)[0]
        where = np.where(gap < best, at, where)
        best = np.minimum(best, gap)
    for point in (q, b[:, 2:]):
        gap, u = point_distances(point, p, d)
        where = np.where(gap < best, u, where)
        best = np.minimum(best, gap)
    turn = d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        u = ((q - p)[:, 0] * e[:, 1] - (q - p)[:, 1] * e[:, 0]) / turn
        v = ((q - p)[:, 0] * d[:, 1] - (q - p)[:, 1] * d[:, 0]) / turn
    cross = (turn != 0) & (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
    return np.where(cross, 0.0, best), np.where(cross, u, where)


def point_distances(point: Floats, start: Floats, along: Floats) -> tuple[Floats, Floats]:
    """Distance (n,) of points from segments, all (n, 2), and where along the segments it is reached, (n,) in 0..1."""
    length2 = (along**2).sum(axis=1)
    u = ((point - start) * along).sum(axis=1) / np.where(length2 > 0, length2, 1.0)
    u = np.clip(u, 0.0, 1.0)
    rest = point - start - u[:, None] * along
    return np.hypot(rest[:, 0], rest[:, 1]), u
