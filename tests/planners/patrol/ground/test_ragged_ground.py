"""Rooms whose walls run as ragged as those of a scanned map: known as such, and planned at once."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box

from rota.check import check_plan
from rota.geometry.free_space import border_segments, sight_walls
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.ground.problem import count_nooks, set_up_problem
from rota.planners.patrol.planner_settings import Effort, PatrolSettings
from rota.planning.make_plan import search_plan

PIXEL_M, WIDE_M, HIGH_M = 0.05, 4.0, 3.0


def ragged_room(seed: int, body_radius_m: float = 0.2, effort: Effort = "quick") -> Mission:
    """A room with a wall into its middle, and up to three pixels more on its walls by chance."""
    rng, pixels = np.random.default_rng(seed), [box(WIDE_M / 2 - 0.1, 0, WIDE_M / 2 + 0.1, 0.6 * HIGH_M)]
    for low, high in (((0, 0), (WIDE_M, 0)), ((0, HIGH_M), (WIDE_M, HIGH_M)), ((0, 0), (0, HIGH_M))):
        along = np.array(high) - np.array(low)
        for share in np.arange(0, 1, PIXEL_M / float(along.max())):
            deep_m = PIXEL_M * int(rng.integers(0, 4))
            x, y = np.array(low) + share * along
            deep = shapely.box(x, y - deep_m, x + PIXEL_M, y + deep_m)
            pixels.append(deep if along[0] else shapely.box(x, y, x + deep_m, y + PIXEL_M))
    area = box(0, 0, WIDE_M, HIGH_M)
    solid = shapely.intersection(shapely.set_precision(shapely.union_all(pixels), 0.01), area)
    return Mission(
        name="ragged room", area=MultiPolygon([area]), period_s=600.0, planning=PatrolSettings(effort=effort),
        obstacles=tuple(Obstacle(shape=MultiPolygon([part])) for part in shapely.get_parts(solid) if part.area > 0),
        fleet=Fleet(speed_m_s=0.3, sensor=DiscSensor(radius_m=3.0), body_radius_m=body_radius_m),
    )  # fmt: skip


def test_nooks_are_sharp_corners_between_short_walls() -> None:
    steps = shapely.Polygon([(0, 0), (1, 0), (1, 1), (0.9, 1), (0.9, 0.9), (0.8, 0.9), (0.8, 1), (0, 1)])
    walls = border_segments(MultiPolygon([steps]))
    assert count_nooks(walls, 0.15) == 3  # between the four sides of 0.1
    assert count_nooks(walls, 0.05) == 0
    circle = border_segments(MultiPolygon([shapely.Point(0, 0).buffer(0.4)]))
    assert count_nooks(circle, 0.15) == 0  # short sides that hardly turn
    assert count_nooks(np.zeros((0, 4)), 1.0) == 0


@pytest.mark.parametrize("effort", ["quick", "normal"])
def test_a_room_is_ragged_whatever_the_effort(effort: Effort) -> None:
    room = set_up_problem(ragged_room(0, effort=effort))
    assert count_nooks(sight_walls(room.mission), 0.2) > 100
    assert room.is_ragged


def test_whose_nooks_a_robot_enters_is_not_ragged() -> None:
    assert not set_up_problem(ragged_room(0, body_radius_m=0.0)).is_ragged


def test_a_ragged_room_is_planned() -> None:
    plan = search_plan(ragged_room(1)).plan
    assert check_plan(plan).verdict == "met"
    assert len(plan) == 1
