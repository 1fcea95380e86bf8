"""Legs with accelerations as shorter legs at constant speeds, for all that knows no others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rota.model.plan import Plan, Trajectory

WITHIN_M = 0.05


def at_constant_speeds(trajectory: Trajectory, within_m: float = WITHIN_M) -> Trajectory:
    """The same way at the same times, at constant speeds between more points; at any moment within so many metres.

    All points stay, new ones lie on their legs. Headings turn at a constant rate between points. A trajectory whose
    legs have constant speeds is returned as it is.

    In a part of the time T a leg with the acceleration a is at most |a| T^2 / 8 off.
    """
    accelerations = trajectory.accelerations_m_s2
    if accelerations is None:
        return trajectory
    times_s = trajectory.times_s
    durations_s = np.diff(times_s)
    parts = np.maximum(1, np.ceil(durations_s * np.sqrt(np.abs(accelerations) / (8 * within_m)))).astype(np.int64)
    first = np.append(0, np.cumsum(parts))  # the new number of each old point
    leg = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(first[-1]) - first[leg]) / parts[leg]
    finer_s = np.append(times_s[leg] + share * durations_s[leg], times_s[-1])
    finer_s[first] = times_s
    bends = trajectory.bends
    along = (share + bends[leg] * share * (share - 1))[:, None]
    begin_m = trajectory.positions_m[leg]
    finer_m = np.vstack([begin_m + along * (trajectory.positions_m[leg + 1] - begin_m), trajectory.positions_m[-1:]])
    finer_m[first] = trajectory.positions_m
    # parts of the shortest legs take no time that float64 can tell
    kept = np.append((finer_s[:-1] > times_s[leg]) & (finer_s[:-1] < times_s[leg + 1]), True)
    kept[1:] &= np.diff(finer_s) > 0
    kept[first] = True
    headings_rad = trajectory.headings_rad
    return replace(
        trajectory,
        times_s=finer_s[kept],
        positions_m=finer_m[kept],
        headings_rad=None if headings_rad is None else np.interp(finer_s[kept], times_s, headings_rad),
        accelerations_m_s2=None,
    )


def plan_at_constant_speeds(plan: Plan, within_m: float = WITHIN_M) -> Plan:
    """The plan with all its trajectories so."""
    if not plan.heeds_motion:
        return plan
    return replace(plan, trajectories=tuple(at_constant_speeds(trajectory, within_m) for trajectory in plan))
