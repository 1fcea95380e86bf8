"""The ground of a mission divided among groups of robots: by straight cuts, or zone by zone."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely import MultiPolygon
from shapely.affinity import rotate

from rota.geometry.free_space import DemandedRegion
from rota.model.arrays import Floats
from rota.model.polygons import polygons_of
from rota.planners.patrol.kinds.groups import Group
from rota.planners.patrol.tolerances import BISECTIONS, SLIVER_M2


@dataclass(frozen=True, kw_only=True)
class Part:
    """What one group is to see. cell: the ground that it is cut from; None: its regions are whole."""

    regions: tuple[DemandedRegion, ...]
    cell: MultiPolygon | None = None

    @property
    def asked_m2_s(self) -> float:
        """Ground per second that is asked for."""
        return sum(load_of(region) for region in self.regions)


def load_of(region: DemandedRegion) -> float:
    """Ground per second (m2/s) that a region asks for; what is only to be visited asks for next to none."""
    # so that visits are shared evenly
    return region.shape.area / region.period_s if region.demand == "every_point" else 1e-6


def by_zones(
    regions: Sequence[DemandedRegion], groups: Sequence[Group], counts: Floats, worth: Floats
) -> list[Part] | None:
    """Whole regions given to groups so that none seems to need more robots than it has, or the fewest more.

    counts: robots of each group; worth: what one of them sees, m2/s. None where there are too many ways, or a group
    that has robots would have nothing to do.
    """
    able = [[k for k, group in enumerate(groups) if group.serves(region) and counts[k] > 0] for region in regions]
    if math.prod(len(each) for each in able) > 4096:  # ways to give whole regions to groups
        return None
    apart_m = np.array([shapely.distance(region.shape, [other.shape for other in regions]) for region in regions])
    busy, best, least = int((counts > 0).sum()), None, (math.inf, math.inf)
    known: dict[tuple[int, tuple[int, ...]], tuple[float, float]] = {}
    for choice in itertools.product(*able):
        if len(set(choice)) < busy:
            continue
        shares = []
        for k in set(choice):
            own = tuple(i for i, owner in enumerate(choice) if owner == k)
            if (k, own) not in known:
                speed_m_s = groups[k].robot.ground_speed_m_s
                known[k, own] = _robots_for([regions[i] for i in own], apart_m[np.ix_(own, own)], worth[k], speed_m_s)
            shares.append([needed / counts[k] for needed in known[k, own]])
        ratio = tuple(np.max(shares, axis=0).tolist())
        if ratio < least:
            least, best = ratio, choice
    if best is None:
        return None
    return [
        Part(regions=tuple(region for region, own in zip(regions, best, strict=True) if own == k))
        for k in range(len(groups))
    ]


def _robots_for(
    regions: Sequence[DemandedRegion], apart_m: Floats, worth: float, speed_m_s: float
) -> tuple[float, float]:
    """How many robots regions seem to take: in whole rounds, and by their ground alone.

    Each region, the shortest period first, goes into the first round that it fits in: seeing all of its regions, and
    driving to and fro between them, takes no longer than the shortest of their periods.
    """
    rounds: list[tuple[list[int], float]] = []  # regions, and seconds
    more = 0.0
    order = sorted(range(len(regions)), key=lambda k: regions[k].period_s)
    for k in order:
        period_s, seen_s = regions[k].period_s, load_of(regions[k]) * regions[k].period_s / worth
        if seen_s > period_s:
            more += seen_s / period_s
            continue
        for number, (own, taken_s) in enumerate(rounds):
            longer_s = taken_s + seen_s + 2 * float(apart_m[k, own].min()) / speed_m_s
            if longer_s <= regions[own[0]].period_s:
                rounds[number] = ([*own, k], longer_s)
                break
        else:
            rounds.append(([k], seen_s))
    return len(rounds) + more, sum(map(load_of, regions)) / worth


def by_cuts(
    regions: Sequence[DemandedRegion],
    groups: Sequence[Group],
    capacity: Floats,
    ground: MultiPolygon,
    angle_deg: float,
    order: Sequence[int],
) -> list[Part]:
    """Slabs of the ground across a direction, each with as much to do as its group's capacity in m2/s allows.

    order: of the groups along the direction. Regions that not all groups can serve go whole to one that can, the one
    with the most capacity left, and count there.
    """
    busy = [k for k in order if capacity[k] > 0]
    owners = _owners_of_special(regions, groups, capacity)
    shared = [region for k, region in enumerate(regions) if k not in owners]
    left = np.array(capacity, dtype=np.float64)
    for k, own in owners.items():
        left[own] -= load_of(regions[k])
    left = np.maximum(left, 0.0)
    shares = np.array([left[k] for k in busy]) / max(left[busy].sum(), 1e-300)
    cells = dict(zip(busy, _slabs(shared, ground, angle_deg, shares), strict=True))
    parts = []
    for k in range(len(groups)):
        mine = [regions[i] for i, owner in owners.items() if owner == k]
        if k in cells:
            mine += [cut for region in shared if (cut := _cut_to(region, cells[k])) is not None]
        parts.append(Part(regions=tuple(mine), cell=cells.get(k)))
    return parts


def _owners_of_special(regions: Sequence[DemandedRegion], groups: Sequence[Group], capacity: Floats) -> dict[int, int]:
    """For each region that not all groups can serve, by its number, the group that does; the largest regions first."""
    left, owners = np.array(capacity, dtype=np.float64), {}
    for k in sorted(range(len(regions)), key=lambda k: -load_of(regions[k])):
        able = [i for i, group in enumerate(groups) if group.serves(regions[k]) and capacity[i] > 0]
        if len(able) < int((capacity > 0).sum()) and able:
            owners[k] = max(able, key=lambda i: left[i])
            left[owners[k]] -= load_of(regions[k])
    return owners


def _slabs(
    regions: Sequence[DemandedRegion], ground: MultiPolygon, angle_deg: float, shares: Floats
) -> list[MultiPolygon]:
    """The ground in slabs one behind the other, with these shares of what the regions ask for."""
    turned = rotate(ground, -angle_deg, origin=(0, 0))
    x0, y0, x1, y1 = turned.bounds
    shapes = [rotate(region.shape, -angle_deg, origin=(0, 0)) for region in regions]
    weights = np.array([load_of(region) / region.shape.area for region in regions])

    def before(x: float) -> float:
        """What is asked for before a cut."""
        clipped = shapely.clip_by_rect(np.array(shapes, dtype=object), x0 - 1, y0 - 1, x, y1 + 1)
        return float(shapely.area(clipped) @ weights) if len(shapes) else 0.0

    whole, cuts = before(x1), [x0 - 1.0]
    for share in np.cumsum(shares)[:-1]:
        low, high = x0, x1
        for _ in range(BISECTIONS):
            middle = (low + high) / 2
            low, high = (middle, high) if before(middle) < share * whole else (low, middle)
        cuts.append(high)
    cuts.append(x1 + 1.0)
    return [
        _polygons(rotate(shapely.box(low, y0 - 1, max(high, low), y1 + 1), angle_deg, origin=(0, 0)), ground)
        for low, high in itertools.pairwise(cuts)
    ]


def _cut_to(region: DemandedRegion, cell: MultiPolygon) -> DemandedRegion | None:
    """A region's part in a cell; what is only to be visited is in the cell that holds most of it, whole."""
    if region.demand == "visit":
        inside = shapely.contains(cell, shapely.point_on_surface(region.shape))
        return region if inside else None
    shape = _polygons(region.shape, cell)
    return None if shape.is_empty else replace(region, shape=shape)


def _polygons(shape: shapely.Geometry, cell: shapely.Geometry) -> MultiPolygon:
    return polygons_of(shapely.intersection(shape, cell), SLIVER_M2)


def divisions(
    regions: Sequence[DemandedRegion],
    groups: Sequence[Group],
    counts: Floats,
    worth: Floats,
    ground: MultiPolygon,
    *,
    confined: bool,
) -> Iterator[list[Part]]:
    """Ways to divide the ground among the groups that have robots, the most promising first.

    counts, worth: see ``by_zones``.
    confined: groups keep to their cells, so that whole zones beside each other are no division.
    """
    busy = [k for k in range(len(groups)) if counts[k] > 0]
    if len(busy) == 1:
        yield [Part(regions=tuple(regions)) if k == busy[0] else Part(regions=()) for k in range(len(groups))]
        return
    if not confined and (whole := by_zones(regions, groups, counts, worth)) is not None:
        yield whole
    x0, y0, x1, y1 = ground.bounds
    along = [0.0, 90.0] if x1 - x0 >= y1 - y0 else [90.0, 0.0]
    for angle_deg in (*along, 45.0, 135.0):
        for order in (busy, busy[::-1]):
            yield by_cuts(regions, groups, counts * worth, ground, angle_deg, order)
