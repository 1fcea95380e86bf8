"""Programmed corners of trajectories with cut corners, beside the polylines that these were made of."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from tests.driven_with_mass import begun_at, rounded
from tests.seeds import seeds

from rota.model.plan import Trajectory
from rota.routes.driven_route import trajectory_of
from rota.routes.passed_stops import passed_stops, without_slight
from rota.routes.route import Route, route_of

A, TOP = 2.5, 8.0
NEAR_M = 1e-6


def polyline(rng: np.random.Generator, count: int, dimensions: int = 2) -> np.ndarray:
    """A closed way of legs between 40 and 90 m, which turn by any angle up to 170 degrees."""
    while True:
        angles = np.cumsum(rng.uniform(-170, 170, count)) * np.pi / 180
        steps = rng.uniform(40, 90, count)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        points = np.cumsum(steps, axis=0) - steps[0]
        last, first = points[0] - points[-1], points[1] - points[0]
        lengths = np.linalg.norm(last)
        turns = [cosine(points[-1] - points[-2], last), cosine(last, first)]
        if lengths > 40 and min(turns) > -0.98 and max(turns) < 0.999:
            return np.column_stack([points, rng.uniform(10, 20, count)]) if dimensions == 3 else points


def cosine(a: np.ndarray, b: np.ndarray) -> float:
    return float(a @ b / np.linalg.norm(a) / np.linalg.norm(b))


def drawn(seed: int, dimensions: int = 2) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Corners, the speeds past them, and waits at those where the robot stops."""
    rng = np.random.default_rng(seed)
    corners = polyline(rng, int(rng.integers(3, 9)), dimensions)
    speeds = np.where(rng.random(len(corners)) < 0.7, rng.uniform(0.3, 6, len(corners)), 0.0)
    speeds[0] = 0
    holds_s = np.where((speeds == 0) & (rng.random(len(corners)) < 0.5), rng.uniform(1, 9, len(corners)), 0.0)
    return corners, speeds, holds_s


def places(route: Route, width: int) -> np.ndarray:
    return np.array([stop.place_m[:width] for stop in route.every_round])


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("seed", seeds(60, at_once=20))
def test_corners_come_back(seed: int, dimensions: int) -> None:
    corners, speeds, holds_s = drawn(seed, dimensions)
    trajectory = rounded(corners, speeds, holds_s, top=TOP, a=A)
    route = route_of(trajectory, 30)
    np.testing.assert_allclose(places(route, dimensions), np.roll(corners, -1, axis=0), atol=NEAR_M)
    np.testing.assert_allclose([stop.hold_s for stop in route.every_round], np.roll(holds_s, -1), atol=1e-9)
    again = trajectory_of(route, flat=dimensions == 2)
    assert again.loop_duration_s == pytest.approx(trajectory.loop_duration_s, rel=1e-9)
    lengths = np.linalg.norm(np.diff(np.vstack([corners, corners[:1]]), axis=0), axis=1)
    for stop, length in zip(route.every_round, lengths, strict=True):
        assert stop.speed_m_s is not None
        assert stop.planned_s is not None
        assert length / stop.planned_s - 1e-9 <= stop.speed_m_s <= TOP + 1e-9
        assert stop.speed_m_s <= np.sqrt(A * length) + 6 + 1e-9


@pytest.mark.parametrize("seed", seeds(60, at_once=10))
def test_wherever_the_loop_begins_the_same_corners_come_back(seed: int) -> None:
    corners, speeds, holds_s = drawn(seed)
    whole = rounded(corners, speeds, holds_s, top=TOP, a=A)
    shares = np.random.default_rng(seed).random(6).tolist()
    # at vertices, too, of which most are amidst curves
    shares += (whole.times_s[1:-1:3] / whole.loop_duration_s).tolist()
    for share in shares:
        begun = begun_at(whole, share)
        route = route_of(begun, 30)
        found = places(route, 2)
        off = np.linalg.norm(found[:, None] - corners[None], axis=2)
        first = int(off[-1].argmin())
        order = (first + 1 + np.arange(len(corners))) % len(corners)
        assert len(found) == len(corners), share
        np.testing.assert_allclose(found, corners[order], atol=NEAR_M)
        driven = trajectory_of(route, flat=True)
        assert driven.loop_duration_s == pytest.approx(begun.loop_duration_s, rel=1e-9)
        assert sum(stop.hold_s for stop in route.every_round) == pytest.approx(holds_s.sum())
        # each corner is passed when it was to be passed, to the moment of the nearest place
        late_s = np.interp(driven.loop_start_s, begun.times_s, begun.times_s) - driven.loop_start_s
        assert abs(late_s) < 1e-9
        at_stops = [k for k in range(len(corners)) if speeds[k] == 0]
        for k in at_stops:
            passed = [t for t in driven.times_s if np.allclose(place_at(driven, t), corners[k], atol=NEAR_M)]
            assert min(np.linalg.norm(begun.at(t) - corners[k]) for t in passed) < 1e-5


def place_at(trajectory: Trajectory, time_s: float) -> np.ndarray:
    return trajectory.at(time_s)


@pytest.mark.parametrize("seed", range(40))
def test_the_way_to_the_loop_has_its_corners_too(seed: int) -> None:
    corners, speeds, holds_s = drawn(seed)
    heading = corners[0] - corners[1]
    across = np.array([-heading[1], heading[0]])
    once = np.array([corners[0] + 2 * heading + across, corners[0] + 2 * heading, corners[0] + heading + across])
    once = np.vstack([once, corners[:1]])
    trajectory = rounded(corners, np.minimum(speeds, 3), holds_s, top=TOP, a=A, once=once)
    route = route_of(trajectory, 30)
    first = np.array([stop.place_m[:2] for stop in route.once])
    expected = once[1:]
    np.testing.assert_allclose(first, expected, atol=NEAR_M)
    assert route.start_m[:2] == tuple(once[0])
    driven = trajectory_of(route, flat=True)
    # what it waits in every round where the loop begins it waits in the first one as well
    assert driven.loop_start_s == pytest.approx(trajectory.loop_start_s + holds_s[0], rel=1e-9)
    assert driven.loop_duration_s == pytest.approx(trajectory.loop_duration_s, rel=1e-9)


def test_a_robot_that_stays_and_one_that_only_waits() -> None:
    stays = Trajectory(
        robot="a", times_s=[0, 2, 4], positions_m=[[0, 0], [2, 0], [4, 0]], accelerations_m_s2=[1, -1], loop_start_s=4
    )
    route = route_of(stays, 30)
    assert (route.closing, [stop.place_m for stop in route.once]) == (None, [(4, 0, 30)])
    assert route.loop[0].speed_m_s == 2
    assert route.loop[0].planned_s == 4
    waits = Trajectory(robot="a", times_s=[0, 5], positions_m=[[1, 1], [1, 1]], accelerations_m_s2=[0])
    route = route_of(waits, 30)
    assert (route.closing, route.loop[0].place_m) == (None, (1, 1, 30))
    alone = Trajectory(robot="a", times_s=[0.0], positions_m=[[1, 1]], accelerations_m_s2=[])
    assert route_of(alone, 30).loop[0].place_m == (1, 1, 30)


def test_curves_that_touch_have_their_own_corners() -> None:
    # from one parabola into the next, with no straight way between: half of a side of 10 m for each
    corners = np.array([[0.0, 0.0], [40.0, 0.0], [40.0, 10.0], [0.0, 10.0]])
    v = np.sqrt(5 * A / np.sin(np.pi / 4))
    trajectory = rounded(corners, np.array([0.0, v, v, 0.0]), np.zeros(4), top=TOP, a=A)
    route = route_of(trajectory, 30)
    np.testing.assert_allclose(places(route, 2), np.roll(corners, -1, axis=0), atol=NEAR_M)


def test_the_slightest_corner_is_one_corner() -> None:
    # by less than a hundredth of a degree, in two turns that leave the speed as it is but for its last digits
    corners = np.array([[0.0, 0.0], [1000.0, 0.0], [2000.0, 0.08], [1000.0, 800.0]])
    slight = rounded(corners, np.array([0.0, 6.0, 0.0, 0.0]), np.zeros(4), top=TOP, a=0.05, least_tangents=2)
    _, a_round = passed_stops(slight)
    np.testing.assert_allclose([stop.place_m for stop in a_round], np.vstack([corners, corners[:1]]), atol=NEAR_M)
    # and no stop of a route
    found = route_of(slight, 30).every_round
    np.testing.assert_allclose([stop.place_m[:2] for stop in found], corners[[2, 3, 0]], atol=NEAR_M)
    assert sum(stop.planned_s or 0.0 for stop in found) == pytest.approx(slight.loop_duration_s)
    assert found[0].speed_m_s == pytest.approx(TOP)


def test_a_bow_of_slight_corners_keeps_as_many_as_hold_it_within_the_limit() -> None:
    # corners 17.9 m apart on a circle of 500 m: a chord past one is off it by c^2 / 8 r = 0.32 m, past two by 0.72 m
    angles = np.linspace(0, 0.25, 8)
    bow = 500 * np.column_stack([np.sin(angles), 1 - np.cos(angles)])
    corners = np.vstack([bow, [[60.0, 300.0]]])
    speeds = np.array([0.0, *np.full(6, 3.0), 0.0, 0.0])
    _, a_round = passed_stops(rounded(corners, speeds, np.zeros(9), top=TOP, a=A))
    assert len(a_round) == 10
    for within_m, kept in ((0.3, 10), (0.4, 7), (0.8, 6), (5.0, 4)):
        fewer = without_slight(a_round, within_m)
        assert len(fewer) == kept
        line = shapely.LineString([stop.place_m for stop in fewer])
        assert max(line.distance(shapely.Point(stop.place_m)) for stop in a_round) <= within_m


def test_what_is_no_parabola_keeps_its_points() -> None:
    bent = Trajectory(
        robot="a",
        times_s=[0, 2, 3, 5, 9],
        positions_m=[[0, 0], [2, 0], [3, 1.5], [3, 3.5], [0, 0]],
        accelerations_m_s2=[1, 0, 0, 0],
    )
    places_m = [stop.place_m[:2] for stop in route_of(bent, 0).every_round]
    assert places_m == [(2, 0), (3, 1.5), (3, 3.5), (0, 0)]


@pytest.mark.parametrize("turn_deg", [10.0, 90.0, 150.0])
@pytest.mark.parametrize("phases", [[(1, 0.4)], [(2, 0.25), (3, 0.5)], [(2, 0.2), (2, 0.3), (1, 0.4)]])
def test_a_curve_whose_acceleration_grows_and_falls_in_phases_is_one_corner(
    turn_deg: float, phases: list[tuple[int, float]]
) -> None:
    """phases: of each how many turns it has, equally long apart, until the middle of the curve."""
    half = np.radians(turn_deg) / 2
    speed, there = 5.0, np.array([40.0, 0.0])
    before, after = speed * np.array([1.0, 0.0]), speed * np.array([np.cos(2 * half), np.sin(2 * half)])
    # jumps of all phases, up and down, each as great as its number says, and half of its time on either side
    jumps = [(k + 1.0, apart_s) for k, (count, apart_s) in enumerate(phases) for _ in range(count)]
    jumps += jumps[::-1]
    lasts_s = sum(apart_s for _, apart_s in jumps)
    total = sum(size for size, _ in jumps)
    at_s, velocity, places, times_s = 0.0, before, [there - 8 * before, there - before * lasts_s / 2], [0.0]
    times_s.append(8.0 - lasts_s / 2)
    for size, apart_s in jumps:
        places += [places[-1] + velocity * apart_s / 2]
        velocity = velocity + (after - before) * size / total
        places += [places[-1] + velocity * apart_s / 2]
        times_s += [times_s[-1] + apart_s / 2, times_s[-1] + apart_s]
        at_s += apart_s
    places.append(places[-1] + 8 * after)
    times_s.append(times_s[-1] + 8)
    way = Trajectory(
        robot="a", times_s=np.array(times_s), positions_m=np.array(places), loop_start_s=times_s[-1],
        accelerations_m_s2=np.zeros(len(times_s) - 1),
    )  # fmt: skip
    stops, _ = passed_stops(way)
    assert [stop.rests for stop in stops] == [True, False, True]
    np.testing.assert_allclose(stops[1].place_m, there, atol=NEAR_M)
    assert stops[1].reached_s == pytest.approx(8.0)
    assert stops[1].top_speed_m_s == pytest.approx(speed)
