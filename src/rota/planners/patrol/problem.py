"""A mission made ready for the search: where robots can stand, what must be seen, and from where it can be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon

from rota.errors import NoPlanFound
from rota.geometry.free_space import DemandedRegion, border_segments, demanded_regions, sight_walls, standing_space
from rota.geometry.kernels import EdgeGrid
from rota.geometry.line_of_sight import edge_grid
from rota.geometry.shortest_path import ShortestPaths
from rota.mission import DiscSensor, Fleet, Mission, Robot, SquareSensor
from rota.planners.patrol.kernels import Samples
from rota.planners.patrol.proved_bound import prove_bound
from rota.planners.patrol.samples import SamplePoints, joined, prepare, region_points
from rota.planners.patrol.start.viewpoints import candidate_places, place_that_sees, search_unseen, what_places_see

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_SAMPLES = 400_000
SAMPLES_PER_REACH = 8
SHRINK = 0.4  # of the lattice's spacing: what lies between its points is then nearly always seen too
LARGE_SHRINK, MANY_SAMPLES = 0.5, 100_000
MOST_EXCLUDED = 0.05  # of the demanded area: beyond it, planning always stops


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
    seeable_m2: tuple[float, ...]  # of each region, at least; 0 for zones to visit
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
    lower_bound: int
    lower_bound_reason: str
    ideal_robots: float
    enough_robots: int  # fewer need not be looked for: the bound, or a fleet's fixed number
    range_margin_m: float
    spacing_m: float

    @property
    def reach_m(self) -> float:
        """Radius of the sensor's disc, or half the side of its square."""
        sensor = self.robot.sensor
        return sensor.radius_m if isinstance(sensor, DiscSensor) else sensor.side_m / 2

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
        inner = [s.radius_m if isinstance(s, DiscSensor) else s.side_m / 2 for s in sensors]
        sensor = DiscSensor(radius_m=min(inner))
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
    reach_m = robot.sensor.radius_m if isinstance(robot.sensor, DiscSensor) else robot.sensor.side_m / 2
    regions = demanded_regions(mission)
    periods_s = tuple(sorted({region.period_s for region in regions}))
    region_class = tuple(periods_s.index(region.period_s) for region in regions)
    space = standing_space(mission, robot.body_radius_m)
    if space.is_empty:
        raise NoPlanFound(f"there is no place where a body of radius {robot.body_radius_m} m can stand")
    asked_m2 = sum(region.shape.area for region in regions if region.demand == "every_point")
    spacing_m = max(reach_m / SAMPLES_PER_REACH, float(np.sqrt(asked_m2 / MOST_SAMPLES)))
    walls = sight_walls(mission)
    margin_m = range_margin(reach_m)
    # on large areas rounds of mending cost more than a little overlap
    shrink = SHRINK if asked_m2 < MANY_SAMPLES * spacing_m**2 else LARGE_SHRINK
    points = joined(
        [
            region_points(
                region, i, region_class[i], spacing_m=spacing_m, shrink_m=shrink * spacing_m, inset_m=0.002 * reach_m
            )
            for i, region in enumerate(regions)
        ]
    )
    samples, order = prepare(
        points, walls, reach_m=robot.sensor.reach_m, weight=points.area_m2, wall_margin_m=0.001 * reach_m
    )
    points = points[order]
    places_m = candidate_places(space, 0.5 * reach_m)
    start, items = what_places_see(places_m, robot, margin_m, samples)
    unseen = np.ones(len(points), dtype=bool)
    unseen[items] = False
    further_m, hopeless = search_unseen(
        points,
        np.flatnonzero(unseen),
        lambda point_m, visit_m: place_that_sees(point_m, visit_m, space, walls, robot, margin_m),
        lambda place_m: what_places_see(place_m[None], robot, margin_m, samples)[1].astype(np.int64),
    )
    asked_shapes = [region.shape for region in regions if region.demand == "every_point"]
    refuse_unseeable(mission, points, hopeless, asked_shapes)
    areas = seeable_areas(regions, points, hopeless, spacing_m)
    if len(hopeless):
        keep = np.ones(len(points), dtype=bool)
        keep[hopeless] = False
        points = points[keep]
        samples, order = prepare(
            points, walls, reach_m=robot.sensor.reach_m, weight=points.area_m2, wall_margin_m=0.001 * reach_m
        )
        points = points[order]
    places_m = np.vstack([places_m, further_m])
    start, items = what_places_see(places_m, robot, margin_m, samples)
    paths = ShortestPaths(space)
    bound = prove_bound(mission, regions, areas, points, start, items)
    return Problem(
        mission=mission,
        robot=robot,
        periods_s=periods_s,
        regions=regions,
        seeable_m2=tuple(areas),
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
        lower_bound=bound.robots,
        lower_bound_reason=bound.reason,
        enough_robots=max(bound.robots, len(mission.fleet.robots or ())),
        ideal_robots=sum(
            r.shape.area / (2 * reach_m * robot.speed_m_s * r.period_s) for r in regions if r.demand == "every_point"
        ),
        range_margin_m=margin_m,
        spacing_m=spacing_m,
    )


def seeable_areas(
    regions: tuple[DemandedRegion, ...], points: SamplePoints, hopeless: Ints, spacing_m: float
) -> list[float]:
    """A safe (low) estimate of each region's area that can be seen; 0 for zones that ask for visits.

    Round every point that nobody can see four lattice squares are taken away: the bound must stay a bound.
    """
    areas = []
    for i, region in enumerate(regions):
        lost = 4 * spacing_m**2 * int((points.region[hopeless] == i).sum())
        areas.append(max(0.0, region.shape.area - lost) if region.demand == "every_point" else 0.0)
    return areas


def refuse_unseeable(mission: Mission, points: SamplePoints, hopeless: Ints, asked_shapes: list[MultiPolygon]) -> None:
    """Stop when a visit is impossible, or what cannot be seen is refused by the mission or is too much of it."""
    visits = hopeless[points.visit_m[hopeless] > 0]
    if len(visits):
        x, y = points.xy_m[visits[0]]
        raise NoPlanFound(f"no robot can be inside the zone at ({x:.2f}, {y:.2f}): its body does not fit there")
    inside = hopeless[points.shrink_m[hopeless] > 0]  # the lattice; border points stand for no ground of their own
    # squares of the lattice stick out of narrow ground: only what lies on demanded ground is lost
    half_m = np.sqrt(points.area_m2[inside]) / 2
    x, y = points.xy_m[inside].T
    squares = shapely.union_all(shapely.box(x - half_m, y - half_m, x + half_m, y + half_m))
    lost_m2 = float(shapely.area(shapely.intersection(squares, shapely.union_all(asked_shapes))))
    asked_m2 = sum(shape.area for shape in asked_shapes)
    share = lost_m2 / asked_m2 if asked_m2 > 0 else 0.0
    if share <= MOST_EXCLUDED and (mission.unseeable == "exclude" or not len(hopeless)):
        return
    blobs = shapely.get_parts(
        shapely.union_all(
            shapely.buffer(shapely.points(points.xy_m[hopeless]), 1e-9 + np.sqrt(points.area_m2[hopeless]))
        )
    )
    blobs = sorted(blobs, key=lambda blob: -float(blob.area))[:5]
    places = ", ".join(f"({blob.centroid.x:.2f}, {blob.centroid.y:.2f})" for blob in blobs)
    allowed = "unseeable: refuse allows none" if mission.unseeable == "refuse" else f"{MOST_EXCLUDED:.0%} is allowed"
    raise NoPlanFound(
        f"about {lost_m2:.2f} m2 ({share:.1%} of what is asked) cannot be seen from anywhere a robot can stand,"
        f" for instance round {places}; {allowed}"
    )
