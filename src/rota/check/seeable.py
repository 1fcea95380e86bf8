"""Which places nobody can see from where bodies can stand."""

from __future__ import annotations

import functools
import math
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from rota.check import sight_kernels, tiling_kernels
from rota.check.arrays import Binned, Flags, Floats, Grid
from rota.check.blocking import blocks_sight
from rota.check.routes import segments_of
from rota.check.standing import StandingArea, standing_areas
from rota.check.tolerances import GRID_MARGIN_M, SLACK_M, slack_of
from rota.model.mission import DiscSensor, Mission, Obstacle, Sensor

MANY_SIDES, RAGGED_SIDES = 10_000, 5_000
MOST_GRID_CELLS = 250_000
MOST_SPREAD = 0.4  # of the reach: spreads for which what blocks sight is kept on ragged ground
LINE_SIDES = 16  # of a border in one line of the tree that finds the nearest
SPREADS = 9  # for so many of them, the ground of ragged missions is kept as looks ask for it
RAGGED_STEPS = 4  # per quarter of a circle, where what blocks sight there is made thinner: corners are very many
LEAST_SPREAD_M = 0.0071  # on ragged ground spreads are this one, twice, four times it and so on: a finest piece has it
MOST_ALONE = 64  # points that one thread looks from by itself


def has_many_sides(mission: Mission) -> bool:
    """Whether walls have so many sides, as on a scanned floor, that they cut most pieces of the ground."""
    return int(shapely.get_num_coordinates(blocks_sight(mission.obstacles))) > RAGGED_SIDES


def seeable(mission: Mission, areas: tuple[StandingArea, ...], points_m: Floats, spread_m: float = 0.0) -> Flags:
    """Whether each of the points (n, 2) can be seen from anywhere some robot can stand: (n,) bool.

    With ``spread_m``: False proves that nothing within that distance of the point can be seen. (If q is seen from p,
    all of the segment from p to a point x near q is within |q - x| of points that are not in an obstacle, so it stays
    out of obstacles made thinner by that much.) Points must not lie inside what blocks sight.
    """
    return _ground(mission.obstacles, areas, slack_of(mission)).sees(points_m, spread_m)


def seeable_ground(mission: Mission) -> SeeableGround:
    """What can be seen of the mission's ground, to be asked again and again; see ``seeable``."""
    return _ground(mission.obstacles, standing_areas(mission), slack_of(mission))


@functools.lru_cache(maxsize=4)
def _ground(obstacles: tuple[Obstacle, ...], areas: tuple[StandingArea, ...], slack_m: float) -> SeeableGround:
    """The same for missions that differ in their periods only; a search has hundreds of plans for them checked."""
    return SeeableGround(blocks_sight(obstacles), areas, slack_m)


class SeeableGround:
    """What can be seen from standing areas past what blocks sight, ``hidden``.

    Answers are kept, since a search has hundreds of plans checked. On ragged ground it keeps the ground as looks ask
    for it, too: without a spread, and with the last few. Of a large floor one takes 60 MB.
    """

    def __init__(self, hidden: Any, areas: tuple[StandingArea, ...], slack_m: float) -> None:
        self._hidden, self._areas, self._slack_m = hidden, areas, slack_m
        self._reach_m = max((area.sensor.reach_m for area in areas), default=0.0)
        corners = shapely.get_num_coordinates([hidden, *(area.shape for area in areas)]).sum()
        self._is_ragged = int(corners) > MANY_SIDES
        self._known: dict[tuple[float, float, float], bool] = {}
        self._scene_within = functools.lru_cache(maxsize=SPREADS)(self._ragged_scene)

    def sees(self, points_m: Floats, spread_m: float = 0.0) -> Flags:
        """Whether each of the points (n, 2) can be seen within the spread: (n,) flags; see ``seeable``."""
        known = self._known
        if not self._is_ragged and len(known) > 300_000:  # 60 MB; there a look takes less than a millisecond
            known.clear()
        keys = [(spread_m, x, y) for x, y in points_m.tolist()]
        new = np.array([k for k, key in enumerate(keys) if key not in known], dtype=np.int64)
        if len(new):
            sight = self._look(points_m[new], spread_m)
            known.update((keys[k], seen) for k, seen in zip(new, sight.tolist(), strict=True))
        return np.array([known[key] for key in keys], dtype=np.bool_)

    def _look(self, points_m: Floats, spread_m: float) -> Flags:
        """What ``sees`` answers, looked at anew."""
        if not self._is_ragged or spread_m > MOST_SPREAD * self._reach_m:
            return _sees_from_any(self._areas, self._hidden, points_m, spread_m, self._slack_m)
        return _sees_in(self._scene if spread_m == 0 else self._scene_within(spread_m), points_m, spread_m)

    @functools.cached_property
    def _scene(self) -> tuple[_Scene, ...]:
        """The ground as looks without a spread ask for it."""
        return self._ragged_scene(0.0)

    def get_ready(self, most_spread_m: float) -> None:
        """Make the ground ready, where it is ragged, for looks without a spread and with all up to the greatest."""
        if not self._is_ragged:
            return
        steps = range(math.ceil(math.log2(max(most_spread_m, LEAST_SPREAD_M) / LEAST_SPREAD_M)) + 1)
        spreads_m = [LEAST_SPREAD_M * 2.0**step for step in steps][:SPREADS]
        _ = self._scene
        for spread_m in spreads_m:
            if spread_m <= min(most_spread_m, MOST_SPREAD * self._reach_m):
                self._scene_within(spread_m)
        for scene in self._scene:
            _sides(scene.area)

    def sees_within(self, points_m: Floats, spreads_m: Floats) -> Flags:
        """The same for a spread of each point, (n,) metres; for one that is greater, where that is less work.

        To make the ground ready for a spread takes longer than thousands of looks.
        """
        if not self._is_ragged:
            return self.sees(points_m, float(spreads_m.max(initial=0.0)))
        steps = np.ceil(np.log2(np.maximum(spreads_m, LEAST_SPREAD_M) / LEAST_SPREAD_M))
        spreads_m = np.where(spreads_m > 0, LEAST_SPREAD_M * 2.0**steps, 0.0)
        sight = np.zeros(len(points_m), np.bool_)
        for spread_m in np.unique(spreads_m):
            members = np.flatnonzero(spreads_m == spread_m)
            sight[members] = self.sees(points_m[members], float(spread_m))
        return sight

    def _ragged_scene(self, spread_m: float) -> tuple[_Scene, ...]:
        """The ground as looks from anywhere on it ask for it."""
        boxes = np.array([area.shape.bounds for area in self._areas if not area.shape.is_empty]).reshape(-1, 4)
        if not len(boxes):
            return ()
        most_m = MOST_SPREAD * self._reach_m if spread_m > 0 else 0.0
        reach_m = self._reach_m + most_m
        box_m = boxes[:, :2].min(axis=0) - reach_m, boxes[:, 2:].max(axis=0) + reach_m
        hidden = _thinner(self._hidden, spread_m, steps=RAGGED_STEPS)
        return _scene_of(self._areas, hidden, box_m, spread_m, self._slack_m, ragged_spread_m=most_m)


def _sees_from_any(
    areas: tuple[StandingArea, ...], hidden: Any, points_m: Floats, spread_m: float, slack_m: float
) -> Flags:
    """Whether each point (n, 2) is seen from any of the areas, within the spread: (n,) flags."""
    if not len(points_m):
        return np.zeros(0, np.bool_)
    box = points_m.min(axis=0), points_m.max(axis=0)
    return _sees_in(_scene_of(areas, _thinner(hidden, spread_m), box, spread_m, slack_m), points_m, spread_m)


def _thinner(hidden: Any, spread_m: float, *, steps: int = 16) -> Any:
    """What blocks sight, thinner by at least a spread. steps: per quarter of a circle round its inner corners."""
    if spread_m == 0:
        return hidden
    least = 1 / math.cos(math.pi / (4 * steps))  # as far as the middles of the steps are to go
    return shapely.buffer(hidden, -max(1.01, 1.01 * least) * spread_m, quad_segs=steps)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Scene:
    """One standing area and what hides it, made ready for looks from places in a box.

    half_m: what the sensor reaches, the spread included. core: what no line of sight may meet. walls, sides,
    crossings: see ``sight_kernels.sees_ground``, in ``grid``. They are not shifted: looks ask how far walls are from a
    point, which float64 tells to the last digit of what it is given, and a shift would round twice.
    """

    area: StandingArea
    half_m: float
    core: Any
    grid: Grid
    walls: Binned
    sides: Binned
    crossings: Binned


def _scene_of(
    areas: tuple[StandingArea, ...],
    hidden: Any,
    box_m: tuple[Floats, Floats],
    spread_m: float,
    slack_m: float,
    *,
    ragged_spread_m: float | None = None,
) -> tuple[_Scene, ...]:
    """A scene for each area that is not empty; box_m: the lower left and the upper right corner.

    ragged_spread_m: on ragged ground, the greatest spread of scenes that share the sides of areas, sorted into cells;
    those are many.
    """
    low, high = box_m
    width, height = np.maximum(high - low, GRID_MARGIN_M)
    core = shapely.buffer(hidden, -slack_m, join_style="mitre")
    shapely.prepare(core)
    wall, walls = shapely.boundary(hidden), segments_of(hidden)
    scenes = []
    for area in areas:
        if area.shape.is_empty:
            continue
        half, square = _half_m(area.sensor) + spread_m, not isinstance(area.sensor, DiscSensor)
        most = half if ragged_spread_m is None else _half_m(area.sensor) + ragged_spread_m
        margin = most * (math.sqrt(2) if square else 1.0) + GRID_MARGIN_M
        # cells to a reach: each keeps all sides in reach of it
        fine = 4 if len(walls) <= RAGGED_SIDES and ragged_spread_m is None else 1
        size = max(margin / fine, math.sqrt(width * height / MOST_GRID_CELLS), max(width, height) / MOST_GRID_CELLS)
        grid = Grid(low[0], low[1], size, int(width / size) + 1, int(height / size) + 1)
        border = shapely.boundary(area.shape)
        shapely.prepare(border)
        crossed = np.empty((0, 2))
        if shapely.intersects(border, wall):  # bodies keep off most walls
            crossed = shapely.get_coordinates(shapely.intersection(border, wall))
        shapely.prepare(area.shape)
        scenes.append(_Scene(
            area=area, half_m=half, core=core, grid=grid, sides=_sides_in_cells(area, margin, grid),
            walls=tiling_kernels.rasterise(walls, margin, grid),
            crossings=tiling_kernels.rasterise(np.hstack([crossed, crossed]), margin, grid),
        ))  # fmt: skip
    return tuple(scenes)


@functools.lru_cache(maxsize=2)
def _sides_in_cells(area: StandingArea, margin_m: float, grid: Grid) -> Binned:
    """The sides of an area, sorted into the cells that they come within the margin of."""
    sides: Binned = tiling_kernels.rasterise(segments_of(area.shape), margin_m, grid)
    return sides


def _half_m(sensor: Sensor) -> float:
    """The radius of a disc, or half the side of a square."""
    return sensor.radius_m if isinstance(sensor, DiscSensor) else sensor.side_m / 2


def _sees_in(scenes: tuple[_Scene, ...], points_m: Floats, spread_m: float) -> Flags:
    """Whether each point (n, 2) is seen from the area of any scene, within the spread: (n,) flags."""
    sight = np.zeros(len(points_m), np.bool_)
    for scene in scenes:
        left = np.flatnonzero(~sight)
        if len(left):
            sight[left] = _sees_from(scene, points_m[left], spread_m)
    return sight


def _sees_from(scene: _Scene, points_m: Floats, spread_m: float) -> Flags:
    """Whether each point (n, 2) is seen from the area of the scene, within the spread: (n,) flags.

    The nearest place to stand decides most; rays decide the rest.
    """
    points, area, half = shapely.points(points_m), scene.area, scene.half_m
    sight: Flags = shapely.dwithin(area.shape, points, spread_m + SLACK_M)
    left = np.flatnonzero(~sight)
    square = not isinstance(area.sensor, DiscSensor)
    if len(left):
        sides = _sides(area)
        nearest = sides.query_nearest(points[left], all_matches=False)[1]
        lines = shapely.shortest_line(points[left], sides.geometries[nearest])
        ends = shapely.get_coordinates(lines).reshape(-1, 2, 2)
        away = np.abs(ends[:, 1] - ends[:, 0])
        far = away.max(axis=1) if square else np.hypot(away[:, 0], away[:, 1])
        sight[left] = (far <= half) & ~shapely.intersects(scene.core, lines)
        # where the nearest place to stand is out of range, all are (a square's corner is the farthest it reaches)
        corner = half * math.sqrt(2) if square else half
        left = left[~sight[left] & (np.hypot(away[:, 0], away[:, 1]) <= corner + SLACK_M)]
    if len(left):
        sight[left] = _ray_test(scene, points_m[left], square)
    return sight


@functools.lru_cache(maxsize=4)
def _sides(area: StandingArea) -> shapely.STRtree:
    """The border of an area in short lines, so that the nearest is found without a look at all.

    A line for each side would take hundreds of megabytes for the round corners of a scanned floor.
    """
    lines = []
    for ring in shapely.get_rings(shapely.get_parts(area.shape)):
        xy = shapely.get_coordinates(ring)
        xy = xy[np.append(True, (xy[1:] != xy[:-1]).any(axis=1))]
        lines += [xy[k : k + LINE_SIDES + 1] for k in range(0, len(xy) - 1, LINE_SIDES)]
    numbers = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
    return shapely.STRtree(shapely.linestrings(np.vstack(lines), indices=numbers))


def _ray_test(scene: _Scene, points_m: Floats, square: bool) -> Flags:
    """Whether each point (n, 2) sees ground within the reach, by rays between all walls: (n,) flags."""
    points = np.ascontiguousarray(points_m)

    def some(part: Floats) -> Flags:
        seen: Flags = sight_kernels.sees_ground(
            part, scene.half_m, square, scene.grid, scene.walls, scene.sides, scene.crossings
        )
        return seen

    if len(points) <= MOST_ALONE:
        return some(points)
    threads = os.cpu_count() or 1
    with ThreadPoolExecutor(max_workers=threads) as pool:
        return np.concatenate(list(pool.map(some, np.array_split(points, 4 * threads))))
