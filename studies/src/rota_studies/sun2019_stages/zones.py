"""Zones made ready for deployment, from the smallest period up: cells, where sensors may be, and what they see."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon

from rota.errors import MissionError, NoPlanFound
from rota.geometry.free_space import DemandedRegion, demanded_regions, standing_space
from rota.geometry.line_of_sight import points_inside
from rota.model.mission import DiscSensor, Mission
from rota.model.polygons import polygons_of
from rota.planners.patrol.ground.problem import common_robot
from rota.planners.patrol.tolerances import SLIVER_M2
from rota_studies.sun2019_stages.cells import (
    Cells,
    Lattice,
    cells_of,
    cells_seen_from,
    ground_for,
    lattice_over,
)
from rota_studies.sun2019_stages.sight_kernels import Ground
from rota_studies.sun2019_stages.stage_settings import BorderCells

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class CoverTask:
    """Cells to cover and where sensors may be to cover them; some place sees each cell.

    box_m: x, y, width, height of where sensors are looked for. places_m: (c, 2) places for set covers; seen_start (c +
    1,) and seen_item: the cells that each of them sees. number: (m,) of the cells in the zone.
    """

    cells: Cells
    number: Ints
    ground: Ground
    box_m: tuple[float, float, float, float]
    places_m: Floats
    seen_start: Ints
    seen_item: Ints


@dataclass(frozen=True, kw_only=True)
class ZoneTasks:
    """One zone to deploy in: its cells, the tasks that cover them, and the cells (k,) that nobody can see.

    The first task is the paper's: sensors in the zone itself, zones already covered are obstacles. Cells that cannot
    be seen so (ground closed to motion, or behind a corner) make a second one: sensors wherever a robot can stand,
    and only obstacles hide. Cells that no place sees whole are quartered, up to four times. spot_m: where a
    zone that asks for visits is visited; such a zone has no cells.
    """

    name: str
    period_s: float
    cells: Cells
    tasks: tuple[CoverTask, ...]
    unseeable: Ints
    spot_m: tuple[float, float] | None = None


def virtual_radius_m(mission: Mission) -> float:
    """r_v = 2 r_s, for the sensor that all robots of the fleet have in common: so far a robot sees to either side.

    Raises MissionError for square sensors: the method is made for discs, whose route is as wide everywhere.
    """
    sensor = common_robot(mission.fleet).sensor
    if not isinstance(sensor, DiscSensor):
        raise MissionError(
            f"fleet.sensor: a square of side {sensor.side_m:.6g} m is not allowed; sensor deployment (Sun 2019) is for"
            " disc sensors, so give shape: disc and a radius_m"
        )
    return 2.0 * sensor.radius_m


def zones_to_deploy(mission: Mission, *, cell_m: float | None, border: BorderCells) -> Iterator[ZoneTasks]:
    """The zones of a mission by their periods; zones of equal periods in the mission's order, the area last.

    cell_m: side of a cell in metres, None for 0.24 of the virtual radius, 50 x 50 cells on 120 m for 10 m. What lies
    in several zones belongs to the one with the smallest period. Zones that ask for visits take one sensor and hide
    nothing from others. Raises MissionError as ``virtual_radius_m`` does, and NoPlanFound where no robot can stand, or
    cells are too many.
    """
    reach_m = virtual_radius_m(mission)
    body_m = common_robot(mission.fleet).body_radius_m
    standing = standing_space(mission, body_m)
    if standing.is_empty:
        raise NoPlanFound(f"there is no place where a body of radius {body_m} m can stand")
    lattice = lattice_over(mission.area, 0.24 * reach_m if cell_m is None else cell_m)
    obstacles = polygons_of(
        shapely.union_all([item.shape for item in mission.obstacles if item.blocks_sight]), SLIVER_M2
    )
    hidden = obstacles
    for region in sorted(demanded_regions(mission), key=lambda region: region.period_s):
        if region.demand == "visit":
            yield _visit_task(region, standing, lattice)
            continue
        cells = cells_of(region.shape, lattice, hidden=hidden, border=border)
        own = polygons_of(region.shape.intersection(standing), SLIVER_M2)
        grounds = (ground_for(own, hidden, reach_m), ground_for(standing, obstacles, reach_m))
        tasks, left = cover_tasks(cells, (own, standing), grounds)
        for _ in range(4 if len(left) else 0):
            cells = cells.quarter(left)
            tasks, left = cover_tasks(cells, (own, standing), grounds)
            if not len(left):
                break
        yield ZoneTasks(name=region.name, period_s=region.period_s, cells=cells, tasks=tasks, unseeable=left)
        hidden = polygons_of(shapely.union_all([hidden, region.shape]), SLIVER_M2)


def _visit_task(region: DemandedRegion, standing: MultiPolygon, lattice: Lattice) -> ZoneTasks:
    """The task of a zone that asks for visits; raises NoPlanFound where no robot can be inside."""
    where = polygons_of(region.shape.intersection(standing), SLIVER_M2)
    if where.is_empty:
        spot = region.shape.representative_point()
        raise NoPlanFound(f"no robot can be inside zone {region.name}, at ({spot.x:.2f}, {spot.y:.2f})")
    spot = max(where.geoms, key=lambda part: float(part.area)).representative_point()
    none = cells_of(region.shape, lattice, hidden=MultiPolygon(), border="clipped").choose(np.zeros(0, dtype=np.int64))
    return ZoneTasks(
        name=region.name, period_s=region.period_s, cells=none, tasks=(), unseeable=np.zeros(0, dtype=np.int64),
        spot_m=(float(spot.x), float(spot.y)),
    )  # fmt: skip


def cover_tasks(
    cells: Cells, spaces: tuple[MultiPolygon, ...], grounds: tuple[Ground, ...]
) -> tuple[tuple[CoverTask, ...], Ints]:
    """The tasks to cover the cells, and the numbers of the cells that no space sees.

    Each space covers what the spaces before it leave.
    """
    tasks, left = [], np.arange(len(cells))
    for space, ground in zip(spaces, grounds, strict=True):
        task, left = _task(cells, left, space, ground)
        if task is not None:
            tasks.append(task)
    return tuple(tasks), left


def _task(cells: Cells, number: Ints, space: MultiPolygon, ground: Ground) -> tuple[CoverTask | None, Ints]:
    """The task to cover the cells of these numbers from places in the space, and the numbers that no place sees."""
    if not len(number) or space.is_empty:
        return None, number
    wanted = cells.choose(number)
    places_m = _places(wanted, space, ground)
    start, items = cells_seen_from(places_m, wanted, ground)
    seen = np.zeros(len(wanted), dtype=bool)
    seen[items] = True
    if not seen.all():
        further_m = _further_places(wanted.choose(np.flatnonzero(~seen)), space, ground)
        places_m = np.vstack([places_m, further_m])
        seen[cells_seen_from(further_m, wanted, ground)[1]] = True
    if not seen.any():
        return None, number
    if not seen.all():
        wanted = wanted.choose(np.flatnonzero(seen))
    start, items = cells_seen_from(places_m, wanted, ground)
    useful = np.diff(start) > 0
    start, items = np.append(0, np.cumsum(np.diff(start)[useful])), items
    task = CoverTask(
        cells=wanted, number=number[seen], ground=ground, box_m=_box(wanted, space, ground.reach_m),
        places_m=places_m[useful], seen_start=start, seen_item=items,
    )  # fmt: skip
    return task, number[~seen]


def _places(cells: Cells, space: MultiPolygon, ground: Ground) -> Floats:
    """The centres and corners (p, 2) of the lattice's squares in the space and in reach of the cells' box."""
    x, y, wide, high = _box(cells, space, ground.reach_m)
    points = cells.lattice.points_m
    near = (points >= np.array([x, y]) - 1e-9) & (points <= np.array([x + wide, y + high]) + 1e-9)
    points = points[near.all(axis=1)]
    return np.ascontiguousarray(points[points_inside(points, ground.space)])


def _further_places(cells: Cells, space: MultiPolygon, ground: Ground) -> Floats:
    """Places for cells that no point of the lattice sees: in the cells themselves and along the space's border."""
    inside = shapely.get_coordinates(shapely.point_on_surface(cells.shapes))
    border = shapely.get_coordinates(shapely.segmentize(space.boundary, cells.lattice.cell_m / 2))
    middles = shapely.get_coordinates(shapely.point_on_surface(np.array(space.geoms)))
    points = np.unique(np.vstack([inside, cells.centres_m, border, middles]), axis=0)
    points = points[points_inside(points, ground.space)]
    start, _ = cells_seen_from(points, cells, ground)
    return np.ascontiguousarray(points[np.diff(start) > 0])


def _box(cells: Cells, space: MultiPolygon, reach_m: float) -> tuple[float, float, float, float]:
    """Where the space's bounding box and that of the cells, grown by the reach, overlap: x, y, width, height."""
    low, high = cells.table.corners.min(axis=0) - reach_m, cells.table.corners.max(axis=0) + reach_m
    x0, y0 = np.maximum(low, space.bounds[:2])
    x1, y1 = np.minimum(high, space.bounds[2:])
    return float(x0), float(y0), float(max(x1 - x0, 1e-6)), float(max(y1 - y0, 1e-6))
