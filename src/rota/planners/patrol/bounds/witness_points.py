"""Points that stand for what is asked, and how far apart the places are from which they can be seen, at least."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from scipy.sparse import csc_array
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from rota.geometry.free_space import DemandedRegion, border_segments, standing_space
from rota.geometry.line_of_sight import visibility_polygon
from rota.geometry.shortest_path import ShortestPaths
from rota.model.arrays import Flags, Floats, Ints
from rota.model.mission import Mission, SquareSensor
from rota.model.polygons import polygons_of
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.samples import SamplePoints
from rota.planners.patrol.ground.surroundings import MANY_WALLS
from rota.planners.patrol.ground.viewpoints import Viewpoints

MOST_SPREAD_OUT = 120  # witnesses that lie far from each other, and places in the linear program for visits
MOST_LOOKED_AT = 20_000  # samples among which witnesses are chosen, for each period, or of which chains are made
ROOM = 1e-4  # of the reach: what blocks is made thinner by it, so that rounding and tolerances only lower the bound


@dataclass(frozen=True, kw_only=True)
class Witnesses:
    """Points (or zones to visit), each of which must be served once in every window of its period.

    period_s: (n,). centre_m: (n, 2), spread_m: (n,); whoever serves a point stands at most ``spread_m`` of travel from
    its centre, and at most ``range_m`` (n,) straight; where corners (n,) is not 0, in the convex polygon with so many
    corner_m (n, c, 2), anticlockwise. way_m: (n, n) ways between the centres, never longer than those of any robot; inf
    where there is none. component: (n,) the component of the standing space that a point is served from, -1 when there
    are several. components: how many the space has.
    """

    centre_m: Floats
    spread_m: Floats
    range_m: Floats
    corners: Ints
    corner_m: Floats
    period_s: Floats
    way_m: Floats
    component: Ints
    components: int

    def __len__(self) -> int:
        return len(self.period_s)

    @cached_property
    def apart_m(self) -> Floats:
        """(n, n) metres at least between a place that serves one and a place that serves the other; 0 on itself."""
        apart = np.maximum(0.0, self.way_m - self.spread_m[:, None] - self.spread_m[None, :])
        row, column = self.component[:, None], self.component[None, :]
        apart[(row >= 0) & (column >= 0) & (row != column)] = np.inf
        np.fill_diagonal(apart, 0.0)
        return apart

    def choose(self, which: Flags | Ints) -> Witnesses:
        """Those at the numbers, or the flags, ``which``."""
        which = np.flatnonzero(which) if which.dtype == np.bool_ else which
        return Witnesses(
            centre_m=self.centre_m[which],
            spread_m=self.spread_m[which],
            range_m=self.range_m[which],
            corners=self.corners[which],
            corner_m=self.corner_m[which],
            period_s=self.period_s[which],
            way_m=self.way_m[np.ix_(which, which)],
            component=self.component[which],
            components=self.components,
        )


def witnesses_of(problem: Problem, reach_m: float) -> Witnesses:
    """Well chosen samples, all of which some robot can see, and all zones to visit.

    reach_m: the farthest that any robot of the fleet sees. Obstacles count as a little smaller than they are and ways
    are measured for a body of no width, so that no true way is shorter. Points whose views cannot be bounded are
    absent. On ground with very many corners ways are measured straight, see ``_straight_witnesses``.
    """
    mission, regions, points, periods_s = problem.mission, problem.regions, problem.points, problem.periods_s
    chosen = _chosen_samples(points, problem.viewpoints, reach_m)
    if _corners_of(mission) > MANY_WALLS:
        return _straight_witnesses(regions, periods_s, points[chosen], reach_m)
    space = _WiderSpace(mission, reach_m)
    served = [
        (place, periods_s[points.period[i]]) for i in chosen if (place := space.where_seen(points.xy_m[i])) is not None
    ]
    served += [
        (place, region.period_s)
        for region in regions
        if region.demand == "visit" and (place := space.where_inside(region.shape)) is not None
    ]
    centre = np.array([place.centre_m for place, _ in served]).reshape(-1, 2)
    return Witnesses(
        centre_m=centre,
        spread_m=np.array([place.spread_m for place, _ in served]),
        range_m=np.array([place.range_m for place, _ in served]),
        corners=np.array([0 if place.hull is None else len(place.hull) for place, _ in served], dtype=np.int64),
        corner_m=_pad([place.hull for place, _ in served]),
        period_s=np.array([period for _, period in served], dtype=np.float64),
        way_m=space.paths.all_pairs(centre),
        component=np.array([place.component for place, _ in served], dtype=np.int64),
        components=len(space.components),
    )


def _corners_of(mission: Mission) -> int:
    """Corners of the area and of all that blocks motion or sight."""
    return int(shapely.get_num_coordinates([mission.area, *(o.shape for o in mission.obstacles)]).sum())


def _straight_witnesses(
    regions: Sequence[DemandedRegion], periods_s: Sequence[float], points: SamplePoints, reach_m: float
) -> Witnesses:
    """The same with straight distances for ways: sound, as no way is shorter, and weaker, as walls count for nothing.

    Whoever sees a point is within the reach of it; whoever is inside a zone is no farther from a point of it than the
    zone's farthest corner. Nothing is said about components that nobody can travel between.
    """
    zones = [region for region in regions if region.demand == "visit"]
    middles = [shapely.get_coordinates(shapely.point_on_surface(zone.shape))[0] for zone in zones]
    radii = [
        float(np.hypot(*(shapely.get_coordinates(zone.shape) - middle).T).max())
        for zone, middle in zip(zones, middles, strict=True)
    ]
    centre = np.vstack([points.xy_m, *(middle[None] for middle in middles)])
    count = len(centre)
    spread_m = np.concatenate([np.full(len(points), reach_m), radii]) * (1 + ROOM)
    return Witnesses(
        centre_m=centre,
        spread_m=spread_m,
        range_m=spread_m,
        corners=np.zeros(count, dtype=np.int64),
        corner_m=_pad([None] * count),
        period_s=np.concatenate([np.array(periods_s)[points.period], [zone.period_s for zone in zones]]),
        way_m=np.hypot(*(centre[:, None] - centre[None]).transpose(2, 0, 1)),
        component=np.full(count, -1, dtype=np.int64),
        components=1,
    )


@dataclass(frozen=True, kw_only=True)
class _Place:
    centre_m: Floats
    spread_m: float
    range_m: float
    hull: Floats | None
    component: int


class _WiderSpace:
    """Where any robot of a fleet may stand, travel and look, a little wider than it is: no bound is too high."""

    def __init__(self, mission: Mission, reach_m: float) -> None:
        room_m = ROOM * reach_m
        robots = mission.fleet.unlike_robots
        body_m = min(robot.body_radius_m for robot in robots)
        self.reach_m = reach_m * (1 + ROOM)
        are_squares = all(isinstance(robot.sensor, SquareSensor) for robot in robots)
        self.half_side_m = self.reach_m / math.sqrt(2) if are_squares else math.inf
        self.travel = polygons_of(standing_space(mission, 0.0).buffer(room_m, join_style="mitre"))
        thin_m = max(0.0, 0.998 * body_m - room_m)  # circumscribed arcs of 64 corners stay within the true ones
        standing = standing_space(mission, thin_m, arc_corners=64) if thin_m > 0 else self.travel
        self.components = list(standing.geoms)
        self.paths = ShortestPaths(self.travel)
        x0, y0, x1, y1 = shapely.box(*self.travel.bounds).buffer(4 * reach_m).bounds
        closed = shapely.difference(shapely.box(x0, y0, x1, y1), self.travel)
        self.borders = border_segments(polygons_of(closed))
        hidden = shapely.union_all([o.shape for o in mission.obstacles if o.blocks_sight])
        self.walls = border_segments(polygons_of(hidden.buffer(-room_m, join_style="mitre")))
        self.hull = shapely.convex_hull(self.travel)
        shapely.prepare(self.travel)

    def where_seen(self, point_m: Floats) -> _Place | None:
        """Where a robot may stand to see a point (2,); None where the ways there have no known bound."""
        view = shapely.intersection(visibility_polygon(point_m, self.walls, self.reach_m), self.travel)
        if view.is_empty:
            return None
        if not shapely.contains_xy(self.travel, *point_m):
            return self._place(shapely.get_coordinates(shapely.point_on_surface(view))[0], view, None, None)
        corners = shapely.get_coordinates(view) - point_m
        spread_m = within_m = min(self.reach_m, float(np.hypot(corners[:, 0], corners[:, 1]).max()))
        if not _is_convex(view):  # or else all of it is reached straight
            straight = visibility_polygon(point_m, self.borders, self.reach_m)
            bent = shapely.difference(view, straight.buffer(1e-3 * ROOM * self.reach_m))
            spread_m = max(within_m, self._farthest(point_m, bent))
        return self._place(point_m, view, spread_m, within_m)

    def where_inside(self, shape: MultiPolygon) -> _Place | None:
        """The same for standing inside a zone."""
        inside = shapely.intersection(shape.buffer(ROOM * self.reach_m, join_style="mitre"), self.travel)
        if inside.is_empty:
            return None
        hull = shapely.convex_hull(inside)
        if shapely.contains(self.travel, hull):  # all of it is reached straight
            middle = shapely.get_coordinates(shapely.centroid(hull))[0]
            corners = shapely.get_coordinates(hull) - middle
            return self._place(middle, inside, float(np.hypot(*corners.T).max()), None)
        middle = shapely.get_coordinates(shapely.point_on_surface(inside))[0]
        return self._place(middle, inside, None, None)

    def _place(
        self, centre_m: Floats, views: BaseGeometry, spread_m: float | None, range_m: float | None
    ) -> _Place | None:
        """The place that holds ``views``; what is None, of how far they are from the centre, is measured."""
        if spread_m is None:
            spread_m = self._farthest(centre_m, views)
        if range_m is None:
            range_m = float(np.hypot(*(shapely.get_coordinates(views) - centre_m).T).max())
        if not np.isfinite(spread_m):
            return None
        within = [k for k, component in enumerate(self.components) if component.intersects(views)]
        component = within[0] if len(within) == 1 else -1
        hull = self._hull(centre_m, views, range_m)
        return _Place(centre_m=centre_m, spread_m=spread_m, range_m=range_m, hull=hull, component=component)

    def _hull(self, centre_m: Floats, views: BaseGeometry, range_m: float) -> Floats | None:
        """The corners of a convex polygon round the views, where it is much smaller than what the range tells."""
        hull, disc = shapely.convex_hull(views), shapely.Point(centre_m).buffer(range_m)
        if np.isfinite(self.half_side_m):
            x, y = centre_m
            h = self.half_side_m
            hull = shapely.intersection(hull, shapely.box(x - h, y - h, x + h, y + h))
        if hull.area > 0.93 * shapely.intersection(disc, self.hull).area:
            return None
        few = shapely.simplify(hull, 0.01 * range_m)
        few = shapely.convex_hull(shapely.buffer(few, 0.0101 * range_m, join_style="mitre"))
        return shapely.get_coordinates(shapely.normalize(few).exterior)[-2::-1] if isinstance(few, Polygon) else None

    def _farthest(self, centre_m: Floats, shape: BaseGeometry) -> float:
        """A bound on the ways from the centre to the points of a shape in the travel space; 0 when it is empty."""
        step_m = self.reach_m / 8  # between points on the border of a view
        farthest = 0.0
        for polygon in polygons_of(shape).geoms:
            border = np.unique(shapely.get_coordinates(shapely.segmentize(polygon.boundary, step_m)), axis=0)
            ways = self.paths.distances(centre_m[None], border)
            # from any point within straight to the border, and along it to the next of these
            farthest = max(farthest, float(ways.max()) + float(np.sqrt(polygon.area / np.pi)) + step_m / 2)
        return farthest


def _is_convex(shape: BaseGeometry) -> bool:
    """Whether it is one polygon that bends to one side only, but for rounding."""
    step = np.diff(shapely.get_coordinates(shape), axis=0)
    after, rounding = np.roll(step, -1, axis=0), 1e-12 * float((step * step).sum())
    bend = step[:, 0] * after[:, 1] - step[:, 1] * after[:, 0]
    bends_once = bool((bend >= -rounding).all() or (bend <= rounding).all())
    return bends_once and isinstance(shape, Polygon) and not len(shape.interiors)


def _pad(hulls: Sequence[Floats | None]) -> Floats:
    """The corners (n, c, 2) of all hulls; zeros after those of each."""
    corner_m = np.zeros((len(hulls), max([1, *(len(hull) for hull in hulls if hull is not None)]), 2))
    for k, hull in enumerate(hulls):
        if hull is not None:
            corner_m[k, : len(hull)] = hull
    return corner_m


def _chosen_samples(points: SamplePoints, viewpoints: Viewpoints, reach_m: float) -> Ints:
    """Samples far from each other, and samples that hardly any place sees, for every period and all shorter ones."""
    inside = np.flatnonzero((points.visit_m == 0) & ((points.shrink_m > 0) | _well_seen(points, viewpoints, reach_m)))
    if not len(inside):
        return inside
    seen_by = np.bincount(viewpoints.seen, minlength=len(points))
    inside = inside[np.lexsort((inside, seen_by[inside]))]
    classes = np.unique(points.period[inside])
    fewest = 12  # of a period
    each = max(fewest, MOST_SPREAD_OUT // len(classes))
    chosen: list[int] = []
    for c in classes[:: max(1, len(classes) * fewest // MOST_SPREAD_OUT)]:
        among = inside[points.period[inside] <= c]
        among = among[:: max(1, len(among) // MOST_LOOKED_AT)]
        chosen += _spread_out(points.xy_m, among, chosen, each, reach_m / 2)
    chosen += _points_apart(_who_sees(viewpoints, inside[:MOST_LOOKED_AT], len(points)), inside[:MOST_LOOKED_AT])
    return np.array(list(dict.fromkeys(chosen)), dtype=np.int64)


def _who_sees(viewpoints: Viewpoints, among: Ints, count: int) -> csc_array:
    """Which places see some of so many points, places by points; of all points it would take a third as much again."""
    is_asked = np.zeros(count, dtype=np.bool_)
    is_asked[among] = True
    asked = np.flatnonzero(is_asked[viewpoints.seen])
    place = np.searchsorted(viewpoints.start, asked, side="right") - 1
    shape = len(viewpoints.start) - 1, count
    return csc_array((np.ones(len(asked), dtype=np.int8), (place, viewpoints.seen[asked])), shape=shape)


def _well_seen(points: SamplePoints, viewpoints: Viewpoints, reach_m: float) -> Flags:
    """Which points (n,) some place sees that is not at the limit of its range: all about them is seen, too."""
    seen = np.zeros(len(points), dtype=np.bool_)
    some = 200  # places that are asked together
    for first in range(0, len(viewpoints.xy_m), some):
        start = viewpoints.start[first : first + some + 1]
        own, sizes = viewpoints.seen[start[0] : start[-1]], np.diff(start)
        away_m = points.xy_m[own] - np.repeat(viewpoints.xy_m[first : first + some], sizes, axis=0)
        seen[own[np.hypot(*away_m.T) < 0.9 * reach_m]] = True
    return seen


def _spread_out(xy_m: Floats, among: Ints, already: list[int], count: int, nearest_m: float) -> list[int]:
    """Up to ``count`` points, each as far as can be from those before and not nearer than ``nearest_m``."""
    away, (x, y) = np.full(len(among), np.inf), np.ascontiguousarray(xy_m[among].T)
    for i in already:
        np.minimum(away, np.hypot(x - xy_m[i, 0], y - xy_m[i, 1]), out=away)
    spread: list[int] = []
    for _ in range(count):
        k = int(np.argmax(away))
        if away[k] < nearest_m:
            break
        spread.append(int(among[k]))
        np.minimum(away, np.hypot(x - x[k], y - y[k]), out=away)
    return spread


def _points_apart(sees: csc_array, among: Ints) -> list[int]:
    """Points no two of which any place sees, taken in their order. sees: places by points, by columns."""
    used = np.zeros(sees.shape[0], dtype=bool)
    hidden: list[int] = []
    for i in among:
        viewers = sees.indices[sees.indptr[i] : sees.indptr[i + 1]]
        if not used[viewers].any():
            used[viewers] = True
            hidden.append(int(i))
            if len(hidden) == 40:  # witnesses that hardly any place sees
                break
    return hidden
