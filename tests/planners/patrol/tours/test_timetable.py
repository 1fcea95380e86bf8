"""Timetables: durations in closed form, speeds, turning pauses, and one round begun anywhere."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely import LineString

from rota.model.mission import DiscSensor, Fleet, Robot
from rota.planners.patrol.driving.polylines import without_straight_vertices
from rota.planners.patrol.driving.timed_line import start_at, steady
from rota.planners.patrol.tolerances import HAIR_M
from rota.planners.patrol.tours.timetable import (
    as_trajectories,
    evenly_spaced,
    loop_timetable,
    stretch_line,
)
from rota.planners.patrol.tours.tour import Tour, tour_length_m

Floats = NDArray[np.float64]
ROBOT = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=1)).equal_robot("r")
TURNING = replace(ROBOT, turn_rate_rad_s=0.5)
SQUARE = np.array([[0.0, 0], [6, 0], [6, 6], [0, 6]])


def tour(vertices_m: object, **fields: object) -> Tour:
    values: dict[str, object] = {"period_class": 0, "period_s": 20.0, "robots": 1, "robot": ROBOT, "component": 0}
    return Tour(vertices_m=np.array(vertices_m, dtype=np.float64), **(values | fields))  # type: ignore[arg-type]


def speeds(times_s: Floats, places_m: Floats) -> Floats:
    return np.hypot(*np.diff(places_m, axis=0).T) / np.diff(times_s)


def random_ring(rng: np.random.Generator) -> Floats:
    return rng.uniform(0, 30, (int(rng.integers(2, 12)), 2))


def positions(times_s: Floats, places_m: Floats, at_s: Floats) -> Floats:
    return np.column_stack([np.interp(at_s % times_s[-1], times_s, places_m[:, axis]) for axis in (0, 1)])


def test_a_square_at_full_speed() -> None:
    times, places, _ = loop_timetable(SQUARE, ROBOT)
    assert times == pytest.approx([0, 3, 6, 9, 12], rel=2e-6)
    assert places.tolist() == [*SQUARE.tolist(), [0, 0]]
    assert (speeds(times, places) < 2).all()  # a millionth below, so that rounding is never speeding


def test_turning_takes_angle_over_rate() -> None:
    times, places, _ = loop_timetable(SQUARE, TURNING)
    # four legs of 3 s and four quarter turns of pi seconds
    assert times[-1] == pytest.approx(12 + 4 * math.pi, rel=2e-6)
    assert times == pytest.approx(np.cumsum([0, 3, math.pi, 3, math.pi, 3, math.pi, 3, math.pi]), rel=2e-6)
    pauses = np.flatnonzero((np.diff(places, axis=0) == 0).all(axis=1))
    assert np.diff(times)[pauses] == pytest.approx([math.pi] * 4, rel=2e-6)
    assert (np.diff(times)[pauses] > math.pi).all()
    assert places[pauses].tolist() == [[6, 0], [6, 6], [0, 6], [0, 0]]


def test_the_way_there_and_back() -> None:
    times, places, _ = loop_timetable(np.array([[0.0, 0], [3, 4]]), ROBOT)
    assert times == pytest.approx([0, 2.5, 5], rel=2e-6)
    assert places.tolist() == [[0, 0], [3, 4], [0, 0]]
    times, *_ = loop_timetable(np.array([[0.0, 0], [3, 4]]), TURNING)
    assert times[-1] == pytest.approx(5 + 2 * math.pi / 0.5, rel=2e-6)


@pytest.mark.parametrize("vertices", [[[1.0, 2]], [[1.0, 2], [1, 2]], [[1.0, 2], [1, 2 + 1e-7]]])
def test_a_tour_without_length_is_a_robot_that_stays(vertices: list[list[float]]) -> None:
    times, places, _ = loop_timetable(np.array(vertices), TURNING)
    assert times.tolist() == [0]
    assert places.tolist() == [[1, 2]]
    line = stretch_line(steady(times, places), 7.0)
    times = line.times_s
    assert times.tolist() == [0]
    (one,) = as_trajectories(evenly_spaced(line, 1), ["r"])
    assert one.loop_duration_s == 0


@pytest.mark.parametrize("robot", [ROBOT, TURNING])
def test_random_tours_take_their_length_over_speed(robot: Robot) -> None:
    rng = np.random.default_rng(1)
    for _ in range(100):
        ring = random_ring(rng)
        times, places, _ = loop_timetable(ring, robot)
        assert times[0] == 0
        assert (np.diff(times) > 0).all()
        assert places[0].tolist() == places[-1].tolist() == ring[0].tolist()
        assert times[-1] == pytest.approx(tour_length_m(tour(ring, robot=robot)) / 2, rel=2e-6)
        assert times[-1] > tour_length_m(tour(ring, robot=robot)) / 2
        assert speeds(times, places).max() <= 2
        assert [p for p in places.tolist() if p in ring.tolist()] == places.tolist()


@pytest.mark.parametrize("robot", [ROBOT, TURNING])
def test_a_round_can_be_stretched_by_driving_slower(robot: Robot) -> None:
    rng = np.random.default_rng(2)
    for _ in range(50):
        ring = random_ring(rng)
        line = loop_timetable(ring, robot)
        natural, places, _ = line
        wanted = float(natural[-1]) * rng.uniform(1, 3)
        times, same, _ = stretch_line(line, wanted)
        assert times[-1] == wanted  # to the last bit: loops with a common period depend on it
        assert same.tolist() == places.tolist()
        assert speeds(times, same).max() <= 2
        # pauses for turning stay as long as they were
        still = (np.diff(places, axis=0) == 0).all(axis=1)
        assert np.diff(times)[still] == pytest.approx(np.diff(natural)[still])
        # what is asked for and cannot be reached is not pretended
        too_short, *_ = stretch_line(line, 0.5 * float(natural[-1]))
        assert too_short[-1] == pytest.approx(natural[-1])


def test_thinning_keeps_the_line() -> None:
    rng = np.random.default_rng(3)
    for _ in range(100):
        ring = random_ring(rng)
        # every leg gets points on it, repeats, and a step too short to be timed
        crowded = []
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            crowded += [a, a, a + 1e-7, *(a + t * (b - a) for t in np.sort(rng.uniform(0.01, 0.99, 3)))]
        lean = without_straight_vertices(np.array(crowded))
        legs = np.hypot(*(np.roll(lean, -1, axis=0) - lean).T)
        assert legs.min() >= HAIR_M
        line, full = (LineString(np.vstack([xy, xy[:1]])) for xy in (lean, np.array(crowded)))
        assert shapely.distance(shapely.points(np.array(crowded)), line).max() < 2e-6
        assert shapely.distance(shapely.points(lean), full).max() < 1e-9
        assert line.length == pytest.approx(full.length, abs=1e-4)


def test_between_two_corners_of_walls_that_nearly_touch_each_is_passed_slowly() -> None:
    robot = Fleet(speed_m_s=2.0, sensor=DiscSensor(radius_m=1.0)).equal_robot("r")
    zigzag = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2e-6], [2.0, 2e-6], [1.0, 3.0], [1.0 - 5e-7, 3.0]])
    times_s, places_m, _ = loop_timetable(zigzag, robot)
    np.testing.assert_array_equal(places_m[:-1], zigzag[:5])
    assert np.diff(times_s).min() == pytest.approx(5e-6)


def test_thinning_by_hand() -> None:
    along = np.array([[0.0, 0], [1, 0], [3, 0], [6, 0], [6, 6], [0, 6], [0, 2]])
    assert without_straight_vertices(along).tolist() == SQUARE.tolist()
    # there and back along one line: the two ends are the corners
    assert without_straight_vertices(np.array([[0.0, 0], [1, 0], [4, 0], [2, 0]])).tolist() == [[0, 0], [4, 0]]
    # a spike is a corner, however thin
    spike = np.array([[0.0, 0], [2, 0], [2, 3], [2, 0], [4, 0], [2, -3]])
    assert without_straight_vertices(spike).tolist() == spike.tolist()
    assert without_straight_vertices(np.array([[5.0, 5]])).tolist() == [[5, 5]]


@pytest.mark.parametrize("robot", [ROBOT, TURNING])
def test_a_round_begun_later_is_the_same_round(robot: Robot) -> None:
    rng = np.random.default_rng(4)
    for _ in range(100):
        times, places, _ = loop_timetable(random_ring(rng), robot)
        duration = float(times[-1])
        on_a_vertex = float(times[rng.integers(0, len(times))])
        for phase in (rng.uniform(0, duration), on_a_vertex, on_a_vertex + 1e-12, -0.3 * duration, 2.7 * duration, 0.0):
            later, there, _ = start_at(steady(times, places), phase)
            assert later[0] == 0
            assert later[-1] == duration  # bit for bit
            assert (np.diff(later) > 0).all()
            assert there[0].tolist() == there[-1].tolist()
            assert speeds(later, there).max() <= 2
            at = rng.uniform(0, duration, 40)
            assert positions(later, there, at) == pytest.approx(positions(times, places, at + phase), abs=1e-4)
            # no corner is cut
            line = LineString(there)
            assert shapely.distance(shapely.points(places), line).max() < 1e-9
            assert line.length == pytest.approx(LineString(places).length)


def test_robots_of_a_tour_follow_each_other_at_equal_times() -> None:
    rng = np.random.default_rng(5)
    for robots in (1, 2, 3, 7):
        ring = random_ring(rng)
        rounds = evenly_spaced(loop_timetable(ring, TURNING), robots)
        assert len(rounds) == robots
        leader = rounds[0][:2]
        duration = rounds[0].duration_s
        at = rng.uniform(0, duration, 60)
        for k, (times, places, _) in enumerate(rounds):
            assert times[-1] == duration
            expected = positions(*leader, at + k * duration / robots)
            assert positions(times, places, at) == pytest.approx(expected, abs=1e-4)


def test_offsets_shift_all_robots_of_their_tour() -> None:
    slow = stretch_line(loop_timetable(SQUARE, ROBOT), 16.0)
    rounds = [
        *evenly_spaced(slow, 2, 1.0),
        *evenly_spaced(loop_timetable(SQUARE + 20, ROBOT), 1, 2.5),
        *evenly_spaced(loop_timetable(np.array([[9.0, 9]]), ROBOT), 1, 3.0),
    ]
    assert [len(times) > 1 for times, *_ in rounds] == [True, True, True, False]
    assert [float(times[-1]) for times, *_ in rounds[:2]] == [16.0, 16.0]
    # at 16 s the square of 24 m is driven at 1.5 m/s
    assert rounds[0][1][0] == pytest.approx([1.5, 0])
    assert rounds[1][1][0] == pytest.approx([6, 6 + 0.0], abs=1.6)
    assert rounds[1][1][0] == pytest.approx(positions(*slow[:2], np.array([9.0]))[0])
    assert rounds[2][1][0] == pytest.approx([25, 20], rel=1e-5)
    assert rounds[3][1].tolist() == [[9, 9]]
    named = as_trajectories(rounds, ["a", "b", "c", "d"])
    assert [one.robot for one in named] == ["a", "b", "c", "d"]
    assert [one.loop_start_s for one in named] == [0, 0, 0, 0]
    assert named[0].loop_duration_s == 16.0
    assert named[0].loop_length_m == pytest.approx(24)
