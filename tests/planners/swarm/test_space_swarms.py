"""The reciprocal controller in space: closed forms, the plane as a special case, and bodies that never touch."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.spatial.distance import pdist
from tests.planners.swarm.conftest import PAPER, box_walls, in_box, scattered, taken
from tests.seeds import seeds

from rota.planners.swarm.planner import ALL_NEIGHBOURS
from rota.planners.swarm.sorted_robots import Beginning
from rota.planners.swarm.space_kernels import Bands
from rota.planners.swarm.space_rollout import SpaceSwarm
from rota.planners.swarm.space_set_kernels import MOST_PLANES, centroid_in_ball
from rota.planners.swarm.state import Outline, Rule
from rota.planners.swarm.velocity_set_kernels import MOST_CORNERS
from rota.planners.swarm.world import kinds_of

HALF_BALL = 3 / 8 * 2  # how far from the centre that of half a ball of radius 2 lies


def in_space(
    places_m: Any, band: tuple[float, float] = (0, 200), rule: Rule = PAPER, full_m: float = -math.inf, **changed: Any
) -> SpaceSwarm:
    places = np.array(places_m, float).reshape(-1, 3)
    like = {"body_m": 0.5, "sensor_m": 25, "speed_m_s": 2, "neighbour_range_m": 51, "wall_range_m": 25}
    like |= {key: changed.pop(key) for key in tuple(changed) if key in like}
    beginning, walls = Beginning(places, **taken(changed, Beginning)), changed.pop("walls", box_walls(250, 250))
    bands = Bands(*(np.full(len(places), float(end)) for end in band))
    return SpaceSwarm(beginning, kinds_of(len(places), **like), walls, rule, bands=bands,
                      full_m=np.full(len(places), full_m), **changed)  # fmt: skip


def first_velocities(swarm: SpaceSwarm) -> np.ndarray:
    swarm.step()
    return swarm.velocities_m_s


def centroid(planes: Any, radius: float) -> np.ndarray | None:
    rows = np.zeros((MOST_PLANES, 4))
    given = np.array(planes, float).reshape(-1, 4)
    rows[: len(given)] = given
    outline, spare = (Outline(np.empty(MOST_CORNERS), np.empty(MOST_CORNERS)) for _ in range(2))
    ok, *middle = centroid_in_ball(rows, len(given), radius, outline, spare)
    return np.array(middle) if ok else None


def units(rng: np.random.Generator, count: int) -> np.ndarray:
    found = rng.normal(size=(count, 3))
    return np.asarray(found / np.linalg.norm(found, axis=1)[:, None])


# ---------------------------------------------------------------- the set's centroid


@pytest.mark.parametrize("distance", [-1.9, -0.7, 0.0, 0.3, 1.0, 1.99])
def test_the_centroid_of_a_ball_s_segment_is_the_closed_form(distance: float) -> None:
    # of the cap of height h: 3 (2 R - h)^2 / (4 (3 R - h)) from the centre
    height = 2 + distance
    found = centroid([[0, 0.6, 0.8, distance]], 2)
    assert found == pytest.approx(-np.array([0, 0.6, 0.8]) * 3 * (4 - height) ** 2 / (4 * (6 - height)), abs=1e-9)


def test_planes_through_the_centre_leave_the_closed_forms() -> None:
    assert centroid([], 2) == pytest.approx([0, 0, 0], abs=1e-15)
    assert centroid([[1, 0, 0, 0]], 2) == pytest.approx([-HALF_BALL, 0, 0], abs=1e-12)
    assert centroid([[1, 0, 0, 0], [0, 1, 0, 0]], 2) == pytest.approx([-HALF_BALL] * 2 + [0], abs=1e-12)
    assert centroid(np.hstack([np.eye(3), np.zeros((3, 1))]), 2) == pytest.approx([-HALF_BALL] * 3, abs=1e-12)


def test_sets_without_volume_have_the_centroid_of_what_is_left() -> None:
    flat = [[0, 0, 1, 0], [0, 0, -1, 0]]
    assert centroid([*flat, [1, 0, 0, 0]], 2) == pytest.approx([-4 * 2 / (3 * math.pi), 0, 0], abs=1e-12)
    assert centroid([*flat, [1, 0, 0, 0], [-1, 0, 0, 0], [0, 1, 0, 0]], 2) == pytest.approx([0, -1, 0], abs=1e-9)
    assert centroid([*flat, [0, 0, 1, -1e-3]], 2) is None
    assert centroid([[1, 0, 0, -2.1]], 2) is None


def test_a_polyhedron_within_the_ball_has_its_own_centroid() -> None:
    # the tetrahedron 0, (a, 0, 0), (0, a, 0), (0, 0, a), moved: its centroid is the mean of its corners
    shift, a = np.array([0.1, -0.2, 0.15]), 0.9
    normals = np.vstack([-np.eye(3), np.full(3, 1 / math.sqrt(3))])
    bounds = normals @ shift + np.array([0, 0, 0, a / math.sqrt(3)])
    assert centroid(np.column_stack([normals, bounds]), 2) == pytest.approx(shift + a / 4, abs=1e-12)


@pytest.mark.parametrize("seed", seeds(12, at_once=4))
def test_the_centroid_is_that_of_random_points_of_the_set(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = units(rng, 200_000) * rng.random((200_000, 1)) ** (1 / 3)
    normals = units(rng, 2 + seed % 6)
    # through the centre, as robots at rest have them, and at any distance
    bounds = np.zeros(len(normals)) if seed % 3 == 0 else rng.uniform(-0.2, 0.9, len(normals))
    inside = points[(points @ normals.T <= bounds).all(axis=1)]
    assert len(inside) > 50
    error = 5 * inside.std(axis=0) / math.sqrt(len(inside))
    found = centroid(np.column_stack([normals, bounds]), 1)
    assert found is not None
    assert (np.abs(found - inside.mean(axis=0)) < error).all()


# ---------------------------------------------------------------- cases by hand


def test_two_robots_at_rest_part_by_the_centroid_of_half_the_ball() -> None:
    velocities = first_velocities(in_space([[120, 100, 50], [126, 100, 58]]))
    apart = np.array([0.6, 0, 0.8]) * HALF_BALL
    assert velocities == pytest.approx(np.stack([-apart, apart]), abs=1e-12)


def test_each_of_two_moving_robots_takes_half_of_the_change() -> None:
    # one above the other, approaching at 1 + 0.5 m/s: v_z <= 0.25 for the lower, v_z >= 0.25 for the upper one
    moving = np.array([[0.3, 0, 1.0], [0, 0, -0.5]])
    lower, upper = first_velocities(in_space([[120, 100, 50], [120, 100, 60]], velocities_m_s=moving))
    for velocity, height, sign in ((lower, 2.25, -1), (upper, 1.75, 1)):
        assert velocity == pytest.approx([0, 0, sign * 3 * (4 - height) ** 2 / (4 * (6 - height))], abs=1e-12)


def test_a_robot_between_two_on_a_line_stays() -> None:
    velocities = first_velocities(in_space([[110, 100, 90], [120, 100, 100], [130, 100, 110]]))
    assert velocities[1] == pytest.approx([0, 0, 0], abs=1e-12)
    assert velocities[2] == pytest.approx(-velocities[0], abs=1e-12)


def test_a_wall_is_upright_and_the_band_ends_where_it_says() -> None:
    assert first_velocities(in_space([[24.9, 125, 50]]))[0] == pytest.approx([HALF_BALL, 0, 0], abs=1e-12)
    # 0.25 m below the ceiling it may climb at 1 m/s: the segment of the ball of height 3
    expected = -3 * (4 - 3) ** 2 / (4 * (6 - 3))
    assert first_velocities(in_space([[125, 125, 199.75]]))[0] == pytest.approx([0, 0, expected], abs=1e-12)


def test_a_robot_climbs_as_long_as_its_footprint_grows() -> None:
    assert first_velocities(in_space([[125, 125, 50]], full_m=60))[0] == pytest.approx([0, 0, HALF_BALL], abs=1e-12)
    assert first_velocities(in_space([[125, 125, 61]], full_m=60))[0] == pytest.approx([0, 0, 0], abs=1e-12)
    swarm = in_space([[125, 125, 50]], band=(40, 55), full_m=60)
    for _ in range(100):
        swarm.step()
    assert swarm.places_m[0] == pytest.approx([125, 125, 55], abs=1e-9)


# ---------------------------------------------------------------- nobody stays low


RING = [[120, 100, 45], [100, 120, 45], [80, 100, 45], [100, 80, 45]]


def test_a_robot_among_higher_ones_climbs() -> None:
    # the half-spaces towards the four leave velocity 0 alone; by their directions in the plane they leave the climb
    velocity = first_velocities(in_space([[100, 100, 30], *RING], band=(20, 45), full_m=45))[0]
    assert velocity == pytest.approx([0, 0, 1], abs=1e-9)  # the middle of a segment, 0 to 2 m/s upwards
    level = first_velocities(in_space([[100, 100, 45], *RING], band=(20, 45), full_m=45))[0]
    assert level == pytest.approx([0, 0, 0], abs=1e-9)


@pytest.mark.parametrize("settles", [False, True])
def test_robots_above_each_other_part_and_all_climb(settles: bool) -> None:
    stack = [[100, 100, 20 + 2 * k] for k in range(5)]
    rule = PAPER if not settles else PAPER._replace(neighbours=ALL_NEIGHBOURS)
    swarm = in_space(stack, band=(20, 45), rule=rule, full_m=45, settles=settles)
    for _ in range(300):
        swarm.step()
        assert pdist(swarm.places_m).min() >= 1.0 - 1e-9
    assert swarm.places_m[:, 2] == pytest.approx(np.full(5, 45.0), abs=1e-9)
    assert pdist(swarm.places_m).min() > 45


def test_robots_that_settle_climb_no_faster_than_they_can() -> None:
    places = np.column_stack([scattered(30, 100, 140, 1.2, 5), np.random.default_rng(5).uniform(20, 40, 30)])
    rule = PAPER._replace(neighbours=ALL_NEIGHBOURS)
    swarm = in_space(places, band=(20, 45), rule=rule, full_m=44, settles=True)
    for _ in range(200):
        swarm.step()
        assert np.linalg.norm(swarm.velocities_m_s, axis=1).max() <= 2 + 1e-9
    assert swarm.places_m[:, 2].min() == pytest.approx(44.0, abs=1e-9)
    still = in_space(places, band=(20, 45), rule=rule, settles=True)  # a footprint that never grows
    for _ in range(5):
        still.step()
    assert (still.places_m[:, 2] == places[:, 2]).all()


# ---------------------------------------------------------------- the plane, and what must not matter


@pytest.mark.parametrize("settles", [False, True])
def test_threads_change_no_bit(settles: bool) -> None:
    places = np.column_stack([scattered(200, 20, 230, 1.2, 5), np.random.default_rng(5).uniform(20, 40, 200)])
    rule = PAPER if not settles else PAPER._replace(neighbours=ALL_NEIGHBOURS)
    swarms = [in_space(places, band=(20, 45), rule=rule, full_m=45, settles=settles, threads=k) for k in (1, 2, 3)]
    for _ in range(10):
        assert len({swarm.step() for swarm in swarms}) == 1
    assert len({swarm.places_m.tobytes() for swarm in swarms}) == 1


@pytest.mark.parametrize("seed", range(3))
def test_in_a_band_without_height_robots_do_what_they_do_in_the_plane(seed: int) -> None:
    places = scattered(40, 60, 190, 1.5, seed)
    speeds = np.random.default_rng(seed).uniform(-1, 1, (40, 2))
    plane = in_box(places, velocities_m_s=speeds, safe=False)
    lifted = (np.column_stack([values, np.full(40, height)]) for values, height in ((places, 30.0), (speeds, 0.0)))
    place, speed = lifted
    space = in_space(place, band=(30, 30), velocities_m_s=speed, safe=False)
    for _ in range(5):
        plane.step()
        space.step()
        assert space.velocities_m_s[:, :2] == pytest.approx(plane.velocities_m_s, abs=1e-9)
        assert (space.places_m[:, 2] == 30).all()
        assert space.velocities_m_s[:, 2] == pytest.approx(np.zeros(40), abs=1e-9)


def test_permuting_robots_permutes_the_result() -> None:
    rng = np.random.default_rng(5)
    places = np.column_stack([scattered(30, 100, 150, 1.2, 5), rng.uniform(40, 60, 30)])
    order = rng.permutation(30)
    one, two = in_space(places, band=(40, 60)), in_space(places[order], band=(40, 60))
    for _ in range(20):
        one.step()
        two.step()
    assert two.places_m == pytest.approx(one.places_m[order], abs=1e-9)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 30), neighbours=st.integers(0, 4), settles=st.booleans())
def test_bodies_never_touch_and_nobody_leaves(seed: int, count: int, neighbours: int, settles: bool) -> None:
    rng = np.random.default_rng(seed)
    places = np.column_stack([scattered(count, 0.5, 9.5, 1.0, seed), rng.uniform(3, 5, count)])
    speeds = units(rng, count) * 2
    swarm = in_space(places, band=(3, 5), rule=PAPER._replace(neighbours=neighbours), walls=box_walls(10, 10),
                     velocities_m_s=speeds, full_m=5, settles=settles)  # fmt: skip
    for _ in range(12):
        before = swarm.places_m
        swarm.step()
        # at every moment of the step, by its closest approach
        for part in np.linspace(0, 1, 9):
            between = before + part * (swarm.places_m - before)
            assert pdist(between).min() >= 1.0 - 1e-9
        assert between[:, :2].min() >= 0.5 - 1e-9
        assert between[:, :2].max() <= 9.5 + 1e-9
        assert ((between[:, 2] >= 3) & (between[:, 2] <= 5)).all()
        assert np.linalg.norm(swarm.velocities_m_s, axis=1).max() <= 2 + 1e-9
