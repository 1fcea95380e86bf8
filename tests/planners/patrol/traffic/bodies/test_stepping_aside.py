"""Robots with small loops that step aside for others, against distances simulated in small steps."""

from typing import Any

import numpy as np
import pytest
from tests.planners.patrol.traffic.bodies.driving import BODY_M, closest_m, tour

from rota.planners.patrol.driving.timed_line import steady
from rota.planners.patrol.tours.timetable import line_of
from rota.planners.patrol.tours.tour import Tour
from rota.planners.patrol.traffic.bodies import timing
from rota.planners.patrol.traffic.bodies.loops import Timed, loop_of
from rota.planners.patrol.traffic.bodies.timing import (
    crowds_that_touch,
    longest_free,
    near_times,
    round_between,
    timed_rounds,
    waiting_place,
)

PERIOD_S = 40.0
POCKET = tour([(0, 0), (0, 0.3)], PERIOD_S)
PAST_IT = tour([(0, -0.705), (3, -0.705), (3, -3)], PERIOD_S)  # 5 mm off who waits at the far end of the pocket


def test_who_is_in_a_pocket_waits_until_the_other_is_away() -> None:
    rounds = timed_rounds([POCKET, PAST_IT], BODY_M)
    assert [times[-1] for times, *_ in rounds] == pytest.approx([PERIOD_S, PERIOD_S], rel=1e-5)
    assert rounds[0][0][-1] == rounds[1][0][-1]
    assert closest_m(rounds, 3 * PERIOD_S) >= 2 * BODY_M
    assert (rounds[0][1] == (0, 0)).all(axis=1).any()  # it drives its round all the same


def test_it_waits_for_all_robots_that_share_a_loop() -> None:
    shared = tour([(0, -0.705), (6, -0.705), (6, -3), (0, -3)], PERIOD_S, robots=2)
    rounds = timed_rounds([POCKET, shared], BODY_M)
    assert crowds_that_touch([POCKET, shared], BODY_M) == []
    assert len(rounds) == 3
    assert rounds[0][0][-1] == pytest.approx(rounds[1][0][-1] / 2)  # once in each of their headways
    assert closest_m(rounds, 4 * PERIOD_S) >= 2 * BODY_M


@pytest.mark.parametrize(
    ("loops", "k"),
    [
        ([POCKET, tour([(0, -0.6), (3, -0.6)], PERIOD_S)], 0),  # too near wherever it waits
        ([POCKET, tour([(0, -5), (3, -5)], PERIOD_S)], 0),  # nobody is in its way
        ([tour([(0, 0)], PERIOD_S), PAST_IT], 0),  # it never moves
        ([POCKET, PAST_IT], 1),  # no small loop
        ([POCKET], 0),
    ],
)
def test_others_are_timed_like_any_loop(loops: list[Tour], k: int) -> None:
    assert waiting_place([loop_of(one) for one in loops], k, 2 * BODY_M) is None


@pytest.mark.parametrize(
    ("times_s", "places_m"),
    [
        ([0], [(0, -0.705)]),  # it stays
        ([0, PERIOD_S, 2 * PERIOD_S], [(0, -0.705), (3, -3), (0, -0.705)]),  # it comes once in two periods
        ([0, 20, 40], [(0, -0.705), (0.1, -0.705), (0, -0.705)]),  # it never goes away
    ],
)
def test_nobody_steps_aside_for_who_leaves_no_time(times_s: list[float], places_m: list[tuple[float, float]]) -> None:
    other = Timed(steady(np.array(times_s, float), np.array(places_m, float)), 0.0)
    assert round_between(loop_of(POCKET), 1, [(loop_of(PAST_IT), other)], 2 * BODY_M) is None


def test_many_that_cannot_step_aside_take_little_time(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []

    def phases_apart(loops: list[Any], clock: Any, body_radius_m: float) -> None:
        asked.append(len(loops))

    monkeypatch.setattr(timing, "phases_apart", phases_apart)
    monkeypatch.setattr(timing, "waits_apart", lambda *_: None)
    main = tour([(0, 0), (70, 0), (70, 5), (0, 5)], 400.0)  # a headway longer than all of the pockets' periods
    pockets = [tour([(x, -0.58), (x, -0.7)], 60.0) for x in range(5, 65, 10)]
    loops = [loop_of(one) for one in (main, *pockets)]
    assert timing.time_apart(loops, BODY_M) is None
    assert len(asked) < 40  # 1957 where each is tried among those left of each


def test_times_near_a_line_are_told_to_a_piece_of_a_leg() -> None:
    line = line_of(POCKET.vertices_m)
    timed = Timed(steady(np.array([0.0, 10.0, 20.0]), np.array([[0.0, -5.0], [0.0, -0.5], [0.0, -5.0]])), 3.0)
    near_s = near_times(timed, line, 1.0)
    assert near_s.min() == pytest.approx(10 * 4.0 / 4.5 - 3.0, abs=0.12)
    assert near_s.max() == pytest.approx(10 + 10 * 0.5 / 4.5 - 3.0, abs=0.12)


@pytest.mark.parametrize(
    ("busy_s", "free_s"),
    [
        ([(2, 3), (5, 6)], (6, 12)),  # through the end of a headway
        ([(-1, 2), (5, 6)], (6, 9)),
        ([(8, 11)], (11, 18)),
        ([(0, 4), (1, 2), (7, 8)], (4, 7)),
        ([], (0, 10)),
    ],
)
def test_the_longest_free_time_goes_round(busy_s: list[tuple[float, float]], free_s: tuple[float, float]) -> None:
    assert longest_free(np.array(busy_s, float).reshape(-1, 2), 10.0) == free_s


def test_no_time_is_free_where_others_follow_each_other() -> None:
    assert longest_free(np.array([(0.0, 5.0), (4.0, 10.0)]), 10.0) is None
    assert longest_free(np.array([(3.0, 14.0)]), 10.0) is None
