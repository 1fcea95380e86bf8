"""The worst revisit gap of every place as a map, in units of the period asked there: 1.0 is the limit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.image import AxesImage
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from rota.cells.cell_map import CellMap, cell_map_of, neighbours
from rota.draw.palette import EXCLUDED, NEVER_SEEN, NOTHING_ASKED, OVER_PERIOD, gap_colours
from rota.model.arrays import Flags, Floats
from rota.model.plan import Plan

# a gap that equals the period to rounding meets it
ON_TIME = 1 + 1e-9


@dataclass(frozen=True, kw_only=True)
class GapMap:
    """Worst gap over period, (rows, columns) as in ``cell_map``; inf: never seen, nan: nothing asked.

    In a zone to visit it is that between visits, all over the zone.

    excluded: (rows, columns), what nobody can see from anywhere a body can stand, where the mission excludes that;
    the ratio is nan there.
    """

    cell_map: CellMap
    ratio: Floats
    excluded: Flags

    @property
    def never(self) -> Flags:
        """(rows, columns): asked for and never seen."""
        return np.isinf(self.ratio)

    @property
    def blank(self) -> Flags:
        """(rows, columns): ground of which nothing is asked."""
        return np.isnan(self.ratio) & self.cell_map.inside & ~self.excluded

    @property
    def late(self) -> Flags:
        """(rows, columns): seen, but with a gap longer than the period."""
        return np.isfinite(self.ratio) & (self.ratio > ON_TIME)


def gap_map(plan: Plan, cells: int = 200_000) -> GapMap:
    """The worst gap over period at the centre of each of about ``cells`` cells; samples, not the check's verdict."""
    from rota.check import revisits, seeable, standing  # loads the compiled loops only when they are needed

    cell_map = cell_map_of(plan.mission, cells)
    ratio, excluded = np.full(cell_map.period_s.shape, np.nan), np.zeros_like(cell_map.inside)
    points_m = np.ascontiguousarray(cell_map.points_m(cell_map.asked))
    if len(points_m):
        ratio[cell_map.asked] = revisits.worst_gaps_s(plan, points_m) / cell_map.period_s[cell_map.asked]
    if cell_map.visit.any():
        ratio[cell_map.visit] = _between_visits(plan, cell_map.points_m(cell_map.visit))
    never = np.isinf(ratio)
    if plan.mission.unseeable == "exclude" and never.any():
        never &= cell_map.asked
        points_m = np.ascontiguousarray(cell_map.points_m(never))
        excluded[never] = ~seeable.seeable(plan.mission, standing.standing_areas(plan.mission), points_m)
        ratio[excluded] = np.nan
    return GapMap(cell_map=cell_map, ratio=ratio, excluded=excluded)


def _between_visits(plan: Plan, points_m: Floats) -> Floats:
    """The greatest worst gap over period (n,) between visits to the zones in which points (n, 2) lie."""
    from rota.check import demands, revisits, tolerances

    sights = revisits.sights_of(plan, plan.mission.area.bounds)
    ratio = np.full(len(points_m), np.nan)
    for demand in demands.demands_of(plan.mission):
        if demand.demand == "visit":
            inside = demands.visits(sights.routes.legs_m, demand.region, tolerances.slack_of(plan.mission))
            gap_s, _ = revisits.loop_gap(sights.routes, inside, sights.window_s)
            here = shapely.contains_xy(demand.region, points_m[:, 0], points_m[:, 1])
            ratio[here] = np.fmax(ratio[here], gap_s / demand.period_s)
    return ratio


def _cells_path(cell_map: CellMap, mask: Flags) -> Path:
    """The cells in ``mask`` as one path of rectangles, one for each run of cells in a row."""
    padded = np.pad(mask, ((0, 0), (1, 1))).astype(np.int8)
    rows, starts = np.nonzero(np.diff(padded, axis=1) == 1)
    _, ends = np.nonzero(np.diff(padded, axis=1) == -1)
    left, _, bottom, _ = cell_map.extent_m
    x0, x1 = left + starts * cell_map.cell_m, left + ends * cell_map.cell_m
    y0, y1 = bottom + rows * cell_map.cell_m, bottom + (rows + 1) * cell_map.cell_m
    vertices = np.stack([np.stack([x, y], -1) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0))], 1)
    codes = np.tile([Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY], len(rows))
    return Path(vertices.reshape(-1, 2), codes.astype(np.uint8))


def _broad(mask: Flags) -> Flags:
    """The mask without what is thinner than three cells, where a hatch would hide the colour it lies on."""
    for join, edge in ((np.logical_and, True), (np.logical_or, False)):
        for axis in (0, 1):
            width = [(1, 1) if k == axis else (0, 0) for k in (0, 1)]
            shifted = np.lib.stride_tricks.sliding_window_view(np.pad(mask, width, constant_values=edge), 3, axis)
            mask = join.reduce(shifted, axis=-1)
    return mask


def colour_cells(cell_map: CellMap, drawn: Floats, ax: Axes, area: Patch, least: float = 0.0) -> AxesImage:
    """Numbers (rows, columns) of cells by their colours, on a scale from the least to 1, cut by the area's patch."""
    return ax.imshow(
        drawn.ravel()[neighbours(cell_map)],
        extent=cell_map.extent_m,
        origin="lower",
        interpolation="nearest",
        aspect="equal",
        cmap=gap_colours(),
        norm=Normalize(least, 1.0),
        zorder=1.2,
        clip_path=area,
    )


def draw_gap_map(gaps: GapMap, ax: Axes, area: Patch) -> AxesImage:
    """The map on ``ax``; late places red and hatched, unseen ones pale and hatched, the rest white and dotted.

    ``area``: the area's patch, by which all is cut: cells on its border reach beyond it.
    """
    shown = neighbours(gaps.cell_map)
    drawn = np.ma.masked_invalid(np.where(gaps.late, gaps.ratio, np.minimum(gaps.ratio, 1.0)))
    drawn[gaps.never] = np.ma.masked
    image = colour_cells(gaps.cell_map, drawn, ax, area)
    # hatched, because in a grey print red is just another grey
    for mask, face, hatch, edge in (
        (gaps.blank, NOTHING_ASKED, "....", "#777777"),
        (_broad(gaps.late), "none", "\\\\\\\\", "white"),
        (gaps.never, NEVER_SEEN, "xxxx", OVER_PERIOD),
        (gaps.excluded, EXCLUDED, "", EXCLUDED),
    ):
        if mask.any():
            path = _cells_path(gaps.cell_map, mask.ravel()[shown])
            patch = PathPatch(path, facecolor=face, edgecolor=edge, hatch=hatch, linewidth=0, zorder=1.3)
            ax.add_patch(patch).set_clip_path(area)
    return image


def gap_legend(gaps: GapMap) -> list[Patch]:
    """Legend entries for what the colour bar does not say, with shares of the asked ground."""
    asked = max(int((gaps.cell_map.asked | gaps.cell_map.visit).sum()), 1)
    entries = []
    if gaps.late.any():
        worst = gaps.ratio[gaps.late].max()
        label = f"over the period: {_share(gaps.late.sum() / asked)}, worst {worst:.2f}"
        entries.append(Patch(facecolor=OVER_PERIOD, edgecolor="white", hatch="\\\\\\\\", linewidth=0, label=label))
    if gaps.never.any():
        label = f"never seen: {_share(gaps.never.sum() / asked)}"
        entries.append(Patch(facecolor=NEVER_SEEN, edgecolor=OVER_PERIOD, hatch="xxxx", linewidth=0.5, label=label))
    if gaps.excluded.any():
        label = f"cannot be seen by any robot: {_share(gaps.excluded.sum() / asked)}"
        entries.append(Patch(facecolor=EXCLUDED, label=label))
    if gaps.blank.any():
        entries.append(
            Patch(facecolor=NOTHING_ASKED, edgecolor="#777777", hatch="....", linewidth=0.5, label="nothing asked")
        )
    return entries


def _share(fraction: float) -> str:
    return f"{100 * fraction:.1f} %" if fraction >= 0.0005 else "under 0.1 %"
