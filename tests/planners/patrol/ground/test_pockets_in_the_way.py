"""Pockets that are needed and in the way: told before any tour is looked for, and only where brute force agrees."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon, box

from rota import NoPlanFound, make_plan
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.ground.pockets_in_the_way import refuse_pockets_in_the_way
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.planner_settings import PatrolSettings

BODY_M, REACH_M = 0.4, 3.0
STEP_M = 0.01


def hall_with_closet(*, deep_m: float = 0.84, rib: bool = True) -> Mission:
    """A hall, and a closet whose door is narrower than a body; beside the door a rib 0.3 m off the wall.

    A robot in the hall looks behind the rib from half in the doorway alone, where it touches one in a closet of 0.84 m.
    """
    wall = box(-deep_m - 0.02, 0, 0, 6).difference(
        shapely.union_all([box(-deep_m - 0.02, 2.58, -0.02, 3.42), box(-0.02, 2.65, 0, 3.35)])
    )
    blocks = [*shapely.get_parts(wall), *([box(0.3, 3.6, 0.32, 5.02), box(0, 5, 0.32, 5.02)] if rib else [])]
    return Mission(
        name="closet", area=MultiPolygon([box(-deep_m - 0.02, 0, 6, 6)]), period_s=600.0,
        planning=PatrolSettings(effort="quick"),
        obstacles=tuple(Obstacle(shape=MultiPolygon([each])) for each in blocks if isinstance(each, Polygon)),
        fleet=Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=REACH_M), body_radius_m=BODY_M),
    )  # fmt: skip


def is_refused(mission: Mission) -> str:
    """What is told of the pockets in the way; empty where none is."""
    try:
        refuse_pockets_in_the_way(set_up_problem(mission))
    except NoPlanFound as refusal:
        return str(refusal)
    return ""


def places_that_fit(mission: Mission) -> NDArray[np.float64]:
    """Places (n, 2) every centimetre, in the closet and a metre into the hall, where a body fits."""
    x0, y0, _, y1 = mission.area.bounds
    xs, ys = np.meshgrid(np.arange(x0 + STEP_M / 2, 1.0, STEP_M), np.arange(y0 + STEP_M / 2, y1, STEP_M))
    places_m = np.column_stack([xs.ravel(), ys.ravel()])
    spots, solid = shapely.points(places_m), solid_of(mission)
    fits = ~shapely.dwithin(shapely.union_all([solid, mission.area.boundary]), spots, BODY_M)
    return places_m[fits]


def those_that_see(
    mission: Mission, places_m: NDArray[np.float64], point_m: tuple[float, float]
) -> NDArray[np.float64]:
    """Of the places (n, 2) those in reach of the point from which a straight line reaches it."""
    near_m = places_m[np.hypot(*(places_m - point_m).T) <= REACH_M]
    lines = shapely.linestrings(np.stack([near_m, np.broadcast_to(point_m, near_m.shape)], axis=1))
    return near_m[~shapely.intersects(solid_of(mission), lines)]


def solid_of(mission: Mission) -> shapely.Geometry:
    """All that blocks, made ready for many questions."""
    solid = shapely.union_all([obstacle.shape for obstacle in mission.obstacles])
    shapely.prepare(solid)
    return solid


def test_what_is_told_is_so_by_brute_force() -> None:
    mission = hall_with_closet()
    told = is_refused(mission)
    x0, y0, _, _, x1, y1 = map(float, re.findall(r"-?\d+\.\d+", told))
    places_m = places_that_fit(mission)
    closet_m = places_m[places_m[:, 0] < 0]
    from_closet, from_door = (those_that_see(mission, places_m, point_m) for point_m in ((x0, y0), (x1, y1)))
    assert len(from_closet)
    assert (from_closet[:, 0] < 0).all()  # no robot in the hall sees the first place
    assert len(from_door)
    assert (from_door[:, 0] > 0).all()  # and none in the closet the second
    apart_m = np.hypot(*np.moveaxis(from_door[:, None] - closet_m[None], -1, 0))
    assert apart_m.max() < 2 * BODY_M  # wherever the two are, they touch


def test_nothing_is_searched_for_then() -> None:
    with pytest.raises(
        NoPlanFound, match=r"is seen only from the pocket round \(-0\.\d+, 3\.\d+\), which no robot leaves"
    ):
        make_plan(hall_with_closet())


@pytest.mark.parametrize("mission", [hall_with_closet(rib=False), hall_with_closet(deep_m=1.6)], ids=["no rib", "deep"])
def test_a_pocket_that_nobody_minds_is_not_refused(mission: Mission) -> None:
    assert not is_refused(mission)


def test_fleets_that_come_to_no_pockets_or_differ_are_not_refused() -> None:
    mission = hall_with_closet()
    fleet = mission.fleet
    assert not is_refused(replace(mission, fleet=replace(fleet, entrances=((3.0, 3.0),))))
    small = replace(fleet.equal_robot("small"), body_radius_m=0.1)
    assert not is_refused(replace(mission, fleet=replace(fleet, robots=(fleet.equal_robot("large"), small))))
