"""Tours made to turn less: while they are annealed, turning takes time that their robots do not really need."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.driving.polylines import turns_rad
from rota.planners.patrol.tours.tour import Tour


def as_if_turning_cost(tours: Sequence[Tour], metres: float) -> list[Tour]:
    """The tours with robots that take as long to turn by one radian as to drive so many metres.

    Periods are longer by what the turns that are likely to stay take. The tours of nests, whose rounds share their
    budgets, stay as they are.
    """
    return [tour if tour.nest >= 0 else _turning(tour, metres) for tour in tours]


def _turning(tour: Tour, metres: float) -> Tour:
    """One tour with a robot that takes time to turn."""
    speed_m_s = driving_of(tour.robot).pace_m_s
    # a fifth of the turning is likely to go away
    more_s = 0.8 * metres * float(turns_rad(tour.vertices_m).sum()) / (speed_m_s * tour.robots)
    robot = replace(tour.robot, turn_rate_rad_s=speed_m_s / metres)
    return replace(tour, robot=robot, period_s=tour.period_s + more_s)


def as_they_were(tried: Sequence[Tour], tours: Sequence[Tour]) -> list[Tour]:
    """The tours (k,) with the places of those that were tried (k,)."""
    return [replace(tour, vertices_m=other.vertices_m) for tour, other in zip(tours, tried, strict=True)]
