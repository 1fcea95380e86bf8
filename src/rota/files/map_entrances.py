"""Where robots come in on a ROS map that does not say so: inside, and where they start."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from shapely import MultiPolygon, Point
from shapely.geometry.base import BaseGeometry

from rota.model.fleet import Fleet, Place, StartBox, StartPoints
from rota.model.start_faults import entrance_fault

ROOM = 1.01  # times the radius: a body that keeps so far off walls has room to move on
NEAR = 0.1  # of the radius: a start so near to where bodies have room leads there
ARC_STEPS = 64  # per quarter of a circle
SLIVER_M2 = 1e-6


def entrances_on_map(
    inside: Place, fleet: Fleet, area: MultiPolygon, blocking: Sequence[MultiPolygon]
) -> tuple[Place, ...] | None:
    """The places where a fleet with its starts comes in: at ``inside``, or near it, and at starts cut off from there.

    Where no body fits at ``inside``, robots come in at the nearest place with room in the largest part of the ground.
    None where bodies have room nowhere: then there is nothing to come in to.
    """
    body_m = max(robot.body_radius_m for robot in fleet.unlike_robots)
    fits = entrance_fault(inside, body_m, area, blocking) is None
    starts = list(_starts(fleet, area))
    if fits and not starts:
        return (inside,)
    room = shapely.difference(area, shapely.union_all(blocking)).buffer(-ROOM * body_m, quad_segs=ARC_STEPS)
    parts = np.array([part for part in shapely.get_parts(room) if part.area > SLIVER_M2])
    if not len(parts):
        return (inside,) if fits else None
    if not fits:
        largest = parts[int(np.argmax(shapely.area(parts)))]
        x, y = shapely.get_coordinates(shapely.shortest_line(largest, Point(inside)))[0]
        inside = (float(x), float(y))
    entrances, tree = [inside], shapely.STRtree(parts)
    entered = set(tree.query_nearest(Point(inside)).tolist())
    for start in starts:
        there = tree.query(start, predicate="dwithin", distance=NEAR * body_m)
        if entered.isdisjoint(there.tolist()):
            for k in there[:1]:
                x, y = shapely.get_coordinates(shapely.shortest_line(parts[k], start))[0]
                entrances.append((float(x), float(y)))
                entered.add(int(k))
    return tuple(entrances)


def _starts(fleet: Fleet, area: MultiPolygon) -> Iterator[BaseGeometry]:
    """Where robots of the fleet start: points, and its box."""
    if isinstance(fleet.start, StartPoints):
        yield from map(Point, fleet.start.points_m)
    if isinstance(fleet.start, StartBox):
        yield shapely.box(*fleet.start.low_m, *fleet.start.high_m)
    yield from (Point(robot.start) for robot in fleet.robots or () if robot.start is not None)
