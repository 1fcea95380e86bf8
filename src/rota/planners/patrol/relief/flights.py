"""Rotations as trajectories: out from the charger, some rounds, back, and on the charger until the next turn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import Charger
from rota.model.plan import Charge, Trajectory
from rota.planners.patrol.driving.timed_line import TimedLine, start_at
from rota.planners.patrol.relief.slots import Handovers, Slot
from rota.planners.patrol.relief.turns import Job, Rotation
from rota.planners.patrol.tolerances import SAME_TIME_S

Floats = NDArray[np.float64]


def trajectories_of(
    rotation: Rotation,
    slots: Sequence[Slot],
    handovers: Sequence[Handovers],
    paths: ShortestPaths,
    names: Sequence[str],
) -> list[Trajectory]:
    """The trajectories of a rotation's robots, which have these names; each repeats from time 0 on."""
    jobs = [_job_line(job, slots[job.shift.slot], handovers[job.shift.slot], paths) for job in rotation.jobs]
    charger = rotation.cycle.charger
    turn_s = rotation.cycle.turn_s
    return [
        robot_of_jobs(name, charger, [(begins_s + k * turn_s, line) for begins_s, line in jobs], rotation.lasts_s)
        for k, name in enumerate(names)
    ]


def _job_line(job: Job, slot: Slot, own: Handovers, paths: ShortestPaths) -> tuple[float, TimedLine]:
    """When a job's robot takes off, and its timed line from the charger and back to it."""
    shift, place_m = job.shift, own.places_m[job.handover]
    way_s, charger_m = float(own.ways_s[job.handover]), np.array(own.charger.at)
    served = _rounds_at(slot, shift.rounds, shift.round_s, float(own.phases_s[job.handover]))
    ends = int(np.argmin(np.hypot(*(own.places_m - served.places_m[-1]).T)))  # at the next handover
    out_m, back_m = paths.path(charger_m, place_m), paths.path(served.places_m[-1], charger_m)
    parts = [
        (_shares(out_m) * way_s, out_m),
        (way_s + served.times_s, served.places_m),
        (way_s + shift.serves_s + _shares(back_m) * float(own.ways_s[ends]), back_m),
    ]
    times_s, places_m = np.concatenate([part[0] for part in parts]), np.vstack([part[1] for part in parts])
    kept = np.concatenate([[True], np.diff(times_s) > SAME_TIME_S])
    return job.begins_s, TimedLine(times_s[kept], places_m[kept], np.zeros(int(kept.sum()) - 1))


def _rounds_at(slot: Slot, rounds: float, round_s: float, phase_s: float) -> TimedLine:
    """The rounds of a slot from a phase on, or the part of a round, from time 0."""
    if slot.line.stays:
        return TimedLine(np.array([0.0, rounds * round_s]), np.repeat(slot.line.places_m, 2, axis=0), np.zeros(1))
    stretch = round_s / slot.line.duration_s
    line = start_at(slot.line, phase_s)
    times_s = line.times_s * stretch
    times_s[-1] = round_s
    if rounds < 1:
        ends_s = rounds * round_s
        before = times_s < ends_s
        last_m = TimedLine(times_s, line.places_m, line.accelerations_m_s2).at(np.array([ends_s]))
        times_s, places_m = np.append(times_s[before], ends_s), np.vstack([line.places_m[before], last_m])
        return TimedLine(times_s, places_m, np.zeros(len(times_s) - 1))
    count = round(rounds)
    every_s = [k * round_s + times_s[1:] for k in range(count)]
    every_m = np.vstack([line.places_m[:1], *[line.places_m[1:]] * count])
    return TimedLine(np.concatenate([[0.0], *every_s]), every_m, np.zeros(len(every_m) - 1))


def _shares(line_m: Floats) -> Floats:
    """How far along a polyline (k, 2) its corners lie, in 0..1."""
    along_m = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line_m, axis=0).T))])
    return along_m / along_m[-1] if along_m[-1] > 0 else np.linspace(0.0, 1.0, len(line_m))


def robot_of_jobs(name: str, charger: Charger, jobs: Sequence[tuple[float, TimedLine]], lasts_s: float) -> Trajectory:
    """A robot that takes off for these jobs at their times, again and again after ``lasts_s``, and charges between.

    It begins with what it does at time 0, in the middle of a job as may be.
    """
    first_s = jobs[0][0]
    rounds = np.floor((first_s + SAME_TIME_S) / lasts_s)
    jobs = [(begins_s - rounds * lasts_s, line) for begins_s, line in jobs]
    first_s = jobs[0][0]
    if abs(first_s) <= SAME_TIME_S:
        jobs, first_s = [(begins_s - first_s, line) for begins_s, line in jobs], 0.0
    times_s = np.concatenate([*(begins_s + line.times_s for begins_s, line in jobs), [first_s + lasts_s]])
    places_m = np.vstack([*(line.places_m for _, line in jobs), np.array(charger.at)])
    ends = np.cumsum([len(line.times_s) for _, line in jobs])
    docked = np.zeros(len(times_s) - 1, np.bool_)
    docked[ends - 1] = True  # from a job's last row to the next one's first
    if times_s[0] > 0:
        times_s, places_m, docked = _from_zero(times_s, places_m, docked, lasts_s)
    charges = [
        Charge(charger=charger.name, from_s=float(times_s[a]), until_s=float(times_s[b])) for a, b in _runs(docked)
    ]
    return Trajectory(robot=name, times_s=times_s, positions_m=places_m, charges=tuple(charges))


def _from_zero(
    times_s: Floats, places_m: Floats, docked: NDArray[np.bool_], lasts_s: float
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """The rows of a round, which begins at some time from 0 on, from 0 to ``lasts_s``: what comes later comes first."""
    k = int(np.argmin(np.abs(times_s - lasts_s)))
    if abs(times_s[k] - lasts_s) <= SAME_TIME_S:  # at this row the round is cut
        times_s = np.concatenate([[0.0], times_s[k + 1 :] - lasts_s, times_s[1:k], [lasts_s]])
        return times_s, np.vstack([places_m[k:], places_m[1 : k + 1]]), np.concatenate([docked[k:], docked[:k]])
    k = int(np.searchsorted(times_s, lasts_s)) - 1  # within this leg
    share = (lasts_s - times_s[k]) / (times_s[k + 1] - times_s[k])
    seam_m = places_m[k] + share * (places_m[k + 1] - places_m[k])
    times_s = np.concatenate([[0.0], times_s[k + 1 :] - lasts_s, times_s[1 : k + 1], [lasts_s]])
    places_m = np.vstack([seam_m, places_m[k + 1 :], places_m[1 : k + 1], seam_m])
    return times_s, places_m, np.concatenate([docked[k:], docked[:k], docked[k : k + 1]])


def _runs(docked: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """From and to which index of the times each row of docked legs goes."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], docked.astype(np.int8), [0]])))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
