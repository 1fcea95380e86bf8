"""The second and third stage of Sun et al. 2019: frames and their partition, beside fast-tsp from PyPI in the same run.

CPU seconds, with everything compiled. The peer is installed into a folder that is thrown away.
"""

from __future__ import annotations

import functools
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from benchmarks.peer_environment import peer_answer
from benchmarks.row import Options, Row
from benchmarks.sun_tables import TABLE_2, TABLE_3, TABLE_4
from benchmarks.warm_cache import measured_warm
from rota.geometry.free_space import standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota_studies.sun2019 import figure_13
from rota_studies.sun2019_method.algorithms import TourSettings
from rota_studies.sun2019_method.partition import CostedPartition, PartitionSettings, cut_frame
from rota_studies.sun2019_method.route_lengths import route_lengths_m
from rota_studies.sun2019_stages.deploy import deploy_sensors
from rota_studies.sun2019_stages.frame import Frame
from rota_studies.sun2019_stages.local_search import locally_shortest_tour, tour_length
from rota_studies.sun2019_stages.partition import partition_frame
from rota_studies.sun2019_stages.tour import find_frame, straight_distances

PEER = "fast-tsp>=0.2,<0.3"
PEER_S = 2.0  # what the peer is given for a tour: its default
SEEDS = 5
SIZES = (100, 1000)
SIDE_M = 10_000.0
SPEED_M_S, SENSOR_M, VIRTUAL_M = 20.0, 5.0, 10.0


class Timed(NamedTuple):
    """What a call gave, and its CPU seconds."""

    answer: Any
    cpu_s: float


def sun_frame(options: Options) -> Iterator[Row]:
    """Frames past the sensors deployed on the paper's map, tours beside the peer's, and partitions."""
    sensors()
    frame = timed(lambda: frame_of(TourSettings()))
    yield genetic_row(frame)
    yield crossings_row(frame.answer)
    points = {n: [np.random.default_rng(seed).uniform(0, SIDE_M, (n, 2)) for seed in range(SEEDS)] for n in SIZES}
    for n in SIZES:
        problem = {"points": [places.tolist() for places in points[n]], "seconds": PEER_S}
        yield tours_row(points[n], peer_answer(options.folder, PEER, "peer_tours.py", problem))
    yield swarms_row(frame.answer)
    yield exact_row(100, 0.1)
    yield exact_row(2000, 5.0)


def timed(call: Callable[[], Any]) -> Timed:
    """What the call gives, and the median of its CPU seconds."""

    def once() -> Timed:
        started_s = time.process_time()
        answer = call()
        return Timed(answer, time.process_time() - started_s)

    runs = measured_warm(once, lambda one: one.cpu_s)
    return Timed(runs[0].answer, statistics.median(one.cpu_s for one in runs))


@functools.cache
def sensors() -> tuple[np.ndarray, np.ndarray, ShortestPaths]:
    """The sensors that Table 2's swarms deploy on Figure 13: positions, sub-regions, where robots travel."""
    mission = figure_13()
    deployment = deploy_sensors(mission, TABLE_2, seed=0)
    return deployment.positions_m, deployment.zone_of, ShortestPaths(standing_space(mission, 0.0))


def frame_of(settings: TourSettings, seed: int = 0) -> Frame:
    """The frame past those sensors."""
    places, zone, paths = sensors()
    return find_frame(places, zone, paths, virtual_radius_m=VIRTUAL_M, algorithm=settings, seed=seed)


def genetic_row(local: Timed) -> Row:
    """Table 3's genetic algorithm beside the local search."""
    genetic = timed(lambda: frame_of(TABLE_3))
    frames = [genetic.answer, *(frame_of(TABLE_3, seed) for seed in range(1, SEEDS))]
    longer = [frame.length_m / local.answer.length_m - 1 for frame in frames]
    changes = sorted({frame.zone_crossings for frame in frames})
    measured = f"{genetic.cpu_s:.1f} s; {100 * min(longer):.1f} to {100 * max(longer):.1f} % longer, changes of "
    measured += f"sub-region {', '.join(map(str, changes))}; local search {local.answer.length_m:,.0f} m with "
    measured += f"{local.answer.zone_crossings} in {local.cpu_s:.2f} s"
    name = f"Sun 2019, Table 3: genetic algorithm, {len(local.answer.order)} sensors, {SEEDS} seeds"
    reached = genetic.cpu_s < 20 and max(longer) <= 0.03
    return Row(name, "CPU < 20 s, at most 3 % longer than the local search's frame", measured, reached)


def crossings_row(graph: Frame) -> Row:
    """Figure 8: what Eq. 14 is for."""
    straight = frame_of(TourSettings(distance="euclidean"))
    measured = f"straight {straight.zone_crossings}, {straight.blocked_legs} legs blocked; "
    measured += f"Eq. 14 {graph.zone_crossings}, {graph.blocked_legs} blocked"
    asked = "fewer with Eq. 14, no leg blocked (the paper's map of Figure 8: 8 and 2)"
    reached = graph.zone_crossings < straight.zone_crossings and graph.blocked_legs == 0
    return Row("Sun 2019, Figure 8: changes of sub-region along the frame", asked, measured, reached)


def tours_row(points: list[np.ndarray], peer: dict[str, Any] | str) -> Row:
    """The local search's tours over random points beside the peer's."""
    n = len(points[0])
    name = f"local search, {n:,} random points, {len(points)} seeds"
    asked = f"at most 1 % longer than fast-tsp ({PEER_S:.0f} s each)"
    distances = [straight_distances(places) for places in points]
    kicks = TourSettings().kicks_per_waypoint
    ours = [
        timed(lambda d=d, k=k: locally_shortest_tour(d, kicks_per_waypoint=kicks, seed=k)[0])
        for k, d in enumerate(distances)
    ]
    seconds = f"CPU {statistics.median(one.cpu_s for one in ours):.2f} s a tour"
    if isinstance(peer, str):
        return Row(name, asked, f"peer not measured: {peer}; {seconds}", None)
    longer = [
        100 * (tour_length(d, one.answer) / tour_length(d, np.array(theirs["order"])) - 1)
        for d, one, theirs in zip(distances, ours, peer["tours"], strict=True)
    ]
    measured = f"{min(longer):+.2f} to {max(longer):+.2f} %, mean {statistics.mean(longer):+.2f} %; {seconds}; "
    return Row(name, asked, f"{measured}fast-tsp {peer['version']}", max(longer) <= 1)


def partition_of(frame: Frame, settings: PartitionSettings) -> CostedPartition:
    """The frame past the sensors, cut for the periods of Section 5.1."""
    _, zone, _ = sensors()
    periods_s = np.array([8.0, 20.0, 40.0])[zone[frame.order]]
    lengths_m = None
    if settings.times == "routes":
        lengths_m = route_lengths(settings.joining_legs)
    return cut_frame(
        frame.legs_m, periods_s, speed_m_s=SPEED_M_S, sensor_radius_m=SENSOR_M, route_lengths_m=lengths_m,
        settings=settings, seed=0,
    )  # fmt: skip


@functools.cache
def route_lengths(joining_legs: bool) -> np.ndarray:
    """Eq. 26: metres of the closed routes round all stretches of the local search's frame."""
    _, zone, paths = sensors()
    frame = frame_of(TourSettings())
    return route_lengths_m(
        frame, np.array([8.0, 20.0, 40.0])[zone[frame.order]], paths, speed_m_s=SPEED_M_S, radius_m=SENSOR_M,
        joining_legs=joining_legs,
    )  # fmt: skip


def swarms_row(frame: Frame) -> Row:
    """Table 4's particle swarms at their printed size, and the exact optimum by the same rules."""
    swarms = timed(lambda: partition_of(frame, TABLE_4))
    exact = timed(lambda: partition_of(frame, replace(TABLE_4, method="exact")))
    found, best = swarms.answer, exact.answer
    measured = f"{swarms.cpu_s:.1f} s; {len(found.first)} robots, cost {found.cost:,.0f} from iteration "
    measured += f"{int(np.argmin(found.history))} on; exact: {len(best.first)} robots, cost "
    measured += f"{best.cost:,.0f}, in {1e3 * exact.cpu_s:.1f} ms"
    name = f"Sun 2019, Table 4: {TABLE_4.swarms} swarms of {TABLE_4.particles:,}, {TABLE_4.iterations} iterations"
    reached = swarms.cpu_s < 60 and len(found.first) == len(best.first)
    return Row(name, "CPU < 60 s, as many robots as the exact optimum", measured, reached)


def exact_row(n: int, limit_s: float) -> Row:
    """The exact partition of long frames with four stretches of three periods; the slowest of several periods."""
    legs_m = np.random.default_rng(n).uniform(8, 14, n)
    slowest = Timed(None, 0.0)
    for period_s in (8.0, 30.0, 0.1 * n, 0.5 * n):
        periods_s = np.repeat([period_s, 5 * period_s, 2 * period_s, 5 * period_s], n // 4)
        call = timed(
            lambda periods_s=periods_s: partition_frame(legs_m, periods_s, speed_m_s=SPEED_M_S, sensor_radius_m=5)
        )
        slowest = max(slowest, call, key=lambda one: one.cpu_s)
    measured = f"{slowest.cpu_s:.3f} s, {len(slowest.answer.first)} robots"
    return Row(f"exact partition, {n:,} waypoints", f"CPU < {limit_s:g} s", measured, slowest.cpu_s < limit_s)
