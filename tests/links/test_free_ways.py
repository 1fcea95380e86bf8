"""Ways in layers: round obstacles, apart where they come close, and refused where there is none."""

from __future__ import annotations

from dataclasses import replace

import pytest
from shapely import LineString, MultiPolygon, box
from tests.links.fleets import ALTITUDE_M, loop_of, plan_of

from rota.errors import PlanError
from rota.links.free_ways import APART_M, LAYER_M, LayeredWay, layered_ways
from rota.model.mission import Mission, Obstacle

SHED = box(40, -50, 60, 50)


def mission_with(*robots: str, area: MultiPolygon | None = None) -> Mission:
    mission = plan_of(*(loop_of(name, 0.0) for name in robots)).mission
    area = area or MultiPolygon([box(-300, -300, 900, 300)])
    return replace(mission, area=area, zones=(), period_s=60.0, obstacles=(Obstacle(shape=SHED, blocks="motion"),))


def apart_or_layered(ways: tuple[LayeredWay, ...]) -> None:
    for k, one in enumerate(ways):
        for other in ways[:k]:
            near = LineString(one.places_m).distance(LineString(other.places_m)) < APART_M
            assert not near or abs(one.height_m - other.height_m) >= LAYER_M


def test_ways_lead_round_what_blocks_and_cross_in_layers() -> None:
    ends = {"a": ((0.0, 0.0), (100.0, 0.0)), "b": ((30.0, -80.0), (30.0, 80.0)), "c": ((200.0, 0.0), (300.0, 0.0))}
    ways = layered_ways(mission_with("a", "b", "c"), ends)
    assert [(way.places_m[0], way.places_m[-1]) for way in ways] == list(ends.values())
    assert LineString(ways[0].places_m).distance(SHED) >= 2.99
    assert ways[0].length_m > 150  # 100 m straight, past a shed of 100 m
    assert ways[1].length_m == pytest.approx(160.0)
    assert [way.height_m for way in ways] == [ALTITUDE_M, ALTITUDE_M + LAYER_M, ALTITUDE_M]
    apart_or_layered(ways)


def test_many_that_stand_on_one_pad_have_a_layer_each() -> None:
    names = [f"r{k}" for k in range(6)]
    ends = {name: ((float(k), 0.0), (100.0 + 40 * k, 100.0)) for k, name in enumerate(names)}
    ways = layered_ways(mission_with(*names), ends)
    assert len({way.height_m for way in ways}) == 6
    apart_or_layered(ways)


def test_who_is_there_stays_and_who_stands_outside_goes_straight_in() -> None:
    ends = {"a": ((0.0, 0.0), (0.0, 0.0)), "b": ((0.0, 310.0), (0.0, 200.0))}
    ways = layered_ways(mission_with("a", "b"), ends)
    assert ways[0].stops_m == ()
    assert ways[0].length_m == 0.0
    assert ways[1].places_m == ((0.0, 310.0), (0.0, 297.0), (0.0, 200.0))


def test_grounds_between_which_no_way_leads_are_told() -> None:
    parts = MultiPolygon([box(-300, -300, 0, 300), box(400, -300, 900, 300)])
    with pytest.raises(PlanError, match=r"robot a: no way leads from \(-10\.0, 0\.0\) to \(500\.0, 0\.0\) round"):
        layered_ways(mission_with("a", area=parts), {"a": ((-10.0, 0.0), (500.0, 0.0))})
