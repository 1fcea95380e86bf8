"""A plan for robots that keep to lanes: who comes to which places, the rounds in time, and what the judge says."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rota.errors import NoPlanFound
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planners.patrol.bounds.forest_bound import forest_bound
from rota.planners.patrol.bounds.proved_bound import ProvedBound, max_of
from rota.planners.patrol.bounds.strongest_robot import strongest_robot
from rota.planners.patrol.bounds.visits_bound import visits_bound
from rota.planners.patrol.cycles.teams import Share
from rota.planners.patrol.driving.timed_line import TimedLine, start_at, steady
from rota.planners.patrol.ground.problem import common_robot
from rota.planners.patrol.margins import with_reserve
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.route_graph.network import Calls, Network, calls_of, network_of
from rota.planners.patrol.route_graph.rounds import fewest_shares, with_spare_robots
from rota.planners.patrol.tolerances import SHORTEST_S, SLOWER
from rota.planners.patrol.tours.timetable import as_trajectories, evenly_spaced
from rota.planners.patrol.verdict import Judge, unmet_reason

Floats = NDArray[np.float64]

HALVINGS = 10  # of the range in which the shortest periods lie that a fixed team keeps


def plan_on_lanes(
    mission: Mission,
    *,
    seed: int,
    judge: Judge,
    progress: Callable[[float, str], None],
    should_stop: Callable[[], bool],
) -> Plan:
    """A plan whose robots keep to the mission's lanes and come to all its zones in time, or that of a fixed team.

    Robots that a fixed team has to spare join those that are the latest for their period. Raises NoPlanFound, with the
    best plan, where a fixed team is too small, and where bodies meet on the way; without one where no lane ends in a
    zone.
    """
    progress(0.0, "looking at the lanes")
    tight = with_reserve(mission)
    network = network_of(tight, common_robot(tight.fleet).ground_speed_m_s * SLOWER)
    calls, bound = calls_of(tight, network), prove_on_lanes(mission)
    progress(0.1, "sharing the places among robots")

    def search(stretch: float) -> list[Share]:
        """The fewest robots for periods that are longer by a factor."""
        return fewest_shares(
            replace(calls, period_s=stretch * calls.period_s), effort=PatrolSettings.of(mission).effort,
            enough=bound.robots, seed=seed, should_stop=should_stop,
        )  # fmt: skip

    shares, team = search(1.0), mission.fleet.robots
    if team is not None and count_of(shares) > len(team):
        shares = shares_of_team(search, len(team), should_stop)
    if team is not None:
        shares = with_spare_robots(shares, len(team))
    progress(0.9, "judging the plan")
    lines = [line for share in shares for line in robot_lines(network, calls, share)]
    names = [robot.name for robot in team] if team else [f"robot-{k + 1}" for k in range(len(lines))]
    plan = Plan(
        mission=mission, trajectories=as_trajectories(lines, names), seed=seed, lower_bound_robots=bound.robots,
        lower_bound_reason=bound.reason,
    )  # fmt: skip
    if (verdict := judge(plan)).verdict != "met":
        raise NoPlanFound(unmet_reason(plan, verdict), best=plan)
    return plan


def count_of(shares: Sequence[Share]) -> int:
    """The robots of all shares."""
    return sum(share.robots for share in shares)


def shares_of_team(search: Callable[[float], list[Share]], robots: int, should_stop: Callable[[], bool]) -> list[Share]:
    """What a team that is too small does at best: the rounds for the periods that it keeps, longer by one factor."""
    low, high = 1.0, 2.0
    while count_of(best := search(high)) > robots:
        low, high = high, 2 * high
        if high > 1e6:
            raise NoPlanFound(f"{robots} robots cannot come to all places: lanes lead to some of them, and not back")
    for _ in range(HALVINGS):
        if should_stop():
            break
        middle = math.sqrt(low * high)
        found = search(middle)
        if count_of(found) <= robots:
            best, high = found, middle * stretch_needed(with_spare_robots(found, robots))
            low = min(low, high)
        else:
            low = middle
    return best


def stretch_needed(shares: Sequence[Share]) -> float:
    """By how much the periods may be longer or shorter that rounds of equal headways keep; 1 where some keep step."""
    if any(share.times_s is not None for share in shares):
        return 1.0
    late = [share.round_s / share.robots / share.headway_s if share.is_plain else 1.0 for share in shares]
    return min(1.0, max(late) / SLOWER)


def prove_on_lanes(mission: Mission) -> ProvedBound:
    """The fewest robots that are proved to be needed; see ``forest_bound`` and ``visits_bound``.

    It is proved for the fastest robot of the fleet. A way between two places counts as the shorter of there and back.
    """
    network = network_of(mission, strongest_robot(mission.fleet).ground_speed_m_s)
    calls = calls_of(mission, network)
    parts = len(np.unique(calls.part))
    apart = [ProvedBound(robots=1, reason="something is to be visited")]
    if parts > 1:
        reason = f"no robot comes there and back between {parts} parts of the lanes"
        apart.append(ProvedBound(robots=parts, reason=reason))
    apart_s = np.minimum(calls.leg_s, calls.leg_s.T)
    for window_s in np.unique(calls.period_s):
        asked = np.flatnonzero(calls.period_s <= window_s)
        apart.append(forest_bound(apart_s[np.ix_(asked, asked)], float(window_s), 1.0, max_of(apart).robots))
    return max_of([*apart, *visits_bound(apart_s, calls.period_s, 1.0, max_of(apart).robots)])


def robot_lines(network: Network, calls: Calls, share: Share) -> list[TimedLine]:
    """The rounds of the robots of a share, at equal headways."""
    if share.times_s is None:
        return evenly_spaced(round_in_time(network, calls, share), share.robots)
    line = round_in_time(network, calls, share)
    return [line if line.stays else start_at(line, share.round_s - float(share.times_s[0]))]


def round_in_time(network: Network, calls: Calls, share: Share) -> TimedLine:
    """One round from its first place on; who keeps step with others waits at places where it is early."""
    order = share.order.tolist()
    ways = [calls.way(a, b) for a, b in zip(order, order[1:] + order[:1], strict=True)]
    if len(set(order)) == 1:
        return steady(np.zeros(1), network.ends_m[ways[0][:1]])
    if share.times_s is None:
        return network.line_along([ways[0][0], *(end for way in ways for end in way[1:])])
    due_s = np.diff(np.append(share.times_s, share.times_s[0] + share.round_s))
    times_s, places_m = [np.zeros(1)], [network.ends_m[ways[0][:1]]]
    for k, (way, leg_s) in enumerate(zip(ways, due_s.tolist(), strict=True)):
        line = network.line_along(way)
        arrive_s, at_m = line.times_s[1:].copy(), line.places_m[1:]
        if leg_s - line.duration_s > SHORTEST_S:
            arrive_s, at_m = np.append(arrive_s, leg_s), np.vstack([at_m, at_m[-1:]])
        arrive_s[-1:] = leg_s
        times_s.append(math.fsum(due_s[:k]) + arrive_s)
        places_m.append(at_m)
    return steady(np.concatenate(times_s), np.vstack(places_m))
