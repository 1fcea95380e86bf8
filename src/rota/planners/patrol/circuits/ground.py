"""Circuits of a mission: the ground of each period in one loop of one robot, opened at a charger.

A robot that comes past all ground of a period, launched from a charger once in that period, is all that this ground
asks for. Nobody relieves anybody: however long a circuit takes, the next robot begins it in time. So no loop need take
just as long as a period, and what a mission asks for of robots in the air is the length of all circuits, with no
remainder for each loop.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely import LineString

from rota.errors import NoPlanFound
from rota.geometry.free_space import DemandedRegion, demanded_regions, sight_walls
from rota.geometry.line_of_sight import visibility_polygon
from rota.geometry.shortest_path import ShortestPaths
from rota.model.arrays import Floats
from rota.model.mission import AREA, Charger, Mission, Robot, Zone, inner_reach_m
from rota.model.plan import Plan
from rota.model.polygons import polygons_of
from rota.planners.patrol.bounds.strongest_robot import strongest_robot
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.driving.rounded import driving_with_mass
from rota.planners.patrol.driving.timed_line import TimedLine, chain, steady
from rota.planners.patrol.margins import with_reserve
from rota.planners.patrol.methods.fixed_team.one_loop import ample_s
from rota.planners.patrol.relief.relieve import without_batteries
from rota.planners.patrol.relief.slots import MOMENT
from rota.planners.patrol.tolerances import HAIR_M, SAME_PLACE_M, SAME_TIME_S, SLOWER
from rota.planners.patrol.traffic.starts.approaches import timed_approach, without_short_legs


@dataclass(frozen=True, kw_only=True, eq=False)
class Circuit:
    """A way from a charger round ground and back, to be begun every ``most_s`` seconds at least.

    used_s: seconds of driving that it takes from a battery, the take-off left out. place: the zone to visit that it is
    for, if that is all and robots change speed at once; None: any other ground.
    """

    charger: Charger
    line: TimedLine
    most_s: float
    used_s: float
    place: shapely.MultiPolygon | None = None


def visits_s(line: TimedLine, place: shapely.MultiPolygon) -> Floats:
    """When a line without accelerations comes into a place and leaves it (n, 2), by the way and at its ends."""
    legs, found = shapely.linestrings(np.stack([line.places_m[:-1], line.places_m[1:]], axis=1)), list[list[float]]()
    for k in np.flatnonzero(shapely.intersects(legs, place)):
        begin_s, end_s, length_m = *line.times_s[k : k + 2], float(shapely.length(legs[k]))
        for part in shapely.get_parts(shapely.intersection(legs[k], place)) if length_m else [legs[k]]:
            along_m = np.hypot(*(shapely.get_coordinates(part) - line.places_m[k]).T)
            shares = along_m / length_m if length_m else np.array([0.0, 1.0])
            own = [begin_s + (end_s - begin_s) * share for share in (shares.min(), shares.max())]
            if found and own[0] <= found[-1][1] + SAME_TIME_S:
                found[-1][1] = own[1]
            else:
                found.append(own)
    return np.array(found).reshape(-1, 2)


@dataclass(frozen=True, kw_only=True)
class Ground:
    """The regions that ask for one period."""

    period_s: float
    regions: tuple[DemandedRegion, ...]


def grounds_of(mission: Mission) -> list[Ground]:
    """The ground of each period that a mission asks for, with its reserve, ascending."""
    regions = sorted(demanded_regions(with_reserve(mission)), key=lambda region: region.period_s)
    return [
        Ground(period_s=period_s, regions=tuple(own))
        for period_s, own in itertools.groupby(regions, key=lambda region: region.period_s)
    ]


def circuits_of(
    ground: Ground, mission: Mission, paths: ShortestPaths, search: Callable[[Mission], Plan]
) -> list[Circuit]:
    """Circuits that come past all of some ground: a loop that ``search`` finds for one robot, cut where batteries end.

    Raises NoPlanFound where one robot cannot come past all, and where a charger is too far away.
    """
    plan = search(_for_one_robot(ground, mission))
    if len(plan) > 1:
        raise NoPlanFound("one robot cannot come past all ground of one period")
    loop = plan.trajectories[0]
    speed_m_s = driving_of(mission.fleet.equal_robot("robot-1")).pace_m_s * SLOWER
    chargers_m = np.array([charger.at for charger in mission.chargers])
    line_m = with_places_beside(loop.positions_m[loop.loop_index :, :2], chargers_m)
    ways_s = paths.distances(chargers_m, line_m) / speed_m_s
    opened = int(np.argmin(ways_s.min(axis=0)[: max(1, len(line_m) - 1)]))
    if len(line_m) > 1:
        line_m = np.vstack([line_m[opened:-1], line_m[: opened + 1]])
        ways_s = np.hstack([ways_s[:, opened:-1], ways_s[:, : opened + 1]])
    times_s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line_m, axis=0).T))]) / speed_m_s
    found = []
    for begin, end in cut_at_chargers(ways_s, times_s, mission.fleet.battery.usable_s):
        charger = mission.chargers[int(np.argmin(ways_s[:, begin] + ways_s[:, end]))]
        out_m, back_m = paths.path(charger.at, line_m[begin]), paths.path(line_m[end], charger.at)
        found.append(_circuit(charger, [out_m, line_m[begin : end + 1], back_m], ground.period_s, mission))
    is_place = len(found) == len(ground.regions) == 1 and ground.regions[0].demand == "visit"
    if is_place and mission.fleet.equal_robot("robot-1").turns_at_once:
        found = [replace(found[0], place=ground.regions[0].shape)]
    return found


def with_places_beside(line_m: Floats, chargers_m: Floats) -> Floats:
    """A polyline (n, 2) with no place twice in a row, and the place of each leg that is nearest to each charger."""
    line_m = line_m[np.concatenate([[True], np.hypot(*np.diff(line_m, axis=0).T) > 0])]
    steps_m = np.diff(line_m, axis=0)
    lengths_m = np.hypot(*steps_m.T)
    from_m = chargers_m[:, None] - line_m[None, :-1]
    shares = np.clip((from_m * steps_m).sum(axis=2) / lengths_m**2, 0.0, 1.0)
    along_m = np.concatenate([[0.0], np.cumsum(lengths_m)])
    kept_m = np.unique(np.concatenate([along_m, (along_m[:-1] + shares * lengths_m).ravel()]))
    kept_m = kept_m[np.concatenate([[True], np.diff(kept_m) > HAIR_M])]
    kept_m[-1] = along_m[-1]
    return np.column_stack([np.interp(kept_m, along_m, line_m[:, axis]) for axis in (0, 1)])


def without_seen(ground: Ground, circuits: Sequence[Circuit], mission: Mission) -> Ground:
    """The ground without what circuits of shorter periods see on their way; ground that is left has smooth borders."""
    robot = strongest_robot(mission.fleet)
    reach_m = inner_reach_m(with_reserve(mission).fleet.equal_robot("robot-1").sensor)
    walls, views, sides = sight_walls(mission), [], 64
    for circuit in circuits:
        # a quarter of the reach lies between places whose views are joined
        lasts_s, each_s = circuit.line.duration_s, 0.25 * reach_m / robot.ground_speed_m_s
        for place_m in circuit.line.at(np.linspace(0.0, lasts_s, math.ceil(lasts_s / each_s) + 1)):
            views.append(visibility_polygon(place_m, walls, reach_m * math.cos(math.pi / sides), sides=sides))
    smooth_m = 0.05 * reach_m
    seen = shapely.union_all(views).buffer(-2 * smooth_m).buffer(smooth_m)
    left = [
        replace(region, shape=polygons_of(region.shape.difference(seen))) if region.demand == "every_point" else region
        for region in ground.regions
    ]
    return replace(ground, regions=tuple(region for region in left if not region.shape.is_empty))


def _for_one_robot(ground: Ground, mission: Mission) -> Mission:
    """The mission that asks for this ground alone, in a time that is ample for one robot.

    How many robots is left open: a fixed team's loop is searched longer, and spares no robot.
    """
    robot, alone = strongest_robot(mission.fleet), without_batteries(mission)
    period_s = ample_s(ground.regions, mission, robot.sensor.reach_m, robot.ground_speed_m_s)
    zones = tuple(
        Zone(
            name="the rest" if region.name == AREA else region.name, period_s=period_s, demand=region.demand,
            shape=region.shape,
        )
        for region in ground.regions
    )  # fmt: skip
    return replace(alone, zones=zones, period_s=None, fleet=replace(alone.fleet, robots=None))


def cut_at_chargers(ways_s: Floats, times_s: Floats, usable_s: float) -> list[tuple[int, int]]:
    """The first and last corner of each circuit along a line, with the least ways in all; no circuit is too long.

    ways_s: (chargers, n) from corners to chargers; times_s: (n,) along the line. Route first, cluster second: the best
    cuts of a given order are a shortest path (Prins, A simple and effective evolutionary algorithm for the vehicle
    routing problem, 2004). Raises NoPlanFound where two corners and their ways are too long for a battery.
    """
    count = len(times_s)
    best_s, came = np.full(count, np.inf), np.zeros(count, np.int64)
    best_s[0] = 0.0
    for end in range(1, count):
        flown_s = np.min(ways_s[:, :end] + ways_s[:, end : end + 1], axis=0) + times_s[end] - times_s[:end]
        flown_s[flown_s > usable_s * SLOWER] = np.inf
        total_s = best_s[:end] + flown_s + SAME_TIME_S  # ways of no length spare nothing: so fewer circuits are better
        came[end] = int(np.argmin(total_s))
        best_s[end] = total_s[came[end]]
    if not np.isfinite(best_s[-1]) or 2 * float(ways_s[:, 0].min()) > usable_s * SLOWER:
        raise NoPlanFound("fleet.endurance_s: a circuit from a charger and back takes longer; give more")
    if count == 1:
        return [(0, 0)]
    cuts, end = [], count - 1
    while end > 0:
        cuts.append((int(came[end]), end))
        end = int(came[end])
    return cuts[::-1]


def _circuit(charger: Charger, parts_m: Sequence[Floats], period_s: float, mission: Mission) -> Circuit:
    """The circuit along a way out, corners one after the other, and a way back; at one corner a robot stays a moment.

    Who comes from a charger to a place beside it has not been there unless it stays, which a wing cannot; nor need one
    that turns at once stay at a place farther off.
    """
    robot, battery = mission.fleet.equal_robot("robot-1"), mission.fleet.battery
    comes_by = robot.turns_at_once and len(parts_m[0]) > 1 and shapely.length(LineString(parts_m[0])) > SAME_PLACE_M
    stays_s = MOMENT * period_s if len(parts_m[1]) == 1 and battery.can_stand and not comes_by else 0.0
    if robot.turns_at_once:
        line = _at_once(parts_m, stays_s, robot.ground_speed_m_s * SLOWER)
    else:
        ways_m = [np.vstack(parts_m[:2]), parts_m[2]] if stays_s else [np.vstack(parts_m)]
        ways = [_in_motion(way_m, robot) for way_m in ways_m]
        waits = steady(np.array([0.0, stays_s]), np.repeat(parts_m[1][:1], 2, axis=0))
        line = chain(ways[0], waits, ways[1]) if stays_s else ways[0]
    line.places_m[-1] = charger.at
    used_s = line.duration_s + stays_s * max(0.0, battery.standing_uses - 1)
    return Circuit(charger=charger, line=line, most_s=period_s, used_s=used_s)


def _at_once(parts_m: Sequence[Floats], stays_s: float, speed_m_s: float) -> TimedLine:
    """The line of a circuit at one speed; at the first corner a robot stays so long."""
    line_m = np.vstack(list(parts_m))
    steps_s = np.hypot(*np.diff(line_m, axis=0).T) / speed_m_s
    steps_s[len(parts_m[0])] += stays_s  # from the corner to the beginning of the way back, which is there too
    kept = np.concatenate([[True], steps_s * speed_m_s / SLOWER > SAME_PLACE_M])
    return steady(np.concatenate([[0.0], np.cumsum(steps_s)])[kept], line_m[kept])


def _in_motion(line_m: Floats, robot: Robot) -> TimedLine:
    """The line of a robot with mass, or that takes time to turn, from rest to rest."""
    line_m = without_short_legs(line_m)
    if len(line_m) == 1:
        return steady(np.zeros(1), line_m)
    return (
        driving_with_mass(robot).way(line_m, cuts=True) if robot.motion.has_mass else timed_approach(line_m, robot).line
    )


def least_on_circuits(mission: Mission, busy_per_s: float) -> float:
    """Robots that circuits hardly do with fewer of: for perfect lanes, for the ways of each launch, and for charging.

    busy_per_s: seconds on a charger for each in the air. A place to visit takes fewer launches where circuits of longer
    periods come past it on the way there and back.
    """
    robot = strongest_robot(mission.fleet)
    chargers = shapely.MultiPoint([charger.at for charger in mission.chargers])
    flying = past_per_s = 0.0
    for ground in reversed(grounds_of(mission)):
        lanes_m = sum(r.shape.area for r in ground.regions if r.demand == "every_point") / (2 * robot.sensor.reach_m)
        away_m = max(shapely.distance(chargers, region.shape) for region in ground.regions)
        ways_m = 2 * max(0.0, away_m - robot.sensor.reach_m)
        launches_per_s = 1 / ground.period_s
        if all(region.demand == "visit" for region in ground.regions):
            launches_per_s = max(0.0, launches_per_s - past_per_s)
            past_per_s += 2 * launches_per_s
        flying += max(lanes_m, ways_m) / robot.ground_speed_m_s * launches_per_s
    return flying * (1 + busy_per_s)
