"""Tours to drive, and how near robots come to each other: a simulation in small steps that knows nothing else."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rota.model.mission import DiscSensor, Fleet
from rota.planners.patrol.driving.timed_line import TimedLine
from rota.planners.patrol.tours.tour import Tour

Floats = NDArray[np.float64]
BODY_M = 0.5
TICK_S = 0.01


def tour(
    vertices_m: Sequence[tuple[float, float]], period_s: float, robots: int = 1, turn: float | None = None
) -> Tour:
    """A tour at one metre per second for bodies of half a metre."""
    robot = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=3), body_radius_m=BODY_M, turn_rate_rad_s=turn).equal_robot(
        "r"
    )
    return Tour(vertices_m=np.array(vertices_m, float), period_class=0, period_s=period_s, robots=robots, robot=robot)


def places_at(moments_s: Floats, times_s: Floats, places_m: Floats) -> Floats:
    """Where (n, 2) a robot is that repeats its round for ever."""
    here = moments_s % times_s[-1] if times_s[-1] > 0 else 0 * moments_s
    return np.column_stack([np.interp(here, times_s, places_m[:, axis]) for axis in (0, 1)])


def closest_m(rounds: Sequence[TimedLine], until_s: float) -> float:
    """The least distance between any two robots in the first so many seconds."""
    moments = np.arange(0, until_s, TICK_S)
    at = [places_at(moments, *one[:2]) for one in rounds]
    return min(float(np.hypot(*(a - b).T).min()) for i, a in enumerate(at) for b in at[:i])


def fastest_m_s(rounds: Sequence[TimedLine]) -> float:
    """The greatest speed on any leg."""
    return max(float((np.hypot(*np.diff(p, axis=0).T) / np.diff(t)).max()) for t, p, _ in rounds if len(t) > 1)


def closest_at_any_phase_m(one: Floats, other: Floats, period_s: float) -> Floats:
    """For each of many shifts, how near two closed lines (n, 2), each driven evenly in the period, bring two robots."""
    moments = np.arange(0, period_s, 0.05)
    first = places_at(moments, *evenly(one, period_s))
    second = places_at(moments, *evenly(other, period_s))
    return np.array([np.hypot(*(np.roll(second, k, axis=0) - first).T).min() for k in range(len(moments))])


def evenly(vertices_m: Floats, period_s: float) -> tuple[Floats, Floats]:
    """Times and places of a closed line driven at one speed."""
    closed = np.vstack([vertices_m, vertices_m[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    return along * (period_s / along[-1]), closed
