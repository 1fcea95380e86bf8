"""Plans of robots that charge: those that take turns at loops, or fly circuits where that takes fewer robots."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace

from rota.errors import NoPlanFound
from rota.model.arrays import Floats
from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.bounds.best_bound import prove_bound
from rota.planners.patrol.bounds.charging_bound import charging_bound, charging_of
from rota.planners.patrol.bounds.proved_bound import ProvedBound, max_of
from rota.planners.patrol.circuits.ground import least_on_circuits
from rota.planners.patrol.circuits.plan_with_circuits import plan_with_circuits
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.margins import with_reserve
from rota.planners.patrol.methods.fewest.search import share_of_progress
from rota.planners.patrol.planner_settings import MOST_PATROLLING
from rota.planners.patrol.relief.posts import posts_of
from rota.planners.patrol.relief.relieve import clearance_of, endless, relieve, require_reach, without_batteries
from rota.planners.patrol.relief.slots import only_visits
from rota.planning.planner import Request


def plan_that_charges(request: Request, search: Callable[[Request], Plan], turns_s: Floats | None = None) -> Plan:
    """The plan with the fewest robots that charge: ``relieve``, and ``plan_with_circuits`` where that may take fewer.

    It is one for ``with_reserve(mission)``, and passes the judge as that; its bound is that of what is asked. search:
    plans for a mission without batteries. turns_s: how long turns at loops may be, and no circuits; None: anything.
    Raises NoPlanFound where no plan exists since batteries are too small or places at chargers too few, and where
    neither finds one.
    """
    mission, seed, judge, progress = request.mission, request.seed, request.judge, request.progress
    require_reach(mission)
    tight = with_reserve(mission)
    problem = set_up_problem(without_batteries(mission))
    bound = charging_bound(problem, mission)
    # loops for circuits, which are as short as can be, take longer
    loops = search(replace(request, mission=endless(mission), progress=share_of_progress(progress, 0.0, 0.4)))
    always = ProvedBound(robots=loops.lower_bound_robots or 0, reason=loops.lower_bound_reason or "")
    if clearance_of(mission) > 0:  # the search proved it for shorter periods than are asked
        always = prove_bound(problem)
    best = max_of([always, bound])
    loops = replace(loops, lower_bound_robots=best.robots, lower_bound_reason=best.reason)
    posts = posts_of(problem, mission.chargers) if only_visits(mission) else ()
    tried = [loops.trajectories, posts] if posts else [loops.trajectories]
    relieved = _take_turns(tried, loops, tight, request, turns_s)
    most = _most_on_circuits(mission, relieved, best.robots) if turns_s is None else 0
    if most > 0 and not request.should_stop():
        told = share_of_progress(progress, 0.4, 1.0)

        def search_part(part: Mission, /, *, begin: float, end: float) -> Plan:
            """A loop for one robot; nobody watches it, as it is no plan for the mission."""
            own = share_of_progress(told, begin, end)
            return search(replace(request, mission=part, progress=own, watch=None))

        with suppress(NoPlanFound):
            found = plan_with_circuits(tight, most=most, seed=seed, judge=judge, search=search_part)
            return replace(loops, mission=tight, trajectories=found.trajectories)
    if isinstance(relieved, NoPlanFound):
        raise relieved
    return relieved


def _take_turns(
    tried: Sequence[Sequence[Trajectory]], loops: Plan, tight: Mission, request: Request, turns_s: Floats | None
) -> Plan | NoPlanFound:
    """The plan with the fewest robots that take turns at the loops of one of some plans, or why none does.

    Robots whose jerk is limited change anywhere, and only where all go steadily if no plan passes so.
    """
    best: Plan | NoPlanFound | None = None
    has_jerk = tight.fleet.equal_robot("robot-1").motion.jerk_m_s3 is not None
    for (number, ways), steadily in itertools.product(enumerate(tried), (False, True) if has_jerk else (False,)):
        if (steadily and isinstance(best, Plan)) or (best is not None and request.should_stop()):
            continue
        try:
            own = replace(loops, mission=endless(tight), trajectories=tuple(ways))
            found = relieve(own, tight, request, briefly=number > 0, steadily=steadily, turns_s=turns_s)
        except NoPlanFound as failure:
            best = failure if best is None or steadily else best
            continue
        if not isinstance(best, Plan) or len(found) < len(best):
            best = found
    assert best is not None
    return best


def _most_on_circuits(mission: Mission, relieved: Plan | NoPlanFound, bound: int) -> int:
    """How many robots on circuits would be better than turns at loops; 0 where they can hardly be so few.

    Of robots with a turn radius no circuits are made.
    """
    if mission.fleet.equal_robot("robot-1").turn_radius_m > 0:
        return 0
    named = mission.fleet.robots
    if isinstance(relieved, Plan):
        most = len(relieved) - 1 if named is None else 0
    else:
        most = MOST_PATROLLING if named is None else len(named)
    least = least_on_circuits(mission, charging_of(mission).per_s)
    return most if most >= max(bound, math.ceil(least)) else 0
