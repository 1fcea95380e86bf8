"""Points that only cut a leg of a curve in two, such as one at which a loop began, or a plan took over."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rota.model.arrays import Floats
from rota.model.trajectory import bends_of

Way = tuple[Floats, Floats, Floats]

CUT_M = 1e-8  # by which a place that only cuts a leg may be off it
ALIKE = 1e-3  # of an acceleration by which two of one curve may differ


def without_cuts(way: Way, points: Sequence[int]) -> Way:
    """A way without those of the points that cut a leg of a curve: times (n,), places (n, d), accelerations (n - 1,).

    A curve is told by tangents, and the jumps of velocity at both ends of one tell how it bends: a half has one of
    them. So such a point stays only where the way without it bends otherwise, as where a curve goes on in a straight.
    """
    cuts = [k for k in points if _cuts(way, k)]
    return np.delete(way[0], cuts), np.delete(way[1], cuts, axis=0), np.delete(way[2], cuts)


def _cuts(way: Way, k: int) -> bool:
    """Whether the k-th point cuts a leg of a curve that the leg before or behind belongs to as well."""
    first = max(0, k - 3)
    near = way[0][first : k + 4], way[1][first : k + 4], way[2][first : k + 3]
    k -= first
    if k < 2 or k > len(near[0]) - 3 or (near[1][k - 1 : k + 2] == near[1][k]).all(axis=1).sum() > 1:
        return False  # nothing tells, or a stay begins or ends there, maybe on a charger
    joined = np.delete(near[0], k), np.delete(near[1], k, axis=0), np.delete(near[2], k)
    (begin_s, at_s, end_s), (begin_m, at_m, end_m) = near[0][k - 1 : k + 2], near[1][k - 1 : k + 2]
    share = (at_s - begin_s) / (end_s - begin_s)
    along = share + bends_of(*joined)[k - 1] * share * (share - 1)
    if np.abs(begin_m + along * (end_m - begin_m) - at_m).max() > CUT_M:
        return False
    bent_m_s2 = _accelerations(*joined)
    whole, parts = bent_m_s2[k - 2], _accelerations(*near)[k - 2 : k]
    beside = [bent_m_s2[leg] for leg in (k - 3, k - 1) if 0 <= leg < len(bent_m_s2)]
    return any(_alike(whole, each) for each in beside) and not all(_alike(part, whole) for part in parts)


def _accelerations(times_s: Floats, places_m: Floats, changes_m_s2: Floats) -> Floats:
    """What all legs but the first and last are accelerated by (n - 3, d): the jumps at their ends count half."""
    lasts_s = np.diff(times_s)[:, None]
    mean_m_s = np.diff(places_m, axis=0) / lasts_s
    half_m_s = mean_m_s * bends_of(times_s, places_m, changes_m_s2)[:, None]
    at_m_s = (mean_m_s[:-1] + half_m_s[:-1] + mean_m_s[1:] - half_m_s[1:]) / 2
    return np.asarray(np.diff(at_m_s, axis=0) / lasts_s[1:-1])


def _alike(one: Floats, other: Floats) -> bool:
    """Whether two accelerations (d,) may be those of one curve."""
    return bool(np.abs(one - other).max() <= ALIKE * np.abs(other).max())
