"""The runs that the figures are made of: the paper's stages, and plans by its method and by ours, each recorded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from rota.check import check_plan
from rota.compare import MethodOutcome, load_compiled_loops, outcome_of
from rota.geometry.free_space import demanded_regions, standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import Mission
from rota.planners.patrol.context import begin_search
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.planner_settings import Effort, Method, PatrolSettings
from rota.planners.patrol.verdict import unmet_reason
from rota.planning.planner import Request
from rota_studies.plain import changes
from rota_studies.records import mission_digest, what
from rota_studies.study_runs import StudyRuns
from rota_studies.sun2019 import paper
from rota_studies.sun2019.kept import found_of, printed_of
from rota_studies.sun2019.maps import figure_8, figure_13, figure_15, with_periods
from rota_studies.sun2019.printed_settings import AS_PRINTED, AS_PRINTED_FIGURE_16
from rota_studies.sun2019.results import Cut, Found, Printed, Sensors, Way, cut_of, sensors_of, way_of
from rota_studies.sun2019_method.algorithms import PaperAlgorithms, TourSettings, algorithms_of
from rota_studies.sun2019_method.deploy import DeploySettings
from rota_studies.sun2019_method.mission_settings import Sun2019
from rota_studies.sun2019_method.partition import PartitionSettings, cut_frame
from rota_studies.sun2019_method.route_lengths import route_lengths_m
from rota_studies.sun2019_stages.deploy import Deployment, deploy_sensors
from rota_studies.sun2019_stages.frame import Frame, PartFrame, radius_m
from rota_studies.sun2019_stages.graph import proximity_graph
from rota_studies.sun2019_stages.search import fewest_robots_by_stages, is_good
from rota_studies.sun2019_stages.stages import Framed, cut_in_segments, framed_sensors
from rota_studies.sun2019_stages.tour import find_frame

Ints = NDArray[np.int64]
T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class StudySettings:
    """What the study runs with. figure_13: Figures 6 to 14; figure_16: Figure 16; by default the paper's tables.

    effort: of all methods. proving_effort: of one more run of
    ``tours`` on Figure 13's map, whose plan may have as few robots as are proved to be needed. seeds: of all that
    verdicts rest on; reading_seeds: of readings that no verdict rests on.
    """

    figure_13: Sun2019 = AS_PRINTED
    figure_16: Sun2019 = AS_PRINTED_FIGURE_16
    effort: Effort = "quick"
    proving_effort: Effort = "normal"
    seeds: int = 8
    reading_seeds: int = 3


class Reading(NamedTuple):
    """What may be read in two ways: whether a segment has the leg that leads to it (Eq. 22), and xi_1 of Eq. 28."""

    joining_legs: bool
    weight_late: float


class Graph(NamedTuple):
    """The proximity graph of Section 4.3: its edges, pairs of sensors (m, 2), and in how many parts it falls."""

    edges: Ints
    parts: int


class Runs(StudyRuns[StudySettings]):
    """Runs of the paper's stages on its maps, by seed, and plans by its method and by ours."""

    def __init__(self, settings: StudySettings, **shared: Any) -> None:
        super().__init__(settings, **shared)
        self.map_8, self.map_13, self.map_15 = figure_8(), figure_13(), figure_15()
        self.figure_13 = algorithms_of(settings.figure_13, settings.effort)
        self.figure_16 = algorithms_of(settings.figure_16, settings.effort)
        self.maps_14 = tuple(with_periods(self.map_13, case.periods_s) for case in paper.TABLE_6)
        self._made: dict[tuple[Any, ...], Any] = {}  # stages that several runs begin with; of them no record is kept

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds of runs that verdicts rest on; the first is that of pictures, and of plans by methods."""
        return tuple(range(self.seed, self.seed + self.settings.seeds))

    @property
    def reading_seeds(self) -> tuple[int, ...]:
        """Those of readings that no verdict rests on."""
        return self.seeds[: self.settings.reading_seeds]

    def sensors(self, mission: Mission, settings: DeploySettings, seed: int) -> Sensors:
        """Algorithm 1, or the same without rules."""
        run = {"what": "deployment", **what(mission), "settings": changes(settings), "seed": seed}
        return self.records.get(Sensors, run, lambda: sensors_of(self._deployed(mission, settings, seed)))

    def way(self, mission: Mission, deploy: DeploySettings, tour: TourSettings, seed: int) -> Way:
        """Algorithm 2, or a local search, over the sensors of a deployment with the same seed."""

        def make() -> Way:
            deployment = self._deployed(mission, deploy, seed)
            return way_of(self._toured(mission, deploy, tour, seed), deployment.zone_of, len(deployment.zones))

        run = {
            "what": "frame", **what(mission), "deployment": changes(deploy), "settings": changes(tour), "seed": seed,
        }  # fmt: skip
        return self.records.get(Way, run, make)

    def graph(self, mission: Mission, settings: PaperAlgorithms, seed: int) -> Graph:
        """The proximity graph over the sensors."""

        def make() -> Graph:
            """The graph by r_n alone, without alpha."""
            deployment = self._deployed(mission, settings.deployments[0], seed)
            range_m = settings.tour.neighbour_range * deployment.virtual_radius_m
            found = proximity_graph(
                deployment.positions_m, deployment.zone_of, _paths(mission), neighbour_range_m=range_m, alpha=0.0
            )
            n = len(found.positions_m)
            ends = np.repeat(np.arange(n), np.diff(found.start))
            links = csr_array((np.ones(len(ends)), (ends, found.items)), shape=(n, n))
            once = ends < found.items
            return Graph(np.column_stack([ends[once], found.items[once]]), int(connected_components(links)[0]))

        run = {"what": "graph", **what(mission), "settings": _stages(settings), "seed": seed}
        return self.records.get(Graph, run, make)

    def printed(self, mission: Mission, settings: PaperAlgorithms, seed: int | None = None) -> Printed:
        """Algorithms 1 to 3 and the routes round the segments, as the paper has them, judged by the check.

        seed: None for that of the pictures, whose routes are drawn.
        """
        at = self.seed if seed is None else seed

        def make() -> Printed:
            framed = self._framed(mission, settings, at)
            self.now(f"{mission.name}: cutting the frame, seed {at}")
            stages = cut_in_segments(framed, mission.fleet.equal_robot("robot-1"), _paths(mission), settings)
            return printed_of(mission, stages, seed=at, drawn=at == self.seed)

        run = {"what": "as printed", **what(mission), "settings": _stages(settings), "seed": at}
        return self.records.get(Printed, run, make)

    def cheapest(self, mission: Mission, settings: PaperAlgorithms, reading: Reading, seed: int) -> Cut:
        """The partition that Eq. 28 costs least, by one reading of what the paper leaves open; ground in one part."""

        def make() -> Cut:
            """The one part of the frame, cut by dynamic programming."""
            (part,) = self._framed(mission, settings, seed).parts
            robot = mission.fleet.equal_robot("robot-1")
            under = replace(
                settings.partition, method="exact", joining_legs=reading.joining_legs, weight_late=reading.weight_late
            )
            lengths_m = self._lengths_m(part, mission, settings, reading.joining_legs, seed)
            return cut_of(
                cut_frame(
                    part.legs_m, part.waypoint_periods_s, speed_m_s=robot.speed_m_s, sensor_radius_m=radius_m(robot),
                    route_lengths_m=lengths_m, settings=under,
                )
            )  # fmt: skip

        run = {
            "what": "cheapest partition", **what(mission), "settings": _stages(settings), **reading._asdict(),
            "seed": seed,
        }  # fmt: skip
        return self.records.get(Cut, run, make)

    def cut_exactly(self, mission: Mission, deploy: DeploySettings, tour: TourSettings, seed: int) -> Cut:
        """The fewest segments of a frame by Eq. 26 as it is estimated: what a frame is worth in robots."""

        def make() -> Cut:
            frame, robot = self._toured(mission, deploy, tour, seed), mission.fleet.equal_robot("robot-1")
            periods_s = self._deployed(mission, deploy, seed).periods_s[frame.order]
            return cut_of(
                cut_frame(
                    frame.legs_m, periods_s, speed_m_s=robot.speed_m_s, sensor_radius_m=radius_m(robot),
                    settings=PartitionSettings(joining_legs=True),
                )
            )  # fmt: skip

        run = {
            "what": "exact partition", **what(mission), "deployment": changes(deploy), "tour": changes(tour),
            "seed": seed,
        }  # fmt: skip
        return self.records.get(Cut, run, make)

    # ------------------------------------------------------------ plans

    def mended(self, mission: Mission, settings: PaperAlgorithms) -> Found:
        """A checked plan by the same settings, with routes repaired until all is seen in time."""
        doing = f"{mission.name}: mending the paper's routes"

        def make() -> Found:
            """The plan of the same stages, repaired and judged."""
            self.now(doing)
            planning = PatrolSettings(effort=self.settings.effort, method="sun2019")
            asked = replace(mission, planning=planning)
            request = Request(
                mission=asked, seed=self.seed, judge=check_plan, should_stop=self.should_stop,
                progress=lambda _, what: self.tell(f"{doing}: {what}"),
            )  # fmt: skip
            context = begin_search(set_up_problem(asked), request)
            best = fewest_robots_by_stages(context, replace(settings, routes="repaired"))
            self.stop_if_asked()  # what was stopped early is not shown
            reason = None if is_good(best) else unmet_reason(best.plan, best.verdict)
            report = check_plan(best.plan)
            outcome = MethodOutcome(method="sun2019", plan=best.plan, report=report, planning_s=0.0, reason=reason)
            return found_of(outcome, drawn=True)

        run = {
            "what": "mended", **what(mission), "settings": _stages(settings), "effort": self.settings.effort,
            "seed": self.seed,
        }  # fmt: skip
        return self.records.get(Found, run, make)

    def by_method(self, mission: Mission, method: Method, *, effort: Effort | None = None) -> Found:
        """The plan of a mission by a method."""
        planning = PatrolSettings(effort=effort or self.settings.effort, method=method)
        doing = f"{mission.name}: {method}, {planning.effort}"

        def make() -> Found:
            """The plan of the method, or why there is none."""
            self.now(doing)
            load_compiled_loops()
            outcome = outcome_of(
                replace(mission, planning=planning),
                seed=self.seed,
                progress=lambda _, what: self.tell(f"{doing}: {what}"),
                should_stop=self.should_stop,
            )
            self.stop_if_asked()
            return found_of(outcome, drawn=method == "tours")

        run = {"what": "plan", **what(mission), "method": method, "effort": planning.effort, "seed": self.seed}
        return self.records.get(Found, run, make)

    # ------------------------------------------------------------ without records

    def _once(self, key: tuple[Any, ...], make: Callable[[], T]) -> T:
        """What several runs begin with, made once."""
        if key not in self._made:
            self._made[key] = make()
        found: T = self._made[key]
        return found

    def _deployed(self, mission: Mission, settings: DeploySettings, seed: int) -> Deployment:
        """The deployment, that of the whole frame where there is one."""
        for under in (self.figure_13, self.figure_16):
            if settings == under.deployments[0] and mission.name != self.map_8.name:
                return self._framed(mission, under, seed).deployment

        def make() -> Deployment:
            self.now(f"{mission.name}: deploying sensors, seed {seed}")
            return deploy_sensors(mission, settings, seed=seed)

        return self._once(("deployed", mission_digest(mission), settings, seed), make)

    def _toured(self, mission: Mission, deploy: DeploySettings, tour: TourSettings, seed: int) -> Frame:
        """The frame past the sensors of a deployment."""

        def make() -> Frame:
            deployment = self._deployed(mission, deploy, seed)
            self.now(f"{mission.name}: finding the frame, seed {seed}")
            return find_frame(
                deployment.positions_m, deployment.zone_of, _paths(mission),
                virtual_radius_m=deployment.virtual_radius_m, algorithm=tour, seed=seed,
            )  # fmt: skip

        return self._once(("toured", mission_digest(mission), deploy, tour, seed), make)

    def _framed(self, mission: Mission, settings: PaperAlgorithms, seed: int) -> Framed:
        """Algorithms 1 and 2. They heed the order of the periods only, so that maps with the same order share them."""
        names = tuple(region.name for region in sorted(demanded_regions(mission), key=lambda region: region.period_s))

        def make() -> Framed:
            self.now(f"{mission.name}: deploying sensors and finding the frame, seed {seed}")
            return framed_sensors(mission, _paths(mission), settings.deployments[0], settings, seed=seed)

        framed: Framed = self._once(("framed", mission.area.wkb, names, settings, seed), make)
        return self._once(
            ("retimed", mission_digest(mission), settings, seed), lambda: retimed(framed, mission, settings)
        )

    def _lengths_m(
        self, part: PartFrame, mission: Mission, settings: PaperAlgorithms, joining_legs: bool, seed: int
    ) -> NDArray[np.float64]:
        """Metres of the routes round all stretches of a frame, with or without the leg that leads to each."""
        if part.route_lengths_m is not None and joining_legs == settings.partition.joining_legs:
            return part.route_lengths_m

        def make() -> NDArray[np.float64]:
            self.now(f"{mission.name}: measuring routes, seed {seed}")
            robot = mission.fleet.equal_robot("robot-1")
            return route_lengths_m(
                part.frame, part.waypoint_periods_s, _paths(mission), speed_m_s=robot.speed_m_s,
                radius_m=radius_m(robot), joining_legs=joining_legs,
            )  # fmt: skip

        return self._once(("lengths", mission_digest(mission), settings, joining_legs, seed), make)


def _stages(settings: PaperAlgorithms) -> dict[str, Any]:
    """What all stages run with that differs from its defaults, by the names that records have."""
    routes = {} if settings.routes == "shortened" else {"routes": settings.routes}
    told = {"tour": changes(settings.tour), "partition": changes(settings.partition), "route": routes}
    return {
        "deployment": changes(settings.deployments[0]),
        **{stage: changed for stage, changed in told.items() if changed},
    }


def retimed(framed: Framed, mission: Mission, settings: PaperAlgorithms) -> Framed:
    """The same sensors and frames with a mission's own periods, whose order is the same."""
    periods_s = {region.name: region.period_s for region in demanded_regions(mission)}
    zones = tuple(replace(zone, period_s=periods_s[zone.name]) for zone in framed.deployment.zones)
    deployment, robot = replace(framed.deployment, zones=zones), mission.fleet.equal_robot("robot-1")
    parts = []
    for part in framed.parts:
        along_s, lengths_m = deployment.periods_s[part.sensors][part.frame.order], part.route_lengths_m
        if lengths_m is not None and not np.array_equal(along_s, part.waypoint_periods_s):
            lengths_m = route_lengths_m(
                part.frame, along_s, _paths(mission), speed_m_s=robot.speed_m_s, radius_m=radius_m(robot),
                joining_legs=settings.partition.joining_legs,
            )  # fmt: skip
        parts.append(replace(part, waypoint_periods_s=along_s, route_lengths_m=lengths_m))
    return replace(framed, deployment=deployment, parts=tuple(parts))


def _paths(mission: Mission) -> ShortestPaths:
    """The shortest paths of the space in which the fleet's bodies can stand."""
    return ShortestPaths(standing_space(mission, mission.fleet.body_radius_m))
