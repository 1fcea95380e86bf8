"""The ground of a plan as cells: which demand each serves, when robots see it, and its worst gap."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from rota.cells.cell_map import CellMap, cell_map_of
from rota.check import revisits, seeable, standing
from rota.check.charging import undocked_routes
from rota.check.demands import demands_of
from rota.check.late_samples import sights_before
from rota.check.presence import away_times_s
from rota.check.report import Report
from rota.check.revisits import sights_along
from rota.check.routes import routes_of, sensors_of
from rota.live.kernels import PlannedSights
from rota.live.planned_sights import counting_sights, sights_by_plan
from rota.model.arrays import Floats, Ints
from rota.model.mission import AREA, Mission
from rota.model.plan import Plan, Seam

NO_CELL = 0xFFFFFFFF  # the index of an entry that stands for a zone to visit


@dataclass(frozen=True, kw_only=True, eq=False)
class SeenCells:
    """Entries (n,): the asked cells row by row from the south, then one for each zone to visit.

    index: (n,) row * columns + column, or ``NO_CELL``. demand: (n,) index in the report's demands. worst: (n,) worst
    gap over period; inf: never seen. excluded: (e,) cells that nobody can see. sights: of all entries, in their order.
    before_s: (n,) when each was seen last before the plan took over from another one, 0 at most; None: it does not.
    """

    cell_map: CellMap
    index: Ints
    demand: Ints
    worst: Floats
    excluded: Ints
    sights: PlannedSights
    before_s: Floats | None

    @property
    def grid(self) -> dict[str, Any]:
        """Lower left corner and size of the cells, and how many there are."""
        left, _, bottom, _ = self.cell_map.extent_m
        rows, columns = self.cell_map.inside.shape
        return {
            "x0_m": float(left), "y0_m": float(bottom), "cell_m": float(self.cell_map.cell_m),
            "columns": columns, "rows": rows,
        }  # fmt: skip


def seen_cells(plan: Plan, report: Report, cells: int) -> SeenCells:
    """About ``cells`` cells over the area's bounding box, judged at their centres as the check judges points."""
    mission = plan.mission
    cell_map = cell_map_of(mission, cells)
    names = [demand.name for demand in report.demands]
    owner = _owners(mission, cell_map, names)
    asked = owner >= 0
    points_m = np.ascontiguousarray(cell_map.points_m(asked))
    gaps_s = revisits.worst_gaps_s(plan, points_m)
    excluded = np.isinf(gaps_s) & (mission.unseeable == "exclude")
    if excluded.any():
        hidden_m = np.ascontiguousarray(points_m[excluded])
        excluded[excluded] = ~seeable.seeable(mission, standing.standing_areas(mission), hidden_m)
    visits = [(k, demand) for k, demand in enumerate(report.demands) if demand.demand == "visit"]
    known = {demand.name: demand for demand in demands_of(mission)}
    index, demands = np.flatnonzero(asked), owner[asked]
    kept = ~excluded
    driven = undocked_routes(routes_of(plan), plan)
    routes = sights_along(driven, sensors_of(plan), mission, mission.area.bounds)
    places = points_m[kept], [known[demand.name].region for _, demand in visits]
    demand_of = np.concatenate([demands[kept], np.array([k for k, _ in visits], np.int64)])
    asked_of = demand_of, [known[demand.name].sensors for demand in report.demands]
    sensors = [mission.fleet.robot(way.robot).sensor for way in plan]
    sights = counting_sights(sights_by_plan(routes, *places), sensors, *asked_of)
    periods_s = np.array([demand.period_s for demand in report.demands], np.float64)
    return SeenCells(
        cell_map=cell_map,
        index=np.concatenate([index[kept], np.full(len(visits), NO_CELL)]),
        demand=demand_of,
        worst=np.concatenate(
            [gaps_s[kept] / periods_s[demands[kept]], [demand.worst_gap_s / demand.period_s for _, demand in visits]]
        ),
        excluded=index[excluded],
        sights=_while_present(sights, plan),
        before_s=None if plan.seam is None else _last_before(plan.mission, plan.seam, *places, *asked_of),
    )


def _last_before(
    mission: Mission, seam: Seam, points_m: Floats, regions: list[Any], demand: Ints, names: list[tuple[str, ...]]
) -> Floats:
    """When points and then regions were seen last before the change; those that were not, when what is told begins."""
    seen = sights_by_plan(sights_before(mission, seam), points_m, regions)
    sights = counting_sights(seen, [one.sensor for one in seam.driven], demand, names)
    entry = np.repeat(np.arange(len(sights.offsets) - 1), np.diff(sights.offsets))
    last_s = np.full(len(sights.offsets) - 1, seam.since_s)
    np.maximum.at(last_s, entry, np.minimum(sights.ends_s, 0.0))
    return last_s


def _owners(mission: Mission, cell_map: CellMap, names: list[str]) -> Ints:
    """(rows, columns): which of the demands ``names`` asks for each cell; -1: none does.

    Among overlapping zones the smallest period rules, as in the check and in ``cell_map_of``.
    """
    owner = np.full(cell_map.inside.shape, names.index(AREA) if AREA in names else -1)
    x_m, y_m = np.meshgrid(cell_map.x_m, cell_map.y_m)
    strict = [zone for zone in mission.zones if zone.demand == "every_point" and zone.period_s is not None]
    for zone in sorted(strict, key=lambda zone: zone.period_s or 0.0)[::-1]:
        shapely.prepare(zone.shape)
        owner[shapely.contains_xy(zone.shape, x_m, y_m)] = names.index(zone.name)
    owner[~cell_map.asked] = -1
    return owner


def _while_present(sights: PlannedSights, plan: Plan) -> PlannedSights:
    """The sights without what a robot would see before it joins or after it leaves."""
    joins_s, leaves_s = (times_s[sights.robots] for times_s in away_times_s(plan))
    starts_s = np.where(sights.again, sights.starts_s, np.maximum(sights.starts_s, joins_s))
    ends_s = np.where(sights.again, sights.ends_s, np.minimum(sights.ends_s, leaves_s))
    kept = (ends_s >= starts_s) & (ends_s >= joins_s) & (starts_s <= leaves_s)
    counts = np.concatenate([[0], np.cumsum(kept)])
    return PlannedSights(counts[sights.offsets], sights.robots[kept], starts_s[kept], ends_s[kept], sights.again[kept])
