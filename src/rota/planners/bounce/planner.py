"""From a mission to a plan of bouncing robots: that monitor zones for ever, or cover the area once."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rota.errors import NoPlanFound
from rota.model.arrays import Floats
from rota.model.mission import Mission, Robot
from rota.model.plan import Plan
from rota.planners.bounce.bounce_map import make_team
from rota.planners.bounce.cells import Cells, make_cells
from rota.planners.bounce.chosen_group import Choice, Chosen, choose_group, out_of_reach
from rota.planners.bounce.clock_kernels import forbid_near_phases
from rota.planners.bounce.coverage import Coverage, cover
from rota.planners.bounce.kernels import Team
from rota.planners.bounce.limit_cycles import LimitCycles, cycles_see, limit_cycles, require_watchable, zone_cells
from rota.planners.bounce.monitoring import Watch
from rota.planners.bounce.physics_sentences import cycles_sentence
from rota.planners.bounce.plane_monitoring import plan_in_plane
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planners.bounce.robust_team import candidates, most_robust
from rota.planners.bounce.sentences import entered_sentence, groups_sentence, pace_sentence, proof_sentence
from rota.planners.bounce.starts import random_starts, robots_of, start_cells
from rota.planners.bounce.timed_group import TimedGroup, timed_group
from rota.planners.bounce.trajectories import Pace, pace_of, trajectory
from rota.planners.bounce.unreached import places_of, unreached_parts
from rota.planning.planner import Answer, Request

MOST_FEWEST = 12  # robots that are tried when the mission asks for as few as possible


@dataclass(frozen=True, kw_only=True, eq=False)
class Bouncing:
    """A mission's robots on its cells."""

    mission: Mission
    cells: Cells
    robots: tuple[Robot, ...]
    team: Team
    apart_m: Floats
    pace: Pace

    @property
    def step_s(self) -> float:
        """How long the longest step lasts."""
        return self.pace.longest_s


def bouncing_robots(mission: Mission, cells: Cells, count: int | None = None) -> Bouncing:
    """The mission's robots on cells; ``count`` of them when it asks for as few as possible."""
    robots, settings = robots_of(mission, count), BounceSettings.of(mission)
    radii = np.array([robot.body_radius_m for robot in robots])
    apart_m = radii[:, None] + radii if settings.contact == "swept" else np.zeros((len(robots),) * 2)
    bounces = [round(angle * settings.headings / 360) for angle in settings.bouncing.angles_of(len(robots))]
    team = make_team(cells, bounces, apart_m=apart_m)
    pace = pace_of(mission, cells, len(robots))
    return Bouncing(mission=mission, cells=cells, robots=robots, team=team, apart_m=apart_m, pace=pace)


def plan_bounce(request: Request) -> Answer:
    """A plan that monitors or covers, as the mission's task is, with sentences on what the search knows.

    Raises NoPlanFound, with the best plan there is, when cells stay uncovered or no team watches all zones.
    """
    settings = BounceSettings.of(request.mission)
    if settings.cells == "none":
        plan, team = plan_in_plane(request)
        return Answer(plan=plan, facts=(cycles_sentence(team),))
    if settings.task == "cover":
        return plan_coverage(request.mission, seed=request.seed)
    return plan_monitoring(request)


# ---------------------------------------------------------------- covering


def plan_coverage(mission: Mission, *, seed: int) -> Answer:
    """A plan by which the robots cover the area once and then stay; NoPlanFound with that plan when it misses cells."""
    bouncing = bouncing_robots(mission, make_cells(mission))
    coverage = coverage_by(bouncing, seed=seed)
    plan = coverage_plan(bouncing, coverage, seed)
    headings = bouncing.cells.headings
    times_s = bouncing.pace.times_s(coverage.states, headings)
    facts = (
        entered_sentence(coverage, len(bouncing.robots), float(times_s[-1])),
        pace_sentence(bouncing.pace.own_s(coverage.states, headings), np.diff(times_s)),
    )
    if not coverage.complete:
        raise NoPlanFound(uncovered_reason(bouncing, coverage), best=plan, facts=facts)
    return Answer(plan=plan, facts=facts)


def coverage_plan(bouncing: Bouncing, coverage: Coverage, seed: int) -> Plan:
    """The plan in which the robots take a joint trajectory and then stay."""
    times_s = bouncing.pace.times_s(coverage.states, bouncing.cells.headings)
    trajectories = (
        trajectory(
            robot.name, bouncing.cells, coverage.states[:, k], times_s=times_s, loop_from=coverage.steps
        )
        for k, robot in enumerate(bouncing.robots)
    )  # fmt: skip
    return Plan(mission=bouncing.mission, trajectories=tuple(trajectories), seed=seed)


def coverage_by(bouncing: Bouncing, *, seed: int) -> Coverage:
    """The joint trajectory that covers, from the mission's starts or from random ones."""
    settings = BounceSettings.of(bouncing.mission)
    starts = random_starts(bouncing.mission, bouncing.cells, bouncing.robots, bouncing.apart_m, seed)
    return cover(bouncing.cells, bouncing.team, starts.tolist(), method=settings.method, most_steps=settings.most_steps)


def uncovered_reason(bouncing: Bouncing, coverage: Coverage) -> str:
    """How much stays uncovered, where, and why."""
    settings, cells, parts = BounceSettings.of(bouncing.mission), bouncing.cells, []
    if coverage.walled_off.any():
        begins = coverage.states[0] // cells.headings
        parts += unreached_parts(bouncing.mission, cells, coverage.walled_off, begins)
    if coverage.missed.any():
        why = f"after bounce.most_steps: {settings.most_steps}"
        if coverage.steps < settings.most_steps:
            why = "when no robot could turn into a way to more"
            if settings.method == "as_printed":
                why = "when all joint states that robots can jump to had been there before"
        parts.append(
            f"{int(coverage.missed.sum())} cells were not entered {why}, at {places_of(cells, coverage.missed)}"
        )
    return f"{coverage.share:.1%} of {cells.count} cells are covered in {coverage.steps} steps; " + "; ".join(parts)


# ---------------------------------------------------------------- monitoring


def plan_monitoring(request: Request) -> Answer:
    """A plan by which the robots visit all zones with a period for ever, without contact on their cycles.

    For as few robots as possible, teams of 1, 2, ... are tried until one meets all periods. Raises NoPlanFound when no
    team that watches all zones is found; a team that visits them too seldom is given all the same.
    """
    mission, seed, should_stop = request.mission, request.seed, request.should_stop
    cells, settings = make_cells(mission), BounceSettings.of(mission)
    counts = [None] if mission.fleet.robots is not None else list(range(1, MOST_FEWEST + 1))
    best: tuple[Bouncing, Watch, Choice, TimedGroup] | None = None
    unproved: str | None = None
    for k, count in enumerate(counts):
        request.progress(k / len(counts), f"{count or len(mission.fleet.robots or ())} robots")
        bouncing = bouncing_robots(mission, cells, count)
        watch = watch_of(bouncing)
        choice = choose_group(watch, bouncing.team, mission, bouncing.robots, cells, seed=seed, should_stop=should_stop)
        unproved = unproved or choice.unproved
        if choice.chosen is not None:
            if settings.purpose == "robust":
                choice = robust_choice(request, bouncing, watch, choice)
            assert choice.chosen is not None
            best = bouncing, watch, choice, timed_group(bouncing.pace, cells.headings, choice.chosen)
            if best[3].ratio(watch, choice.chosen, [z.period_s for z in mission.zones if z.period_s is not None]) <= 1:
                break
        if should_stop():
            break
    if best is None:
        raise NoPlanFound(unwatched_reason(bouncing, unproved))
    bouncing, watch, choice, timed = best
    assert choice.chosen is not None
    groups = groups_sentence(watch, len(bouncing.robots)) if choice.told is None else choice.told
    facts = (groups, proof_sentence(mission, choice), pace_sentence(timed.own_s, timed.lasts_s))
    plan = monitoring_plan(bouncing, choice.chosen, seed, timed)
    return Answer(plan=plan, facts=tuple(fact for fact in facts if fact is not None))


def robust_choice(request: Request, bouncing: Bouncing, watch: Watch, choice: Choice) -> Choice:
    """The choice with another group that meets all periods, if one keeps more of its visits when turns are off."""
    settings = BounceSettings.of(bouncing.mission)
    starts = [cell for cell in start_cells(bouncing.cells, bouncing.robots) if cell is not None]
    groups = candidates(watch, bouncing.team, choice.chosen, starts, settings, request.seed)
    plans = [monitoring_plan(bouncing, group, request.seed) for group in groups]
    return replace(choice, chosen=groups[most_robust(plans, request)])


def unwatched_reason(bouncing: Bouncing, unproved: str | None) -> str:
    """Why there is no plan: how many robots were tried, and which zones they cannot reach from their starts.

    unproved: why there may be a plan all the same; None: there is none.
    """
    robots, listed = bouncing.robots, bouncing.mission.fleet.robots
    most = "up to " * (listed is None) + f"{len(robots)} robot" + "s" * (len(robots) != 1)
    margin_s = BounceSettings.of(bouncing.mission).clock_margin_s
    most += f" whose clocks may differ by {margin_s:.3g} s" * (margin_s > 0)
    team = f"no team of {most}" + (" was found that" if unproved is not None else "")
    other = "; other bouncing angles may do (bounce.bouncing_angles_deg: any tries all)"
    open_end = other if unproved is None else f"; that there is none is not proved: {unproved}{other}"
    printed = " of those that Algorithm 2 keeps as printed" * (
        BounceSettings.of(bouncing.mission).method == "as_printed"
    )
    if all(robot.start is None for robot in robots):
        return f"{team}{printed} goes its rounds without contact so that each zone is visited{open_end}"
    watch = watch_of(bouncing)
    names = [zone.name for zone in bouncing.mission.zones if zone.period_s is not None]
    starts = [cell for cell in start_cells(bouncing.cells, robots) if cell is not None]
    left_out = out_of_reach(watch, bouncing.team, starts, bouncing.mission, bouncing.cells)
    missed = ", ".join(name for name, out in zip(names, left_out, strict=True) if out)
    why = f"; left alone, no robot comes from its start to a limit cycle that enters {missed}" if missed else open_end
    return f"{team} goes its rounds from its starts without contact so that each zone is visited{why}"


def watch_of(bouncing: Bouncing) -> Watch:
    """What the robots' limit cycles see of the mission's zones; raises MissionError for those that none enters."""
    zones = [zone for zone in bouncing.mission.zones if zone.period_s is not None]
    inside = zone_cells(bouncing.cells, zones)
    margin_steps = BounceSettings.of(bouncing.mission).clock_margin_s / bouncing.step_s
    radii = np.array([robot.body_radius_m for robot in bouncing.robots])
    cycles = apart_in_time(limit_cycles(bouncing.team), bouncing.cells, radii[:, None] + radii, margin_steps)
    sees = cycles_see(cycles, inside, bouncing.cells.headings)
    require_watchable(sees, [zone.name for zone in zones], bouncing.cells, inside)
    periods_s = np.array([zone.period_s for zone in zones], np.float64)
    return Watch(cycles=cycles, sees=sees, period_steps=periods_s / bouncing.step_s)


def monitoring_plan(bouncing: Bouncing, chosen: Chosen, seed: int, timed: TimedGroup | None = None) -> Plan:
    """The plan in which the robots come to their cycles, if they do not begin there, and follow them."""
    headings, way = bouncing.cells.headings, len(chosen.transient)
    timed = timed or timed_group(bouncing.pace, headings, chosen)
    trajectories = (
        trajectory(robot.name, bouncing.cells, states, times_s=times_s, loop_from=way)
        for robot, states, times_s in zip(bouncing.robots, timed.states, timed.times_s, strict=True)
    )
    return Plan(mission=bouncing.mission, trajectories=tuple(trajectories), seed=seed)


def apart_in_time(cycles: LimitCycles, cells: Cells, apart_m: Floats, margin_steps: float) -> LimitCycles:
    """The cycles with fewer compatible pairs: robots stay apart for all differences of clocks up to the margin.

    apart_m: (m, m) metres by which bodies keep the centres of the team's robots apart. margin_steps: in steps; 0 leaves
    all as it is. Contact by the grid counts as well, but at equal times only.
    """
    if margin_steps <= 0:
        return cycles
    kinds = len(set(cycles.kind_of_robot))
    of_kinds = np.zeros((kinds, kinds))
    for i, a in enumerate(cycles.kind_of_robot):
        for j, b in enumerate(cycles.kind_of_robot):
            if i != j:
                of_kinds[a, b] = apart_m[i, j]
    kind_of_cycle = cycles.kind[cycles.start]
    compatible = cycles.compatible.copy()
    forbid_near_phases(
        np.ascontiguousarray(cells.centres_m[cycles.state // cells.headings]),
        np.ascontiguousarray(of_kinds[np.ix_(kind_of_cycle, kind_of_cycle)]),
        cycles.start, cycles.length, float(margin_steps), np.empty(int(cycles.length.max()), np.bool_), compatible,
    )  # fmt: skip
    return replace(cycles, compatible=compatible)
