"""Stretches of the frame as polylines, and how long routes round them are (Sun et al. 2019, Section 4.4)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rota_studies.sun2019_stages.frame import Frame
from rota_studies.sun2019_stages.partition import Partition

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def segment_line(frame: Frame, partition: Partition, segment: int, *, joining_legs: bool) -> Floats:
    """The polyline (k, 2) of one segment of the frame, from its first waypoint to its last; one point for one waypoint.

    joining_legs: begin at the last waypoint of the segment before, as Eq. 22 has it.
    """
    places = partition.places(segment, len(frame.order))
    return stretch_line(frame, places, joining_legs=joining_legs)


def stretch_line(frame: Frame, places: Ints, *, joining_legs: bool) -> Floats:
    """The polyline (k, 2) past the waypoints at these places (m,) of the frame, which follow each other."""
    held = places.tolist()
    if joining_legs:
        held = [(held[0] - 1) % len(frame.order), *held]
    pieces = [frame.path_m[frame.leg_start[k] : frame.leg_start[k + 1]] for k in held[:-1]]
    return np.vstack([*pieces, frame.path_m[frame.leg_start[held[-1]]]])


def length_m(route_m: Floats) -> float:
    """Length of a closed route (n, 2)."""
    return float(np.hypot(*(np.roll(route_m, -1, axis=0) - route_m).T).sum())
