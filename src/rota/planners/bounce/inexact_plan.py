"""What becomes of a plan when robots turn inexactly: simulated in the plane, from where the plan begins."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rota.geometry.free_space import free_ground
from rota.mission import Mission
from rota.plan import Plan
from rota.planners.bounce.cells import make_cells
from rota.planners.bounce.inexact_turns import Crew, Estimate, InexactRuns, TurningError, make_crew, run_crew
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planners.bounce.trajectories import step_duration_s

RUNS = 1000
PERIODS = 10.0  # of the longest one, for which robots that monitor are followed
LEAST_TURN_S = 1e-3  # of robots that turn at once


@dataclass(frozen=True, kw_only=True)
class Kept:
    """What is left of a plan, with exact turns in the plane and with inexact ones.

    name: a zone's, for the share of the time in which it had been visited within its period; or None, for the share of
    all cells entered in the plan's time.
    """

    name: str | None
    exact: Estimate
    inexact: Estimate


def kept_with_errors(plan: Plan) -> tuple[Kept, ...]:
    """What is left of a plan with turns off by up to the mission's ``turning_error_deg``, uniformly.

    Robots drive at their slowest one's speed from the plan's first places and headings on, turn at every contact and
    never by a clock: they do what the paper's robots do, not what the plan's times say. On a grid a turn takes a step.
    """
    mission, settings = plan.mission, BounceSettings.of(plan.mission)
    crew, starts = _crew(plan), _starts(plan)
    errors = (TurningError(), TurningError(angle_rad=math.radians(settings.turning_error_deg)))
    if settings.task == "cover":
        cells, until_s = make_cells(mission), max(float(trajectory.times_s[-1]) for trajectory in plan)
        both_runs = [run_crew(crew, error, starts, duration_s=until_s, seed=plan.seed, cells=cells) for error in errors]
        exact, inexact = (runs.mean_seen(until_s) for runs in both_runs)
        return (Kept(name=None, exact=exact, inexact=inexact),)
    zones = [(zone.shape, zone.period_s) for zone in mission.zones if zone.period_s is not None]
    lasting_s = PERIODS * max(period_s for _, period_s in zones)

    def watched(error: TurningError) -> InexactRuns:
        return run_crew(crew, error, starts, duration_s=lasting_s, seed=plan.seed, zones=zones)

    exact_shares, shares = (watched(error).watched_shares() for error in errors)
    names = [zone.name for zone in mission.zones if zone.period_s is not None]
    return tuple(
        Kept(name=name, exact=trajectory, inexact=other)
        for name, trajectory, other in zip(names, exact_shares, shares, strict=True)
    )


def _crew(plan: Plan) -> Crew:
    """The plan's robots as the simulation in the plane has them."""
    mission = plan.mission
    robots = [mission.fleet.robot(trajectory.robot) for trajectory in plan]
    angles = BounceSettings.of(mission).bouncing_angles_deg
    each = angles * len(robots) if len(angles) == 1 else angles
    return make_crew(
        free_ground(mission),
        [robot.body_radius_m for robot in robots],
        [math.radians(angle) for angle in each],
        speed_m_s=min(robot.speed_m_s for robot in robots),
        turn_s=_turn_s(mission, plan),
    )


def _turn_s(mission: Mission, plan: Plan) -> float:
    """Seconds that a turn takes in the simulation: a step on the grid, the slowest robot's longest turn without."""
    if BounceSettings.of(mission).cells == "grid":
        return step_duration_s(mission, make_cells(mission))
    rates = [mission.fleet.robot(trajectory.robot).turn_rate_rad_s for trajectory in plan]
    longest_rad = math.radians(max(BounceSettings.of(mission).bouncing_angles_deg))
    return max([LEAST_TURN_S, *(longest_rad / rate for rate in rates if rate is not None)])


def _starts(plan: Plan) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """(RUNS, m, 3) x, y in metres and heading in radians of each robot at the plan's start, the same in each run."""
    poses = [
        (*trajectory.positions_m[0, :2], 0.0 if trajectory.headings_rad is None else trajectory.headings_rad[0])
        for trajectory in plan
    ]
    return np.repeat(np.array([poses], dtype=np.float64), RUNS, axis=0)
