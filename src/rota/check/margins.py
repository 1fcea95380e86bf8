"""What a plan has to spare: of which period, and of what robots see, there is the least, and where."""

from __future__ import annotations

import math

import numpy as np
from shapely import contains_xy, get_coordinates

from rota.check.arrays import Floats, Ints
from rota.check.charging import battery_levels, undocked_routes
from rota.check.demands import DemandedGround, demands_of, visits
from rota.check.margin_report import Margin
from rota.check.pieces import point_pieces
from rota.check.presence import seeing_routes
from rota.check.report import Report
from rota.check.revisits import loop_gap, piece_gaps, sights_along
from rota.check.routes import Routes, routes_of, sensors_of
from rota.check.tolerances import PERIOD_TOLERANCE, slack_of
from rota.model.plan import Plan

MOST_PLACES = 2_000
MOST_CORNERS = 500
CORNER_IN_M = 0.01  # how far inside of a corner it is looked at
STEP = 2.0**-12  # of the reach: how finely a range is told
FEW = 20  # one in so many places is asked for its range before all are


def margins_of(plan: Plan, report: Report) -> tuple[Margin, ...]:
    """The thinnest reserve of each kind of a plan that is met, thinnest first; none where it is not, or asks nothing.

    Of periods it is proved, by the report. Where that is, and by how much less robots may see, is what was found at
    some ``MOST_PLACES`` places.
    """
    if report.verdict != "met" or not report.demands:
        return ()
    tightest = max(report.demands, key=lambda demand: demand.worst_gap_s / demand.period_s)
    looked = _Looked(plan)
    place = looked.worst_place(tightest.name)
    margins = [
        Margin(
            kind="period",
            who=tightest.name,
            robots=looked.robots_that_visit(tightest.name) if place is None else looked.robots_that_see(place),
            spare=max(0.0, tightest.period_s - tightest.worst_gap_s),
            limit=tightest.period_s,
            unit="s",
            place_m=None if place is None or not tightest.worst_gap_s else looked.place_m(place),
            places=None,
        )
    ]
    if len(looked.points_m):
        margins.append(looked.range_margin())
    margins += _battery_margin(plan)
    return tuple(sorted(margins, key=lambda margin: margin.spare / margin.limit))


def _battery_margin(plan: Plan) -> list[Margin]:
    """The robot whose battery comes nearest to its reserve, and where; none where batteries never run low.

    Levels are told for ever by two rounds of a plan that is met.
    """
    found = []
    for way in plan:
        robot = plan.mission.fleet.robot(way.robot)
        if robot.battery.endurance_s is None:
            continue
        levels = battery_levels(plan, way)
        least = int(levels.levels_s.argmin())
        x, y = way.at(levels.times_s[least])[:2]
        found.append(
            Margin(
                kind="battery",
                who=way.robot,
                robots=(),
                spare=max(0.0, float(levels.levels_s[least]) - robot.battery.reserve_s),
                limit=robot.battery.endurance_s,
                unit="s",
                place_m=(float(x), float(y)),
                places=None,
            )
        )
    return [min(found, key=lambda margin: margin.share)] if found else []


def worst_ratio_of(plan: Plan) -> float:
    """The longest gap over its period at some ``MOST_PLACES`` places that are seen, and between visits.

    Much less work than the check, and no proof.
    """
    looked = _Looked(plan, in_time=False)
    ratios = [float((looked.gaps_s / looked.periods_s).max(initial=0.0))]
    for demand in demands_of(plan.mission):
        if demand.demand == "visit":
            inside = visits(looked.routes.legs_m, demand.region, slack_of(plan.mission))
            ratios.append(loop_gap(looked.routes, inside)[0] / demand.period_s)
    return max(ratios)


class _Looked:
    """Places of a plan's ground, and how long they wait: points_m (n, 2), owners, gaps_s (n,).

    in_time: only those that are seen within their periods. What nobody can see, or lies so near a border that nobody
    does, is left out in any case.
    """

    def __init__(self, plan: Plan, *, in_time: bool = True) -> None:
        self.plan, self.routes = plan, seeing_routes(undocked_routes(routes_of(plan), plan), plan)
        self.reaches_m, self.squares = sensors_of(plan)
        self.demands = [each for each in demands_of(plan.mission) if each.demand == "every_point" and not each.sensors]
        points = [_points_m(each, sum(other.region.area for other in self.demands)) for each in self.demands]
        self.points_m = np.ascontiguousarray(np.vstack([np.empty((0, 2)), *points]))
        self.owners = np.repeat(np.arange(len(points)), [len(each) for each in points])
        self.periods_s = np.array([each.period_s for each in self.demands])[self.owners] * (1 + PERIOD_TOLERANCE)
        self.gaps_s = self._gaps_s(self.points_m, 0.0)
        met = self.gaps_s <= (self.periods_s if in_time else np.finfo(np.float64).max)
        self.points_m, self.owners, self.periods_s = self.points_m[met], self.owners[met], self.periods_s[met]
        self.gaps_s = self.gaps_s[met]

    def worst_place(self, name: str) -> int | None:
        """The place of a demand that waits longest; None for a zone to visit."""
        own = np.flatnonzero([self.demands[k].name == name for k in self.owners])
        return int(own[self.gaps_s[own].argmax()]) if len(own) else None

    def place_m(self, place: int) -> tuple[float, float]:
        """Where a place is."""
        return float(self.points_m[place, 0]), float(self.points_m[place, 1])

    def robots_that_see(self, place: int) -> tuple[str, ...]:
        """The names of the robots that see a place."""
        seen = []
        for robot, way in enumerate(self.plan):
            own = self.routes.robots == robot
            gap_s = self._gaps_s(self.points_m[place : place + 1], 0.0, self.routes.legs(own))
            seen += [way.robot] if math.isfinite(gap_s[0]) else []
        return tuple(seen)

    def robots_that_visit(self, name: str) -> tuple[str, ...]:
        """The names of the robots that come to a zone to visit."""
        region = next(each.region for each in demands_of(self.plan.mission) if each.name == name)
        legs = [leg for leg, _, _ in visits(self.routes.legs_m, region, slack_of(self.plan.mission))]
        own = set(self.routes.robots[legs].tolist())
        return tuple(way.robot for robot, way in enumerate(self.plan) if robot in own)

    def range_margin(self) -> Margin:
        """By how much less all robots may see until the first place waits longer than its period."""
        reach_m = float(self.reaches_m.min())
        spare_m, late = self._least_range(np.arange(len(self.points_m))[::FEW], reach_m)
        found = self._late(np.arange(len(self.points_m)), spare_m)
        if len(found):
            spare_m, late = self._least_range(found, spare_m)
        place = int(late[0])
        return Margin(
            kind="range",
            who=self.demands[self.owners[place]].name,
            robots=self.robots_that_see(place),
            spare=spare_m,
            limit=reach_m,
            unit="m",
            place_m=self.place_m(place),
            places=len(self.points_m),
        )

    def _least_range(self, places: Ints, most_m: float) -> tuple[float, Ints]:
        """By how much less all robots may see before the first of some places is late, and those that are late then."""
        low_m, high_m, late = 0.0, most_m, places
        while high_m - low_m > STEP * float(self.reaches_m.min()):
            middle_m = (low_m + high_m) / 2
            found = self._late(late, middle_m)
            if len(found):
                high_m, late = middle_m, found
            else:
                low_m = middle_m
        return low_m, late

    def _late(self, places: Ints, less_m: float) -> Ints:
        """Those of some places that wait longer than their periods where all robots see so much less far."""
        return places[self._gaps_s(self.points_m[places], less_m) > self.periods_s[places]]

    def _gaps_s(self, points_m: Floats, less_m: float, routes: Routes | None = None) -> Floats:
        """How long points (n, 2) wait where all robots see so much less far."""
        if not len(points_m):
            return np.empty(0)
        low, high = points_m.min(axis=0), points_m.max(axis=0)
        sensors = (self.reaches_m - less_m, self.squares)
        bounds_m = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
        sights = sights_along(self.routes if routes is None else routes, sensors, self.plan.mission, bounds_m)
        return piece_gaps(sights, point_pieces(points_m), np.zeros(len(points_m))).gaps_s


def _points_m(demand: DemandedGround, whole_m2: float) -> Floats:
    """Points (n, 2) of a demand's ground: a lattice, its share of ``MOST_PLACES``, and places just inside corners."""
    x0, y0, x1, y1 = demand.region.bounds
    step_m = math.sqrt(whole_m2 / MOST_PLACES)
    columns, rows = (max(1, math.ceil((high - low) / step_m)) for low, high in ((x0, x1), (y0, y1)))
    x, y = np.meshgrid(
        x0 + (np.arange(columns) + 0.5) * (x1 - x0) / columns, y0 + (np.arange(rows) + 0.5) * (y1 - y0) / rows
    )
    inside = contains_xy(demand.region, x, y)
    corners_m = get_coordinates(demand.region.buffer(-CORNER_IN_M, join_style="mitre"))
    step = math.ceil(max(1, len(corners_m)) / MOST_CORNERS)
    return np.vstack([np.column_stack([x[inside], y[inside]]), corners_m[::step]])
