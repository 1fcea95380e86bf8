"""The runs that the figures are made of: teams on maps from random starts, and plans that watch regions."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from rota.cells.entered_cells import entries_of_cells
from rota.check import check_plan
from rota.errors import NoPlanFound, PlanError
from rota.files.create2_legs import drives_of
from rota.geometry.free_space import free_ground
from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory
from rota.planners.bounce.cells import make_cells
from rota.planners.bounce.coverage import Coverage
from rota.planners.bounce.planner import Bouncing, bouncing_robots, coverage_by, coverage_plan
from rota.planners.bounce.planner_settings import BounceMethod, BounceSettings
from rota.planning.make_plan import search_plan
from rota_studies.alam2020 import paper
from rota_studies.records import DIGEST, drawn_ways, plan_digest, what
from rota_studies.study_runs import StudyRuns

Longs = NDArray[np.int64]
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

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
    """A team's runs by one method, one for each start, (starts,) each.

    steps: that each takes. complete: whether it covers all free cells, share: how many of them. until: steps to
    ``paper.COVERED_FIGURE_9`` of them, -1: never. contacts: steps in which robots are in contact. jumps: turns by the
    clock. digests: hex digits of each joint trajectory.
    """

    seeds: Longs
    cells: int
    steps: Longs
    complete: Flags
    share: Floats
    until: Longs
    contacts: Longs
    jumps: Longs
    digests: tuple[str, ...]

    @property
    def shortest(self) -> int:
        """The number of the run with fewest steps."""
        return int(self.steps.argmin())


@dataclass(frozen=True, kw_only=True)
class Driven:
    """What a Create 2 would have to drive of a plan: times slower than planned, legs, and those ending in a contact."""

    slowing: float
    legs: int
    bumps: int


@dataclass(frozen=True, kw_only=True)
class Drawn:
    """A covering run to be drawn: its robots' ways, and how often each cell, (rows, columns), is entered."""

    ways: tuple[Trajectory, ...]
    entries: Longs


@dataclass(frozen=True, kw_only=True)
class Watching:
    """A plan that watches, as its check sees it.

    gaps_s: the worst between two visits, by zone. clocks_s: by how much clocks may differ, inf: by any time. driven:
    None where a Create 2 cannot.
    """

    verdict: str
    gaps_s: tuple[float, ...]
    violations: int
    clocks_s: float
    driven: Driven | None
    digest: str


class Runs(StudyRuns[StudySettings]):
    """Runs of teams that cover and watch; those of a team have one record."""

    @property
    def starts(self) -> tuple[int, ...]:
        """The seeds of random starts."""
        return tuple(range(self.seed, self.seed + self.settings.starts))

    def cover(self, mission: Mission, method: BounceMethod) -> CoverRuns:
        """The mission's team from as many random starts as the settings have, the same for both methods."""
        return self.records.get(
            CoverRuns,
            self._run("cover", mission, method) | {"seeds": f"{self.seed} to {self.starts[-1]}"},
            lambda: self._covered(mission, method),
        )

    def drawn(self, mission: Mission, method: BounceMethod, seed: int, *, ways: bool) -> Drawn:
        """One of these runs, to be drawn; ``ways``: or only its starts and the cells entered."""

        def make() -> Drawn:
            plan = self.plan(mission, method, seed)
            kept = drawn_ways(plan) if ways else tuple(_begun(way) for way in plan)
            return Drawn(ways=kept, entries=entries_of_cells(plan))

        return self.records.get(Drawn, self._run("draw", mission, method) | {"seed": seed, "ways": ways}, make)

    def driven(self, mission: Mission, method: BounceMethod) -> tuple[Driven | None, ...]:
        """What Create 2 would have to drive of all these runs."""
        return self.records.get(
            tuple[Driven | None, ...],
            self._run("drive", mission, method) | {"seeds": f"{self.seed} to {self.starts[-1]}"},
            lambda: tuple(driven(self.plan(mission, method, seed)) for seed in self.starts),
        )

    def floor_passed(self, mission: Mission, method: BounceMethod) -> Floats:
        """(starts,) share of the ground that bodies pass over in each of these runs."""
        return self.records.get(
            NDArray[np.float64],
            self._run("floor", mission, method) | {"seeds": f"{self.seed} to {self.starts[-1]}"},
            lambda: np.array([floor_passed(self.plan(mission, method, seed)) for seed in self.starts]),
        )

    def watching(self, mission: Mission) -> Watching | None:
        """What ``rota plan`` finds for a mission that watches; None: no plan."""

        def make() -> Watching | None:
            self.now(f"a plan that watches: {mission.name}")
            try:
                search = search_plan(mission, seed=self.seed)
            except NoPlanFound:
                return None
            return watching(search.plan)

        run = {"what": "watch", **what(mission), "seed": self.seed}
        return self.records.get(Watching | None, run, make)

    def plan(self, mission: Mission, method: BounceMethod, seed: int) -> Plan:
        """A covering run as a plan; no record is kept of it."""
        self.now(f"{mission.name}, {method}, start {seed}")
        bouncing = _bouncing(mission, method)
        return coverage_plan(bouncing, coverage_by(bouncing, seed=seed), seed)

    def _run(self, doing: str, mission: Mission, method: BounceMethod) -> dict[str, object]:
        return {"what": doing, **what(mission), "method": method}

    def _covered(self, mission: Mission, method: BounceMethod) -> CoverRuns:
        bouncing = _bouncing(mission, method)
        found = []
        for seed in self.starts:
            self.now(f"covering by {mission.name}, {method}, start {seed}")
            found.append(coverage_by(bouncing, seed=seed))
        return cover_runs(bouncing, found, self.starts)


def _bouncing(mission: Mission, method: BounceMethod) -> Bouncing:
    mission = replace(mission, planning=replace(BounceSettings.of(mission), method=method))
    return bouncing_robots(mission, make_cells(mission))


def cover_runs(bouncing: Bouncing, coverages: Sequence[Coverage], seeds: Sequence[int]) -> CoverRuns:
    """What the runs of a team came to."""
    until = [steps_until(run, bouncing.cells.headings, paper.COVERED_FIGURE_9) for run in coverages]
    return CoverRuns(
        seeds=np.array(seeds),
        cells=bouncing.cells.count,
        steps=np.array([run.steps for run in coverages]),
        complete=np.array([run.complete for run in coverages]),
        share=np.array([run.share for run in coverages]),
        until=np.array([-1 if step is None else step for step in until]),
        contacts=np.array([int((run.contacts > 0).sum()) for run in coverages]),
        jumps=np.array([int((run.jumps >= 0).sum()) for run in coverages]),
        digests=tuple(
            hashlib.sha256(np.ascontiguousarray(run.states, dtype=np.int64).tobytes()).hexdigest()[:DIGEST]
            for run in coverages
        ),
    )


def watching(plan: Plan) -> Watching:
    """A plan that watches, judged by the check."""
    report = check_plan(plan)
    return Watching(
        verdict=report.verdict,
        gaps_s=tuple(demand.worst_gap_s for demand in report.demands),
        violations=len(report.violations),
        clocks_s=math.inf if report.clock_margin_s is None else report.clock_margin_s,
        driven=driven(plan),
        digest=plan_digest(plan),
    )


def driven(plan: Plan) -> Driven | None:
    """What a Create 2 would have to drive of a plan; None where it cannot."""
    try:
        drives = drives_of(plan)
    except PlanError:
        return None
    legs = [leg for drive in drives for leg in drive.legs]
    return Driven(slowing=drives[0].slowing, legs=len(legs), bumps=sum(leg.bumps for leg in legs))


def floor_passed(plan: Plan) -> float:
    """The share of the ground that some body passes over."""
    ground, robots = free_ground(plan.mission), plan.mission.fleet.robots or ()
    bodies = [
        shapely.LineString(way.positions_m[:, :2]).buffer(robot.body_radius_m)
        for way, robot in zip(plan, robots, strict=True)
    ]
    return float(shapely.union_all(bodies).intersection(ground).area / ground.area)


def _begun(way: Trajectory) -> Trajectory:
    """Where a robot stands before it sets out."""
    facing = None if way.headings_rad is None else way.headings_rad[:1]
    return Trajectory(robot=way.robot, times_s=way.times_s[:1], positions_m=way.positions_m[:1], headings_rad=facing)


def steps_until(coverage: Coverage, headings: int, share: float) -> int | None:
    """The step after which that share of the free cells is covered; None: it never is. headings: of the cells."""
    cells = coverage.states // headings
    _, first = np.unique(cells.ravel(), return_index=True)
    entered = np.sort(first // cells.shape[1])
    wanted = math.ceil(share * len(coverage.covered) - 1e-9)
    return int(entered[wanted - 1]) if len(entered) >= wanted else None
