"""How far apart the views of witnesses are said to be, against shortest paths between all places that see them."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box

from rota.geometry.free_space import sight_walls, standing_space
from rota.geometry.line_of_sight import edge_grid, sees
from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota.planners.patrol.bounds import witness_points
from rota.planners.patrol.ground.problem import Problem, set_up_problem


def cluttered(seed: int) -> Mission:
    """A yard, some of it U-shaped, with boxes that block both, motion or sight, and small or wide bodies."""
    rng = np.random.default_rng(seed)
    obstacles = []
    for _ in range(int(rng.integers(2, 6))):
        x, y = rng.uniform(0, 24, 2)
        width, height = rng.uniform(0.5, 10, 2)
        shape = MultiPolygon([box(x, y, x + width, y + height)])
        obstacles.append(Obstacle(shape=shape, blocks=("both", "both", "motion", "sight")[rng.integers(4)]))
    area = box(0, 0, 30, 30).difference(box(8, 8, 22, 30)) if seed % 3 == 0 else box(0, 0, 30, 30)
    body_m = float(rng.choice([0, 0.3, 0.8]))
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=float(rng.uniform(2, 7))), body_radius_m=body_m)
    return Mission(name="yard", area=area, obstacles=tuple(obstacles), period_s=20, fleet=fleet)


def witnesses(mission: Mission, problem: Problem) -> witness_points.Witnesses:
    return witness_points.witnesses_of(problem, mission.fleet.sensor.reach_m)


@pytest.mark.parametrize("seed", [0, 7, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (2, 5, 8, 9))])
def test_no_two_places_are_nearer_than_is_said(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    mission = cluttered(seed)
    monkeypatch.setattr("rota.planners.patrol.ground.problem.refuse_unseeable", lambda *_: None)
    problem = set_up_problem(mission)
    seen_m: list[np.ndarray] = []
    found = witness_points._WiderSpace.where_seen

    def noted(ground: witness_points._WiderSpace, point_m: np.ndarray) -> witness_points._Place | None:
        place = found(ground, point_m)
        if place is not None:
            seen_m.append(point_m)
        return place

    monkeypatch.setattr(witness_points._WiderSpace, "where_seen", noted)
    apart = witnesses(mission, problem).apart_m
    assert len(apart) == len(seen_m) > 20

    space = standing_space(mission, mission.fleet.body_radius_m)
    paths, walls = ShortestPaths(space), edge_grid(sight_walls(mission))
    grid = np.stack(np.meshgrid(np.arange(0.2, 30, 0.9), np.arange(0.2, 30, 0.9)), axis=-1).reshape(-1, 2)
    border = shapely.get_coordinates(space.boundary.segmentize(0.8))
    places = np.vstack([border, grid[shapely.contains_xy(space, grid)]])
    places = places[paths.part_of(places) >= 0]
    ways = paths.all_pairs(places)
    viewers = []
    for point in seen_m:
        near = np.flatnonzero(np.hypot(*(places - point).T) <= mission.fleet.sensor.reach_m)
        viewers.append(near[sees(np.repeat(point[None], len(near), axis=0), places[near], walls)])
    shares = []
    for i in range(len(apart)):
        for j in range(i):
            if len(viewers[i]) and len(viewers[j]):
                least = ways[np.ix_(viewers[i], viewers[j])].min()
                assert apart[i, j] <= least
                if 5 < least < np.inf:
                    shares.append(apart[i, j] / least)
    if shares:  # and it says something
        assert np.median(shares) > 0.3


def test_zones_to_visit_are_as_far_apart_as_one_walks() -> None:
    zones = tuple(
        Zone(name=f"z{k}", shape=box(x, 0, x + 4, 4), period_s=9, demand="visit") for k, x in enumerate((0, 26))
    )
    wall = Obstacle(shape=MultiPolygon([box(14, 0, 16, 20)]))
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=2))
    mission = Mission(name="visits", area=box(0, 0, 30, 30), obstacles=(wall,), zones=zones, fleet=fleet)
    apart = witnesses(mission, set_up_problem(mission)).apart_m
    nearest = 2 * np.hypot(10, 16) + 2  # from the near upper corners round the top of the wall
    assert 0.6 * nearest < apart[0, 1] <= nearest


@pytest.mark.parametrize("seed", [0, 5])
def test_convex_views_are_as_wide_as_they_are_by_ways_inside(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    mission = cluttered(seed)
    monkeypatch.setattr("rota.planners.patrol.ground.problem.refuse_unseeable", lambda *_: None)
    problem = set_up_problem(mission)
    convex: list[bool] = []
    is_convex = witness_points._is_convex
    monkeypatch.setattr(witness_points, "_is_convex", lambda view: (convex.append(is_convex(view)), convex[-1])[1])
    shortly = witnesses(mission, problem).spread_m
    assert any(convex)
    assert not all(convex)
    monkeypatch.setattr(witness_points, "_is_convex", lambda view: False)
    assert shortly == pytest.approx(witnesses(mission, problem).spread_m, abs=1e-9)
