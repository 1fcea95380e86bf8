"""First tours: for each group of period classes, part and cluster, a short round trip past places that see it all."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from rota.model.arrays import Flags, Floats, Ints
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.viewpoints import choose_viewpoints, what_places_see
from rota.planners.patrol.initial.standing import robots_stand, standing_tours, tour_of_one
from rota.planners.patrol.tours.tour import Tour, tour_length_m
from rota.planners.patrol.tours.visiting_order import short_order

MOST_GEODESIC = 1500  # beyond as many places, their order is found with straight distances
MOST_ORDERED = 4000  # beyond as many places, or ends of lanes, lanes are their order
MOST_ORDERED_RAGGED = 7000  # the same among ragged walls, which lanes would cross again and again
DETOUR = 1.15  # length of real tours over area / swath, for choosing groups and how many robots share a hub


def class_groups(problem: Problem) -> Iterator[tuple[tuple[int, ...], ...]]:
    """Ways to serve the period classes by groups (each by its shortest period), the fewest expected robots first."""
    classes = range(len(problem.periods_s))
    area_m2 = [
        sum(
            r.shape.area
            for r, k in zip(problem.regions, problem.region_class, strict=True)
            if k == c and r.demand != "visit"
        )
        for c in classes
    ]

    def expectation(groups: tuple[tuple[int, ...], ...]) -> tuple[int, float]:
        shares = []
        for group in groups:
            swept = problem.swath_m * problem.pace_m_s * problem.periods_s[group[0]]
            shares.append(DETOUR * sum(area_m2[c] for c in group) / swept)
        return sum(max(1, math.ceil(share)) for share in shares), sum(shares)

    groupings = []
    for cuts in itertools.product([False, True], repeat=max(0, len(area_m2) - 1)):
        groups: list[tuple[int, ...]] = [(0,)]
        for c, cut in enumerate(cuts, start=1):
            if cut:
                groups.append((c,))
            else:
                groups[-1] = (*groups[-1], c)
        groupings.append(tuple(groups))
    return iter(sorted(groupings, key=expectation))


@dataclass(frozen=True, kw_only=True)
class PlaceGroup:
    """Places that one tour, or several, go past to see all that is theirs.

    period_class: of the tours. component: of the standing space. places: their indices in the problem's places.
    stands: the tour of a robot that hardly moves, where the period leaves no time for more; otherwise None.
    """

    period_class: int
    component: int
    places: Ints
    stands: Tour | None = None


def place_groups(problem: Problem, groups: tuple[tuple[int, ...], ...]) -> list[PlaceGroup]:
    """For each group of classes, part and cluster the places from which all of it is seen."""
    viewed: list[PlaceGroup] = []
    places, covered = problem.viewpoints, np.zeros(len(problem.points), dtype=bool)
    for group in groups:
        wanted = np.isin(problem.points.period, group) & ~covered
        if robots_stand(problem, problem.periods_s[group[0]]) and wanted.any():
            for tour in standing_tours(problem, wanted, group[0]):
                _, seen = what_places_see(tour.vertices_m, problem.robot, problem.range_margin_m, problem.samples)
                covered[seen] = True
                viewed.append(
                    PlaceGroup(
                        period_class=group[0], component=tour.component, places=np.zeros(0, dtype=np.int64), stands=tour
                    )
                )
            continue
        chosen, _ = choose_viewpoints(places.start, places.seen, wanted, problem.points.area_m2)
        for place in chosen:
            covered[places.seen[places.start[place] : places.start[place + 1]]] = True
        for component, cluster in clusters(problem, chosen, problem.periods_s[group[0]]):
            viewed.append(PlaceGroup(period_class=group[0], component=component, places=cluster))
    return viewed


def shared_tour(problem: Problem, group: PlaceGroup) -> Tour:
    """One tour past all places of the group, with the robots that its length needs."""
    if group.stands is not None:
        return group.stands
    return tour_past(problem, problem.viewpoints.xy_m[group.places], group.period_class, group.component)


def tours_apart(problem: Problem, group: PlaceGroup, count: int) -> list[Tour]:
    """Up to ``count`` tours of one robot, each past the places of a neighbourhood of its own.

    To share a tour is shorter in the open; to keep apart is better in narrow places, where a shared tour goes there
    and back, and for bodies, which would meet.
    """
    if group.stands is not None:
        return [group.stands]
    places_m = problem.viewpoints.xy_m[group.places]
    if len(places_m) > MOST_GEODESIC:
        labels = list(straight_neighbourhoods(places_m, count))
    else:
        labels = list(neighbourhoods(distances(problem, places_m), count))
    return [tour_past(problem, places_m[label], group.period_class, group.component) for label in labels]


def straight_neighbourhoods(places_m: Floats, count: int) -> Iterator[Ints]:
    """The places (n, 2) in at most ``count`` groups round their middles, by straight distances (Lloyd's iteration)."""
    order = np.lexsort((places_m[:, 1], places_m[:, 0]))
    middles_m = places_m[order[np.linspace(0, len(order) - 1, count).astype(np.int64)]]
    nearest = np.zeros(len(places_m), dtype=np.int64)
    for _ in range(30):
        _, nearest = cKDTree(middles_m).query(places_m)
        sums = np.column_stack([np.bincount(nearest, places_m[:, axis], count) for axis in (0, 1)])
        middles_m = sums / np.maximum(1, np.bincount(nearest, minlength=count))[:, None]
    for k in range(count):
        if (nearest == k).any():
            yield np.flatnonzero(nearest == k)


def neighbourhoods(distance_m: Floats, count: int) -> Iterator[Ints]:
    """The places (n, n distances) in at most ``count`` groups round medoids: far apart at first, then moved to rest."""
    medoids = [int(np.argmax(distance_m.sum(axis=1)))]
    while len(medoids) < min(count, len(distance_m)):
        medoids.append(int(np.argmax(distance_m[medoids].min(axis=0))))
    for _ in range(20):
        nearest = np.argmin(distance_m[medoids], axis=0)
        groups = [np.flatnonzero(nearest == k) for k in range(len(medoids))]
        moved = [int(g[np.argmin(distance_m[np.ix_(g, g)].sum(axis=1))]) for g in groups if len(g)]
        if moved == medoids:
            break
        medoids = moved
    nearest = np.argmin(distance_m[medoids], axis=0)
    for k in range(len(medoids)):
        if (nearest == k).any():
            yield np.flatnonzero(nearest == k)


def clusters(problem: Problem, places: Ints, period_s: float) -> Iterator[tuple[int, Ints]]:
    """The places by part of the standing space, and by distance: who is too far apart gets robots of its own.

    Going there and back from one cluster to the next would take a whole robot (2 d > V T).
    """
    apart_m = max(problem.pace_m_s * period_s / 2, 2 * problem.swath_m)
    for component in np.unique(problem.viewpoints.component[places]):
        own = places[problem.viewpoints.component[places] == component]
        if len(own) > most_ordered(problem):
            yield int(component), own
            continue
        for group in linked_groups(distances(problem, problem.viewpoints.xy_m[own]) <= apart_m):
            yield int(component), own[group]


def linked_groups(linked: Flags) -> Iterator[Ints]:
    """What is linked (n, n), by whatever way, in groups; as a sparse graph a full table takes forty times the room."""
    left = np.ones(len(linked), dtype=np.bool_)
    while left.any():
        fresh = np.arange(len(left)) == np.argmax(left)
        group = fresh
        while fresh.any():
            fresh = linked[fresh].any(axis=0) & ~group
            group = group | fresh
        left &= ~group
        yield np.flatnonzero(group)


def distances(problem: Problem, places_m: Floats) -> Floats:
    """Distances (n, n) between places of one component: round obstacles, or straight when they are very many.

    On ragged ground they are those of ways from place to place, exact between places within four reaches, which are
    found much sooner and hardly longer.
    """
    if problem.is_ragged and len(places_m) <= MOST_ORDERED_RAGGED:
        return problem.paths.lengths_from_point_to_point(places_m, 4 * problem.reach_m)
    if len(places_m) <= MOST_GEODESIC:
        return np.asarray(problem.paths.all_pairs(places_m))
    x, y, away_m = *places_m.T, np.empty((len(places_m), len(places_m)))
    for first in range(0, len(places_m), 256):  # all at once would take three such tables
        rows = slice(first, first + 256)
        np.hypot(np.subtract.outer(x[rows], x), np.subtract.outer(y[rows], y), out=away_m[rows])
    return away_m


def tour_past(problem: Problem, places_m: Floats, period_class: int, component: int) -> Tour:
    """The closed tour past all places along shortest paths, with the robots that it needs."""
    order = (
        lane_order(places_m, problem.swath_m)
        if len(places_m) > most_ordered(problem)
        else short_order(distances(problem, places_m))
    )
    stops = places_m[order]
    vertices = problem.paths.paths_along(np.vstack([stops, stops[:1]]))[:-1] if len(stops) > 1 else stops
    return with_robots_needed(tour_of_one(problem, vertices, period_class, component))


def most_ordered(problem: Problem) -> int:
    """How many places are put in order by their distances, which takes memory as the square of the number."""
    return MOST_ORDERED_RAGGED if problem.is_ragged else MOST_ORDERED


def lane_order(places_m: Floats, lane_m: float) -> Ints:
    """Boustrophedon: lanes as wide as the swath, every second one backwards."""
    lane = np.floor((places_m[:, 1] - places_m[:, 1].min()) / lane_m).astype(np.int64)
    along = np.where(lane % 2 == 0, places_m[:, 0], -places_m[:, 0])
    return np.lexsort((along, lane)).astype(np.int64)


def with_robots_needed(tour: Tour) -> Tour:
    """The tour with as many equally spaced robots as its length needs."""
    one = replace(tour, robots=1)
    return replace(tour, robots=max(1, math.ceil(tour_length_m(tour) / one.budget_m)))
