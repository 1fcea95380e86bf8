"""A closed loop over lanes side by side: to and fro, and back along one side, which it sees on its way."""

from __future__ import annotations

import numpy as np
import shapely
from shapely import LineString

from rota.model.arrays import Floats
from rota.model.mission import DiscSensor
from rota.planners.patrol.methods.large.rows import Column
from rota.planners.patrol.methods.sweeping.lanes import Swath, lane_ends
from rota.planners.patrol.tolerances import SAME_PLACE_M


def ring_over(column: Column, swath: Swath) -> Floats:
    """A closed polyline (k, 2), in the frame of the lanes, from which all of the column is seen in the open.

    Lanes lead straight past holes in their ground. With an even number of lanes the way back is along the left ends; an
    inner lane then begins where that way sees no further. With an odd one it is straight across.
    """
    ends = np.array([lane_ends(part, y, swath) for part, y in zip(column.lanes, column.heights_m, strict=True)])
    lanes = len(ends)
    back = np.column_stack([ends[:, 0], column.heights_m])[::-1] if lanes % 2 == 0 else np.zeros((0, 2))
    if lanes > 2 and len(back) and isinstance(swath.sensor, DiscSensor):
        seen = LineString(back).buffer(swath.half_m)
        for j in range(1, lanes - 1):
            rest = shapely.difference(column.lanes[j], seen)
            ends[j] = lane_ends(rest, column.heights_m[j], swath) if not rest.is_empty else (ends[j, 1], ends[j, 1])
    there = np.stack([ends, np.repeat(column.heights_m[:, None], 2, axis=1)], axis=2)  # lane, end, axis
    there[1::2] = there[1::2, ::-1]
    ring = np.vstack([there.reshape(-1, 2), back[1:-1]])
    closed = LineString(np.vstack([ring, ring[:1]])).simplify(SAME_PLACE_M)
    return np.asarray(shapely.get_coordinates(closed)[:-1])
