"""The closest approach of two that move at once, each at a constant velocity or a constant acceleration."""

from __future__ import annotations

import numpy as np

from rota.check.arrays import Floats, Ints

HALVINGS = 60  # of an interval of 0..1, after which float64 has nothing between its ends


def nearest_shares(gap_m: Floats, drift_m: Floats, bow_m: Floats) -> Floats:
    """The shares u (n,) of a time, 0..1, at which a gap is least that is gap + drift u + bow u (u - 1).

    gap_m, drift_m, bow_m: (n, d) vectors: the gap as the time begins, what it changes by, and by how much its way
    bends. Where no bow is, in closed form. Elsewhere the square of the gap is a polynomial of the fourth degree. Its
    slope, of the third, runs one way between the up to two places where it turns, so that halving finds each zero.
    """
    drift2 = (drift_m**2).sum(axis=1)
    shares = np.clip(-(gap_m * drift_m).sum(axis=1) / np.where(drift2 > 0, drift2, 1.0), 0.0, 1.0)
    bent = _gaps_with_bow(bow_m)
    if len(bent):
        shares[bent] = _nearest_of_bent(gap_m[bent], drift_m[bent], bow_m[bent])
    return np.asarray(shares)


def gaps_at(gap_m: Floats, drift_m: Floats, bow_m: Floats, shares: Floats) -> Floats:
    """The gaps (n, d) at shares (n,) of the time; see ``nearest_shares``."""
    gaps = gap_m + shares[:, None] * drift_m
    bent = _gaps_with_bow(bow_m)
    if len(bent):
        gaps[bent] += (shares * (shares - 1))[bent, None] * bow_m[bent]
    return np.asarray(gaps)


def _gaps_with_bow(bow_m: Floats) -> Ints:
    """Which gaps have a bow; most plans have none at all, which is soon seen."""
    return np.flatnonzero(bow_m.any(axis=1)) if bow_m.any() else np.zeros(0, np.int64)


def _nearest_of_bent(gap_m: Floats, drift_m: Floats, bow_m: Floats) -> Floats:
    """The same of gaps that all have a bow."""
    begin = drift_m - bow_m
    # half the slope of the square: c0 + c1 u + c2 u^2 + c3 u^3
    c0, c1 = (gap_m * begin).sum(axis=1), (begin**2).sum(axis=1) + 2 * (gap_m * bow_m).sum(axis=1)
    c2, c3 = 3 * (begin * bow_m).sum(axis=1), 2 * (bow_m**2).sum(axis=1)
    knots = np.stack([np.zeros(len(c0)), *_turning_points(c1, c2, c3), np.ones(len(c0))])
    low, high = knots[:-1].copy(), knots[1:].copy()
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        rises = c0 + middle * (c1 + middle * (c2 + middle * c3)) > 0
        low, high = np.where(rises, low, middle), np.where(rises, middle, high)
    tried = np.vstack([knots, high])
    distances = np.stack([(gaps_at(gap_m, drift_m, bow_m, shares) ** 2).sum(axis=1) for shares in tried])
    return np.asarray(tried[np.argmin(distances, axis=0), np.arange(len(c0))])


def _turning_points(c1: Floats, c2: Floats, c3: Floats) -> tuple[Floats, Floats]:
    """Where c1 u + c2 u^2 + c3 u^3 turns, ascending, put to the nearer end where that is not within 0..1."""
    below = c2**2 - 3 * c1 * c3
    root = np.sqrt(np.maximum(below, 0.0))
    most = -(c2 + np.copysign(root, c2))  # the form whose sum does not cancel
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = np.nan_to_num(most / (3 * c3), nan=0.0), np.nan_to_num(c1 / most, nan=0.0)
    one, other = np.clip(one, 0.0, 1.0), np.clip(other, 0.0, 1.0)
    return np.minimum(one, other), np.maximum(one, other)
