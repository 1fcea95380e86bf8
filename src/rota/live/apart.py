"""Which robots of a plan can wait without the others, and which are waited for at all."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from rota.check.revisits import worst_gaps_s
from rota.live.places import places_of
from rota.model.plan import Plan
from rota.routes.flights import flights_of, has_flights
from rota.routes.served_loops import service_of
from rota.routes.who_relieves import robots_that_relieve

MOST_PLACES = 4_000  # at which it is looked whether one team alone sees them in time
MET = 1 + 1e-9  # times its period


def teams_apart(plan: Plan) -> dict[str, int]:
    """The number of each robot's team, by names: a team may wait for a late relief while others go on.

    Robots are of one team that take turns at a loop, that share a charger with fewer places than robots, or without
    which some place is not seen in time: then it matters how they follow each other. All are in swarms, where
    bodies are to be kept apart, where zones are to be visited, and where nobody charges.
    """
    teams = {way.robot: k for k, way in enumerate(plan)}
    visits = any(zone.demand == "visit" for zone in plan.mission.zones)
    charge = [way for way in plan if has_flights(way)]
    if visits or _keep_apart(plan) or not charge:
        return dict.fromkeys(teams, 0)
    for loop in service_of([flight for way in charge for flight in flights_of(way)]).loops:
        _join(teams, loop.robots)
    for pad in plan.mission.chargers:
        users = [way.robot for way in charge if any(stay.charger == pad.name for stay in way.charges)]
        if len(users) > pad.places:
            _join(teams, users)
    _join_by_sight(plan, teams)
    return teams


def robots_waited_for(plan: Plan) -> frozenset[str]:
    """The names of robots for which others wait when they are late: all that do not charge, or relieve somebody.

    Others, as on circuits, are launched by themselves. In swarms, and where bodies are to be kept apart, all are waited
    for.
    """
    names = frozenset(way.robot for way in plan)
    if _keep_apart(plan):
        return names
    return names - {way.robot for way in plan if has_flights(way)} | robots_that_relieve(plan)


def _keep_apart(plan: Plan) -> bool:
    """Whether it matters to bodies, or to a swarm, how far each robot is."""
    bodies = any(plan.mission.fleet.robot(way.robot).body_radius_m > 0 for way in plan)
    return plan.mission.planning.makes_runs or bodies


def _join(teams: dict[str, int], names: Iterable[str]) -> None:
    """Make one team of all teams of these robots."""
    joined = {teams[name] for name in names}
    for name, team in teams.items():
        if team in joined:
            teams[name] = min(joined)


def _join_by_sight(plan: Plan, teams: dict[str, int]) -> None:
    """Make one team of those that see a place in time together alone."""
    places = places_of(plan.mission, MOST_PLACES)
    points_m = places.points_m[: places.points]
    while len(numbers := sorted(set(teams.values()))) > 1:
        own = [
            replace(plan, trajectories=tuple(way for way in plan if teams[way.robot] == k), seam=None) for k in numbers
        ]
        gaps_s = np.array([worst_gaps_s(each, points_m) for each in own])
        together = (gaps_s.min(axis=0) > places.periods_s[: places.points] * MET) & (
            np.isfinite(gaps_s).sum(axis=0) > 1
        )
        if not together.any():
            return
        seeing = {numbers[k] for k in np.flatnonzero((gaps_s[:, together] < math.inf).any(axis=1))}
        _join(teams, [name for name, team in teams.items() if team in seeing])
