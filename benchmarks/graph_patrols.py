"""Teams on the graphs of patrolling_sim: idleness beside the recorded routes of its strategy MSP and one cyclic round.

D. Portugal and R. P. Rocha, "On the Performance and Scalability of Multi-Robot Patrolling Algorithms" (SSRR 2011) and
the program's own files: ``maps/NAME/NAME.graph``, and ``MSP/NAME/NAME_K_I``, the closed route of robot I of K. *Worst*
idleness is the longest time between visits to any place; *mean* the mean over places of the mean time between visits.
All drive 1 m/s along the same edges, without time for turning or meeting. Robots of MSP do not wait for each other: the
worst of a place is that of the route which comes to it most often.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.row import Options, Row
from rota import Fleet, PatrolSettings, make_plan
from rota.check import check_plan
from rota.errors import NoPlanFound
from rota.files.mission_file import read_mission
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planners.patrol.route_graph.network import Calls, calls_of, network_of
from rota.planners.patrol.route_graph.plan_on_graph import nearest_first, plain_shares

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MAPS = ("example", "grid", "cumberland", "DIAG_labs", "1r5")
TEAMS = (1, 2, 4, 6, 8)
ASKED = "no worse than the best of its peers"
NEAR_M = 1e-3


class Idleness(NamedTuple):
    """Seconds between visits."""

    worst_s: float
    mean_s: float

    def __str__(self) -> str:
        return f"{self.worst_s:.1f} / {self.mean_s:.1f} s"


def graph_patrols(options: Options) -> Iterator[Row]:
    """Worst and mean idleness of teams on each map; needs ``--graphs FOLDER``, a checkout of patrolling_sim."""
    if options.graphs is None:
        yield Row("teams on graphs, worst / mean idleness", ASKED, "needs --graphs FOLDER", None)
        return
    for name in MAPS:
        mission = mission_on(options.graphs.resolve(), options.folder, name)
        network = network_of(mission, 1.0)
        calls = calls_of(mission, network)
        number = {f"{x:.6f} {y:.6f}": k for k, (x, y) in enumerate(network.ends_m[calls.end].tolist())}
        named = {
            zone.name: number[f"{zone.shape.centroid.x:.6f} {zone.shape.centroid.y:.6f}"] for zone in mission.zones
        }
        order = nearest_first(calls.leg_s)
        whole_s = float(calls.leg_s[order, np.roll(order, -1)].sum())  # so long that one robot drives it
        (whole,) = plain_shares(calls.leg_s, np.full(len(calls), 1.01 * whole_s), moves=500_000, seed=0)
        alone = idleness_on_routes([route_through(whole.order.tolist(), calls)], calls)
        for robots in TEAMS:
            began_s = time.process_time()
            ours = idleness_of(least_idle(mission, robots), network.ends_m[calls.end])
            took_s = time.process_time() - began_s
            peers = {"one round for all": Idleness(alone.worst_s / robots, alone.mean_s / robots)}
            routes = recorded_routes(options.graphs / "MSP" / name, name, robots)
            if routes and all(place in named for route in routes for place in route):
                own = [np.array([named[place] for place in route]) for route in routes]
                peers["MSP"] = idleness_on_routes(own, calls)
            told = "; ".join(f"{peer} {value}" for peer, value in peers.items())
            best_s = min(value.worst_s for value in peers.values())
            what = f"{name}, {len(calls)} places, {robots} robot{'' if robots == 1 else 's'}: worst / mean idleness"
            yield Row(what, ASKED, f"{ours}, {took_s:.0f} s of CPU; {told}", ours.worst_s <= 1.001 * best_s)


def mission_on(graphs: Path, folder: Path, name: str) -> Mission:
    """All places of a map, to be visited more often than anybody can."""
    path = folder / f"{name}.yaml"
    graph = graphs / "maps" / name / f"{name}.graph"
    path.write_text(
        f"rota: 1\nname: {name}\narea: {{graph: {graph}, width_m: 0.02}}\nperiod_s: 1\n"
        "fleet: {speed_m_s: 1, sensor: {shape: disc, radius_m: 2}}\n"
    )
    return read_mission(path).mission


def least_idle(mission: Mission, robots: int) -> Plan:
    """The plan of a team for the shortest period that it keeps at all places; nothing else may be wrong with it."""
    fleet = Fleet(robots=robots, speed_m_s=mission.fleet.speed_m_s, sensor=mission.fleet.sensor)
    try:
        plan = make_plan(replace(mission, fleet=fleet, planning=PatrolSettings(effort="quick")), seed=0)
    except NoPlanFound as failure:
        if not isinstance(failure.best, Plan):
            raise
        plan = failure.best
    assert {found.kind for found in check_plan(plan).violations} <= {"gap"}, mission.name
    return plan


def idleness_of(plan: Plan, places_m: Floats) -> Idleness:
    """Of a plan as the check has it; a robot visits a place whenever it is at a timed point there."""
    worst_s = max(demand.worst_gap_s for demand in check_plan(plan).demands)
    rate = np.zeros(len(places_m))
    for trajectory in plan:
        at_m = trajectory.positions_m[trajectory.loop_index : -1] if trajectory.loop_duration_s else None
        if at_m is None:
            rate[np.hypot(*(places_m - trajectory.positions_m[-1]).T) < NEAR_M] = np.inf
            continue
        moved = (at_m != np.roll(at_m, 1, axis=0)).any(axis=1)  # who waits at a place visits it once
        near = np.hypot(*(places_m[:, None] - at_m[None, moved]).transpose(2, 0, 1)) < NEAR_M
        rate += near.sum(axis=1) / trajectory.loop_duration_s
    return Idleness(worst_s, float((1 / rate).mean()))


def recorded_routes(folder: Path, name: str, robots: int) -> list[list[str]]:
    """The closed routes of MSP for a team, place by place; none where some are missing."""
    paths = [folder / f"{name}_{robots}_{k}" for k in range(robots)]
    if not all(path.is_file() for path in paths):
        return []
    return [path.read_text().split()[1:] for path in paths]


def route_through(order: Sequence[int], calls: Calls) -> Ints:
    """All places on the closed way through places in an order, those on the way included."""
    number = {int(end): k for k, end in enumerate(calls.end)}
    ends = [end for a, b in zip(order, [*order[1:], order[0]], strict=True) for end in calls.way(a, b)[:-1]]
    return np.array([number[end] for end in [*ends, ends[0]]])


def idleness_on_routes(routes: Sequence[Ints], calls: Calls) -> Idleness:
    """Of closed routes, (m,) places each, the first again at the end."""
    worst_s, rate = np.full(len(calls), np.inf), np.zeros(len(calls))
    for route in routes:
        clock_s = np.concatenate([[0.0], np.cumsum(calls.leg_s[route[:-1], route[1:]])])
        for place in np.unique(route):
            at_s = clock_s[:-1][route[:-1] == place]
            gaps_s = np.diff(np.append(at_s, at_s[0] + clock_s[-1]))
            worst_s[place] = min(worst_s[place], gaps_s.max())
            rate[place] += len(at_s) / clock_s[-1]
    return Idleness(float(worst_s.max()), float((1 / rate).mean()))
