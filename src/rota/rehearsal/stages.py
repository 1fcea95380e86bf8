"""A run in stages: a plan is driven until a robot fails, then one for those that remain takes over."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.errors import MissionError, RotaError
from rota.live.kernels import PlannedSights
from rota.model.plan import Plan, Trajectory
from rota.rehearsal import drive_kernels
from rota.rehearsal.chance import chance_of, wind_of
from rota.rehearsal.charging import full_batteries
from rota.rehearsal.drive_kernels import Fills
from rota.rehearsal.kernels import Driven
from rota.rehearsal.least_times import least_times_s
from rota.rehearsal.scene import Scene, scene_with
from rota.replanning.replan import replan
from rota.vehicles.motion import Wind

Floats = NDArray[np.float64]

TAKES_OVER_S = 15.0  # after a failure: `rota watch` notes it after 5 s of silence, and its plans take over 10 s later


@dataclass(frozen=True, kw_only=True, eq=False)
class Stage:
    """What is driven by one plan, that of the scene. until_s: (k,) when each robot goes over to the next one's."""

    scene: Scene
    driven: Driven
    fills: Fills
    until_s: Floats


@dataclass(frozen=True, kw_only=True, eq=False)
class _Begin:
    """How a stage begins: at which tick of the run, when for each robot (k,), and at which time of the clock of all."""

    tick: int
    starts_s: Floats
    clock_s: float


def drive_in_stages(scene: Scene, seed: int, number: int) -> tuple[list[Stage], str | None]:
    """How all robots drive in the run of this number, and why nobody was replanned at last, where that was refused."""
    wind, count = wind_of(scene, seed, number), len(scene.plan.trajectories)
    begin = _Begin(tick=0, starts_s=np.zeros(count), clock_s=0.0)
    stages: list[Stage] = []
    now, plan, lost = scene, scene.plan, frozenset[int]()
    while True:
        driven, fills, clocks_s = _drive(now, wind, seed, number, begin)
        found = _next_takeover(driven, clocks_s, lost) if scene.conditions.replan else None
        refusal = None
        if found is not None:
            tick, fresh = found
            try:
                if scene.charges:  # a new plan would have to begin with batteries as they are
                    raise MissionError("chargers: robots that charge are not replanned in rehearsals")
                names = [scene.plan.trajectories[robot].robot for robot in sorted(fresh)]
                at_s = tick * scene.tick_s
                plan = replan(plan, at_s=at_s, lost=names, should_stop=lambda: True).plan
            except RotaError as error:
                found, refusal = None, str(error)
        if found is None:
            stages.append(Stage(scene=now, driven=driven, fills=fills, until_s=np.full(count, np.inf)))
            return stages, refusal
        until_s = driven.times_s[:, tick].copy()
        stages.append(Stage(scene=now, driven=driven, fills=fills, until_s=until_s))
        now, lost = scene_with(now, _plan_of_all(now, plan, driven)), lost | fresh
        begin = _Begin(tick=begin.tick + tick, starts_s=until_s, clock_s=float(clocks_s[tick]))


def _drive(scene: Scene, wind: Wind, seed: int, number: int, begin: _Begin) -> tuple[Driven, Fills, Floats]:
    """How a plan is driven from its beginning on, batteries, and the clock of all at each tick."""
    chance, fills = chance_of(scene, wind, seed, number), full_batteries(scene)
    least_s = least_times_s(scene.plan, wind, scene.tick_s, scene.ticks - begin.tick)
    times_s, clocks_s = drive_kernels.drive(
        least_s, chance, scene.batteries, fills, scene.tick_s, begin.tick, begin.starts_s, begin.clock_s
    )
    driven = Driven(
        times_s=times_s,
        tick_s=scene.tick_s,
        loops_s=np.array([way.loop_duration_s for way in scene.plan], np.float64),
        fails_s=chance.fails_s,
        begin_s=scene.begin_s,
        end_s=scene.end_s,
    )
    return driven, fills, clocks_s


def _next_takeover(driven: Driven, clocks_s: Floats, lost: frozenset[int]) -> tuple[int, frozenset[int]] | None:
    """The tick at which a plan takes over since robots have failed, and which; None: no more in this run."""
    left = [robot for robot in range(len(driven.fails_s)) if robot not in lost]
    fails_s = min((float(driven.fails_s[robot]) for robot in left), default=math.inf)
    fresh = frozenset(robot for robot in left if driven.fails_s[robot] <= fails_s)
    tick = int(np.searchsorted(clocks_s, fails_s)) + math.ceil(TAKES_OVER_S / driven.tick_s)
    if len(fresh) == len(left) or tick >= len(clocks_s) or clocks_s[tick] >= driven.end_s:
        return None
    return tick, fresh


def _plan_of_all(scene: Scene, plan: Plan, driven: Driven) -> Plan:
    """A plan for robots that remain with those that are lost as well, which stand where they failed."""
    lines = {way.robot: way for way in plan}
    ways = []
    for robot, before in enumerate(scene.plan):
        if before.robot not in lines:
            ticks = driven.tick_s * np.arange(driven.times_s.shape[1])
            place_m = before.at(np.interp(driven.fails_s[robot], driven.times_s[robot], ticks))
            lines[before.robot] = Trajectory(robot=before.robot, times_s=np.zeros(1), positions_m=place_m[None])
        ways.append(lines[before.robot])
    return Plan(mission=scene.plan.mission, trajectories=tuple(ways), seed=plan.seed)


def join(stages: list[Stage]) -> tuple[PlannedSights, Driven]:
    """All stages as one: the robots of each count as robots of their own, which fail where they go over to the next."""
    if len(stages) == 1:
        return stages[0].scene.sights, stages[0].driven
    count, first = len(stages[0].until_s), stages[0].driven
    times_s = np.empty((len(stages) * count, first.times_s.shape[1]))
    for k, stage in enumerate(stages):
        own, rows = stage.driven.times_s, times_s[k * count : (k + 1) * count]
        rows[:, : own.shape[1]], rows[:, own.shape[1] :] = own, own[:, -1:]
    driven = first._replace(
        times_s=times_s,
        loops_s=np.concatenate([stage.driven.loops_s for stage in stages]),
        fails_s=np.concatenate([np.minimum(stage.driven.fails_s, stage.until_s) for stage in stages]),
    )
    parts = [stage.scene.sights for stage in stages]
    places = np.concatenate([np.repeat(np.arange(len(one.offsets) - 1), np.diff(one.offsets)) for one in parts])
    order = np.argsort(places, kind="stable")
    robots = np.concatenate([one.robots + k * count for k, one in enumerate(parts)])
    return PlannedSights(
        offsets=np.sum([one.offsets for one in parts], axis=0),
        robots=robots[order],
        starts_s=np.concatenate([one.starts_s for one in parts])[order],
        ends_s=np.concatenate([one.ends_s for one in parts])[order],
        again=np.concatenate([one.again for one in parts])[order],
    ), driven
