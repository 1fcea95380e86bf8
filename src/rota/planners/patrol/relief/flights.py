"""Rotations as trajectories: out from the charger, some rounds, back, and on the charger until the next turn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rota.model.arrays import Flags
from rota.model.mission import Charger
from rota.model.plan import Charge, Trajectory
from rota.model.trajectory import forward_accelerations
from rota.planners.patrol.driving.timed_line import TimedLine, start_at, stretch
from rota.planners.patrol.relief.slots import Handovers, Slot
from rota.planners.patrol.relief.turns import Job, Rotation
from rota.planners.patrol.relief.ways import Ways
from rota.planners.patrol.tolerances import SAME_TIME_S


def trajectories_of(
    rotation: Rotation,
    slots: Sequence[Slot],
    handovers: Sequence[Handovers],
    ways: Ways,
    names: Sequence[str],
) -> list[Trajectory]:
    """The trajectories of a rotation's robots, which have these names; each repeats from time 0 on."""
    jobs = [_job_line(job, slots[job.shift.slot], handovers[job.shift.slot], ways) for job in rotation.jobs]
    charger = rotation.cycle.charger
    turn_s = rotation.cycle.turn_s
    return [
        robot_of_jobs(name, charger, [(begins_s + k * turn_s, line) for begins_s, line in jobs], rotation.lasts_s)
        for k, name in enumerate(names)
    ]


def _job_line(job: Job, slot: Slot, own: Handovers, ways: Ways) -> tuple[float, TimedLine]:
    """When a job's robot takes off, and its timed line from the charger and back to it."""
    shift, charger_m, line = job.shift, np.array(own.charger.at), slot.line
    begins_phase_s, slower = float(own.phases_s[job.handover]), slot.slower(shift.round_s)
    ends = own.at_phase(begins_phase_s + shift.rounds * line.duration_s, line.duration_s)
    way_s = float(own.ways_s[job.handover])
    if own.passing is not None:
        into, back, _ = own.passing
    else:
        into = ways.into(charger_m, line, begins_phase_s, slower, way_s)
        back = ways.back(charger_m, line, float(own.phases_s[ends]), slower, float(own.ways_s[ends]))
    served = _rounds_at(slot, shift.rounds, shift.round_s, begins_phase_s)
    comes_s = into.duration_s
    times_s = np.concatenate([into.times_s, comes_s + served.times_s, comes_s + shift.serves_s + back.times_s])
    places_m = np.vstack([into.places_m, served.places_m, back.places_m])
    changes = np.concatenate(
        [into.accelerations_m_s2, [0.0], served.accelerations_m_s2, [0.0], back.accelerations_m_s2]
    )
    return job.begins_s + (way_s - comes_s), TimedLine(times_s, places_m, changes)


def _rounds_at(slot: Slot, rounds: float, round_s: float, phase_s: float) -> TimedLine:
    """The rounds of a slot from a phase on, or the part of a round, from time 0."""
    if slot.line.stays:
        return TimedLine(np.array([0.0, rounds * round_s]), np.repeat(slot.line.places_m, 2, axis=0), np.zeros(1))
    line = stretch(start_at(slot.line, phase_s), slot.slower(round_s))
    line.times_s[-1] = round_s
    if rounds < 1:
        ends_s = rounds * round_s
        before = line.times_s < ends_s
        places_m = np.vstack([line.places_m[before], line.at(np.array([ends_s]))])
        times_s = np.append(line.times_s[before], ends_s)
        return TimedLine(times_s, places_m, line.accelerations_m_s2[: len(times_s) - 1])
    count = round(rounds)
    every_s = [k * round_s + line.times_s[1:] for k in range(count)]
    every_m = np.vstack([line.places_m[:1], *[line.places_m[1:]] * count])
    return TimedLine(np.concatenate([[0.0], *every_s]), every_m, np.tile(line.accelerations_m_s2, count))


def robot_of_jobs(name: str, charger: Charger, jobs: Sequence[tuple[float, TimedLine]], lasts_s: float) -> Trajectory:
    """A robot that takes off for these jobs at their times, again and again after ``lasts_s``, and charges between.

    It begins with what it does at time 0, in the middle of a job as may be.
    """
    first_s = jobs[0][0]
    rounds = np.floor((first_s + SAME_TIME_S) / lasts_s)
    jobs = [(begins_s - rounds * lasts_s, _without_moments(line)) for begins_s, line in jobs]
    first_s = jobs[0][0]
    if abs(first_s) <= SAME_TIME_S:
        jobs, first_s = [(begins_s - first_s, line) for begins_s, line in jobs], 0.0
    times_s = np.concatenate([*(begins_s + line.times_s for begins_s, line in jobs), [first_s + lasts_s]])
    places_m = np.vstack([*(line.places_m for _, line in jobs), np.array(charger.at)])
    changes = np.concatenate([np.append(line.accelerations_m_s2, 0.0) for _, line in jobs])  # 0: on the charger
    ends = np.cumsum([len(line.times_s) for _, line in jobs])
    docked = np.zeros(len(times_s) - 1, np.bool_)
    docked[ends - 1] = True  # from a job's last row to the next one's first
    line = TimedLine(times_s, places_m, changes)
    if times_s[0] > 0:
        line, docked = _from_zero(line, docked, lasts_s)
    charges = [
        Charge(charger=charger.name, from_s=float(line.times_s[a]), until_s=float(line.times_s[b]))
        for a, b in _runs(docked)
    ]
    changes = forward_accelerations(*line)
    return Trajectory(
        robot=name, times_s=line.times_s, positions_m=line.places_m, charges=tuple(charges),
        accelerations_m_s2=changes if changes.any() else None,
    )  # fmt: skip


def _without_moments(line: TimedLine) -> TimedLine:
    """The line without steps that take no time but for rounding: turns by next to nothing, and seams of its parts."""
    kept = np.diff(line.times_s) > SAME_TIME_S
    rows = np.concatenate([[True], kept])
    return TimedLine(line.times_s[rows], line.places_m[rows], line.accelerations_m_s2[kept])


def _from_zero(line: TimedLine, docked: Flags, lasts_s: float) -> tuple[TimedLine, Flags]:
    """The rows of a round, which begins at some time from 0 on, from 0 to ``lasts_s``: what comes later comes first."""
    times_s, places_m, changes = line
    k = int(np.argmin(np.abs(times_s - lasts_s)))
    if abs(times_s[k] - lasts_s) <= SAME_TIME_S:  # at this row the round is cut
        times_s = np.concatenate([[0.0], times_s[k + 1 :] - lasts_s, times_s[1:k], [lasts_s]])
        places_m = np.vstack([places_m[k:], places_m[1 : k + 1]])
        changes, docked = (np.concatenate([own[k:], own[:k]]) for own in (changes, docked))
        return TimedLine(times_s, places_m, changes), docked
    k = int(np.searchsorted(times_s, lasts_s)) - 1  # within this leg
    seam_m = line.at(np.array([lasts_s]))
    times_s = np.concatenate([[0.0], times_s[k + 1 :] - lasts_s, times_s[1 : k + 1], [lasts_s]])
    places_m = np.vstack([seam_m, places_m[k + 1 :], places_m[1 : k + 1], seam_m])
    changes, docked = (np.concatenate([own[k:], own[:k], own[k : k + 1]]) for own in (changes, docked))
    return TimedLine(times_s, places_m, changes), docked


def _runs(docked: Flags) -> list[tuple[int, int]]:
    """From and to which index of the times each row of docked legs goes."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], docked.astype(np.int8), [0]])))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
