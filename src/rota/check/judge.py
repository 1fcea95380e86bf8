"""The judgement of a plan: every demand in a bracket of pieces and points, then motion, separation and the fleet."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import shapely

from rota.check.arrays import Floats, Ints
from rota.check.bouncing import bounce_violations
from rota.check.charging import charging_violations
from rota.check.clocks import clock_margin_s, clock_violations
from rota.check.counting import claim_violations, counting_robots, kind_violations
from rota.check.demands import DemandedGround, demands_of, visits
from rota.check.findings import Findings
from rota.check.holding import holding_of
from rota.check.lane_keeping import lane_violations
from rota.check.lateness import lateness_of
from rota.check.motion import motion_violations
from rota.check.moving import moving_violations
from rota.check.presence import presence_violations
from rota.check.report import DemandVerdict, Outcome, Report, Violation, violation
from rota.check.revisits import Sights, loop_gap, sights_of
from rota.check.seams import seam_violations
from rota.check.separation import separation_violations
from rota.check.standing import near_entrance_m, near_way_in_m, standing_area_of, standing_areas
from rota.check.standing_still import standing_violations
from rota.check.tiled_ground import FINEST_M, findings_by_group
from rota.check.timing_kernels import time_along
from rota.check.tolerances import MOST_EXCLUDED, PERIOD_TOLERANCE, TOUCH_M, slack_of
from rota.errors import MissionError
from rota.model.mission import Mission, StartBox, StartPoints
from rota.model.plan import Plan
from rota.model.violation_kinds import ViolationKind

MOST_UNMET_POINTS = 200_000


@dataclass
class Verdicts:
    """The verdicts on demands, and what is unmet: places (k, 2) and the number of each one's demand, (k,)."""

    demands: list[DemandVerdict] = field(default_factory=list)
    violations: list[Violation] = field(default_factory=list)
    firsts_s: list[float] = field(default_factory=list)
    unmet_m: list[Floats] = field(default_factory=list)
    unmet_demand: list[Ints] = field(default_factory=list)
    shown_m: list[Floats] = field(default_factory=list)
    shown_demand: list[Ints] = field(default_factory=list)

    def places(self) -> dict[str, Any]:
        """The fields of a report that say what is unmet, at most MOST_UNMET_POINTS of each kind."""
        unmet, unmet_demand = _cap(self.unmet_m, self.unmet_demand)
        shown, shown_demand = _cap(self.shown_m, self.shown_demand)
        return {
            "unmet_points_m": unmet,
            "unmet_demand": unmet_demand,
            "shown_unmet_m": shown,
            "shown_unmet_demand": shown_demand,
        }


def check_plan(plan: Plan, *, finest_m: float = FINEST_M, on_the_way: Callable[[], None] | None = None) -> Report:
    """The independent verdict on a plan: "met" only when it is shown for every demanded point and for ever.

    finest_m: size in metres, greater than 0, below which pieces are not cut any more; what is then still open is "not
    proven". The excluded part (what nobody can see from where a body can stand) is rounded outwards to about that size.
    A plan without trajectories sees nothing. on_the_way: called now and then; what it raises ends the check without a
    verdict.
    """
    if not 0 < finest_m < math.inf:
        raise MissionError(f"finest_m: {finest_m!r} is not allowed; must be a finite number greater than 0")
    mission = plan.mission
    demands = demands_of(mission)
    with ThreadPoolExecutor(max_workers=1) as pool:
        driven = pool.submit(violations_on_the_way, plan)
        sights_by = functools.cache(lambda names: sights_of(counting_robots(plan, names), mission.area.bounds))
        findings = findings_by_group(mission, demands, sights_by, finest_m, on_the_way)
    excluded_violation = too_much_excluded(mission, demands, findings)
    verdicts = Verdicts()
    for k, demand in enumerate(demands):
        if demand.demand == "visit":
            judge_visits(verdicts, k, demand, sights_by(demand.sensors), mission)
        else:
            judge_points(verdicts, k, demand, findings[k], bool(excluded_violation))
    violations = verdicts.violations + excluded_violation + driven.result()
    margin_s = clock_margin_s(plan)
    violations += clock_violations(plan, margin_s)
    bounced = bounce_violations(plan)
    violations += bounced.violations
    outcomes = {d.outcome for d in verdicts.demands}
    verdict: Outcome = "not proven" if "not proven" in outcomes else "met"
    if violations or "violated" in outcomes:
        verdict = "violated"
    bound, robots = plan.lower_bound_robots, len(plan.trajectories)
    if verdict == "met" and (false := claim_violations(plan)):  # the plan itself is the proof
        violations += false
        verdict = "violated"
    first = max(verdicts.firsts_s, default=0.0)
    report = Report(
        verdict=verdict,
        robots=robots,
        lower_bound_robots=bound,
        cells_entered=bounced.cells,
        not_judged=(*bounced.not_judged, *_unjudged_headings(plan), *_unjudged_past(plan)),
        demands=tuple(verdicts.demands),
        violations=tuple(violations),
        clock_margin_s=margin_s,
        first_coverage_s=first if math.isfinite(first) else None,
        holds_from_s=max((trajectory.loop_start_s for trajectory in plan), default=0.0),
        **verdicts.places(),
        run_end=plan.run_end,
        holding=holding_of(plan),
    )
    if plan.seam is None:
        return report
    return replace(report, lateness=lateness_of(plan, report, finest_m=finest_m, on_the_way=on_the_way))


def too_much_excluded(
    mission: Mission, demands: tuple[DemandedGround, ...], findings: list[Findings]
) -> list[Violation]:
    """One violation where more ground is seen by nobody than the mission lets a plan leave out; else none."""
    total = sum(demand.region.area for demand in demands if demand.demand == "every_point")
    excluded = sum(f.excluded_area_m2 for f in findings)
    limit = 0.0 if mission.unseeable == "refuse" else MOST_EXCLUDED * total
    if excluded <= limit:
        return []
    k = max(range(len(findings)), key=lambda k: findings[k].excluded_area_m2)
    who = ", ".join(demands[i].name for i in range(len(findings)) if findings[i].excluded_area_m2 > 0)
    return [violation("unseeable", who, findings[k].excluded_places()[0], None, excluded, limit, "m2")]


def judge_points(verdicts: Verdicts, k: int, demand: DemandedGround, findings: Findings, refused: bool) -> None:
    """Add the verdict on demand number k of every point; ``refused``: too much ground is seen by nobody."""
    outcome: Outcome = "not proven" if findings.undecided_cells else "met"
    if findings.worst_place_m is not None:
        outcome = "violated"
        verdicts.violations.append(_late(demand, findings.worst_place_m, findings.worst_s, findings.worst_begin_s))
    elif refused and findings.excluded_area_m2 > 0:
        outcome = "violated"
    verdicts.demands.append(
        DemandVerdict(
            name=demand.name,
            period_s=demand.period_s,
            demand=demand.demand,
            area_m2=float(demand.region.area),
            worst_gap_s=findings.upper_s,
            worst_gap_at_least_s=findings.lower_s,
            unseen_area_m2=findings.unseen_area_m2,
            excluded_area_m2=findings.excluded_area_m2,
            excluded_places=tuple(findings.excluded_places()),
            undecided_cells=findings.undecided_cells,
            outcome=outcome,
        )
    )
    verdicts.firsts_s.append(findings.first_s)
    points = findings.unmet_points_m()
    verdicts.unmet_m.append(points)
    verdicts.unmet_demand.append(np.full(len(points), k, np.int64))
    shown = findings.shown_unmet_m()
    verdicts.shown_m.append(shown)
    verdicts.shown_demand.append(np.full(len(shown), k, np.int64))


def _late(demand: DemandedGround, place_m: tuple[float, float], gap_s: float, begin_s: float) -> Violation:
    """That a gap is longer than a demand's period."""
    time_s = begin_s if math.isfinite(begin_s) and math.isfinite(gap_s) else None
    return violation("gap", demand.name, place_m, time_s, gap_s, demand.period_s, "s")


def judge_visits(verdicts: Verdicts, k: int, demand: DemandedGround, sights: Sights, mission: Mission) -> None:
    """Add the verdict on demand number k of visits to its zone."""
    routes = sights.routes
    inside = visits(routes.legs_m, demand.region, slack_of(mission))
    gap, begin = loop_gap(routes, inside, sights.window_s)
    met = gap <= demand.period_s * (1 + PERIOD_TOLERANCE)
    if not met:
        standing = shapely.union_all([area.shape for area in standing_areas(mission, demand.sensors)])
        reachable = shapely.intersection(demand.region, standing)
        place = shapely.point_on_surface(demand.region if reachable.is_empty else reachable)
        verdicts.violations.append(_late(demand, (place.x, place.y), gap, begin))
        verdicts.unmet_m.append(np.array([[place.x, place.y]]))
        verdicts.unmet_demand.append(np.array([k], np.int64))
    verdicts.demands.append(
        DemandVerdict(
            name=demand.name,
            period_s=demand.period_s,
            demand=demand.demand,
            area_m2=float(demand.region.area),
            worst_gap_s=gap,
            worst_gap_at_least_s=gap,
            unseen_area_m2=0.0 if math.isfinite(gap) else float(demand.region.area),
            excluded_area_m2=0.0,
            excluded_places=(),
            undecided_cells=0,
            outcome="met" if met else "violated",
        )
    )
    times = [time_along(*routes.times_s[m], routes.bends[m], lo) for m, lo, _ in inside]
    verdicts.firsts_s.append(min(times, default=math.inf))


def violations_on_the_way(plan: Plan) -> list[Violation]:
    """What is wrong with the routes themselves, whatever is seen from them."""
    violations = _fleet_violations(plan) + motion_violations(plan) + separation_violations(plan)
    violations += _late_violations(plan) + lane_violations(plan) + seam_violations(plan)
    violations += moving_violations(plan) + presence_violations(plan) + entrance_violations(plan)
    return violations + charging_violations(plan) + standing_violations(plan)


def _unjudged_headings(plan: Plan) -> tuple[str, ...]:
    """That nothing is said of headings, where a plan has some and its robots do not bounce."""
    given = any(trajectory.headings_rad is not None for trajectory in plan)
    return ("headings: they are judged of robots that bounce",) if given and not plan.mission.planning.bouncing else ()


def _unjudged_past(plan: Plan) -> tuple[str, ...]:
    """That what was driven before a plan took over is believed."""
    return () if plan.seam is None else ("what was driven before the change: it is taken as it is told",)


def _late_violations(plan: Plan) -> list[Violation]:
    """Robots that begin their loops, from when on periods hold, later than the mission allows."""
    most_s = plan.mission.holds_within_s
    late = [] if most_s is None else [t for t in plan if t.loop_start_s > most_s * (1 + PERIOD_TOLERANCE)]
    return [
        violation("holds too late", t.robot, t.positions_m[t.loop_index, :2], None, t.loop_start_s, most_s or 0.0, "s")
        for t in late
    ]


def _fleet_violations(plan: Plan) -> list[Violation]:
    """Robots of a fixed fleet that have no trajectory, or begin away from their start."""
    violations = _common_start_violations(plan) + kind_violations(plan)
    trajectories = {trajectory.robot: trajectory for trajectory in plan}
    for robot in plan.mission.fleet.robots or ():
        trajectory = trajectories.get(robot.name)
        if trajectory is None:
            violations.append(violation("no trajectory", robot.name, robot.start, 0.0, 0.0, 1.0, "trajectories"))
        elif robot.start is not None:
            away = math.dist(robot.start, trajectory.positions_m[0, :2])
            if away > TOUCH_M:
                violations.append(violation("start", robot.name, robot.start, 0.0, away, TOUCH_M, "m"))
    return violations


def _common_start_violations(plan: Plan) -> list[Violation]:
    """Robots without a start of their own that begin outside the fleet's box, or at none of its free points."""
    fleet, violations = plan.mission.fleet, []
    free = list(fleet.start.points_m) if isinstance(fleet.start, StartPoints) else []
    for trajectory in plan:
        if fleet.start is None or fleet.robot(trajectory.robot).start is not None:
            continue
        x, y = (float(value) for value in trajectory.positions_m[0, :2])
        if isinstance(fleet.start, StartBox):
            (x0, y0), (x1, y1) = fleet.start.low_m, fleet.start.high_m
            place = (min(max(x, x0), x1), min(max(y, y0), y1))
        elif free:
            place = min(free, key=lambda point: math.dist(point, (x, y)))
        else:
            violations.append(violation("no start left", trajectory.robot, (x, y), 0.0, 0.0, 1.0, "starts"))
            continue
        away = math.dist(place, (x, y))
        if away > TOUCH_M:
            violations.append(violation("start", trajectory.robot, place, 0.0, away, TOUCH_M, "m"))
        elif place in free:
            free.remove(place)
    return violations


def _cap(places_m: list[Floats], demands: list[Ints]) -> tuple[Floats, Ints]:
    """All places and their demands, or an even choice of them when there are too many."""
    points = np.vstack([np.empty((0, 2)), *places_m])
    demand = np.concatenate([np.empty(0, np.int64), *demands])
    if len(points) > MOST_UNMET_POINTS:
        chosen = np.linspace(0, len(points) - 1, MOST_UNMET_POINTS).astype(np.int64)
        points, demand = points[chosen], demand[chosen]
    return points, demand


def entrance_violations(plan: Plan) -> list[Violation]:
    """Robots that come to places where no way leads from an entrance: the first of each, when, and how far off it is.

    Where a robot turns tells all: between two such places its leg is judged by itself, and each is to be in ground that
    ways lead to. A gap just as wide as the body is no way, though a leg may pass it. Where a robot begins it must be as
    near to such ground as an entrance.
    """
    mission, violations = plan.mission, []
    if mission.fleet.entrances is None:
        return []
    for trajectory in plan:
        robot = mission.fleet.robot(trajectory.robot)
        inside = standing_area_of(mission, robot).shape
        shapely.prepare(inside)  # whose sides are then looked up in a tree
        places_m = trajectory.positions_m[:, :2]
        limits_m = np.full(len(places_m), near_way_in_m(robot.body_radius_m))
        limits_m[0] = near_entrance_m(robot.body_radius_m)
        far = ~shapely.dwithin(inside, shapely.points(places_m), limits_m)  # all, where bodies can come to nothing
        for i in np.flatnonzero(far)[:1]:
            x, y = (float(value) for value in places_m[i])
            at_s = float(trajectory.times_s[i])
            away_m = float("inf") if inside.is_empty else float(shapely.distance(inside, shapely.Point(x, y)))
            kind: ViolationKind = "no way there from the entrances"
            violations.append(violation(kind, robot.name, (x, y), at_s, away_m, float(limits_m[i]), "m"))
    return violations
