"""Robots that take over on lanes: each drives its lane to the end, and from there to a round of those that remain."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from scipy.sparse.csgraph import dijkstra

from rota.errors import NoPlanFound, PlanError
from rota.model.arrays import Floats, Ints
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.driving.timed_line import TimedLine, start_at, steady
from rota.planners.patrol.ground.problem import common_robot
from rota.planners.patrol.handover.rounds import PHASES, loop_of
from rota.planners.patrol.route_graph.network import Network, calls_of, network_of
from rota.planners.patrol.route_graph.plan_on_graph import GraphSearch
from rota.planners.patrol.tolerances import HAIR_M, SHORTEST_S, SLOWER
from rota.planners.patrol.traffic.starts.assignment import earliest_assignment
from rota.planning.planner import Handover


@dataclass(frozen=True, kw_only=True, eq=False)
class Coming:
    """A robot that drives on to the next end of a lane: its name, its line to there, the end, and all ways from it."""

    name: str
    line: TimedLine
    end: int
    from_there_s: Floats
    before: Ints


def takeovers_on_lanes(asked: Handover) -> Iterator[Plan]:
    """Plans in which the robots that remain share all places anew, at some phases of the clock of all rounds."""
    network = network_of(asked.mission, common_robot(asked.mission.fleet).ground_speed_m_s * SLOWER)
    coming = [one for name in asked.places if (one := _coming(asked, name, network)) is not None]
    if len(coming) < len(asked.places):
        return
    with suppress(NoPlanFound):
        rounds = _rounds_of_team(asked, network)
        longest_s = max(round_.duration_s for round_ in rounds)
        for shift_s in np.linspace(0, longest_s, PHASES, endpoint=False):
            joined = _join_all(coming, rounds, float(shift_s), network)
            if joined is not None:
                lines = tuple(joined[name] for name in asked.places)
                yield Plan(mission=asked.mission, seed=asked.seed, seam=asked.seam, trajectories=lines)


def _rounds_of_team(asked: Handover, network: Network) -> list[TimedLine]:
    """A round for each robot, by which they keep periods that are as short as is found."""
    search = GraphSearch(
        mission=asked.mission, network=network, calls=calls_of(asked.mission, network),
        bound=ProvedBound(robots=1, reason="something is to be visited"),
        body_m=common_robot(asked.mission.fleet).body_radius_m, seed=asked.seed, should_stop=lambda: False,
    )  # fmt: skip
    return [loop_of(line) for line in search.plan(search.shares_with_room(1.0))]


def _coming(asked: Handover, name: str, network: Network) -> Coming | None:
    """A robot on its way to the next end; None for a new one that is at none."""
    line = asked.going_on.get(name)
    places_m = np.array([asked.places[name]]) if line is None else line.positions_m[:, :2]
    times_s = np.zeros(1) if line is None else line.times_s
    away_m = np.hypot(*(places_m[:, None] - network.ends_m[None]).transpose(2, 0, 1))
    there = np.flatnonzero(away_m.min(axis=1) <= HAIR_M)
    if not len(there):
        return None
    first = int(there[0])
    end = int(np.argmin(away_m[first]))
    from_there_s, before = dijkstra(network.ways_s, indices=end, return_predecessors=True)
    way = steady(times_s[: first + 1], places_m[: first + 1])
    return Coming(name=name, line=way, end=end, from_there_s=from_there_s, before=before.astype(np.int64))


def _join_all(
    coming: Sequence[Coming], rounds: Sequence[TimedLine], shift_s: float, network: Network
) -> dict[str, Trajectory] | None:
    """All robots into rounds that are so far on at the time 0, by name; None where one cannot come."""
    entries = [_ends_of(round_, network) for round_ in rounds]
    earliest_s = np.array(
        [[_moments_s(one, *entry, round_.duration_s, shift_s).min(initial=math.inf) for entry, round_ in
          zip(entries, rounds, strict=True)] for one in coming]
    )  # fmt: skip
    who = earliest_assignment(earliest_s)
    if who is None:
        return None
    joined: dict[str, Trajectory] = {}
    for k, round_ in enumerate(rounds):
        one, (phases_s, ends) = coming[int(who[k])], entries[k]
        moments_s = _moments_s(one, phases_s, ends, round_.duration_s, shift_s)
        best = int(np.argmin(moments_s))
        line = _trajectory(one, network, int(ends[best]), float(moments_s[best]), start_round(round_, phases_s[best]))
        if line is None:
            return None
        joined[one.name] = line
    return joined


def start_round(round_: TimedLine, phase_s: float) -> TimedLine:
    """The round begun so far into it."""
    return round_ if round_.stays else start_at(round_, float(phase_s))


def _ends_of(round_: TimedLine, network: Network) -> tuple[Floats, Ints]:
    """When a round is at ends of lanes, and at which: (k,) each."""
    away_m = np.hypot(*(round_.places_m[:, None] - network.ends_m[None]).transpose(2, 0, 1))
    there = np.flatnonzero(away_m.min(axis=1) <= HAIR_M)
    return round_.times_s[there], np.argmin(away_m[there], axis=1)


def _moments_s(one: Coming, phases_s: Floats, ends: Ints, duration_s: float, shift_s: float) -> Floats:
    """When a robot can come into a round at each of its ends (k,), as far on as the round then is; inf: never."""
    least_s = one.line.duration_s + one.from_there_s[ends]
    if duration_s == 0:
        return np.asarray(least_s)
    first_s = (phases_s - shift_s) % duration_s
    with np.errstate(invalid="ignore"):
        turns = np.ceil(np.maximum(0.0, least_s - first_s) / duration_s)
        return np.asarray(np.where(np.isfinite(turns), first_s + turns * duration_s, np.inf))


def _trajectory(one: Coming, network: Network, end: int, joins_s: float, round_: TimedLine) -> Trajectory | None:
    """The trajectory to the end of its lane, on to an end of the round, a wait there, and the round."""
    ends = [end]
    while ends[-1] != one.end:
        ends.append(int(one.before[ends[-1]]))
    way = network.line_along(ends[::-1])
    times, places = [one.line.times_s], [one.line.places_m]
    for begins_s, line in ((one.line.duration_s, way), (joins_s, round_)):
        if begins_s - times[-1][-1] > SHORTEST_S:
            times.append(np.array([begins_s]))
            places.append(places[-1][-1:])
        else:
            begins_s = float(times[-1][-1])
        if not line.stays:
            times.append(begins_s + line.times_s[1:])
            places.append(line.places_m[1:])
    try:
        return Trajectory(
            robot=one.name, times_s=np.concatenate(times), positions_m=np.vstack(places),
            loop_start_s=begins_s,
        )  # fmt: skip
    except PlanError:  # legs whose times are one but for rounding
        return None
