"""Robots by the orders of their tasks: against brute force, nonlinear programs and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize
from tests.planners.patrol.bounds.test_bounds_of_far_places import robots_on_a_graph
from tests.planners.patrol.searching import YARD

from rota.planners.patrol.bounds import tour_bound as tour_bound_module
from rota.planners.patrol.bounds.length_kernels import LONGEST, Tasks, is_longer
from rota.planners.patrol.bounds.strongest_robot import strongest_robot
from rota.planners.patrol.bounds.tour_bound import robots_on_rounds, spread_out, tour_bound
from rota.planners.patrol.bounds.witness_points import Witnesses

ROBOT = strongest_robot(YARD.fleet)
SPEED_M_S = ROBOT.ground_speed_m_s


def ways(xy: np.ndarray) -> np.ndarray:
    return np.hypot(*(xy[:, None] - xy[None, :]).transpose(2, 0, 1))


def places(xy_m: list[tuple[float, float]], range_m: float, period_s: list[float]) -> Witnesses:
    """Places on open ground that are served from so near."""
    n, centre_m = len(xy_m), np.array(xy_m, dtype=np.float64).reshape(-1, 2)
    return Witnesses(
        centre_m=centre_m,
        spread_m=np.full(n, range_m),
        range_m=np.full(n, range_m),
        corners=np.zeros(n, dtype=np.int64),
        corner_m=np.zeros((n, 1, 2)),
        period_s=np.array(period_s, dtype=np.float64),
        way_m=ways(centre_m),
        component=np.zeros(n, dtype=np.int64),
        components=1,
    )


def in_order(centre_m: np.ndarray, radius_m: np.ndarray, hulls: list[np.ndarray | None], apart_m: np.ndarray) -> Tasks:
    """Tasks in discs, or in the hulls where there are any, one after another, with all the time in the world."""
    n = len(centre_m)
    corner_m = np.zeros((n, 8, 2))
    for k, hull in enumerate(hulls):
        if hull is not None:
            corner_m[k, : len(hull)] = hull
    return Tasks(
        place=np.arange(n),
        opens_m=np.full(n, -1e6),
        closes_m=np.full(n, 1e6),
        centre_m=centre_m,
        radius_m=radius_m,
        corners=np.array([0 if hull is None else len(hull) for hull in hulls], dtype=np.int64),
        corner_m=corner_m,
        apart_m=apart_m,
    )


def longest_proved(tasks: Tasks) -> float:
    """The greatest length that the way past all tasks in their order is proved to have, by halving."""
    n = len(tasks.place)
    low, high = 0.0, 1e3
    for _ in range(40):
        middle, xy_m = (low + high) / 2, np.zeros((LONGEST, 2))
        xy_m[:n] = tasks.centre_m
        if is_longer(np.arange(LONGEST), xy_m, 0, n - 1, middle, tasks):
            low = middle
        else:
            high = middle
    return low


@pytest.mark.parametrize("with_hulls", [False, True])
def test_proved_lengths_are_those_of_a_nonlinear_program(with_hulls: bool) -> None:
    rng = np.random.default_rng(1)
    shares = []
    for _ in range(40):
        n = int(rng.integers(2, 7))
        centre_m, radius_m = rng.uniform(0, 10, (n, 2)), rng.uniform(0.1, 2, n)
        square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        hulls = [centre_m[k] + radius_m[k] * square if with_hulls and k % 2 else None for k in range(n)]
        proved_m = longest_proved(in_order(centre_m, radius_m, hulls, np.zeros((n, n))))

        def length(flat: np.ndarray) -> float:
            return float(np.sqrt((np.diff(flat.reshape(-1, 2), axis=0) ** 2).sum(axis=1) + 1e-12).sum())

        def room(flat: np.ndarray, c: np.ndarray = centre_m, r: np.ndarray = radius_m, h: list = hulls) -> np.ndarray:
            off = flat.reshape(-1, 2) - c
            discs = np.array([h[k] is None for k in range(len(c))])
            sides = [(r[:, None] - off)[~discs].ravel(), (r[:, None] + off)[~discs].ravel()]
            return np.concatenate([(r**2 - (off**2).sum(axis=1))[discs], *sides])

        found = minimize(length, centre_m.ravel(), method="SLSQP", constraints={"type": "ineq", "fun": room})
        assert proved_m <= found.fun + 1e-4
        shares.append((proved_m + 0.05) / (found.fun + 0.05))
    assert np.median(shares) > 0.995
    assert min(shares) > 0.85  # places near each other pull no harder than from so far


def test_a_leg_round_a_wall_counts_as_long_as_its_places_are_apart() -> None:
    centre_m, radius_m = np.array([[0.0, 0.0], [10.0, 0.0], [12.0, 0.0]]), np.full(3, 0.5)
    apart_m = np.zeros((3, 3))
    apart_m[1, 2] = apart_m[2, 1] = 30.0
    # 9 m straight, with the second place's far side for nothing, and 30 m round the wall
    assert longest_proved(in_order(centre_m, radius_m, [None] * 3, apart_m)) == pytest.approx(39.0, rel=1e-3)
    assert longest_proved(in_order(centre_m, radius_m, [None] * 3, np.zeros((3, 3)))) == pytest.approx(11.0, rel=1e-3)


@pytest.mark.parametrize("range_m", [0.0, 1.0])
def test_one_robot_comes_to_both_ends_of_a_line_in_twice_the_way_between(range_m: float) -> None:
    ends = [(0.0, 0.0), (10.0, 0.0)]
    there_and_back_s = 2 * (10 - 2 * range_m) / SPEED_M_S
    for period_s, robots in ((1.01 * there_and_back_s, 1), (0.99 * there_and_back_s, 2)):
        assert tour_bound(places(ends, range_m, [period_s] * 2), ROBOT, 1, 100).robots == robots


def test_one_robot_goes_round_three_places_in_a_period() -> None:
    ring = [(0.0, 0.0), (10.0, 0.0), (5.0, 75**0.5)]
    # within a window alone 20 m would do, and 15 m to either side of one of them
    for period_s, robots in ((30.1 / SPEED_M_S, 1), (29.9 / SPEED_M_S, 2)):
        assert tour_bound(places(ring, 0.0, [period_s] * 3), ROBOT, 1, 100).robots == robots


def test_two_lines_far_apart_take_two_robots_each_on_short_periods() -> None:
    ends = [(0.0, 0.0), (10.0, 0.0), (0.0, 100.0), (10.0, 100.0)]
    for period_s, robots in ((9.9 / SPEED_M_S, 4), (12 / SPEED_M_S, 4), (20.1 / SPEED_M_S, 2)):
        assert tour_bound(places(ends, 0.0, [period_s] * 4), ROBOT, 1, 1000).robots == robots


def test_known_bounds_are_kept_and_many_robots_are_not_asked_about() -> None:
    ends = [(0.0, 0.0), (10.0, 0.0)]
    assert tour_bound(places(ends, 0.0, [100 / SPEED_M_S] * 2), ROBOT, 5, 100).robots == 5
    assert tour_bound(places(ends, 0.0, [1 / SPEED_M_S] * 2), ROBOT, 9, 100).robots == 9
    assert tour_bound(places(ends[:0], 0.0, []), ROBOT, 1, 100).robots == 1


def test_nobody_is_asked_about_who_can_go_round_all_places(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(2)
    some = [
        places([tuple(xy) for xy in rng.uniform(0, 10, (n, 2))], 0.5, list(rng.uniform(4, 40, n) / SPEED_M_S))
        for n in rng.integers(1, 6, 24)
    ]
    enough = [robots_on_rounds(witnesses, ROBOT) for witnesses in some]
    bounds = [tour_bound(witnesses, ROBOT, 1, 20).robots for witnesses in some]
    monkeypatch.setattr(tour_bound_module, "robots_on_rounds", lambda *_: np.inf)
    assert [tour_bound(witnesses, ROBOT, 1, 20).robots for witnesses in some] == bounds
    pairs = list(zip(enough, bounds, strict=True))
    assert all(known >= proved for known, proved in pairs)
    assert sum(known == proved for known, proved in pairs) >= 8


def test_what_is_proved_before_a_stop_is_kept() -> None:
    ends = [(0.0, 0.0), (10.0, 0.0), (0.0, 100.0), (10.0, 100.0)]
    needs_four = places(ends, 0.0, [9.9 / SPEED_M_S] * 4)
    for looks, robots in ((0, 1), (1, 2), (2, 3), (100, 4)):
        left = iter(range(looks))
        assert tour_bound(needs_four, ROBOT, 1, 1000, lambda left=left: next(left, None) is None).robots == robots


def test_nothing_is_proved_of_what_robots_on_a_lattice_can_do() -> None:
    rng = np.random.default_rng(0)
    exact = 0
    for _ in range(150):
        xy = [(0, 0)]
        edges: list[tuple[int, int]] = []
        while len(xy) < 4:  # a tree with edges a metre long
            at = int(rng.integers(len(xy)))
            step = ((0, 1), (1, 0), (0, -1), (-1, 0))[int(rng.integers(4))]
            there = (xy[at][0] + step[0], xy[at][1] + step[1])
            if there not in xy:
                edges.append((at, len(xy)))
                xy.append(there)
        periods = tuple(int(p) for p in rng.integers(1, 5, 4))
        robots = robots_on_a_graph(edges, periods)
        # a place that is seen at whole seconds in every T of them is seen in every window of T seconds
        proved = tour_bound(places(xy, 0.0, [p / SPEED_M_S for p in periods]), ROBOT, 1, 1000).robots
        assert proved <= robots, (xy, periods)
        exact += proved == robots
    assert exact >= 100


def test_places_spread_out_from_the_farthest() -> None:
    xy_m = np.array([[0.0, 0.0], [1.0, 0.0], [10.0, 0.0], [5.0, 1.0]])
    assert list(spread_out(xy_m, 4)) == [2, 0, 3, 1]
    assert list(spread_out(xy_m, 4, 3)) == [3, 0, 2, 1]
    assert len(spread_out(np.zeros((0, 2)), 4)) == 0
