"""Tours for a team of a given size: spare robots help or stand aside, too few robots share joined tours."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import shapely
from shapely import LineString, MultiLineString

from rota.geometry.free_space import nearest_free_point
from rota.model.mission import Mission
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.tours.tour import Tour, tour_length_m, unfold_nests


def starts_per_component(problem: Problem, asked: Mission) -> Counter[int]:
    """How many robots have a start of their own in each component of the standing space."""
    own_m = [robot.start for robot in asked.fleet.robots or () if robot.start is not None]
    free_m = [nearest_free_point(problem.space, place_m) for place_m in own_m]
    return Counter(int(component) for component in problem.paths.part_of(np.array(free_m).reshape(-1, 2)))


def with_helpers(tours: list[Tour], robots: int, starting: Counter[int]) -> list[Tour]:
    """The tours as driven by so many robots: spare ones join the fullest tours, where robots start if they can.

    starting: robots that start in each component, which bind them to it.
    """
    tours = unfold_nests(tours)
    for _ in range(robots - sum(tour.robots for tour in tours)):
        tours = with_a_helper(tours, components_short(tours, starting))
    return tours


def components_short(tours: list[Tour], starting: Counter[int]) -> set[int]:
    """The components whose tours have fewer robots than start there; all with tours when there is none."""
    robots: Counter[int] = Counter()
    for tour in tours:
        robots[tour.component] += tour.robots
    return {component for component in robots if robots[component] < starting[component]} or set(robots)


def with_a_helper(tours: list[Tour], components: set[int] | None = None) -> list[Tour]:
    """The tours with one robot more on the one whose budget is fullest, of those in these components; None: of all."""
    candidates = [k for k, tour in enumerate(tours) if components is None or tour.component in components]
    fullest = max(candidates, key=lambda k: tour_length_m(tours[k]) / tours[k].budget_m)
    helped = replace(tours[fullest], robots=tours[fullest].robots + 1)
    return [*tours[:fullest], helped, *tours[fullest + 1 :]]


def with_bystanders(problem: Problem, tours: list[Tour], robots: int) -> list[Tour] | None:
    """The tours as driven, and robots that stay where no other comes past; None when there is no room for so many."""
    wide_m = 2 * problem.robot.body_radius_m * (1 + 1e-6)
    routes = [LineString(np.vstack([tour.vertices_m, tour.vertices_m[:1]])) for tour in tours]
    free_m = shapely.distance(MultiLineString(routes), shapely.points(problem.viewpoints.xy_m))
    tours = unfold_nests(tours)
    slowest = max(tours, key=lambda tour: tour.period_s)
    while sum(tour.robots for tour in tours) < robots:
        i = int(np.argmax(free_m))
        if free_m[i] < wide_m:
            return None
        place_m, component = problem.viewpoints.xy_m[i : i + 1], int(problem.viewpoints.component[i])
        tours.append(replace(slowest, vertices_m=place_m, robots=1, component=component, pace=None))
        free_m = np.minimum(free_m, np.hypot(*(problem.viewpoints.xy_m - place_m).T))
    return tours


def join_for_team(problem: Problem, tours: list[Tour], robots: int) -> list[Tour]:
    """The tours served by so many robots, fewer than they need: tours of one component are joined as it takes.

    robots: at least the number of components. They go where the ratio of round time to period is worst.
    """
    tours = [replace(tour, robots=1) for tour in tours]
    while len(tours) > robots:
        pairs = [
            (tour_length_m(a) + tour_length_m(b), i, j)
            for i, a in enumerate(tours)
            for j, b in enumerate(tours[:i])
            if a.component == b.component
        ]
        _, i, j = min(pairs)
        both = joined_tour(problem, tours[i], tours[j])
        tours = [tour for k, tour in enumerate(tours) if k not in (i, j)] + [both]
    for _ in range(robots - len(tours)):
        tours = with_a_helper(tours)
    return tours


def joined_tour(problem: Problem, a: Tour, b: Tour) -> Tour:
    """One tour that goes round both, changing over where they are nearest, at the shorter of the two periods."""
    apart_m = problem.paths.distances(a.vertices_m, b.vertices_m)
    i, j = (int(k) for k in np.unravel_index(int(np.argmin(apart_m)), apart_m.shape))
    first = np.vstack([np.roll(a.vertices_m, -i, axis=0), a.vertices_m[i : i + 1]])
    second = np.vstack([np.roll(b.vertices_m, -j, axis=0), b.vertices_m[j : j + 1]])
    vertices_m = problem.paths.paths_along(np.vstack([first, second, first[:1]]))[:-1]
    quick = a if a.period_class <= b.period_class else b
    return replace(quick, vertices_m=vertices_m, robots=1, pace=None)
