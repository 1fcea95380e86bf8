"""Round corners drawn finer where robots need it, and places a hair inside of narrow views."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box

from rota.geometry.free_space import border_segments, standing_space, standing_space_in
from rota.geometry.line_of_sight import visibility_polygon
from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.ground import problem as problem_module
from rota.planners.patrol.ground.finer_space import with_patches, with_room_to_see
from rota.planners.patrol.ground.nearest_places import nearest_places
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.repair.last_places import border_place

BODY_M = 0.6
BLOCKS = (box(2.9, 7.1, 3.8, 9.4), box(2.7, 3.2, 4.1, 5.1), box(7.1, 1.2, 9.7, 3.6))
# in the corner behind the last block; from the coarse arc round that block's corner it is 3.006 m away
CORNER_M = np.array([9.98590654, 0.5541374])


@pytest.fixture(scope="module")
def coarse() -> Problem:
    """A problem whose arcs have 16 corners a turn, as on ground with very many corners."""
    mission = Mission(
        name="blocks",
        area=MultiPolygon([box(0, 0, 10, 10)]),
        obstacles=tuple(Obstacle(shape=shape) for shape in BLOCKS),
        fleet=Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=3.0), body_radius_m=BODY_M),
        period_s=200.0,
    ).with_effort("quick")
    problem = set_up_problem(mission)
    space = standing_space(mission, BODY_M)
    paths = ShortestPaths(space)
    places_m = problem.viewpoints.xy_m[paths.part_of(problem.viewpoints.xy_m) >= 0]
    return replace(
        problem,
        space=space,
        paths=paths,
        viewpoints=problem.viewpoints._replace(xy_m=places_m, component=paths.part_of(places_m)),
    )


def test_space_in_a_box_is_that_part_of_the_whole(coarse: Problem) -> None:
    whole = standing_space(coarse.mission, BODY_M, arc_corners=64)
    for frame in ((2.0, 6.0, 5.0, 9.9), (0.0, 0.0, 10.0, 10.0), (7.5, 1.5, 9.0, 3.0)):
        here = standing_space_in(coarse.mission, BODY_M, frame, arc_corners=64)
        assert shapely.symmetric_difference(here, shapely.intersection(whole, box(*frame))).area < 1e-9


def test_a_robot_gets_the_room_from_which_a_place_is_seen(coarse: Problem) -> None:
    points_m = CORNER_M[None]
    assert nearest_places(points_m, coarse.space, coarse.walls, coarse.robot)[1][0] > 3.0
    wider = with_room_to_see(coarse, points_m)
    place_m, range_m = nearest_places(points_m, wider.space, wider.walls, wider.robot)
    assert range_m[0] <= 3.0
    exact = shapely.difference(box(0, 0, 10, 10).buffer(-BODY_M), shapely.union_all(BLOCKS).buffer(BODY_M - 1e-6, 256))
    assert shapely.covers(exact.buffer(2e-6), wider.space)
    assert 0 < wider.space.area - coarse.space.area < 0.05 * BODY_M**2
    assert wider.paths.part_of(place_m)[0] == 0
    assert np.array_equal(wider.viewpoints.component, wider.paths.part_of(wider.viewpoints.xy_m))


def test_corners_are_drawn_finer_yet_where_that_does_not_do(coarse: Problem) -> None:
    """The sensor reaches the corner from the finest arc round the block, but from no coarser one."""
    frame = (5.0, 0.0, 10.0, 6.0)
    fine, finest = (standing_space_in(coarse.mission, BODY_M, frame, arc_corners=k) for k in (128, 2048))
    far_m, near_m = (
        nearest_places(CORNER_M[None], space, coarse.walls, coarse.robot)[1][0] for space in (fine, finest)
    )
    assert near_m < far_m - 1e-5
    short = replace(coarse, robot=replace(coarse.robot, sensor=DiscSensor(radius_m=float(near_m + far_m) / 2)))
    wider = with_room_to_see(short, CORNER_M[None])
    assert nearest_places(CORNER_M[None], wider.space, wider.walls, wider.robot)[1][0] <= short.reach_m


def test_a_nearer_place_where_no_robot_of_the_problem_can_be_hides_no_other(coarse: Problem) -> None:
    beside = MultiPolygon([box(0, 0, 10, 10), box(10.1, 0, 12.1, 2)])  # 0.7 m from the corner there is room for a body
    fenced = replace(coarse, mission=replace(coarse.mission, area=beside))
    assert with_room_to_see(fenced, CORNER_M[None]).space.equals(with_room_to_see(coarse, CORNER_M[None]).space)


def test_points_that_lie_near_each_other_get_the_room_that_each_would_get_alone(coarse: Problem) -> None:
    points_m = CORNER_M + np.array([[0.0, 0.0], [-0.01, 0.0], [0.0, -0.012], [-3.0, 6.0]])
    together, alone = with_room_to_see(coarse, points_m), coarse
    for point_m in points_m:
        alone = with_room_to_see(alone, point_m[None])
    assert together.space.area > coarse.space.area
    assert shapely.symmetric_difference(together.space, alone.space).area < 1e-9


def test_who_is_seen_anyway_or_by_nobody_changes_nothing(coarse: Problem) -> None:
    assert with_room_to_see(coarse, np.array([[5.0, 6.0], [2.7, 9.9]])) is coarse
    cage = border_segments(MultiPolygon([box(9.95, 0.5, 10, 0.6).exterior.buffer(0.01)]))
    hidden = replace(coarse, walls=np.vstack([coarse.walls, cage]))
    assert with_room_to_see(hidden, CORNER_M[None]) is hidden


def test_on_ragged_ground_the_border_place_lies_inside_of_the_view(
    coarse: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Past a block's corner: from the edge of the view, whether the point is seen is up to rounding."""
    hidden_m = np.array([6.9, 0.2])
    far_m = np.array([4.55, 5.1])
    monkeypatch.setattr(problem_module, "MOST_DENSE", 0)
    assert coarse.is_ragged
    for point_m in (hidden_m, far_m, np.array([2.65, 4.0]), np.array([3.3, 9.9])):
        place_m = border_place(coarse, point_m)
        assert place_m is not None
        places = visibility_polygon(point_m, coarse.walls, 3.0).intersection(coarse.space)
        assert shapely.distance(places.boundary, shapely.Point(place_m)) == pytest.approx(1e-3, abs=1e-6)
        assert shapely.contains_xy(places, *place_m)
        nearest_m = shapely.distance(places, shapely.Point(point_m))
        assert nearest_m <= np.hypot(*(place_m - point_m)) < nearest_m + 0.01


def test_patches_join_no_parts_and_change_no_order() -> None:
    parts = [box(0, 0, 10, 10), box(12, 0, 14, 2), box(20, 0, 21, 1.9)]
    at_one, joining, too_large = box(10, 4, 11, 5), box(9, 0, 13, 1), box(21, 0, 24, 1.9)
    wider = with_patches(parts, [at_one, joining, too_large, box(50, 0, 51, 1)])
    assert wider[0].area == pytest.approx(103, abs=1e-4)  # of the patch between two parts all but a seam
    assert wider[0].distance(wider[1]) == pytest.approx(1e-6)
    assert wider[1:] == parts[1:]


def test_patches_give_back_no_ground_that_is_kept_clear() -> None:
    """Who stays there was given that room by cutting the part back."""
    (wider,) = with_patches([box(0, 0, 10, 10)], [box(9, 4, 11, 6)], [(0, box(10.5, 0, 12, 12)), (1, box(9, 4, 11, 5))])
    assert wider.area == pytest.approx(101)
