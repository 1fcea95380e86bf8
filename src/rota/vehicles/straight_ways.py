"""Plans without the points that stand on straight ways: autopilots slow down for each."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from rota.errors import RotaError
from rota.model.plan import Plan, Trajectory
from rota.routes.route import route_of
from rota.vehicles.track_kernels import kept_samples


def straighten_ways(plan: Plan, within_m: float) -> Plan:
    """The plan with fewer timed points: at any moment each robot is within so many metres of where it was to be.

    Rounds take as long, waits stay, and no leg is faster. So a plan that is met with a range reserve of ``within_m``
    (``range_margin_m``) stays met but for what corners of walls hide. Robots whose legs have accelerations keep all
    their points, which are where they speed up and brake. Raises RotaError for lengths that are not more than 0, for
    robots that bounce, whose points are where they bounce, and where all robots have such legs.
    """
    if not 0 < within_m < math.inf:
        raise RotaError(f"within_m: {within_m:g} is not allowed; must be greater than 0")
    if plan.mission.planning.bouncing is not None:
        raise RotaError(f"{plan.mission.name}: its robots bounce, and do so at every point of their ways")
    driven = [way for way in plan if way.accelerations_m_s2 is not None]
    if driven and len(driven) == len(plan.trajectories):
        points = sum(len(way.times_s) for way in driven)
        routes = [route_of(way, plan.mission.fleet.altitude_m) for way in driven]
        stops = sum(len(route.once) + len(route.every_round) for route in routes)
        raise RotaError(
            f"{plan.mission.name}: its robots are planned with their motion, and points on their ways are where they"
            f" speed up and brake; nothing is to be left out: of its {points} points rota export writes {stops} stops,"
            " the corners and waits alone. prefer: fewest_turns plans for fewer corners"
        )
    return replace(
        plan, trajectories=tuple(way if way in driven else _straight(way, within_m) for way in plan.trajectories)
    )


def _straight(trajectory: Trajectory, within_m: float) -> Trajectory:
    """The trajectory without points that lie within so many metres of the line between others."""
    times_s, positions_m = trajectory.times_s, np.array(trajectory.positions_m)
    kept = kept_samples(times_s.copy(), positions_m, trajectory.loop_index, within_m)
    headings_rad = trajectory.headings_rad
    return replace(
        trajectory,
        times_s=times_s[kept],
        positions_m=positions_m[kept],
        headings_rad=None if headings_rad is None else headings_rad[kept],
    )
