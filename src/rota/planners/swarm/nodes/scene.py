"""What all robots of a swarm of processes share before they start: map, starts, what each is like, and the rules."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rota.cells.importance_cells import ImportanceCells
from rota.errors import MissionError
from rota.geometry.free_space import free_ground
from rota.model.arrays import Floats
from rota.model.mission import Mission
from rota.planners.swarm.importance_field import importance_for
from rota.planners.swarm.nodes.apart import RADIO_SILENCES, least_radio_m
from rota.planners.swarm.nodes.hearing import Start
from rota.planners.swarm.nodes.telling import LONGEST_HOLD_NS, MOST_ROBOTS, swarm_number
from rota.planners.swarm.planner import DECIDE, fleet_of, rule_of
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.sensing import sensors_of, squares_of
from rota.planners.swarm.settle_kernels import decide_settle
from rota.planners.swarm.starts import place_starts
from rota.planners.swarm.state import FleetKinds, Grid, Kinds, Rule
from rota.planners.swarm.world import make_grid, walls_of
from rota.planning.robot_processes import HeightAt, level

SILENT_PERIODS, LEAST_SILENT_PERIODS = 5, 4  # after which a robot that tells nothing is forgotten
HOLD_SHARE = 0.98  # of the time between decisions; robots that decide late by the rest of it keep their rate
# of simulations, where news are late only because a mission says so
OF_SIMULATIONS = {"delay_steps": 0, "messages_lost": 0.0, "device": "cpu", "altitudes_m": None, "filter": True}


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """A mission as its robots' processes see it.

    starts_m: (n, 2). period_ns: the time between decisions by default, the mission's time step. silent_ns: one that has
    told nothing for so long is forgotten; clock_error_ns: by which clocks may differ; own_clocks: each robot
    goes by its own, see ``apart``. radio_m: how far tellings are received. decide: the controller, the very
    function that the simulation runs. ground_m: the height of the ground at a place (x, y), over which robots fly at
    the fleet's altitude. importance: of the ground; None: all is worth as much.
    """

    mission: Mission
    seed: int
    number: int
    starts_m: Floats
    fleet: FleetKinds
    grid: Grid
    importance: ImportanceCells | None
    period_ns: int
    silent_ns: int
    clock_error_ns: int
    decide: Callable[..., None]
    own_clocks: bool = False
    radio_m: float = math.inf
    ground_m: HeightAt = level

    @property
    def starts(self) -> tuple[Start, ...]:
        """Where all robots stand before they take part."""
        bodies = self.fleet.kinds.body_m[self.fleet.kind]
        return tuple(Start(float(x), float(y), float(b)) for (x, y), b in zip(self.starts_m, bodies, strict=True))

    def own_kind(self, robot: int) -> Kinds:
        """What one robot is like: kinds of one row."""
        row = int(self.fleet.kind[robot])
        return Kinds(*(values[row : row + 1] for values in self.fleet.kinds))

    def rule(self, hold_ns: int) -> Rule:
        """What the controllers read, for a robot that holds each decision so long."""
        # news are late by a part of a hold; ``rule.late`` is for news that are later than that
        return rule_of(SwarmSettings.of(self.mission), self.seed)._replace(time_step_s=hold_ns * 1e-9)


def scene_of(
    mission: Mission,
    *,
    seed: int = 0,
    silent_s: float | None = None,
    clock_error_s: float = 0.0,
    own_clocks: bool = False,
    radio_m: float | None = None,
    ground_m: HeightAt = level,
) -> Scene:
    """The scene of a mission. silent_s None: ``SILENT_PERIODS`` time steps of the mission. radio_m None: any distance.

    Raises MissionError for settings that only simulations have, for too many robots, for steps and limits out of range,
    for a radio range within which bodies could touch, and for starts without room.
    """
    settings, robots = SwarmSettings.of(mission), mission.fleet.robots or ()
    for name, only in OF_SIMULATIONS.items():
        if (value := getattr(settings, name)) != only:
            raise MissionError(f"swarm.{name}: {value} is not allowed: robots in processes of their own have {only}")
    if len(robots) > MOST_ROBOTS:
        raise MissionError(f"fleet.robots: {len(robots)} is not allowed; at most {MOST_ROBOTS} can be told apart")
    period_ns = require_period(settings.time_step_s, "swarm.time_step_s")
    silent_s = SILENT_PERIODS * settings.time_step_s if silent_s is None else silent_s
    least_s = LEAST_SILENT_PERIODS * settings.time_step_s
    if not least_s <= silent_s <= 1e3:
        raise MissionError(
            f"silent: {silent_s:.6g} s is not allowed; {least_s:.6g} s, {LEAST_SILENT_PERIODS} time steps, to"
            " 1000 s are needed"
        )
    if not 0 <= clock_error_s <= silent_s:
        raise MissionError(f"clock error: {clock_error_s:.6g} s is not allowed; 0 to {silent_s:.6g} s is needed")
    if own_clocks and clock_error_s == 0:
        raise MissionError("clock error: 0 s is not allowed with own clocks: tell how late the promptest news are")
    ground = free_ground(mission)
    settles = DECIDE[settings.controller] is decide_settle
    fleet, walls = fleet_of(mission, sensors_m=_spreading_m(mission) if settles else None), walls_of(ground)
    least_m = least_radio_m(fleet.kinds.body_m[fleet.kind], fleet.kinds.speed_m_s[fleet.kind], silent_s)
    if radio_m is not None and not least_m <= radio_m:
        raise MissionError(
            f"radio range: {radio_m:.6g} m is not allowed: bodies keep apart from {least_m:.6g} m on, what two robots"
            f" drive in {RADIO_SILENCES:g} times {silent_s:.6g} s and their bodies' radii"
        )
    importance = importance_for(mission, ground, sensors_of(mission))
    grid = make_grid(walls, fleet.kinds, len(robots), settings.time_step_s, importance=importance, mapped=settles)
    return Scene(
        mission=mission,
        seed=seed,
        number=swarm_number(mission, seed),
        starts_m=place_starts(mission, ground, seed=seed, reserve_m=0.0),
        fleet=fleet,
        grid=grid,
        importance=importance,
        period_ns=period_ns,
        silent_ns=round(silent_s * 1e9),
        clock_error_ns=round(clock_error_s * 1e9),
        decide=DECIDE[settings.controller],
        own_clocks=own_clocks,
        radio_m=math.inf if radio_m is None else radio_m,
        ground_m=ground_m,
    )


def _spreading_m(mission: Mission) -> Floats:
    """(n,): radii of the discs with which robots spread by area; of a square sensor the disc of the same area.

    The discs within squares are all seen wherever these overlap by corners only. Robots that close a gap would stop
    there, up to 3 % short of what fresh ones cover.
    """
    sensors_m = sensors_of(mission)
    return np.where(squares_of(mission), sensors_m * 2 / math.sqrt(math.pi), sensors_m)


def require_period(period_s: float, where: str) -> int:
    """The time between decisions in nanoseconds; MissionError for one that cannot be told."""
    if not (math.isfinite(period_s) and 1e-3 <= period_s <= LONGEST_HOLD_NS * 1e-9):
        raise MissionError(f"{where}: {period_s:.6g} s is not allowed; 0.001 to {LONGEST_HOLD_NS * 1e-9:g} s is needed")
    return round(period_s * 1e9)
