"""Cells that robots have no way to: whether walls or the grid keep them away, and a grid that would not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from shapely import MultiPolygon

from rota.errors import MissionError
from rota.geometry.free_space import free_ground
from rota.model.mission import TOUCH_M, Mission
from rota.model.polygons import polygons_of
from rota.planners.bounce.arrays import Flags, Ints
from rota.planners.bounce.cells import Cells, make_cells
from rota.planners.bounce.coverage import reachable_cells
from rota.planners.bounce.planner_settings import BounceSettings

PLACES_TOLD = 6
SHIFTS = (0.25, 0.5, 0.75)  # of a cell, by which another grid's corner is tried along each axis
SIZES = (0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6, 0.55, 0.5, 0.45, 0.4, 0.35, 0.3, 0.25)  # of the cell's, likewise
MOST_CELLS_TRIED = 250_000  # of a grid, and of all grids that are tried for a sentence three times as many


def places_of(cells: Cells, marked: Flags) -> str:
    """Where the marked cells (n,) are, the first of them by their centres."""
    centres = cells.centres_m[marked]
    listed = ", ".join(f"({x:.6g}, {y:.6g})" for x, y in centres[:PLACES_TOLD])
    return listed + (f" and {len(centres) - PLACES_TOLD} more" if len(centres) > PLACES_TOLD else "")


def unreached_parts(mission: Mission, cells: Cells, unreached: Flags, begins: Ints) -> list[str]:
    """Why no robot has a way from its start cell (m,) to the cells marked (n,): walls, the grid, or both.

    A cell is kept away by the grid alone if it is in the same piece of the ground for a body's centre as a start.
    """
    room = body_room(mission)
    piece = np.full(cells.count, -1)
    for number, part in enumerate(room.geoms):
        shapely.prepare(part)
        piece[shapely.dwithin(part, shapely.points(cells.centres_m), TOUCH_M)] = number
    by_grid = unreached & np.isin(piece, piece[begins])
    walled_off, parts = unreached & ~by_grid, []
    if walled_off.any():
        parts.append(
            f"no robot has a way from its start to {int(walled_off.sum())} cells, at {places_of(cells, walled_off)}"
        )
    if by_grid.any():
        parts.append(
            f"the grid joins no robot's start with {int(by_grid.sum())} cells, at {places_of(cells, by_grid)}, though"
            f" a body could drive there: {_advice(mission, cells, room)}"
        )
    return parts


def body_room(mission: Mission) -> MultiPolygon:
    """Where the centre of the fleet's widest body may be."""
    robots = mission.fleet.unlike_robots
    radius_m = max(robot.body_radius_m for robot in robots)
    room = free_ground(mission).buffer(-(radius_m - TOUCH_M / 2) if radius_m > TOUCH_M else 0, quad_segs=16)
    return polygons_of(room)


def _advice(mission: Mission, cells: Cells, room: MultiPolygon) -> str:
    """How to change the grid so that its cells are joined."""
    other = joined_grid(mission, cells, room)
    if other is None:
        return "smaller cells (bounce.cell_m) or another origin of the grid (bounce.cell_origin) may join them"
    cell_m, corner = other
    if corner is None:
        return f"bounce.cell_m: {cell_m:.6g} joins all its cells"
    return f"bounce.cell_origin: [{corner[0]:.6g}, {corner[1]:.6g}] joins all its cells"


def joined_grid(mission: Mission, cells: Cells, room: MultiPolygon) -> tuple[float, tuple[float, float] | None] | None:
    """A grid whose cells are joined within each piece of ``room``: its cell size, and its corner if that is new.

    First the same cells are shifted, then smaller cells are tried in steps of a twentieth. None where none of these
    joins.
    """
    settings, (x0, y0) = BounceSettings.of(mission), cells.corner_m
    shifts = [(a, b) for a in (0.0, *SHIFTS) for b in (0.0, *SHIFTS) if a or b]
    tried: list[tuple[float, tuple[float, float] | None]] = [
        (cells.cell_m, (round(x0 + a * cells.cell_m, 6), round(y0 + b * cells.cell_m, 6))) for a, b in shifts
    ]
    tried += [(float(f"{share * cells.cell_m:.4g}"), None) for share in SIZES]
    left = 3 * MOST_CELLS_TRIED
    for cell_m, corner in tried:
        expected = cells.count * (cells.cell_m / cell_m) ** 2
        left -= int(expected)
        if expected > MOST_CELLS_TRIED or left < 0:
            continue
        planning = replace(settings, cell_m=cell_m, cell_origin=corner)
        try:
            other = make_cells(replace(mission, planning=planning))
        except MissionError:  # no room at any centre
            continue
        if _joins_all(other, room):
            return cell_m, corner
    return None


def _joins_all(cells: Cells, room: MultiPolygon) -> bool:
    """Whether moves join all cells that lie in one piece of the room, and each piece has some."""
    points = shapely.points(cells.centres_m)
    for part in room.geoms:
        shapely.prepare(part)
        inside = np.flatnonzero(shapely.dwithin(part, points, TOUCH_M)).astype(np.int32)
        if len(inside) == 0 or not reachable_cells(cells, inside[:1])[inside].all():
            return False
    return True
