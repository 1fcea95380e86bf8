"""How late places are where a plan takes over from another one: what was driven before counts, by the same intervals.

A place is late at a moment when it was not seen within its period before it. All is asked of gaps between two sights
that end after a moment. Sample points bound them from below. From above the ground is judged in pieces, as that of any
plan, for limits just above what the samples say; where a piece shows more, limits are raised and it is judged again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rota.check import lateness_kernels
from rota.check.demands import DemandedGround, demands_of, visits
from rota.check.findings import Findings
from rota.check.late_report import LateDemand, Lateness
from rota.check.pieces import quarter
from rota.check.presence import seeing_routes
from rota.check.report import Report, Violation, violation
from rota.check.revisits import SeamSights, Sights, late_points, sights_along
from rota.check.routes import HOLD, LOOP, Routes, routes_of, sensors_of
from rota.check.seeable import seeable_ground
from rota.check.tiled_ground import tile_and_refine, tiles_of
from rota.check.timing_kernels import time_along
from rota.check.tolerances import PERIOD_TOLERANCE, TOUCH_M, slack_of
from rota.model.mission import DiscSensor
from rota.model.plan import Plan, Seam

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_LEGS = 2_000_000  # of loops driven until all is seen again; of more nothing is told
ROUNDS = 8  # in which limits are raised
FIRST_S = 0.02  # above what samples say, doubled in each round
ENOUGH = 3_000  # sample points of a demand
MOST_OPEN = 2  # rounds in which no place shows more and yet some piece is in doubt


def seam_violations(plan: Plan) -> list[Violation]:
    """Robots that drove before the plan took over and are neither lost nor in it, or begin elsewhere than they were."""
    if plan.seam is None:
        return []
    violations, here = [], {trajectory.robot: trajectory for trajectory in plan}
    for driven in plan.seam.driven:
        if driven.robot in plan.seam.lost:
            continue
        was = driven.positions_m[-1]
        if driven.robot not in here:
            violations.append(violation("no trajectory", driven.robot, was, 0.0, 0.0, 1.0, "trajectories"))
            continue
        away_m = math.dist(was, here[driven.robot].positions_m[0, :2])
        if away_m > TOUCH_M:
            violations.append(violation("start", driven.robot, was, 0.0, away_m, TOUCH_M, "m"))
    return violations


def lateness_of(plan: Plan, report: Report, *, finest_m: float, on_the_way: Callable[[], None] | None) -> Lateness:
    """How late places are from the moment on at which the plan takes over; ``report``: on its loops.

    What was not seen in the time that is told of before counts as seen when that begins. Only for a plan with a seam.
    """
    assert plan.seam is not None
    sights, demands = _sights_across(plan, plan.seam, report), demands_of(plan.mission)
    if sights is None:
        worst = [
            LateDemand(name=d.name, worst_s=math.inf, worst_at_least_s=0.0, place_m=None, time_s=None) for d in demands
        ]
        return Lateness(
            at_s=plan.seam.at_s, lost=plan.seam.lost, demands=tuple(worst), late_m2_s=math.inf, holds_again_s=None
        )
    sampled = [_sample(sights, plan, k, demand) for k, demand in enumerate(demands)]
    bracket = _Bracket(plan, sights, demands, finest_m, on_the_way)
    ever = all(demand.outcome == "met" for demand in report.demands)
    return Lateness(
        at_s=plan.seam.at_s,
        lost=plan.seam.lost,
        demands=tuple(bracket.worst(sampled)),
        late_m2_s=sum(one.late_m2_s for one in sampled) if ever else math.inf,
        holds_again_s=bracket.holds_again_s(max((one.last_s for one in sampled), default=0.0)) if ever else None,
    )


# ---------------------------------------------------------------- what is seen before and after


def _sights_across(plan: Plan, seam: Seam, report: Report) -> Sights | None:
    """What is seen after the change until all is seen again, with what was seen before; None: by too many legs."""
    routes, bounds_m = seeing_routes(routes_of(plan), plan), plan.mission.area.bounds
    gaps_s = [demand.worst_gap_s for demand in report.demands if math.isfinite(demand.worst_gap_s)]
    periods_s = [demand.period_s for demand in report.demands]
    to_s = routes.from_s + max([*gaps_s, *periods_s], default=0.0)
    turns = _turns(routes, to_s)
    if turns.sum() > MOST_LEGS:
        return None
    old_routes, old_sensors = _routes_before(seam)
    then = plan.mission if seam.obstacles is None else replace(plan.mission, obstacles=seam.obstacles)
    before = sights_along(old_routes, old_sensors, then, bounds_m)
    after = sights_along(_unroll(routes, turns, to_s), sensors_of(plan), plan.mission, bounds_m)
    return replace(after, seam=SeamSights(before=before, moments_s=(seam.since_s, 0.0, routes.from_s, to_s)))


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
    leg = leg[order]
    return replace(
        routes,
        legs_m=np.ascontiguousarray(routes.legs_m[leg]),
        heights_m=routes.heights_m[leg],
        times_s=np.ascontiguousarray(np.maximum(times_s[order], times_s[order][:, :1])),
        bends=np.ascontiguousarray(routes.bends[leg]),
        robots=routes.robots[leg],
        kinds=np.full(len(leg), LOOP, np.int64),
    )


def _routes_before(seam: Seam) -> tuple[Routes, tuple[Floats, NDArray[np.bool_]]]:
    """What was driven before, each leg once, and what robots saw with."""
    legs, times, bends, robots = [np.empty((0, 4))], [np.empty((0, 2))], [np.empty(0)], [np.empty(0, np.int64)]
    for k, driven in enumerate(seam.driven):
        xy, t = driven.positions_m, driven.times_s
        if len(t) == 1:
            xy, t = np.vstack([xy, xy]), np.append(t, t)
        legs.append(np.hstack([xy[:-1], xy[1:]]))
        times.append(np.stack([t[:-1], t[1:]], axis=1))
        bends.append(driven.bends if len(driven.times_s) > 1 else np.zeros(1))
        robots.append(np.full(len(t) - 1, k, np.int64))
    sensors, count = [driven.sensor for driven in seam.driven], len(seam.driven)
    reaches = [one.radius_m if isinstance(one, DiscSensor) else one.side_m / 2 for one in sensors]
    legs_m = np.ascontiguousarray(np.vstack(legs))
    routes = Routes(
        legs_m=legs_m,
        heights_m=np.full((len(legs_m), 2), np.nan),
        times_s=np.ascontiguousarray(np.vstack(times)),
        bends=np.concatenate(bends),
        robots=np.concatenate(robots),
        kinds=np.full(len(legs_m), LOOP, np.int64),
        durations_s=np.zeros(count),
        classes=np.arange(count, dtype=np.int64),
        parts=np.ones(count, np.int64),
        units_s=np.ones(count),
        from_s=0.0,
    )
    squares = np.array([not isinstance(one, DiscSensor) for one in sensors], np.bool_)
    return routes, (np.array(reaches, np.float64), squares)


# ---------------------------------------------------------------- how late that is


class _Sampled:
    """The longest gap of some point of a demand that ends after the change, and what is late of all of them."""

    def __init__(
        self, gap_s: float, begin_s: float, place_m: tuple[float, float], late_m2_s: float, last_s: float
    ) -> None:
        self.gap_s, self.begin_s, self.place_m = gap_s, begin_s, place_m
        self.late_m2_s, self.last_s = late_m2_s, last_s


def _sample(sights: Sights, plan: Plan, k: int, demand: DemandedGround) -> _Sampled:
    """What the middles of all tiles say of a demand, or the visits to it."""
    if demand.demand == "visit":
        return _sample_of_visits(sights, plan, demand)
    pieces, owners = tiles_of(plan.mission, sights)
    own = pieces.choose(owners == k)
    while len(own) < ENOUGH:
        finer, _ = quarter(own, np.full((len(own), 3), np.nan), 2 * sights.slack_m)
        if len(finer) <= len(own):
            break
        own = finer
    points, areas_m2 = own.centres_m(), own.areas_m2()
    gaps_s, begins_s, late_s, last_s = late_points(sights, points, demand.period_s * (1 + PERIOD_TOLERANCE))
    unseen = np.flatnonzero(np.isinf(gaps_s))
    hidden = ~seeable_ground(plan.mission).sees_within(points[unseen], np.zeros(len(unseen)))
    kept = np.setdiff1d(np.arange(len(points)), unseen[hidden])
    if not len(kept):
        return _Sampled(0.0, 0.0, (0.0, 0.0), 0.0, 0.0)
    worst = kept[np.argmax(gaps_s[kept])]
    return _Sampled(
        float(gaps_s[worst]),
        float(begins_s[worst]),
        (float(points[worst, 0]), float(points[worst, 1])),
        float((late_s * areas_m2)[kept].sum()),
        float(np.maximum(last_s[kept], 0.0).max()),
    )


def _sample_of_visits(sights: Sights, plan: Plan, demand: DemandedGround) -> _Sampled:
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
    return _Sampled(gap_s, begin_s, (place.x, place.y), late_s * demand.region.area, max(last_s, 0.0))


class _Bracket:
    """The same from above: the ground is judged in pieces for limits that are raised until they are shown."""

    def __init__(
        self, plan: Plan, sights: Sights, demands: Sequence[DemandedGround], finest_m: float,
        on_the_way: Callable[[], None] | None,
    ) -> None:  # fmt: skip
        self.mission, self.sights, self.demands = plan.mission, sights, demands
        self.finest_m, self.on_the_way = finest_m, on_the_way

    def _judge(self, limits_s: Sequence[float], after_s: float) -> list[Findings]:
        """Gaps that end after the moment, against these limits."""
        seam = self.sights.seam
        assert seam is not None
        from_s, _, loops_s, to_s = seam.moments_s
        sights = replace(self.sights, seam=replace(seam, moments_s=(from_s, after_s, loops_s, to_s)))
        asked = tuple(replace(one, period_s=limit) for one, limit in zip(self.demands, limits_s, strict=True))
        return tile_and_refine(self.mission, asked, sights, self.finest_m, self.on_the_way)

    def worst(self, sampled: list[_Sampled]) -> list[LateDemand]:
        """How late each demand is."""
        found = [(one.gap_s, one.begin_s, one.place_m) for one in sampled]
        points = [demand.demand == "every_point" for demand in self.demands]
        uppers_s = [one.gap_s for one in sampled]
        more_s, open_ones = FIRST_S, [k for k, own in enumerate(points) if own and math.isfinite(found[k][0])]
        doubts = [0] * len(points)
        for _ in range(ROUNDS):
            if not open_ones:
                break
            limits = [max(d.period_s, gap + more_s) for d, (gap, _, _) in zip(self.demands, found, strict=True)]
            findings = self._judge([limit if k in open_ones else math.inf for k, limit in enumerate(limits)], 0.0)
            for k in list(open_ones):
                one = findings[k]
                uppers_s[k] = max(one.upper_s, found[k][0])
                if one.worst_place_m is not None:
                    found[k] = (one.worst_s, one.worst_begin_s, one.worst_place_m)
                    if math.isinf(one.worst_s):
                        open_ones.remove(k)
                elif not one.undecided_cells or uppers_s[k] <= limits[k] or doubts[k] == MOST_OPEN:
                    open_ones.remove(k)
                else:
                    doubts[k] += 1
            more_s *= 2
        return [
            _late(demand, upper_s, *what) for demand, upper_s, what in zip(self.demands, uppers_s, found, strict=True)
        ]

    def holds_again_s(self, last_s: float) -> float | None:
        """From when on no place is late, as far as that is shown; last_s: some point is late until then."""
        if math.isinf(last_s):
            return None
        if not any(demand.demand == "every_point" for demand in self.demands):
            return last_s
        more_s, again_s = 0.0, last_s
        for _ in range(ROUNDS):
            findings = self._judge([demand.period_s for demand in self.demands], again_s + more_s)
            later = [one for one in findings if one.worst_place_m is not None]
            if not later:
                return None if any(one.undecided_cells for one in findings) else again_s + more_s
            ends_s = [one.worst_begin_s + one.worst_s for one in later]
            again_s = max([again_s, *(end_s for end_s in ends_s if math.isfinite(end_s))])
            more_s = max(FIRST_S, 2 * more_s)
        return None


def _late(
    demand: DemandedGround, upper_s: float, gap_s: float, begin_s: float, place_m: tuple[float, float]
) -> LateDemand:
    """How late a demand is whose gaps lie between these."""
    late = gap_s > demand.period_s * (1 + PERIOD_TOLERANCE)
    over_s = upper_s - demand.period_s if upper_s > demand.period_s * (1 + PERIOD_TOLERANCE) else 0.0
    return LateDemand(
        name=demand.name,
        worst_s=max(0.0, over_s),
        worst_at_least_s=gap_s - demand.period_s if late else 0.0,
        place_m=place_m if late else None,
        time_s=begin_s if late else None,
    )
