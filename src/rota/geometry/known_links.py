"""What the links between corners of one space tell of those of another that differs from it in a few places."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.sparse import csr_array

from rota.geometry.corner_kernels import KnownLinks
from rota.model.arrays import Floats

NEAR_CHANGE_M = 0.01  # of a changed border: within it all is looked at anew


def known_links(corners: Floats, others: Floats, links: csr_array, changed_m: Floats) -> KnownLinks:
    """What is known of the links between corners (c, 7) from the links (d, d) between others (d, 7).

    A row tells all that a link depends on, space aside: the places of a corner and of its neighbours, and its part.
    changed_m: the boxes that hold all in which the two spaces differ.
    """
    number_of = {row.tobytes(): k for k, row in enumerate(others)}
    old = np.array([number_of.get(row.tobytes(), -1) for row in corners], dtype=np.int64)
    new_of = np.full(len(others), -1, dtype=np.int64)
    new_of[old[old >= 0]] = np.flatnonzero(old >= 0)
    rows = links[np.maximum(old, 0)]  # those of new corners are left out below
    one, other = np.repeat(np.arange(len(old)), np.diff(rows.indptr)), new_of[rows.indices]
    kept = (old[one] >= 0) & (other >= 0)
    start = np.concatenate([[0], np.cumsum(np.bincount(one[kept], minlength=len(old)))]).astype(np.int64)
    return KnownLinks(old >= 0, start, np.ascontiguousarray(other[kept]), changed_m)


def nothing_known(corners: int) -> KnownLinks:
    """What is known of the links of so many corners when none were looked for before."""
    nothing = np.zeros(0, dtype=np.int64)
    return KnownLinks(np.zeros(corners, dtype=np.bool_), np.zeros(corners + 1, np.int64), nothing, np.zeros((0, 4)))


def boxes_of_change(edges: Floats, others: Floats) -> Floats:
    """Boxes (b, 4) round all edges (n, 4) and (m, 4) that only one of two borders has, those near each other in one."""
    rows, counts = np.unique(np.vstack([edges, others]), axis=0, return_counts=True)
    changed = shapely.linestrings(rows[counts == 1].reshape(-1, 2, 2))
    blobs = shapely.get_parts(shapely.union_all(shapely.envelope(shapely.buffer(changed, NEAR_CHANGE_M))))
    return np.ascontiguousarray(shapely.bounds(blobs).reshape(-1, 4))
