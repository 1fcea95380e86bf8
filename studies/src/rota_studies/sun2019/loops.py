"""The loops of a plan, each with the sub-region whose period it must keep."""

from __future__ import annotations

import math

from shapely import LineString, Point

from rota.draw.routes import Route, routes_of
from rota.model.mission import AREA
from rota.model.plan import Plan
from rota.planning.plan_summary import robot_rows
from rota_studies.sun2019.results import Loop


def loops_of(plan: Plan) -> tuple[Loop, ...]:
    """The loops of a plan, the shortest first."""
    found = (Loop(_kept_zone(plan, route), route.duration_s, len(route.robots)) for route in routes_of(plan))
    return tuple(sorted(found, key=lambda loop: loop.duration_s))


def _kept_zone(plan: Plan, route: Route) -> str | None:
    """The sub-region with the smallest period that a loop serves; None when it serves none.

    Between equal periods, the sub-region in which more of the loop lies.
    """
    mission = plan.mission
    periods_s = {zone.name: zone.period_s or math.inf for zone in mission.zones} | {AREA: mission.period_s or math.inf}
    line = LineString(route.loop_m) if len(route.loop_m) > 1 else Point(route.loop_m[0])
    inside_m = {zone.name: float(line.intersection(zone.shape).length) for zone in mission.zones}
    inside_m[AREA] = route.length_m - sum(inside_m.values())
    served = robot_rows(plan)[route.robots[0]].zones
    if len(route.robots) > 1:
        every_s, reach_m = route.duration_s / len(route.robots), mission.fleet.sensor.reach_m
        near = [zone.name for zone in mission.zones if line.distance(zone.shape) < reach_m]
        served = tuple(zone for zone in (*near, AREA) if every_s <= periods_s[zone])
    return min(served, key=lambda zone: (periods_s[zone], -inside_m[zone]), default=None)
