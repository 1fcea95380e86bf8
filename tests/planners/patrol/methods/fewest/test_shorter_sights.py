"""Sensors that see farther than rooms are wide never get more robots than those that do not."""

from __future__ import annotations

import pytest
from shapely import MultiPolygon, Polygon, box

from rota import DiscSensor, Fleet, Mission, Obstacle, PatrolSettings, make_plan
from rota.model.mission import SquareSensor
from rota.planners.patrol.methods.fewest.shorter_sights import mission_with_reach

# narrow rooms off a narrow corridor
COMB = Polygon([(0, 0), (9, 0), (9, 6), (8, 6), (8, 1), (5, 1), (5, 6), (4, 6), (4, 1), (1, 1), (1, 6), (0, 6)])


def comb(radius_m: float) -> Mission:
    """Walled rooms that one robot can go round in time."""
    walls = box(-1, -1, 10, 7) - COMB
    return Mission(
        name="comb", area=box(-1, -1, 10, 7), obstacles=(Obstacle(shape=MultiPolygon([walls])),), period_s=30,
        fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=radius_m)), planning=PatrolSettings(effort="quick"),
    )  # fmt: skip


@pytest.mark.parametrize("radius_m", [7, 40])
def test_a_longer_reach_takes_no_more_robots(radius_m: float) -> None:
    assert len(make_plan(comb(radius_m), seed=0)) == 1


def test_a_reach_is_shortened_whatever_the_shape() -> None:
    assert mission_with_reach(comb(8), 0.25).fleet.sensor == DiscSensor(radius_m=2)
    squares = Mission(
        name="squares", area=box(0, 0, 1, 1), period_s=9, fleet=Fleet(speed_m_s=1, sensor=SquareSensor(side_m=8))
    )
    assert mission_with_reach(squares, 0.5).fleet.sensor == SquareSensor(side_m=4)
