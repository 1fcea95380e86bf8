"""Plans for unlike robots: the cheapest fleet of given kinds, or those that a fleet lists, each with ground of its own.

Which robot does what is searched in two levels. Above, a fleet is chosen, and the ground is divided among its groups in
proportion to what each can see. Below, each part is planned as a mission of its own for robots that are alike, by all
that patrol has for these. What a part took, or by how much it missed its periods, tells what its group is really worth,
and the next division goes by that.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from rota.errors import NoPlanFound
from rota.model.anywhere import without_starts
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planners.patrol.bounds.best_bound import prove_bound
from rota.planners.patrol.ground.problem import common_robot, set_up_problem
from rota.planners.patrol.kinds.cheapest import plan_cheapest
from rota.planners.patrol.kinds.division import load_of
from rota.planners.patrol.kinds.groups import Group
from rota.planners.patrol.kinds.parts import Search
from rota.planners.patrol.kinds.starts import lead_groups
from rota.planners.patrol.kinds.team import Team
from rota.planning.planner import Request


def plan_with_kinds(request: Request, search: Search) -> Plan:
    """A plan for a fleet whose robots are not alike. search: plans for a mission whose robots are taken to be.

    Robots with bodies come to ground of their own from starts anywhere. Raises NoPlanFound where no division of the
    ground that was tried meets the demand, with the best plan there is, and where the starts are too near or too far.
    """
    mission = request.mission
    leads = mission.has_starts and any(robot.body_radius_m > 0 for robot in mission.fleet.unlike_robots)
    team = Team(replace(request, mission=without_starts(mission)) if leads else request, search)
    plan = plan_cheapest(team) if mission.fleet.kinds else plan_listed(team, search, mission)
    return lead_groups(plan, mission, request.judge) if leads and not plan.mission.has_starts else plan


def plan_listed(team: Team, search: Search, mission: Mission) -> Plan:
    """A plan for exactly the robots of the fleet: as if each were the weakest where that may do, else as what they are.

    search: plans for robots taken to be alike. mission: with the robots' starts, which the first of these heeds. Where
    a division of the ground fails, groups that missed their periods get less of it in the next one. Raises NoPlanFound
    where none meets the demand, with the best plan there is.
    """
    for region in team.regions:
        if not any(group.serves(region) for group in team.groups):
            raise NoPlanFound(f"zone {region.name}: no robot has a sensor that counts: {', '.join(region.sensors)}")
    if _may_do_as_weakest(team):
        try:
            return search(mission, in_full=True)
        except NoPlanFound:
            pass
    counts = np.array([len(group.robots) for group in team.groups], dtype=np.float64)
    least, best, why, wrong = math.inf, None, "nothing was tried", ""
    for number in range(team.tries):
        if number and team.should_stop():
            break
        team.tell(0.9 * number / team.tries, "dividing the ground among the robots")
        outcomes = team.plan_parts(team.divide(counts, number), in_full=True)
        ratios = np.array([outcome.ratio for outcome in outcomes])
        if all(outcome.robots for outcome in outcomes) and ratios.max() <= least:
            best, wrong = team.join(outcomes)
            if ratios.max() <= 1 and not wrong:
                return _with_bound(best, team)
        if ratios.max() < least:
            least, why = float(ratios.max()), outcomes[int(ratios.argmax())].why or wrong
        # who missed its periods is worth less than was thought
        team.worth = team.worth / np.clip(np.where(np.isfinite(ratios), ratios, 2.0), 1.0, 2.0)
    raise NoPlanFound(f"no division of the ground among unlike robots meets the demand: {why}", best=best)


def _may_do_as_weakest(team: Team) -> bool:
    """Whether robots all like the weakest may see all that is asked, and what each sees counts everywhere."""
    fleet = team.mission.fleet
    if team.mission.chargers or not all(group.serves(region) for group in team.groups for region in team.regions):
        return False
    weakest = Group(name="weakest", robot=common_robot(fleet))
    return sum(map(load_of, team.regions)) <= len(fleet.robots or ()) * weakest.swath_m2_s


def _with_bound(plan: Plan, team: Team) -> Plan:
    """The plan with the bound that holds for robots as good as the best of its fleet."""
    try:
        bound = prove_bound(set_up_problem(team.mission), tours=False)
    except NoPlanFound:  # the weakest robot sees nothing
        return plan
    return replace(plan, lower_bound_robots=bound.robots, lower_bound_reason=bound.reason)
