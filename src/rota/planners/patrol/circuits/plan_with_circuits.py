"""Plans of robots that charge and fly circuits, each launched from its charger as often as its ground asks."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Protocol

import numpy as np

from rota.errors import NoPlanFound
from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.circuits.ground import Circuit, circuits_of, grounds_of, without_seen
from rota.planners.patrol.circuits.launches import Ring, fewest_rings
from rota.planners.patrol.relief.flights import robot_of_jobs
from rota.planners.patrol.relief.relieve import MOST_TRIES
from rota.planners.patrol.traffic.starts.paths_by_body import PathsByBody
from rota.planners.patrol.verdict import Judge, worst_reached


class SearchPart(Protocol):
    """How the loop of one robot over some ground is found, between two shares of the whole progress."""

    def __call__(self, part: Mission, /, *, begin: float, end: float) -> Plan:
        """A plan whose only robot comes past all of it; NoPlanFound where there is none."""


def plan_with_circuits(mission: Mission, *, most: int, seed: int, judge: Judge, search: SearchPart) -> Plan:
    """The plan whose robots fly circuits, with as few of them as can be found, ``most`` at most.

    A fleet of named robots keeps all of them. Raises NoPlanFound where that takes more, where circuits are too long for
    the batteries, chargers have too few places, and where the judge passes no plan.
    """
    body_radius_m = mission.fleet.equal_robot("robot-1").body_radius_m
    circuits = all_circuits(mission, PathsByBody(mission).paths(body_radius_m), search)
    found: Plan | None = None
    for number in range(MOST_TRIES if body_radius_m > 0 else 1):
        robots = _trajectories(circuits, mission, most, seed + number if number else 0)
        found = Plan(mission=mission, trajectories=tuple(robots))
        if judge(found).verdict == "met":
            return found
    assert found is not None
    raise NoPlanFound(f"with circuits the plan does not pass the check: {worst_reached(judge(found))}", best=found)


def all_circuits(mission: Mission, paths: ShortestPaths, search: SearchPart) -> list[Circuit]:
    """The circuits of the ground of each period, ascending; each leaves out what those before it see on their way."""
    circuits: list[Circuit] = []
    grounds = grounds_of(mission)
    for k, ground in enumerate(grounds):
        left = without_seen(ground, circuits, mission) if circuits else ground
        if left.regions:
            own = partial(search, begin=k / len(grounds), end=(k + 1) / len(grounds))
            circuits += circuits_of(left, mission, paths, own)
    return circuits


def _trajectories(circuits: Sequence[Circuit], mission: Mission, most: int, seed: int) -> list[Trajectory]:
    """The robots that fly circuits, those of each charger by themselves; of named ones nobody is left out."""
    named, battery = mission.fleet.robots, mission.fleet.battery
    of_chargers = [[each for each in circuits if each.charger is charger] for charger in mission.chargers]
    of_chargers = [own for own in of_chargers if own]
    dealt: list[list[Ring]] = []
    for own in of_chargers:
        dealt.append(fewest_rings(own, battery, least=1, most=most - _robots(dealt), seed=seed))
    if named and (to_spare := len(named) - _robots(dealt)) > 0:
        first = _robots(dealt[:1]) + to_spare
        dealt[0] = fewest_rings(of_chargers[0], battery, least=first, most=first, seed=seed)
    made: list[Trajectory] = []
    for own, rings in zip(of_chargers, dealt, strict=True):
        require_places(own, rings)
        for ring in rings:
            jobs = [(launch.begins_s, own[launch.circuit].line) for launch in ring.launches]
            for k in range(ring.robots):
                later = [(begins_s + k * ring.turn_s, line) for begins_s, line in jobs]
                name = named[len(made)].name if named else f"robot-{len(made) + 1}"
                made.append(robot_of_jobs(name, [own[0].charger], later, ring.lasts_s))
    return made


def _robots(dealt: Sequence[Sequence[Ring]]) -> int:
    """How many robots fly these rings."""
    return sum(ring.robots for rings in dealt for ring in rings)


def require_places(circuits: Sequence[Circuit], rings: Sequence[Ring]) -> None:
    """NoPlanFound where more robots than the charger of these circuits has places for are there at once."""
    charger, robots = circuits[0].charger, _robots([rings])
    turn_s = rings[0].turn_s
    begins_s = np.array([launch.begins_s for ring in rings for launch in ring.launches])
    lasts_s = np.array([circuits[launch.circuit].line.duration_s for ring in rings for launch in ring.launches])
    moments_s = np.mod(np.concatenate([begins_s, begins_s + lasts_s]), turn_s)
    flown_s = np.mod(moments_s[:, None] - begins_s[None], turn_s)  # since each launch of this turn
    in_air = np.maximum(0, np.ceil((lasts_s[None] - flown_s) / turn_s)).sum(axis=1)
    if robots - int(in_air.min()) > charger.places:
        raise NoPlanFound(f"charger {charger.name!r} has {charger.places} places, {robots - int(in_air.min())} needed")
