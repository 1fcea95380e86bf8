"""The published controller: cases worked by hand, and what must not change its decisions."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from tests.planners.swarm.conftest import PAPER, in_box, scattered

from rota.model.mission import MovingObstacle
from rota.planners.swarm.reciprocal_kernels import half_plane
from rota.planners.swarm.rollout import Swarm

HALF_DISC = 4 * 2 / (3 * math.pi)  # how far from the centre that of half a disc of radius 2 lies
CIRCLE = PAPER._replace(circle=True)


def first_velocities(swarm: Swarm) -> np.ndarray:
    swarm.step()
    return swarm.velocities_m_s


def test_two_robots_at_rest_part_by_the_centroid_of_half_the_speed_disc() -> None:
    velocities = first_velocities(in_box([[120, 100], [130, 100]]))
    assert velocities == pytest.approx(np.array([[-HALF_DISC, 0], [HALF_DISC, 0]]), abs=1e-12)


def test_each_of_two_moving_robots_takes_half_of_the_change() -> None:
    # approaching at 1 + 0.5 m/s along x: v . e <= (1 - 0.5) / 2 for the left one, the same towards -x for the right one
    swarm = in_box([[120, 100], [130, 100]], velocities_m_s=np.array([[1.0, 0.3], [-0.5, 0.0]]))
    left, right = first_velocities(swarm)
    disc = shapely.Point(0, 0).buffer(2, quad_segs=4096)
    expected = disc.intersection(shapely.box(-3, -3, 0.25, 3)).centroid
    assert left == pytest.approx([expected.x, 0], abs=1e-6)
    expected = disc.intersection(shapely.box(0.25, -3, 3, 3)).centroid
    assert right == pytest.approx([expected.x, 0], abs=1e-6)


def test_a_robot_between_two_stays_on_their_line_s_normal() -> None:
    # v . e <= 0 both ways leaves the segment across, whose middle is 0; the outer ones leave by half a disc
    velocities = first_velocities(in_box([[110, 100], [120, 100], [130, 100]], rule=PAPER._replace(neighbours=1)))
    assert velocities[[0, 2]] == pytest.approx(np.array([[-HALF_DISC, 0], [HALF_DISC, 0]]), abs=1e-12)
    assert velocities[1] == pytest.approx([HALF_DISC, 0], abs=1e-12)  # of two as near, the first in the fleet counts
    assert first_velocities(in_box([[110, 100], [120, 100], [130, 100]]))[1] == pytest.approx([0, 0], abs=1e-12)


def test_a_wall_in_sensor_range_takes_the_whole_change_and_one_farther_none() -> None:
    assert first_velocities(in_box([[24.9, 125]]))[0] == pytest.approx([HALF_DISC, 0], abs=1e-12)
    assert first_velocities(in_box([[25.1, 125]]))[0] == pytest.approx([0, 0], abs=1e-12)
    assert first_velocities(in_box([[24.9, 125]], wall_range_m=24))[0] == pytest.approx([0, 0], abs=1e-12)


def test_the_end_of_a_wall_counts_by_its_nearest_point() -> None:
    walls = np.array([[0, 0, 200, 0], [100, 100, 100, 150.0]])
    velocity = first_velocities(in_box([[94, 92]], walls=walls))[0]
    assert velocity == pytest.approx(np.array([-0.6, -0.8]) * HALF_DISC, abs=1e-12)


@pytest.mark.parametrize(("alpha", "bound"), [(1.0, -1.0), (1.5, -1.5)])
def test_what_moves_and_does_not_give_way_is_left_the_whole_change(alpha: float, bound: float) -> None:
    # it comes from the right at 1 m/s: the robot, at rest, must go left as fast, or alpha times as fast
    disc = MovingObstacle(radius_m=1, times_s=(0, 100), positions_m=((135, 100), (35, 100)))
    swarm = in_box([[120, 100]], rule=PAPER._replace(alpha=alpha), moving=(disc,))
    allowed = shapely.Point(0, 0).buffer(2, quad_segs=4096).intersection(shapely.box(-3, -3, bound, 3))
    assert first_velocities(swarm)[0] == pytest.approx([allowed.centroid.x, 0], abs=1e-6)


def test_an_empty_set_gives_velocity_0() -> None:
    # neighbours that all come nearer at full speed ask more than the speed disc allows on three sides
    ring = [[110, 100], [95, 108.66], [95, 91.34]]
    inwards = [[-2, 0], [1, -1.73], [1, 1.73]]
    swarm = in_box([[100, 100], *ring], velocities_m_s=np.array([[0, 0], *inwards], float))
    assert first_velocities(swarm)[0].tolist() == [0, 0]


def test_corollary_1_the_velocity_obstacle_lies_in_the_weak_coverage_set() -> None:
    """Eq. 13: what collides within the horizon weakens coverage, for tangent and for circle."""
    rng = np.random.default_rng(5)
    collided = 0
    for _ in range(3000):
        dx, dy = rng.uniform(-20, 20, 2)
        distance = math.hypot(dx, dy)
        bodies, horizon = rng.uniform(0, 1) * distance, 1.0
        v = rng.uniform(-60, 60, 2)
        t = np.clip((v @ [dx, dy]) / (v @ v), 0, horizon)
        if math.hypot(*(t * v - [dx, dy])) < bodies:
            collided += 1
            assert v @ [dx, dy] > 0  # the tangent line's side
            assert any(math.hypot(*(s * v - [dx, dy])) < distance for s in np.linspace(1e-6, 1, 100) * t)
            # and its own reading as a constraint forbids it to robots that move so
            ex, ey, bound = half_plane(dx, dy, distance, tuple(v), (0.0, 0.0), 1.0, PAPER)
            assert v @ [ex, ey] > bound
    assert collided > 100


def test_the_circle_asks_for_the_way_to_its_nearest_point() -> None:
    # relative velocity (3, 0), the circle of radius 10 round (10, 0): 3 m/s in, so u = (-3, 0) and half of it
    ex, ey, bound = half_plane(10.0, 0.0, 10.0, (2.0, 0.0), (-1.0, 0.0), 0.5, CIRCLE)
    assert (ex, ey, bound) == pytest.approx((1, 0, 2 - 1.5))
    # beside the circle: relative velocity (0, 5); the nearest point lies towards (0, 5) as seen from (10, 0)
    away = math.hypot(10, 5)
    ex, ey, bound = half_plane(10.0, 0.0, 10.0, (0.0, 5.0), (0.0, 0.0), 0.5, CIRCLE)
    normal, u = np.array([-10, 5]) / away, 10 - away
    assert (ex, ey) == pytest.approx(tuple(-normal))
    assert bound == pytest.approx(-(np.array([0, 5]) + 0.5 * u * normal) @ normal)


def test_samples_come_near_the_centroid_and_nearer_with_their_number() -> None:
    places = scattered(25, 100, 150, 1.1, 6)
    exact = first_velocities(in_box(places))
    errors = []
    for samples in (100, 10000):
        sampled = first_velocities(in_box(places, rule=PAPER._replace(samples=samples, seed=1)))
        free = (exact != 0).any(axis=1) & (sampled != 0).any(axis=1)
        assert free.sum() > 5
        errors.append(float(np.median(np.hypot(*(sampled - exact)[free].T))))
    assert errors[1] < 0.03
    assert errors[1] < 0.5 * errors[0]


@pytest.mark.parametrize("rule", [PAPER, CIRCLE])
def test_permuting_the_robots_permutes_the_result(rule) -> None:
    rng = np.random.default_rng(7)
    places, order = scattered(60, 60, 200, 1.1, 8), rng.permutation(60)
    bodies, sensors, speeds = rng.uniform(0.2, 0.5, 60), rng.uniform(15, 25, 60), rng.uniform(1, 2, 60)
    like = {"body_m": bodies, "sensor_m": sensors, "speed_m_s": speeds}
    one = in_box(places, rule=rule, **like)
    other = in_box(places[order], rule=rule, **{key: values[order] for key, values in like.items()})
    for _ in range(40):
        one.step()
        other.step()
    assert np.array_equal(one.places_m[order], other.places_m)
    assert not np.allclose(one.places_m, places)


@pytest.mark.parametrize("samples", [0, 50])
def test_threads_change_no_bit(samples: int) -> None:
    places = np.random.default_rng(9).uniform(1, 1999, (2000, 2))
    rule = PAPER._replace(samples=samples, seed=4)
    swarms = [in_box(places, (2000, 2000), rule=rule, threads=threads) for threads in (1, 2, 3)]
    for _ in range(5):
        moved = {swarm.step() for swarm in swarms}
    assert len(moved) == 1
    assert all(np.array_equal(swarms[0].places_m, swarm.places_m) for swarm in swarms[1:])


def test_another_seed_gives_other_samples_and_the_same_one_the_same() -> None:
    places = scattered(25, 100, 150, 1.1, 10)
    velocities = [first_velocities(in_box(places, rule=PAPER._replace(samples=200, seed=seed))) for seed in (1, 1, 2)]
    assert np.array_equal(velocities[0], velocities[1])
    assert not np.array_equal(velocities[0], velocities[2])
