"""Zones that ask for visits and leave robots little room, or none."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import MultiPolygon, Point, Polygon, box

import rota
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota.planners.patrol.planner_settings import PatrolSettings


def mission(zone: Polygon, built: Polygon, *, body_radius_m: float = 0.0, blocks: str = "both") -> Mission:
    return Mission(
        name="yard",
        area=MultiPolygon([box(0, 0, 10, 10)]),
        obstacles=(Obstacle(shape=MultiPolygon([built]), blocks=blocks),),  # type: ignore[arg-type]
        zones=(
            Zone(name="tank", shape=MultiPolygon([zone]), period_s=60, demand="visit"),
            Zone(name="gate", shape=MultiPolygon([box(0, 0, 1, 1)]), period_s=60, demand="visit"),
        ),
        fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=3), body_radius_m=body_radius_m),
        planning=PatrolSettings(effort="quick"),
    )


@pytest.mark.parametrize(
    ("zone", "built", "body_radius_m"),
    [
        (box(4, 4, 7, 7), box(4, 4, 6.7, 7), 0.0),  # built over but for 0.3 m
        (box(4, 4, 7, 7), box(4, 4, 6.7, 7), 0.29),  # of which the body leaves 0.01 m
        (box(4.5, 4.5, 7, 6.5), box(4, 4, 6.75, 7), 0.25),  # the centre comes to its very border
        (box(0, 8, 0.25, 10), box(4, 4, 6, 6), 0.25),  # in a corner of the yard
    ],
    ids=["strip", "sliver", "touched", "corner"],
)
def test_a_zone_mostly_out_of_reach_is_entered_where_it_can_be(
    zone: Polygon, built: Polygon, body_radius_m: float
) -> None:
    plan = rota.make_plan(mission(zone, built, body_radius_m=body_radius_m))
    report = rota.check_plan(plan)
    assert report.verdict == "met"
    assert len(plan.trajectories) == 1
    # independently of the check: some stretch of the route comes into the zone
    (route,) = plan
    steps = np.linspace(0, 1, 101)[:, None, None]
    places = (route.positions_m[:-1] + steps * np.diff(route.positions_m, axis=0)).reshape(-1, 2)
    assert min(zone.distance(Point(place)) for place in places) <= 1e-9


def test_a_zone_that_nobody_can_enter_is_named_with_the_reason() -> None:
    with pytest.raises(
        rota.NoPlanFound, match=r"zone tank, at \(5\.60, 5\.50\): it is no place for a body of .* 0\.31"
    ):
        rota.make_plan(mission(box(4.2, 4.2, 7, 6.8), box(4, 4, 6.7, 7), body_radius_m=0.31))
    with pytest.raises(rota.NoPlanFound, match=r"zone tank, .*: it is blocked to motion"):
        rota.make_plan(mission(box(4.5, 4.5, 6, 6), box(4, 4, 6.7, 7), blocks="motion"))
