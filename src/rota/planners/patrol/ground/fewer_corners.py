"""Many obstacles much smaller than the reach get as few corners as that allows: trunks hide next to nothing."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from rota.model.arrays import Flags
from rota.model.mission import Mission
from rota.model.polygons import polygons_of
from rota.planners.patrol.tolerances import TIE

GROWN = 0.01  # of the reach, by which obstacles grow at most


def with_fewer_corners(mission: Mission, reach_m: float, body_m: float) -> Mission:
    """The mission with fewer corners where robots drive round its small obstacles; itself where there are few anyway.

    Each obstacle contains the one that it stands for, and no point of it is farther from that than ``GROWN`` reaches:
    who keeps off it keeps off that. Gaps that bodies fit through stay open, since an obstacle with another one near it,
    or the area's border, is left as it is.
    """
    shapes = [obstacle.shape for obstacle in mission.obstacles]
    if int(shapely.get_num_coordinates(shapes).sum()) <= 500:
        return mission
    parts, owners = shapely.get_parts(shapes, return_index=True)
    # an obstacle nearer than that to anything stays as it is
    crowded = _those_beside_others(parts, mission, 2 * body_m + 3.0 * GROWN * reach_m)
    simple = parts.copy()
    for k in np.flatnonzero(~crowded):
        simple[k] = _with_fewest_sides(parts[k], reach_m)
    changed = simple != parts
    if not changed.any():
        return mission
    obstacles = (
        replace(obstacle, shape=polygons_of(simple[owners == k])) if changed[owners == k].any() else obstacle
        for k, obstacle in enumerate(mission.obstacles)
    )
    return replace(mission, obstacles=tuple(obstacles))


def _those_beside_others(parts: NDArray[np.object_], mission: Mission, near_m: float) -> Flags:
    """Whether another part, or the border of the area, is so near to each of the parts: (n,) flags."""
    crowded: Flags = shapely.dwithin(parts, shapely.boundary(mission.area), near_m)
    one, other = shapely.STRtree(parts).query(parts, predicate="dwithin", distance=near_m)
    crowded[one[one != other]] = True
    return crowded


def _with_fewest_sides(part: Polygon, reach_m: float) -> Polygon:
    """The polygon with the fewest sides round a small part that grows little enough; the part where there is none.

    All sides touch the part, at equal angles from each other.
    """
    corners = shapely.get_coordinates(shapely.convex_hull(part))[:-1]
    middle = corners.mean(axis=0)
    if 2 * np.hypot(*(corners - middle).T).max() > 0.25 * reach_m:  # wider ones keep their corners
        return part
    for sides in (4, 6, 8, 12, 16, 24):  # the fewest first
        if sides >= shapely.get_num_coordinates(part) - 1:
            break
        turn = 2 * math.pi / sides
        across = np.column_stack([np.cos(turn * np.arange(sides)), np.sin(turn * np.arange(sides))])
        far_m = (across @ (corners - middle).T).max(axis=1) + TIE * reach_m
        along_m = (np.roll(far_m, -1) - far_m * math.cos(turn)) / math.sin(turn)  # to where the next side begins
        vertices_m = middle + far_m[:, None] * across + along_m[:, None] * across[:, ::-1] * (-1, 1)
        if shapely.distance(part, shapely.points(vertices_m)).max() <= GROWN * reach_m:
            return Polygon(vertices_m)
    return part
