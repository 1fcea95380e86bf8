"""A mission made ready for the search: where robots can stand, what must be seen, and from where it can be."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon

from rota.errors import NoPlanFound
from rota.geometry.free_space import DemandedRegion, border_segments, demanded_regions, sight_walls, standing_space
from rota.geometry.kernels import EdgeGrid
from rota.geometry.line_of_sight import edge_grid
from rota.geometry.shortest_path import MOST_DENSE, ShortestPaths
from rota.mission import DiscSensor, Effort, Fleet, Mission, Robot, SquareSensor, inner_reach_m
from rota.planners.patrol.ground.limits_of_sight import (
    fine_arc_corners,
    has_rim,
    rim_points,
    with_reach_for,
)
from rota.planners.patrol.ground.nearest_places import nearest_places
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.samples import MANY_CORNERS, SamplePoints, joined, prepare, region_points
from rota.planners.patrol.ground.unseeable import refuse_unseeable
from rota.planners.patrol.ground.viewpoints import (
    candidate_places,
    place_that_sees,
    search_unseen,
    sensor_arguments,
    what_places_see,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_SAMPLES = 400_000
COARSEST, COARSEST_PLACES = (
    0.5,
    0.9,
)  # of the reach: spacing of samples and of places on very large ground, which has more
SAMPLES_PER_REACH: dict[Effort, int] = {"quick": 8, "normal": 12, "high": 16}
# of the lattice's spacing: what lies between its points is then nearly always seen too, or needs a point of its own
SHRINK: dict[Effort, float] = {"quick": 0.4, "normal": 0.2, "high": 0.15}
LARGE_SHRINK, MANY_SAMPLES = 0.5, 100_000
COARSE_ARC_CORNERS = 8  # of a whole turn round corners of ground that has very many of them
HAIR_M = 1e-6  # less than this inside of the sensor's reach counts for nothing


@dataclass(frozen=True, kw_only=True)
class Problem:
    """What the search works on.

    periods_s: the classes, ascending. places_m (c, 2): candidates to look from; sees_start, sees_item: which of the
    prepared samples each sees. ``points`` stand in the order of the prepared ``samples``.
    """

    mission: Mission
    robot: Robot
    periods_s: tuple[float, ...]
    regions: tuple[DemandedRegion, ...]
    region_class: tuple[int, ...]
    space: MultiPolygon
    space_grid: EdgeGrid
    paths: ShortestPaths
    walls: Floats
    points: SamplePoints
    samples: Samples
    places_m: Floats
    places_part: Ints
    sees_start: Ints
    sees_item: Ints
    ideal_robots: float
    range_margin_m: float
    spacing_m: float
    rim_places_m: Floats  # (m, 2) on the border of the space: the rim of all that can be seen is seen from there only

    @property
    def reach_m(self) -> float:
        """Radius of the sensor's disc, or half the side of its square."""
        return inner_reach_m(self.robot.sensor)

    @property
    def is_ragged(self) -> bool:
        """Whether the ground has very many corners, as that of a scanned floor has."""
        return len(self.paths.corners_m) > MOST_DENSE

    @property
    def swath_m(self) -> float:
        """Width of the lane that a moving robot sees, where nothing hides anything."""
        return 2 * self.reach_m


def common_robot(fleet: Fleet) -> Robot:
    """A robot that every robot of the fleet can stand in for: the slowest, with the shortest reach, the widest body."""
    robots = fleet.robots or (fleet.equal_robot("robot-1"),)
    sensors = [robot.sensor for robot in robots]
    if all(isinstance(sensor, SquareSensor) for sensor in sensors):
        sensor: DiscSensor | SquareSensor = min(sensors, key=lambda sensor: sensor.reach_m)
    else:
        sensor = DiscSensor(radius_m=min(inner_reach_m(sensor) for sensor in sensors))
    rates = [robot.turn_rate_rad_s for robot in robots if robot.turn_rate_rad_s is not None]
    return Robot(
        name="common",
        speed_m_s=min(robot.speed_m_s for robot in robots),
        sensor=sensor,
        body_radius_m=max(robot.body_radius_m for robot in robots),
        turn_rate_rad_s=min(rates) if rates else None,
    )


def range_margin(reach_m: float) -> float:
    """How much shorter than its reach a sensor is taken, so that the check need not go below its finest pieces."""
    return min(0.05 * reach_m, max(0.004 * reach_m, 0.012))


def set_up_problem(mission: Mission) -> Problem:
    """Lay out everything the search needs; raises NoPlanFound when too much can be seen from nowhere."""
    robot = common_robot(mission.fleet)
    reach_m = inner_reach_m(robot.sensor)
    regions = demanded_regions(mission)
    periods_s = tuple(sorted({region.period_s for region in regions}))
    region_class = tuple(periods_s.index(region.period_s) for region in regions)
    margin_m = range_margin(reach_m)
    space, rim = space_and_rim(mission, regions, robot, margin_m)
    walls = sight_walls(mission)
    parts, spacing_m = lattices(mission, regions, region_class, space, reach_m)
    rim_places_m = np.zeros((0, 2))
    if rim:
        parts.append(rim_points(regions, region_class, space, robot, margin_m=margin_m, spacing_m=spacing_m))
        rim_places_m = nearest_places(parts[-1].xy_m, space, walls, robot)[0]
    points, samples, _ = laid_out(joined(parts), walls, robot)
    places_m = candidate_places(space, 0.5 * reach_m, COARSEST_PLACES * reach_m)
    points, samples, further_m, hopeless, unseeable = places_for_all(
        points, samples, places_m, space, walls, robot, margin_m
    )
    refuse_unseeable(mission, points, unseeable, regions)
    if len(hopeless):
        keep = np.ones(len(points), dtype=bool)
        keep[hopeless] = False
        points, samples, _ = laid_out(points[keep], walls, robot)
    places_m = np.vstack([places_m, further_m])
    start, items = what_places_see(places_m, robot, margin_m, samples)
    paths = ShortestPaths(space)
    return Problem(
        mission=mission,
        robot=robot,
        periods_s=periods_s,
        regions=regions,
        region_class=region_class,
        space=space,
        space_grid=edge_grid(border_segments(space)),
        paths=paths,
        walls=walls,
        points=points,
        samples=samples,
        places_m=places_m,
        places_part=paths.part_of(places_m),
        sees_start=start,
        sees_item=items,
        ideal_robots=sum(
            r.shape.area / (2 * reach_m * robot.speed_m_s * r.period_s) for r in regions if r.demand == "every_point"
        ),
        range_margin_m=margin_m,
        spacing_m=spacing_m,
        rim_places_m=rim_places_m,
    )


def space_and_rim(
    mission: Mission, regions: tuple[DemandedRegion, ...], robot: Robot, margin_m: float
) -> tuple[MultiPolygon, bool]:
    """Where the robot can stand, and whether the rim of what it sees from there lies in the regions.

    Round corners as fine as a rim, or a zone that is entered only there, needs it. Raises NoPlanFound when there is no
    place to stand at all, or none in a zone that asks for visits.
    """
    body_m = robot.body_radius_m
    corners = shapely.get_num_coordinates([mission.area, *(obstacle.shape for obstacle in mission.obstacles)]).sum()
    space = standing_space(mission, body_m, arc_corners=16 if corners <= MANY_CORNERS else COARSE_ARC_CORNERS)
    visits = [region for region in regions if region.demand == "visit"]
    rim = has_rim(regions, space, robot, margin_m)
    if rim or any(shapely.disjoint(region.shape, space) for region in visits):
        space = standing_space(mission, body_m, arc_corners=fine_arc_corners(body_m))
    if space.is_empty:
        raise NoPlanFound(f"there is no place where a body of radius {body_m} m can stand")
    for region in visits:
        if shapely.disjoint(region.shape, space):
            spot = region.shape.representative_point()
            fits = "blocked to motion" if body_m == 0 else f"no place for a body of radius {body_m} m"
            raise NoPlanFound(
                f"no robot can be inside zone {region.name}, at ({spot.x:.2f}, {spot.y:.2f}): it is {fits}"
            )
    return space, rim


def lattices(
    mission: Mission,
    regions: tuple[DemandedRegion, ...],
    region_class: tuple[int, ...],
    space: MultiPolygon,
    reach_m: float,
) -> tuple[list[SamplePoints], float]:
    """The sample points of each region, and the spacing of their lattices in metres: finer for more effort."""
    effort = mission.patrol.effort
    asked_m2 = sum(region.shape.area for region in regions if region.demand == "every_point")
    spacing_m = min(float(np.sqrt(asked_m2 / MOST_SAMPLES)), COARSEST * reach_m)
    spacing_m = max(reach_m / SAMPLES_PER_REACH[effort], spacing_m)
    # on large areas rounds of mending cost more than a little overlap
    shrink = SHRINK[effort] if asked_m2 < MANY_SAMPLES * spacing_m**2 else LARGE_SHRINK
    parts = [
        region_points(
            region, i, region_class[i], space, spacing_m=spacing_m, shrink_m=shrink * spacing_m, inset_m=0.002 * reach_m
        )
        for i, region in enumerate(regions)
    ]
    return parts, spacing_m


def laid_out(points: SamplePoints, walls: Floats, robot: Robot) -> tuple[SamplePoints, Samples, Ints]:
    """The points in the order in which the kernels take them, and as they take them, and that order.

    They weigh what their area is.
    """
    reach_m, _ = sensor_arguments(robot, 0.0)
    samples, order = prepare(
        points, walls, reach_m=robot.sensor.reach_m, weight=points.area_m2, wall_margin_m=0.001 * reach_m
    )
    return points[order], samples, order


def places_for_all(
    points: SamplePoints,
    samples: Samples,
    places_m: Floats,
    space: MultiPolygon,
    walls: Floats,
    robot: Robot,
    margin_m: float,
) -> tuple[SamplePoints, Samples, Floats, Ints, Ints]:
    """Further places for samples that no candidate place (n, 2) sees; at the rim of what can be seen with full reach.

    The points and samples, their shrink fitted to the places; the further places (m, 2); the samples that none of the
    places sees; and those of them that surely nobody can see.
    """

    def sees(place_m: Floats) -> Ints:
        return what_places_see(place_m[None], robot, margin_m, samples)[1]

    unseen = np.ones(len(points), dtype=bool)
    unseen[what_places_see(places_m, robot, margin_m, samples)[1]] = False
    further_m, left = search_unseen(
        np.flatnonzero(unseen),
        lambda i: place_that_sees(points.xy_m[i], float(points.visit_m[i]), space, walls, robot, margin_m),
        sees,
    )
    if not len(left):
        return points, samples, further_m, left, left
    nearest_m, ranges_m = nearest_places(points.xy_m[left], space, walls, robot)
    reach_m, _ = sensor_arguments(robot, 0.0)
    shrink_m = points.shrink_m.copy()
    shrink_m[left] = with_reach_for(points[left], ranges_m, reach_m, margin_m).shrink_m
    on_lattice = np.isin(np.arange(len(points)), left, invert=True)  # which has one shrink for all its points
    points = replace(
        points,
        shrink_m=shrink_m,
        row=np.where(on_lattice, points.row, -1),
        column=np.where(on_lattice, points.column, -1),
    )
    points, samples, order = laid_out(points, walls, robot)
    left = np.argsort(order)[left]
    near = {
        int(i): nearest_m[k] for k, i in enumerate(left) if reach_m - ranges_m[k] > HAIR_M and points.visit_m[i] == 0
    }
    last_m, hopeless = search_unseen(left, near.get, sees)
    surely = np.isin(hopeless, left[(ranges_m > reach_m) | (points.visit_m[left] > 0)])
    return points, samples, np.vstack([further_m, last_m]), hopeless, hopeless[surely]


def stretched(problem: Problem, stretch: float) -> Problem:
    """The same problem with all periods multiplied by ``stretch``."""
    mission = problem.mission
    zones = tuple(
        zone if zone.period_s is None else replace(zone, period_s=stretch * zone.period_s) for zone in mission.zones
    )
    outside_s = None if mission.period_s is None else stretch * mission.period_s
    return replace(
        problem,
        mission=replace(mission, zones=zones, period_s=outside_s),
        periods_s=tuple(stretch * period_s for period_s in problem.periods_s),
        regions=tuple(replace(region, period_s=stretch * region.period_s) for region in problem.regions),
        ideal_robots=problem.ideal_robots / stretch,
    )
