"""A plan for robots that keep to lanes: who comes to which places, the rounds in time, and what the judge says."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rota.errors import NoPlanFound
from rota.model.arrays import Floats, Ints
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planners.patrol.bounds.forest_bound import forest_bound
from rota.planners.patrol.bounds.proved_bound import ProvedBound, max_of
from rota.planners.patrol.bounds.strongest_robot import strongest_robot
from rota.planners.patrol.bounds.visits_bound import visits_bound
from rota.planners.patrol.cycles.in_step import with_one_less
from rota.planners.patrol.cycles.teams import Share, share_places, worth
from rota.planners.patrol.driving.timed_line import TimedLine, start_at, steady
from rota.planners.patrol.ground.problem import common_robot
from rota.planners.patrol.margins import with_reserve
from rota.planners.patrol.methods.cycles.search import MOST_TARGETS, ROUNDS, STATES, STATES_IN_STEP
from rota.planners.patrol.planner_settings import Effort, PatrolSettings
from rota.planners.patrol.route_graph.network import Calls, Network, calls_of, network_of
from rota.planners.patrol.route_graph.splitting_kernels import anneal_order, split_at_best
from rota.planners.patrol.tolerances import SHORTEST_S, SLOWER
from rota.planners.patrol.tours.timetable import as_trajectories, evenly_spaced
from rota.planners.patrol.traffic.bodies.loops import Loop
from rota.planners.patrol.traffic.bodies.timing import timed_loops
from rota.planners.patrol.verdict import Verdict, unmet_reason
from rota.planning.planner import Request

MOVES: dict[Effort, int] = {"quick": 120_000, "normal": 500_000, "high": 3_000_000}  # tried on the order of places
PER_LOAD = 0.3  # of a robot: what a robot's full load costs, so that rounds become shorter until one robot is spared


@dataclass(frozen=True, kw_only=True)
class GraphSearch:
    """What is asked of robots on lanes, and what is known of it."""

    mission: Mission
    network: Network
    calls: Calls
    bound: ProvedBound
    body_m: float
    seed: int
    should_stop: Callable[[], bool]

    def shares(self, stretch: float) -> list[Share]:
        """The fewest robots found for periods that are longer by a factor; robots with bodies keep no step."""
        return fewest_shares(
            replace(self.calls, period_s=stretch * self.calls.period_s), enough=self.bound.robots,
            effort=PatrolSettings.of(self.mission).effort, with_step=self.body_m == 0, seed=self.seed,
            should_stop=self.should_stop,
        )  # fmt: skip

    def shares_with_room(self, stretch: float) -> list[Share]:
        """The fewest robots for periods shorter by a factor, which then have time to wait; or those of a fixed team."""
        team = self.mission.fleet.robots
        shares = [share._replace(headway_s=share.headway_s / stretch) for share in self.shares(stretch)]
        if team is None:
            return shares
        if count_of(shares) > len(team):
            shares = shares_of_team(self.shares, len(team), self.should_stop)
        return with_spare_robots(shares, len(team))

    def plan(self, shares: list[Share]) -> Plan:
        """The plan in which robots drive these, with bodies kept apart if timing can do it."""
        network, calls, team = self.network, self.calls, self.mission.fleet.robots
        if in_step(shares):
            lines = [line for share in shares for line in lines_in_step(network, calls, share)]
        else:
            lines = timed_loops([loop_on_lanes(network, calls, share) for share in shares], self.body_m)
        names = [robot.name for robot in team] if team else [f"robot-{k + 1}" for k in range(len(lines))]
        return Plan(
            mission=self.mission, trajectories=as_trajectories(lines, names), seed=self.seed,
            lower_bound_robots=self.bound.robots, lower_bound_reason=self.bound.reason,
        )  # fmt: skip


def plan_on_lanes(request: Request) -> Plan:
    """A plan whose robots keep to the mission's lanes and come to all its zones in time, or that of a fixed team.

    Robots that a fixed team has to spare join those that are the latest for their period. Bodies are kept apart by
    phases and waits; where these are not enough, rounds are planned with more time to spare, which may take more
    robots. Raises NoPlanFound, with the best plan, where a fixed team is too small, and where bodies meet all the same;
    without one where no lane ends in a zone.
    """
    mission, should_stop = request.mission, request.should_stop
    request.progress(0.0, "looking at the lanes")
    tight = with_reserve(mission)
    robot = common_robot(tight.fleet)
    network = network_of(tight, robot.ground_speed_m_s * SLOWER)
    search = GraphSearch(
        mission=mission, network=network, calls=calls_of(tight, network), bound=prove_on_lanes(mission),
        body_m=robot.body_radius_m, seed=request.seed, should_stop=should_stop,
    )  # fmt: skip
    failed: list[tuple[Plan, Verdict]] = []
    # of the periods, so that robots can wait for each other
    stretches = (1.0, 0.9, 0.8, 0.65, 0.5) if robot.body_radius_m > 0 else (1.0,)
    for k, stretch in enumerate(stretches):
        request.progress((k + 0.1) / len(stretches), "sharing the places among robots")
        plan = search.plan(search.shares_with_room(stretch))
        if (verdict := request.judge(plan)).verdict == "met":
            return plan
        failed.append((plan, verdict))
        if should_stop():
            break
    raise NoPlanFound(unmet_reason(*failed[0]), best=failed[0][0])


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
    for _ in range(10):  # halvings of the range in which the shortest periods lie
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
    if in_step(shares):
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


def in_step(shares: Sequence[Share]) -> bool:
    """Whether some robots keep step with each other."""
    return any(share.times_s is not None for share in shares)


def loop_on_lanes(network: Network, calls: Calls, share: Share) -> Loop:
    """The round of a share, which runs its own way only, and may be slower."""
    return Loop(
        line=round_in_time(network, calls, share), robots=share.robots, period_s=share.headway_s,
        speed_m_s=network.speed_m_s, is_one_way=True,
    )  # fmt: skip


def lines_in_step(network: Network, calls: Calls, share: Share) -> list[TimedLine]:
    """The rounds of the robots of a share; of one that keeps step from the beginning of the round of all."""
    line = round_in_time(network, calls, share)
    if share.times_s is None or line.stays:
        return evenly_spaced(line, share.robots)
    return [start_at(line, share.round_s - float(share.times_s[0]))] * share.robots  # those to spare go along


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


def fewest_shares(
    calls: Calls, *, effort: Effort, enough: int, with_step: bool, seed: int, should_stop: Callable[[], bool]
) -> list[Share]:
    """The fewest robots found that come to all places in time, in each part of the network by itself.

    with_step: robots may keep step with each other; their times then leave no room to wait for others.
    """
    shares = list[Share]()
    parts = [np.flatnonzero(calls.part == part) for part in np.unique(calls.part)]
    for own in parts:
        leg_s, period_s = calls.leg_s[np.ix_(own, own)], calls.period_s[own]
        found = plain_shares(leg_s, period_s, moves=MOVES[effort], seed=seed)
        if len(own) <= MOST_TARGETS:
            again = share_places(
                leg_s, period_s, most_states=STATES[effort], rounds=ROUNDS[effort], seed=seed,
                should_stop=should_stop, begin=found,
            )  # fmt: skip
            found = min(found, again, key=worth)
        if with_step:
            found = with_one_less(
                found, leg_s, period_s, most_states=STATES_IN_STEP * STATES[effort],
                enough=enough if len(parts) == 1 else 1, should_stop=should_stop,
            )  # fmt: skip
        shares += [share._replace(order=own[share.order]) for share in found]
    return shares


def plain_shares(leg_s: Floats, period_s: Floats, *, moves: int, seed: int) -> list[Share]:
    """Rounds that come to each place (n,) once, from an order of all of them that moves have made better."""
    order = nearest_first(leg_s)
    settings = np.array([moves, 0.3, 1e-3, PER_LOAD])
    random = np.array([2 * seed + 1], dtype=np.uint64)
    anneal_order(order, leg_s, period_s, settings, random)
    least, cut = np.zeros(len(order) + 1), np.zeros(len(order) + 1, dtype=np.int64)
    split_at_best(order, leg_s, period_s, PER_LOAD, least, cut)
    shares, end = list[Share](), len(order)
    while end:
        some, end = order[cut[end] : end], int(cut[end])
        round_s = float(leg_s[some, np.roll(some, -1)].sum()) if len(some) > 1 else 0.0
        headway_s = float(period_s[some].min())
        shares.append(Share(some, max(1, math.ceil(round_s / (SLOWER * headway_s))), round_s, headway_s))
    return shares[::-1]


def nearest_first(leg_s: Floats) -> Ints:
    """All places (n,), each followed by the nearest that is left."""
    order, left = [0], set(range(1, len(leg_s)))
    while left:
        order.append(min(left, key=lambda k: (leg_s[order[-1], k], k)))
        left.remove(order[-1])
    return np.array(order, dtype=np.int64)


def with_spare_robots(shares: list[Share], robots: int) -> list[Share]:
    """The shares with so many robots in all: each more goes where robots are the latest for their period."""
    shares = list(shares)
    for _ in range(robots - sum(share.robots for share in shares)):
        plain = [k for k, share in enumerate(shares) if share.is_plain]
        if not plain:
            plain = list(range(len(shares)))  # it stands by
        k = max(plain, key=lambda k: shares[k].round_s / shares[k].robots / shares[k].headway_s)
        shares[k] = shares[k]._replace(robots=shares[k].robots + 1)
    return shares
