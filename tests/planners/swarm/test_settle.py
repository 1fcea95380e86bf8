"""The controller that comes to rest: how much it covers, in how many steps, and without contact."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely
from benchmarks.missions import EXAMPLES
from benchmarks.swarm_jams import heap
from scipy.spatial.distance import pdist
from shapely import MultiPolygon, box
from tests.planners.swarm.conftest import PAPER, in_box, scattered

from rota.files.mission_file import read_mission
from rota.geometry.free_space import free_ground
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, StartBox
from rota.planners.swarm.deciding import deciding_room
from rota.planners.swarm.metrics import covered_share
from rota.planners.swarm.planner import ALL_NEIGHBOURS, beginning_of, make_swarm, run_mission
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.settle_kernels import OVERLAP_SHARE, decide_settle, pushes
from rota.planners.swarm.world import walls_of

ALL = PAPER._replace(neighbours=ALL_NEIGHBOURS)
SQUARE = MultiPolygon([box(0, 0, 250, 250)])


def test_two_discs_come_apart_until_they_touch_and_rest_there() -> None:
    swarm = in_box([[115, 100], [135, 100]], rule=ALL, decide=decide_settle, neighbour_range_m=50)
    moved = [swarm.step() for _ in range(400)]
    assert moved[-1] == 0
    # momentum may carry them on, and friction stops them a little before
    assert pdist(swarm.places_m)[0] >= 50 - 0.03
    assert swarm.places_m[:, 1] == pytest.approx([100, 100])
    assert swarm.places_m.mean(axis=0) == pytest.approx([125, 100], abs=0.5)


def push_of_walls(place: tuple[float, float], ground: MultiPolygon) -> tuple[float, float]:
    swarm = in_box([place], walls=walls_of(ground), rule=ALL, decide=decide_settle)
    room = deciding_room(ALL)
    return pushes(0, 0, False, swarm.robots, swarm.kinds, swarm.grid, room.near, room.outline)


@pytest.mark.parametrize("overlap_m", [0.5, 2.5])
def test_a_straight_wall_pushes_by_nearly_twice_its_overlap(overlap_m: float) -> None:
    px, py = push_of_walls((125, 25 - overlap_m), SQUARE)
    assert px == pytest.approx(0, abs=1e-9)
    assert py == pytest.approx(OVERLAP_SHARE * overlap_m * (2 - overlap_m / 25))


@pytest.mark.parametrize("sides", [64, 256])
def test_a_round_obstacle_pushes_the_same_of_however_many_walls_it_is(sides: int) -> None:
    """By the closed form for two circles, 45 m apart; never more than a straight wall."""
    ground = SQUARE.difference(shapely.Point(125, 125).buffer(22, quad_segs=sides // 4))
    px, py = push_of_walls((80, 125), MultiPolygon([ground]))
    cosine = (25**2 + 45**2 - 22**2) / (2 * 25 * 45)
    assert py == pytest.approx(0, abs=1e-9)
    assert px == pytest.approx(-OVERLAP_SHARE * 25 * (1 - cosine**2), rel=0.03)
    assert abs(px) < OVERLAP_SHARE * 2 * (25 + 22 - 45)


def rooms(robots: int, **settings: Any) -> Mission:
    """Four rooms of 25 m with doors of 1.5 m between them, and robots in a corner of one."""
    walls = [box(24.75, a, 25.25, b) for a, b in ((-1, 11.75), (13.25, 36.75), (38.25, 51))]
    walls += [box(a, 24.75, b, 25.25) for a, b in ((-1, 11.75), (13.25, 36.75), (38.25, 51))]
    blocks = shapely.get_parts(shapely.union_all(walls).intersection(box(0, 0, 50, 50)))
    like = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=5), body_radius_m=0.5)
    return Mission(
        name="rooms",
        area=MultiPolygon([box(0, 0, 50, 50)]),
        obstacles=tuple(Obstacle(shape=MultiPolygon([block])) for block in blocks),
        fleet=replace(
            like,
            robots=tuple(like.equal_robot(f"r{k}") for k in range(robots)),
            start=StartBox(low_m=(1, 1), high_m=(13, 13)),
        ),
        planning=SwarmSettings(**settings),
    )


@pytest.mark.parametrize("seed", [0, 1, 3, 10])
def test_robots_in_a_full_room_go_on_through_doors_and_rest(seed: int) -> None:
    asked = rooms(36, most_steps=3000)
    run = run_mission(asked, seed=seed)
    places = np.array([trajectory.positions_m[-1] for trajectory in run.plan])
    in_rooms = np.histogram2d(*places.T, bins=2, range=((0, 50), (0, 50)))[0]
    assert run.at_rest
    assert in_rooms.min() >= 6
    assert covered_share(places, np.full(36, 5.0), free_ground(asked)) > 0.93


@pytest.mark.parametrize("seed", [104, pytest.param(111, marks=pytest.mark.slow)])
def test_heaps_do_not_go_round_by_news_of_ground_that_is_taken(seed: int) -> None:
    """Four robots of each went to and fro at full speed for ever, by old news that each had from the others."""
    asked = heap(100, 50.0, 0)
    run = run_mission(asked, seed=seed)
    places = np.array([trajectory.positions_m[-1] for trajectory in run.plan])
    assert run.at_rest
    assert covered_share(places, np.full(100, 25.0), asked.area) > 0.78


@pytest.mark.parametrize("seed", [0, 14, 21])
def test_sixty_robots_spread_from_a_heap_and_rest_soon(seed: int) -> None:
    """They pushed each other less while most ground was free, and waited for old news of ground that was taken."""
    asked = read_mission(EXAMPLES / "swarm-port.yaml").mission
    run = run_mission(asked, seed=seed)
    places = np.array([trajectory.positions_m[-1] for trajectory in run.plan])
    assert run.at_rest
    assert run.steps < 1200
    assert covered_share(places, np.full(60, 25.0), free_ground(asked)) > 0.878


@pytest.mark.parametrize("late", [False, True])
def test_heaps_in_corners_open_and_rest_for_ever(late: bool) -> None:
    like = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=25), body_radius_m=0.5)
    robots = tuple(like.equal_robot(f"r{k}") for k in range(16))
    fleet = replace(like, robots=robots, start=StartBox(low_m=(1, 1), high_m=(16, 16)))
    planning = SwarmSettings(most_steps=6000, delay_steps=int(late), messages_lost=0.1 * late)
    asked = Mission(name="heap", area=MultiPolygon([box(0, 0, 200, 200)]), fleet=fleet, planning=planning)
    run = run_mission(asked, seed=1)
    places = np.array([trajectory.positions_m[-1] for trajectory in run.plan])
    assert run.at_rest
    assert covered_share(places, np.full(16, 25.0), asked.area) > 0.76
    if late:
        return
    state = run.state
    swarm = make_swarm(asked, asked.area, beginning_of(state), seed=1, reserve_m=state.thinned_m)
    assert max(swarm.step() for _ in range(1000)) == 0


@pytest.mark.parametrize("seed", [1, 2])
def test_49_robots_rest_whose_rows_buckle_slowly(seed: int) -> None:
    """Without friction such rows move on for thousands of steps, and cover 0.1 % of the area more at most."""
    fleet = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=25), body_radius_m=0.5)
    robots = tuple(fleet.equal_robot(f"robot-{k}") for k in range(49))
    start = StartBox(low_m=(70, 70), high_m=(140, 140))
    area = MultiPolygon([box(0, 0, 350, 350)])
    asked = Mission(name="49", area=area, fleet=replace(fleet, robots=robots, start=start), planning=SwarmSettings())
    run = run_mission(asked, seed=seed)
    places = np.array([trajectory.positions_m[-1] for trajectory in run.plan])
    assert run.at_rest
    assert run.steps < 2000
    assert covered_share(places, np.full(49, 25.0), area) > 0.783


@pytest.mark.parametrize("side_m", [10.0, 15.0])
def test_heaps_open_with_news_two_steps_late(side_m: float) -> None:
    """With nothing but top speeds known the last filter holds them for good: 8.9 % and 72.5 % are covered."""
    run = run_mission(heap(49, side_m, delay_steps=2), seed=100)
    places = np.array([trajectory.positions_m[-1] for trajectory in run.plan])
    assert run.at_rest
    assert covered_share(places, np.full(49, 25.0), MultiPolygon([box(0, 0, 350, 350)])) > 0.77


@pytest.mark.parametrize(("low", "most_steps"), [(100.0, 1000), (1.0, 1600)], ids=["centre", "corner"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_25_robots_cover_nearly_all_that_discs_can_and_rest(low: float, most_steps: int, seed: int) -> None:
    """At least 77 % each (78.54 % is the most), within 2,000 steps, bodies apart: what the area's gradient reaches."""
    swarm = in_box(scattered(25, low, low + 50, 1.02, seed), rule=ALL, decide=decide_settle, neighbour_range_m=50)
    nearest = np.inf
    while swarm.steps < most_steps:
        moved = swarm.step()
        nearest = min(nearest, pdist(swarm.places_m).min())
        if moved <= 1e-5:
            break
    assert moved <= 1e-5
    assert nearest >= 1
    assert 0.77 < covered_share(swarm.places_m, np.full(25, 25.0), SQUARE) < 0.7854
