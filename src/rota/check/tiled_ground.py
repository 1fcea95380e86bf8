"""The demanded ground in tiles: cut up, looked at by a plan's robots, and made ready before there is a plan."""

from __future__ import annotations

import functools
import math
import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import shapely

from rota.check.arrays import Flags, Ints
from rota.check.counting import Names, groups_of
from rota.check.demands import DemandedGround, demands_of
from rota.check.findings import Findings
from rota.check.pieces import Pieces, convex_pieces, join
from rota.check.refine import refine
from rota.check.revisits import Sights
from rota.check.seeable import is_ragged, seeable_ground
from rota.check.standing import standing_areas
from rota.check.tolerances import PERIOD_TOLERANCE, SLIVER_SHARE, slack_of
from rota.model.mission import DiscSensor, Mission

FINEST_M = 0.01  # pieces are not cut below this size
FEW_PIECES = 50_000  # still open on ragged ground: all that is unmet among them is told
# pieces of a violated demand are cut to this part of a tile; of many tiles to a finer one, since a planner that is told
# of coarse pieces only goes to see what was seen already, and its next plan is looked at all over again
CUTS, MANY_CUTS, MANY_PIECES = 4, 16, 50_000
MOST_CELLS = 4_000_000


def get_ready(mission: Mission, *, finest_m: float = FINEST_M) -> None:
    """Work out what the check of any plan for a mission over ragged ground asks of the mission alone.

    A planner's first plan takes longer than this, and its check is then sooner done. On other ground it takes no time
    to speak of, and nothing is done.
    """
    if not is_ragged(mission):
        return
    sensors = [area.sensor for area in standing_areas(mission)]
    reach_m = min(sensor.radius_m if isinstance(sensor, DiscSensor) else sensor.side_m / 2 for sensor in sensors)
    _ = _tiles_of(mission, _tile_m(mission, reach_m, finest_m))
    seeable_ground(mission).get_ready()


def findings_by_group(
    mission: Mission,
    demands: tuple[DemandedGround, ...],
    sights_by: Callable[[Names], Sights],
    finest_m: float,
    on_the_way: Callable[[], None] | None = None,
) -> list[Findings]:
    """``tile_and_refine`` with the sights of the robots that count for each demand; sights_by: by names of sensors."""
    groups, found = groups_of(demands), dict[int, Findings]()
    if len(groups) == 1:
        return tile_and_refine(mission, demands, sights_by(groups[0][0]), finest_m, on_the_way)
    for names, own in groups:
        every = tile_and_refine(mission, demands, sights_by(names), finest_m, on_the_way, names)
        found |= {k: every[k] for k in own}
    return [found[k] for k in range(len(demands))]


def tile_and_refine(
    mission: Mission,
    demands: tuple[DemandedGround, ...],
    sights: Sights,
    finest_m: float,
    on_the_way: Callable[[], None] | None = None,
    names: Names | None = None,
) -> list[Findings]:
    """Findings for each demand: the demanded ground is cut into pieces, and pieces in doubt are refined.

    on_the_way: called now and then; what it raises ends it. names: of demands that name these sensors alone; those of
    the others say nothing.
    """
    reach_m = float(sights.team.reaches_m.min(initial=math.inf))
    tiles = _tiles_of(mission, _tile_m(mission, reach_m, finest_m))
    pieces, owners, size = tiles.pieces, tiles.owners, tiles.size_m
    unfilled = _unfilled_demands(mission, demands, pieces, owners)
    if names is not None:
        asked = np.flatnonzero(np.array([demand.sensors == names for demand in demands])[owners])
        pieces, owners = pieces.choose(asked), owners[asked]
    limits = np.array([demand.period_s for demand in demands]) * (1 + PERIOD_TOLERANCE)

    regions, counting = [demand.region for demand in demands], demands[0].sensors if names is None else names
    ground = seeable_ground(mission, counting)
    shapely.prepare(regions)

    one_at_a_time = threading.Lock()  # prepared shapes are not made for several threads

    def is_seeable(pieces: Pieces, numbers: Ints) -> Flags:
        can_see, middles_m = np.ones(len(pieces), np.bool_), pieces.centres_m()
        with one_at_a_time:
            for k in np.unique(numbers):
                members = np.flatnonzero(numbers == k)
                members = members[shapely.contains_xy(regions[k], *middles_m[members].T)]
                can_see[members] = ground.sees(pieces.choose(members))
        return can_see

    # on ragged ground walls hide part of most pieces: coarse ones do not tell what is missed, and a planner that is
    # told of finer ones only when all coarse ones are met repairs its plan once for each size
    few = FEW_PIECES if is_ragged(mission) else 0
    coarse_m = max(finest_m, size / (MANY_CUTS if len(pieces) > MANY_PIECES else CUTS))
    findings = refine(
        sights, pieces, owners, limits, is_seeable, finest_m=finest_m, coarse_m=coarse_m, few=few, on_the_way=on_the_way
    )
    for k in unfilled:
        findings[k].undecided_cells += 1
    return findings


@dataclass(frozen=True, kw_only=True, eq=False)
class Tiles:
    """Pieces of all demands, the index of each one's demand, and the size of the lattice (larger for a huge area)."""

    pieces: Pieces
    owners: Ints
    size_m: float


def tiles_of(mission: Mission, reach_m: float) -> Tiles:
    """The tiles of all demands that ask for every point, the same object for the same ground; reach_m: the shortest."""
    return _tiles_of(mission, _tile_m(mission, reach_m, FINEST_M))


def _unfilled_demands(mission: Mission, demands: tuple[DemandedGround, ...], pieces: Pieces, owners: Ints) -> list[int]:
    """Numbers of the demands whose region the pieces do not fill, slivers along its border aside.

    Slivers thinner than the check's tolerance have no area to speak of. A region that is nothing else was not looked
    at. Where there is no piece at all, every demand is left out.
    """
    points = [k for k, demand in enumerate(demands) if demand.demand == "every_point" and not demand.region.is_empty]
    tiled_m2 = np.bincount(owners, pieces.areas_m2(), len(demands))
    if not tiled_m2.any():
        return points
    slivers_m2 = [
        SLIVER_SHARE * demands[k].region.area + 8 * slack_of(mission) * demands[k].region.length for k in points
    ]
    return [k for k, most in zip(points, slivers_m2, strict=True) if demands[k].region.area - tiled_m2[k] > most]


def _tile_m(mission: Mission, reach_m: float, finest_m: float) -> float:
    """The size of a tile; reach_m: the shortest of the team, inf where nobody sees."""
    return max(reach_m / 4 if math.isfinite(reach_m) else mission.fleet.sensor.reach_m / 4, finest_m)


def _tiles_of(mission: Mission, size_m: float) -> Tiles:
    """The tiles of that size."""
    return _tiles(demands_of(mission), slack_of(mission), size_m)


@functools.lru_cache(maxsize=2)
def _tiles(demands: tuple[DemandedGround, ...], slack_m: float, size_m: float) -> Tiles:
    """The same, made anew."""
    regions = [demand.region for demand in demands if demand.demand == "every_point"]
    # a long strip has few cells for its area and many for its border
    most_m = (
        math.sqrt(sum(region.area for region in regions) / MOST_CELLS),
        sum(r.length for r in regions) / MOST_CELLS,
    )
    size = max(size_m, *most_m)
    tiles: list[Pieces] = []
    owners: list[Ints] = [np.empty(0, np.int64)]
    for k, demand in enumerate(demands):
        if demand.demand == "every_point":
            tiles.append(convex_pieces(demand.region, size, 2 * slack_m))
            owners.append(np.full(len(tiles[-1]), k, np.int64))
    return Tiles(pieces=join(tiles), owners=np.concatenate(owners), size_m=size)
