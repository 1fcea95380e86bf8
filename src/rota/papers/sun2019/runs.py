"""The runs that the figures are made of: the paper's stages, and plans by its method and by ours, each run once."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.check import Report, check_plan
from rota.compare import MethodOutcome, load_compiled_loops, outcome_of
from rota.geometry.free_space import standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota.mission import Mission
from rota.papers.study import StudyStopped
from rota.papers.sun2019 import paper
from rota.papers.sun2019.maps import figure_8, figure_13, figure_15, with_periods
from rota.papers.sun2019.printed_settings import AS_PRINTED, AS_PRINTED_FIGURE_16
from rota.plan import Plan, Trajectory
from rota.planners.patrol.context import begin_search
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.methods.sun2019.deploy import Deployment, deploy_sensors
from rota.planners.patrol.methods.sun2019.deploy_settings import DeploySettings
from rota.planners.patrol.methods.sun2019.frame_settings import TourSettings
from rota.planners.patrol.methods.sun2019.partition import Partition, partition_frame
from rota.planners.patrol.methods.sun2019.route_lengths import route_lengths_m
from rota.planners.patrol.methods.sun2019.search import fewest_robots_by_stages, is_good
from rota.planners.patrol.methods.sun2019.settings import MethodSettings
from rota.planners.patrol.methods.sun2019.stages import (
    Framed,
    PartFrame,
    Stages,
    cut_in_segments,
    framed_sensors,
    radius_m,
)
from rota.planners.patrol.methods.sun2019.tour import Frame, find_frame
from rota.planners.patrol.planner_settings import Effort, Method, PatrolSettings, Sun2019
from rota.planners.patrol.verdict import unmet_reason

AS_THE_PAPER = Sun2019(deployment="ccpso2", tour="genetic", partition="pso", routes="repaired")


@dataclass(frozen=True, kw_only=True)
class StudySettings:
    """What the study runs with. figure_13: Figures 6 to 14; figure_16: Figure 16; by default the paper's tables.

    Of several deployments in them the first counts. effort: of all methods. proving_effort: of one more run of
    ``tours`` on Figure 13's map, whose plan may have as few robots as are proved to be needed. further_seeds: what is
    told with a spread runs with so many seeds more.
    """

    figure_13: MethodSettings = AS_PRINTED
    figure_16: MethodSettings = AS_PRINTED_FIGURE_16
    effort: Effort = "quick"
    proving_effort: Effort = "normal"
    further_seeds: int = 2


class Reading(NamedTuple):
    """What may be read in two ways: whether a segment has the leg that leads to it (Eq. 22), and xi_1 of Eq. 28."""

    joining_legs: bool
    weight_late: float


class Printed(NamedTuple):
    """The paper's algorithms run to the end on one map: stages, the routes as a plan, and what the check says of it."""

    mission: Mission
    stages: Stages
    plan: Plan
    report: Report


class Runs:
    """Runs what is asked for, once, with one seed; remembers it, since figures share runs, and the maps they are on.

    tell: called with what is being done. should_stop: asked before every run; True raises StudyStopped.
    """

    def __init__(
        self, settings: StudySettings, *, seed: int, tell: Callable[[str], None], should_stop: Callable[[], bool]
    ) -> None:
        self.settings = settings
        self.seed = seed
        self.map_8, self.map_13, self.map_15 = figure_8(), figure_13(), figure_15()
        self.maps_14 = tuple(with_periods(self.map_13, case.periods_s) for case in paper.TABLE_6)
        self._tell = tell
        self._should_stop = should_stop
        self._framed: list[tuple[Mission, MethodSettings, Framed]] = []
        self._printed: list[tuple[MethodSettings, Printed]] = []
        self._outcomes: list[tuple[Mission, PatrolSettings, MethodOutcome]] = []
        self._lengths: list[tuple[PartFrame, bool, NDArray[np.float64]]] = []
        self._mended: list[tuple[Mission, MethodSettings, MethodOutcome]] = []

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds of runs whose spread is told; the first is the seed of all other runs."""
        return tuple(range(self.seed, self.seed + 1 + self.settings.further_seeds))

    def deployment(self, mission: Mission, settings: DeploySettings, *, seed: int | None = None) -> Deployment:
        """Algorithm 1 (or the same without rules)."""
        seed = self.seed if seed is None else seed
        self._begin(f"{mission.name}: deploying sensors, seed {seed}")
        return deploy_sensors(mission, settings, seed=seed)

    def frame(
        self, mission: Mission, deployment: Deployment, settings: TourSettings, *, seed: int | None = None
    ) -> Frame:
        """Algorithm 2 on ground in one part."""
        seed = self.seed if seed is None else seed
        self._begin(f"{mission.name}: finding the frame, seed {seed}")
        return find_frame(
            deployment.positions_m,
            deployment.zone_of,
            _paths(mission),
            virtual_radius_m=deployment.virtual_radius_m,
            settings=settings,
            seed=seed,
        )

    def framed(self, mission: Mission, settings: MethodSettings, *, seed: int | None = None) -> Framed:
        """Algorithms 1 and 2."""
        seed = self.seed if seed is None else seed
        for known, under, framed in self._framed:
            if known is mission and under == settings and framed.seed == seed:
                return framed
        self._begin(f"{mission.name}: deploying sensors and finding the frame, seed {seed}")
        framed = framed_sensors(mission, _paths(mission), settings.deployments[0], settings, seed=seed)
        self._framed.append((mission, settings, framed))
        return framed

    def cheapest(self, framed: Framed, mission: Mission, settings: MethodSettings, reading: Reading) -> Partition:
        """The partition that Eq. 28 costs least, by one reading of what the paper leaves open; ground in one part."""
        (part,) = framed.parts
        robot, under = mission.fleet.equal_robot("robot-1"), settings.partition
        lengths_m = self._lengths_m(part, mission, settings, reading.joining_legs)
        return partition_frame(
            part.legs_m, part.waypoint_periods_s, speed_m_s=robot.speed_m_s, sensor_radius_m=radius_m(robot),
            route_lengths_m=lengths_m,
            settings=replace(
                under, method="exact", joining_legs=reading.joining_legs, weight_late=reading.weight_late
            ),
        )  # fmt: skip

    def printed(self, mission: Mission, settings: MethodSettings) -> Printed:
        """Algorithms 1 to 3 and the routes round the segments, as the paper has them, judged by the check."""
        for under, known in self._printed:
            if known.mission is mission and under == settings:
                return known
        framed = self.framed(mission, settings)
        self._begin(f"{mission.name}: cutting the frame")
        stages = cut_in_segments(framed, mission.fleet.equal_robot("robot-1"), _paths(mission), settings)
        plan = driven(mission, stages, seed=self.seed)
        self._begin(f"{mission.name}: checking the routes")
        printed = Printed(mission, stages, plan, check_plan(plan))
        self._printed.append((settings, printed))
        return printed

    def _lengths_m(
        self, part: PartFrame, mission: Mission, settings: MethodSettings, joining_legs: bool
    ) -> NDArray[np.float64]:
        """Metres of the routes round all stretches of a frame, with or without the leg that leads to each."""
        if part.route_lengths_m is not None and joining_legs == settings.partition.joining_legs:
            return part.route_lengths_m
        for known, joined, lengths_m in self._lengths:
            if known is part and joined == joining_legs:
                return lengths_m
        self._begin(f"{mission.name}: measuring routes")
        robot = mission.fleet.equal_robot("robot-1")
        lengths_m = route_lengths_m(
            part.frame, part.waypoint_periods_s, _paths(mission), speed_m_s=robot.speed_m_s, radius_m=radius_m(robot),
            joining_legs=joining_legs, settings=settings.route,
        )  # fmt: skip
        self._lengths.append((part, joining_legs, lengths_m))
        return lengths_m

    def mended(self, mission: Mission, settings: MethodSettings) -> MethodOutcome:
        """A checked plan by the same settings, with routes repaired until all is seen in time."""
        for known, under, outcome in self._mended:
            if known is mission and under == settings:
                return outcome
        doing = f"{mission.name}: mending the paper's routes"
        self._begin(doing)
        planning = PatrolSettings(effort=self.settings.effort, method="sun2019", sun2019=AS_THE_PAPER)
        asked, began_s = replace(mission, planning=planning), time.perf_counter()
        context = begin_search(
            set_up_problem(asked), asked=asked, seed=self.seed, judge=check_plan, should_stop=self._should_stop,
            progress=lambda _, what: self._tell(f"{doing}: {what}"),
        )  # fmt: skip
        route = replace(settings.route, routes="repaired")
        best = fewest_robots_by_stages(context, replace(settings, route=route))
        self._begin(doing)  # what was stopped early is not shown
        outcome = MethodOutcome(
            method="sun2019", plan=best.plan, report=check_plan(best.plan), planning_s=time.perf_counter() - began_s,
            reason=None if is_good(best) else unmet_reason(best.plan, best.verdict),
        )  # fmt: skip
        self._mended.append((mission, settings, outcome))
        return outcome

    def by_method(self, mission: Mission, method: Method, *, effort: Effort | None = None) -> MethodOutcome:
        """A checked plan by a method as it is by default, at the study's effort or another one."""
        return self._outcome(mission, PatrolSettings(effort=effort or self.settings.effort, method=method))

    def _outcome(self, mission: Mission, planning: PatrolSettings) -> MethodOutcome:
        """The plan of a mission by a method, made once; raises StudyStopped where the study is to stop."""
        for known, under, outcome in self._outcomes:
            if known is mission and under == planning:
                return outcome
        if not self._outcomes:
            self._begin("loading")
            load_compiled_loops()
        doing = f"{mission.name}: {planning.method}"
        self._begin(doing)
        outcome = outcome_of(
            replace(mission, planning=planning),
            seed=self.seed,
            progress=lambda _, what: self._tell(f"{doing}: {what}"),
            should_stop=self._should_stop,
        )
        self._begin(doing)  # what was stopped early is not shown
        self._outcomes.append((mission, planning, outcome))
        return outcome

    def _begin(self, doing: str) -> None:
        """Tell what begins; raises StudyStopped where the study is to stop."""
        if self._should_stop():
            raise StudyStopped
        self._tell(doing)


def driven(mission: Mission, stages: Stages, *, seed: int) -> Plan:
    """The segments' routes driven by a robot each, at full speed and for ever; nothing is mended."""
    trajectories = []
    for k, segment in enumerate(stages.segments):
        ring_m = np.vstack([segment.route_m, segment.route_m[:1]])
        legs_m = np.hypot(*np.diff(ring_m, axis=0).T)
        moved = np.append(True, legs_m > 0)
        times_s = np.append(0.0, np.cumsum(legs_m))[moved] / mission.fleet.speed_m_s
        trajectories.append(Trajectory(robot=f"robot-{k + 1}", times_s=times_s, positions_m=ring_m[moved]))
    return Plan(mission=mission, trajectories=tuple(trajectories), seed=seed)


def _paths(mission: Mission) -> ShortestPaths:
    """The shortest paths of the space in which the fleet's bodies can stand."""
    return ShortestPaths(standing_space(mission, mission.fleet.body_radius_m))
