"""The best of all proofs that a mission takes so many robots."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from weakref import ref

import numpy as np

from rota.geometry.free_space import DemandedRegion
from rota.model.mission import Robot
from rota.planners.patrol.bounds.area_bound import area_rate, rate_proof
from rota.planners.patrol.bounds.chain_bound import chain_bound, straight_chain_bound
from rota.planners.patrol.bounds.forest_bound import forest_bound
from rota.planners.patrol.bounds.proved_bound import ProvedBound, max_of
from rota.planners.patrol.bounds.rate_bound import swept_robots
from rota.planners.patrol.bounds.seeable_area import surely_seeable_m2
from rota.planners.patrol.bounds.strongest_robot import strongest_robot
from rota.planners.patrol.bounds.tour_bound import tour_bound
from rota.planners.patrol.bounds.turning_bound import circle_radius_m, turning_robots
from rota.planners.patrol.bounds.visits_bound import visits_bound
from rota.planners.patrol.bounds.witness_points import Witnesses, witnesses_of
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.targets import targets_of
from rota.planners.patrol.planner_settings import Effort, PatrolSettings

TOUR_STATES: dict[Effort, int] = {"quick": 20, "normal": 30, "high": 200}  # of each search for orders


def prove_by_area(problem: Problem) -> ProvedBound:
    """The bound that counts no more than areas and periods: a tenth of the work, and often the highest there is."""
    least = least_asked(problem)
    if not least.robots:
        return least
    regions, robot = problem.regions, strongest_robot(problem.mission.fleet)
    seeable_m2 = surely_seeable_of(problem)
    return max_of([least, _by_areas(regions, seeable_m2, robot)])


def prove_bound(
    problem: Problem, *, tours: bool = True, should_stop: Callable[[], bool] = lambda: False
) -> ProvedBound:
    """The highest of all lower bounds for the problem's mission; of equal ones the simplest proof.

    Nothing that can be seen gives 0. Every bound is for a robot as good as the best of the fleet in all respects.
    tours: orders of places are looked at, too, which takes longer than all else; not any further once ``should_stop``.
    """
    least = least_asked(problem)
    if not least.robots:
        return least
    regions, robot = problem.regions, strongest_robot(problem.mission.fleet)
    witnesses, visits = witnesses_of(problem, robot.sensor.reach_m), asks_for_visits(problem)
    seeable_m2 = surely_seeable_of(problem)
    states = TOUR_STATES[PatrolSettings.of(problem.mission).effort] if tours else 0
    proofs = [
        least,
        _by_areas(regions, seeable_m2, robot),
        *_by_rates(regions, seeable_m2, robot, circle_radius_m(problem.mission)),
        straight_chain_bound(problem, robot),
    ]
    if witnesses.components > 1:
        proofs.append(_by_components(witnesses, robot, visits, states, should_stop))
    best = max_of(proofs)
    return max_of([best, *_by_witnesses(witnesses, robot, best.robots, visits, states, should_stop)])


_last: tuple[ref[Problem] | None, list[float]] = (None, [])  # the problem asked about last, and its areas


def surely_seeable_of(problem: Problem) -> list[float]:
    """What ``surely_seeable_m2`` tells of it, remembered: areas and periods are proved first, and all else later."""
    global _last
    known, areas_m2 = _last
    if known is None or known() is not problem:
        areas_m2 = surely_seeable_m2(problem.regions, problem.sure_space, problem.walls, problem.sure_robot)
        _last = ref(problem), areas_m2
    return areas_m2


def least_asked(problem: Problem) -> ProvedBound:
    """One robot where anything is asked that can be seen, else none."""
    if not len(problem.points):
        return ProvedBound(robots=0, reason="nothing that is asked can be seen")
    return ProvedBound(robots=1, reason="something is asked, and it can be seen")


def _by_areas(regions: Sequence[DemandedRegion], seeable_m2: Sequence[float], robot: Robot) -> ProvedBound:
    """The proof from areas and periods alone."""
    swept = [k for k, region in enumerate(regions) if region.demand == "every_point"]
    return rate_proof(*area_rate([seeable_m2[k] for k in swept], [regions[k].period_s for k in swept], robot))


def _by_rates(
    regions: Sequence[DemandedRegion], seeable_m2: Sequence[float], robot: Robot, radius_m: float
) -> Iterator[ProvedBound]:
    """The other proofs that count ground per second; radius_m: of a circle that no robot leaves."""
    swept = [k for k, region in enumerate(regions) if region.demand == "every_point"]
    shapes, periods_s = [regions[k].shape for k in swept], [regions[k].period_s for k in swept]
    asked_m2 = [seeable_m2[k] for k in swept]
    lost_m2 = [regions[k].shape.area - seeable_m2[k] for k in swept]
    yield rate_proof(*swept_robots(shapes, lost_m2, periods_s, robot))
    yield rate_proof(*turning_robots(shapes, asked_m2, periods_s, robot, radius_m), turns=True)


def asks_for_visits(problem: Problem) -> bool:
    """Whether a robot meets some of several demands by coming to a place; other ground is swept."""
    return len(problem.regions) > 1 and len(targets_of(problem)) > 0


def _by_witnesses(
    witnesses: Witnesses, robot: Robot, least: int, visits: bool, states: int, should_stop: Callable[[], bool]
) -> Iterator[ProvedBound]:
    """The proofs from places far apart. least: what is known already, so that vain searches end early."""
    known = least
    for proof in _by_pairs(witnesses, robot, least, visits):
        known = max(known, proof.robots)
        yield proof
    if states:
        yield tour_bound(witnesses, robot, known, states, should_stop)


def _by_pairs(witnesses: Witnesses, robot: Robot, least: int, visits: bool) -> Iterator[ProvedBound]:
    """Those of them that know no more of the places than how far apart each two of them are."""
    apart_m, speed_m_s = witnesses.apart_m, robot.ground_speed_m_s
    if np.isfinite(witnesses.way_m).all():
        yield chain_bound(witnesses.way_m, witnesses.spread_m, witnesses.period_s, speed_m_s)
    if visits:
        yield from visits_bound(apart_m, witnesses.period_s, speed_m_s, least)
    windows_s = np.unique(witnesses.period_s)
    for window_s in windows_s[:: max(1, len(windows_s) // 6)]:  # six windows, or a few more, spread over all
        asked = np.flatnonzero(witnesses.period_s <= window_s)
        yield forest_bound(apart_m[np.ix_(asked, asked)], float(window_s), speed_m_s, least)


def _by_components(
    witnesses: Witnesses, robot: Robot, visits: bool, states: int, should_stop: Callable[[], bool]
) -> ProvedBound:
    """The bounds of the components, added up: what is seen from one component alone takes robots of its own."""
    each = []
    for component in np.unique(witnesses.component[witnesses.component >= 0]):
        own = witnesses.choose(witnesses.component == component)
        proofs = _by_witnesses(own, robot, 1, visits, states, should_stop)
        each.append(max([1, *(proof.robots for proof in proofs)]))
    return ProvedBound(
        robots=sum(each),
        reason=f"the ground falls into {len(each)} parts between which no robot can travel,"
        f" and they take {' + '.join(map(str, each[:8]))}{' + ...' if len(each) > 8 else ''}",
    )
