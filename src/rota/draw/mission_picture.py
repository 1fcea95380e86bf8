"""The mission on an axes: area, obstacles, zones and what they ask."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from shapely import LineString, MultiPolygon
from shapely.geometry.polygon import orient

from rota.cells.importance_cells import ImportanceCells, importance_cells
from rota.draw.palette import AREA_EDGE, GROUND, IMPORTANT, NO_ENTRY, NO_SIGHT, OBSTACLE, OUTSIDE, ZONE_EDGE, ZONE_TINTS
from rota.model.arrays import Floats
from rota.model.mission import Mission, Obstacle

CELLS_ACROSS, DARKER = 400.0, 0.6
SHADES = LinearSegmentedColormap.from_list("importance", [GROUND, IMPORTANT])
FONT_PT = 7.5
NAME_CHARACTERS = 60
OUTLINED_CORNERS = 300
FEW_ZONES = 12  # that are labelled with what they ask, even where all ask the same


def plain(text: str, characters: int = NAME_CHARACTERS) -> str:
    """``text`` as matplotlib shall print it: no dollar sign taken for mathematics, cut when too long, on one line."""
    text = " ".join(text.split())
    text = text if len(text) <= characters else text[: characters - 1] + "…"
    return text.replace("$", r"\$")


def period_text(period_s: float) -> str:
    """A period as it was asked, not rounded: from 10 minutes on in whole minutes or hours where it is that."""
    for unit_s, unit in ((3600, "h"), (60, "min")):
        if period_s >= 600 and period_s % unit_s == 0:
            return f"{period_s / unit_s:.0f} {unit}"
    return f"{period_s:.10g} s"


def outline(shape: MultiPolygon) -> Path:
    """A shape's rings as one path; holes run the other way round, as filling needs."""
    rings = [ring for part in shape.geoms for ring in (orient(part).exterior, *orient(part).interiors)]
    return Path.make_compound_path(*(Path(np.asarray(ring.coords)[:, :2], closed=True) for ring in rings))


def demand_in_words(period_s: float | None, demand: str) -> str:
    """What a place asks, in a few words: ``8 s``, ``visit 8 s`` or ``nothing asked``."""
    if period_s is None:
        return "nothing asked"
    return f"visit {period_text(period_s)}" if demand == "visit" else period_text(period_s)


def zone_tints(mission: Mission) -> list[str]:
    """One tint per zone, the stronger the shorter its period; ground colour where nothing is asked."""
    periods_s = sorted({zone.period_s for zone in mission.zones if zone.period_s is not None}, reverse=True)
    ladder = np.linspace(0 if len(periods_s) > 1 else 1, len(ZONE_TINTS) - 1, max(1, len(periods_s))).round()
    tint = {period_s: ZONE_TINTS[int(step)] for period_s, step in zip(periods_s, ladder, strict=False)}
    return [GROUND if zone.period_s is None else tint[zone.period_s] for zone in mission.zones]


def _obstacle_patch(obstacle: Obstacle) -> PathPatch:
    """An obstacle in the colour and hatch of what it blocks."""
    path = outline(obstacle.shape)
    if obstacle.blocks == "motion":
        return PathPatch(path, facecolor="none", edgecolor=NO_ENTRY, hatch="///", linewidth=1.0, zorder=3)
    if obstacle.blocks == "sight":
        return PathPatch(path, facecolor="#DDEBDD", edgecolor=NO_SIGHT, hatch="xxx", linewidth=1.0, zorder=3)
    # on a scanned map the outlines of a thousand specks would hide the specks
    outlined = shapely.get_num_coordinates(obstacle.shape) <= OUTLINED_CORNERS
    edge, width = ("white", 0.5) if outlined else (OBSTACLE, 0.3)
    return PathPatch(path, facecolor=OBSTACLE, edgecolor=edge, linewidth=width, zorder=3)


def frame(mission: Mission, ax: Axes) -> None:
    """Limits, equal aspect, metres on both axes."""
    left, bottom, right, top = mission.area.bounds
    pad_m = 0.025 * float(np.sqrt((right - left) * (top - bottom)))
    ax.set_xlim(left - pad_m, right + pad_m)
    ax.set_ylim(bottom - pad_m, top + pad_m)
    ax.set_aspect("equal", adjustable="box")
    ax.set_facecolor(OUTSIDE)
    ax.set_xlabel("x (m)", fontsize=FONT_PT, labelpad=1.5)
    ax.set_ylabel("y (m)", fontsize=FONT_PT, labelpad=1.5)
    ax.tick_params(labelsize=FONT_PT, length=2.5, pad=2)
    ax.apply_aspect()
    window = ax.get_window_extent()
    wide, high = window.width / ax.figure.dpi, window.height / ax.figure.dpi
    ax.locator_params(axis="x", nbins=int(np.clip(wide / 0.55, 1, 8)), steps=[1, 2, 5, 10])
    ax.locator_params(axis="y", nbins=int(np.clip(high / 0.4, 1, 8)), steps=[1, 2, 5, 10])
    ax.ticklabel_format(style="plain", useOffset=False)
    for spine in ax.spines.values():
        spine.set_linewidth(0.5)
        spine.set_color("#888888")


def points_per_metre(ax: Axes) -> float:
    """Printed points per metre on an axes of equal aspect, whose limits are set."""
    ax.apply_aspect()
    window = ax.get_window_extent()
    left, right = ax.get_xlim()
    return float(window.width / (right - left) * 72 / ax.figure.dpi)


def draw_mission(mission: Mission, ax: Axes, *, fill: bool = True) -> PathPatch:
    """Area, zones and obstacles on ``ax`` in metres; returns the patch of the area, to clip by.

    With ``fill`` False zones are outlines only, and a map may lie beneath all outlines, from zorder 1.1 to 1.9. Zones
    are drawn with the longest period lowest. What lies outside the area is grey. Where ground differs in importance, it
    is shaded by that.
    """
    frame(mission, ax)
    ground = PathPatch(outline(mission.area), facecolor=GROUND, edgecolor="none", zorder=1)
    ax.add_patch(ground)
    # above zones, which end at it, and below obstacles, which may stand on it
    ax.add_patch(PathPatch(outline(mission.area), facecolor="none", edgecolor=AREA_EDGE, linewidth=1.1, zorder=2.5))
    shaded = fill and draw_importance(mission, ax, ground)
    tints = zone_tints(mission)
    order = sorted(range(len(mission.zones)), key=lambda k: -(mission.zones[k].period_s or np.inf))
    for k in order:
        zone = mission.zones[k]
        tint = tints[k] if fill and not (shaded and zone.period_s is None) else "none"
        patch = PathPatch(outline(zone.shape), facecolor=tint, edgecolor=ZONE_EDGE, zorder=2)
        patch.set_linewidth(0.9)
        patch.set_linestyle("dotted" if zone.period_s is None else "dashed" if zone.demand == "visit" else "solid")
        # a zone sticking out of the area asks nothing out there
        ax.add_patch(patch).set_clip_path(ground)
        if not fill:
            patch.set_path_effects([withStroke(linewidth=2.0, foreground="white")])
    for obstacle in mission.obstacles:
        ax.add_patch(_obstacle_patch(obstacle))
    _draw_one_ways(mission, ax)
    return ground


def _draw_one_ways(mission: Mission, ax: Axes) -> None:
    """A chevron in the middle of each lane that runs one way."""
    for lane in mission.lanes:
        if lane.one_way:
            line = LineString(lane.line_m)
            at = line.interpolate(0.5, normalized=True)
            on = line.interpolate(0.5 + 1e-3, normalized=True)
            turn_deg = float(np.degrees(np.arctan2(on.y - at.y, on.x - at.x)))
            ax.plot(at.x, at.y, marker=(3, 0, turn_deg - 90), markersize=5, color=AREA_EDGE, zorder=2.6)


def asked_everywhere(mission: Mission) -> str | None:
    """What all zones ask, where they are too many to be labelled with it one by one; None: they differ, or are few."""
    told = {demand_in_words(zone.period_s, zone.demand) for zone in mission.zones}
    return told.pop() if len(told) == 1 and len(mission.zones) > FEW_ZONES else None


def mission_legend(mission: Mission) -> list[Patch]:
    """Legend entries for the importance of ground, where it differs, and for the kinds of obstacles that are there."""
    kinds = {obstacle.blocks for obstacle in mission.obstacles}
    entries = importance_legend(mission)
    if "both" in kinds:
        entries.append(Patch(facecolor=OBSTACLE, edgecolor="#222222", label="obstacle"))
    if "motion" in kinds:
        entries.append(Patch(facecolor="none", edgecolor=NO_ENTRY, hatch="////", label="no entry, seen through"))
    if "sight" in kinds:
        entries.append(Patch(facecolor="#DDEBDD", edgecolor=NO_SIGHT, hatch="xxxx", label="cuts sight, may be entered"))
    return entries


@lru_cache(maxsize=4)
def shaded_cells(mission: Mission) -> ImportanceCells | None:
    """The importance of the mission's area, fine enough for a picture; None where all ground is worth as much."""
    x0, y0, x1, y1 = mission.area.bounds
    return importance_cells(mission, mission.area, max(x1 - x0, y1 - y0) / CELLS_ACROSS)


def shade(values: Floats, most: float) -> Floats:
    """How dark importance is drawn, 0..1; middling importance is darker than its share, so that it shows."""
    return np.asarray((values / most) ** DARKER)


def draw_importance(mission: Mission, ax: Axes, ground: PathPatch) -> bool:
    """Shade the ground by its importance, the darker the more; False where all is worth as much."""
    cells = shaded_cells(mission)
    if cells is None:
        return False
    rows, columns = cells.values.shape
    (left, bottom), side_m = (low - cells.side_m / 2 for low in cells.low_m), cells.side_m
    image = ax.imshow(
        shade(cells.values, float(cells.values.max())), cmap=SHADES, vmin=0, vmax=1, origin="lower", zorder=1.05,
        extent=(left, left + columns * side_m, bottom, bottom + rows * side_m), interpolation="nearest",
    )  # fmt: skip
    image.set_clip_path(ground)
    return True


def importance_legend(mission: Mission) -> list[Patch]:
    """Legend entries for the most and the least important ground; none where all is worth as much."""
    cells = shaded_cells(mission)
    if cells is None:
        return []
    told = cells.values[cells.ground_m2 > 0]
    most = float(told.max())
    return [
        Patch(
            facecolor=SHADES(float(shade(np.array(value), most))), edgecolor="#888888", label=f"importance {value:.3g}"
        )
        for value in np.unique([most, float(told.min())])[::-1].tolist()
    ]
