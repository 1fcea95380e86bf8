"""The last filter: bodies stay apart and inside whatever velocities are wished for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.spatial.distance import pdist, squareform
from shapely import Point, Polygon
from tests.planners.swarm.conftest import PAPER, in_box

from rota.planners.swarm.filter_kernels import HalfPlanes, nearest_allowed
from rota.planners.swarm.planner import DECIDE
from rota.planners.swarm.reciprocal_kernels import decide_reciprocal
from rota.planners.swarm.state import Hearing, Outline
from rota.planners.swarm.velocity_set_kernels import MOST_CORNERS, cut, square_round


def wishing(velocities_m_s: np.ndarray):
    """A controller that wishes for given velocities, by the number in the fleet."""

    def decide(begin, end, snapshot, decisions, room) -> None:
        decide_reciprocal(begin, end, snapshot, decisions, room)  # for nearest2
        decisions.vx[begin:end], decisions.vy[begin:end] = velocities_m_s[snapshot.robots.name[begin:end]].T

    return decide


def apart(places_m: np.ndarray, bodies_m: np.ndarray) -> float:
    gaps = squareform(pdist(places_m)) - (bodies_m[:, None] + bodies_m[None, :])
    return float(gaps[np.triu_indices(len(bodies_m), 1)].min())


def packed(rng: np.random.Generator, count: int, side_m: float, widest_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Bodies in a box, many of them touching or nearly so."""
    bodies = rng.uniform(0.2, 1.0, count) * widest_m
    places: list[np.ndarray] = []
    for k in range(count):
        for _ in range(4000):
            place = rng.uniform(bodies[k], side_m - bodies[k], 2)
            if k and rng.random() < 0.7:  # beside another one
                j, angle = int(rng.integers(k)), rng.uniform(0, 2 * np.pi)
                gap = rng.choice([0.0, 1e-9, 1e-3, 0.1])
                place = places[j] + (bodies[j] + bodies[k] + gap) * np.array([np.cos(angle), np.sin(angle)])
            inside = (place >= bodies[k]).all() and (place <= side_m - bodies[k]).all()
            gaps = [np.hypot(*(place - p)) - b - bodies[k] for p, b in zip(places, bodies, strict=False)]
            if inside and min(gaps, default=1) >= 0:
                places.append(place)
                break
        else:
            break
    return np.array(places), bodies[: len(places)]


@settings(max_examples=60, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 30), speed=st.floats(0.1, 30), inwards=st.booleans())
def test_bodies_never_touch_and_nobody_leaves(seed: int, count: int, speed: float, inwards: bool) -> None:
    rng = np.random.default_rng(seed)
    side = 14.0
    places, bodies = packed(rng, count, side, 1.0)
    wish = rng.normal(size=(len(places), 2))
    if inwards:
        wish = side / 2 - places + 0.1 * wish
    wish *= speed / np.maximum(np.hypot(*wish.T), 1e-9)[:, None]
    like = {"body_m": bodies, "speed_m_s": speed, "sensor_m": 5, "neighbour_range_m": 10, "wall_range_m": 5}
    swarm = in_box(places, (side, side), decide=wishing(wish), **like)
    for _ in range(20):
        before = swarm.places_m
        swarm.step()
        for part in np.linspace(0, 1, 5):  # bodies stay apart at every moment of the step
            between = before + part * (swarm.places_m - before)
            assert len(bodies) < 2 or apart(between, bodies) > -1e-12
            assert (between >= bodies[:, None] - 1e-12).all()
            assert (between <= side - bodies[:, None] + 1e-12).all()


@pytest.mark.parametrize("controller", DECIDE)
@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 25), neighbours=st.integers(0, 6))
def test_no_controller_with_the_filter_lets_bodies_touch(
    controller: str, seed: int, count: int, neighbours: int
) -> None:
    """Packed, with random velocities in the first snapshot: states that no controller would have come to."""
    rng = np.random.default_rng(seed)
    places, bodies = packed(rng, count, 20.0, 0.8)
    speeds = rng.uniform(-2, 2, (len(places), 2))
    like = {"body_m": bodies, "sensor_m": 5, "neighbour_range_m": 10, "wall_range_m": 5}
    rule = PAPER._replace(neighbours=neighbours)
    swarm = in_box(places, (20, 20), rule=rule, velocities_m_s=speeds, decide=DECIDE[controller], **like)
    for _ in range(30):
        swarm.step()
        assert len(bodies) < 2 or apart(swarm.places_m, bodies) > -1e-12
        assert (np.minimum(swarm.places_m, 20 - swarm.places_m) >= bodies[:, None] - 1e-12).all()


def test_without_the_filter_the_same_robots_do_touch() -> None:
    places = np.array([[5.0, 5.0], [8.0, 5.0]])
    wish = np.array([[2.0, 0.0], [-2.0, 0.0]])
    free = in_box(places, (14, 14), decide=wishing(wish), safe=False)
    kept = in_box(places, (14, 14), decide=wishing(wish))
    nearest = [np.inf, np.inf]
    for _ in range(10):
        for k, swarm in enumerate((free, kept)):
            swarm.step()
            nearest[k] = min(nearest[k], pdist(swarm.places_m)[0])
    assert nearest[0] < 1
    assert nearest[1] == pytest.approx(1, abs=1e-6)
    assert nearest[1] >= 1


def test_a_free_robot_keeps_its_velocity_and_one_at_a_wall_glides() -> None:
    wish = np.array([[1.0, 0.5], [-1.0, 0.5]])
    swarm = in_box([[100, 100], [0.6, 50]], decide=wishing(wish))
    swarm.step()
    assert swarm.velocities_m_s[0].tolist() == [1.0, 0.5]
    # 0.1 m are left to the wall, for one step of 0.25 s
    assert swarm.velocities_m_s[1] == pytest.approx([-0.4, 0.5], abs=1e-7)


def test_a_step_longer_than_the_area_jumps_through_no_wall() -> None:
    walls = np.array([[0, 0, 50, 0], [50, 0, 50, 50], [50, 50, 0, 50], [0, 50, 0, 0], [25, 0, 25, 50.0]])
    swarm = in_box([[10, 20]], decide=wishing(np.array([[900.0, 0.0]])), speed_m_s=900, walls=walls)
    for _ in range(5):
        swarm.step()
    assert swarm.places_m[0] == pytest.approx([24.5, 20], abs=1e-6)


# ---------------------------------------------------------------- the nearest velocity by itself


def allowed(wish: np.ndarray, normals: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    planes = HalfPlanes(*np.ascontiguousarray(normals.T), bounds)
    return np.array(nearest_allowed(*wish, float(np.hypot(*wish)), len(normals), planes))


def directions(angles: np.ndarray) -> np.ndarray:
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def test_the_nearest_velocity_is_shapely_s_nearest_point() -> None:
    rng = np.random.default_rng(2)
    outside = 0
    for _ in range(300):
        normals, bounds = directions(rng.uniform(0, 2 * np.pi, 6)), rng.uniform(0, 1, 6)
        outline, spare = (Outline(np.empty(MOST_CORNERS), np.empty(MOST_CORNERS)) for _ in range(2))
        corners = square_round(9.0, outline)
        for (ex, ey), bound in zip(normals, bounds, strict=True):
            corners = cut(outline, corners, ex, ey, bound, spare)
            outline, spare = spare, outline
        shape = Polygon(np.stack([outline.x, outline.y], axis=1)[:corners])
        wish = rng.uniform(-3, 3, 2)
        away = np.hypot(*(allowed(wish, normals, bounds) - wish))
        assert away == pytest.approx(shape.distance(Point(wish)), abs=1e-12)
        outside += away > 0
    assert outside > 150


@settings(max_examples=300, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    planes=st.lists(st.tuples(st.integers(0, 23), st.sampled_from([0.0, 1e-300, 1e-12, 0.3, 1.0])), max_size=20),
)
def test_the_nearest_velocity_is_never_longer_than_the_wish_nor_out_of_bounds(seed: int, planes: list) -> None:
    """Directions of a lattice at any angle, with errors of the last digit, many of them opposite or equal."""
    rng = np.random.default_rng(seed)
    angle = rng.choice([0.0, rng.uniform(0, 7)])
    normals = directions(np.array([np.pi / 12 * k for k, _ in planes]) + angle)
    normals += rng.choice([0.0, 1e-16, -1e-16], normals.shape)
    bounds = np.array([bound for _, bound in planes])
    wish = directions(rng.uniform(0, 7, 1))[0] * 2 if rng.random() < 0.5 else normals[:1].sum(axis=0) * 2
    if not wish.any():
        return
    found = allowed(wish, normals, bounds)
    assert np.hypot(*found) <= np.hypot(*wish) * (1 + 1e-15)
    assert (normals @ found <= bounds + 1e-14).all()


def test_robots_that_touch_on_both_sides_glide_between_them() -> None:
    # a column at any angle: only along the column's normals is there a way
    for angle in np.linspace(0, 2 * np.pi, 50):
        normals = directions(np.array([angle, angle + np.pi]))
        wish = directions(np.array([angle + 1.0]))[0]
        found = allowed(wish, normals, np.zeros(2))
        across = directions(np.array([angle + np.pi / 2]))[0]
        assert found == pytest.approx(np.sin(1.0) * across, abs=1e-12)


def test_more_half_planes_than_there_is_room_for_are_heeded_all_the_same() -> None:
    # a ring of 100 robots round one: all but one far enough for a step of any length, that one for none
    angle = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    ring = directions(angle) * np.where(np.arange(100) == 70, 1.0, 1.9)[:, None]
    places = np.vstack([[0.0, 0.0], ring]) + 50
    bodies = np.concatenate([[0.5], np.where(np.arange(100) == 70, 0.5, 0.001)])
    wish = np.vstack([ring[70] * 7.0, np.zeros((100, 2))])
    for hearing in (None, Hearing(delay_steps=1, lost=0.0)):
        swarm = in_box(places, (100, 100), body_m=bodies, speed_m_s=7, decide=wishing(wish), hearing=hearing)
        swarm.step()
        assert np.hypot(*(swarm.places_m[0] - 50)) < 1e-6
