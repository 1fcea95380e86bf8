"""One ground to the tours that sweep it, by as few robots as its period and the lanes' lengths allow.

Sun et al. 2019, Figure 3, draws such methods for one open area with one period; here each takes the ground of one group
of period classes in one component of the standing space, so that zones can have routes of their own (``search`` chooses
the groups). A share ``reserve`` of every robot's budget is kept for the repair. A method that needs more robots than
``most`` gives None.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.methods.sweeping.routes import (
    SweepGround,
    best_route,
    promising_angles,
    robots_for,
)
from rota.planners.patrol.tours.tour import Tour, tour_length_m

Floats = NDArray[np.float64]
Sweeping = Callable[[Problem, SweepGround, float, int | None], list[Tour] | None]  # see the methods of this module

BALANCING = 6  # rounds in which strips, sub-areas and districts are made more alike


def sequential(problem: Problem, ground: SweepGround, reserve: float, most: int | None) -> list[Tour] | None:
    """One route over everything, with robots evenly spaced on it (Figure 3b), as many as its length needs."""
    return share_out(best_route(problem, ground, ground.shape, promising_angles(problem, ground.shape)), reserve, most)


def sequential_once(most_angles: int) -> Sweeping:
    """The method ``sequential`` for one problem, with so many directions of lanes; no ground gets lanes twice."""
    routes: dict[tuple[bytes, bytes, int, int], Tour | None] = {}

    def sweeping(problem: Problem, ground: SweepGround, reserve: float, most: int | None) -> list[Tour] | None:
        key = (ground.shape.wkb, ground.stops_m.tobytes(), ground.period_class, ground.component)
        if key not in routes:
            tried = promising_angles(problem, ground.shape, most_angles)
            routes[key] = best_route(problem, ground, ground.shape, tried)
        return share_out(routes[key], reserve, most)

    return sweeping


def share_out(tour: Tour | None, reserve: float, most: int | None) -> list[Tour] | None:
    """The route with as many robots as its length needs; none where there is no route."""
    return [] if tour is None else not_more([replace(tour, robots=robots_for(tour, reserve))], most)


def not_more(tours: list[Tour], most: int | None) -> list[Tour] | None:
    """The tours, or None when they have more robots than that."""
    return tours if most is None or burden(tours)[0] <= most else None


def meets_itself(tours: list[Tour]) -> bool:
    """Whether robots with bodies share a lane to and fro, and so come face to face."""
    return any(tour.robots > 1 and tour.robot.body_radius_m > 0 for tour in tours)


def burden(tours: list[Tour]) -> tuple[int, float]:
    """Robots, then the fullest budget of any: what makes one division of the ground better than another."""
    return sum(tour.robots for tour in tours), max((load(tour) for tour in tours), default=0.0)


def load(tour: Tour) -> float:
    """Length over budget."""
    return tour_length_m(tour) / tour.budget_m
