"""Unlike robots with bodies, led from their starts to ground of their own, over that of others where need be."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from rota.errors import NoPlanFound
from rota.model.anywhere import without_starts
from rota.model.mission import Mission, Robot
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.handover.charging.flights_from_starts import lead_to_flights, robots_at_starts
from rota.planners.patrol.kinds.groups import Group, groups_of
from rota.planners.patrol.traffic.starts.from_starts import lead_from_starts
from rota.planners.patrol.traffic.starts.one_by_one import set_out_in_turn
from rota.planners.patrol.verdict import Judge, worst_reached
from rota.routes.moments import delay

Ways = Sequence[Sequence[Trajectory]]  # of each group


def lead_groups(plan: Plan, mission: Mission, judge: Judge) -> Plan:
    """The plan's routes, reached from the mission's starts by each group of robots alike; its mission is ``mission``.

    Raises NoPlanFound where a group does not reach its routes, or the judge passes no plan, with the one judged last.
    """
    bare = replace(plan, mission=mission)
    named = replace(mission.fleet, kinds=(), robots=tuple(mission.fleet.robot(one.robot) for one in plan))
    robots = robots_at_starts(bare, replace(mission, fleet=named))
    groups = groups_of(replace(named, robots=tuple(robots), start=None))
    last = bare
    for ways in _orders([_lead_alone(bare, group) for group in groups], {robot.name: robot for robot in robots}):
        led = {one.robot: one for own in ways for one in own}
        last = replace(bare, trajectories=tuple(led[one.robot] for one in plan))
        if judge(last).verdict == "met":
            return last
    raise NoPlanFound(
        f"with the ways from the starts the plan does not pass the check: {worst_reached(judge(last))}", best=last
    )


def _lead_alone(plan: Plan, group: Group) -> tuple[Trajectory, ...]:
    """The routes of one group, reached from its starts as if it were there alone."""
    mission, names = plan.mission, [robot.name for robot in group.robots]
    charges = group.robot.battery.endurance_s is not None
    longest_s = max(period_s for period_s in (mission.period_s, *(zone.period_s for zone in mission.zones)) if period_s)
    alone = replace(
        mission, zones=(), period_s=longest_s, fleet=replace(group.fleet_of(mission.fleet), start=None),
        chargers=mission.chargers if charges else (),
    )  # fmt: skip
    own = tuple(one for one in plan if one.robot in names)
    lead = lead_to_flights if charges else lead_from_starts
    return lead(Plan(mission=without_starts(alone), trajectories=own, seed=plan.seed), alone, None).trajectories


def _orders(ways: Ways, robots: Mapping[str, Robot]) -> Iterator[Ways]:
    """All groups set out at once, or each as soon as bodies stay apart.

    Robots that only stay somewhere may have nothing to do, and stay at their starts at first.
    """
    at_starts = [[_stay_at_start(one, robots[one.robot]) for one in own] for own in ways]
    bodies_m = {name: robot.body_radius_m for name, robot in robots.items()}
    slowest_m_s = min(robot.ground_speed_m_s for robot in robots.values())
    for each in (at_starts, ways):
        yield each
        units = [partial(_delay_all, own) for own in each]
        if in_turn := set_out_in_turn(units, bodies_m, 4 * max(bodies_m.values()) / slowest_m_s):
            yield [in_turn]


def _delay_all(ways: Sequence[Trajectory], by_s: float) -> list[Trajectory]:
    """What a group drives, so much later."""
    return [delay(one, by_s) for one in ways]


def _stay_at_start(way: Trajectory, robot: Robot) -> Trajectory:
    """For a way that ends on the spot, with no charge: the start itself."""
    if way.loop_duration_s > 0 or way.charges or robot.start is None:
        return way
    return Trajectory(robot=way.robot, loop_start_s=0.0, times_s=np.zeros(1), positions_m=np.array([robot.start]))
