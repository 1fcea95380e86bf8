"""How long each place stays unseen: exact for points, an upper bound for convex pieces, on every leg in closed form."""

from __future__ import annotations

import functools
import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from shapely import contains_xy, intersects_xy, prepare

from rota.check import gap_kernels, kernels, lateness_kernels, passing_kernels, tiling_kernels, window_kernels
from rota.check.arrays import Binned, Flags, Floats, Grid, Ints, Legs, Loops, Scene, SeenTimes, Team, Ways
from rota.check.blocking import blocks_sight
from rota.check.charging import undocked_routes
from rota.check.counting import counting_robots
from rota.check.demands import demands_of
from rota.check.pieces import Pieces, point_pieces
from rota.check.presence import seeing_routes
from rota.check.routes import HOLD, TRANSIENT, Routes, routes_of, segments_of, sensors_of
from rota.check.timing_kernels import time_along
from rota.check.tolerances import GRID_MARGIN_M, ROUNDING, slack_of
from rota.model.mission import Mission
from rota.model.plan import Plan

MOST_GRID_CELLS = 1_000_000
MOST_ALONE = 200  # pieces that one thread looks at by itself


@dataclass(frozen=True, kw_only=True, eq=False)
class Sights:
    """A plan made ready to be asked what it sees: legs and walls, found through one grid over the asked places.

    reach_m: the farthest that any robot sees, with a margin. walls: for places within bounds_m (x0, y0, x1, y1) and
    pieces within reach of their middles, since what hides part of one of these lies in reach of its middle, too.
    window_s: None for a plan, which goes on for ever; from when to when for a recording. seam: of a plan that takes
    over from another one: gaps are asked for that end after a moment.
    """

    routes: Routes
    origin_m: Floats
    slack_m: float
    grid: Grid
    legs: Legs
    team: Team
    walls: Binned
    bounds_m: tuple[float, float, float, float]
    reach_m: float
    hidden: Any
    window_s: tuple[float, float] | None = None
    seam: SeamSights | None = None

    @functools.cached_property
    def far_walls(self) -> Binned:
        """The walls for any pieces: what hides part of one from a place in reach of all of it is in twice the reach."""
        far: Binned = tiling_kernels.rasterise(self.walls.segments_m, 2 * self.reach_m, self.grid)
        return far

    def walls_for(self, pieces: Pieces) -> Binned:
        """The walls that may hide part of these pieces from a place in reach of all of it."""
        low, high = pieces.corners_m.min(axis=0), pieces.corners_m.max(axis=0)
        x0, y0, x1, y1 = self.bounds_m
        inside = x0 <= low[0] and y0 <= low[1] and high[0] <= x1 and high[1] <= y1
        small = math.sqrt(2) * pieces.sizes_m().max() <= self.reach_m
        return self.walls if inside and small else self.far_walls


@dataclass(frozen=True, kw_only=True, eq=False)
class SeamSights:
    """What was seen before a plan took over, each leg once, and moments_s: see ``lateness_kernels.late_between``."""

    before: Sights
    moments_s: tuple[float, float, float, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class Gaps:
    """Worst gaps of n places: gaps_s (inf: never seen), begins_s (nan: not known), first sight firsts_s, all (n,).

    ``exact`` False: too many loops of too many durations; the gap is then an upper bound even for a single point.
    """

    gaps_s: Floats
    begins_s: Floats
    firsts_s: Floats
    exact: Flags


def sights_of(plan: Plan, bounds_m: tuple[float, float, float, float]) -> Sights:
    """Legs and walls of a plan in a grid over ``bounds_m`` (x0, y0, x1, y1 of all places that will be asked)."""
    return sights_along(
        seeing_routes(undocked_routes(routes_of(plan), plan), plan), sensors_of(plan), plan.mission, bounds_m
    )


def sights_along(
    routes: Routes,
    sensors: tuple[Floats, Flags],
    mission: Mission,
    bounds_m: tuple[float, float, float, float],
    window_s: tuple[float, float] | None = None,
) -> Sights:
    """The same of routes whose robots have ``sensors``: reaches and which of them are squares, see ``sensors_of``."""
    reaches, squares = sensors
    reach = float((reaches * np.where(squares, math.sqrt(2), 1.0)).max(initial=0.0))
    x0, y0, x1, y1 = bounds_m
    origin = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
    size = max(reach / 2, math.sqrt(max(x1 - x0, GRID_MARGIN_M) * max(y1 - y0, GRID_MARGIN_M) / MOST_GRID_CELLS))
    size = max(size, (x1 - x0) / MOST_GRID_CELLS, (y1 - y0) / MOST_GRID_CELLS)
    columns, rows = math.floor((x1 - x0) / size) + 1, math.floor((y1 - y0) / size) + 1
    grid = Grid(x0 - origin[0], y0 - origin[1], size, columns, rows)
    four = np.tile(origin, 2)
    legs = np.ascontiguousarray(routes.legs_m - four)
    blocking = blocks_sight(mission.obstacles)
    walls = np.ascontiguousarray(segments_of(blocking) - four)
    reach_m = reach * (1 + ROUNDING) + GRID_MARGIN_M
    near = tiling_kernels.rasterise(legs, reach_m, grid)
    first, way_of = _ways_of(legs, routes.robots, sensors)
    own = routes.robots[first]
    ways = Ways(
        near=tiling_kernels.rasterise(legs[first], reach_m, grid),
        reaches_m=reaches[own],
        squares=squares[own],
        widest_m=float(reaches[own].max(initial=0.0)),
    )
    return Sights(
        routes=routes,
        origin_m=origin,
        slack_m=slack_of(mission),
        grid=grid,
        legs=Legs(near, routes.times_s, routes.bends, routes.robots, routes.kinds, ways, way_of),
        team=Team(reaches, squares, Loops(routes.classes, routes.parts, routes.units_s, routes.from_s)),
        walls=tiling_kernels.rasterise(walls, reach_m, grid),
        bounds_m=bounds_m,
        reach_m=reach_m,
        hidden=blocking,
        window_s=window_s,
    )


def _ways_of(legs_m: Floats, robots: Ints, sensors: tuple[Floats, Flags]) -> tuple[Ints, Ints]:
    """The first leg of each way, (w,) ascending, and the way (m,) that each leg (m, 4) goes; see ``Ways``."""
    if not len(legs_m):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    reaches, squares = sensors
    keys = (*legs_m.T, reaches[robots], squares[robots])
    order = np.lexsort(keys)
    other = np.concatenate([[True], np.any([key[order][1:] != key[order][:-1] for key in keys], axis=0)])
    starts = np.flatnonzero(other)
    firsts = np.minimum.reduceat(order, starts)
    rank = np.argsort(np.argsort(firsts))
    way_of = np.empty(len(legs_m), np.int64)
    way_of[order] = rank[np.cumsum(other) - 1]
    return np.sort(firsts), way_of


def piece_gaps(sights: Sights, pieces: Pieces, limits_s: Floats) -> Gaps:
    """Worst gap of each piece: no point of it waits longer. limits_s: (n,) beyond which more effort is worth it."""
    seam = sights.seam
    if not len(pieces) or not (len(sights.team.reaches_m) or seam):
        return _never(len(pieces))

    def gaps_of(*arguments: Any) -> Any:
        if seam is not None:
            return lateness_kernels.late_gaps(*arguments)[:4]
        if sights.window_s is None:
            return kernels.worst_gaps(*arguments)
        within = (*arguments[:2], *arguments[3:], sights.window_s)  # limits say nothing there
        return window_kernels.gaps_within(*within)

    gaps_s, begins_s, firsts_s, exact = _in_parts(gaps_of, sights, pieces, limits_s)
    return Gaps(gaps_s=gaps_s, begins_s=begins_s, firsts_s=firsts_s, exact=exact)


def passing_gaps(sights: Sights, pieces: Pieces, limits_s: Floats) -> Gaps:
    """Worst gap of each piece that no single view may take in: each of its points is seen at a moment of its own.

    Only robots that drive one leg again and again count. The gap is inf where that does not show that all of a piece is
    seen; so it is for a recording.
    """
    if not len(sights.team.reaches_m) or not len(pieces) or sights.window_s is not None or sights.seam is not None:
        return _never(len(pieces))
    gaps_s, firsts_s = _in_parts(passing_kernels.passing_gaps, sights, pieces, limits_s)
    n = len(pieces)
    return Gaps(gaps_s=gaps_s, begins_s=np.full(n, np.nan), firsts_s=firsts_s, exact=np.zeros(n, np.bool_))


def _never(n: int) -> Gaps:
    """Gaps of n pieces that nobody sees."""
    never = np.full(n, np.inf)
    return Gaps(gaps_s=never, begins_s=np.full(n, np.nan), firsts_s=never, exact=np.ones(n, np.bool_))


def _in_parts(
    kernel: Callable[..., tuple[Any, ...]], sights: Sights, pieces: Pieces, limits_s: Floats
) -> tuple[Any, ...]:
    """The arrays (n,) that a kernel gives for n pieces, each thread looking at a part of them."""
    threads = 1 if len(pieces) <= MOST_ALONE else os.cpu_count() or 1
    if threads == 1:
        return kernel(*_arguments(sights, pieces, limits_s))
    cuts = np.array_split(np.arange(len(pieces)), threads)
    arguments = [_arguments(sights, pieces.choose(cut), limits_s[cut]) for cut in cuts]
    with ThreadPoolExecutor(max_workers=threads) as pool:
        parts = list(pool.map(lambda part: kernel(*part), arguments))
    return tuple(np.concatenate(arrays) for arrays in zip(*parts, strict=True))


def _arguments(sights: Sights, pieces: Pieces, limits_s: Floats) -> tuple[Any, ...]:
    """What ``worst_gaps`` and ``passing_gaps`` are given."""
    corners = np.ascontiguousarray(pieces.corners_m - sights.origin_m)
    limits = np.ascontiguousarray(limits_s, np.float64)
    seen = sights.grid, sights.legs, sights.team, sights.walls_for(pieces)
    if (seam := sights.seam) is not None:
        old = seam.before
        before = Scene(old.grid, old.legs, old.team, old.walls_for(pieces))
        return pieces.offsets, corners, limits, sights.slack_m, Scene(*seen), before, seam.moments_s
    return pieces.offsets, corners, limits, sights.slack_m, *seen


def late_points(sights: Sights, points_m: Floats, period_s: float) -> tuple[Floats, Floats, Floats, Floats]:
    """``late_between`` of points (n, 2): four arrays (n,)."""
    periods_s = np.full(len(points_m), period_s)
    if not len(points_m):
        return periods_s, periods_s, periods_s, periods_s
    found = _in_parts(lateness_kernels.late_gaps, sights, point_pieces(points_m), periods_s)
    return found[0], found[1], found[4], found[5]


def swath_cuts(sights: Sights, pieces: Pieces) -> Floats:
    """For each piece a line (n, 3) nx, ny, c: n.p = c, along the edge of what some leg sees; nan: none crosses it.

    A piece across the edges of two swaths looks unseen until it is cut there, however thin the swaths' overlap is.
    """
    corners = np.ascontiguousarray(pieces.corners_m - sights.origin_m)
    lines: Floats = tiling_kernels.swath_cuts(
        pieces.offsets, corners, sights.grid, sights.legs.ways, 100 * sights.slack_m
    )
    lines[:, 2] += lines[:, :2] @ sights.origin_m
    return lines


def worst_gaps_s(plan: Plan, points_m: Floats) -> Floats:
    """Worst revisit gap (n,) in seconds at each of ``points_m`` (n, 2), from the latest loop start on; inf: never seen.

    A point inside an obstacle that blocks sight is never seen. A plan without robots sees nothing. In zones that name
    the sensors that count only these see anything.
    """
    gaps_s = _gaps_at(plan, points_m)
    for demand in demands_of(plan.mission):
        if demand.sensors and demand.demand == "every_point":
            inside = np.flatnonzero(intersects_xy(demand.region, *points_m.T))
            gaps_s[inside] = _gaps_at(counting_robots(plan, demand.sensors), points_m[inside])
    return gaps_s


def _gaps_at(plan: Plan, points_m: Floats) -> Floats:
    """The same, whatever sensors robots have."""
    points = point_pieces(points_m)
    if not len(points):
        return np.empty(0)
    low, high = points.corners_m.min(axis=0), points.corners_m.max(axis=0)
    sights = sights_of(plan, (low[0], low[1], high[0], high[1]))
    gaps = piece_gaps(sights, points, np.zeros(len(points))).gaps_s
    # a robot may stand in the same hedge, with no wall between
    prepare(sights.hidden)
    return np.where(contains_xy(sights.hidden, *points.corners_m.T), np.inf, gaps)


def loop_gap(
    routes: Routes, inside: list[tuple[int, float, float]], window_s: tuple[float, float] | None = None
) -> tuple[float, float]:
    """Worst gap between visits in seconds, and the time at which it begins (nan: not known).

    inside: (leg, from, to) in 0..1, ascending: the parts of the legs that count as a visit. inf without any. window_s:
    see ``Sights``.
    """
    starts: list[float] = []
    ends: list[float] = []
    robots: list[int] = []
    bounds = [0]
    for leg, lo, hi in inside:
        if routes.kinds[leg] == HOLD:
            return 0.0, routes.from_s
        if routes.kinds[leg] == TRANSIENT:
            continue
        start, end = (time_along(*routes.times_s[leg], routes.bends[leg], share) for share in (lo, hi))
        if not robots or robots[-1] != routes.robots[leg]:
            robots.append(int(routes.robots[leg]))
            bounds.append(bounds[-1])
        if bounds[-1] > bounds[-2] and start <= ends[-1]:
            ends[-1] = max(ends[-1], end)
        else:
            starts.append(start)
            ends.append(end)
            bounds[-1] += 1
    if not robots:
        return math.inf, math.nan
    times = SeenTimes(np.array(starts), np.array(ends), np.array(bounds, np.int64), np.array(robots, np.int64))
    if window_s is not None:
        gap, begin = window_kernels.gap_within(times, len(robots), *window_s)
        return float(gap), float(begin)
    loops = Loops(routes.classes, routes.parts, routes.units_s, routes.from_s)
    gap, begin, _ = gap_kernels.team_gap(times, len(robots), loops, 0.0)
    return float(gap), float(begin)
