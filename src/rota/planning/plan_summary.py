"""What a plan comes to, robot by robot, as rows and as plain text: loop length and time, zones served, slack."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from shapely import LineString, Point, Polygon, union_all
from shapely.geometry.base import BaseGeometry

from rota.model.arrays import Floats
from rota.model.columns import columns
from rota.model.mission import AREA, DiscSensor, Mission, Sensor, Zone
from rota.model.plan import Plan, Trajectory
from rota.model.polygons import polygons_of
from rota.routes.flights import on_charger
from rota.routes.passed_stops import passed_stops

if TYPE_CHECKING:
    from rota.check import Report

# a regular 256-gon with a circle's area has a radius so much larger
SAME_COST = 1e-9  # sums of costs differ by less where they are the same
MOMENTS = 120  # of a loop at which it is looked what is in range
AS_LARGE = math.sqrt(2 * math.pi / (256 * math.sin(2 * math.pi / 256)))


@dataclass(frozen=True, kw_only=True)
class RobotRow:
    """One robot of the table. ``slack``: the share of its tightest period that its loop leaves; None: shared zones."""

    robot: str
    loop_length_m: float
    loop_time_s: float
    zones: tuple[str, ...]
    slack: float | None


def robot_rows(plan: Plan) -> tuple[RobotRow, ...]:
    """One row per trajectory, in the plan's order."""
    demands = _demands(plan.mission)
    return tuple(_row(plan.mission, trajectory, demands) for trajectory in plan.trajectories)


def _row(mission: Mission, trajectory: Trajectory, demands: tuple[Zone, ...]) -> RobotRow:
    zones, slack = _zones_and_slack(mission, trajectory, demands)
    return RobotRow(
        robot=trajectory.robot,
        loop_length_m=trajectory.loop_length_m,
        loop_time_s=trajectory.loop_duration_s,
        zones=zones,
        slack=slack,
    )


def _zones_and_slack(
    mission: Mission, trajectory: Trajectory, demands: tuple[Zone, ...]
) -> tuple[tuple[str, ...], float | None]:
    """The zones served, and the slack; None when no zone is served without other robots."""
    rounds, longest_s = _rounds(trajectory)
    loop_s = trajectory.loop_duration_s
    sensor = mission.fleet.robot(trajectory.robot).sensor
    passed, alone, slacks = [], [], []
    for zone in demands:
        near = [_comes_near(line, zone, sensor) for line in rounds]
        if not any(near) or zone.period_s is None:
            continue
        passed.append(zone.name)
        again_s = longest_s if all(near) else loop_s
        if again_s <= zone.period_s:
            alone.append(zone.name)
            slacks.append((zone.period_s, (zone.period_s - again_s) / zone.period_s))
    return tuple(alone or passed), min(slacks)[1] if slacks else None


def _rounds(trajectory: Trajectory) -> tuple[list[LineString | Point], float]:
    """The loop cut wherever it comes back to the place to which it comes back most often, and its longest piece's time.

    One piece, and the whole loop's time, when it comes back nowhere. Corners that are cut count as if they were not:
    past one place lead many curves.
    """
    times_s = trajectory.times_s[trajectory.loop_index :]
    points_m = trajectory.positions_m[trajectory.loop_index :, :2]
    if trajectory.accelerations_m_s2 is not None and (stops := passed_stops(trajectory)[1]):
        times_s = np.array([stop.left_s for stop in stops])
        points_m = np.array([stop.place_m[:2] for stop in stops])
    if len(points_m) < 3:
        return [LineString(points_m) if len(points_m) > 1 else Point(points_m[0])], trajectory.loop_duration_s
    _, place, visits = np.unique(np.round(points_m[:-1], 6), axis=0, return_inverse=True, return_counts=True)
    back = np.flatnonzero(place.ravel() == np.argmax(visits))
    if len(back) == 1:
        return [LineString(points_m)], trajectory.loop_duration_s
    first, steps = back[0], len(points_m) - 1
    # from that place on, once round
    points_m = np.vstack([points_m[first:-1], points_m[: first + 1]])
    ends = [*(back - first), steps]
    starts_s = np.append(times_s[back], times_s[back[0]] + trajectory.loop_duration_s)
    pieces = [LineString(points_m[i : j + 1]) for i, j in itertools.pairwise(ends)]
    return pieces, float(np.diff(starts_s).max())


def _comes_near(loop: LineString | Point, zone: Zone, sensor: Sensor) -> bool:
    if zone.demand == "visit":
        return bool(loop.intersects(zone.shape))
    return bool(loop.distance(zone.shape) < sensor.reach_m)


def _demands(mission: Mission) -> tuple[Zone, ...]:
    """The zones with a period, and the area outside all zones as one more."""
    zones = tuple(zone for zone in mission.zones if zone.period_s is not None)
    if mission.period_s is None:
        return zones
    rest = polygons_of(mission.area.difference(union_all([zone.shape for zone in mission.zones])))
    if rest.is_empty:
        return zones
    return (*zones, Zone(name=AREA, shape=rest, period_s=mission.period_s))


def round_off(value: float) -> str:
    """A loop's metres or seconds as people are told them: one decimal; below 1 two digits that count."""
    return f"{value:.1f}" if value >= 1 or value == 0 else f"{value:.2g}"


def robots_table(plan: Plan) -> str:
    """The rows as plain text: names and zones to the left of their columns, numbers to the right."""
    lines = [("robot", "loop m", "loop s", "slack", "serves")]
    for row in robot_rows(plan):
        slack = "shared" if row.slack is None else f"{row.slack:.0%}"
        served = ", ".join(row.zones) or "nothing"
        lines.append((row.robot, round_off(row.loop_length_m), round_off(row.loop_time_s), slack, served))
    return columns(lines, (0, 4))


def robots_sentence(plan: Plan) -> str:
    """Robots in the plan against the proved lower bound, as a sentence; of kinds their cost against that."""
    n, bound = len(plan.trajectories), plan.lower_bound_robots
    count = f"{n} robot" + ("s" if n != 1 else "")
    if plan.mission.fleet.kinds:
        return _cost_sentence(plan, count)
    if bound is None:
        return f"{count}; no lower bound is known."
    if n < bound:
        return f"{count}; meeting the demand takes at least {bound}, proved."
    if n == bound:
        return f"{count}: no plan needs fewer, proved."
    if bound == 1:
        return f"{count}; that one robot cannot do it is not proved."
    return f"{count}; no plan with fewer than {bound} exists, proved."


def cost_in_words(plan: Plan) -> str:
    """What the robots of a fleet of kinds cost, and the proved bound on that."""
    cost, bound = sum(plan.mission.fleet.kind_of(way.robot).cost for way in plan), plan.lower_bound_cost
    return f"cost {cost:.6g}" + ("" if bound is None else f", at least {bound:.6g} is proved")


def _cost_sentence(plan: Plan, robots: str) -> str:
    """Robots of each kind and what they cost, against the proved bound on the cost."""
    used = Counter(plan.mission.fleet.kind_of(way.robot) for way in plan)
    words = [f"{used[kind]} {kind.name}" for kind in plan.mission.fleet.kinds if used[kind]]
    cost, bound = sum(n * kind.cost for kind, n in used.items()), plan.lower_bound_cost
    told = f"{robots}, {' and '.join(words)}, at a cost of {cost:.6g}"
    if bound is None:
        return f"{told}; no lower bound is known."
    if bound >= cost * (1 - SAME_COST):
        return f"{told}: no fleet of these kinds costs less, proved."
    return f"{told}; no fleet of these kinds for less than {bound:.6g} exists, proved."


def range_from(sensor: Sensor, place_m: Floats) -> Polygon:
    """What a sensor at a place (2,) or (3,) metres has in range, obstacles aside; a disc as a 256-gon of its area.

    A disc that grows with height has nothing in range from a place without one.
    """
    place = Point(place_m[:2])
    if isinstance(sensor, DiscSensor):
        radius_m = sensor.radius_at_m(float(place_m[2]) if len(place_m) == 3 else 0.0)
        return place.buffer(radius_m * AS_LARGE, quad_segs=64)
    return place.buffer(sensor.side_m / 2, cap_style="square")


def range_at_the_end(plan: Plan) -> tuple[BaseGeometry, BaseGeometry, float]:
    """What the robots have in range at their last places; see ``range_at``."""
    return range_at(plan, max((float(trajectory.times_s[-1]) for trajectory in plan), default=0.0))


def range_at(plan: Plan, time_s: float) -> tuple[BaseGeometry, BaseGeometry, float]:
    """What the robots have in range at a time, the ground without what cuts sight, both as shapes.

    The third is the area in square metres that all their footprints have together. Robots that charge then, or ever
    leave, have none.
    """
    mission = plan.mission
    free = mission.area.difference(union_all([o.shape for o in mission.obstacles if o.blocks_sight]))
    footprints = [
        range_from(mission.fleet.robot(one.robot).sensor, one.at(time_s))
        for one in plan
        if mission.fleet.robot(one.robot).leaves_s is None and not on_charger(one, np.array([time_s]))[0]
    ]
    return union_all(footprints).intersection(free), free, sum(footprint.area for footprint in footprints)


def least_range_s(plan: Plan) -> float:
    """The time at which robots have least in range, of ``MOMENTS`` of the longest loop; the end where all stay."""
    longest = max(plan, key=lambda one: one.loop_duration_s)
    if not longest.loop_duration_s:
        return max(float(one.times_s[-1]) for one in plan)
    times_s = longest.loop_start_s + longest.loop_duration_s * (np.arange(MOMENTS) + 0.5) / MOMENTS
    return float(min(times_s.tolist(), key=lambda time_s: range_at(plan, time_s)[0].area))


def approach_sentence(plan: Plan) -> str | None:
    """When the last robot that has a way to its loop begins it; None when all begin on their loops."""
    loops_s = max((trajectory.loop_start_s for trajectory in plan), default=0.0)
    return f"All robots are on their loops {round_off(loops_s)} s after they set out." if loops_s > 0 else None


def bound_sentence(plan: Plan) -> str | None:
    """Why there is no plan with fewer robots than the proved bound; None when that is not told."""
    if plan.lower_bound_robots is None or plan.lower_bound_reason is None:
        return None
    if plan.lower_bound_cost is not None:
        return f"A cost of {plan.lower_bound_cost:.6g} at least: {plan.lower_bound_reason}."
    count = f"{plan.lower_bound_robots} robot" + ("s" if plan.lower_bound_robots != 1 else "")
    return f"{count} at least: {plan.lower_bound_reason}."


def ratio_sentence(plan: Plan, report: Report) -> str | None:
    """How a fixed fleet's worst gap compares with its period, as a sentence; None for fleets of as few as possible.

    Of a plan that meets its demand no gap is longer; of another some gap is at least as long.
    """
    if plan.mission.fleet.robots is None or not report.demands:
        return None
    if report.verdict == "met":
        return f"Worst gap: {report.worst_ratio:.3f} of its period."
    if math.isinf(report.worst_ratio_at_least):
        return "Worst gap: some of what is asked is never seen."
    return f"Worst gap: at least {report.worst_ratio_at_least:.3f} times its period."
