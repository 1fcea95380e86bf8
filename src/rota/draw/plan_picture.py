"""A plan as one picture: the routes on the mission, and the worst revisit gap of every place beside them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from rota.draw.gap_map import GapMap, draw_gap_map, gap_legend, gap_map
from rota.draw.house_style import house_style
from rota.draw.legends import LEGEND_PT, axes_at, legend_height, place_legend
from rota.draw.mission_picture import draw_mission, mission_legend, period_text, plain
from rota.draw.route_lines import draw_route_lines, route_legend
from rota.draw.routes import routes_of
from rota.draw.zone_labels import draw_zone_labels
from rota.files.atomic_write import replaced_file, require_suffix
from rota.mission import Mission
from rota.plan import Plan

FORMATS = (".png", ".svg", ".pdf")
DPI = 160

UNDATED: dict[str, dict[str, None]] = {".svg": {"Date": None}, ".pdf": {"CreationDate": None, "ModDate": None}}

# inches
MARGIN, GAP, HEADER, PANEL_TITLE, AXIS, BAR = 0.12, 0.35, 0.55, 0.24, 0.42, 0.13
Y_AXIS, BAR_TEXT = 0.55, 0.42


@dataclass(frozen=True, kw_only=True)
class _Layout:
    """Sizes in inches: the figure, each of the two maps, the columns they stand in; whether one is below the other."""

    map_width: float
    map_height: float
    column: float
    stacked: bool


def _layout(mission: Mission) -> _Layout:
    """Maps side by side; one below the other where the area is much wider than high. At most 7.5 in high."""
    left, bottom, right, top = mission.area.bounds
    pad_m = 0.05 * np.sqrt((right - left) * (top - bottom))
    slope = (top - bottom + pad_m) / (right - left + pad_m)
    if slope < 0.42:
        width = float(np.clip(1.3 / slope, 9.0, 14.0))
        return _Layout(map_width=width, map_height=width * slope, column=width, stacked=True)
    height = min(4.9 * slope, 7.5)
    return _Layout(map_width=height / slope, map_height=height, column=max(height / slope, 3.4), stacked=False)


def _header(plan: Plan) -> str:
    """Robots, bound and the period outside zones."""
    count = len(plan.trajectories)
    words = [f"{count} robot{'' if count == 1 else 's'}"]
    if plan.lower_bound_robots is not None:
        words.append(f"lower bound {plan.lower_bound_robots}")
    mission = plan.mission
    where = "outside zones" if mission.zones else "whole area"
    words.append(f"{where} {'nothing asked' if mission.period_s is None else 'every ' + period_text(mission.period_s)}")
    return " · ".join(words)


def _colour_bar(fig: Figure, image: AxesImage, x: float, y: float, width: float) -> None:
    cax = axes_at(fig, x, y, width, BAR)
    bar = fig.colorbar(image, cax=cax, orientation="horizontal", extend="max", extendfrac=0.06)
    bar.set_ticks([0, 0.25, 0.5, 0.75, 1.0], labels=["0", "0.25", "0.5", "0.75", "1.0 = limit"])
    bar.ax.tick_params(labelsize=LEGEND_PT, length=2.5, pad=2)
    bar.set_label("worst gap / period", fontsize=LEGEND_PT, labelpad=1.5)
    bar.outline.set_linewidth(0.5)


def draw_routes(plan: Plan, ax: Axes) -> None:
    """The mission and the plan's loops on ``ax`` in metres, every zone labelled with its period."""
    draw_mission(plan.mission, ax)
    draw_route_lines(plan, ax)
    draw_zone_labels(plan.mission, ax, routes_of(plan))


def draw_gaps(plan: Plan, ax: Axes, gaps: GapMap | None = None) -> AxesImage:
    """The worst revisit gap over the period as a map on ``ax``; returns the image, for a colour bar.

    ``gaps``: the numbers, when they are at hand; otherwise they are computed.
    """
    area = draw_mission(plan.mission, ax, fill=False)
    return draw_gap_map(gap_map(plan) if gaps is None else gaps, ax, area)


def plan_figure(plan: Plan, cells: int = 200_000) -> Figure:
    """The picture as a matplotlib figure: routes on the left (or top), worst gaps over about ``cells`` cells beside."""
    layout = _layout(plan.mission)
    gaps = gap_map(plan, cells)
    routes = [*route_legend(plan), *mission_legend(plan.mission)]
    notes = gap_legend(gaps)
    below_routes = AXIS + legend_height(routes, layout.column)
    below_gaps = AXIS + BAR + BAR_TEXT + legend_height(notes, layout.column)
    block = PANEL_TITLE + layout.map_height
    if layout.stacked:
        height = HEADER + 2 * block + below_routes + below_gaps + 2 * MARGIN
        width = Y_AXIS + layout.column + 2 * MARGIN
    else:
        height = HEADER + block + max(below_routes, below_gaps) + 2 * MARGIN
        width = 2 * (Y_AXIS + layout.column) + GAP + 2 * MARGIN
    fig = Figure(figsize=(width, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(fig)
    x = MARGIN + Y_AXIS
    top = height - MARGIN
    fig.text(x / width, top / height, plain(plan.mission.name), fontsize=12, fontweight="bold", va="top")
    fig.text(x / width, (top - 0.27) / height, _header(plan), fontsize=9, va="top", color="#333333")

    y = top - HEADER - block
    left_ax = axes_at(fig, x, y, layout.map_width, layout.map_height)
    draw_routes(plan, left_ax)
    left_ax.set_title("Routes, numbered where each robot's loop starts", fontsize=9, loc="left", pad=4)
    place_legend(fig, routes, x, y - AXIS, layout.column)

    if layout.stacked:
        y -= below_routes + block
    else:
        x += layout.column + GAP + Y_AXIS
    right_ax = axes_at(fig, x, y, layout.map_width, layout.map_height)
    image = draw_gaps(plan, right_ax, gaps)
    right_ax.set_title("Longest time unseen, in periods of the place", fontsize=9, loc="left", pad=4)
    _colour_bar(fig, image, x, y - AXIS - BAR, min(layout.column, 4.9))
    place_legend(fig, notes, x, y - AXIS - BAR - BAR_TEXT, layout.column)
    return fig


def draw_plan(plan: Plan, path: str | Path) -> None:
    """Draw a plan to ``path`` as PNG, SVG or PDF, by its suffix; the file appears whole or not at all.

    The same plan gives the same bytes. The map is sampled at cell centres: it illustrates, the check decides. Raises
    RotaError for another suffix or a folder that cannot be written to.
    """
    path = Path(path)
    suffix = require_suffix(path, FORMATS, "a picture")
    with house_style():
        fig = plan_figure(plan)
        with replaced_file(path) as partial:
            fig.savefig(partial, format=suffix[1:], dpi=DPI, metadata=UNDATED.get(suffix))
