"""The mission on an axes: area, obstacles, zones and what they ask."""

from __future__ import annotations

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from shapely import GeometryCollection, MultiPolygon, Polygon, box, maximum_inscribed_circle
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from rota.draw.palette import AREA_EDGE, GROUND, NO_ENTRY, NO_SIGHT, OBSTACLE, OUTSIDE, ZONE_EDGE, ZONE_TINTS
from rota.mission import Mission, Obstacle, Zone

FONT_PT = 7.5
NAME_CHARACTERS = 60
OUTLINED_CORNERS = 300
# from the middle outwards
STEPS_3, STEPS_4 = (0, -1, 1, -2, 2, -3, 3), (0, 1, -1, 2, -2, 3, -3, 4, -4)


def plain(text: str, characters: int = NAME_CHARACTERS) -> str:
    """``text`` as matplotlib shall print it: no dollar sign taken for mathematics, cut when too long, on one line."""
    text = " ".join(text.split())
    text = text if len(text) <= characters else text[: characters - 1] + "…"
    return text.replace("$", r"\$")


def seconds(duration_s: float) -> str:
    """A duration for people: seconds up to 10 minutes, then minutes, then hours."""
    if duration_s < 600:
        return f"{duration_s:.4g} s"
    return f"{duration_s / 60:.4g} min" if duration_s < 36_000 else f"{duration_s / 3600:.4g} h"


def metres(length_m: float) -> str:
    """A length for people: metres up to 10 km, then kilometres."""
    return f"{length_m:.0f} m" if length_m < 10_000 else f"{length_m / 1000:.4g} km"


def outline(shape: MultiPolygon) -> Path:
    """A shape's rings as one path; holes run the other way round, as filling needs."""
    rings = [ring for part in shape.geoms for ring in (orient(part).exterior, *orient(part).interiors)]
    return Path.make_compound_path(*(Path(np.asarray(ring.coords)[:, :2], closed=True) for ring in rings))


def asked(period_s: float | None, demand: str) -> str:
    """What a place asks, in a few words: ``8 s``, ``visit 8 s`` or ``nothing asked``."""
    if period_s is None:
        return "nothing asked"
    return f"visit {seconds(period_s)}" if demand == "visit" else seconds(period_s)


def _zone_tints(mission: Mission) -> list[str]:
    """One tint per zone, the stronger the shorter its period; ground colour where nothing is asked."""
    periods_s = sorted({zone.period_s for zone in mission.zones if zone.period_s is not None}, reverse=True)
    ladder = np.linspace(0 if len(periods_s) > 1 else 1, len(ZONE_TINTS) - 1, max(1, len(periods_s))).round()
    tint = {period_s: ZONE_TINTS[int(step)] for period_s, step in zip(periods_s, ladder, strict=False)}
    return [GROUND if zone.period_s is None else tint[zone.period_s] for zone in mission.zones]


def _obstacle_patch(obstacle: Obstacle) -> PathPatch:
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
    ax.locator_params(axis="x", nbins=int(np.clip(wide / 0.55, 1, 8)))
    ax.locator_params(axis="y", nbins=int(np.clip(high / 0.4, 1, 8)))
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


def _label_boxes(shape: Polygon, width_m: float, height_m: float) -> list[Polygon]:
    """Boxes of this size worth trying for a label: all over the shape, its widest place first, then round it."""
    widest = maximum_inscribed_circle(shape, tolerance=0.05 * np.sqrt(shape.area)).coords[0]
    left, bottom, right, top = shape.bounds
    middle_m = ((left + right) / 2, (bottom + top) / 2)
    reach_m = max((right - left) / 2 - 0.6 * width_m, 0.0), max((top - bottom) / 2 - 0.7 * height_m, 0.0)
    lattice = [(middle_m[0] + i / 3 * reach_m[0], middle_m[1] + j / 4 * reach_m[1]) for j in STEPS_4 for i in STEPS_3]
    around = [
        (middle_m[0], top + 0.8 * height_m),
        (middle_m[0], bottom - 0.8 * height_m),
        (right + 0.6 * width_m, middle_m[1]),
        (left - 0.6 * width_m, middle_m[1]),
    ]
    half_m = (width_m / 2, height_m / 2)
    spots = [(float(widest[0]), float(widest[1])), *lattice, *around]
    return [box(x_m - half_m[0], y_m - half_m[1], x_m + half_m[0], y_m + half_m[1]) for x_m, y_m in spots]


def _label_cost(spot: Polygon, shape: Polygon, frame_box: Polygon, taken: list[Polygon], avoid: BaseGeometry) -> float:
    """How bad a label stands there: beyond the frame or on another label, then on lines, then off its zone."""
    left, _, right, _ = spot.bounds
    covered = sum(spot.intersection(other).area for other in taken) + spot.difference(frame_box).area
    off = spot.difference(shape).area
    return float((20 * covered + 0.7 * off) / spot.area + spot.intersection(avoid).length / (right - left))


def draw_zone_labels(mission: Mission, ax: Axes, avoid: BaseGeometry | None = None) -> None:
    """Each zone's name and period, in or beside it, clear of each other and of the lines ``avoid`` where it can be."""
    scale = points_per_metre(ax)
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    lines = GeometryCollection() if avoid is None else avoid
    taken: list[Polygon] = []
    for zone in mission.zones:
        text = f"{plain(zone.name, 28)}  {asked(zone.period_s, zone.demand)}"
        width_m, height_m = (0.56 * len(text) * FONT_PT + 5) / scale, (FONT_PT + 6) / scale
        shape = max(_parts(zone, mission), key=lambda part: part.area)
        around = box(*shape.bounds).buffer(2 * max(width_m, height_m))
        boxes, near = _label_boxes(shape, width_m, height_m), lines.intersection(around)
        costs = [_label_cost(spot, shape, box(left, bottom, right, top), taken, near) for spot in boxes]
        taken.append(boxes[int(np.argmin(costs))])
        label = ax.text(taken[-1].centroid.x, taken[-1].centroid.y, text, fontsize=FONT_PT, zorder=6)
        label.set(ha="center", va="center", color="#3A2A08")
        label.set_bbox({"boxstyle": "round,pad=0.22", "fc": "white", "ec": ZONE_EDGE, "lw": 0.5, "alpha": 0.9})


def _parts(zone: Zone, mission: Mission) -> list[Polygon]:
    inside = zone.shape.intersection(mission.area)
    return [part for part in getattr(inside, "geoms", [inside]) if isinstance(part, Polygon) and part.area > 0]


def draw_mission(mission: Mission, ax: Axes, *, fill: bool = True) -> None:
    """Area, zones and obstacles on ``ax`` in metres; with ``fill`` False zones are outlines only, for a map beneath.

    Zones are drawn with the longest period lowest. What lies outside the area is grey.
    """
    frame(mission, ax)
    ground = PathPatch(outline(mission.area), facecolor=GROUND, edgecolor=AREA_EDGE, linewidth=1.1)
    ground.set_zorder(1)
    ax.add_patch(ground)
    tints = _zone_tints(mission)
    order = sorted(range(len(mission.zones)), key=lambda k: -(mission.zones[k].period_s or np.inf))
    for k in order:
        zone = mission.zones[k]
        patch = PathPatch(outline(zone.shape), facecolor=tints[k] if fill else "none", edgecolor=ZONE_EDGE, zorder=2)
        patch.set_linewidth(0.9)
        patch.set_linestyle("dotted" if zone.period_s is None else "dashed" if zone.demand == "visit" else "solid")
        # a zone sticking out of the area asks nothing out there
        ax.add_patch(patch).set_clip_path(ground)
        if not fill:
            patch.set_path_effects([withStroke(linewidth=2.0, foreground="white")])
    for obstacle in mission.obstacles:
        ax.add_patch(_obstacle_patch(obstacle))


def mission_legend(mission: Mission) -> list[Patch]:
    """Legend entries for the kinds of obstacles that are there."""
    kinds = {obstacle.blocks for obstacle in mission.obstacles}
    entries = []
    if "both" in kinds:
        entries.append(Patch(facecolor=OBSTACLE, edgecolor="#222222", label="obstacle"))
    if "motion" in kinds:
        entries.append(Patch(facecolor="none", edgecolor=NO_ENTRY, hatch="////", label="no entry, seen through"))
    if "sight" in kinds:
        entries.append(Patch(facecolor="#DDEBDD", edgecolor=NO_SIGHT, hatch="xxxx", label="cuts sight, may be entered"))
    return entries
