"""From a mission to a plan of bouncing robots: that monitor zones for ever, or cover the area once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.errors import NoPlanFound
from rota.mission import Mission, Robot
from rota.plan import Plan
from rota.planners.bounce.bounce_map import make_team
from rota.planners.bounce.cells import Cells, make_cells
from rota.planners.bounce.chosen_group import Chosen, choose_group, out_of_reach
from rota.planners.bounce.clock_margin import apart_in_time
from rota.planners.bounce.coverage import Coverage, cover
from rota.planners.bounce.group_count import TooMany, count_groups
from rota.planners.bounce.kernels import Team
from rota.planners.bounce.limit_cycles import limit_cycles, require_watchable, seen_by_cycles, zone_cells
from rota.planners.bounce.monitoring import Watch
from rota.planners.bounce.starts import random_starts, robots_of, start_cells
from rota.planners.bounce.trajectories import loops_in_step, step_duration_s, trajectory

Floats = NDArray[np.float64]

MOST_FEWEST = 12  # robots that are tried when the mission asks for as few as possible
PLACES_TOLD = 6
MOST_COUNTED = 20_000  # sets of states looked at, for a sentence


@dataclass(frozen=True, kw_only=True, eq=False)
class Bouncing:
    """A mission's robots on its cells."""

    mission: Mission
    cells: Cells
    robots: tuple[Robot, ...]
    team: Team
    apart_m: Floats
    step_s: float


def bouncing_robots(mission: Mission, cells: Cells, count: int | None = None) -> Bouncing:
    """The mission's robots on cells; ``count`` of them when it asks for as few as possible."""
    robots, settings = robots_of(mission, count), mission.bounce
    angles = settings.bouncing_angles_deg
    each = angles * len(robots) if len(angles) == 1 else angles
    radii = np.array([robot.body_radius_m for robot in robots])
    apart_m = radii[:, None] + radii if settings.contact == "swept" else np.zeros((len(robots),) * 2)
    bounces = [round(angle * settings.headings / 360) for angle in each]
    team = make_team(cells, bounces, apart_m=apart_m)
    step_s = step_duration_s(mission, cells)
    return Bouncing(mission=mission, cells=cells, robots=robots, team=team, apart_m=apart_m, step_s=step_s)


# ---------------------------------------------------------------- covering


def plan_coverage(mission: Mission, *, seed: int) -> Plan:
    """A plan by which the robots cover the area once and then stay; raises NoPlanFound with it when it misses cells."""
    bouncing = bouncing_robots(mission, make_cells(mission))
    found = covered_by(bouncing, seed=seed)
    plan = coverage_plan(bouncing, found, seed)
    if not found.complete:
        raise NoPlanFound(uncovered_reason(bouncing, found), best=plan)
    return plan


def coverage_plan(bouncing: Bouncing, found: Coverage, seed: int) -> Plan:
    """The plan in which the robots take a joint trajectory and then stay."""
    trajectories = (
        trajectory(
            robot.name, bouncing.cells, found.states[:, k], step_s=bouncing.step_s, loop_from=found.steps,
            jumps=found.jumps == k,
        )
        for k, robot in enumerate(bouncing.robots)
    )  # fmt: skip
    return Plan(mission=bouncing.mission, trajectories=tuple(trajectories), seed=seed)


def covered_by(bouncing: Bouncing, *, seed: int) -> Coverage:
    """The joint trajectory that covers, from the mission's starts or from random ones."""
    settings = bouncing.mission.bounce
    starts = random_starts(bouncing.mission, bouncing.cells, bouncing.robots, bouncing.apart_m, seed)
    return cover(bouncing.cells, bouncing.team, starts.tolist(), method=settings.method, most_steps=settings.most_steps)


def coverage_of(plan: Plan) -> tuple[Coverage, float]:
    """The joint trajectory of a plan that covers, found again from its seed, and how long a step takes in seconds."""
    bouncing = bouncing_robots(plan.mission, make_cells(plan.mission))
    return covered_by(bouncing, seed=plan.seed), bouncing.step_s


def uncovered_reason(bouncing: Bouncing, found: Coverage) -> str:
    """How much stays uncovered, where, and why."""
    settings, parts = bouncing.mission.bounce, []
    if found.walled_off.any():
        places = _places(bouncing.cells, found.walled_off)
        parts.append(f"no robot has a way from its start to {int(found.walled_off.sum())} cells, at {places}")
    if found.missed.any():
        why = f"after bounce.most_steps: {settings.most_steps}"
        if found.steps < settings.most_steps:
            why = "when all joint states that robots can jump to had been there before"
        places = _places(bouncing.cells, found.missed)
        parts.append(f"{int(found.missed.sum())} cells were not entered {why}, at {places}")
    return f"{found.share:.1%} of {bouncing.cells.count} cells are covered in {found.steps} steps; " + "; ".join(parts)


def _places(cells: Cells, marked: NDArray[np.bool_]) -> str:
    centres = cells.centres_m[marked]
    told = ", ".join(f"({x:.6g}, {y:.6g})" for x, y in centres[:PLACES_TOLD])
    return told + (f" and {len(centres) - PLACES_TOLD} more" if len(centres) > PLACES_TOLD else "")


# ---------------------------------------------------------------- monitoring


def plan_monitoring(
    mission: Mission, *, seed: int, progress: Callable[[float, str], None], should_stop: Callable[[], bool]
) -> Plan:
    """A plan by which the robots visit all zones with a period for ever, without contact on their cycles.

    For as few robots as possible, teams of 1, 2, ... are tried until one meets all periods. Raises NoPlanFound when no
    team watches all zones; a team that visits them too seldom is given all the same.
    """
    cells = make_cells(mission)
    counts = [None] if mission.fleet.robots is not None else list(range(1, MOST_FEWEST + 1))
    best: Plan | None = None
    for k, count in enumerate(counts):
        progress(k / len(counts), f"{count or len(mission.fleet.robots or ())} robots")
        bouncing = bouncing_robots(mission, cells, count)
        chosen = choose_group(watch_of(bouncing), bouncing.team, mission, bouncing.robots, cells,
                              seed=seed, should_stop=should_stop)  # fmt: skip
        if chosen is not None:
            best = monitoring_plan(bouncing, chosen, seed)
            if chosen.ratio <= 1:
                return best
        if should_stop():
            break
    if best is None:
        raise NoPlanFound(unwatched_reason(bouncing))
    return best


def unwatched_reason(bouncing: Bouncing) -> str:
    """Why no team was found: how many robots were tried, and which zones they cannot come to from where they start."""
    robots, listed = bouncing.robots, bouncing.mission.fleet.robots
    most = "up to " * (listed is None) + f"{len(robots)} robot" + "s" * (len(robots) != 1)
    margin_s = bouncing.mission.bounce.clock_margin_s
    most += f" whose clocks may differ by {margin_s:.3g} s" * (margin_s > 0)
    if all(robot.start is None for robot in robots):
        return f"no team of {most} goes its rounds without contact so that each zone is visited"
    watch = watch_of(bouncing)
    names = [zone.name for zone in bouncing.mission.zones if zone.period_s is not None]
    starts = [cell for cell in start_cells(bouncing.cells, robots) if cell is not None]
    left_out = out_of_reach(watch, bouncing.team, starts, bouncing.mission, bouncing.cells)
    missed = ", ".join(name for name, out in zip(names, left_out, strict=True) if out)
    why = f"; left alone, no robot comes from its start to a limit cycle that enters {missed}" if missed else ""
    return f"no team of {most} goes its rounds from its starts without contact so that each zone is visited{why}"


def watch_of(bouncing: Bouncing) -> Watch:
    """What the robots' limit cycles see of the mission's zones; raises MissionError for those that none enters."""
    zones = [zone for zone in bouncing.mission.zones if zone.period_s is not None]
    inside = zone_cells(bouncing.cells, zones)
    margin_steps = bouncing.mission.bounce.clock_margin_s / bouncing.step_s
    radii = np.array([robot.body_radius_m for robot in bouncing.robots])
    cycles = apart_in_time(limit_cycles(bouncing.team), bouncing.cells, radii[:, None] + radii, margin_steps)
    sees = seen_by_cycles(cycles, inside, bouncing.cells.headings)
    require_watchable(cycles, sees, [zone.name for zone in zones])
    periods_s = np.array([zone.period_s for zone in zones], np.float64)
    return Watch(cycles=cycles, sees=sees, period_steps=periods_s / bouncing.step_s)


def monitoring_plan(bouncing: Bouncing, chosen: Chosen, seed: int) -> Plan:
    """The plan in which the robots come to their cycles, if they do not begin there, and follow them."""
    cycles = chosen.cycles
    loops = loops_in_step([int(cycles.length[cycles.cycle[node]]) for node in chosen.nodes])
    way = len(chosen.transient)
    trajectories = []
    for k, (robot, node, steps) in enumerate(zip(bouncing.robots, chosen.nodes, loops, strict=True)):
        rounds = [cycles.state[cycles.later(node, t)] for t in range(steps + 1)]
        states = np.concatenate([chosen.transient[:, k], np.array(rounds, np.int32)]).astype(np.int32)
        trajectories.append(trajectory(robot.name, bouncing.cells, states, step_s=bouncing.step_s, loop_from=way))
    return Plan(mission=bouncing.mission, trajectories=tuple(trajectories), seed=seed)


def groups_of(mission: Mission, robots: int) -> int | None:
    """How many periodic groups of so many robots visit all zones without contact; None: too many to count at once."""
    watch = watch_of(bouncing_robots(mission, make_cells(mission), robots))
    try:
        return count_groups(watch.cycles, watch.sees, most_calls=MOST_COUNTED)
    except TooMany:
        return None
