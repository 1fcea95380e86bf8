"""The loop of a swarm that charges: the longest round that batteries last for and that the swarm gets done in time."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from rota.errors import NoPlanFound
from rota.model.arrays import Floats, Ints
from rota.model.mission import Mission
from rota.model.plan import Charge, Trajectory
from rota.planners.swarm.charging.super_period import Outcome, Schedule, SuperPeriod, keep_m
from rota.planners.swarm.charging.turns import Allowed, Needs, Roster, Turns, needs_of, roster_of, turns_of
from rota.planners.swarm.charging.ways import Ways
from rota.planners.swarm.rollout import Swarm
from rota.planners.swarm.state import Guide
from rota.planners.swarm.trajectory_log import TrajectoryLog

SPREADING_SHARE = 0.5  # of what batteries may use: for so long robots spread at most before the first round begins
LEEWAY = 1.25  # times as long as the way alone takes, since others are in it
STEPS_MORE = 4  # of time, for what begins and ends within steps
TRIES = 5  # each with more time for the ways than the one before took


def guide_of(mission: Mission, swarm: Swarm) -> Guide:
    """A guide that sends nobody anywhere, and keeps all off the chargers."""
    n = len(swarm)
    return Guide(
        targets_m=np.full((n, 2), np.nan),
        may_enter=np.full(n, -1, np.int64),
        pads_m=np.array([charger.at for charger in mission.chargers], np.float64),
        keep_m=keep_m(float(swarm.kinds.body_m.max())),
    )


def most_spreading_steps(mission: Mission, step_s: float) -> float:
    """After how many steps robots must have spread; inf where none charges."""
    robots = tuple(robot for robot in mission.fleet.robots or () if robot.battery.endurance_s is not None)
    if not mission.chargers:
        return math.inf
    usable_s = needs_of(robots, mission.chargers[:1] * len(robots)).usable_s
    return max(1.0, math.floor(SPREADING_SHARE * float(usable_s.min()) / step_s))


def make_rounds(
    mission: Mission,
    begun: Callable[[], tuple[Swarm, TrajectoryLog]],
    progress: Callable[[float, str], None],
    should_stop: Callable[[], bool],
) -> tuple[Trajectory, ...]:
    """Trajectories of robots that have spread and then charge in turns for ever.

    begun: gives the swarm where it has spread to, and its log, each time anew. Raises NoPlanFound where chargers or
    batteries cannot suffice, where robots hold each other up, and where ``should_stop`` says so.
    """

    def on_step(doing: str) -> None:
        if should_stop():
            raise NoPlanFound("the search was stopped before the round in which robots charge was planned")
        progress(1.0, doing)

    robots = mission.fleet.robots or ()
    users = np.array([k for k, robot in enumerate(robots) if robot.battery.endurance_s is not None])
    own = tuple(robots[k] for k in users)
    swarm, log = begun()
    wider_m = float(swarm.kinds.body_m.max()) - max(robot.body_radius_m for robot in robots)
    ways = Ways(mission, max(0.0, wider_m))
    step_s, rooms = swarm.rule.time_step_s, np.array([charger.places for charger in mission.chargers])
    ways_s = ways.lasts_s(own, swarm.places_m[users], np.array([charger.at for charger in mission.chargers]))
    needs = needs_of(own, mission.chargers)
    allowed = _times_allowed(mission, swarm, ways_s)
    for number in range(TRIES):
        turns = turns_of(needs, int(rooms.sum()), allowed)
        roster = roster_of(ways_s, rooms, turns)
        if not number:
            farthest_s = LEEWAY * float(ways_s[roster.robot, roster.charger].max()) + STEPS_MORE * step_s
            allowed = replace(allowed, in_s=farthest_s, out_s=farthest_s)
            turns = turns_of(needs, int(rooms.sum()), allowed)
            roster = roster_of(ways_s, rooms, turns)
        schedule = _in_steps(turns, roster, users, allowed, step_s)
        if number:
            swarm, log = begun()
        doing = partial(on_step, f"a round of {turns.round_s:.0f} s, try {number + 1}")
        outcome = SuperPeriod(mission, swarm, log, schedule, ways).run(doing)
        late_in_s, late_out_s = _lateness_s(outcome, schedule, turns, needs, users, step_s)
        if max(late_in_s, late_out_s) <= 0:
            return _trajectories(mission, log, outcome, step_s)
        allowed = replace(
            allowed,
            in_s=allowed.in_s + LEEWAY * max(0.0, late_in_s),
            out_s=allowed.out_s + LEEWAY * max(0.0, late_out_s),
        )
    raise NoPlanFound(
        f"robots come {max(late_in_s, late_out_s):.0f} s too late to chargers or home in rounds of"
        f" {turns.round_s:.0f} s, and so they did in {TRIES - 1} with less time for ways: more room is needed"
    )


def _times_allowed(mission: Mission, swarm: Swarm, ways_s: Floats) -> Allowed:
    """Times that are allowed for if all go to the nearest charger from where they have spread to.

    ways_s: (n, m) to each charger.
    """
    step_s = swarm.rule.time_step_s
    nearest_s = ways_s.min(axis=1)
    farthest_s = LEEWAY * float(nearest_s[np.isfinite(nearest_s)].max(initial=0.0)) + STEPS_MORE * step_s
    slowest_m_s = min(robot.ground_speed_m_s for robot in mission.fleet.robots or ())
    clears_s = 2 * keep_m(float(swarm.kinds.body_m.max())) / slowest_m_s + STEPS_MORE * step_s
    rooms = [charger.places for charger in mission.chargers]
    return Allowed(
        in_s=farthest_s,
        out_s=farthest_s,
        between_s=clears_s * min(max(rooms), len(ways_s)),
        spread_s=swarm.steps * step_s,
    )


def _in_steps(turns: Turns, roster: Roster, users: Ints, allowed: Allowed, step_s: float) -> Schedule:
    """The turns and who takes them, in steps."""
    return Schedule(
        robot=users[roster.robot],
        charger=roster.charger,
        leaves=np.floor(turns.begins_s / step_s).astype(np.int64),
        until=np.ceil(turns.ends_s / step_s).astype(np.int64),
        period=math.ceil(turns.period_s / step_s),
        ready=math.ceil(turns.ready_s / step_s),
        home=math.ceil(allowed.out_s / step_s),
    )


def _lateness_s(
    outcome: Outcome, schedule: Schedule, turns: Turns, needs: Needs, users: Ints, step_s: float
) -> tuple[float, float]:
    """How much too late robots came to chargers, and home, at most; below 0: early."""
    short_s = turns.charge_s - (schedule.until - outcome.came) * step_s
    first = np.array([outcome.stays[outcome.stays[:, 0] == k, 2].min() for k in users])
    late_out_s = (outcome.end - outcome.begin - schedule.period) * step_s
    return float(max(short_s.max(), (first * step_s - needs.usable_s).max())), float(late_out_s)


def _trajectories(mission: Mission, log: TrajectoryLog, outcome: Outcome, step_s: float) -> tuple[Trajectory, ...]:
    """Trajectories of the way that was logged, with the stays at chargers, and the super-period as their loop."""
    names = [robot.name for robot in mission.fleet.robots or ()]
    stays: dict[int, list[Charge]] = defaultdict(list)
    for k, q, came, left in outcome.stays.tolist():
        stays[k].append(Charge(charger=mission.chargers[q].name, from_s=came * step_s, until_s=left * step_s))
    return tuple(
        replace(one, loop_start_s=outcome.begin * step_s, charges=tuple(stays[k]))
        for k, one in enumerate(log.trajectories(names, step_s))
    )
