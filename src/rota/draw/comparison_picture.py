"""Several plans of one mission as one picture: their routes side by side, each under what it comes to."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rota.draw.mission_picture import draw_mission, mission_legend, plain
from rota.draw.palette import OVER_PERIOD
from rota.draw.picture_file import new_figure, write_picture
from rota.draw.plan_picture import draw_routes
from rota.draw.zone_labels import draw_zone_labels
from rota.model.mission import Mission
from rota.model.plan import Plan

# inches
MARGIN, GAP, HEADER, PANEL_TITLE, FOOTER = 0.14, 0.28, 0.3, 0.42, 0.3
WIDEST, MAP_AREA, NARROWEST_MAP = 13.5, 12.0, 3.0
EMPTY = 0.3  # what a place without a map weighs, against the logarithm of how much wider or higher than asked
NO_PLAN = "no plan"


@dataclass(frozen=True, kw_only=True)
class Panel:
    """One plan of the comparison: what made it, what it comes to in a few words, and whether it meets its demand."""

    title: str
    caption: str
    plan: Plan | None
    met: bool


@dataclass(frozen=True, kw_only=True)
class _Grid:
    """Columns and rows of maps, and the size of each in inches."""

    columns: int
    rows: int
    width: float
    height: float


def _grid(mission: Mission, count: int) -> _Grid:
    """As many columns as make the picture about half again as wide as high, with few gaps; all maps of one size."""
    left, bottom, right, top = mission.area.bounds
    pad_m = 0.05 * math.sqrt((right - left) * (top - bottom))
    slope = (top - bottom + pad_m) / (right - left + pad_m)
    width = float(np.clip(math.sqrt(MAP_AREA / slope), NARROWEST_MAP, WIDEST - 2 * MARGIN))
    most = max(1, int((WIDEST - 2 * MARGIN + GAP) / (width + GAP)))

    def unlike(columns: int) -> float:
        rows = -(-count // columns)
        wide, high = columns * (width + GAP), rows * (width * slope + PANEL_TITLE + GAP) + HEADER
        return abs(math.log(wide / high / 1.5)) + EMPTY * (rows * columns - count)

    columns = min(range(1, min(most, count) + 1), key=unlike)
    return _Grid(columns=columns, rows=-(-count // columns), width=width, height=width * slope)


def comparison_figure(mission: Mission, panels: Sequence[Panel]) -> Figure:
    """The picture as a matplotlib figure, panels row by row in the order given; at least one is needed."""
    if not panels:
        raise ValueError("panels: none is given; at least one is needed")
    grid = _grid(mission, len(panels))
    entries = mission_legend(mission)
    footer = FOOTER if entries else 0.0
    wide = grid.columns * (grid.width + GAP) - GAP + 2 * MARGIN
    high = HEADER + grid.rows * (PANEL_TITLE + grid.height + GAP) - GAP + footer + 2 * MARGIN
    fig = new_figure(wide, high)
    fig.text(MARGIN / wide, 1 - MARGIN / high, plain(mission.name), fontsize=12, fontweight="bold", va="top")
    for k, panel in enumerate(panels):
        row, column = divmod(k, grid.columns)
        x = MARGIN + column * (grid.width + GAP)
        y = high - MARGIN - HEADER - row * (PANEL_TITLE + grid.height + GAP) - PANEL_TITLE - grid.height
        ax = fig.add_axes((x / wide, y / high, grid.width / wide, grid.height / high))
        _draw_panel(mission, panel, ax)
        top = (y + grid.height) / high
        fig.text(x / wide, top + 0.235 / high, plain(panel.title), fontsize=10, fontweight="bold", va="bottom")
        colour = "#333333" if panel.met else OVER_PERIOD
        fig.text(x / wide, top + 0.07 / high, plain(panel.caption, 90), fontsize=8, va="bottom", color=colour)
    if entries:
        at = (MARGIN / wide, (MARGIN + 0.18) / high)
        fig.legend(
            handles=list(entries), loc="upper left", bbox_to_anchor=at, ncols=len(entries), fontsize=7.5,
            frameon=False, borderpad=0, borderaxespad=0,
        )  # fmt: skip
    return fig


def _draw_panel(mission: Mission, panel: Panel, ax: Axes) -> None:
    if panel.plan is not None:
        draw_routes(panel.plan, ax)
    else:
        draw_mission(mission, ax)
        draw_zone_labels(mission, ax)
        ax.text(0.5, 0.5, NO_PLAN, transform=ax.transAxes, ha="center", va="center", fontsize=14, color=OVER_PERIOD)
    ax.set(xlabel="", ylabel="", xticks=[], yticks=[])


def draw_comparison(mission: Mission, panels: Sequence[Panel], path: str | Path) -> None:
    """Draw plans of one mission side by side to ``path`` as PNG, SVG or PDF, by its suffix.

    The file appears whole or not at all, and the same plans give the same bytes. Raises RotaError for another suffix
    or a folder that cannot be written to.
    """
    write_picture(path, lambda: comparison_figure(mission, panels))
