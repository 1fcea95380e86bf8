"""The runs that the figures are made of: a map, a controller and a seed each, run once, two at a time."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from rota.geometry.free_space import free_ground
from rota.model.mission import Mission
from rota.planners.swarm.metrics import History, covered_share
from rota.planners.swarm.planner import SwarmRun, run_mission
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.sensing import sensors_of, squares_of
from rota_studies import records
from rota_studies.chen2018 import paper
from rota_studies.plain import changes
from rota_studies.records import plan_digest
from rota_studies.study_runs import StudyRuns

Floats = NDArray[np.float64]
Longs = NDArray[np.int64]

PLATEAU = 0.25  # of a run that was cut off, over which its coverage must not have changed to count as settled
DRAWN_PLACES = 5_000  # of one run: so many places at most, evenly spread over its steps
SPARSE, SPARSE_STEPS = 100, 10  # steps between them, from which on only so many of those that tables name are drawn
MOMENTS = (40, 50, 100, 200, 300, 500, 574, 1000, 2000, 3000)


@dataclass(frozen=True, kw_only=True)
class Controller:
    """A controller as the page calls it, with a few words on what it is."""

    name: str
    what: str
    settings: SwarmSettings


def _controller(name: str, what: str, **settings: object) -> Controller:
    """A controller by its settings, without filter and thinning unless they are given."""
    like = {"thinning_m": 0.0, "neighbours": paper.NEIGHBOURS, "filter": False}
    planning = SwarmSettings(**{**like, **settings})  # type: ignore[arg-type]
    return Controller(name=name, what=what, settings=planning)


SAMPLED = _controller("RD, sampled", "tangent, 1,000 random velocities", controller="reciprocal", velocity="sampled")
EXACT = _controller("RD", "tangent, exact centroid", controller="reciprocal")
CIRCLE_1 = _controller("RD, circle 1 s", "circle at τ = 1 s, exact", controller="reciprocal", boundary="circle")
CIRCLE_5 = _controller(
    "RD, circle 5 s", "circle at τ = 5 s, exact", controller="reciprocal", boundary="circle", horizon_s=5.0
)
FILTERED = _controller("RD + filter", "tangent, exact, last filter", controller="reciprocal", filter=True)
VORONOI = _controller("V-based", "range-limited Voronoi cells, last filter", controller="voronoi", filter=True)
FORCES = _controller("VFA", "virtual forces, last filter", controller="virtual_force", filter=True)
SETTLE = _controller(
    "settle",
    "ours: covered-area gradient, overlaps, news of free ground; last filter",
    controller="settle",
    filter=True,
)

READINGS = (SAMPLED, EXACT, CIRCLE_1, CIRCLE_5, FILTERED)
"""Of the published controller."""
COMPARED = (EXACT, VORONOI, FORCES, SETTLE)
"""The three methods of the paper, and ours."""


@dataclass(frozen=True, kw_only=True)
class StudySettings:
    """How much is run. seeds: of the small case; steps: the most for it.

    scales, scale_seeds, scale_steps: Figure 20; large_robots, large_steps: Figure 21, large_seeds: of each place of its
    start box, long_steps: how that goes on. timed_steps, timed_seeds: Table 3. gain_seeds: of the sweep in Figure 18;
    claim_seeds: of what the paper has no figure for. process_seeds, process_s: how often, and for how long, robots run
    as processes of their own (Figure 22).
    """

    seeds: int = 10
    steps: int = 2000
    scales: tuple[int, ...] = (9, 25, 100)
    scale_seeds: int = 8
    scale_steps: int = 2500
    large_robots: int = paper.ROBOTS_LARGE
    large_steps: int = paper.STEPS_FIGURE_21
    large_seeds: int = 3
    timed_steps: int = 150
    timed_seeds: int = 8
    gain_seeds: int = 5
    claim_seeds: int = 8
    long_steps: int = 10_000
    process_seeds: int = 8
    process_s: float = 20.0


class Job(NamedTuple):
    """What is to be run: on a map, by a controller, with a seed, for how many steps at most; ``drawn``: with ways."""

    mission: Mission
    controller: Controller
    seed: int
    most_steps: int
    drawn: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class Ways:
    """What is drawn of a run. at: (k,) steps, places_m: (k, n, 2) there. gaps_m: (steps + 1,) least between middles."""

    at: Longs
    places_m: Floats
    gaps_m: Floats

    def places_at(self, step: int) -> Floats:
        """(n, 2) metres at a step, or in the end; of a step between kept ones, the kept step before."""
        places: Floats = self.places_m[int(np.searchsorted(self.at, step, side="right")) - 1]
        return places


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """What a run came to. at_rest: the stop rule ended it. coverage: exact share of the free ground in the end.

    settled: from which step on coverage stays within half a point, inf: it had not. least_m: least distance between two
    middles, obstacle_m: between a middle and an obstacle, inf: there is none. lost: robots that left the area, at most.
    falls, worst_fall: steps by which coverage fell, and by how much at most. At the steps ``at`` (k,): covered, by
    pixels; way_m, mean length of the ways so far; turned, sum over all steps so far of the share of robots that turned
    back. digest: of where robots were when. ways: None where it is not drawn.
    """

    steps: int
    at_rest: bool
    coverage: float
    settled: float
    least_m: float
    obstacle_m: float
    lost: int
    falls: int
    worst_fall: float
    at: Longs
    covered: Floats
    way_m: Floats
    turned: Floats
    straight_m: Floats
    digest: str
    ways: Ways | None = None

    @property
    def drawn(self) -> Ways:
        """The ways of a run that is drawn."""
        assert self.ways is not None
        return self.ways

    def row(self, step: int) -> int:
        """The place in ``at`` of a step that is kept, or of the end where that comes before."""
        return int(np.searchsorted(self.at, min(step, self.steps)))


def kept_steps(steps: int) -> Longs:
    """The steps whose values are kept: moments that tables name, often in the beginning, and the end."""
    grid = {*range(0, 1001, 20), *range(1000, steps, 200), *MOMENTS}
    return np.array(sorted({step for step in grid if step < steps} | {steps}))


def few_of(steps: Longs) -> Longs:
    """``SPARSE_STEPS`` of the steps, evenly spread over them, the first and the last among them."""
    return steps[np.linspace(0, len(steps) - 1, min(SPARSE_STEPS, len(steps))).round().astype(np.int64)]


class Runs(StudyRuns[StudySettings]):
    """Runs of missions by controllers, two at a time, each with a record."""

    def __call__(self, mission: Mission, controller: Controller, *, most_steps: int | None = None) -> Outcome:
        """One run with the first seed, to be drawn."""
        return self.all([Job(mission, controller, self.seed, most_steps or self.settings.steps, drawn=True)])[0]

    def seeds(
        self, mission: Mission, controller: Controller, count: int | None = None, *, most_steps: int | None = None
    ) -> list[Outcome]:
        """Runs with one seed after another, ``count`` or as many as the settings have for the small case."""
        seeds = self.some(count or self.settings.seeds)
        return self.all([Job(mission, controller, seed, most_steps or self.settings.steps) for seed in seeds])

    def some(self, count: int) -> range:
        """So many seeds, from the first on."""
        return range(self.seed, self.seed + count)

    def all(self, jobs: Iterable[Job]) -> list[Outcome]:
        """The outcomes of these runs in their order; the longest should come first, so that none is left at the end."""
        asked = [
            records.Job(
                {"what": "run", **what(job.mission, job.controller), "seed": job.seed, "most_steps": job.most_steps}
                | ({"drawn": True} if job.drawn else {}),
                lambda job=job: self._run(job),  # type: ignore[misc]
            )
            for job in jobs
        ]
        found: list[Outcome] = self.records.get_all(Outcome, asked)
        return found

    def _run(self, job: Job) -> Outcome:
        """Run one job; raises StudyStopped where the study is to stop."""
        self.now(f"{job.mission.name}: {job.controller.name}, seed {job.seed}")
        mission = replace(job.mission, planning=replace(job.controller.settings, most_steps=job.most_steps))
        run = run_mission(mission, seed=job.seed, should_stop=self.should_stop, observed=True)
        self.stop_if_asked()  # what was stopped early is not shown
        return outcome_of(mission, run, drawn=job.drawn)


def what(mission: Mission, controller: Controller | None = None) -> dict[str, object]:
    """What tells a mission, and a controller, apart, for a record."""
    chosen = {"controller": controller.name, "settings": changes(controller.settings)} if controller else {}
    return records.what(mission) | chosen


def outcome_of(mission: Mission, run: SwarmRun, *, drawn: bool = False) -> Outcome:
    """The values that the figures need of an observed run whose trajectories are not thinned."""
    history = run.history
    if history is None:
        raise ValueError("history: None; the run must be observed")
    at, changed = kept_steps(run.steps), np.diff(history.coverage)
    places = places_at_steps(mission, run, at)
    ways = None
    if drawn:
        stride = -(-(run.steps + 1) * len(run.plan.trajectories) // DRAWN_PLACES)
        shown = np.array(sorted({*range(0, run.steps, stride), *at.tolist()})) if stride < SPARSE else few_of(at)
        gaps_m = history.body_gap_m + 2 * paper.BODY_M
        ways = Ways(at=shown, places_m=places_at_steps(mission, run, shown), gaps_m=gaps_m)
    return Outcome(
        steps=run.steps,
        at_rest=run.at_rest,
        coverage=covered_in(mission, places[-1]),
        settled=settled_step(history, at_rest=run.at_rest),
        least_m=float(history.body_gap_m.min()) + 2 * paper.BODY_M,
        obstacle_m=_to_obstacles_m(mission, run),
        lost=int(history.outside.max()),
        falls=int((changed < 0).sum()),
        worst_fall=float(-changed.min(initial=0.0)),
        at=at,
        covered=history.coverage[at],
        way_m=history.way_m[at],
        turned=np.cumsum(history.reversals)[at],
        straight_m=np.hypot(*(places - places[0]).transpose(2, 0, 1)).mean(axis=1),
        digest=plan_digest(run.plan),
        ways=ways,
    )


def places_at_steps(mission: Mission, run: SwarmRun, steps: Longs) -> Floats:
    """(k, n, 2) metres: where robots are at steps (k,)."""
    times_s = steps * SwarmSettings.of(mission).time_step_s
    places = np.empty((len(steps), len(run.plan.trajectories), 2))
    for k, trajectory in enumerate(run.plan):
        for axis in (0, 1):
            places[:, k, axis] = np.interp(times_s, trajectory.times_s, trajectory.positions_m[:, axis])
    return places


def settled_step(history: History, within: float = 0.005, *, at_rest: bool) -> float:
    """The step from which on the coverage stays within a share of its last value, half a point by default.

    at_rest: whether the run ended by ithistory. The last value of a run that was cut off counts only where the
    coverage has stayed there for the last ``PLATEAU`` of its steps; else the result is inf.
    """
    away = np.flatnonzero(np.abs(history.coverage - history.coverage[-1]) > within)
    step = int(away[-1]) + 1 if len(away) else 0
    return step if at_rest or step <= (1 - PLATEAU) * history.steps else math.inf


def _to_obstacles_m(mission: Mission, run: SwarmRun) -> float:
    """The least distance of a robot's middle from an obstacle, at the points of its way; inf without obstacles."""
    if not mission.obstacles:
        return math.inf
    return min(float(obstacle_distances_m(mission, way.positions_m[:, :2]).min()) for way in run.plan)


def obstacle_distances_m(mission: Mission, places_m: Floats) -> Floats:
    """Distances (...,) of places (..., 2) from the nearest obstacle, metres."""
    obstacles = shapely.union_all([obstacle.shape for obstacle in mission.obstacles])
    distances: Floats = shapely.distance(obstacles, shapely.points(places_m.reshape(-1, 2)))
    return distances.reshape(places_m.shape[:-1])


def covered_in(mission: Mission, places_m: Floats) -> float:
    """Exact share of a mission's free ground in range of its robots at places (n, 2)."""
    return covered_share(places_m, sensors_of(mission), free_ground(mission), squares_of(mission))
