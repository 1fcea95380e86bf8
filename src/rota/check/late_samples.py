"""What sample points say of how late places are where a plan takes over from another one, and what all is seen from."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rota.check import lateness_kernels
from rota.check.arrays import Flags, Floats, Ints
from rota.check.charging import docked_rows, undocked_routes
from rota.check.counting import Names, counting_before, counting_robots, groups_of
from rota.check.demands import DemandedGround, demands_of, visits
from rota.check.late_report import ForEver, LateSample
from rota.check.pieces import point_pieces, quarter
from rota.check.presence import seeing_routes
from rota.check.revisits import SeamSights, Sights, late_points, loop_gap, piece_gaps, sights_along, sights_of
from rota.check.routes import HOLD, LOOP, Routes, routes_driven, routes_of, sensors_of
from rota.check.seeable import SeeableGround, seeable_ground
from rota.check.tiled_ground import Tiles, tiles_of
from rota.check.timing_kernels import time_along
from rota.check.tolerances import NO_LENGTH, PERIOD_TOLERANCE, slack_of
from rota.model.mission import DiscSensor, Mission
from rota.model.plan import Plan, Seam

MOST_LEGS = 2_000_000  # of loops driven until all is seen again; of more nothing is told
ENOUGH, MOST = 1_000, 2_000  # sample points of a demand


def sample_lateness(plan: Plan, most_points: int) -> LateSample:
    """How late some points of each demand are, within moments, to compare plans with."""
    assert plan.seam is not None
    for_ever, points = _sample_loops(plan, most_points)
    demands = demands_of(plan.mission)
    ever = all(one.unseen_m2 == 0 and one.ratio <= 1 + PERIOD_TOLERANCE for one in for_ever)
    within_s = long_enough_s(demands, ever)
    across = {names: sights_across(plan, plan.seam, names, within_s) for names, _ in groups_of(demands)}
    sampled = []
    for k, one in enumerate(demands):
        if (sights := across[one.sensors]) is None:
            return LateSample(for_ever=for_ever, worst_s=math.inf, late_m2_s=math.inf, last_s=math.inf)
        visited = one.demand == "visit"
        told = _sample_of_visits(sights, plan, one) if visited else _sample_at(sights, one, *points[k])
        sampled.append((told, one))
    known = [(one, demand) for one, demand in sampled if math.isfinite(one.gap_s)]
    return LateSample(
        for_ever=for_ever,
        worst_s=max((max(0.0, one.gap_s - demand.period_s) for one, demand in known), default=0.0),
        late_m2_s=sum(one.late_m2_s for one, _ in known),
        last_s=max((one.last_s for one, _ in known), default=0.0),
    )


def sample_loops(plan: Plan, most_points: int) -> tuple[ForEver, ...]:
    """What some points of each demand come to for ever, in the order of the demands."""
    return _sample_loops(plan, most_points)[0]


def _sample_loops(plan: Plan, most_points: int) -> tuple[tuple[ForEver, ...], dict[int, tuple[Floats, Floats]]]:
    """The same, and of each demand the points (n, 2) that are seen, with the ground (n,) that each stands for."""
    mission, demands = plan.mission, demands_of(plan.mission)
    reach_m = float(sensors_of(plan)[0].min(initial=math.inf))
    seen = {names: sights_of(counting_robots(plan, names), mission.area.bounds) for names, _ in groups_of(demands)}
    for_ever, points = list[ForEver](), dict[int, tuple[Floats, Floats]]()
    for k, demand in enumerate(demands):
        sights = seen[demand.sensors]
        routes = sights.routes
        if demand.demand == "visit":
            gap_s = loop_gap(routes, visits(routes.legs_m, demand.region, slack_of(mission)))[0]
            never = not math.isfinite(gap_s)
            unseen_m2, gap_s = (demand.region.area, 0.0) if never else (0.0, gap_s)
        else:
            ground = seeable_ground(mission, demand.sensors)
            own, areas_m2 = _some_points(tiles_of(mission, reach_m), ground, k, most_points)
            gaps_s = piece_gaps(sights, point_pieces(own), np.full(len(own), demand.period_s)).gaps_s
            ever = np.isfinite(gaps_s)
            points[k] = own[ever], areas_m2[ever]
            unseen_m2, gap_s = float(areas_m2[~ever].sum()), float(gaps_s[ever].max(initial=0.0))
        for_ever.append(ForEver(demand.name, unseen_m2, gap_s / demand.period_s))
    return tuple(for_ever), points


@functools.lru_cache(maxsize=32)
def _some_points(tiles: Tiles, ground: SeeableGround, k: int, most_points: int) -> tuple[Floats, Floats]:
    """Middles (n, 2) of tiles of a demand that can be seen, and the ground (n,) each stands for.

    The plans of a search are compared at the same ones.
    """
    pieces, own = tiles.pieces, np.flatnonzero(tiles.owners == k)
    if not len(own):
        return np.empty((0, 2)), np.empty(0)
    chosen = own[np.unique(np.linspace(0, len(own) - 1, most_points).astype(np.int64))]
    points = pieces.choose(chosen).centres_m()
    seeable = ground.sees(point_pieces(points))
    share_m2 = pieces.choose(own).areas_m2().sum() / max(1, np.count_nonzero(seeable))
    return points[seeable], np.full(np.count_nonzero(seeable), share_m2)


# ---------------------------------------------------------------- what is seen before and after


def long_enough_s(demands: Sequence[DemandedGround], ever: bool) -> float:
    """For how long after all loops have begun it may be asked how late places are; ever: whether loops meet all.

    Gaps that begin in such loops are not late, and those that begin before end within a period of them.
    """
    return 2 * max((demand.period_s for demand in demands), default=0.0) if ever else math.inf


def sights_across(plan: Plan, seam: Seam, names: Names = (), within_s: float = math.inf) -> Sights | None:
    """What is seen after the change until all is seen again, with what was seen before; None: by too many legs.

    names: of the sensors that count, if not all. within_s: for so long after all loops have begun, if that is enough.
    """
    plan, before = counting_robots(plan, names), sights_before(plan.mission, counting_before(seam, names))
    routes, bounds_m = seeing_routes(undocked_routes(routes_of(plan), plan), plan), plan.mission.area.bounds
    # whatever a robot sees in its loop it sees again within one
    to_s = routes.from_s + min(float(routes.durations_s.max(initial=0.0)), within_s)
    turns = _turns(routes, to_s)
    if turns.sum() > MOST_LEGS:
        return None
    after = sights_along(_unroll(routes, turns, to_s), sensors_of(plan), plan.mission, bounds_m)
    return replace(after, seam=SeamSights(before=before, moments_s=(seam.since_s, 0.0, routes.from_s, to_s)))


def sights_before(mission: Mission, seam: Seam) -> Sights:
    """What was seen before the change, past the obstacles of then."""
    routes, sensors = _routes_before(seam)
    then = mission if seam.obstacles is None else replace(mission, obstacles=seam.obstacles)
    return sights_along(routes, sensors, then, mission.area.bounds)


def _turns(routes: Routes, to_s: float) -> Ints:
    """How often each leg (m,) is driven until then."""
    durations = routes.durations_s[routes.robots]
    loops = routes.kinds == LOOP
    again = np.floor((to_s - routes.times_s[:, 0]) / np.where(loops, durations, 1.0))
    return np.where(loops, np.maximum(again, 0) + 1, 1).astype(np.int64)


def _unroll(routes: Routes, turns: Ints, to_s: float) -> Routes:
    """The routes as driven until then, each leg once, robot by robot and in the order of time."""
    leg = np.repeat(np.arange(len(turns)), turns)
    turn = np.arange(len(leg)) - np.repeat(np.cumsum(turns) - turns, turns)
    times_s = routes.times_s[leg] + (turn * routes.durations_s[routes.robots[leg]])[:, None]
    times_s[routes.kinds[leg] == HOLD, 1] = to_s
    order = np.lexsort((times_s[:, 0], routes.robots[leg]))
    return replace(
        routes.legs(leg[order]),
        times_s=np.ascontiguousarray(np.maximum(times_s[order], times_s[order][:, :1])),
        kinds=np.full(len(leg), LOOP, np.int64),
    )


def _routes_before(seam: Seam) -> tuple[Routes, tuple[Floats, Flags]]:
    """What was driven before, each leg once, and what robots saw with."""
    legs, times, bends, robots = [np.empty((0, 4))], [np.empty((0, 2))], [np.empty(0)], [np.empty(0, np.int64)]
    for k, driven in enumerate(seam.driven):
        xy, t = driven.positions_m, driven.times_s
        if len(t) == 1:
            xy, t = np.vstack([xy, xy]), np.append(t, t)
        away = ~docked_rows(t, driven.charges)
        legs.append(np.hstack([xy[:-1], xy[1:]])[away])
        times.append(np.stack([t[:-1], t[1:]], axis=1)[away])
        bends.append((driven.bends if len(driven.times_s) > 1 else np.zeros(1))[away])
        robots.append(np.full(np.count_nonzero(away), k, np.int64))
    sensors, count = [driven.sensor for driven in seam.driven], len(seam.driven)
    reaches = [one.radius_m if isinstance(one, DiscSensor) else one.side_m / 2 for one in sensors]
    routes = routes_driven(np.vstack(legs), np.vstack(times), np.concatenate(bends), np.concatenate(robots), count)
    squares = np.array([not isinstance(one, DiscSensor) for one in sensors], np.bool_)
    return routes, (np.array(reaches, np.float64), squares)


class Sampled:
    """The longest gap of some point of a demand that ends after the change, and what is late of all of them."""

    def __init__(
        self, gap_s: float, begin_s: float, place_m: tuple[float, float], late_m2_s: float, last_s: float
    ) -> None:
        self.gap_s, self.begin_s, self.place_m = gap_s, begin_s, place_m
        self.late_m2_s, self.last_s = late_m2_s, last_s


def sample_demand(sights: Sights, plan: Plan, k: int, demand: DemandedGround) -> Sampled:
    """What the middles of all tiles say of a demand, or the visits to it."""
    if demand.demand == "visit":
        return _sample_of_visits(sights, plan, demand)
    tiles = tiles_of(plan.mission, float(sights.team.reaches_m.min(initial=math.inf)))
    own = tiles.pieces.choose(tiles.owners == k)
    while len(own) < ENOUGH:
        finer, _ = quarter(own, np.full((len(own), 3), np.nan), 2 * sights.slack_m)
        if len(finer) <= len(own):
            break
        own = finer
    chosen = np.unique(np.linspace(0, len(own) - 1, MOST).astype(np.int64)) if len(own) else np.zeros(0, np.int64)
    points, areas_m2 = own.centres_m()[chosen], own.areas_m2()[chosen]
    areas_m2 *= own.areas_m2().sum() / max(areas_m2.sum(), NO_LENGTH)
    gaps_s, begins_s, late_s, last_s = late_points(sights, points, demand.period_s * (1 + PERIOD_TOLERANCE))
    unseen = np.flatnonzero(np.isinf(gaps_s))
    hidden = ~seeable_ground(plan.mission, demand.sensors).sees(point_pieces(points[unseen]))
    kept = np.setdiff1d(np.arange(len(points)), unseen[hidden])
    return _sum_up(gaps_s[kept], begins_s[kept], points[kept], (late_s * areas_m2)[kept], last_s[kept])


def _sample_at(sights: Sights, demand: DemandedGround, points_m: Floats, areas_m2: Floats) -> Sampled:
    """The same of points (n, 2) that stand for so much ground (n,)."""
    gaps_s, begins_s, late_s, last_s = late_points(sights, points_m, demand.period_s * (1 + PERIOD_TOLERANCE))
    return _sum_up(gaps_s, begins_s, points_m, late_s * areas_m2, last_s)


def _sum_up(gaps_s: Floats, begins_s: Floats, points: Floats, late_m2_s: Floats, last_s: Floats) -> Sampled:
    """What points (n, 2) say together."""
    if not len(points):
        return Sampled(0.0, 0.0, (0.0, 0.0), 0.0, 0.0)
    worst = int(np.argmax(gaps_s))
    return Sampled(
        float(gaps_s[worst]),
        float(begins_s[worst]),
        (float(points[worst, 0]), float(points[worst, 1])),
        float(late_m2_s.sum()),
        float(np.maximum(last_s, 0.0).max()),
    )


def _sample_of_visits(sights: Sights, plan: Plan, demand: DemandedGround) -> Sampled:
    """The same of visits to a zone, exactly."""
    assert sights.seam is not None
    spans = [
        (
            time_along(*routes.times_s[leg], routes.bends[leg], lo),
            time_along(*routes.times_s[leg], routes.bends[leg], hi),
        )
        for routes in (sights.routes, sights.seam.before.routes)
        for leg, lo, hi in visits(routes.legs_m, demand.region, slack_of(plan.mission))
    ]
    starts, ends = np.array(spans, np.float64).reshape(-1, 2).T
    gap_s, begin_s, late_s, last_s = lateness_kernels.late_between(
        np.ascontiguousarray(starts), np.ascontiguousarray(ends), demand.period_s * (1 + PERIOD_TOLERANCE),
        sights.seam.moments_s,
    )  # fmt: skip
    place = demand.region.representative_point()
    return Sampled(gap_s, begin_s, (place.x, place.y), late_s * demand.region.area, max(last_s, 0.0))
