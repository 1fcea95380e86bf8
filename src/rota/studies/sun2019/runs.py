"""The runs that the figures are made of: the paper's stages, and plans by its method and by ours, each run once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from rota.compare import MethodOutcome, load_compiled_loops, outcome_of
from rota.geometry.free_space import standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota.mission import DiscSensor, Effort, Method, Mission
from rota.planners.patrol.sun2019.deploy import Deployment, deploy_sensors
from rota.planners.patrol.sun2019.deploy_settings import TABLE_2, TABLE_7, DeploySettings
from rota.planners.patrol.sun2019.frame_settings import TABLE_3, TABLE_4, PartitionSettings, TourSettings
from rota.planners.patrol.sun2019.partition import Partition, partition_frame
from rota.planners.patrol.sun2019.tour import Frame, find_frame
from rota.studies.sun2019.maps import figure_8, figure_13, figure_15


class StudyStopped(Exception):  # noqa: N818 (no fault: somebody asked for it)
    """The study was asked to stop before its end; nothing is written of it."""


@dataclass(frozen=True, kw_only=True)
class StageSettings:
    """How the three algorithms run."""

    deploy: DeploySettings
    tour: TourSettings
    partition: PartitionSettings


@dataclass(frozen=True, kw_only=True)
class StudySettings:
    """What the study runs with. figure_13: Figures 6 to 14; figure_16: Figure 16. effort: of the method ``tours``.

    The defaults are the paper's Tables 2, 3, 4 and 7.
    """

    figure_13: StageSettings = field(
        default_factory=lambda: StageSettings(deploy=TABLE_2, tour=TABLE_3, partition=TABLE_4)
    )
    figure_16: StageSettings = field(
        default_factory=lambda: StageSettings(deploy=TABLE_7, tour=TABLE_3, partition=TABLE_4)
    )
    effort: Effort = "quick"


@dataclass(frozen=True, kw_only=True)
class Stages:
    """What the paper's three algorithms came to on one map."""

    mission: Mission
    deployment: Deployment
    frame: Frame
    partition: Partition


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
        self._tell = tell
        self._should_stop = should_stop
        self._deployments: list[tuple[Mission, DeploySettings, Deployment]] = []
        self._outcomes: list[tuple[Mission, MethodOutcome]] = []

    def deployment(self, mission: Mission, settings: DeploySettings) -> Deployment:
        """Algorithm 1 (or the same without rules)."""
        for known, under, found in self._deployments:
            if known is mission and under == settings:
                return found
        self._begin(f"{mission.name}: deploying sensors")
        found = deploy_sensors(mission, settings, seed=self.seed)
        self._deployments.append((mission, settings, found))
        return found

    def frame(self, mission: Mission, deployment: Deployment, settings: TourSettings) -> Frame:
        """Algorithm 2."""
        self._begin(f"{mission.name}: finding the frame")
        space = ShortestPaths(standing_space(mission, mission.fleet.body_radius_m))
        return find_frame(
            deployment.positions_m,
            deployment.zone_of,
            space,
            virtual_radius_m=deployment.virtual_radius_m,
            settings=settings,
            seed=self.seed,
        )

    def partition(
        self, mission: Mission, deployment: Deployment, frame: Frame, settings: PartitionSettings
    ) -> Partition:
        """Algorithm 3."""
        self._begin(f"{mission.name}: cutting the frame")
        sensor = mission.fleet.sensor
        assert isinstance(sensor, DiscSensor)
        return partition_frame(
            frame.legs_m,
            deployment.periods_s[frame.order],
            speed_m_s=mission.fleet.speed_m_s,
            sensor_radius_m=sensor.radius_m,
            settings=settings,
            seed=self.seed,
        )

    def stages(self, mission: Mission, settings: StageSettings) -> Stages:
        """All three algorithms, one after the other."""
        deployment = self.deployment(mission, settings.deploy)
        frame = self.frame(mission, deployment, settings.tour)
        partition = self.partition(mission, deployment, frame, settings.partition)
        return Stages(mission=mission, deployment=deployment, frame=frame, partition=partition)

    def outcome(self, mission: Mission, method: Method) -> MethodOutcome:
        """A checked plan by one of the methods, or why there is none."""
        for known, found in self._outcomes:
            if known is mission and found.method == method:
                return found
        if not self._outcomes:
            self._begin("loading")
            load_compiled_loops()
        doing = f"{mission.name}: {method}"
        self._begin(doing)
        found = outcome_of(
            mission.with_method(method).with_effort(self.settings.effort),
            seed=self.seed,
            progress=lambda _, what: self._tell(f"{doing}: {what}"),
            should_stop=self._should_stop,
        )
        self._begin(doing)  # what was stopped early is not shown
        self._outcomes.append((mission, found))
        return found

    def _begin(self, doing: str) -> None:
        if self._should_stop():
            raise StudyStopped
        self._tell(doing)
