"""Boustrophedon cells: ground cut so that lanes cross each cell from end to end."""

from __future__ import annotations

import numpy as np
import shapely
from shapely import Polygon

from rota.model.arrays import Flags, Floats
from rota.planners.patrol.methods.sweeping.lanes import polygons, shared_m, slabs
from rota.planners.patrol.tolerances import CUT_M, ON_LINE_M


def cells(shape: Polygon) -> list[Polygon]:
    """Boustrophedon cells: every line along x meets each in one stretch, and neighbours that could be one are one.

    Cut where a line moving upwards is split or joined: at the reflex corners that are lowest or highest around.
    Source: Choset, Coverage of known spaces: the boustrophedon cellular decomposition, Autonomous Robots 9, 2000.
    """
    _, low, _, high = shape.bounds
    cuts = [low, *sorted({y for y in events(shape) if low + 1e-9 < y < high - 1e-9}), high]
    layers = slabs(shape, cuts)
    grown: list[list[Polygon]] = []
    open_below: list[tuple[Polygon, list[Polygon]]] = []
    for layer in layers:
        below = [part for part, _ in open_below]
        touches = shared_borders(layer, below)
        now: list[tuple[Polygon, list[Polygon]]] = []
        for i, part in enumerate(layer):
            beneath = np.flatnonzero(touches[i])
            if len(beneath) == 1 and touches[:, beneath[0]].sum() == 1:
                cell = open_below[beneath[0]][1]
                cell.append(part)
            else:
                cell = [part]
                grown.append(cell)
            now.append((part, cell))
        open_below = now
    return [part for cell in grown for part in polygons(shapely.union_all(cell, grid_size=ON_LINE_M))]


def shared_borders(parts: list[Polygon], others: list[Polygon]) -> Flags:
    """Which parts (n,) share a border with which others (m,) of the slab below: (n, m)."""
    spans, other_spans = (shapely.bounds(np.array(list_, dtype=object)).reshape(-1, 4) for list_ in (parts, others))
    shared: Flags = (spans[:, None, 0] < other_spans[None, :, 2]) & (other_spans[None, :, 0] < spans[:, None, 2])
    for i, j in np.argwhere(shared):
        shared[i, j] = shared_m(parts[i], others[j]) > CUT_M
    return shared


def events(shape: Polygon) -> list[float]:
    """Heights at which a line along x, moving upwards, is split by an obstacle or joined behind one."""
    heights: list[float] = []
    for number, ring in enumerate([shape.exterior, *shape.interiors]):
        points = shapely.get_coordinates(ring)[:-1]
        if ring.is_ccw != (number == 0):
            points = points[::-1]
        heights += ring_events(points)
    return heights


def ring_events(points_m: Floats) -> list[float]:
    """Heights of the reflex corners of a ring (n, 2), shape on the left, that are its lowest or highest around."""
    y = points_m[:, 1]
    level = np.abs(np.roll(y, -1) - y) < 1e-9  # the edge after each corner is along x
    heights = []
    for i in range(len(y)):
        if level[i - 1]:
            continue  # a level stretch counts at its first corner
        j, run = i, 0
        while level[j] and run < len(y):
            j, run = (j + 1) % len(y), run + 1
        before, after = y[i - 1] - y[i], y[(j + 1) % len(y)] - y[i]
        if before * after <= 0:
            continue
        if run:
            # with the shape on the left, a lowest stretch has it above when it leads to the right
            outside = (points_m[j, 0] < points_m[i, 0]) == (before > 0)
        else:
            come, go = points_m[i] - points_m[i - 1], points_m[(i + 1) % len(y)] - points_m[i]
            outside = bool(come[0] * go[1] - come[1] * go[0] < 0)
        if outside:
            heights.append(float(y[i]))
    return heights
