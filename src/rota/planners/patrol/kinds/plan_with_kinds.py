"""Plans for unlike robots: the cheapest fleet of given kinds, or those that a fleet lists, each with ground of its own.

Which robot does what is searched in two levels. Above, a fleet is chosen, and the ground is divided among its groups in
proportion to what each can see. Below, each part is planned as a mission of its own for robots that are alike, by all
that patrol has for these. What a part took, or by how much it missed its periods, tells what its group is really worth,
and the next division goes by that.
"""

from __future__ import annotations

from rota.model.plan import Plan
from rota.planners.patrol.kinds.cheapest import plan_cheapest
from rota.planners.patrol.kinds.listed import plan_listed
from rota.planners.patrol.kinds.parts import Search
from rota.planners.patrol.kinds.team import Team
from rota.planning.planner import Request


def plan_with_kinds(request: Request, search: Search) -> Plan:
    """A plan for a fleet whose robots are not alike. search: plans for a mission whose robots are taken to be.

    Raises NoPlanFound where no division of the ground that was tried meets the demand, with the best plan there is.
    """
    team = Team(request, search)
    return plan_cheapest(team) if request.mission.fleet.kinds else plan_listed(team, search)
