"""Tours over pieces of built-up ground, and how they are joined."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations, pairwise

import numpy as np
import pytest
from shapely import MultiPolygon, box
from tests.planners.patrol.searching import search_on

import rota
from rota.errors import NoPlanFound
from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.planners.patrol.context import Context
from rota.planners.patrol.methods.large.pieces import (
    MOST_SHARING,
    best_runs,
    in_pieces,
    is_built_up,
    joined_tours,
    link_between,
    without_scraps,
)
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.tours.tour import Tour, tour_length_m

BLOCKS = Mission(
    name="blocks",
    area=MultiPolygon([box(0, 0, 60, 30)]),
    obstacles=tuple(Obstacle(shape=MultiPolygon([box(x, y, x + 9, y + 8)])) for x in (5, 20, 35, 48) for y in (4, 18)),
    period_s=30,
    fleet=Fleet(speed_m_s=3, sensor=DiscSensor(radius_m=4)),
    planning=PatrolSettings(effort="quick"),
)
ROBOT = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=1.0)).equal_robot("any")
PERIOD_S = 100.0
OPEN = ShortestPaths(MultiPolygon([box(-1, -1, 2000, 200)]))


def in_small_pieces(mission: Mission) -> Context:
    context = search_on(mission)
    districts = replace(context.settings.districts, piece_area=30.0)
    return replace(context, settings=replace(context.settings, districts=districts))


def ring(x0_m: float, long_m: float) -> Tour:
    """A loop one metre high of that length, from x0 on."""
    wide_m = long_m / 2 - 1
    corners_m = [[x0_m, 0.0], [x0_m + wide_m, 0.0], [x0_m + wide_m, 1.0], [x0_m, 1.0]]
    return Tour(vertices_m=np.array(corners_m), period_class=0, period_s=PERIOD_S, robots=1, robot=ROBOT)


def row_of_rings(robots: list[float]) -> list[Tour]:
    """Loops side by side, 2 m apart, which take so many robots each."""
    tours, x_m = [], 0.0
    for each in robots:
        tours.append(ring(x_m, each * PERIOD_S))
        x_m += each * PERIOD_S / 2 + 1
    return tours


def test_ground_is_built_up_where_each_corner_has_little_of_it() -> None:
    context = search_on(BLOCKS)  # 32 corners of buildings on 1,224 m2, 76.5 squares of the reach
    assert is_built_up(context)
    for most, built_up in ((2.3, False), (2.5, True)):
        districts = replace(context.settings.districts, built_up_corner=most)
        assert is_built_up(replace(context, settings=replace(context.settings, districts=districts))) is built_up
    assert not is_built_up(search_on(replace(BLOCKS, fleet=replace(BLOCKS.fleet, body_radius_m=0.2))))
    assert not is_built_up(search_on(replace(BLOCKS, obstacles=())))


def test_tours_over_pieces_pass_the_check_and_robots_share_them() -> None:
    context = in_small_pieces(BLOCKS)
    found = in_pieces(context)
    report = rota.check_plan(found.plan)
    assert report.verdict == "met"
    assert not report.violations
    assert any(tour.robots > 1 for tour in found.tours)
    assert [tour.robots for tour in found.tours] == [math.ceil(tour_length_m(tour) / 90) for tour in found.tours]


def test_no_piece_is_left_out_when_the_search_is_to_end() -> None:
    with pytest.raises(NoPlanFound, match="stopped before"):
        in_pieces(replace(in_small_pieces(BLOCKS), should_stop=lambda: True))


def test_neighbours_are_joined_where_that_spares_robots() -> None:
    tours = row_of_rings([1.4, 1.4])
    link = link_between(OPEN, *tours)
    assert link.length_m == pytest.approx(2)
    [joined] = joined_tours(OPEN, tours)
    assert joined.robots == 3  # 2 + 2 apart
    assert tour_length_m(joined) == pytest.approx(280 + 2 * 2)
    driven = {tuple(vertex) for vertex in joined.vertices_m}
    assert driven == {tuple(vertex) for tour in tours for vertex in tour.vertices_m}
    assert [tour.robots for tour in joined_tours(OPEN, row_of_rings([1.9, 1.9]))] == [2, 2]


def test_links_lead_round_walls() -> None:
    walled = MultiPolygon([box(-1, -1, 300, 200) - box(48.9, -2, 49.1, 150)])
    paths, tours = ShortestPaths(walled), row_of_rings([0.98, 1.3])
    # from (48, 1) past the end of the wall to (51, 1)
    assert link_between(paths, *tours).length_m == pytest.approx(2 * math.hypot(1.0, 149) + 0.2, abs=0.5)
    assert [tour.robots for tour in joined_tours(paths, tours)] == [1, 2]


def test_runs_take_the_fewest_robots_of_all_ways_to_cut_the_row() -> None:
    rng = np.random.default_rng(5)
    for _ in range(10):
        tours = row_of_rings(list(rng.uniform(0.2, 4.0, 7)))
        own_m = [tour_length_m(tour) for tour in tours]

        def robots(runs: list[tuple[int, int]], own_m: list[float] = own_m) -> int:
            lengths_m = [sum(own_m[a:b]) + 4 * (b - a - 1) for a, b in runs]
            each = [math.ceil(length_m / PERIOD_S) for length_m in lengths_m]
            return 10**6 if any(n > MOST_SHARING for n in each) else sum(each)

        ways = [list(pairwise([0, *cuts, 7])) for k in range(7) for cuts in combinations(range(1, 7), k)]
        assert robots(best_runs(OPEN, tours)) == min(map(robots, ways))


def test_scraps_go_to_the_tour_nearest_to_them() -> None:
    tours = row_of_rings([2.0, 0.1, 1.5])
    left = without_scraps(OPEN, tours)
    assert len(left) == 2
    assert sum(tour_length_m(tour) for tour in left) == pytest.approx(360 + 2 * 2)
