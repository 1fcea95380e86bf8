"""Corners that robots on arcs do not come near: by hand in squares and triangles, and by what they drive."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from shapely import MultiPolygon, Polygon, box

from rota.errors import NoPlanFound
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota.planners.patrol.tight_corners import require_corners_in_reach

FLEET = Fleet(speed_m_s=18.0, sensor=DiscSensor(radius_m=25.0), turn_radius_m=75.0)
FIELD = Mission(name="field", area=MultiPolygon([box(0, 0, 800, 600)]), period_s=600.0, fleet=FLEET)
SQUARE = math.sqrt(2) - 1  # radii from a right angle to the arc that touches both its sides
SHARP = 1 / math.sin(math.pi / 6) - 1  # the same of an angle of 60 degrees


def of(mission: Mission = FIELD, area: Polygon | None = None, **fleet: object) -> Mission:
    other = mission if area is None else replace(mission, area=MultiPolygon([area]))
    return replace(other, fleet=replace(FLEET, **fleet))  # type: ignore[arg-type]


def test_a_corner_out_of_reach_is_told_with_what_helps() -> None:
    nearest = f"no nearer than {75 * SQUARE:.1f} m, and sensors reach 25 m; cut the corners off"
    with pytest.raises(NoPlanFound, match=nearest) as told:
        require_corners_in_reach(FIELD)
    # four corners of ground farther than 100 m from the arcs' middles: 75 m square each, less what a disc covers of it;
    # arcs may be 1 % wider than they must
    told_m2 = float(str(told.value).split()[1])
    assert told_m2 == pytest.approx(4 * (75**2 - area_within(100 + 0.01 * 75, 75)), rel=0.01)


def area_within(radius: float, side: float) -> float:
    """Area of a square from 0 to ``side`` within a circle round 0 of a greater radius, less than its diagonal."""
    meets = math.sqrt(radius**2 - side**2)
    angle = math.asin(side / radius) - math.asin(meets / radius)
    return side * meets + radius**2 * angle / 2


@pytest.mark.parametrize(
    ("mission", "in_reach"),
    [
        (of(turn_radius_m=0.99 * 25 / SQUARE), True),
        (of(turn_radius_m=1.07 * 25 / SQUARE), False),
        (of(turn_radius_m=0.0), True),
        (of(area=Polygon([(0, 0), (2000, 0), (1000, 1000 * math.sqrt(3))]), turn_radius_m=0.99 * 25 / SHARP), True),
        (of(area=Polygon([(0, 0), (2000, 0), (1000, 1000 * math.sqrt(3))]), turn_radius_m=1.07 * 25 / SHARP), False),
        (of(replace(FIELD, period_s=1.0)), True),  # robots stand
        (of(replace(FIELD, zones=(Zone(name="middle", shape=box(300, 200, 500, 400), period_s=600.0),), period_s=None)),
         True),
        (of(replace(FIELD, obstacles=tuple(Obstacle(shape=box(x, y, x + 80, y + 80))
                                           for x in (0, 720) for y in (0, 520)))), True),
        (of(body_radius_m=2.0, turn_radius_m=0.99 * 25 / SQUARE), False),  # the body keeps it farther off
    ],
)  # fmt: skip
def test_what_is_in_reach(mission: Mission, in_reach: bool) -> None:
    if in_reach:
        require_corners_in_reach(mission)
        return
    with pytest.raises(NoPlanFound, match="no loop comes near"):
        require_corners_in_reach(mission)


@pytest.mark.parametrize(("body_m", "needed"), [(0.0, "75 m, and 70.0 m"), (10.0, "85 m, and 70.0 m")])
def test_a_strip_in_which_nobody_can_come_back_is_refused_at_once(body_m: float, needed: str) -> None:
    strip = of(area=box(0, 0, 800, 140), body_radius_m=body_m)
    with pytest.raises(NoPlanFound, match=f"it takes a radius of {needed} is the most that fits"):
        require_corners_in_reach(strip)


@pytest.mark.parametrize("area", [box(0, 0, 800, 149.5), box(0, 0, 30, 30)])
def test_a_strip_as_wide_as_a_circle_but_for_rounding_and_what_one_who_stays_sees_are_not_refused(
    area: Polygon,
) -> None:
    require_corners_in_reach(of(area=area))
