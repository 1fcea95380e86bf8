"""A trajectory at a moment: what was driven until then, and what its robot would drive from then on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rota.model.mission import Sensor
from rota.model.plan import Driven, Trajectory

Floats = NDArray[np.float64]

APART_S = 1e-9  # rows nearer to each other than this, and than a share as small of the time, are one


def delay(trajectory: Trajectory, by_s: float) -> Trajectory:
    """The same driven so much later: its robot stands where it begins until then."""
    if by_s == 0:
        return trajectory
    changes = trajectory.accelerations_m_s2
    return replace(
        trajectory,
        times_s=np.append(0.0, trajectory.times_s + by_s),
        positions_m=np.vstack([trajectory.positions_m[:1], trajectory.positions_m]),
        headings_rad=None,
        accelerations_m_s2=None if changes is None else np.append(0.0, changes),
        loop_start_s=trajectory.loop_start_s + by_s,
        waypoints=None,
    )


def way_before(trajectory: Trajectory, sensor: Sensor, at_s: float, least_s: float) -> Driven:
    """What was driven in the ``least_s`` seconds before a moment, or since the beginning; times end with 0."""
    times_s, places_m, changes = _rows(trajectory, max(0.0, at_s - least_s), at_s)
    return Driven(
        robot=trajectory.robot,
        sensor=sensor,
        times_s=times_s - at_s,
        positions_m=places_m[:, :2],
        accelerations_m_s2=changes if changes.any() else None,
    )


def join_ways(earlier: Driven | None, way: Driven, least_s: float) -> Driven:
    """What was driven in the last ``least_s`` seconds and a leg before, where it began in what was driven earlier.

    The way alone where it does not begin there, or with another sensor.
    """
    if earlier is None or earlier.times_s[-1] != way.times_s[0] or earlier.sensor != way.sensor:
        return way
    times_s = np.append(earlier.times_s[:-1], way.times_s)
    changes = np.concatenate([_changes_of(earlier), _changes_of(way)])
    first = max(0, int(np.searchsorted(times_s, -least_s, side="right")) - 1)
    return replace(
        way,
        times_s=times_s[first:],
        positions_m=np.vstack([earlier.positions_m[:-1], way.positions_m])[first:],
        accelerations_m_s2=changes[first:] if changes.any() else None,
    )


def _changes_of(way: Driven) -> Floats:
    """The accelerations of a way along its legs."""
    changes = way.accelerations_m_s2
    return np.zeros(len(way.times_s) - 1) if changes is None else changes


def go_on(trajectory: Trajectory, at_s: float) -> Trajectory:
    """What is driven from a moment on, whose clock begins there; the loop begins there if it has begun before."""
    loop_s = trajectory.loop_duration_s
    if at_s >= trajectory.loop_start_s and loop_s == 0:
        return replace(
            trajectory, times_s=np.zeros(1), positions_m=trajectory.positions_m[-1:], loop_start_s=0.0,
            headings_rad=None, accelerations_m_s2=None, waypoints=None,
        )  # fmt: skip
    begins_s = max(trajectory.loop_start_s, at_s)
    times_s, places_m, changes = _rows(trajectory, at_s, begins_s + loop_s)
    times_s = times_s - at_s
    if loop_s > 0:  # rounding must not open the loop
        times_s = np.append(times_s[:-1], begins_s - at_s + loop_s)
        first = int(np.argmin(np.abs(times_s - (begins_s - at_s))))
        times_s[first] = begins_s - at_s
        places_m[-1] = places_m[first]
    return replace(
        trajectory, times_s=times_s, positions_m=places_m, loop_start_s=begins_s - at_s, headings_rad=None,
        accelerations_m_s2=changes if changes.any() else None, waypoints=None,
    )  # fmt: skip


def _rows(trajectory: Trajectory, from_s: float, to_s: float) -> tuple[Floats, Floats, Floats]:
    """Times (n,) from one moment to another, places (n, d) then, and accelerations (n - 1,) along the legs between."""
    times_s, loop_s, index = trajectory.times_s, trajectory.loop_duration_s, trajectory.loop_index
    changes = trajectory.accelerations_m_s2
    changes = np.zeros(len(times_s) - 1) if changes is None else changes
    turns = 0 if loop_s == 0 else max(0, int(np.ceil((to_s - times_s[-1]) / loop_s)))
    skipped = 0 if loop_s == 0 else max(0, int(np.floor((from_s - trajectory.loop_start_s) / loop_s)))
    rows = [times_s] if skipped == 0 else []
    legs = [changes] if skipped == 0 else []
    for turn in range(max(1, skipped), turns + 1):
        rows.append(times_s[index + (turn > skipped or skipped == 0) :] + turn * loop_s)
        legs.append(changes[index:])
    if not rows:
        rows, legs = [times_s[index:] + skipped * loop_s], [changes[index:]]
    rows_s, along = np.concatenate(rows), np.concatenate(legs)
    apart_s = APART_S * max(1.0, to_s)
    inside = (rows_s > from_s + apart_s) & (rows_s < to_s - apart_s)
    kept_s = np.concatenate([[from_s], rows_s[inside], [to_s] if to_s > from_s else []])
    leg = np.clip(np.searchsorted(rows_s, (kept_s[1:] + kept_s[:-1]) / 2, side="right") - 1, 0, max(0, len(along) - 1))
    after = (kept_s[1:] + kept_s[:-1]) / 2 > rows_s[-1]  # a robot that stays
    own = np.where(after, 0.0, along[leg]) if len(along) else np.zeros(len(kept_s) - 1)
    return kept_s, trajectory.at(kept_s), own
