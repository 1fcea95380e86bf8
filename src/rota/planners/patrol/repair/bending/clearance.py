"""How far vertices and legs may move before they meet the border of the standing space."""

from __future__ import annotations

import numpy as np
import shapely

from rota.model.arrays import Flags, Floats
from rota.planners.patrol.repair.bending.layout import Layout
from rota.planners.patrol.repair.bending.program import Rows, rows_along
from rota.planners.patrol.tolerances import HAIR_M, ON_LINE_M


class Border:
    """The border of the standing space, as segments (m, 4), made ready to be asked."""

    def __init__(self, segments_m: Floats) -> None:
        self._lines = shapely.linestrings(segments_m.reshape(-1, 2, 2))
        self._tree = shapely.STRtree(self._lines)

    def clearances(self, layout: Layout, places_m: Floats, near_m: float) -> tuple[Rows, Flags]:
        """Limits on moves of what is within ``near_m`` of the border; and the vertices (n,) that had better stay.

        Towards each segment nobody moves farther than there is room; along it everybody may. What touches the border
        stays: it does so to go round a corner, which no single step leaves behind.
        """
        n = len(places_m)
        a, b = layout.start, layout.end
        legs = shapely.linestrings(np.stack([places_m[a], places_m[b]], axis=1))
        leg, segment = self._tree.query(legs, predicate="dwithin", distance=near_m)
        ways_m = shapely.get_coordinates(shapely.shortest_line(legs[leg], self._lines[segment])).reshape(-1, 2, 2)
        t = leg_parameters(places_m[a[leg]], places_m[b[leg]], ways_m[:, 0])
        points = shapely.points(places_m)
        vertex, beside = self._tree.query(points, predicate="dwithin", distance=near_m)
        to_m = shapely.get_coordinates(shapely.shortest_line(points[vertex], self._lines[beside])).reshape(-1, 2, 2)
        first, last = np.concatenate([a[leg], vertex]), np.concatenate([b[leg], vertex])
        ways_m, t = np.vstack([ways_m, to_m]), np.concatenate([t, np.zeros(len(vertex))])
        out_m = ways_m[:, 1] - ways_m[:, 0]
        room_m = np.hypot(*out_m.T)
        touches = room_m < HAIR_M
        fixed = np.zeros(n, dtype=np.bool_)
        fixed[first[touches & (t < 1)]] = True
        fixed[last[touches & (t > 0)]] = True
        keep = ~touches
        along = rows_along(out_m[keep] / room_m[keep, None], first[keep], last[keep], t[keep], n)
        return Rows(along, room_m[keep] - ON_LINE_M), fixed


def leg_parameters(start_m: Floats, end_m: Floats, places_m: Floats) -> Floats:
    """How far along legs (r, 2) to (r, 2) the places (r, 2) on them lie: 0 to 1; 0 on a leg without length."""
    along_m = end_m - start_m
    share = ((places_m - start_m) * along_m).sum(axis=1) / np.maximum((along_m**2).sum(axis=1), 1e-18)
    return np.asarray(np.clip(share, 0.0, 1.0))
