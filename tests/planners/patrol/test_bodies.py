"""Phases that keep bodies apart: against distances sampled over the whole common period."""

import math

import numpy as np
import pytest

from rota.mission import DiscSensor, Robot
from rota.planners.patrol.annealing.tour import Tour
from rota.planners.patrol.bodies import common_durations, timed_rounds

BODY_M = 0.5


def circle_tour(x: float, radius_m: float, period_s: float, robots: int = 1) -> Tour:
    angle = np.linspace(0, 2 * math.pi, 24, endpoint=False)
    robot = Robot(name="r", speed_m_s=1.0, sensor=DiscSensor(radius_m=3), body_radius_m=BODY_M)
    vertices = np.column_stack([x + radius_m * np.cos(angle), radius_m * np.sin(angle)])
    return Tour(vertices_m=vertices, serves=0, period_s=period_s, robots=robots, robot=robot)


def closest_m(rounds: list[tuple[np.ndarray, np.ndarray]], until_s: float) -> float:
    moments = np.arange(0, until_s, 0.02)
    at = [
        np.column_stack([np.interp(moments % times[-1], times, places[:, axis]) for axis in (0, 1)])
        for times, places in rounds
    ]
    return min(float(np.hypot(*(a - b).T).min()) for i, a in enumerate(at) for b in at[:i])


@pytest.mark.parametrize("periods", [(40.0, 40.0), (40.0, 80.0), (40.0, 100.0)])
def test_loops_that_cross_never_bring_bodies_together(periods: tuple[float, float]) -> None:
    tours = [circle_tour(0, 5, periods[0]), circle_tour(6, 5, periods[1])]
    rounds = timed_rounds(tours, BODY_M)
    for (times, _), period in zip(rounds, periods, strict=True):
        assert times[-1] <= period
    ratio = rounds[1][0][-1] / rounds[0][0][-1]
    assert ratio * 12 == pytest.approx(round(ratio * 12), abs=1e-9)  # a simple ratio: the phases hold for ever
    assert closest_m(rounds, 12 * periods[1]) >= 2 * BODY_M


def test_robots_that_share_a_loop_and_cross_another() -> None:
    rounds = timed_rounds([circle_tour(0, 5, 20.0, robots=2), circle_tour(6, 5, 40.0)], BODY_M)
    assert len(rounds) == 3
    assert closest_m(rounds, 400) >= 2 * BODY_M


def test_without_bodies_nobody_waits() -> None:
    (times, _), _ = timed_rounds([circle_tour(0, 5, 40.0), circle_tour(6, 5, 40.0)], 0.0)
    assert times[-1] == pytest.approx(2 * 24 * 5 * math.sin(math.pi / 24), rel=1e-5)  # the 24-gon at full speed


def test_durations_are_multiples_of_one_unit_within_the_periods() -> None:
    tours = [circle_tour(0, 5, 8.0 * 5), circle_tour(6, 5, 20.0 * 5), circle_tour(9, 5, 40.0 * 5)]
    for durations, unit in common_durations(tours, [32.0, 64.0, 150.0]):
        for duration, tour, natural in zip(durations, tours, [32.0, 64.0, 150.0], strict=True):
            assert duration is not None
            assert natural <= duration <= tour.period_s
            assert duration / unit == pytest.approx(round(duration / unit), abs=1e-9)
