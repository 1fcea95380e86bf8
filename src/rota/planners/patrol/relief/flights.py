"""Rotations as trajectories: out from the charger, some rounds, back, and on the charger until the next turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rota.errors import NoPlanFound
from rota.model.arrays import Flags, Floats
from rota.model.mission import Charger
from rota.model.plan import Charge, Trajectory
from rota.model.trajectory import forward_accelerations
from rota.planners.patrol.driving.round_starts import without_cuts
from rota.planners.patrol.driving.timed_line import TimedLine, start_at, stretch
from rota.planners.patrol.relief.slots import Handovers, Slot
from rota.planners.patrol.relief.turns import Job, Rotation
from rota.planners.patrol.relief.ways import Ways
from rota.planners.patrol.tolerances import SAME_ROUND, SAME_TIME_S


@dataclass(frozen=True, kw_only=True, eq=False)
class Flight:
    """A job as it is driven: its robot takes off at ``begins_s``, goes into the round, serves it, and goes back."""

    job: Job
    begins_s: float
    serves_s: float
    into: TimedLine
    served: TimedLine
    back: TimedLine

    @property
    def line(self) -> TimedLine:
        """From the charger and back to it."""
        comes_s, leaves_s = self.into.duration_s, self.into.duration_s + self.serves_s
        parts, moved_s = (self.into, self.served, self.back), (0.0, comes_s, leaves_s)
        times_s = [begins_s + part.times_s for begins_s, part in zip(moved_s, parts, strict=True)]
        changes = [part.accelerations_m_s2 for part in parts]
        return TimedLine(
            np.concatenate(times_s),
            np.vstack([part.places_m for part in parts]),
            np.concatenate([changes[0], [0.0], changes[1], [0.0], changes[2]]),
        )


def trajectories_of(rotation: Rotation, flights: Sequence[Flight], names: Sequence[str]) -> list[Trajectory]:
    """The trajectories of a rotation's robots, which have these names; each repeats from time 0 on."""
    jobs = [(flight.begins_s, flight.line) for flight in flights]
    chargers, turn_s = [rotation.cycle.charger], rotation.cycle.turn_s
    return [
        robot_of_jobs(name, chargers, [(begins_s + k * turn_s, line) for begins_s, line in jobs], rotation.lasts_s)
        for k, name in enumerate(names)
    ]


def on_shortest_ways(
    rotation: Rotation, slots: Sequence[Slot], handovers: Sequence[Handovers], ways: Ways
) -> list[Flight]:
    """The jobs of a rotation as they are driven on the shortest ways."""
    owns = [handovers[job.shift.slot] for job in rotation.jobs]
    return [flight(job, slots[job.shift.slot], own, own, ways) for job, own in zip(rotation.jobs, owns, strict=True)]


def flight(job: Job, slot: Slot, own: Handovers, after: Handovers, ways: Ways) -> Flight:
    """A job on the shortest ways from the charger of some handovers, and back to that of others."""
    shift, charger_m, line = job.shift, np.array(own.charger.at), slot.line
    begins_phase_s, slower = float(own.phases_s[job.handover]), slot.slower(shift.round_s)
    way_s, (ends, serves_s) = float(own.ways_s[job.handover]), leaves_at(job, slot, own)
    if own.passing is not None:
        into, back, _ = own.passing
    else:
        into = ways.into(charger_m, line, begins_phase_s, slower, way_s)
        back = ways.back(np.array(after.charger.at), line, float(own.phases_s[ends]), slower, float(after.ways_s[ends]))
    served = _rounds_at(slot, serves_s, shift.round_s, begins_phase_s)
    return Flight(
        job=job,
        begins_s=job.begins_s + (way_s - into.duration_s),
        serves_s=serves_s,
        into=into,
        served=served,
        back=back,
    )


def leaves_at(job: Job, slot: Slot, own: Handovers) -> tuple[int, float]:
    """At which handover of its slot a job's robot leaves, and how many seconds after it came; who gives way, sooner."""
    shift, lasts_s = job.shift, slot.line.duration_s
    ends_s = float(own.phases_s[job.handover]) + shift.rounds * lasts_s
    if shift.gives_way_s == 0:
        return own.at_phase(ends_s, lasts_s), shift.serves_s
    slower = slot.slower(shift.round_s)
    sooner_s = np.where(np.isfinite(own.ways_s), (ends_s - own.phases_s) % lasts_s, np.inf)
    sooner_s[sooner_s * slower < shift.gives_way_s * (1 - SAME_ROUND)] += lasts_s
    ends = int(np.argmin(sooner_s))
    if sooner_s[ends] >= shift.rounds * lasts_s:
        raise NoPlanFound("robots would leave a loop before they are on it")
    return ends, shift.rounds * shift.round_s - float(sooner_s[ends]) * slower


def _rounds_at(slot: Slot, serves_s: float, round_s: float, phase_s: float) -> TimedLine:
    """The rounds of a slot from a phase on for so many seconds, the last one maybe in part, from time 0."""
    if slot.line.stays:
        return TimedLine(np.array([0.0, serves_s]), np.repeat(slot.line.places_m, 2, axis=0), np.zeros(1))
    begun = start_at(slot.line, phase_s)
    line = stretch(begun, slot.slower(round_s))
    line.times_s[-1] = round_s
    whole = int(serves_s / round_s + SAME_ROUND)
    rest_s = serves_s - whole * round_s
    times_s, places_m, changes = [np.zeros(1)], [line.places_m[:1]], list[Floats]()
    for k in range(whole):
        times_s.append(k * round_s + line.times_s[1:])
        places_m.append(line.places_m[1:])
        changes.append(line.accelerations_m_s2)
    if rest_s > SAME_ROUND * round_s:
        before = int((line.times_s < rest_s).sum())
        times_s.append(whole * round_s + np.append(line.times_s[1:before], rest_s))
        places_m.append(np.vstack([line.places_m[1:before], line.at(np.array([rest_s]))]))
        changes.append(line.accelerations_m_s2[:before])
    served = TimedLine(np.concatenate(times_s), np.vstack(places_m), np.concatenate(changes))
    begins_s, cuts_s = np.arange(0.0, serves_s, round_s), list[Floats]()
    if slot.begins_amid_a_leg:
        cuts_s.append(begins_s + (slot.line.duration_s - phase_s) * slot.slower(round_s))
    if slot.has_mass and len(begun.times_s) > len(slot.line.times_s):  # robots change amid a leg
        cuts_s.append(begins_s)
    return without_cuts(served, np.concatenate(cuts_s)) if cuts_s else served


def robot_of_jobs(
    name: str, chargers: Sequence[Charger], jobs: Sequence[tuple[float, TimedLine]], lasts_s: float
) -> Trajectory:
    """A robot that takes off for these jobs at their times, again and again after ``lasts_s``, and charges between.

    chargers: those at which jobs end. It begins with what it does at time 0, in the middle of a job as may be.
    """
    first_s = jobs[0][0]
    rounds = np.floor((first_s + SAME_TIME_S) / lasts_s)
    jobs = [(begins_s - rounds * lasts_s, without_moments(line)) for begins_s, line in jobs]
    first_s = jobs[0][0]
    if abs(first_s) <= SAME_TIME_S:
        jobs, first_s = [(begins_s - first_s, line) for begins_s, line in jobs], 0.0
    times_s = np.concatenate([*(begins_s + line.times_s for begins_s, line in jobs), [first_s + lasts_s]])
    places_m = np.vstack(
        [*(line.places_m for _, line in jobs), np.array(_nearest(chargers, jobs[-1][1].places_m[-1]).at)]
    )
    changes = np.concatenate([np.append(line.accelerations_m_s2, 0.0) for _, line in jobs])  # 0: on the charger
    ends = np.cumsum([len(line.times_s) for _, line in jobs])
    docked = np.zeros(len(times_s) - 1, np.bool_)
    docked[ends - 1] = True  # from a job's last row to the next one's first
    line = TimedLine(times_s, places_m, changes)
    if times_s[0] > 0:
        line, docked = _from_zero(line, docked, lasts_s)
    charges = [
        Charge(
            charger=_nearest(chargers, line.places_m[a]).name,
            from_s=float(line.times_s[a]),
            until_s=float(line.times_s[b]),
        )
        for a, b in _runs(docked)
    ]
    changes = forward_accelerations(*line)
    return Trajectory(
        robot=name, times_s=line.times_s, positions_m=line.places_m, charges=tuple(charges),
        accelerations_m_s2=changes if changes.any() else None,
    )  # fmt: skip


def _nearest(chargers: Sequence[Charger], place_m: Floats) -> Charger:
    """The charger at a place (2,)."""
    return min(chargers, key=lambda charger: float(np.hypot(*(np.array(charger.at) - place_m))))


def without_moments(line: TimedLine) -> TimedLine:
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
