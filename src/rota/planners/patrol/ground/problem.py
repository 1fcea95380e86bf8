"""A mission made ready for the search: where robots can stand, what must be seen, and from where it can be."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from shapely import MultiPolygon, Polygon

from rota.errors import NoPlanFound
from rota.geometry.free_space import DemandedRegion, demanded_regions, sight_walls
from rota.geometry.shortest_path import MOST_DENSE, ShortestPaths
from rota.model.arrays import Floats
from rota.model.mission import DiscSensor, Fleet, Mission, Robot, SquareSensor, inner_reach_m
from rota.model.motion_limits import weakest
from rota.planners.patrol.driving.corner_costs import pace_on_lanes
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.efforts import EFFORTS
from rota.planners.patrol.ground.fewer_corners import with_fewer_corners
from rota.planners.patrol.ground.limits_of_sight import limit_points
from rota.planners.patrol.ground.nearest_places import nearest_places
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.samples import SamplePoints, join, known_walls, lay_out, region_points
from rota.planners.patrol.ground.sight import Sight
from rota.planners.patrol.ground.standing import clear_body_m, space_for, thin_m
from rota.planners.patrol.ground.unseeable import refuse_much_unseeable, refuse_unseeable
from rota.planners.patrol.ground.viewpoints import (
    Viewpoints,
    places_that_see_all,
    what_places_see,
)
from rota.planners.patrol.loop_settings import SamplingSettings
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.tolerances import OUT_OF_REACH
from rota.planning.stopping import require_going_on


@dataclass(frozen=True, kw_only=True)
class Problem:
    """What the search works on.

    robot: any robot of the fleet can stand in for it. regions: what must be seen or visited how often. space, paths:
    where the robot's centre may be, and the shortest paths there. sure_space: see ``StandingSpace``. walls: (k, 4)
    metres, the borders of what blocks sight. points: what tours are made to see, in the order of ``samples``, which are
    the same as the kernels take them. viewpoints: places from which all of them are seen. at_limit: whether some of
    them lie at the limit of sight, which is seen from the border of the space alone. range_margin_m: by how much less
    than its reach the sensor is taken to see. lanes_overlap_m: by how much lanes do, on either side, where they are
    bent round many small obstacles. spacing_m: between the points of the lattices. kept_off: parts of the space, by
    their numbers, that were cut back from ground about a robot that stays in another part, each with that ground.
    waits_m: of parts whose robots step aside for others, by their numbers, the places (x, y) where they wait meanwhile.
    """

    mission: Mission
    robot: Robot
    regions: tuple[DemandedRegion, ...]
    space: MultiPolygon
    sure_space: MultiPolygon
    paths: ShortestPaths
    walls: Floats
    points: SamplePoints
    samples: Samples
    viewpoints: Viewpoints
    at_limit: bool
    range_margin_m: float
    spacing_m: float
    lanes_overlap_m: float = 0.0
    kept_off: tuple[tuple[int, Polygon], ...] = ()
    waits_m: tuple[tuple[int, tuple[float, float]], ...] = ()

    @cached_property
    def periods_s(self) -> tuple[float, ...]:
        """The period classes: all periods of the regions, ascending."""
        return periods_of(self.regions)

    @cached_property
    def region_class(self) -> tuple[int, ...]:
        """The period class of each region."""
        return tuple(self.periods_s.index(region.period_s) for region in self.regions)

    @property
    def sure_robot(self) -> Robot:
        """The robot with the body that is clear of walls everywhere in ``sure_space``: all of it is free of them."""
        body_m = clear_body_m(self.mission, thin_m(self.mission, self.robot))
        return self.robot if self.sure_space is self.space else replace(self.robot, body_radius_m=body_m)

    @property
    def reach_m(self) -> float:
        """Radius of the sensor's disc, or half the side of its square."""
        return inner_reach_m(self.robot.sensor)

    @cached_property
    def asked_m2(self) -> float:
        """Area of all ground of which every point must be seen."""
        return float(sum(region.shape.area for region in self.regions if region.demand == "every_point"))

    @property
    def is_ragged(self) -> bool:
        """Whether walls run as ragged as those of a scanned floor: of very many corners, or full of nooks."""
        return len(self.paths.corners_m) > MOST_DENSE or self.is_full_of_nooks

    @cached_property
    def is_full_of_nooks(self) -> bool:
        """Whether much lies in nooks that no body enters: it is seen through slits, for which samples are too few."""
        nooks = count_nooks(self.walls, min(0.1 * self.reach_m, self.robot.body_radius_m))
        return nooks > max(50, self.asked_m2 / self.reach_m**2)  # one for each square of the reach

    @property
    def pace_m_s(self) -> float:
        """Its robot's usual speed, see ``Driving``."""
        return driving_of(self.robot).pace_m_s

    def lanes_m(self, ground_m2: float) -> float:
        """Metres at the pace of perfect lanes over a square of this ground; with mass, their ends cost time."""
        driving, length_m = driving_of(self.robot), ground_m2 / self.swath_m
        if not driving.has_mass or driving.slopes is None or ground_m2 == 0:
            return length_m
        lane_m = math.sqrt(ground_m2)
        return length_m * (1 + self.swath_m / lane_m) * driving.pace_m_s / pace_on_lanes(driving, lane_m)

    @property
    def swath_m(self) -> float:
        """Width of the lane that a moving robot sees, where nothing hides anything."""
        return 2 * self.reach_m


def set_up_problem(
    mission: Mission, *, is_whole: bool = True, should_stop: Callable[[], bool] = lambda: False
) -> Problem:
    """Lay out everything the search needs.

    is_whole: False for a part of a mission, which may hold all the ground that nobody sees of the whole. Raises
    NoPlanFound when the robots can stand nowhere, or in no place of a zone to visit, and when more can be seen from
    nowhere than the mission allows, or nothing at all can be seen. So it does once ``should_stop``, asked between the
    steps: nothing that could go on is there yet.
    """
    go_on = partial(require_going_on, should_stop, "all that the mission asks for was laid out")
    robot, regions = common_robot(mission.fleet), demanded_regions(mission)
    margin_m = range_margin(inner_reach_m(robot.sensor))
    roomy = with_fewer_corners(mission, inner_reach_m(robot.sensor), robot.body_radius_m)
    space, sure_space, at_limit, robot = space_for(roomy, regions, robot, margin_m)
    go_on()
    walls = sight_walls(mission)
    sure_sight = Sight(sure_space, walls, robot, 0.0)
    if is_whole:
        refuse_much_unseeable(mission, regions, sure_sight)
    go_on()
    sampling = EFFORTS[PatrolSettings.of(mission).effort].sampling
    if mission.fleet.robots is not None:  # the least ratio of a fixed team comes no lower with finer samples
        sampling = replace(sampling, few_samples=0)
    points, spacing_m = points_of_regions(regions, space, robot, sampling)
    go_on()
    if at_limit:
        classes = [periods_of(regions).index(region.period_s) for region in regions]
        last = limit_points(regions, classes, space, robot, range_margin_m=margin_m, spacing_m=spacing_m)
        points = join([points, last])
        go_on()
    points, hopeless = surely_seen(points, space, sure_space, walls, robot)
    go_on()
    seen = places_that_see_all(points, Sight(space, walls, robot, margin_m))
    beside = np.append(seen.unseeable, len(points) + np.arange(len(hopeless)))
    refuse_unseeable(mission, join([seen.points, hopeless]), beside, regions, sure_sight)
    points, samples = seen.points, seen.samples
    if len(seen.unseen):
        kept = np.setdiff1d(np.arange(len(points)), seen.unseen)
        if not len(kept):
            raise NoPlanFound("nothing of what is asked can be seen from where robots can be")
        points, samples, _ = lay_out(points[kept], walls, robot, known=known_walls(samples, kept))
    go_on()
    paths = ShortestPaths(space)
    seen_from = what_places_see(seen.places_m, robot, margin_m, samples)
    return Problem(
        mission=mission, robot=robot, regions=regions, space=space, sure_space=sure_space, paths=paths, walls=walls,
        points=points, samples=samples,
        viewpoints=Viewpoints(seen.places_m, paths.part_of(seen.places_m), *seen_from),
        at_limit=at_limit, range_margin_m=margin_m, spacing_m=spacing_m,
        lanes_overlap_m=0.0 if roomy is mission else float(points.shrink_m.max(initial=0.0)),
    )  # fmt: skip


def count_nooks(walls: Floats, most_m: float) -> int:
    """The corners between walls (k, 4), both shorter than ``most_m``, that follow each other, of over half a radian."""
    step = walls[:, 2:] - walls[:, :2]
    before, after = step[:-1], step[1:]
    turn = np.arctan2(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], (before * after).sum(axis=1))
    short = np.hypot(*step.T) < most_m
    follows = (walls[:-1, 2:] == walls[1:, :2]).all(axis=1)
    return int(np.count_nonzero(short[:-1] & short[1:] & follows & (np.abs(turn) > 0.5)))


def surely_seen(
    points: SamplePoints, space: MultiPolygon, sure_space: MultiPolygon, walls: Floats, robot: Robot
) -> tuple[SamplePoints, SamplePoints]:
    """The points that are seen from the sure space, or are for a visit; and those of the lattice that nobody sees.

    What is only just out of reach is in neither: the whole space may see it. All are sure where the spaces are one.
    """
    if sure_space is space:
        return points, points[np.zeros(0, dtype=np.int64)]
    reach_m, ranges_m = inner_reach_m(robot.sensor), nearest_places(points.xy_m, sure_space, walls, robot)[1]
    sure = (ranges_m <= reach_m) | (points.visit_m > 0)
    hidden = ~sure & (ranges_m > OUT_OF_REACH * reach_m) & (points.shrink_m > 0)
    return points[np.flatnonzero(sure)], points[np.flatnonzero(hidden)]


def periods_of(regions: tuple[DemandedRegion, ...]) -> tuple[float, ...]:
    """All periods of the regions in seconds, ascending."""
    return tuple(sorted({region.period_s for region in regions}))


def common_robot(fleet: Fleet) -> Robot:
    """A robot that every robot of the fleet can stand in for: the slowest, with the shortest reach, the widest body."""
    robots = fleet.unlike_robots
    sensors = [robot.sensor for robot in robots]
    if all(isinstance(sensor, SquareSensor) for sensor in sensors):
        sensor: DiscSensor | SquareSensor = min(sensors, key=lambda sensor: sensor.reach_m)
    else:
        sensor = DiscSensor(radius_m=min(inner_reach_m(sensor) for sensor in sensors))
    rates = [robot.turn_rate_rad_s for robot in robots if robot.turn_rate_rad_s is not None]
    return Robot(
        name="common",
        speed_m_s=min(robot.ground_speed_m_s for robot in robots),
        sensor=sensor,
        body_radius_m=max(robot.body_radius_m for robot in robots),
        turn_rate_rad_s=min(rates) if rates else None,
        turn_radius_m=max(robot.turn_radius_m for robot in robots),
        motion=weakest(robot.motion for robot in robots),
    )


def range_margin(reach_m: float) -> float:
    """How much shorter than its reach a sensor is taken, so that the check need not go below its finest pieces."""
    return min(0.05 * reach_m, max(0.004 * reach_m, 0.012))


def points_of_regions(
    regions: tuple[DemandedRegion, ...], space: MultiPolygon, robot: Robot, settings: SamplingSettings
) -> tuple[SamplePoints, float]:
    """The points that stand for all regions, and the spacing of their lattices in metres."""
    reach_m = inner_reach_m(robot.sensor)
    asked_m2 = sum(region.shape.area for region in regions if region.demand == "every_point")
    spacing_m = min(float(np.sqrt(asked_m2 / settings.most_samples)), reach_m / 2)
    usual_m = max(reach_m / settings.per_reach, spacing_m)
    spacing_m = finer_spacing_m(asked_m2, reach_m, settings, usual_m)
    shrink = settings.shrink if spacing_m == usual_m else 0.2  # as with twelve samples a reach at effort normal
    if asked_m2 >= 100_000 * spacing_m**2:
        shrink = 0.5  # on large ground a little overlap costs less than rounds of repair
    periods_s = periods_of(regions)
    each = [
        region_points(
            region, i, periods_s.index(region.period_s), space,
            spacing_m=spacing_m, shrink_m=shrink * spacing_m, inset_m=0.002 * reach_m,
        )
        for i, region in enumerate(regions)
    ]  # fmt: skip
    return join(each), spacing_m


def finer_spacing_m(asked_m2: float, reach_m: float, settings: SamplingSettings, usual_m: float) -> float:
    """The spacing in metres on ground that the usual spacing gives few samples; else the usual one."""
    if settings.few_samples == 0:
        return usual_m
    # more than twelve samples a reach spare no robot on small ground
    finer_m = max(reach_m / 12, float(np.sqrt(asked_m2 / settings.few_samples)))
    return min(usual_m, finer_m)


def stretch_periods(problem: Problem, stretch: float) -> Problem:
    """The same problem with all periods multiplied by ``stretch``."""
    regions = tuple(replace(region, period_s=stretch * region.period_s) for region in problem.regions)
    return replace(problem, mission=stretch_mission(problem.mission, stretch), regions=regions)


def stretch_mission(mission: Mission, stretch: float) -> Mission:
    """The same mission with all periods multiplied by ``stretch``."""
    zones = tuple(
        zone if zone.period_s is None else replace(zone, period_s=stretch * zone.period_s) for zone in mission.zones
    )
    return replace(mission, zones=zones, period_s=None if mission.period_s is None else stretch * mission.period_s)
