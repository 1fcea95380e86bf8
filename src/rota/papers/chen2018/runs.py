"""The runs that the figures are made of: a map, a controller and a seed each, run once, two at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.geometry.free_space import free_ground
from rota.mission import Mission
from rota.papers.chen2018 import paper
from rota.papers.study import StudyStopped
from rota.planners.swarm.metrics import History, covered_share
from rota.planners.swarm.planner import SwarmRun, run_mission, sensors_of, squares_of
from rota.planners.swarm.planner_settings import SwarmSettings

Floats = NDArray[np.float64]

AT_A_TIME = 2
KEPT_PLACES = 1_000_000  # of one run: so many places at most, evenly spread over its steps


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

    scales, scale_seeds, scale_steps: Figure 20; large_robots, large_steps: Figure 21, long_steps: how that goes on.
    timed_steps: Table 3. gain_seeds: of the sweep in Figure 18; claim_seeds: of what the paper has no figure for.
    process_seeds, process_s: how often, and for how long, robots run as processes of their own (Figure 22).
    """

    seeds: int = 10
    steps: int = 2000
    scales: tuple[int, ...] = (9, 25, 49, 100, 225)
    scale_seeds: int = 3
    scale_steps: int = 4000
    large_robots: int = paper.ROBOTS_LARGE
    large_steps: int = paper.STEPS_FIGURE_21
    timed_steps: int = 400
    gain_seeds: int = 5
    claim_seeds: int = 5
    long_steps: int = 20_000
    process_seeds: int = 3
    process_s: float = 20.0


class Job(NamedTuple):
    """What is to be run: on a map, by a controller, with a seed, for no more steps than that."""

    mission: Mission
    controller: Controller
    seed: int
    most_steps: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """What a run came to. at_rest: the stop rule ended it. coverage: exact share of the free ground in the end.

    places_m: (k, n, 2) metres, at every ``stride``-th step and in the end.
    """

    steps: int
    at_rest: bool
    coverage: float
    history: History
    places_m: Floats
    stride: int

    def places_at(self, step: int) -> Floats:
        """(n, 2) metres at a step, or in the end; of a step between kept ones, the kept step before."""
        places: Floats = self.places_m[-1] if step >= self.steps else self.places_m[step // self.stride]
        return places


class Runs:
    """Runs what is asked for, once; remembers it, since figures share runs.

    seed: the first of the seeds. tell: called with what is being done. should_stop: asked before every run and within;
    True raises StudyStopped.
    """

    def __init__(
        self, settings: StudySettings, *, seed: int, tell: Callable[[str], None], should_stop: Callable[[], bool]
    ) -> None:
        self.settings = settings
        self.seed = seed
        self.tell = tell
        self.should_stop = should_stop
        self._known: dict[tuple[str, str, int, int], Outcome] = {}

    def __call__(self, mission: Mission, controller: Controller, *, most_steps: int | None = None) -> Outcome:
        """One run with the first seed."""
        return self.seeds(mission, controller, 1, most_steps=most_steps)[0]

    def seeds(
        self, mission: Mission, controller: Controller, count: int | None = None, *, most_steps: int | None = None
    ) -> list[Outcome]:
        """Runs with one seed after another, ``count`` or as many as the settings have for the small case."""
        count = count or self.settings.seeds
        jobs = [Job(mission, controller, self.seed + k, most_steps or self.settings.steps) for k in range(count)]
        return self.all(jobs)

    def all(self, jobs: Iterable[Job]) -> list[Outcome]:
        """The outcomes of these runs in their order; runs that are not known yet are made."""
        jobs = list(jobs)
        missing = list(dict.fromkeys(_key(job) for job in jobs if _key(job) not in self._known))
        by_key = {_key(job): job for job in jobs}
        if missing:
            self.stop_if_asked()
            # the longest runs first, so that none is left alone at the end; results do not depend on the order
            with ThreadPoolExecutor(AT_A_TIME) as pool:
                for key, outcome in zip(missing, pool.map(self._run, [by_key[key] for key in missing]), strict=True):
                    self._known[key] = outcome
        return [self._known[_key(job)] for job in jobs]

    def stop_if_asked(self) -> None:
        """Raise StudyStopped when somebody asked for it."""
        if self.should_stop():
            raise StudyStopped

    def _run(self, job: Job) -> Outcome:
        """Run one job; raises StudyStopped where the study is to stop."""
        self.stop_if_asked()
        self.tell(f"{job.mission.name}: {job.controller.name}, seed {job.seed}")
        mission = replace(job.mission, planning=replace(job.controller.settings, most_steps=job.most_steps))
        run = run_mission(mission, seed=job.seed, should_stop=self.should_stop, observed=True)
        self.stop_if_asked()  # what was stopped early is not shown
        return outcome_of(mission, run)


def outcome_of(mission: Mission, run: SwarmRun) -> Outcome:
    """The values that the figures need of an observed run whose trajectories are not thinned."""
    if run.history is None:
        raise ValueError("history: None; the run must be observed")
    stride = -(-(run.steps + 1) * len(run.plan.trajectories) // KEPT_PLACES)
    kept = [*range(0, run.steps + 1, stride), run.steps]
    times_s = np.array(kept) * SwarmSettings.of(mission).time_step_s
    places = np.empty((len(kept), len(run.plan.trajectories), 2))
    for k, trajectory in enumerate(run.plan):
        for axis in (0, 1):
            places[:, k, axis] = np.interp(times_s, trajectory.times_s, trajectory.positions_m[:, axis])
    return Outcome(
        steps=run.steps,
        at_rest=run.at_rest,
        coverage=covered_in(mission, places[-1]),
        history=run.history,
        places_m=places,
        stride=stride,
    )


def covered_in(mission: Mission, places_m: Floats) -> float:
    """Exact share of a mission's free ground in range of its robots at places (n, 2)."""
    return covered_share(places_m, sensors_of(mission), free_ground(mission), squares_of(mission))


def _key(job: Job) -> tuple[str, str, int, int]:
    """What tells a job apart from all others."""
    return job.mission.name, job.controller.name, job.seed, job.most_steps
