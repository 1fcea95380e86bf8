"""What refining shows of one demand, and what nobody can see of it, in connected parts."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from rota.check.arrays import Floats, Ints

MOST_PLACES = 8


@dataclass
class Findings:
    """What refining shows of one demand: gaps in seconds, areas in square metres (see DemandVerdict).

    worst_place_m None: no gap is shown too long. excluded: (k, 4) rows x, y, area and size of pieces nobody can see.
    """

    upper_s: float = 0.0
    lower_s: float = 0.0
    first_s: float = 0.0
    worst_s: float = 0.0
    worst_begin_s: float = math.nan
    worst_place_m: tuple[float, float] | None = None
    unseen_area_m2: float = 0.0
    excluded_area_m2: float = 0.0
    undecided_cells: int = 0
    excluded: list[Floats] = field(default_factory=list)
    unmet: list[Floats] = field(default_factory=list)
    shown: list[Floats] = field(default_factory=list)

    def unmet_points_m(self) -> Floats:
        """(n, 2) corners and middles of all pieces not shown met, and the worst place (its piece may be excluded)."""
        worst = [] if self.worst_place_m is None else [np.array([self.worst_place_m])]
        return _distinct([*self.unmet, *worst])

    def shown_unmet_m(self) -> Floats:
        """(n, 2) places that were looked at by themselves and are unmet: many of the others may yet be met."""
        return _distinct(self.shown)

    def excluded_places(self) -> list[tuple[float, float, float]]:
        """(x, y, area) of the largest connected parts that nobody can see; the place is in the part."""
        rows = np.vstack([np.empty((0, 4)), *self.excluded])
        if not len(rows):
            return []
        low = rows[:, :2].min(axis=0)
        size = max(float(rows[:, 3].max()), float((rows[:, :2].max(axis=0) - low).max()) / 1000)
        bins = ((rows[:, :2] - low) / size).astype(np.int64)
        label = _connected_bins(bins)
        places = []
        for k in range(label.max() + 1):
            part = rows[label == k]
            x, y = part[np.argmax(part[:, 2]), :2]
            places.append((float(x), float(y), float(part[:, 2].sum())))
        return sorted(places, key=lambda place: -place[2])[:MOST_PLACES]


def _distinct(places_m: list[Floats]) -> Floats:
    """All places (n, 2) once, in order; ``np.unique`` of rows takes ten times as long."""
    points = np.vstack([np.empty((0, 2)), *places_m])
    points = points[np.lexsort((points[:, 1], points[:, 0]))]
    other = np.ones(len(points), np.bool_)
    other[1:] = (points[1:] != points[:-1]).any(axis=1)
    return points[other]


def _connected_bins(bins: Ints) -> Ints:
    """(n,) number of the part of each bin (n, 2); bins that share a side or a corner are in one part."""
    # a good part of the time that starting takes, and few plans leave out any ground
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    kinds, kind_of = np.unique(bins, axis=0, return_inverse=True)
    index = np.full(kinds.max(axis=0) + 3, -1)
    index[kinds[:, 0] + 1, kinds[:, 1] + 1] = np.arange(len(kinds))
    x, y = kinds.T + 1
    near = [np.column_stack([index[x, y], index[x + i, y + j]]) for i, j in ((1, 0), (0, 1), (1, 1), (1, -1))]
    links = np.vstack(near)
    links = links[links[:, 1] >= 0]
    graph = coo_array((np.ones(len(links)), links.T), shape=(len(kinds), len(kinds)))
    labels: Ints = connected_components(graph, directed=False)[1].astype(np.int64)
    return labels[kind_of.ravel()]


def together(parts: Iterable[Findings]) -> Findings:
    """What was found out about one demand in all the parts."""
    whole = Findings()
    for part in parts:
        whole.upper_s = max(whole.upper_s, part.upper_s)
        whole.lower_s = max(whole.lower_s, part.lower_s)
        whole.first_s = max(whole.first_s, part.first_s)
        if part.worst_place_m is not None and (whole.worst_place_m is None or part.worst_s > whole.worst_s):
            whole.worst_s, whole.worst_begin_s, whole.worst_place_m = (
                part.worst_s,
                part.worst_begin_s,
                part.worst_place_m,
            )
        whole.unseen_area_m2 += part.unseen_area_m2
        whole.excluded_area_m2 += part.excluded_area_m2
        whole.undecided_cells += part.undecided_cells
        whole.excluded += part.excluded
        whole.unmet += part.unmet
        whole.shown += part.shown
    return whole
