"""Small random missions, each from its seed: holes, bent and starred grounds, obstacles, zones, bodies, turning.

Every mission has room for its robots to pass each other, can be seen whole (but for corners) and is small enough for
one to about six robots, so that a planner has no excuse; all else is drawn.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import shapely
from shapely import MultiPolygon, Point, Polygon, affinity, box

from rota.errors import MissionError
from rota.model.mission import Blocks, Demand, DiscSensor, Fleet, Mission, Obstacle, Sensor, SquareSensor, Zone
from rota.planners.patrol.planner_settings import PatrolSettings

DRAWS = 1000  # of one seed, until a mission is fair
LEAST_SEEABLE = 0.985  # share of the ground that a robot comes near enough to, walls left aside
MOST_ROBOTS = 6.0  # worth of sweeping
LEAST_VISIT_M2 = 1.0  # of a zone to visit, where robots can stand
GROUNDS = ("rectangle", "convex", "star", "L", "U", "courtyard", "two halves")


def random_mission(seed: int) -> Mission:
    """The mission of this seed: always the same. Raises RuntimeError when no fair one was drawn."""
    rng = np.random.default_rng(seed)
    for _ in range(DRAWS):
        try:
            mission = drawn(rng, f"random-{seed}")
        except MissionError:  # a zone beside the ground, say
            continue
        if is_fair(mission):
            return mission
    raise RuntimeError(f"seed {seed}: no fair mission in {DRAWS} draws")


def described(mission: Mission) -> str:
    """What the mission is like, in a few words."""
    fleet = mission.fleet
    parts = [f"{mission.area.area:.0f} m2"]
    holes = sum(len(part.interiors) for part in mission.area.geoms)
    parts += [f"{len(mission.area.geoms)} grounds"] * (len(mission.area.geoms) > 1) + [f"{holes} hole"] * (holes > 0)
    parts += [f"{o.blocks} obstacle" if o.blocks != "both" else "obstacle" for o in mission.obstacles]
    for zone in mission.zones:
        parts.append("zone without period" if zone.period_s is None else f"{zone.demand} zone {zone.period_s:g} s")
    parts.append("square" if isinstance(fleet.sensor, SquareSensor) else "disc")
    parts += [f"body {fleet.body_radius_m:g} m"] * (fleet.body_radius_m > 0)
    parts += [f"turning {fleet.turn_rate_rad_s} rad/s"] * (fleet.turn_rate_rad_s is not None)
    parts += [f"{len(fleet.robots)} robots"] if fleet.robots is not None else []
    return ", ".join(parts)


# ---------------------------------------------------------------- what is drawn


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """A number to two decimals, so that a mission can be typed in."""
    return round(float(rng.uniform(low, high)), 2)


def drawn(rng: np.random.Generator, name: str) -> Mission:
    """A mission, fair or not; raises MissionError where the draws do not fit together."""
    area = ground(rng)
    reach_m, speed_m_s = between(rng, 3, 8), between(rng, 0.8, 8)
    body_m = between(rng, 0.05, 0.3) if rng.random() < 0.35 else 0.0
    robots = between(rng, 0.4, 3.5)  # worth of sweeping within the area's period
    period_s = round(area.area / (2 * reach_m * speed_m_s * robots), 1)
    blocks = obstacles(rng, area, clear_m=max(0.5, 6 * body_m))
    sensor: Sensor = DiscSensor(radius_m=reach_m)
    if rng.random() < 0.2:
        sensor = SquareSensor(side_m=round(1.7 * reach_m, 2))
    fleet = Fleet(
        speed_m_s=speed_m_s,
        sensor=sensor,
        body_radius_m=body_m,
        turn_rate_rad_s=between(rng, 0.8, 4) if rng.random() < 0.2 else None,
    )
    mission = Mission(
        name=name,
        area=area,
        obstacles=blocks,
        zones=zones(rng, area, period_s),
        period_s=period_s,
        fleet=fleet,
        planning=PatrolSettings(effort="quick"),
    )
    if rng.random() < 0.1:
        names = [f"watcher-{k + 1}" for k in range(math.ceil(2 * sweeping(mission)) + 2)]
        mission = replace(mission, fleet=replace(fleet, robots=tuple(fleet.equal_robot(one) for one in names)))
    return mission


def ground(rng: np.random.Generator) -> MultiPolygon:
    """An area of 25 to 45 m across: convex, bent, starred, with a hole, or in two halves that do not meet."""
    kind = GROUNDS[int(rng.choice(len(GROUNDS), p=(0.2, 0.15, 0.2, 0.14, 0.14, 0.12, 0.05)))]
    wide_m, high_m, bar_m = between(rng, 25, 45), between(rng, 25, 45), between(rng, 10, 14)
    turned = between(rng, 0, 90)
    if kind == "convex":
        corners = [(wide_m * rng.random(), high_m * rng.random()) for _ in range(6)]
        shape = shapely.MultiPoint([(0, 0), (wide_m, 0.2 * high_m), (0.4 * wide_m, high_m), *corners]).convex_hull
    elif kind == "star":
        shape = star(rng, int(rng.integers(5, 10)), 0.3 * wide_m, 0.6 * wide_m)
    elif kind == "L":
        shape = box(0, 0, wide_m, bar_m) | box(0, 0, bar_m, high_m)
    elif kind == "U":
        shape = box(0, 0, wide_m + bar_m, bar_m) | box(0, 0, bar_m, high_m) | box(wide_m, 0, wide_m + bar_m, high_m)
    elif kind == "courtyard":
        shape = box(0, 0, wide_m, high_m) - affinity.translate(star(rng, 5, 3, 7), wide_m / 2, high_m / 2)
    elif kind == "two halves":
        shape = box(0, 0, bar_m, high_m) | box(bar_m + 2, 0, wide_m + 2, bar_m)
    else:
        return MultiPolygon([box(0, 0, wide_m, high_m)])
    shape = to_centimetres(affinity.rotate(shape, turned))
    return MultiPolygon([shape]) if isinstance(shape, Polygon) else MultiPolygon(shape)


def star(rng: np.random.Generator, corners: int, low_m: float, high_m: float) -> Polygon:
    """A polygon round the origin, convex or not, that never crosses itself."""
    angles = 2 * math.pi * (np.arange(corners) + rng.uniform(-0.3, 0.3, corners)) / corners
    far_m = rng.uniform(low_m, high_m, corners)
    return Polygon(np.round(np.column_stack([far_m * np.cos(angles), far_m * np.sin(angles)]), 2))


def to_centimetres(shape: Polygon) -> Polygon:
    """The shape with corners in whole centimetres, as one would type it in."""
    # a shape keeps the grid it was rounded to, and all that is made of it would be rounded too: the second takes it off
    return shapely.set_precision(shapely.set_precision(shape, 0.01), 0.0)


def spot(rng: np.random.Generator, area: MultiPolygon) -> tuple[float, float]:
    """A place within the area's bounds."""
    left, bottom, right, top = area.bounds
    return between(rng, left, right), between(rng, bottom, top)


def obstacles(rng: np.random.Generator, area: MultiPolygon, clear_m: float) -> tuple[Obstacle, ...]:
    """Up to four blocks, walls, polygons and pillars, each so far from the border and from the others."""
    placed: list[Obstacle] = []
    for _ in range(int(rng.integers(0, 5))):
        x, y = spot(rng, area)
        shapes = (
            box(0, 0, between(rng, 2, 8), between(rng, 2, 8)),
            box(0, 0, between(rng, 5, 12), between(rng, 0.2, 0.5)),
            star(rng, 5, 1.5, 4),
            Point(0, 0).buffer(between(rng, 0.5, 3), quad_segs=4),
        )
        shape = affinity.rotate(shapes[int(rng.integers(len(shapes)))], between(rng, 0, 180))
        shape = to_centimetres(affinity.translate(shape, x, y))
        blocks: Blocks = ("both", "motion", "sight")[int(rng.choice(3, p=(0.7, 0.15, 0.15)))]
        fits = area.buffer(-clear_m).covers(shape)
        if fits and all(shape.distance(other.shape) >= clear_m for other in placed):
            placed.append(Obstacle(shape=MultiPolygon([shape]), blocks=blocks))
    return tuple(placed)


def zones(rng: np.random.Generator, area: MultiPolygon, period_s: float) -> tuple[Zone, ...]:
    """Up to three zones that may overlap each other and stick out; more or less urgent, to visit, or without period."""
    found: list[Zone] = []
    for k in range(int(rng.choice(4, p=(0.35, 0.3, 0.25, 0.1)))):
        shape = star(rng, 6, 2.5, 8) if rng.random() < 0.6 else box(0, 0, between(rng, 4, 12), between(rng, 4, 12))
        shape = affinity.translate(shape, *spot(rng, area))
        period: float | None = round(period_s * between(rng, 0.35, 1.6), 1)
        demand: Demand = "visit" if rng.random() < 0.2 else "every_point"
        if rng.random() < 0.1:
            period, demand = None, "every_point"
        found.append(Zone(name=f"zone-{k + 1}", shape=MultiPolygon([shape]), period_s=period, demand=demand))
    return tuple(found)


# ---------------------------------------------------------------- whether it is fair


def is_fair(mission: Mission) -> bool:
    """Whether robots can come everywhere, see nearly everything, pass each other, and about six of them suffice."""
    fleet = mission.fleet
    walls = shapely.union_all([o.shape for o in mission.obstacles if o.blocks_motion])
    opaque = shapely.union_all([o.shape for o in mission.obstacles if o.blocks_sight])
    # robots that pass each other in the narrowest place need three radii to either side of it, with some play
    standing = (mission.area - walls).buffer(-3 * fleet.body_radius_m, join_style="mitre")
    if standing.is_empty or len(shapely.get_parts(standing)) != len(mission.area.geoms):
        return False
    reach_m = fleet.sensor.radius_m if isinstance(fleet.sensor, DiscSensor) else fleet.sensor.side_m / 2
    near = (mission.area - walls).buffer(-fleet.body_radius_m).buffer(reach_m)
    asked = mission.area - opaque
    if (asked & near).area < LEAST_SEEABLE * asked.area:
        return False
    visits = [zone.shape for zone in mission.zones if zone.demand == "visit" and zone.period_s is not None]
    if any((shape & standing).area < LEAST_VISIT_M2 for shape in visits):
        return False
    return sweeping(mission) <= MOST_ROBOTS


def sweeping(mission: Mission) -> float:
    """Robots' worth of sweeping, by the areas and periods; the shortest period rules where zones overlap."""
    fleet = mission.fleet
    side_m = 2 * fleet.sensor.radius_m if isinstance(fleet.sensor, DiscSensor) else fleet.sensor.side_m
    rate_m2_s, done = 0.0, Polygon()
    opaque = shapely.union_all([obstacle.shape for obstacle in mission.obstacles if obstacle.blocks_sight])
    for zone in sorted(mission.zones, key=lambda zone: math.inf if zone.period_s is None else zone.period_s):
        if zone.demand == "every_point" and zone.period_s is not None:
            rate_m2_s += ((zone.shape & mission.area) - done - opaque).area / zone.period_s
        if zone.demand == "every_point":
            done = done | zone.shape
    if mission.period_s is not None:
        rate_m2_s += (mission.area - done - opaque).area / mission.period_s
    return rate_m2_s / (side_m * fleet.speed_m_s)
