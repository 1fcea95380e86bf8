"""From a mission to a plan: robots at their starts, a run of the swarm, and its trajectories thinned."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from shapely import MultiPolygon

from rota.cells.importance_cells import importance_at, states_importance
from rota.errors import CheckpointError
from rota.geometry.free_space import free_ground
from rota.model.arrays import Floats
from rota.model.mission import DiscSensor, Mission
from rota.model.plan import EndReason, Plan, RunEnd
from rota.planners.swarm.baseline_kernels import decide_virtual_force, decide_voronoi
from rota.planners.swarm.charging.rounds import guide_of, make_rounds, most_spreading_steps
from rota.planners.swarm.deciding import Controller
from rota.planners.swarm.importance_field import importance_for
from rota.planners.swarm.messages import hearing_of, oldest_steps
from rota.planners.swarm.metrics import History, Observer
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.presence import Presence, holding_from_joining
from rota.planners.swarm.reciprocal_kernels import decide_reciprocal
from rota.planners.swarm.rest import blocked_robots, last_change_of, longest_rest_m, steps_at_rest
from rota.planners.swarm.rollout import Surroundings, Swarm
from rota.planners.swarm.sensing import bands_of, sensors_of, squares_of
from rota.planners.swarm.settle_kernels import decide_settle
from rota.planners.swarm.sorted_robots import Beginning
from rota.planners.swarm.space_rollout import SpaceSwarm
from rota.planners.swarm.starts import passable_reserve_m, place_starts, require_short_steps, spare_room_m
from rota.planners.swarm.state import FleetKinds, Rule
from rota.planners.swarm.trajectory_log import Kept, TrajectoryLog
from rota.planners.swarm.world import kinds_of, walls_of
from rota.planning.checkpoint import Checkpoint

DECIDE: dict[str, Callable[..., None]] = {
    "reciprocal": decide_reciprocal,
    "voronoi": decide_voronoi,
    "virtual_force": decide_virtual_force,
    "settle": decide_settle,
}
ALL_NEIGHBOURS = 32  # as many as any but "reciprocal" heeds, within the reach of both sensors
HEIGHTS = 1  # the stream of random numbers that starts in space take their heights from
LARGEST_SEED = 2**63  # that compiled code can hold
RANGE_PER_SENSOR = 2.04  # Table 2: 51 m for sensors of 25 m


@dataclass(frozen=True, kw_only=True)
class SwarmRun:
    """A plan, and how it came about. ``at_rest``: the stop rule ended the run; ``steps``: after how many.

    ``history`` None: nobody asked for it. ``state``: what it takes to go on from there.
    """

    plan: Plan
    steps: int
    at_rest: bool
    history: History | None
    state: Checkpoint


def run_mission(
    mission: Mission,
    *,
    seed: int,
    progress: Callable[[float, str], None] = lambda _fraction, _doing: None,
    should_stop: Callable[[], bool] = lambda: False,
    threads: int = 1,
    observed: bool = False,
    resume: Checkpoint | None = None,
) -> SwarmRun:
    """Let the mission's robots spread until they rest, or for as many steps as it allows; then they hold.

    They do not rest for good before all have joined and left, and all moving obstacles have come to a stand.

    Bodies are kept so much wider while they move that thinning the trajectories, which errs by no more than
    ``thinning_m`` at any time, makes none touch: less where robots start closer than that. Without the filter nothing
    is promised. ``observed``: measure every step. ``resume``: go on from there, to the plan that the same run comes to
    without a stop, bit for bit; what is observed is then the rest. Raises MissionError for starts without room and for
    a time step that jumps through walls, CheckpointError for a run of another mission or seed. Swarms in space are not
    observed.
    """
    settings = SwarmSettings.of(mission)
    ground = free_ground(mission)
    state = _beginning(mission, ground, seed) if resume is None else _resume(resume, mission, seed)
    swarm = _swarm_from(state, mission, ground, threads)
    log = _log_from(state)
    still, needed, stop_m = state.steps_at_rest, steps_at_rest(settings), longest_rest_m(mission)
    presence, awaited = Presence(mission), last_change_of(mission)
    observer = None
    if isinstance(swarm, Swarm):
        presence.begin(swarm)
        observer = _observer_of(swarm, mission, ground) if observed else None
    stopped = False
    most_steps = min(settings.most_steps, most_spreading_steps(mission, settings.time_step_s))
    while swarm.steps < most_steps and (still < needed or swarm.steps <= awaited) and not (stopped := should_stop()):
        if isinstance(swarm, Swarm) and presence.update(swarm):
            log.keep_last()
        began_s = time.perf_counter()
        still = still + 1 if swarm.step() <= stop_m and swarm.news_rest else 0
        if observer is not None:
            observer.note(time.perf_counter() - began_s)
        log.add(swarm.places_m)
        if swarm.steps % 50 == 0:
            progress(swarm.steps / settings.most_steps, f"step {swarm.steps}")
    end = _end_of(swarm, mission, still >= needed and swarm.steps > awaited, stopped)
    if mission.chargers:
        log.keep_last()
    now = _state_of(state, mission, swarm, log, still)
    if mission.chargers:
        ways = make_rounds(mission, partial(_begin_again, now, mission, ground, threads), progress, should_stop)
        plan = Plan(mission=mission, trajectories=ways, seed=seed, run_end=None if end.goes_on else end)
    else:
        plan = _plan_of(log, mission, seed, end)
    return SwarmRun(
        plan=plan,
        steps=swarm.steps,
        at_rest=end.at_rest,
        history=None if observer is None else observer.history(),
        state=now,
    )


def _end_of(swarm: Swarm | SpaceSwarm, mission: Mission, at_rest: bool, stopped: bool) -> RunEnd:
    """How a run ended."""
    blocked = blocked_robots(swarm, mission) if at_rest else ()
    at_rest = at_rest and not blocked
    reason: EndReason = "rest" if at_rest else "blocked" if blocked else "stopped" if stopped else "most_steps"
    return RunEnd(at_rest=at_rest, steps=swarm.steps, reason=reason, blocked=blocked)


def _observer_of(swarm: Swarm, mission: Mission, ground: MultiPolygon) -> Observer:
    worth = partial(importance_at, mission) if states_importance(mission) else None
    return Observer(swarm, ground, SwarmSettings.of(mission).stop_m, squares_of(mission), worth)


def _beginning(mission: Mission, ground: MultiPolygon, seed: int) -> Checkpoint:
    """The robots at their starts; raises MissionError where there is no room, or steps are too long."""
    settings = SwarmSettings.of(mission)
    if not settings.filter:
        require_short_steps(mission, sensors_of(mission), settings.time_step_s, settings.wall_range_m)
    wish_m = passable_reserve_m(mission, ground, settings.thinning_m) if settings.filter else 0.0
    starts = place_starts(mission, ground, seed=seed, reserve_m=wish_m)
    reserve_m = min(wish_m, spare_room_m(mission, ground, starts, wish_m))
    if settings.altitudes_m is not None:
        # apart in the plane, they are apart at any heights
        heights = np.random.default_rng([seed, HEIGHTS]).uniform(*bands_of(mission), len(starts))
        starts = np.column_stack([starts, heights])
    none = np.empty(0, np.int64)
    return Checkpoint(
        mission=mission,
        seed=seed,
        steps=0,
        steps_at_rest=0,
        thinned_m=reserve_m if settings.filter else settings.thinning_m,
        names=np.arange(len(starts), dtype=np.int64),
        places_m=starts,
        velocities_m_s=np.zeros_like(starts),
        kept_steps=none,
        kept_robots=none,
        kept_places_m=np.empty((0, starts.shape[1])),
        recent_m=starts[None],
        past=np.empty((0, 4, len(starts))),
        news_m=np.empty(0),
    )


def _swarm_from(state: Checkpoint, mission: Mission, ground: MultiPolygon, threads: int) -> Swarm | SpaceSwarm:
    """The swarm that goes on from a state, on the ground or at the mission's altitudes."""
    reserve_m = state.thinned_m if SwarmSettings.of(mission).filter else 0.0
    if SwarmSettings.of(mission).altitudes_m is not None:
        return make_space_swarm(mission, ground, state, reserve_m=reserve_m, threads=threads)
    return make_swarm(mission, ground, beginning_of(state), seed=state.seed, reserve_m=reserve_m, threads=threads)


def _begin_again(
    state: Checkpoint, mission: Mission, ground: MultiPolygon, threads: int
) -> tuple[Swarm, TrajectoryLog]:
    """The swarm that goes on from a state in the plane, and its log."""
    swarm = _swarm_from(state, mission, ground, threads)
    assert isinstance(swarm, Swarm)
    return swarm, _log_from(state)


def _log_from(state: Checkpoint) -> TrajectoryLog:
    """The log that goes on from a state."""
    kept = (Kept(state.kept_steps, state.kept_robots, state.kept_places_m),)
    return TrajectoryLog(state.recent_m, state.thinned_m, begin=state.recent_from, kept=kept)


def _plan_of(log: TrajectoryLog, mission: Mission, seed: int, end: RunEnd) -> Plan:
    """The plan of the way that was logged, robots holding where they came to."""
    names = [robot.name for robot in mission.fleet.robots or ()]
    trajectories = holding_from_joining(log.trajectories(names, SwarmSettings.of(mission).time_step_s), mission)
    return Plan(mission=mission, trajectories=trajectories, seed=seed, run_end=end)


def _resume(state: Checkpoint, mission: Mission, seed: int) -> Checkpoint:
    """The state, once it is clear that it is one of a run of this mission with this seed; CheckpointError otherwise."""
    state.require_same(mission, seed)
    hearing = hearing_of(SwarmSettings.of(state.mission))
    needed = 0 if hearing is None else oldest_steps(hearing) + 1
    if len(state.past) not in (needed, 0 if state.steps == 0 else needed):
        raise CheckpointError(f"past: messages of {len(state.past)} steps; {needed} are needed")
    return state


def _state_of(
    before: Checkpoint, mission: Mission, swarm: Swarm | SpaceSwarm, log: TrajectoryLog, still: int
) -> Checkpoint:
    """What it takes to go on from where the swarm is now."""
    names, kept = swarm.robots.name.copy(), log.kept
    return replace(
        before,
        mission=mission,
        steps=swarm.steps,
        steps_at_rest=still,
        names=names,
        places_m=swarm.places_m[names],
        velocities_m_s=swarm.velocities_m_s[names],
        kept_steps=kept.steps,
        kept_robots=kept.robots,
        kept_places_m=kept.places_m,
        recent_m=log.recent_m.copy(),
        past=swarm.past,
        news_m=swarm.news_m,
    )


def make_swarm(
    mission: Mission,
    ground: MultiPolygon,
    beginning: Beginning,
    *,
    seed: int,
    reserve_m: float = 0.0,
    threads: int = 1,
    decide: Callable[..., None] | None = None,
) -> Swarm:
    """The mission's robots where they begin; their bodies are wider by ``reserve_m``.

    decide: a kernel in place of the controller's own.
    """
    settings = SwarmSettings.of(mission)
    controller = Controller(
        decide=decide or DECIDE[settings.controller],
        rule=rule_of(settings, seed)._replace(last_change=last_change_of(mission)),
        safe=settings.filter,
        hearing=hearing_of(settings),
        device=settings.device,
    )
    importance = importance_for(mission, ground, sensors_of(mission))
    surroundings = Surroundings(walls_of(ground), mission.moving_obstacles, importance)
    swarm = Swarm(beginning, fleet_of(mission, reserve_m), surroundings, controller, threads=threads)
    swarm.guide = guide_of(mission, swarm) if mission.chargers else None
    return swarm


def fleet_of(mission: Mission, reserve_m: float = 0.0, sensors_m: Floats | None = None) -> FleetKinds:
    """What the robots of a mission in the plane are like; their bodies are wider by ``reserve_m``.

    sensors_m: (n,) radii of the discs that they spread with; None: ``sensors_of``.
    """
    settings, robots = SwarmSettings.of(mission), mission.fleet.robots or ()
    sensors = sensors_of(mission) if sensors_m is None else sensors_m
    reach_m = settings.neighbour_range_m or RANGE_PER_SENSOR * sensors.max()
    return kinds_of(
        len(robots),
        body_m=np.array([robot.body_radius_m for robot in robots]) + reserve_m,
        sensor_m=sensors,
        speed_m_s=np.array([robot.ground_speed_m_s for robot in robots]),
        neighbour_range_m=reach_m if settings.controller == "reciprocal" else sensors + sensors.max(),
        wall_range_m=settings.wall_range_m or sensors,
    )


def make_space_swarm(
    mission: Mission, ground: MultiPolygon, state: Checkpoint, *, reserve_m: float = 0.0, threads: int = 1
) -> SpaceSwarm:
    """The robots of a mission with altitudes as ``state`` has them; their bodies are wider by ``reserve_m``.

    Ranges that are not given follow from the footprints that robots have at their ceilings.
    """
    settings, robots, bands = SwarmSettings.of(mission), mission.fleet.robots or (), bands_of(mission)
    full = np.array([robot.sensor.full_height_m for robot in robots if isinstance(robot.sensor, DiscSensor)])
    return SpaceSwarm(
        beginning_of(state),
        fleet_of(mission, reserve_m),
        walls_of(ground),
        rule_of(settings, state.seed)._replace(last_change=last_change_of(mission)),
        bands=bands,
        full_m=np.minimum(full, bands.high_m),
        importance=importance_for(mission, ground, sensors_of(mission)),
        settles=settings.controller == "settle",
        safe=settings.filter,
        threads=threads,
    )


def beginning_of(state: Checkpoint) -> Beginning:
    """Where the swarm of a checkpoint goes on."""
    return Beginning(
        state.places_m,
        velocities_m_s=state.velocities_m_s,
        names=state.names,
        steps=state.steps,
        past=state.past if len(state.past) else None,
        news_m=state.news_m if state.steps > 0 else None,
    )


def rule_of(settings: SwarmSettings, seed: int) -> Rule:
    """What the compiled controllers read of the settings."""
    return Rule(
        neighbours=settings.neighbours if settings.controller == "reciprocal" else ALL_NEIGHBOURS,
        circle=settings.boundary == "circle",
        horizon_s=settings.horizon_s,
        alpha=settings.alpha,
        samples=settings.samples if settings.velocity == "sampled" else 0,
        seed=seed % LARGEST_SEED,
        time_step_s=settings.time_step_s,
        late=hearing_of(settings) is not None,
    )
