"""Missions cut into missions for boxes: nothing that is asked gets lost, and nothing is asked twice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box

from rota.geometry.free_space import demanded_regions
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota.planners.patrol.methods.large.cells import ELSEWHERE, missions_of, weighed_boxes
from rota.planners.patrol.planner_settings import PatrolSettings

TOWN = Mission(
    name="town",
    area=MultiPolygon([box(0, 0, 120, 70).difference(box(100, 50, 120, 70))]),
    obstacles=(
        Obstacle(shape=MultiPolygon([box(20, 20, 41.3, 40)])),
        Obstacle(shape=MultiPolygon([box(70, 0, 74, 50)]), blocks="sight"),
        Obstacle(shape=MultiPolygon([box(80, 55, 90, 60)]), blocks="motion"),
    ),
    zones=(
        Zone(name="gate", shape=MultiPolygon([box(45, 20, 95, 45)]), period_s=20),
        Zone(name="yard", shape=MultiPolygon([box(60, 30, 119, 69)]), period_s=30),
        Zone(name="lake", shape=MultiPolygon([box(5, 50, 55, 65)]), period_s=None),
        Zone(name="desk", shape=MultiPolygon([box(10, 5, 66, 12)]), period_s=40, demand="visit"),
        Zone(name=ELSEWHERE, shape=MultiPolygon([box(0, 0, 5, 5)]), period_s=50),
    ),
    period_s=60,
    fleet=Fleet(speed_m_s=4, sensor=DiscSensor(radius_m=5)),
    planning=PatrolSettings(effort="quick"),
)


@pytest.mark.parametrize("weights", [[1], [1, 1], [3, 1, 2], [1, 1, 1, 5, 1, 1, 1], [2] * 16])
def test_boxes_hold_what_they_weigh_and_fill_the_bounds_once(weights: list[int]) -> None:
    shape = shapely.union_all([box(0, 0, 100, 20), box(0, 0, 15, 90), shapely.Point(80, 80).buffer(18)])
    boxes = weighed_boxes(shape, np.array(weights, dtype=np.float64))
    cells = shapely.box(*np.array(boxes).T)
    assert len(boxes) == len(weights)
    bounds = box(*shape.bounds)
    assert shapely.area(cells).sum() == pytest.approx(bounds.area, rel=1e-12)
    assert shapely.union_all(cells).area == pytest.approx(bounds.area, rel=1e-9)
    shares = shape.area * np.array(weights) / sum(weights)
    assert shapely.area(shapely.intersection(shape, cells)) == pytest.approx(shares, rel=1e-6)


@pytest.mark.parametrize("count", [2, 5])
@pytest.mark.parametrize("margin_m", [0.0, 20.0])
def test_districts_together_ask_for_what_the_whole_asks(count: int, margin_m: float) -> None:
    missions = missions_of(TOWN, count, margin_m)
    assert len(missions) == count
    asked = [{region.name: region for region in demanded_regions(mission)} for mission in missions]
    if margin_m > 0:
        assert any(ELSEWHERE + "'" in {zone.name for zone in mission.zones} for mission in missions)
    for whole in demanded_regions(TOWN):
        parts = [regions[whole.name] for regions in asked if whole.name in regions]
        assert {(part.period_s, part.demand) for part in parts} == {(whole.period_s, whole.demand)}
        if whole.demand == "visit":
            assert len(parts) == 1
        # the parts share no ground and leave none out
        assert sum(part.shape.area for part in parts) == pytest.approx(whole.shape.area, abs=1e-6)
        together = shapely.union_all([part.shape for part in parts])
        assert shapely.symmetric_difference(together, whole.shape).area == pytest.approx(0, abs=1e-6)


def test_districts_keep_all_that_blocks_sight_and_motion_near_them() -> None:
    for mission in missions_of(TOWN, 4, 10.0):
        near = shapely.box(*mission.area.bounds)
        kept = shapely.union_all([o.shape for o in mission.obstacles])
        there = shapely.intersection(shapely.union_all([o.shape for o in TOWN.obstacles]), near)
        assert shapely.difference(there, kept).area == pytest.approx(0, abs=1e-9)


def test_boxes_without_demand_are_absent() -> None:
    # two yards far apart, nothing asked between them: three boxes hold them, none is empty
    zones = (
        Zone(name="west", shape=MultiPolygon([box(0, 0, 10, 10)]), period_s=20),
        Zone(name="east", shape=MultiPolygon([box(110, 0, 120, 10)]), period_s=20),
    )
    missions = missions_of(replace(TOWN, zones=zones, obstacles=(), period_s=None), 2, 5.0)
    names = [{region.name for region in demanded_regions(mission)} for mission in missions]
    assert names == [{"west"}, {"east"}]
