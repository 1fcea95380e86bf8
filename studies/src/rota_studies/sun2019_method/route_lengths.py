"""Eq. 26 as printed: the length of the closed route round every segment of a frame (Sun et al. 2019, Section 4.4).

The partition asks for the time round any stretch of the frame, thousands of times a second. So the routes round all
stretches are led once, before it begins, and their lengths are looked up.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from shapely import MultiPolygon

from rota.geometry.shortest_path import ShortestPaths
from rota.planners.patrol.methods.sun2019.route import as_line, borders_of, route_round, widen
from rota_studies.sun2019_stages.frame import Frame
from rota_studies.sun2019_stages.stretches import length_m, stretch_line

Floats = NDArray[np.float64]

# Times its period: a stretch whose route takes longer is part of no good partition, and need not be known as exactly
FAR_TOO_LONG = 3.0  # by twice its length and 2 pi r_s, which is then all that is told
TOO_LONG = 1.3  # by the borders round it: the ways from one border to the next are then left out


def segment_lengths_m(legs_m: Floats, *, joining_legs: bool) -> Floats:
    """Metres (n, n) along the frame of the k + 1 waypoints from each on, with the leg before the first if asked for."""
    n = len(legs_m)
    along = np.concatenate([[0.0], np.cumsum(np.tile(legs_m, 2))])
    first = np.arange(n)[:, None]
    long_m = along[first + np.arange(n)] - along[first]
    return np.asarray(long_m + np.roll(legs_m, 1)[:, None] if joining_legs else long_m)


def segment_periods_s(waypoint_periods_s: Floats) -> Floats:
    """Eq. 23 (n, n): the smallest period of the k + 1 waypoints from each on."""
    n = len(waypoint_periods_s)
    places = (np.arange(n)[:, None] + np.arange(n)) % n
    return np.asarray(np.minimum.accumulate(waypoint_periods_s[places], axis=1))


def route_lengths_m(
    frame: Frame,
    waypoint_periods_s: Floats,
    paths: ShortestPaths,
    *,
    speed_m_s: float,
    radius_m: float,
    joining_legs: bool,
) -> Floats:
    """Metres (n, n) of the closed routes round the k + 1 waypoints from each on, n of them in the frame's order.

    They are the lengths of the routes of ``route_round`` for stretches whose route takes up to 1.3 times their period.
    Longer routes are given without the ways that join several borders to one route. Routes three times too long are
    given as twice the stretch and 2 pi r_s. Both only matter in that they are much too long.

    frame: in one part of the space of ``paths``. waypoint_periods_s: (n,) along it. joining_legs: see
    ``PartitionSettings``.
    """
    n = len(frame.order)
    found_m = 2 * segment_lengths_m(frame.legs_m, joining_legs=joining_legs) + 2 * np.pi * radius_m
    allowed_m = speed_m_s * segment_periods_s(waypoint_periods_s)
    first, more = np.nonzero(found_m <= FAR_TOO_LONG * allowed_m)
    if not len(first):
        return found_m
    lines = [
        stretch_line(frame, (int(a) + np.arange(int(k) + 1)) % n, joining_legs=joining_legs)
        for a, k in zip(first, more, strict=True)
    ]
    space = MultiPolygon([paths.parts[int(paths.part_of(lines[0][:1])[0])]])
    middles = np.array([as_line(line) for line in lines], dtype=object)
    widened = widen(middles, radius_m, space)
    for a, k, line_m, middle, shape in zip(first, more, lines, middles, widened, strict=True):
        rings = borders_of(shape, middle, space, radius_m=radius_m)
        found_m[a, k] = sum(length_m(ring) for ring in rings)
        if len(rings) != 1 and found_m[a, k] <= TOO_LONG * allowed_m[a, k]:
            found_m[a, k] = length_m(route_round(line_m, paths, radius_m=radius_m))
    return found_m
