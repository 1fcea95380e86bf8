"""The runs that the figures are made of: a team on a map from random starts, each run once."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rota.mission import Mission
from rota.papers.alam2020 import paper
from rota.papers.study import StudyStopped
from rota.plan import Plan
from rota.planners.bounce.cells import make_cells
from rota.planners.bounce.coverage import Coverage
from rota.planners.bounce.planner import Bouncing, bouncing_robots, coverage_plan, covered_by
from rota.planners.bounce.planner_settings import BounceMethod, BounceSettings

Longs = NDArray[np.int64]

METHODS: tuple[BounceMethod, ...] = ("as_printed", "improved")


@dataclass(frozen=True, kw_only=True)
class StudySettings:
    """How much is run. starts: random ones of each team. layouts: random ones beside Figures 7 and 8,
    on which runs end after ``layout_steps``.

    region_pairs: random target regions of Figures 10 and 11.
    error_steps: after which chances are told; walks: simulated for each of them.
    """

    starts: int = paper.RUNS
    layouts: int = 10
    layout_steps: int = 10_000
    region_pairs: int = 200
    error_steps: int = 300
    walks: int = 10_000


@dataclass(frozen=True, kw_only=True, eq=False)
class CoverRuns:
    """A team's runs by one method, one for each start."""

    bouncing: Bouncing
    coverages: tuple[Coverage, ...]
    seeds: tuple[int, ...]

    @property
    def steps(self) -> Longs:
        """(starts,) steps that each takes."""
        return np.array([run.steps for run in self.coverages])

    @property
    def complete(self) -> int:
        """How many cover all free cells."""
        return sum(run.complete for run in self.coverages)

    @property
    def contacts(self) -> Longs:
        """(starts,) steps of each in which robots are in contact."""
        return np.array([int((run.contacts > 0).sum()) for run in self.coverages])

    @property
    def jumps(self) -> Longs:
        """(starts,) turns of each by the clock."""
        return np.array([int((run.jumps >= 0).sum()) for run in self.coverages])

    @property
    def shortest(self) -> int:
        """The number of the run with fewest steps."""
        return int(self.steps.argmin())

    def plan(self, run: int) -> Plan:
        """A run as a plan."""
        return coverage_plan(self.bouncing, self.coverages[run], self.seeds[run])


class Runs:
    """Runs what is asked for, once; remembers it.

    seed: the first of the seeds. tell: called with what is being done. should_stop: asked before every run; True raises
    StudyStopped.
    """

    def __init__(
        self, settings: StudySettings, *, seed: int, tell: Callable[[str], None], should_stop: Callable[[], bool]
    ) -> None:
        self.settings = settings
        self.seed = seed
        self._tell = tell
        self._should_stop = should_stop
        self._known: dict[tuple[bytes, str, str], CoverRuns] = {}

    def now(self, doing: str) -> None:
        """Tell what is being done next; raise StudyStopped when somebody asked for it."""
        if self._should_stop():
            raise StudyStopped
        self._tell(doing)

    def cover(self, mission: Mission, method: BounceMethod) -> CoverRuns:
        """The mission's team from as many random starts as the settings have, the same for both methods."""
        mission = replace(mission, planning=replace(BounceSettings.of(mission), method=method))
        key = (b"".join(o.shape.wkb for o in mission.obstacles) + mission.area.wkb, mission.name, method)
        if key not in self._known:
            bouncing = bouncing_robots(mission, make_cells(mission))
            seeds = tuple(range(self.seed, self.seed + self.settings.starts))
            coverages = []
            for start in seeds:
                self.now(f"covering by {mission.name}, {method}, start {start}")
                coverages.append(covered_by(bouncing, seed=start))
            self._known[key] = CoverRuns(bouncing=bouncing, coverages=tuple(coverages), seeds=seeds)
        return self._known[key]


def steps_until(coverage: Coverage, headings: int, share: float) -> int | None:
    """The step after which that share of the free cells is covered; None: it never is. headings: of the cells."""
    cells = coverage.states // headings
    _, first = np.unique(cells.ravel(), return_index=True)
    entered = np.sort(first // cells.shape[1])
    wanted = math.ceil(share * len(coverage.covered) - 1e-9)
    return int(entered[wanted - 1]) if len(entered) >= wanted else None
