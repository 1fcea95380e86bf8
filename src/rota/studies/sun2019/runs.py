"""The runs that the figures are made of: the paper's stages, and plans by its method and by ours, each run once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from rota.check import Report, check_plan
from rota.compare import MethodOutcome, load_compiled_loops, outcome_of
from rota.geometry.free_space import standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota.mission import Effort, Mission, PatrolSettings, Sun2019
from rota.plan import Plan, Trajectory
from rota.planners.patrol.sun2019.deploy import Deployment, deploy_sensors
from rota.planners.patrol.sun2019.deploy_settings import DeploySettings
from rota.planners.patrol.sun2019.frame_settings import TourSettings
from rota.planners.patrol.sun2019.settings import AS_PRINTED, AS_PRINTED_FIGURE_16, MethodSettings
from rota.planners.patrol.sun2019.stages import Framed, Stages, cut_in_segments, framed_sensors
from rota.planners.patrol.sun2019.tour import Frame, find_frame
from rota.studies.study import StudyStopped
from rota.studies.sun2019 import paper
from rota.studies.sun2019.maps import figure_8, figure_13, figure_15, with_periods


@dataclass(frozen=True, kw_only=True)
class StudySettings:
    """What the study runs with. figure_13: Figures 6 to 14; figure_16: Figure 16; by default the paper's tables.

    Of several deployments in them the first counts. effort: of the methods ``sun2019`` and ``tours``.
    """

    figure_13: MethodSettings = AS_PRINTED
    figure_16: MethodSettings = AS_PRINTED_FIGURE_16
    effort: Effort = "quick"


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

    def deployment(self, mission: Mission, settings: DeploySettings) -> Deployment:
        """Algorithm 1 (or the same without rules)."""
        self._begin(f"{mission.name}: deploying sensors")
        return deploy_sensors(mission, settings, seed=self.seed)

    def frame(self, mission: Mission, deployment: Deployment, settings: TourSettings) -> Frame:
        """Algorithm 2 on ground in one part."""
        self._begin(f"{mission.name}: finding the frame")
        return find_frame(
            deployment.positions_m,
            deployment.zone_of,
            _paths(mission),
            virtual_radius_m=deployment.virtual_radius_m,
            settings=settings,
            seed=self.seed,
        )

    def framed(self, mission: Mission, settings: MethodSettings) -> Framed:
        """Algorithms 1 and 2."""
        for known, under, found in self._framed:
            if known is mission and under == settings:
                return found
        self._begin(f"{mission.name}: deploying sensors and finding the frame")
        found = framed_sensors(mission, _paths(mission), settings.deployments[0], settings, seed=self.seed)
        self._framed.append((mission, settings, found))
        return found

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
        found = Printed(mission, stages, plan, check_plan(plan))
        self._printed.append((settings, found))
        return found

    def by_stages(self, mission: Mission, stages: Sun2019 | None = None) -> MethodOutcome:
        """A checked plan by the method ``sun2019``, its stages as given or as the method chooses."""
        planning = PatrolSettings(effort=self.settings.effort, method="sun2019", sun2019=stages or Sun2019())
        return self._outcome(mission, planning)

    def by_tours(self, mission: Mission) -> MethodOutcome:
        """A checked plan by the method ``tours``."""
        return self._outcome(mission, PatrolSettings(effort=self.settings.effort))

    def _outcome(self, mission: Mission, planning: PatrolSettings) -> MethodOutcome:
        for known, under, found in self._outcomes:
            if known is mission and under == planning:
                return found
        if not self._outcomes:
            self._begin("loading")
            load_compiled_loops()
        doing = f"{mission.name}: {planning.method}"
        self._begin(doing)
        found = outcome_of(
            replace(mission, planning=planning),
            seed=self.seed,
            progress=lambda _, what: self._tell(f"{doing}: {what}"),
            should_stop=self._should_stop,
        )
        self._begin(doing)  # what was stopped early is not shown
        self._outcomes.append((mission, planning, found))
        return found

    def _begin(self, doing: str) -> None:
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
    return ShortestPaths(standing_space(mission, mission.fleet.body_radius_m))
