"""The best proof at hand that a mission takes so many robots, and the proof in one sentence."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.geometry.free_space import DemandedRegion
from rota.mission import Robot
from rota.planners.patrol.bounds.apart_bound import (
    best_chain,
    heaviest_clique,
    straight_chain,
    too_far_apart,
    travel_robots,
)
from rota.planners.patrol.bounds.area_bound import area_rate, strongest_robot
from rota.planners.patrol.bounds.far_groups import Pieces, ground_pieces, groups_of_their_own, swept_and_travelled
from rota.planners.patrol.bounds.rate_bound import swept_robots
from rota.planners.patrol.bounds.seeable_area import surely_seeable_m2
from rota.planners.patrol.bounds.witness_points import Witnesses, witnesses_of
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.samples import SamplePoints
from rota.planners.patrol.verdict import counted

Ints = NDArray[np.int64]

ROUNDING = 1e-6  # what a real number of robots must exceed a whole one by
MOST_CHAINED, MOST_WINDOWS = 20_000, 6


@dataclass(frozen=True, kw_only=True)
class ProvedBound:
    """No plan with fewer than ``robots`` exists; ``reason`` says why, to go on after "... robots at least:"."""

    robots: int
    reason: str


def prove_bound(problem: Problem) -> ProvedBound:
    """The highest of all lower bounds for the problem's mission; of equal ones the simplest proof.

    Nothing that can be seen gives 0. Every bound is for a robot as good as the best of the fleet in all respects.
    """
    mission, regions, points = problem.mission, problem.regions, problem.points
    if not len(points):
        return ProvedBound(robots=0, reason="nothing that is asked can be seen")
    robot = strongest_robot(mission.fleet)
    periods_s = list(problem.periods_s)
    seen = witnesses_of(problem, robot.sensor.reach_m)
    seeable_m2 = surely_seeable_m2(regions, problem.space, problem.walls, problem.robot)
    pieces = ground_pieces(regions, seeable_m2)
    best = max_of(
        [
            ProvedBound(robots=1, reason="something is asked, and it can be seen"),
            *_by_sweeping(regions, seeable_m2, robot),
            _by_groups(pieces, robot),
            _by_travel_between(pieces, robot),
            _by_straight_chain(points, periods_s, robot),
            *([_by_parts(seen, robot)] if seen.parts > 1 else []),
        ]
    )
    return max_of([best, *_by_witnesses(seen, robot, best.robots)])


def max_of(proofs: Sequence[ProvedBound]) -> ProvedBound:
    """The first of those that prove the most."""
    return max(proofs, key=lambda proof: proof.robots)


def _by_sweeping(regions: Sequence[DemandedRegion], seeable_m2: Sequence[float], robot: Robot) -> Iterator[ProvedBound]:
    strict = [k for k, region in enumerate(regions) if region.demand == "every_point"]
    areas, periods = [seeable_m2[k] for k in strict], [regions[k].period_s for k in strict]
    needed, asked = area_rate(areas, periods, robot)
    yield _rate_proof(needed, asked)
    lost = [regions[k].shape.area - seeable_m2[k] for k in strict]
    yield _rate_proof(*swept_robots([regions[k].shape for k in strict], lost, periods, robot))


def _rate_proof(needed: float, asked_m2_s: float) -> ProvedBound:
    robots = math.ceil(needed - ROUNDING)
    each = f", a robot sweeps {asked_m2_s / needed:.4g} at most" if needed > 0 else ""
    return ProvedBound(robots=robots, reason=f"{asked_m2_s:.4g} m2/s are asked for{each}")


def _by_groups(pieces: Pieces, robot: Robot) -> ProvedBound:
    robots, groups = groups_of_their_own(pieces, robot)
    if robots == groups:
        return ProvedBound(robots=robots, reason=_apart_reason(groups))
    return ProvedBound(
        robots=robots,
        reason=f"{groups} pieces of ground are too far apart for one robot to serve two"
        " of them, and each takes robots of its own",
    )


def _by_travel_between(pieces: Pieces, robot: Robot) -> ProvedBound:
    robots, window_s = swept_and_travelled(pieces, robot)
    return ProvedBound(
        robots=robots,
        reason=f"within any {window_s:.6g} s they must sweep ground in several places and travel between these",
    )


def _by_straight_chain(points: SamplePoints, periods_s: Sequence[float], robot: Robot) -> ProvedBound:
    lattice = np.flatnonzero((points.visit_m == 0) & (points.shrink_m > 0))
    some = lattice[:: max(1, len(lattice) // MOST_CHAINED)]
    period_s = np.array(periods_s)[points.period[some]]
    robots = straight_chain(points.xy_m[some], robot.sensor.reach_m, period_s, robot.speed_m_s)
    return ProvedBound(robots=robots, reason=_chain_reason(robots))


def _by_witnesses(seen: Witnesses, robot: Robot, least: int) -> Iterator[ProvedBound]:
    """Proofs from places far apart. least: what is known already, so that vain searches end early."""
    apart_m, speed_m_s = seen.apart_m, robot.speed_m_s
    one_each = np.ones(len(seen), dtype=np.int64)
    clique = len(heaviest_clique(too_far_apart(apart_m, seen.period_s, speed_m_s), one_each))
    yield ProvedBound(
        robots=clique,
        reason=_apart_reason(clique),
    )
    if np.isfinite(seen.way_m).all():
        chain = best_chain(seen.way_m, seen.spread_m, seen.period_s, speed_m_s)
        yield ProvedBound(robots=chain, reason=_chain_reason(chain))
    windows_s = np.unique(seen.period_s)
    for window_s in windows_s[:: max(1, len(windows_s) // MOST_WINDOWS)]:
        asked = np.flatnonzero(seen.period_s <= window_s)
        robots, shown = travel_robots(apart_m[np.ix_(asked, asked)], float(window_s), speed_m_s, least)
        yield ProvedBound(
            robots=robots,
            reason=f"{len(shown)} places must be served within any {window_s:.6g} s, and the ways between them are too"
            f" long for {counted(robots - 1)}",
        )


def _apart_reason(places: int) -> str:
    return f"{places} places are too far apart for one robot to serve two of them"


def _chain_reason(robots: int) -> str:
    return f"of {robots} places in a row none can be left for its period by a robot that serves the next"


def _by_parts(seen: Witnesses, robot: Robot) -> ProvedBound:
    """The bounds of the parts, added up: what is seen from one part alone takes robots of that part."""
    each = []
    for part in np.unique(seen.part[seen.part >= 0]):
        own = seen.chosen(seen.part == part)
        each.append(max([1, *(proof.robots for proof in _by_witnesses(own, robot, 1))]))
    robots = sum(each)
    return ProvedBound(
        robots=robots,
        reason=f"the ground falls into {len(each)} parts between which no robot can travel,"
        f" and they take {' + '.join(map(str, each[:8]))}{' + ...' if len(each) > 8 else ''}",
    )
