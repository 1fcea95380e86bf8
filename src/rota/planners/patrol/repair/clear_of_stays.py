"""Tours led round robots that stay for ever, before repair makes them see all that they can from there."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import shapely
from shapely import MultiPolygon

from rota.planners.patrol.ground.keeping_off import keeping_off
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.repair.detours import least_detour, with_detour
from rota.planners.patrol.tours.tour import Tour
from rota.planners.patrol.traffic.bodies.lanes import lead_along


def clear_of_who_stays(problem: Problem, tours: list[Tour]) -> tuple[Problem, list[Tour]]:
    """The problem with room for robots that stay in parts of the space of their own, and the tours led round them.

    All of a part no wider than a body counts as the place where its robot stays: it may be led to and fro there.
    """
    body_m, parts = problem.robot.body_radius_m, problem.paths.parts
    narrow = [shapely.minimum_bounding_radius(part) <= body_m / 2 for part in parts]
    stay = [tour for tour in tours if len(tour.vertices_m) == 1 or narrow[tour.component]]
    if not stay or body_m == 0:
        return problem, tours
    spots = [parts[t.component] if narrow[t.component] else shapely.Point(t.vertices_m[0]) for t in stay]
    clear = keeping_off(problem, spots, [tour.component for tour in stay])
    if clear is problem:
        return problem, tours
    parts, paths = clear.paths.parts, clear.paths
    return clear, [lead_along(t, t.vertices_m, MultiPolygon([parts[t.component]]), paths, 0.0) for t in tours]


def past_where_they_wait(problem: Problem, tours: Sequence[Tour]) -> list[Tour]:
    """The tours, those in pockets whose robots step aside for others led past the places where they wait meanwhile."""
    waits_m = dict(problem.waits_m)
    led = list(tours)
    for k, tour in enumerate(tours):
        if tour.component in waits_m and tour.robots == 1 and tour.nest < 0 and tour.robot.turn_radius_m == 0:
            place_m = np.array(waits_m[tour.component])
            if not (tour.vertices_m == place_m).all(axis=1).any():
                leg, longer_m = least_detour(problem, tour.vertices_m, place_m)
                led[k] = with_detour(problem, tour, leg, place_m[None]) if math.isfinite(longer_m) else tour
    return led
