"""Large swarms of the published controller, which decides for many robots at a time and sorts them seldom."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.planners.swarm.conftest import PAPER, box_walls, in_box

from rota.planners.swarm.deciding import FEWEST_IN_BLOCKS, Controller, deciding_room
from rota.planners.swarm.filter_kernels import filter_velocities
from rota.planners.swarm.reciprocal_block_kernels import (
    BLOCK,
    MOST_ROUND,
    ROWS,
    BlockRoom,
    argument,
    decide_in_blocks,
)
from rota.planners.swarm.reciprocal_kernels import decide_reciprocal
from rota.planners.swarm.rollout import Surroundings, Swarm
from rota.planners.swarm.sorted_robots import Beginning
from rota.planners.swarm.state import Decisions, FleetKinds, Snapshot
from rota.planners.swarm.world import kinds_of, moving_at, widest_m

LARGE, SIDE_M = FEWEST_IN_BLOCKS, 5000.0
EXACT = np.empty(0)


def dense(count: int, side_m: float, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.uniform(1, side_m - 1, (count, 2)), rng.uniform(-1.4, 1.4, (count, 2))


def fleet(count: int, speeds_m_s: np.ndarray | float = 2.0) -> FleetKinds:
    return kinds_of(count, body_m=0.5, sensor_m=25, speed_m_s=speeds_m_s, neighbour_range_m=51, wall_range_m=25)


def large_swarm(threads: int = 1, beginning: Beginning | None = None) -> Swarm:
    places, velocities = dense(LARGE, SIDE_M)
    begin = beginning or Beginning(places, velocities_m_s=velocities)
    walls = Surroundings(box_walls(SIDE_M, SIDE_M))
    return Swarm(begin, fleet(LARGE), walls, Controller(decide_reciprocal, PAPER), threads=threads)


def both_decisions(swarm: Swarm) -> tuple[np.ndarray, np.ndarray]:
    """(n, 2) velocities by blocks, and one by one."""
    n, time_step_s = len(swarm), swarm.rule.time_step_s
    snapshot = Snapshot(0, swarm.robots, swarm.kinds, swarm.grid, moving_at((), 0.0, time_step_s), swarm.rule)
    blocks, alone = (Decisions(*np.empty((3, n))) for _ in range(2))
    room = deciding_room(swarm.rule)
    reach_m = widest_m(swarm.kinds, time_step_s)
    found = np.empty(MOST_ROUND + 1, np.int64)
    decide_in_blocks(0, n, snapshot, reach_m, blocks, BlockRoom(found, np.ones(ROWS * BLOCK), room, EXACT))
    decide_reciprocal(0, n, snapshot, alone, room)
    filter_velocities(0, n, snapshot, reach_m, EXACT, alone, room)
    return np.stack(blocks[:2], axis=1), np.stack(alone[:2], axis=1)


def test_the_argument_of_a_complex_number_is_that_of_the_library() -> None:
    x, y = np.random.default_rng(0).normal(size=(2, 2000))
    for place in [*zip(x, y, strict=True), (1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1), (1, -1e-300)]:
        assert argument(*map(float, place)) == pytest.approx(math.atan2(place[1], place[0]) % (2 * math.pi), abs=2e-15)


@pytest.mark.parametrize("steps", [0, 5, 60])
def test_a_block_decides_as_each_robot_alone(steps: int) -> None:
    """Also where robots stand in heaps, in one place, by walls, are bodies only, or go at other speeds."""
    places, velocities = dense(900, 1400)
    places[:80] = 700 + places[:80] / 100  # more than there is room for in a block
    places[80] = places[81]
    speeds = np.where(np.arange(900) % 7 == 0, 0.7, 2.0)
    begin = Beginning(places, velocities_m_s=velocities * speeds[:, None] / 2)
    walls = Surroundings(box_walls(1400, 1400))
    swarm = Swarm(begin, fleet(900, speeds), walls, Controller(decide_reciprocal, PAPER))
    swarm.leave(np.arange(100, 160))
    swarm.leave(np.arange(160, 180), bodies_stay=False)
    for _ in range(steps):
        swarm.step()
    blocks, alone = both_decisions(swarm)
    assert np.abs(blocks - alone).max() < 1e-6  # decide_reciprocal takes corners' mean for sets below 1e-12 R^2
    assert np.median(np.abs(blocks - alone).max(axis=1)) < 1e-14
    assert (np.hypot(*alone.T) > 0).mean() > 0.3


def test_robots_that_leave_each_other_no_choice_stand() -> None:
    ring = np.array([[110, 100], [95, 108.66], [95, 91.34], [100, 112]])
    inwards = np.array([[-2, 0], [1, -1.73], [1, 1.73], [0, -1]])
    swarm = in_box([[100, 100], *ring], velocities_m_s=np.vstack([[[0, 0]], inwards]), wall_range_m=1, sensor_m=1)
    blocks, alone = both_decisions(swarm)
    middle = int(np.flatnonzero(swarm.robots.name == 0)[0])
    assert blocks[middle].tolist() == alone[middle].tolist() == [0, 0]


def test_neither_threads_nor_sorting_nor_a_stop_change_a_bit() -> None:
    swarms = [large_swarm(1), large_swarm(2), large_swarm(3), large_swarm(2)]

    def step_all() -> set[float]:
        swarms[3].join([])  # sorts
        return {swarm.step() for swarm in swarms}

    assert all(len(step_all()) == 1 for _ in range(7))
    names = swarms[0].robots.name.copy()
    assert (names != swarms[3].robots.name).any()
    places, velocities = swarms[0].places_m[names], swarms[0].velocities_m_s[names]
    swarms.append(large_swarm(2, Beginning(places, velocities_m_s=velocities, names=names, steps=7)))
    assert all(len(step_all()) == 1 for _ in range(6))
    first = swarms[0].places_m.tobytes()
    assert all(swarm.places_m.tobytes() == first for swarm in swarms)
