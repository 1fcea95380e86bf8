"""Where a swarm moves: walls, what robots are like, and the grid that both are sorted into."""

from __future__ import annotations

import math

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely import MultiPolygon

from rota.cells.importance_cells import ImportanceCells
from rota.errors import MissionError
from rota.model.arrays import Floats, Ints
from rota.model.mission import MovingObstacle
from rota.planners.swarm.filter_kernels import ROUNDING_M
from rota.planners.swarm.importance_field import field_of
from rota.planners.swarm.kernels import walls_of_cells
from rota.planners.swarm.place_graph import empty_place_graph, place_graph_of
from rota.planners.swarm.state import FleetKinds, Grid, Kinds, Moving

CELLS_PER_ROBOT = 4  # no more cells than that, so that a huge area costs no memory
FEWEST_CELLS = 1024


def moving_at(discs: tuple[MovingObstacle, ...], time_s: float, time_step_s: float) -> Moving:
    """Places of all discs at a time, and the velocities that bring them to their places one step later."""
    places = np.array([disc.at(time_s) for disc in discs]).reshape(-1, 2)
    next_places = np.array([disc.at(time_s + time_step_s) for disc in discs]).reshape(-1, 2)
    vx, vy = (next_places - places).T / time_step_s
    radius = np.array([disc.radius_m for disc in discs])
    return Moving(*(np.ascontiguousarray(values) for values in (*places.T, vx, vy, radius)))


def walls_of(ground: MultiPolygon) -> Floats:
    """The border of a ground as segments (m, 4), x0, y0, x1, y1; none of them a point."""
    rings = shapely.get_rings(shapely.get_parts(ground))
    pieces = [np.hstack([points[:-1], points[1:]]) for points in map(shapely.get_coordinates, rings)]
    walls = np.vstack([np.empty((0, 4)), *pieces])
    kept = (walls[:, :2] != walls[:, 2:]).any(axis=1)
    return np.ascontiguousarray(walls[kept])


def kinds_of(
    count: int,
    *,
    body_m: ArrayLike,
    sensor_m: ArrayLike,
    speed_m_s: ArrayLike,
    neighbour_range_m: ArrayLike,
    wall_range_m: ArrayLike,
) -> FleetKinds:
    """What a fleet of robots is like; each value is a number or (count,). Raises MissionError for values below 0."""
    values = (body_m, sensor_m, speed_m_s, neighbour_range_m, wall_range_m)
    rows = np.stack([np.broadcast_to(np.asarray(value, float), (count,)) for value in values], axis=1)
    if not np.isfinite(rows).all() or (rows < 0).any():
        k = int(np.flatnonzero(~np.isfinite(rows).all(axis=1) | (rows < 0).any(axis=1))[0])
        raise MissionError(f"robot {k}: {rows[k].tolist()} is not allowed; radii, speed and ranges are finite, >= 0")
    if (rows == rows[0]).all():
        kinds, kind = rows[:1], np.zeros(count, np.int64)
    else:
        kinds, kind = np.unique(rows, axis=0, return_inverse=True)
    columns = (np.ascontiguousarray(column) for column in kinds.T)
    return FleetKinds(Kinds(*columns), kind.ravel().astype(np.int64))


def widest_m(kinds: Kinds, time_step_s: float) -> float:
    """The largest body plus the longest step of any robot."""
    return float(kinds.body_m.max() + kinds.speed_m_s.max() * time_step_s)


def with_absent(kinds: Kinds) -> Kinds:
    """The kinds; the same without sensor and speed for robots that take no part; without sensor for those that are

    sent somewhere; and one kind without a body.
    """
    still = np.zeros_like(kinds.body_m)
    parts = {name: np.concatenate([values, still, values, [0.0]]) for name, values in kinds._asdict().items()}
    parts["body_m"] = np.concatenate([kinds.body_m, kinds.body_m, kinds.body_m, [-np.inf]])
    parts["sensor_m"] = np.concatenate([kinds.sensor_m, still, still, [0.0]])
    return Kinds(**parts)


def require_room(
    numbers: Ints, places_m: Floats, bodies_m: Floats, others_m: Floats, other_bodies_m: Floats, walls: Floats
) -> None:
    """Raise MissionError unless bodies at places (k, 2) stand clear of each other, of others (m, 2) and of walls.

    The walls are closed rings round the free space; a place outside it has no room. Touching is allowed, by rounding.
    """
    lines = shapely.linestrings(walls.reshape(-1, 2, 2))
    free = shapely.build_area(shapely.node(shapely.multilinestrings(lines)))
    all_m, all_bodies_m = np.vstack([others_m, places_m]), np.concatenate([other_bodies_m, bodies_m])
    for k, (number, place, body) in enumerate(zip(numbers, places_m, bodies_m, strict=True)):
        where = f"robot {int(number)} at [{place[0]:.9g}, {place[1]:.9g}]"
        if not np.isfinite(place).all():
            raise MissionError(f"{where}: coordinates must be finite")
        gaps = np.hypot(*(all_m - place).T) - all_bodies_m - body
        gaps[len(others_m) + k] = np.inf
        if gaps.min() < -ROUNDING_M:
            raise MissionError(
                f"{where}: there is no room to join; its body overlaps another one by {-gaps.min():.6g} m"
            )
        gap = shapely.distance(lines, shapely.Point(place)).min() - body
        if gap < -ROUNDING_M or not shapely.intersects_xy(free, *place):
            raise MissionError(f"{where}: there is no room to join; it stands outside the free space or in a wall")


def make_grid(
    walls: Floats,
    kinds: Kinds,
    robots: int,
    time_step_s: float,
    slack_m: float = 0.0,
    *,
    importance: ImportanceCells | None = None,
    mapped: bool = False,
) -> Grid:
    """A grid over all walls; whatever concerns a robot stands in its cell or in the cells next to it.

    walls: (m, 4), at least one. Cells are as wide as the farthest that any robot looks, and wider where there would be
    more than a few for each robot. slack_m: how far robots may be from where others know them, and from where they were
    when they were sorted. importance: of the ground; None: all is worth as much. mapped: with the graph of places.
    """
    low = np.minimum(walls[:, :2], walls[:, 2:]).min(axis=0)
    size = np.maximum(walls[:, :2], walls[:, 2:]).max(axis=0) - low
    step_reach = 2 * widest_m(kinds, time_step_s)
    cell = max(float(kinds.neighbour_range_m.max()), 2 * float(kinds.sensor_m.max()), step_reach) + slack_m
    most = max(CELLS_PER_ROBOT * robots, FEWEST_CELLS)
    cell = max(cell, math.sqrt(float(size[0] * size[1]) / most), float(size.max()) / most)
    columns, rows = (int(extent // cell) + 1 for extent in size)
    cells = (columns + 2) * (rows + 2)
    grid = Grid(
        x0=float(low[0]),
        y0=float(low[1]),
        cell_m=cell,
        columns=columns,
        rows=rows,
        start=np.zeros(cells + 1, np.int64),
        wall_start=np.zeros(cells + 1, np.int64),
        wall_item=np.empty(0, np.int64),
        walls=walls,
        place_graph=place_graph_of(walls, kinds, importance) if mapped else empty_place_graph(),
        importance=field_of(importance),
    )
    within = max(float(kinds.wall_range_m.max()), float(kinds.sensor_m.max()), widest_m(kinds, time_step_s))
    total = walls_of_cells(grid, within, False)
    np.cumsum(grid.wall_start, out=grid.wall_start)
    grid = grid._replace(wall_item=np.empty(total, np.int64))
    walls_of_cells(grid, within, True)
    grid.wall_start[1:] = grid.wall_start[:-1]
    grid.wall_start[0] = 0
    return grid
