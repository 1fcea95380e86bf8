"""What becomes of a plan when robots turn inexactly: simulated in the plane, from where the plan begins."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rota.geometry.free_space import free_ground
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planners.bounce.cells import cells_of, make_cells
from rota.planners.bounce.inexact_turns import Crew, Estimate, InexactRuns, TurningError, make_crew, run_crew
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planners.bounce.trajectories import step_duration_s

RUNS = 1000  # of a plan; fewer where they take more looks at walls and corners than these, but no fewer than those
MOST_WORK, LEAST_RUNS = 1.5e9, 100
MOST_UNASKED, LEAST_UNASKED = 1e8, 12  # where the mission states no error
STATED_ERROR_DEG = 1.0  # of each turn, where the mission states none
PERIODS = 10.0  # of the longest one, for which robots that monitor are followed
LEAST_TURN_S = 1e-3  # of robots that turn at once
COVERING_S, COVERING_RUNS = 6 * 3600.0, 400  # for which robots that only react are followed until all is covered
SHARES = (0.1, 0.5, 0.9)  # of the runs, by which the first contact is told


@dataclass(frozen=True, kw_only=True)
class Kept:
    """What is left of a plan, with exact turns in the plane and with inexact ones.

    name: a zone's, for the share of the time in which it had been visited within its period; or None, for the share of
    all cells entered in the plan's time.
    """

    name: str | None
    exact: Estimate
    inexact: Estimate


@dataclass(frozen=True, kw_only=True)
class Inexact:
    """What ``runs`` simulated runs of ``lasting_s`` seconds leave of a plan, each turn off by up to ``error_deg``.

    met_s: by when two bodies first touched in SHARES of the runs, inf: not while they lasted; None for a robot alone.
    """

    error_deg: float
    runs: int
    lasting_s: float
    kept: tuple[Kept, ...]
    met_s: tuple[float, ...] | None

    @property
    def least_share(self) -> float:
        """The least of the shares that are kept."""
        return min((kept.inexact.value for kept in self.kept), default=0.0)


def with_errors(plan: Plan, *, most_runs: int = RUNS, exact: bool = True) -> Inexact:
    """What is left of a plan with turns off by up to the mission's ``turning_error_deg``, uniformly.

    Robots drive at their slowest one's speed from the plan's first places and headings on, turn at every contact and
    never by a clock: they do what the paper's robots do, not what the plan's times say. On a grid a turn takes a step.
    A mission that states no error is simulated with one of STATED_ERROR_DEG. exact: with exact turns as well, for
    comparison, which is one run; without it the same numbers stand for both.
    """
    mission, settings = plan.mission, BounceSettings.of(plan.mission)
    crew = _crew(plan)
    error_deg = settings.turning_error_deg or STATED_ERROR_DEG
    error = TurningError(angle_rad=math.radians(error_deg))
    zones = [(zone.shape, zone.period_s) for zone in mission.zones if zone.period_s is not None]
    covers = settings.task == "cover"
    lasting_s = max(t.times_s[-1] for t in plan) if covers else PERIODS * max(period_s for _, period_s in zones)
    asked = settings.turning_error_deg > 0
    least, work = (LEAST_RUNS, MOST_WORK) if asked else (LEAST_UNASKED, MOST_UNASKED)
    runs = _runs_within(crew, float(lasting_s), most_runs, least, work)

    def simulate(error: TurningError, runs: int) -> InexactRuns:
        cells = make_cells(mission) if covers else None
        return run_crew(
            crew, error, _starts(plan, runs), duration_s=float(lasting_s), seed=plan.seed, cells=cells,
            zones=() if covers else zones,
        )  # fmt: skip

    inexact = simulate(error, runs)
    without = simulate(TurningError(), 1) if exact else inexact
    if covers:
        kept: tuple[Kept, ...] = (
            Kept(name=None, exact=without.mean_seen(lasting_s), inexact=inexact.mean_seen(lasting_s)),
        )
    else:
        names = [zone.name for zone in mission.zones if zone.period_s is not None]
        kept = tuple(
            Kept(name=name, exact=one, inexact=other)
            for name, one, other in zip(names, without.watched_shares(), inexact.watched_shares(), strict=True)
        )
    met_s = inexact.contact_quantiles_s(SHARES) if len(plan.trajectories) > 1 else None
    return Inexact(error_deg=error_deg, runs=runs, lasting_s=float(lasting_s), kept=kept, met_s=met_s)


@dataclass(frozen=True, kw_only=True)
class Covering:
    """By when robots that only react had entered all ``cells``, in SHARES of the runs; inf: not in ``lasting_s``."""

    error_deg: float
    runs: int
    lasting_s: float
    cells: int
    times_s: tuple[float, ...]


def covering(plan: Plan, *, most_runs: int = COVERING_RUNS) -> Covering:
    """How long robots that turn at every contact take from the plan's start to enter every cell that a body fits into.

    Without a grid cells are as wide as the widest body. Turns are off as in ``with_errors``.
    """
    mission, settings = plan.mission, BounceSettings.of(plan.mission)
    crew, error_deg = _crew(plan), settings.turning_error_deg or STATED_ERROR_DEG
    if settings.cells == "grid":
        cells = make_cells(mission)
    else:
        radius_m = crew.rim.body_radius_m
        cells = cells_of(free_ground(mission), mission.area.bounds, cell_m=2 * radius_m, body_radius_m=radius_m)
    runs = _runs_within(crew, COVERING_S, most_runs, LEAST_UNASKED, MOST_WORK)
    error = TurningError(angle_rad=math.radians(error_deg))
    made = run_crew(crew, error, _starts(plan, runs), duration_s=COVERING_S, seed=plan.seed, cells=cells)
    ordered = np.sort(made.cover_times_s())
    times_s = tuple(float(ordered[max(math.ceil(share * runs) - 1, 0)]) for share in SHARES)
    return Covering(error_deg=error_deg, runs=runs, lasting_s=COVERING_S, cells=cells.count, times_s=times_s)


def _runs_within(crew: Crew, lasting_s: float, most: int, least: int, work: float) -> int:
    """How many runs take this work, by the mean length of a chord of the ground; ``least`` at least, or ``most``."""
    ground = crew.rim.free
    chord_m = math.pi * ground.area / ground.length
    bounces = len(crew.bounces_rad) * lasting_s / (chord_m / crew.speed_m_s + crew.turn_s)
    looks = max(2 * bounces * len(crew.rim.kinds), 1.0)
    return min(most, max(min(least, most), int(work / looks)))


def _crew(plan: Plan) -> Crew:
    """The plan's robots as the simulation in the plane has them."""
    mission = plan.mission
    robots = [mission.fleet.robot(trajectory.robot) for trajectory in plan]
    return make_crew(
        free_ground(mission),
        [robot.body_radius_m for robot in robots],
        [math.radians(angle) for angle in BounceSettings.of(mission).bouncing.angles_of(len(robots))],
        speed_m_s=min(robot.ground_speed_m_s for robot in robots),
        turn_s=_turn_s(mission, plan),
    )


def _turn_s(mission: Mission, plan: Plan) -> float:
    """Seconds that a turn takes in the simulation: a step on the grid, the slowest robot's longest turn without."""
    if BounceSettings.of(mission).cells == "grid":
        return step_duration_s(mission, make_cells(mission))
    rates = [mission.fleet.robot(trajectory.robot).turn_rate_rad_s for trajectory in plan]
    longest_rad = math.radians(max(BounceSettings.of(mission).bouncing_angles_deg))
    return max([LEAST_TURN_S, *(longest_rad / rate for rate in rates if rate is not None)])


def _starts(plan: Plan, runs: int) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """(runs, m, 3) x, y in metres and heading in radians of each robot at the plan's start, the same in each run."""
    poses = [
        (*trajectory.positions_m[0, :2], 0.0 if trajectory.headings_rad is None else trajectory.headings_rad[0])
        for trajectory in plan
    ]
    return np.repeat(np.array([poses], dtype=np.float64), runs, axis=0)
