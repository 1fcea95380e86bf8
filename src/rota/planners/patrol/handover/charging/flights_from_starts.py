"""Robots that charge, led from their starts into a plan's flights, as new robots come into a plan that takes over."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain, cycle, islice

import numpy as np

from rota.errors import NoPlanFound
from rota.model.mission import Mission, Robot, StartPoints
from rota.model.plan import Plan, Trajectory
from rota.model.seam import Seam
from rota.planners.patrol.driving.timed_line import round_of
from rota.planners.patrol.handover.charging.flyers import fills_s
from rota.planners.patrol.handover.charging.takeovers import takeovers_with_chargers
from rota.planners.patrol.relief.ways import pause_s
from rota.planners.patrol.tolerances import SHORTEST_S
from rota.planners.patrol.traffic.starts.assignment import earliest_assignment, least_sum
from rota.planners.patrol.traffic.starts.from_starts import entry_choices, starts_of, travel_times_s
from rota.planners.patrol.traffic.starts.one_by_one import set_out_in_turn
from rota.planners.patrol.traffic.starts.paths_by_body import PathsByBody
from rota.planners.patrol.verdict import Judge, worst_reached
from rota.planning.planner import Handover
from rota.routes.moments import delay, go_on

TRIED = 12  # plans that are judged, each also with robots that wait at their starts


def lead_to_flights(plan: Plan, mission: Mission, judge: Judge | None) -> Plan:
    """The plan's flights, reached from the mission's starts with full batteries; its mission becomes ``mission``.

    Who has no start of its own stands on a charger. Of the plans that the judge passes (None: whatever becomes of them)
    it is the one in which the last robot is on its round soonest. Raises NoPlanFound where there are too few starts, or
    robots reach neither flights nor chargers, with the plan as it was; and where none passes, with the first of them.
    """
    bare, robots = replace(plan, mission=mission), robots_at_starts(plan, mission)
    found = sorted(islice(_set_out_at_once(bare, robots), TRIED), key=_last_joins_s)
    if not found:
        raise NoPlanFound("from their starts the robots reach neither their flights nor a charger in time", best=bare)
    at_once = (each for led in found for each in (led, _waiting_at_starts(led)))
    in_turn = _set_out_in_turn(bare, robots)
    for led in chain(in_turn, at_once) if judge is None else chain(at_once, in_turn):
        if judge is None or judge(led).verdict == "met":
            return led
    assert judge is not None, "one would have been taken"
    raise NoPlanFound(
        f"with the ways from the starts the plan does not pass the check: {worst_reached(judge(found[0]))}",
        best=found[0],
    )


def _set_out_at_once(plan: Plan, robots: Sequence[Robot]) -> Iterator[Plan]:
    """Plans whose robots come from their starts as soon as each can."""
    for found in takeovers_with_chargers(_handover(plan, robots, plan.trajectories, 1.0)):
        yield replace(plan, trajectories=found.trajectories)


def _set_out_in_turn(plan: Plan, robots: Sequence[Robot]) -> Iterator[Plan]:
    """The plan whose robots wait at their starts while bodies would touch; each has the round that begins nearest."""
    bodies_m = {robot.name: robot.body_radius_m for robot in robots}
    if not any(bodies_m.values()) or len(robots) != len(plan):
        return
    begins_m, starts_m = (
        np.array([one.at(0.0)[:2] for one in plan]), np.array([robot.start or (0.0, 0.0) for robot in robots])
    )  # fmt: skip
    away_m = np.hypot(*(starts_m[:, None] - begins_m[None]).transpose(2, 0, 1))
    units = [partial(_alone, plan, robots[k], plan.trajectories[i]) for k, i in zip(*least_sum(away_m), strict=True)]
    slowest_m_s = min(robot.ground_speed_m_s for robot in robots)
    ways = {one.robot: one for one in set_out_in_turn(units, bodies_m, 4 * max(bodies_m.values()) / slowest_m_s)}
    if ways:
        yield replace(plan, trajectories=tuple(ways[robot.name] for robot in robots))


def _alone(plan: Plan, robot: Robot, loop: Trajectory, later_s: float) -> list[Trajectory]:
    """What one robot drives that waits at its start for so long and then comes into a loop; nothing: it cannot."""
    battery = robot.battery
    level = 1.0 - later_s * battery.standing_uses / (battery.endurance_s or math.inf)
    if level <= 0 or (later_s > 0 and not battery.can_stand):
        return []
    asked = _handover(plan, [robot], (go_on(loop, later_s),), level)
    found = next(takeovers_with_chargers(asked), None)
    return [] if found is None else [replace(delay(found.trajectories[0], later_s), battery=1.0)]


def _handover(plan: Plan, robots: Sequence[Robot], loops: tuple[Trajectory, ...], battery: float) -> Handover:
    """Robots that stand at their starts come into loops whose clocks are at 0."""
    fleet = replace(plan.mission.fleet, robots=tuple(robots), start=None)
    placed = {robot.name: robot.start for robot in robots if robot.start is not None}
    return Handover(
        mission=replace(plan.mission, fleet=fleet), places=placed, seam=Seam(at_s=0.0, driven=()), seed=plan.seed,
        going_on={}, loops=loops, lateness=_last_joins_s, most=TRIED, batteries=dict.fromkeys(placed, battery),
    )  # fmt: skip


def _last_joins_s(plan: Plan) -> tuple[float, ...]:
    """When the last robot is on its round."""
    return (max(one.loop_start_s for one in plan),)


def robots_at_starts(plan: Plan, mission: Mission) -> list[Robot]:
    """A robot for each trajectory, by its name or the fleet's, at its start; of more starts those sooner there."""
    rounds = [round_of(trajectory) for trajectory in plan]
    paths = PathsByBody(mission)
    starts = starts_of(mission, rounds, paths, plan)
    robots, places_m = starts.robots, starts.places_m
    if isinstance(mission.fleet.start, StartPoints):
        nearest = earliest_assignment(travel_times_s(starts, entry_choices(rounds, starts), paths)[0])
        if nearest is None:
            raise NoPlanFound("from their starts the robots cannot reach their routes", best=plan)
        robots = [mission.fleet.robot(one.robot) for one in plan]
        places_m = [places_m[k] for k in nearest]
    pads = cycle([charger.at for charger in mission.chargers for _ in range(charger.places)] or [None])
    return [
        replace(robot, start=next(pads) if place is None else (float(place[0]), float(place[1])))
        for robot, place in zip(robots, places_m, strict=True)
    ]


def _waiting_at_starts(plan: Plan) -> Plan:
    """The plan whose robots come to a charger from their starts only when they have to: others need its places."""
    mission = plan.mission
    waiting = tuple(_waiting(one, mission.fleet.robot(one.robot), mission) for one in plan)
    return replace(plan, trajectories=waiting)


def _waiting(way: Trajectory, robot: Robot, mission: Mission) -> Trajectory:
    """A robot's way with as long a wait at its start as its first stay on a charger has time to spare."""
    first, battery = next(iter(way.charges), None), robot.battery
    if first is None or not SHORTEST_S < first.from_s < way.loop_start_s or not battery.can_stand:
        return way
    charger = next(one for one in mission.chargers if one.name == first.charger)
    took_s = first.from_s * max(1.0, battery.standing_uses)
    needs_s = max(battery.grounding_s, pause_s(robot)) + fills_s(robot, charger, took_s)
    # while it waits it may take from its battery, which is charged again
    each_s = 1 + (0.0 if charger.swap_s is not None else fills_s(robot, charger, battery.standing_uses))
    waits_s = (first.until_s - first.from_s - needs_s) / each_s
    if waits_s <= SHORTEST_S:
        return way
    arrives = int(np.searchsorted(way.times_s, first.from_s))
    times_s = np.concatenate([[0.0], way.times_s[: arrives + 1] + waits_s, way.times_s[arrives + 1 :]])
    changes = way.accelerations_m_s2
    return replace(
        way, times_s=times_s, positions_m=np.vstack([way.positions_m[:1], way.positions_m]),
        accelerations_m_s2=None if changes is None else np.append(0.0, changes),
        charges=(replace(first, from_s=first.from_s + waits_s), *way.charges[1:]),
    )  # fmt: skip
