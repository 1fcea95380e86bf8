"""A plan's picture: two maps of the same ground side by side or one below the other, a legend under each; a chart."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rota.draw.legends import axes_at, legend_height, place_legend
from rota.draw.mission_picture import plain
from rota.draw.picture_file import new_figure
from rota.model.mission import Mission

# inches
MARGIN, GAP, HEADER, PANEL_TITLE, AXIS = 0.12, 0.35, 0.55, 0.24, 0.42
Y_AXIS, WIDEST_SCALE, CHART_GAP = 0.55, 4.9, 0.2


@dataclass(frozen=True, kw_only=True)
class Half:
    """One of the maps. draw: draws it on axes. legend: what stands below, under a scale of ``scale_in`` inches.

    scale: draws the scale on the figure, given the place of its lower end and its width in inches; None: none.
    """

    title: str
    draw: Callable[[Axes], None]
    legend: Sequence[Artist] = field(default=())
    scale_in: float = 0.0
    scale: Callable[[Figure, float, float, float], None] | None = None


@dataclass(frozen=True, kw_only=True)
class Chart:
    """What stands below the maps, as wide as both: so many inches high, with room for its labels on the left."""

    title: str
    height_in: float
    labels_in: float
    draw: Callable[[Axes], None]
    legend: Sequence[Artist] = field(default=())


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


def _chart_height(chart: Chart, width: float) -> float:
    """Inches that a chart takes with its title, axis and legend, in a figure so wide."""
    return PANEL_TITLE + chart.height_in + AXIS + legend_height(chart.legend, _chart_width(chart, width)) + CHART_GAP


def _chart_width(chart: Chart, width: float) -> float:
    return width - 2 * MARGIN - chart.labels_in


def _place_chart(fig: Figure, chart: Chart) -> None:
    """Draw the chart at the lower end of a figure that has room for it."""
    width = _chart_width(chart, fig.get_figwidth())
    x, y = MARGIN + chart.labels_in, MARGIN + legend_height(chart.legend, width) + AXIS
    ax = axes_at(fig, x, y, width, chart.height_in)
    chart.draw(ax)
    ax.set_title(chart.title, fontsize=9, loc="left", pad=4)
    place_legend(fig, chart.legend, x, y - AXIS, width)


def two_maps(mission: Mission, header: str, left: Half, right: Half, chart: Chart | None = None) -> Figure:
    """The picture as a matplotlib figure under the mission's name and a header; the right map below a wide left one.

    chart: what stands below both.
    """
    layout = _layout(mission)
    below = [AXIS + half.scale_in + legend_height(half.legend, layout.column) for half in (left, right)]
    block = PANEL_TITLE + layout.map_height
    if layout.stacked:
        height = HEADER + 2 * block + sum(below) + 2 * MARGIN
        width = Y_AXIS + layout.column + 2 * MARGIN
    else:
        height = HEADER + block + max(below) + 2 * MARGIN
        width = 2 * (Y_AXIS + layout.column) + GAP + 2 * MARGIN
    height += _chart_height(chart, width) if chart is not None else 0.0
    fig = new_figure(width, height)
    x, top = MARGIN + Y_AXIS, height - MARGIN
    fig.text(x / width, top / height, plain(mission.name), fontsize=12, fontweight="bold", va="top")
    fig.text(x / width, (top - 0.27) / height, header, fontsize=9, va="top", color="#333333")
    y = top - HEADER - block
    for half in (left, right):
        ax = axes_at(fig, x, y, layout.map_width, layout.map_height)
        half.draw(ax)
        ax.set_title(half.title, fontsize=9, loc="left", pad=4)
        if half.scale is not None:
            half.scale(fig, x, y - AXIS, min(layout.column, WIDEST_SCALE))
        place_legend(fig, half.legend, x, y - AXIS - half.scale_in, layout.column)
        if layout.stacked:
            y -= below[0] + block
        else:
            x += layout.column + GAP + Y_AXIS
    if chart is not None:
        _place_chart(fig, chart)
    return fig
