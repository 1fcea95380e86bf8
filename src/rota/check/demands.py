"""What is asked where: zones made disjoint, the smallest period ruling, and the times at which a zone is visited."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
from shapely import MultiPolygon, difference, dwithin, intersection, points, prepare, union_all

from rota.check.arrays import Floats, Ints
from rota.check.blocking import blocks_sight
from rota.check.routes import segments_of
from rota.model.mission import AREA, Demand, Mission, Obstacle, Zone


@dataclass(frozen=True, kw_only=True, eq=False)
class DemandedGround:
    """One demand: every point of ``region`` (or, with "visit", the region as one) once in every ``period_s``.

    sensors: names of those that count; none: all do.
    """

    name: str
    period_s: float
    demand: Demand
    region: Any
    sensors: tuple[str, ...] = ()


def demands_of(mission: Mission) -> tuple[DemandedGround, ...]:
    """The demands of a mission: the zones in their order, then the rest of the area, which is called "area".

    Regions of every_point demands are disjoint: among overlapping zones the smallest period rules, of equal ones the
    first. A zone without a period, or one that asks only for visits, takes its ground from the area's period alone. All
    regions lie in the area and outside of what blocks sight or asks nothing; a region may be empty. A visit
    zone's region is the part of the zone in the area.
    """
    return _demands_of(mission.area, mission.obstacles, mission.zones, mission.period_s)


@functools.lru_cache(maxsize=4)
def _demands_of(
    area: MultiPolygon, obstacles: tuple[Obstacle, ...], zones: tuple[Zone, ...], period_s: float | None
) -> tuple[DemandedGround, ...]:
    """The same for missions that differ in their robots only, as those do for robots that remain of a fleet."""
    ground_in_sight = _open_ground(area, obstacles)
    strict = [z for z in zones if z.demand == "every_point" and z.period_s is not None]
    regions: dict[str, Any] = {}
    taken: Any = MultiPolygon()
    for zone in sorted(strict, key=lambda zone: zone.period_s or 0.0):
        ground = intersection(zone.shape, ground_in_sight)
        regions[zone.name] = _polygonal(difference(ground, taken))
        taken = union_all([taken, zone.shape])
    demands = []
    for zone in zones:
        if zone.period_s is not None:
            region = regions.get(zone.name)
            region = _polygonal(intersection(zone.shape, area)) if region is None else region
            demands.append(
                DemandedGround(
                    name=zone.name, period_s=zone.period_s, demand=zone.demand, region=region, sensors=zone.sensors
                )
            )
    if period_s is not None:
        rest = _polygonal(difference(ground_in_sight, union_all([zone.shape for zone in zones])))
        if not rest.is_empty or not demands:
            demands.append(DemandedGround(name=AREA, period_s=period_s, demand="every_point", region=rest))
    return tuple(demands)


@functools.lru_cache(maxsize=4)
def _open_ground(area: MultiPolygon, obstacles: tuple[Obstacle, ...]) -> Any:
    """The area without what blocks sight and without obstacles that ask nothing: all that can be demanded."""
    ground = difference(area, blocks_sight(obstacles))
    left_out = [obstacle.shape for obstacle in obstacles if obstacle.asks == "nothing"]
    return difference(ground, union_all(left_out)) if left_out else ground


def _polygonal(shape: Any) -> MultiPolygon:
    """The polygons of a geometry; lines and points left by an overlay have no area and are dropped."""
    parts = getattr(shape, "geoms", [shape])
    return MultiPolygon([part for part in parts if part.geom_type == "Polygon" and part.area > 0])


def visits(legs_m: Floats, region: Any, slack_m: float) -> list[tuple[int, float, float]]:
    """The parts (leg, from, to) of legs (m, 4) inside a region, border included; from and to in 0..1 of the leg."""
    parts: list[tuple[int, float, float]] = []
    sides = segments_of(region)
    if not len(sides):
        return parts
    x0, y0, x1, y1 = region.bounds
    low, high = np.minimum(legs_m[:, :2], legs_m[:, 2:]), np.maximum(legs_m[:, :2], legs_m[:, 2:])
    reached = (low <= [x1 + slack_m, y1 + slack_m]).all(axis=1) & (high >= [x0 - slack_m, y0 - slack_m]).all(axis=1)
    near = np.flatnonzero(reached)
    prepare(region)
    at_once = max(1, 1_000_000 // len(sides))  # of which all sides are looked at together
    for k in range(0, len(near), at_once):
        legs = near[k : k + at_once]
        which, begins, ends = _inside(legs_m[legs], region, sides, slack_m)
        parts += zip(legs[which].tolist(), begins.tolist(), ends.tolist(), strict=True)
    return parts


def _inside(legs_m: Floats, region: Any, sides: Floats, slack_m: float) -> tuple[Ints, Floats, Floats]:
    """The parts of legs (n, 4) within slack_m of a region: of which leg, from and to in 0..1 of it, rising.

    sides: (s, 4) of its border.
    """
    leg, share = _stops(legs_m, sides, slack_m)
    start, along = legs_m[leg, :2], legs_m[leg, 2:] - legs_m[leg, :2]
    near = dwithin(region, points(start + share[:, None] * along), slack_m)
    middles = start[:-1] + ((share[1:] + share[:-1]) / 2)[:, None] * along[:-1]
    # to the next stop of the same leg
    goes_on = np.append((leg[1:] == leg[:-1]) & dwithin(region, points(middles), slack_m), False)
    came = np.append(False, goes_on[:-1])
    first, last = np.flatnonzero((near | goes_on) & ~came), np.flatnonzero((near | came) & ~goes_on)
    return leg[first], share[first], share[last]


def _stops(legs_m: Floats, sides: Floats, slack_m: float) -> tuple[Ints, Floats]:
    """Where legs (n, 4) may enter or leave a region, and both ends of each: of which leg, and the share of it, rising.

    That is where they cross its sides (s, 4) and where they pass the ends of these.
    """
    start, along = legs_m[:, None, :2], legs_m[:, None, 2:] - legs_m[:, None, :2]
    across, offset = sides[:, 2:] - sides[:, :2], sides[:, :2] - start
    turn = along[..., 0] * across[:, 1] - along[..., 1] * across[:, 0]
    length2 = (along**2).sum(axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (offset[..., 0] * across[:, 1] - offset[..., 1] * across[:, 0]) / turn
        v = (offset[..., 0] * along[..., 1] - offset[..., 1] * along[..., 0]) / turn
        passed = [((sides[:, k : k + 2] - start) * along).sum(axis=2) / length2 for k in (0, 2)]
    margin = slack_m / np.sqrt((across**2).sum(axis=1))
    crossed = (turn != 0) & (v >= -margin) & (v <= 1 + margin)
    every = np.arange(len(legs_m))
    found = [(every, np.zeros(len(every))), (every, np.ones(len(every)))]
    for shares, chosen in ((u, crossed), *((each, np.isfinite(each)) for each in passed)):
        within = chosen & (shares > 0) & (shares < 1)
        found.append((np.nonzero(within)[0], shares[within]))
    leg, share = (np.concatenate(each) for each in zip(*found, strict=True))
    order = np.lexsort((share, leg))
    leg, share = leg[order], share[order]
    new = np.append(True, (leg[1:] != leg[:-1]) | (share[1:] != share[:-1]))
    return leg[new], share[new]
