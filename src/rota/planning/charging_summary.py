"""What charging comes to in a plan, robot by robot: flights, time away from chargers, and the least that is left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rota.model.columns import columns
from rota.model.plan import Plan, Trajectory


@dataclass(frozen=True, kw_only=True)
class ChargingRow:
    """One robot over its round: flights, the longest one, the share of time away, and battery left at the least."""

    robot: str
    round_s: float
    flights: int
    longest_s: float
    away: float
    least_s: float


def charging_rows(plan: Plan) -> tuple[ChargingRow, ...]:
    """One row per trajectory, in the plan's order; ``least_s`` is inf for a robot without an endurance."""
    from rota.check.charging import battery_levels

    rows = []
    for one in plan:
        robot, flights_s = plan.mission.fleet.robot(one.robot), flights_of(one)
        levels = None if robot.battery.endurance_s is None else battery_levels(plan, one)
        rows.append(
            ChargingRow(
                robot=one.robot,
                round_s=one.loop_duration_s,
                flights=len(flights_s),
                longest_s=float(flights_s.max(initial=0.0)),
                away=float(flights_s.sum() / one.loop_duration_s) if one.loop_duration_s else 1.0,
                least_s=float("inf") if levels is None else float(levels.levels_s.min()),
            )
        )
    return tuple(rows)


def flights_of(trajectory: Trajectory) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """The seconds (k,) of each flight of a robot's round, from leaving a charger to being at one again."""
    stays = [c for c in trajectory.charges if c.from_s >= trajectory.loop_start_s]
    ends = np.array([c.from_s for c in stays] + [trajectory.times_s[-1]])
    begins = np.array([trajectory.loop_start_s] + [c.until_s for c in stays])
    lasts_s = ends - begins
    if len(lasts_s) > 1:  # what goes on across the seam is one flight
        lasts_s = np.append(lasts_s[1:-1], lasts_s[-1] + lasts_s[0])
    kept: np.ndarray[tuple[int], np.dtype[np.float64]] = lasts_s[lasts_s > 0]
    return kept


def charging_table(plan: Plan) -> str:
    """The rows as plain text."""
    lines = [("robot", "round s", "flights", "longest s", "away", "least left s")]
    for row in charging_rows(plan):
        least = f"{row.least_s:.0f}" if np.isfinite(row.least_s) else "all"
        lines.append(
            (row.robot, f"{row.round_s:.0f}", str(row.flights), f"{row.longest_s:.0f}", f"{row.away:.0%}", least)
        )
    return columns(lines)


def charging_sentence(plan: Plan) -> str:
    """How many robots are away from chargers at once on average, and how many reliefs there are in an hour."""
    rows = charging_rows(plan)
    away = sum(row.away for row in rows)
    each_hour = sum(3600 * row.flights / row.round_s for row in rows if row.round_s)
    told = f"On average {away:.2f} of them are away from chargers; {each_hour:.1f} flights begin in an hour."
    grounding = {(b.landing_s, b.climbing_s) for b in (plan.mission.fleet.robot(one.robot).battery for one in plan)}
    if any(map(sum, grounding)):
        landing_s, climbing_s = map(max, zip(*grounding, strict=True))
        told += f" Of each stay at a charger {landing_s:.0f} s are for landing and {climbing_s:.0f} s for climbing."
    return told
