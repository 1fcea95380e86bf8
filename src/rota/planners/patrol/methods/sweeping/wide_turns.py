"""The first plan of robots whose turns are wider than lanes lie apart: lanes, rings at the border, and arcs between.

Lanes leave room to turn at their ends, and are driven in an order that skips some, as tractors do (Bochtis & Vougioukas
2008, "Minimising the non-working distance travelled by machines operating in a headland field pattern"). Rings see the
ground beside the border, where the turns are made. What is then unseen gets pieces of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely
from shapely import LineString
from shapely.geometry.base import BaseGeometry

from rota.model.arrays import Floats
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points, prepare_with
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.samples import SamplePoints
from rota.planners.patrol.ground.viewpoints import choose_viewpoints, what_places_see
from rota.planners.patrol.initial.first_tours import class_groups
from rota.planners.patrol.initial.standing import tour_of_one
from rota.planners.patrol.methods.sweeping.routes import (
    SweepGround,
    promising_angles,
    robots_for,
    sensing,
    sweep_grounds,
)
from rota.planners.patrol.methods.sweeping.wide_turn_pieces import lanes_with_room, parts_near, rings
from rota.planners.patrol.methods.sweeping.wide_turn_routes import Route, lengths_m, short_route
from rota.planners.patrol.repair.detours import near_places
from rota.planners.patrol.repair.repair import Repaired, judge_tours
from rota.planners.patrol.repair.seeing import annealing_of
from rota.planners.patrol.tolerances import TO_SPARE
from rota.planners.patrol.tours.curve_kernels import BLOCKED_M
from rota.planners.patrol.tours.tour import Tour, tour_length_m


@dataclass(frozen=True, kw_only=True, eq=False)
class Swept:
    """Grounds, and the route over each of them."""

    problem: Problem
    grounds: tuple[SweepGround, ...]
    routes: tuple[Route, ...]

    @cached_property
    def tours(self) -> list[Tour]:
        """The routes as tours of as many robots as their lengths need."""
        return [self._tour(k) for k in range(len(self.routes))]

    @property
    def rank(self) -> tuple[int, float]:
        """Robots, then travel."""
        return sum(tour.robots for tour in self.tours), sum(tour_length_m(tour) for tour in self.tours)

    def with_piece(self, k: int, gap: int, piece: Floats) -> Swept:
        """The same with one piece more in the k-th route, after the piece with the number of the gap."""
        routes = (*self.routes[:k], self.routes[k].with_piece(gap, piece), *self.routes[k + 1 :])
        return replace(self, routes=routes)

    def _tour(self, k: int) -> Tour:
        ground = self.grounds[k]
        tour = tour_of_one(self.problem, self.routes[k].vertices_m, ground.period_class, ground.component)
        return replace(tour, robots=robots_for(tour, 0.0))


def turns_widely(problem: Problem) -> bool:
    """Whether robots that come back from a lane are on the next but one, or farther off."""
    return 2 * problem.robot.turn_radius_m > problem.swath_m


def sweep_with_wide_turns(context: Context, is_crowded: Callable[[Tour], bool]) -> Repaired | None:
    """A plan of lanes and rings, judged; None where none passes, or where no loop fits in the ground.

    is_crowded: whether a tour has so many robots that it is no use.
    """
    settings = context.settings
    groupings = list(class_groups(context.problem))[: settings.sweeping.groupings]
    found = [swept for groups in groupings if (swept := routes_over(context.problem, groups)) is not None]
    if not found:
        return None
    swept = min(found, key=lambda swept: swept.rank)
    extra = no_points()
    for turn in range(1, settings.repair.rounds + 1):
        points, samples = prepare_with(context.problem, extra)
        swept = seeing_all(context, swept, points, samples)
        if any(is_crowded(tour) for tour in swept.tours):
            return None
        repaired = judge_tours(context, swept.tours, extra, turn, bends=False, eased_by=0.0)
        if repaired.met:
            return repaired
        if len(repaired.extra) == len(extra) or context.should_stop():
            return None
        extra = repaired.extra
    return None


def routes_over(problem: Problem, groups: tuple[tuple[int, ...], ...]) -> Swept | None:
    """A route over the ground of each group of period classes; None where there is none over some."""
    grounds = sweep_grounds(problem, groups)
    routes = [best_route(problem, ground) for ground in grounds]
    if not routes or any(route is None for route in routes):
        return None
    return Swept(problem=problem, grounds=tuple(grounds), routes=tuple(route for route in routes if route))


def best_route(problem: Problem, ground: SweepGround) -> Route | None:
    """The shortest of the routes along lanes in promising directions and rings; None where none keeps to the space.

    Ground that a route does not see is charged for: pieces of their own take long to lead there.
    """
    radius_m = problem.robot.turn_radius_m * (1 + TO_SPARE)
    dearer = 50.0  # times the length of lane that the ground takes: what pieces for it alone take at worst
    best: tuple[float, Route] | None = None
    for pieces in layouts(problem, ground, radius_m):
        if not pieces:
            continue
        route = short_route(pieces, radius_m, problem.paths.grid)
        line = LineString(np.vstack([route.vertices_m, route.vertices_m[:1]]))
        missed_m2 = float(unseen_by(ground.shape, [shapely.get_coordinates(line)], problem.reach_m).area)
        cost_m = line.length + dearer * missed_m2 / problem.swath_m
        if route.is_free and (best is None or cost_m < best[0]):
            best = (cost_m, route)
    return None if best is None else best[1]


def layouts(problem: Problem, ground: SweepGround, radius_m: float) -> Iterator[list[Floats]]:
    """Pieces that see the ground in the open: a ring at the border, lanes, and rings where lanes leave room to turn.

    Rings a swath apart see all but ground in corners, and nearer to each other all; both are tried. None lies deeper
    than two radii: beyond that lanes have room.
    """
    space = problem.paths.parts[ground.component]
    outer, little_m2 = list(rings(space, 0.0, radius_m)), 1e-3 * ground.shape.area  # left to further pieces
    for angle in promising_angles(problem, ground.shape):
        swath = sensing(problem, angle)
        left = unseen_by(ground.shape, outer, swath.half_m)
        lanes = list(lanes_with_room(left, space, swath, radius_m))
        beside = unseen_by(left, lanes, swath.half_m)
        for apart_m in (2 * swath.half_m, math.sqrt(2) * swath.half_m):
            pieces, unseen = [*outer, *lanes], beside
            for depth_m in np.arange(apart_m, 2 * radius_m + apart_m, apart_m):
                if unseen.area <= little_m2:
                    break
                ring = rings(space, float(depth_m), radius_m)
                new = [part for piece in ring for part in parts_near(piece, unseen, swath.half_m, radius_m)]
                pieces, unseen = [*pieces, *new], unseen_by(unseen, new, swath.half_m)
            yield pieces


def unseen_by(ground: BaseGeometry, pieces: Sequence[Floats], half_m: float) -> BaseGeometry:
    """The ground that is farther from all pieces than the half of a swath."""
    if not pieces:
        return ground
    return shapely.difference(ground, shapely.union_all([LineString(piece).buffer(half_m) for piece in pieces]))


def seeing_all(context: Context, swept: Swept, points: SamplePoints, samples: Samples) -> Swept:
    """The routes with further pieces, until they see all samples that any piece they can be led along sees.

    Each time the place that sees most of what is unseen, or one of those that see the same, is led past.
    """
    problem, hopeless = context.problem, np.zeros(len(points), dtype=bool)
    for _ in range(60):  # lanes and rings leave less than that; where they leave more, other methods are as good
        wanted = np.zeros(len(points), dtype=bool)
        wanted[annealing_of(context, swept.tours, samples, length_weight=1.0, seed=context.seed).unseen_samples] = True
        wanted &= ~hopeless
        if not wanted.any() or context.should_stop():
            break
        places_m = near_places(problem, points.xy_m[wanted])
        start, items = what_places_see(places_m, problem.robot, problem.range_margin_m, samples)
        chosen, _ = choose_viewpoints(start, items, wanted, points.area_m2)
        if not len(chosen):
            break
        seen = items[start[chosen[0]] : start[chosen[0] + 1]]
        seen = seen[wanted[seen]]
        place = np.repeat(np.arange(len(places_m)), np.diff(start))
        able = np.unique(place[items == seen[0]])
        sees = np.bincount(place, weights=wanted[items].astype(np.float64), minlength=len(places_m))[able]
        able = able[np.argsort(-sees, kind="stable")][:24]  # a way is free from some of so many, or hardly from any
        longer = led_past_one(swept, places_m[able], int(points.period[seen[0]]))
        if longer is None:
            hopeless[seen] = True
        swept = longer or swept
    return swept


def led_past_one(swept: Swept, places_m: Floats, period: int) -> Swept | None:
    """The routes, one of them with a piece through the place (n, 2) to which that takes least; None where none can.

    period: the class of what is to be seen.
    """
    turned = np.arange(16) * (math.tau / 16)  # the headings in which each place is tried
    parts = np.repeat(swept.problem.paths.part_of(places_m), len(turned))
    poses_m, headings = np.repeat(places_m, len(turned), axis=0), np.tile(turned, len(places_m))
    best = (BLOCKED_M / 2, 0, 0, -1)
    for k, (route, ground) in enumerate(zip(swept.routes, swept.grounds, strict=True)):
        if ground.period_class > period:
            continue
        ends_m, begins_m, out, into = route.gaps
        there_m = lengths_m(ends_m, out, poses_m, headings, route.radius_m, route.space)
        back_m = lengths_m(poses_m, headings, begins_m, into, route.radius_m, route.space)
        more_m = there_m + back_m.T - route.joins_m[:, None]
        more_m[:, parts != ground.component] = np.inf
        least = int(np.argmin(more_m))
        best = min(best, (float(more_m.flat[least]), k, *divmod(least, len(poses_m))))
    _, k, gap, pose = best
    if pose < 0:
        return None
    length_m = 2e-3 * swept.routes[k].radius_m  # of the piece for one place: long enough to be timed
    half_m = length_m / 2 * np.array([math.cos(headings[pose]), math.sin(headings[pose])])
    return swept.with_piece(k, gap, np.array([poses_m[pose] - half_m, poses_m[pose] + half_m]))
