"""A run in stages: a plan is driven until a robot fails, then one for those that remain takes over."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rota.errors import RotaError
from rota.live.keeping import LATE_S
from rota.live.kernels import PlannedSights
from rota.model.arrays import Floats, Ints
from rota.model.plan import Plan, Trajectory
from rota.rehearsal import drive_kernels
from rota.rehearsal.chance import chance_of, wind_of
from rota.rehearsal.charging import copy_of, each_at_its_own, full_batteries, go_on_with
from rota.rehearsal.drive_kernels import Fills
from rota.rehearsal.kernels import Driven
from rota.rehearsal.least_times import least_times_s
from rota.rehearsal.scene import Scene, scene_with
from rota.replanning.replan import first_plan
from rota.vehicles.motion import Wind

IN_PHASE_S = 2 * LATE_S  # by which who is off the clock of all counts as being where its plan has it
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
    """How a stage begins: at which tick of the run, when for each robot (k,), at which time of the clock of all.

    fills: how batteries are then.
    """

    tick: int
    starts_s: Floats
    clock_s: float
    fills: Fills


def drive_in_stages(scene: Scene, seed: int, number: int) -> tuple[list[Stage], str | None]:
    """How all robots drive in the run of this number, and why nobody was replanned at last, where that was refused."""
    wind, count = wind_of(scene, seed, number), len(scene.plan.trajectories)
    begin = _Begin(tick=0, starts_s=np.zeros(count), clock_s=0.0, fills=full_batteries(scene))
    stages: list[Stage] = []
    now, plan, lost = scene, scene.plan, frozenset[int]()
    while True:
        drive = _Drive(now, wind, seed, number, begin)
        found = _next_takeover(drive.driven, drive.clocks_s, lost) if scene.conditions.replan else None
        refusal = None
        if found is not None:
            tick, fresh = found
            lost |= fresh
            ticks = drive.own_ticks(tick, lost)
            fills = drive.fills_at(ticks)
            try:
                plan = _plan_for_those_left(plan, drive.scene, ticks, fills, fresh, lost)
            except RotaError as error:
                found, refusal = None, str(error)
        if found is None:
            stages.append(Stage(scene=now, driven=drive.driven, fills=drive.fills, until_s=np.full(count, np.inf)))
            return stages, refusal
        until_s = drive.driven.times_s[np.arange(count), ticks]
        stages.append(Stage(scene=now, driven=drive.driven, fills=fills, until_s=until_s))
        now = scene_with(now, _plan_of_all(now, plan, drive.driven))
        begin = _Begin(
            tick=begin.tick + tick, starts_s=until_s, clock_s=float(drive.clocks_s[tick]),
            fills=go_on_with(fills, now),
        )  # fmt: skip


class _Drive:
    """How a plan is driven from its beginning on; clocks_s: the clock of all at each tick."""

    def __init__(self, scene: Scene, wind: Wind, seed: int, number: int, begin: _Begin) -> None:
        self.scene, self._begin = scene, begin
        self._chance = chance_of(scene, wind, seed, number, int(begin.fills.left.max(initial=0)))
        self._least_s = least_times_s(scene.plan, wind, scene.tick_s, scene.ticks - begin.tick)
        times_s, self.clocks_s, self.fills = self._until(self._least_s.shape[1])
        self.driven = Driven(
            times_s=times_s,
            tick_s=scene.tick_s,
            loops_s=np.array([way.loop_duration_s for way in scene.plan], np.float64),
            fails_s=self._chance.fails_s,
            begin_s=scene.begin_s,
            end_s=scene.end_s,
        )

    def _until(self, ticks: int) -> tuple[Floats, Floats, Fills]:
        """So many ticks: when robots are where their plans have them, the clock of all, and batteries in the end."""
        begin, fills = self._begin, copy_of(self._begin.fills)
        times_s, clocks_s = drive_kernels.drive(
            self._least_s[:, :ticks], self._chance, self.scene.batteries, fills, self.scene.tick_s, begin.tick,
            begin.starts_s, begin.clock_s,
        )  # fmt: skip
        return times_s, clocks_s, fills

    def own_ticks(self, tick: int, lost: frozenset[int]) -> Ints:
        """Which tick of its plan each robot (k,) has come to when the clock of all has come to this one."""
        ticks = np.full(len(self.driven.times_s), tick)
        for robot, times_s in enumerate(self.driven.times_s):
            if robot not in lost and abs(times_s[tick] - self.clocks_s[tick]) > IN_PHASE_S:
                ticks[robot] = min(np.searchsorted(times_s, self.clocks_s[tick]), len(times_s) - 1)
        return ticks

    def fills_at(self, ticks: Ints) -> Fills:
        """How batteries are at a tick of its own for each robot (k,)."""
        if not self.scene.charges:
            return self.fills
        then = {tick: self._until(tick)[2] for tick in set(ticks.tolist())}
        return each_at_its_own([then[tick] for tick in ticks.tolist()])


def _plan_for_those_left(
    plan: Plan, scene: Scene, ticks: Ints, fills: Fills, fresh: frozenset[int], lost: frozenset[int]
) -> Plan:
    """The plan for those that remain, as `rota replan` first finds it; RotaError where there is none.

    ticks: (k,) to which each has come: who is behind the others is late. fills: how full batteries are then.
    """
    names = [way.robot for way in scene.plan]
    left = [robot for robot in range(len(names)) if robot not in lost]
    first = int(ticks[left].max())
    full_s = scene.batteries.endurance_s.tolist()
    return first_plan(
        plan,
        at_s=first * scene.tick_s,
        lost=[names[robot] for robot in sorted(fresh)],
        late={names[robot]: (first - int(ticks[robot])) * scene.tick_s for robot in left if ticks[robot] < first},
        battery={
            names[robot]: float(np.clip(fills.levels_s[robot] / full_s[robot], 0.0, 1.0))
            for robot in left
            if math.isfinite(full_s[robot])
        },
    )


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
